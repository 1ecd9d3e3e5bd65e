#include "shading/passes/tile_pixels.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "shading/vm/srgb.hpp"

namespace aluminate::passes {
namespace {

std::uint8_t stored_code(double display) { return static_cast<std::uint8_t>(display * 255.0 + 0.5); }

/// Calls visit(first pixel) for each row.
template <class Visit>
void for_each_row(const PixelRect& rect, const Frame& frame, Visit&& visit) {
  for (int y = rect.y; y < rect.y + rect.height; ++y)
    visit(static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width) + static_cast<std::size_t>(rect.x));
}

}  // namespace

Background::Background(const glm::dvec3& display) {
  linear[3] = 1;
  stored[3] = 255;
  for (std::size_t c = 0; c < 3; ++c) {
    stored[c] = stored_code(display[static_cast<int>(c)]);
    linear[c] = static_cast<float>(vm::srgb_decode16(stored[c]) / 65535.0);
  }
}

void clear_pixels(const Background& background, const PixelRect& rect, Frame& frame) {
  const auto width = static_cast<std::size_t>(rect.width);
  for_each_row(rect, frame, [&](std::size_t first) {
    float* const linear = &frame.linear[first * 4];
    for (std::size_t i = 0; i < width; ++i) std::copy_n(background.linear.data(), 4, linear + 4 * i);
    std::fill_n(&frame.covered[first], width, std::uint8_t{0});
    std::fill_n(&frame.cost.path[first], width, 0u);
  });
}

void blank_pixels(const Background& background, const PixelRect& rect, Frame& frame) {
  clear_pixels(background, rect, frame);
  const auto width = static_cast<std::size_t>(rect.width);
  CostPlanes& cost = frame.cost;
  for_each_row(rect, frame, [&](std::size_t first) {
    std::fill_n(&frame.depth_d24[first], width, raster::kDepthMax);
    for (auto* plane : {&cost.alu_words, &cost.alu_slots, &cost.fetches, &cost.fetch_cyc, &cost.overdraw, &cost.helpers})
      std::fill_n(&(*plane)[first], width, 0u);
    for (std::size_t i = 0; i < width; ++i) std::memcpy(&frame.rgba8[(first + i) * 4], background.stored.data(), 4);
  });
}

void store_quads(std::span<const raster::QuadPosition> quads, std::uint64_t lanes, std::uint32_t path,
                 const std::array<const double*, 3>& rgb, Frame& frame) {
  const auto width = static_cast<std::size_t>(frame.width);
  const auto store = [&](std::size_t at, std::size_t lane) {
    float* const linear = &frame.linear[at * 4];
    for (std::size_t c = 0; c < 3; ++c) linear[c] = static_cast<float>(rgb[c][lane]);
    frame.covered[at] = 1;
    frame.cost.path[at] = path;
  };
  for (std::size_t q = 0; q < quads.size(); ++q) {
    const unsigned wanted = static_cast<unsigned>(lanes >> 4 * q) & 0xf;
    const std::size_t upper = std::size_t{quads[q].y} * width + quads[q].x, lower = upper + width;
    if ((wanted & 1) != 0) store(upper, 4 * q);
    if ((wanted & 2) != 0) store(upper + 1, 4 * q + 1);
    if ((wanted & 4) != 0) store(lower, 4 * q + 2);
    if ((wanted & 8) != 0) store(lower + 1, 4 * q + 3);
  }
}

void encode_pixels(const Background& background, const PixelRect& rect, Frame& frame) {
  static_assert(std::endian::native == std::endian::little);  // red is the lowest byte, and the first in memory
  const auto empty = std::bit_cast<std::uint32_t>(background.stored);
  for_each_row(rect, frame, [&](std::size_t first) {
    for (std::size_t i = first; i < first + static_cast<std::size_t>(rect.width); ++i) {
      std::uint32_t stored = empty;
      if (frame.covered[i]) {
        const float* const linear = &frame.linear[i * 4];
        stored = 0xff000000u | std::uint32_t{vm::srgb_encode8_single(linear[2])} << 16 |
                 std::uint32_t{vm::srgb_encode8_single(linear[1])} << 8 | vm::srgb_encode8_single(linear[0]);
      }
      std::memcpy(&frame.rgba8[i * 4], &stored, 4);
    }
  });
}

}  // namespace aluminate::passes
