// The texture unit on textures small enough to know every texel.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "platform/host/error.hpp"
#include "shading/vm/decoded.hpp"
#include "shading/vm/srgb.hpp"
#include "shading/vm/texture_unit.hpp"
#include "tests/vm/machine.hpp"

namespace aluminate::vm::testing {
namespace {

Texture ramp(int width, int height, bool mipmapped = false) {  // R = x, G = y, B = x + y, A = 255
  std::vector<std::uint8_t> rgba;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int byte : {x, y, x + y, 255}) rgba.push_back(static_cast<std::uint8_t>(byte));
  return Texture::from_rgba8(width, height, rgba, false, mipmapped);
}

struct Fetched {
  AlignedRows coordinates{6}, texels{4};
  FetchCost cost;
  double code(int lane, std::size_t channel) { return texels.at(channel, lane) * 255; }
};

Fetched sample(const Texture& texture, const SamplerState& state, Opcode op, const std::vector<std::array<double, 3>>& lanes,
               bool reference = false, std::uint64_t exec = kAllLanes, bool masked = false) {
  Fetched f;
  for (int lane = 0; lane < kLanes; ++lane)
    for (std::size_t k = 0; k < 3; ++k)
      f.coordinates.at(k, lane) = lanes[std::min<std::size_t>(static_cast<std::size_t>(lane), lanes.size() - 1)][k];
  FetchRequest request;
  request.op = op;
  for (std::size_t k = 0; k < 6; ++k) request.rows[k] = f.coordinates.data() + k * kLanes;
  request.exec = exec;
  request.covered = kAllLanes << 3;
  if (exec == kAllLanes) request.covered = kAllLanes;
  const std::array<double*, 4> rows = {&f.texels.at(0, 0), &f.texels.at(1, 0), &f.texels.at(2, 0), &f.texels.at(3, 0)};
  const SamplerBinding binding{&texture, state};
  const number::Grid grid = format("fx31").unit_grid();
  f.cost = reference ? fetch_reference(binding, request, masked, grid, rows) : fetch(binding, request, masked, grid, rows);
  return f;
}

constexpr SamplerState kPoint{Address::Wrap, Address::Wrap, Filter::Point, Filter::Point, Filter::Point, false};
constexpr SamplerState kBilinear{Address::Wrap, Address::Wrap, Filter::Linear, Filter::Linear, Filter::Point, false};

TEST(TextureFetch, TexelCentresGiveTheTexelExactly) {
  const Texture t = ramp(8, 4);
  for (const SamplerState& state : {kPoint, kBilinear})
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 8; ++x) {
        Fetched f = sample(t, state, Opcode::TexLod, {{(x + 0.5) / 8, (y + 0.5) / 4, 0}});
        EXPECT_EQ(f.texels.at(0, 0), std::rint(0x1p50 * x / 255) * 0x1p-50);
        EXPECT_EQ(f.texels.at(1, 0), std::rint(0x1p50 * y / 255) * 0x1p-50);
        EXPECT_EQ(f.texels.at(3, 0), 1.0);
      }
}

TEST(TextureFetch, EveryCodeIsItsFractionRoundedToTheUnitGrid) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 256; ++i) rgba.insert(rgba.end(), 4, static_cast<std::uint8_t>(i));
  const Texture t = Texture::from_rgba8(256, 1, rgba, false, false);
  for (int i = 0; i < 256; ++i) {
    Fetched f = sample(t, kPoint, Opcode::TexLod, {{(i + 0.5) / 256, 0.5, 0}});
    EXPECT_EQ(f.texels.at(2, 0), static_cast<double>(std::rint(0x1p50L * i / 255) * 0x1p-50L)) << i;
  }
}

