// The conformance suites: named families of frames, each frame made from a seed. A suite states what must hold besides
// equality with the oracle.
#pragma once

#include <span>
#include <string_view>

#include "tests/rasterizer/candidate.hpp"

namespace aluminate::raster::test {

struct SuiteCase {
  Geometry geometry;
  BillRule bill{};
  bool every_sample_once = false;    // a closed partition of the viewport: each sample is covered by exactly one triangle
  bool every_sample_covered = false; // no background anywhere
  bool may_be_empty = false;         // nothing drawn is a legal outcome
};

struct Suite {
  std::string_view name, what;
  SuiteCase (*make)(std::uint32_t seed);
};

std::span<const Suite> suites();

/// The same case with this many samples a pixel.
void use_samples(SuiteCase& test, int samples, std::uint32_t seed);

}  // namespace aluminate::raster::test
