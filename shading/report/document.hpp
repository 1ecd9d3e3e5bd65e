// The JSON documents and text tables of `render` and `compare`. Every document starts with schema, tool,
// command and inputs; keys carry units; everything but "timing" is the same on every machine and thread
// count.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "platform/console/frame_budget.hpp"
#include "platform/console/gpu_model.hpp"
#include "shading/passes/frame.hpp"
#include "shading/passes/light_cost.hpp"
#include "shading/report/statistics.hpp"

namespace aluminate::report {

/// What a document says about where it came from.
struct Origin {
  std::string scene_file, scene_hash;
  std::vector<std::pair<std::string, std::string>> file_hashes;  // every other file given: path, XXH3-128 in hex
  passes::FrameOptions options;  // as resolved
};

/// A rendered frame with its price.
struct Billed {
  std::string name;  // "A schlick-smith"
  Origin origin;
  passes::Frame frame;
  console::GpuModel gpu;
  console::FrameBudget budget;
  passes::LightCosts lights;  // marginal cost of one more light, by convention
};

/// XXH3-128 of width, height and the stored RGBA8 bytes, hex.
std::string image_hash(const passes::Frame& frame);
std::string image_hash(int width, int height, std::span<const std::uint8_t> rgba8);

/// The command that makes this picture again, without what never changes it (threads, outputs).
std::string canonical_command(const std::string& verb, const Origin& origin);

std::string render_json(const Billed& billed);
std::string render_text(const Billed& billed);

std::string compare_json(const Billed& a, const Billed& b, const ImageDifference& difference);
std::string compare_text(const Billed& a, const Billed& b, const ImageDifference& difference);

/// True when B costs more ALU words, fetch cycles or console time than A.
bool hurts(const Billed& a, const Billed& b);

}  // namespace aluminate::report