TEST(TextureFetch, BilinearWeightsAreTheDistances) {
  const Texture t = ramp(8, 4);
  Fetched f = sample(t, kBilinear, Opcode::TexLod, {{3.75 / 8, 1.25 / 4, 0}});
  EXPECT_NEAR(f.code(0, 0), 3.25, 1e-12);
  EXPECT_NEAR(f.code(0, 1), 0.75, 1e-12);
  EXPECT_NEAR(f.code(0, 2), 4.0, 1e-12);
}

TEST(TextureFetch, AddressModesFoldAsNamed) {
  const Texture t = ramp(8, 4);
  const auto at = [&](Address mode, double u) {
    SamplerState state = kPoint;
    state.u = mode;
    return sample(t, state, Opcode::TexLod, {{u, 0.5, 0}}).code(0, 0);
  };
  EXPECT_NEAR(at(Address::Wrap, 1.0 + 2.5 / 8), 2, 1e-12);
  EXPECT_NEAR(at(Address::Wrap, -0.5 / 8), 7, 1e-12);
  EXPECT_NEAR(at(Address::Clamp, 17.0), 7, 1e-12);
  EXPECT_NEAR(at(Address::Clamp, -17.0), 0, 1e-12);
  EXPECT_NEAR(at(Address::Mirror, 1.0 + 2.5 / 8), 5, 1e-12);
  EXPECT_NEAR(at(Address::Mirror, -2.5 / 8), 2, 1e-12);
  EXPECT_NEAR(at(Address::Mirror, 2.0 + 2.5 / 8), 2, 1e-12);
}

TEST(TextureFetch, BilinearAtTheSeamWrapsOrRepeatsTheEdge) {
  const Texture t = ramp(8, 4);
  SamplerState state = kBilinear;
  EXPECT_NEAR(sample(t, state, Opcode::TexLod, {{0.0, 0.5 / 4, 0}}).code(0, 0), 3.5, 1e-12);  // texels 7 and 0
  state.u = Address::Clamp;
  EXPECT_NEAR(sample(t, state, Opcode::TexLod, {{0.0, 0.5 / 4, 0}}).code(0, 0), 0, 1e-12);
  EXPECT_NEAR(sample(t, state, Opcode::TexLod, {{1.0, 0.5 / 4, 0}}).code(0, 0), 7, 1e-12);
}

TEST(TextureFetch, LargeCoordinatesAddressTheTexelsOfTheirFraction) {
  const Texture t = ramp(8, 4);
  for (int i = 0; i < 64; ++i) {
    const double u = (i + 0.25) / 64;  // on every grid
    Fetched near = sample(t, kBilinear, Opcode::TexLod, {{u, u, 0}});
    Fetched far = sample(t, kBilinear, Opcode::TexLod, {{u + 1e6, u - 1e6, 0}});
    EXPECT_EQ(near.texels.at(0, 0), far.texels.at(0, 0)) << u;
    EXPECT_EQ(near.texels.at(1, 0), far.texels.at(1, 0)) << u;
  }
}

TEST(TextureFetch, SrgbIsDecodedBeforeFiltering) {
  const std::vector<std::uint8_t> rgba = {0, 0, 0, 0, 255, 188, 50, 255};
  const Texture t = Texture::from_rgba8(2, 1, rgba, true, false);
  Fetched f = sample(t, kBilinear, Opcode::TexLod, {{0.5, 0.5, 0}});
  EXPECT_EQ(f.texels.at(0, 0), 0.5);
  EXPECT_NEAR(f.texels.at(1, 0), srgb_decode16(188) / 131070.0, 1e-15);
  EXPECT_EQ(f.texels.at(3, 0), 0.5);  // alpha is linear
}

