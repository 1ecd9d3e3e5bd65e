// Fetches 64 lanes of texels: level of detail, addressing, filtering, all in integers after the coordinates.
//   in   coordinate rows as the shader computed them (any finite value), the sampler's binding
//   out  rows of numbers in [0, 1] on the result's grid, and what the fetch cost
// Definitions (level of detail, faces, weights, rounding): docs/texture_unit.md.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "platform/number/format.hpp"
#include "shading/vm/program.hpp"
#include "shading/vm/texture.hpp"

namespace aluminate::vm {

/// Coordinates a sampler takes: 2 for a flat texture, 3 for a direction (cube) or a volume.
constexpr std::size_t coordinate_count(SamplerDimension d) { return d == SamplerDimension::Tex2D ? 2 : 3; }

/// 64 doubles a row, n = coordinate_count. Rows [0, n): the coordinates. TexBias, TexLod: row n is the bias
/// or the level. TexGrad: rows [n, 2n) differ along x, [2n, 3n) along y. Other rows are not read.
struct FetchRequest {
  Opcode op = Opcode::Tex;
  SamplerDimension dimension = SamplerDimension::Tex2D;
  std::array<const double*, 9> rows{};
  std::uint64_t exec = 0;     // lanes that want a result
  std::uint64_t covered = 0;  // lanes that are billed
};

/// Source operand and position in it that row i of a request comes from; source < 0: not read.
struct FetchOperand {
  int source = -1, position = 0;
};
constexpr FetchOperand fetch_operand(Opcode op, SamplerDimension dimension, std::size_t row) {
  const std::size_t n = coordinate_count(dimension);
  if (row < n) return {0, static_cast<int>(row)};
  if ((op == Opcode::TexBias || op == Opcode::TexLod) && row == n) return {0, 3};
  if (op == Opcode::TexGrad && row < 3 * n) return {static_cast<int>(row / n), static_cast<int>(row % n)};
  return {};
}

struct FetchCost {
  std::uint64_t fetches = 0;  // covered lanes that fetched
  std::uint64_t cycles = 0;   // bilinear cycles of those
};

/// results[c] == nullptr: component c is not wanted. masked: other lanes of the result rows keep what they
/// had. Result rows may be coordinate rows. Implicit detail: one level per quad, from lanes 1 - 0 and 2 - 0.
/// No texture, or one of another shape than the request's: (0, 0, 0, 1).
FetchCost fetch(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                const number::Grid& grid, const std::array<double*, 4>& results) noexcept;

/// The same, texel by texel; the oracle.
FetchCost fetch_reference(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                          const number::Grid& grid, const std::array<double*, 4>& results) noexcept;

// ---- shared definitions
// -----------------------------------------------------------------------------------------

bool has_shape(const Texture* texture, SamplerDimension dimension) noexcept;

/// Level of detail times 256: 256 * log2 of the longer of the two texel-space derivative vectors.
std::int32_t volume_level_of_detail(const std::array<double, 3>& along_x,
                                    const std::array<double, 3>& along_y,
                                    const std::array<int, 3>& size) noexcept;
/// What one fetch covers of a flat texture: `probes` filtered samples spread evenly along its longer axis,
/// all of the level of detail that the share of one of them asks for.
struct Footprint {
  std::int32_t lod = 0;  // times 256
  int probes = 1;
  double du = 0, dv = 0;  // the longer axis
};
Footprint footprint_of(double du_dx, double dv_dx, double du_dy, double dv_dy, int width, int height,
                       int max_anisotropy) noexcept;
/// Where probe i of n lies, in parts of the longer axis from its middle.
constexpr double probe_offset(int i, int n) { return (2.0 * i + 1.0 - n) / (2.0 * n); }
/// Samples a fetch may make: 1 unless the sampler is anisotropic and the operation has derivatives.
constexpr int most_probes(const SamplerState& state, const FetchRequest& request) {
  return request.dimension == SamplerDimension::Tex2D && request.op != Opcode::TexLod &&
                 state.minify == Filter::Linear
             ? state.max_anisotropy
             : 1;
}

std::int32_t level_of_detail(double du_dx, double dv_dx, double du_dy, double dv_dy, int width,
                             int height) noexcept;
/// A level or bias given as a number, times 256, to nearest.
std::int32_t to_lod(double level) noexcept;

struct MipChoice {
  Filter filter = Filter::Linear;
  std::int32_t level = 0;     // finer of the two levels
  std::int32_t fraction = 0;  // weight of the coarser in 1/256; 0 = one level only
};
MipChoice choose_mip(const SamplerState& state, std::size_t levels, std::int32_t lod) noexcept;

/// What scales a sum of `probes` filtered samples to a number: binary64(2^-24 / (65535 probes)).
constexpr double texel_scale(int probes) { return 0x1p-24 / (65535.0 * probes); }

/// Sum of filtered samples, each scaled by 65535 * 2^24, to a number on the grid.
inline double texel_value(const number::Grid& grid, std::uint64_t sum, int probes = 1) {
  return std::fma(static_cast<double>(sum), texel_scale(probes), grid.magic) - grid.magic;
}

}  // namespace aluminate::vm
