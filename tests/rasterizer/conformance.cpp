// Holds the tile rasterizer to the oracle, suite by suite, seed by seed: visibility, depth, bill and the order of in-order
// fragments must be the same bytes. A run that could not have failed fails: no suite matched, nothing drawn, constant image.
#include <fmt/format.h>
#include <fnmatch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "rasterizer/vector_target.hpp"
#include "tests/rasterizer/suites.hpp"

using namespace aluminate::raster;
using namespace aluminate::raster::test;

namespace {

bool constant(const std::vector<std::uint32_t>& plane) {
  return std::all_of(plane.begin(), plane.end(), [&](std::uint32_t v) { return v == plane.front(); });
}

/// Empty when the case holds.
std::string run_case(const SuiteCase& test, std::uint32_t seed, Picture& expected) {
  expected = draw_expected(test.geometry, test.bill);
  CandidateOptions options;
  options.bill = test.bill;
  options.tile_order_seed = seed + 1;
  if (seed % 3 == 1) options.skips = SkipSet::none();
  const Picture candidate = draw_candidate(test.geometry, options);
  if (std::string text = difference(candidate, expected); !text.empty()) return text;
  const ReferenceImage& image = expected.planes;
  const auto samples = static_cast<std::size_t>(image.samples);
  for (std::size_t element = 0; element < image.hits.size(); ++element) {
    const std::size_t pixel = element / samples;
    const std::uint32_t hits = image.hits[element];
    if ((test.every_sample_once && hits != 1) || (test.every_sample_covered && hits == 0))
      return fmt::format("pixel ({}, {}) sample {} is covered {} times", pixel % static_cast<std::size_t>(image.width), pixel / static_cast<std::size_t>(image.width),
                         element % samples, hits);
  }
  return {};
}

int run_suite(const Suite& suite, int samples, std::uint32_t low, std::uint32_t high) {
  std::uint64_t fragments = 0;
  bool varied = false;
  for (std::uint32_t seed = low; seed < high; ++seed) {
    SuiteCase test = suite.make(seed);
    use_samples(test, samples, seed);
    Picture expected;
    if (const std::string text = run_case(test, seed, expected); !text.empty()) {
      fmt::print("FAIL {} --samples {} --range {} {}: {}\n", suite.name, samples, seed, seed + 1, text);
      return 1;
    }
    std::uint64_t drawn = 0;
    for (const std::uint32_t hits : expected.planes.hits) drawn += hits;
    if (drawn == 0 && !test.may_be_empty) {
      fmt::print("FAIL {} --samples {} --range {} {}: nothing was drawn, the case proves nothing\n", suite.name, samples, seed, seed + 1);
      return 1;
    }
    fragments += drawn;
    varied = varied || !constant(expected.planes.depth) || !constant(expected.planes.visibility);
  }
  if (fragments == 0 || !varied) {
    fmt::print("FAIL {}: {}, the suite proves nothing\n", suite.name, fragments == 0 ? "nothing was drawn" : "every image is constant");
    return 1;
  }
  fmt::print("ok   {:<22} {}x seeds {}..{}, {} fragments\n", suite.name, samples, low, high, fragments);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"tile rasterizer against the reference, byte by byte"};
  std::vector<std::string> names, globs;
  std::vector<std::uint32_t> range{0, 20};
  std::string unit;
  int samples = 1;
  bool list = false, list_units = false;
  app.add_option("--suite", names, "run this suite");
  app.add_option("--suite-glob", globs, "run the suites whose names match");
  app.add_option("--range", range, "seeds: first, one past the last")->expected(2);
  app.add_option("--samples", samples, "samples a pixel, 1 or 4")->check(CLI::IsMember({1, 4}));
  app.add_option("--vector-unit", unit, "use this vector unit (default: the best one)");
  app.add_flag("--list", list, "list the suites");
  app.add_flag("--list-vector-units", list_units, "list the vector units this machine can use, best first");
  CLI11_PARSE(app, argc, argv);
  if (list) {
    for (const Suite& suite : suites()) fmt::print("{:<22} {}\n", suite.name, suite.what);
    return 0;
  }
  if (list_units) {
    for (const std::string& name : vector_targets()) fmt::print("{}\n", name);
    return 0;
  }
  use_vector_target(unit);
  if (range[0] >= range[1]) {
    fmt::print("the range {} {} holds no seed\n", range[0], range[1]);
    return 2;
  }
  int failures = 0, matched = 0;
  for (const Suite& suite : suites()) {
    const std::string name(suite.name);
    const bool wanted = (names.empty() && globs.empty()) || std::find(names.begin(), names.end(), name) != names.end() ||
                        std::any_of(globs.begin(), globs.end(), [&](const std::string& glob) { return fnmatch(glob.c_str(), name.c_str(), 0) == 0; });
    if (!wanted) continue;
    ++matched;
    failures += run_suite(suite, samples, range[0], range[1]);
  }
  if (matched == 0) {
    fmt::print("no suite matches; --list names them\n");
    return 2;
  }
  return failures == 0 ? 0 : 1;
}