TEST(TextureMips, AreExactBoxesAlsoForOddSizes) {
  const std::vector<std::uint8_t> rgba = {0, 0, 0, 255, 100, 0, 0, 255, 200, 0, 0, 255, 50, 0, 0, 255, 250, 0, 0, 255};
  const Texture t = Texture::from_rgba8(5, 1, rgba, false, true);
  ASSERT_EQ(t.levels().size(), 3u);
  ASSERT_EQ(t.levels()[1].width, 2);
  EXPECT_EQ(t.levels()[1].codes8[0], 80);   // (2*0 + 2*100 + 1*200) / 5
  EXPECT_EQ(t.levels()[1].codes8[4], 160);  // (1*200 + 2*50 + 2*250) / 5
  EXPECT_EQ(t.levels()[2].codes8[0], 120);
  EXPECT_EQ(t.levels()[2].codes8[3], 255);
}

TEST(TextureMips, AverageSrgbInLinearLight) {
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 4; ++i) rgba.insert(rgba.end(), 4, static_cast<std::uint8_t>(i % 2 == 0 ? 0 : 255));
  const Texture t = Texture::from_rgba8(2, 2, rgba, true, true);
  EXPECT_EQ(t.levels()[1].codes8[0], 188);  // encode(0.5)
  EXPECT_EQ(t.levels()[1].codes8[3], 128);  // alpha: 127.5 rounds half up
}

TEST(TextureMips, AConstantTextureStaysConstant) {
  for (bool srgb : {false, true})
    for (int code = 0; code < 256; ++code) {
      const std::vector<std::uint8_t> rgba(7 * 5 * 4, static_cast<std::uint8_t>(code));
      const Texture t = Texture::from_rgba8(7, 5, rgba, srgb, true);
      for (const MipLevel& level : t.levels())
        for (std::uint8_t byte : level.codes8) ASSERT_EQ(byte, code);
    }
}

TEST(LevelOfDetail, IsLog2OfTexelsPerPixel) {
  EXPECT_EQ(level_of_detail(1.0 / 64, 0, 0, 1.0 / 64, 64, 64), 0);
  EXPECT_EQ(level_of_detail(4.0 / 64, 0, 0, 1.0 / 64, 64, 64), 2 * 256);
  EXPECT_EQ(level_of_detail(0, 1.0 / 32, 0, 0, 64, 64), 256);
  EXPECT_EQ(level_of_detail(3.0 / 64, 4.0 / 64, 0, 0, 64, 64), static_cast<int>(std::lround(256 * std::log2(5.0))));
  EXPECT_LT(level_of_detail(0, 0, 0, 0, 64, 64), -256 * 20);
  EXPECT_GT(level_of_detail(1e300, 0, 0, 0, 64, 64), 256 * 20);
}

TEST(LevelOfDetail, IsOneLevelOverAConstantGradientWherever) {
  // Coordinates as a plane gives them, far from the origin too: every quad of the batch has the same level.
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 64 * 64; ++i) rgba.insert(rgba.end(), 4, static_cast<std::uint8_t>(i % 64));
  const Texture t = Texture::from_rgba8(64, 64, rgba, false, true);
  for (const double base : {0.0, 1000.0, -65536.0}) {
    std::vector<std::array<double, 3>> lanes, levels;
    for (int lane = 0; lane < kLanes; ++lane) {
      const int q = lane / 4, x = q % 4 * 2 + lane % 2, y = q / 4 * 2 + lane / 2 % 2;
      lanes.push_back({base + 3.0 / 64 * x, base + 2.5 / 64 * y, 0});
      levels.push_back({lanes.back()[0], lanes.back()[1], std::log2(3.0)});
    }
    Fetched implicit = sample(t, SamplerState{}, Opcode::Tex, lanes), given = sample(t, SamplerState{}, Opcode::TexLod, levels);
    for (int lane = 0; lane < kLanes; ++lane) EXPECT_EQ(implicit.texels.at(0, lane), given.texels.at(0, lane)) << lane;
  }
}

