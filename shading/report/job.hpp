// From a scene and options to a billed frame, and from that to files: what `render` and `compare` do, without
// arguments or printing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "shading/report/document.hpp"

namespace aluminate::scenes {
struct Scene;
}

namespace aluminate::report {

/// Renders `frames` times (the pictures are the same; the times are not) and prices the last one.
/// budget_ms <= 0: the platform's own frame.
Billed render_and_bill(const scenes::Scene& scene, const passes::FrameOptions& options, double budget_ms,
                       int frames);

/// One rendering with its price and without the marginal costs of a light, which take three more
/// compilations.
Billed bill(const scenes::Scene& scene, const passes::FrameOptions& options, double budget_ms);
/// The price of a frame that is there.
Billed bill(const scenes::Scene& scene, const passes::FrameOptions& options, passes::Frame frame,
            double budget_ms);

/// .png: stored display values. .exr: linear light R, G, B, A before tone map and clamp. UserError for other
/// endings.
void check_image_path(const std::string& path);
std::vector<std::uint8_t> encode_picture(const std::string& path, const Billed& billed);

/// EXR with the layers cost.alu_words, cost.alu_slots, cost.fetches, cost.fetch_cyc, cost.overdraw,
/// cost.helpers, cost.path (32-bit unsigned) and depth.Z (float, 0 near to 1 far).
std::vector<std::uint8_t> encode_cost_layers(const Billed& billed);

/// The files of `compare`: a.png, b.png, difference.png, cost_a.png, cost_b.png, cost_difference.png,
/// cost_a.exr, cost_b.exr, compare.json. Created before rendering, so that an unwritable folder fails first;
/// all or nothing.
struct ComparisonFile {
  std::string name;
  std::vector<std::uint8_t> bytes;
};
std::vector<std::string> comparison_file_names();
std::vector<ComparisonFile> comparison_files(const Billed& a, const Billed& b,
                                             const ImageDifference& difference);

}  // namespace aluminate::report