TEST(LevelOfDetail, ChoosesLevelsAndWeights) {
  SamplerState s;
  s.magnify = Filter::Point;
  const auto chosen = [&](std::int32_t lod) {
    const MipChoice m = choose_mip(s, 5, lod);
    return std::array<int, 3>{m.filter == Filter::Linear, m.level, m.fraction};
  };
  EXPECT_EQ(chosen(0), (std::array<int, 3>{0, 0, 0}));
  EXPECT_EQ(chosen(1), (std::array<int, 3>{1, 0, 1}));
  EXPECT_EQ(chosen(256 + 64), (std::array<int, 3>{1, 1, 64}));
  EXPECT_EQ(chosen(99999), (std::array<int, 3>{1, 4, 0}));
  s.mip = Filter::Point;
  EXPECT_EQ(chosen(127), (std::array<int, 3>{1, 0, 0}));
  EXPECT_EQ(chosen(128), (std::array<int, 3>{1, 1, 0}));
  EXPECT_EQ(chosen(99999), (std::array<int, 3>{1, 4, 0}));
  s.mipmapped = false;
  EXPECT_EQ(chosen(700), (std::array<int, 3>{1, 0, 0}));
}

TEST(TextureFetch, TrilinearBlendsTwoLevelsAndCostsTwoCycles) {
  std::vector<std::uint8_t> rgba(4 * 4 * 4, 0);
  rgba[0] = 240;
  const Texture t = Texture::from_rgba8(4, 4, rgba, false, true);  // level 1 texel (0,0): 60; level 2: 15
  SamplerState s;
  s.u = s.v = Address::Clamp;
  Fetched f = sample(t, s, Opcode::TexLod, {{0, 0, 1.25}});
  EXPECT_NEAR(f.code(0, 0), 0.75 * 60 + 0.25 * 15, 1e-12);
  EXPECT_EQ(f.cost.fetches, 64u);
  EXPECT_EQ(f.cost.cycles, 128u);
  EXPECT_EQ(sample(t, s, Opcode::TexLod, {{0, 0, 1}}).cost.cycles, 64u);
}

TEST(TextureFetch, ImplicitDetailIsTheQuadsAndBiasAddsToIt) {
  const Texture t = ramp(64, 64, true);
  SamplerState s;
  // Quad with texel steps of 4 along x, 2 along y: level 2.
  const std::vector<std::array<double, 3>> quad = {{0.5, 0.5, -1}, {0.5 + 4.0 / 64, 0.5, -1}, {0.5, 0.5 + 2.0 / 64, -1}, {0.5 + 4.0 / 64, 0.5 + 2.0 / 64, -1}};
  std::vector<std::array<double, 3>> at_level_two = quad, at_level_one = quad;
  for (auto& lane : at_level_two) lane[2] = 2;
  for (auto& lane : at_level_one) lane[2] = 1;
  Fetched implicit = sample(t, s, Opcode::Tex, quad), two = sample(t, s, Opcode::TexLod, at_level_two);
  Fetched biased = sample(t, s, Opcode::TexBias, quad), one = sample(t, s, Opcode::TexLod, at_level_one);
  for (int lane = 0; lane < 4; ++lane) {
    EXPECT_EQ(implicit.texels.at(0, lane), two.texels.at(0, lane));
    EXPECT_EQ(biased.texels.at(0, lane), one.texels.at(0, lane));
  }
}

TEST(TextureFetch, DegenerateAndHugeCoordinatesAreHarmless) {
  const Texture t = ramp(64, 64, true);
  for (const SamplerState& s : {SamplerState{}, SamplerState{Address::Mirror, Address::Clamp, Filter::Linear, Filter::Linear, Filter::Linear, true}}) {
    std::vector<std::array<double, 3>> lanes;
    for (double u : {0.0, 1e300, -1e300, 0x1p500, 1e-300, -1e-300, 0x1p20, -0x1p31}) lanes.push_back({u, -u, u});
    for (Opcode op : {Opcode::Tex, Opcode::TexBias, Opcode::TexLod}) {
      Fetched f = sample(t, s, op, lanes);
      for (std::size_t lane = 0; lane < lanes.size(); ++lane)
        for (std::size_t c = 0; c < 4; ++c) {
          const double texel = f.texels.at(c, static_cast<int>(lane));
          ASSERT_TRUE(texel >= 0 && texel <= 1) << lanes[lane][0];
        }
    }
  }
}

TEST(TextureFetch, NoTextureBoundGivesOpaqueBlack) {
  FetchRequest request;
  AlignedRows rows(4), coordinates(1);
  for (auto& row : request.rows) row = coordinates.data();
  request.exec = request.covered = kAllLanes;
  fetch({}, request, false, format("fx31").unit_grid(), {rows.data(), nullptr, nullptr, rows.data() + kLanes});
  EXPECT_EQ(rows.at(0, 9), 0);
  EXPECT_EQ(rows.at(1, 9), 1);
}

TEST(Anisotropy, ProbesAreTheRatioOfTheAxesAndShareTheLongerOne) {
  const auto footprint = [](double x, double y, int max) { return footprint_of(x / 64, 0, 0, y / 64, 64, 64, max); };
  EXPECT_EQ(footprint(8, 1, 16).probes, 8);
  EXPECT_EQ(footprint(8, 1, 16).lod, 0);
  EXPECT_EQ(footprint(8, 1, 4).probes, 4);
  EXPECT_EQ(footprint(8, 1, 4).lod, 256);
  EXPECT_EQ(footprint(8, 1, 1).lod, 3 * 256);
  EXPECT_EQ(footprint(8, 3, 16).probes, 3);        // 2.67, rounded up
  EXPECT_EQ(footprint(8, 0.001, 16).probes, 8);    // no probes closer than a texel
  EXPECT_EQ(footprint(0.5, 0.01, 16).probes, 1);   // magnified
  EXPECT_EQ(footprint(1e300, 0, 16).probes, 16);
  EXPECT_EQ(footprint(4, 16, 16).du, 0);
  EXPECT_EQ(footprint(4, 16, 16).dv, 0.25);
  EXPECT_EQ(probe_offset(0, 4), -0.375);
  EXPECT_EQ(probe_offset(3, 4), 0.375);
  EXPECT_EQ(probe_offset(0, 1), 0);
}

TEST(Anisotropy, KeepsWhatTheShorterAxisResolves) {
  // Columns of 0 and 240 seen from a grazing angle: eight texels a pixel along the columns, one across.
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 64 * 64; ++i) rgba.insert(rgba.end(), 4, static_cast<std::uint8_t>(i % 2 == 0 ? 0 : 240));
  const Texture t = Texture::from_rgba8(64, 64, rgba, false, true);
  SamplerState s;
  std::vector<std::array<double, 3>> quad;
  for (int l = 0; l < 4; ++l) quad.push_back({(20.5 + (l & 1)) / 64, (20.5 + 8 * (l >> 1)) / 64, 0});
  Fetched isotropic = sample(t, s, Opcode::Tex, quad);
  EXPECT_NEAR(isotropic.code(0, 0), 120, 1e-12);
  s.max_anisotropy = 16;
  Fetched sharp = sample(t, s, Opcode::Tex, quad);
  EXPECT_NEAR(sharp.code(0, 0), 0, 1e-12);
  EXPECT_NEAR(sharp.code(1, 0), 240, 1e-12);
  EXPECT_EQ(isotropic.cost.cycles, 64u);
  EXPECT_EQ(sharp.cost.cycles, 4 * 8u + 60u);  // lanes behind the first quad stand still
  s.max_anisotropy = 3;                        // 8 / 3 texels a probe: between two levels
  EXPECT_EQ(sample(t, s, Opcode::Tex, quad).cost.cycles, 4 * 3 * 2u + 60u);
  s.minify = Filter::Point;
  EXPECT_EQ(sample(t, s, Opcode::Tex, quad).cost.cycles, 4 * 1u + 60u);
}

TEST(Anisotropy, AConstantTextureStaysConstant) {
  const std::vector<std::uint8_t> rgba(16 * 16 * 4, 77);
  const Texture t = Texture::from_rgba8(16, 16, rgba, true, true);
  SamplerState plain, s;
  s.max_anisotropy = 7;
  std::vector<std::array<double, 3>> lanes;
  for (int l = 0; l < kLanes; ++l) lanes.push_back({0.37 * l, 0.013 * l, 0});
  Fetched a = sample(t, s, Opcode::Tex, lanes), b = sample(t, plain, Opcode::TexLod, lanes);
  for (int l = 0; l < kLanes; ++l) EXPECT_NEAR(a.texels.at(0, l), b.texels.at(0, l), 0x1p-50);
}

void check_fast_against_reference() {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-2, 2);
  for (int round = 0; round < 400; ++round) {
    const int width = 1 << (random() % 7), height = 1 + static_cast<int>(random() % 40);
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width * height) * 4);
    for (auto& byte : rgba) byte = static_cast<std::uint8_t>(random());
    const Texture t = Texture::from_rgba8(width, height, rgba, random() % 2 == 0, random() % 4 != 0);
    const auto address = [&] { return static_cast<Address>(random() % 3); };
    const auto filter = [&] { return static_cast<Filter>(random() % 2); };
    SamplerState state{address(), address(), filter(), filter(), filter(), random() % 3 != 0};
    state.max_anisotropy = std::array{1, 2, 3, 8, kMostProbes}[random() % 5];
    const double spread = std::exp2(unit(random) * 5);
    std::vector<std::array<double, 3>> lanes;
    for (int lane = 0; lane < kLanes; ++lane)
      lanes.push_back({unit(random) * spread, unit(random) * spread * (round % 5 == 0 ? 1e6 : 1), unit(random) * 4});
    // Every other texture is seen by smooth quads, long along some axis, the others by lanes without order.
    if (round % 2 == 0)
      for (std::size_t quad = 0; quad < kLanes; quad += 4) {
        const double scale = std::exp2(unit(random) * 2 - 2) / width, ratio = std::exp2(unit(random) * 3);
        const double angle = unit(random) * 3;
        for (std::size_t l = 1; l < 4; ++l) {
          const double x = (l & 1) != 0 ? scale : 0, y = (l & 2) != 0 ? scale * ratio : 0;
          lanes[quad + l][0] = lanes[quad][0] + x * std::cos(angle) - y * std::sin(angle);
          lanes[quad + l][1] = lanes[quad][1] + x * std::sin(angle) + y * std::cos(angle);
        }
      }
    const Opcode op = std::array{Opcode::Tex, Opcode::TexBias, Opcode::TexLod}[random() % 3];
    const bool masked = random() % 3 == 0;
    const std::uint64_t exec = random() % 2 == 0 ? kAllLanes : random() | random();
    Fetched a = sample(t, state, op, lanes, false, exec, masked), b = sample(t, state, op, lanes, true, exec, masked);
    ASSERT_EQ(a.cost.fetches, b.cost.fetches);
    ASSERT_EQ(a.cost.cycles, b.cost.cycles);
    for (int lane = 0; lane < kLanes; ++lane)
      if (!masked && (exec >> lane & 1) == 0)  // any numbers
        for (std::size_t c = 0; c < 4; ++c) {
          ASSERT_TRUE(std::isfinite(a.texels.at(c, lane)));
          a.texels.at(c, lane) = b.texels.at(c, lane);
        }
    for (int lane = 0; lane < kLanes; ++lane)
      for (std::size_t c = 0; c < 4; ++c) ASSERT_EQ(a.texels.at(c, lane), b.texels.at(c, lane)) << round << " " << lane;
  }
}

TEST(TextureFetch, FastAndReferenceGiveTheSameBitsOnEveryTarget) {
  for (const char* target : kernel_targets()) {
    SCOPED_TRACE(target);
    force_kernel_target(target);
    check_fast_against_reference();
    force_kernel_target(nullptr);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace aluminate::vm::testing
