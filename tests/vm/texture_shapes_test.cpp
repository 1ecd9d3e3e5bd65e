// Cube maps and volumes: faces and their orientation, level of detail on a face, eight-texel filtering, and
// the fast unit against the texel-by-texel one.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "shading/vm/cube_map.hpp"
#include "shading/vm/texture_unit.hpp"
#include "tests/vm/machine.hpp"

namespace aluminate::vm::testing {
namespace {

using Lane = std::array<double, 9>;

struct Fetched {
  AlignedRows rows{9}, texels{4};
  FetchCost cost;
  double code(int lane, std::size_t channel) { return texels.at(channel, lane) * 255; }
};

Fetched sample(const Texture& texture, const SamplerState& state, SamplerDimension dimension, Opcode op,
               const std::vector<Lane>& lanes, bool reference = false) {
  Fetched f;
  for (int lane = 0; lane < kLanes; ++lane)
    for (std::size_t k = 0; k < 9; ++k)
      f.rows.at(k, lane) = lanes[std::min<std::size_t>(static_cast<std::size_t>(lane), lanes.size() - 1)][k];
  FetchRequest request;
  request.op = op;
  request.dimension = dimension;
  for (std::size_t k = 0; k < 9; ++k) request.rows[k] = f.rows.data() + k * kLanes;
  request.exec = request.covered = kAllLanes;
  const std::array<double*, 4> rows = {&f.texels.at(0, 0), &f.texels.at(1, 0), &f.texels.at(2, 0),
                                       &f.texels.at(3, 0)};
  const SamplerBinding binding{&texture, state};
  const number::Grid grid = format("fx31").unit_grid();
  f.cost = reference ? fetch_reference(binding, request, false, grid, rows)
                     : fetch(binding, request, false, grid, rows);
  return f;
}

// R = column, G = row, B = slice.
Texture ramp(TextureShape shape, int width, int height, int slices, bool mipmapped = false) {
  MipLevel level{width, height, slices};
  for (int z = 0; z < slices; ++z)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int code : {x, y, z, 255}) level.codes8.push_back(static_cast<std::uint8_t>(code));
  return Texture::from_level(shape, std::move(level), false, mipmapped);
}

constexpr SamplerState kPoint{Address::Clamp, Address::Clamp, Filter::Point, Filter::Point,
                              Filter::Point,  false,          Address::Clamp};
constexpr SamplerState kLinear{Address::Clamp, Address::Clamp, Filter::Linear, Filter::Linear,
                               Filter::Point,  false,          Address::Clamp};

// Direct3D's table: which way columns and rows run on each face.
struct FaceAxes {
  Direction out, right, down;
};
constexpr FaceAxes kFaces[] = {{{1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
                               {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},   {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
                               {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}}};

Lane direction(const FaceAxes& face, double u, double v, double length = 1) {
  Lane lane{};
  for (std::size_t k = 0; k < 3; ++k)
    lane[k] = length * (face.out[k] + (2 * u - 1) * face.right[k] + (2 * v - 1) * face.down[k]);
  return lane;
}

TEST(CubeMap, EveryTexelOfEveryFaceIsWhereDirect3dPutsIt) {
  const Texture t = ramp(TextureShape::Cube, 8, 8, 6);
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x)
        for (double length : {1.0, 0.125, 512.0}) {
          Fetched f = sample(t, kPoint, SamplerDimension::TexCube, Opcode::TexLod,
                             {direction(kFaces[face], (x + 0.5) / 8, (y + 0.5) / 8, length)});
          ASSERT_NEAR(f.code(0, 0), x, 1e-12);
          ASSERT_NEAR(f.code(0, 1), y, 1e-12);
          ASSERT_NEAR(f.code(0, 2), face, 1e-12);
        }
}

TEST(CubeMap, FilteringEndsAtTheEdgeOfAFace) {
  const Texture t = ramp(TextureShape::Cube, 8, 8, 6);
  Fetched f = sample(t, kLinear, SamplerDimension::TexCube, Opcode::TexLod,
                     {direction(kFaces[0], 1 - 0x1p-20, 0.25)});
  EXPECT_NEAR(f.code(0, 0), 7, 1e-12);
  EXPECT_NEAR(f.code(0, 1), 1.5, 1e-12);
  EXPECT_NEAR(f.code(0, 2), 0, 1e-12);
}

// Every border texel holds its edge's constant, corners the mean of their three edges: then the picture has no seam.
TEST(CubeMap, IsContinuousAcrossAnEdgeBothFacesAgreeOn) {
  constexpr int kSize = 8;
  const auto edge_code = [](int a, int b) {  // of two axes, each 2 * axis + sign
    return 20 + 15 * (std::min(a, b) * 6 + std::max(a, b)) % 200;
  };
  const auto side = [](const Direction& d) {
    for (std::size_t k = 0; k < 3; ++k)
      if (d[k] != 0) return static_cast<int>(2 * k) + (d[k] < 0 ? 1 : 0);
    return -1;
  };
  const auto opposite = [](int s) { return s ^ 1; };
  MipLevel level{kSize, kSize, 6};
  for (const FaceAxes& face : kFaces)
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const int out = side(face.out), right = side(face.right), down = side(face.down);
        const int h = x == 0 ? opposite(right) : x == kSize - 1 ? right : -1;
        const int v = y == 0 ? opposite(down) : y == kSize - 1 ? down : -1;
        int code = 7 * x + 11 * y;
        if (h >= 0 && v >= 0) {
          code = (edge_code(out, h) + edge_code(out, v) + edge_code(h, v)) / 3;
        } else if (h >= 0 || v >= 0) {
          code = edge_code(out, std::max(h, v));
        }
        for (int c = 0; c < 4; ++c) level.codes8.push_back(static_cast<std::uint8_t>(code));
      }
  const Texture t = Texture::from_level(TextureShape::Cube, std::move(level), false, false);
  int crossings = 0;
  for (const FaceAxes& face : kFaces)
    for (int i = 1; i < 64; ++i)
      for (const bool along_right : {false, true}) {
        const double inside = 1 - 0x1p-12, outside = 1 + 0x1p-12, at = i / 64.0;
        Fetched a = sample(t, kLinear, SamplerDimension::TexCube, Opcode::TexLod,
                           {direction(face, along_right ? inside : at, along_right ? at : inside)});
        Fetched b = sample(t, kLinear, SamplerDimension::TexCube, Opcode::TexLod,
                           {direction(face, along_right ? outside : at, along_right ? at : outside)});
        EXPECT_NEAR(a.code(0, 0), b.code(0, 0), 1);
        ++crossings;
      }
  EXPECT_EQ(crossings, 6 * 63 * 2);
}

TEST(CubeMap, TiesGoToZBeforeYBeforeX) {
  EXPECT_EQ(cube_face({1, 1, 1}), 4);
  EXPECT_EQ(cube_face({-1, -1, -1}), 5);
  EXPECT_EQ(cube_face({1, -1, 0.5}), 3);
  EXPECT_EQ(cube_face({0, 0, 0}), 4);
  EXPECT_EQ(face_point({0, 0, 0}).u, 0.5);
}

TEST(CubeMap, DetailIsTheDerivativeOfThePlaceOnTheFace) {
  const double h = 1e-6;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Direction at{unit(random), unit(random), unit(random)},
        step{unit(random) * h, unit(random) * h, unit(random) * h};
    const Direction beyond{at[0] + step[0], at[1] + step[1], at[2] + step[2]};
    if (cube_face(at) != cube_face(beyond)) continue;
    const FacePoint from = face_point(at), to = face_point(beyond);
    const auto change = face_step(at, step);
    // Central enough: the second derivative of s / m times h^2, m >= 1 / sqrt(3) of a direction no shorter
    // than 0.1.
    if (at[0] * at[0] + at[1] * at[1] + at[2] * at[2] < 0.01) continue;
    EXPECT_NEAR(change[0], to.u - from.u, 2e3 * h * h);
    EXPECT_NEAR(change[1], to.v - from.v, 2e3 * h * h);
  }
}

TEST(CubeMap, ImplicitDetailIsTheSameAsTheExplicitOne) {
  const Texture t = ramp(TextureShape::Cube, 64, 64, 6, true);
  // Four texels a pixel along the face's rows, one along its columns: level 2.
  std::vector<Lane> quad, level_two;
  for (int l = 0; l < 4; ++l) {
    quad.push_back(direction(kFaces[2], 0.5 + (l & 1) * 4.0 / 64, 0.5 + (l >> 1) * 1.0 / 64));
    level_two.push_back(quad.back());
    level_two.back()[3] = 2;
  }
  const SamplerState s;
  Fetched a = sample(t, s, SamplerDimension::TexCube, Opcode::Tex, quad);
  Fetched b = sample(t, s, SamplerDimension::TexCube, Opcode::TexLod, level_two);
  for (int lane = 0; lane < 4; ++lane) EXPECT_EQ(a.texels.at(0, lane), b.texels.at(0, lane)) << lane;
  std::vector<Lane> gradients = quad;
  for (Lane& lane : gradients) {
    lane = quad[0];
    for (std::size_t k = 0; k < 3; ++k)
      lane[3 + k] = quad[1][k] - quad[0][k], lane[6 + k] = quad[2][k] - quad[0][k];
  }
  EXPECT_EQ(sample(t, s, SamplerDimension::TexCube, Opcode::TexGrad, gradients).texels.at(0, 0),
            a.texels.at(0, 0));
}

TEST(Volume, EightTexelsAreWeighedByDistance) {
  const Texture t = ramp(TextureShape::Volume, 8, 4, 2);
  Fetched f = sample(t, kLinear, SamplerDimension::Tex3D, Opcode::TexLod, {{3.75 / 8, 1.25 / 4, 0.5, 0}});
  EXPECT_NEAR(f.code(0, 0), 3.25, 1e-5);  // the blend of two slices is rounded to 2^-16 / 65535 of full scale
  EXPECT_NEAR(f.code(0, 1), 0.75, 1e-5);
  EXPECT_NEAR(f.code(0, 2), 0.5, 1e-5);
  EXPECT_EQ(f.cost.cycles, 128u);  // two slices
  EXPECT_NEAR(sample(t, kPoint, SamplerDimension::Tex3D, Opcode::TexLod, {{0, 0, 0.9, 0}}).code(0, 2), 1,
              1e-12);
  EXPECT_EQ(sample(t, kPoint, SamplerDimension::Tex3D, Opcode::TexLod, {{0, 0, 0.9, 0}}).cost.cycles, 64u);
}

TEST(Volume, MipsAverageTheThirdAxisToo) {
  const Texture t = ramp(TextureShape::Volume, 2, 2, 4, true);
  ASSERT_EQ(t.levels().size(), 3u);
  EXPECT_EQ(t.levels()[1].slices, 2);
  EXPECT_EQ(t.levels()[1].codes8[2], 1);  // slices 0 and 1: 0.5, half up
  EXPECT_EQ(t.levels()[1].codes8[6], 3);
  EXPECT_EQ(t.levels()[2].codes8[2], 2);
}

TEST(Volume, DetailTakesTheLongestOfThreeAxes) {
  EXPECT_EQ(volume_level_of_detail({0, 0, 4.0 / 16}, {1.0 / 8, 0, 0}, {8, 8, 16}), 2 * 256);
}

TEST(WideTexels, AreReadAsTheyAre) {
  MipLevel level{4, 1, 1};
  for (int i = 0; i < 16; ++i) level.codes16.push_back(static_cast<std::uint16_t>(i * 4369));
  const Texture t = Texture::from_level(TextureShape::Flat, level, false, false);
  for (int x = 0; x < 4; ++x)
    for (std::size_t c = 0; c < 4; ++c) {
      Fetched f = sample(t, kPoint, SamplerDimension::Tex2D, Opcode::TexLod, {{(x + 0.5) / 4, 0.5, 0}});
      EXPECT_EQ(
          f.texels.at(c, 0),
          std::rint(0x1p50L * static_cast<long double>(level.codes16[4 * static_cast<std::size_t>(x) + c]) /
                    65535) *
              0x1p-50L);
    }
}

TEST(Shapes, ATextureOfAnotherShapeIsNoTexture) {
  const Texture flat = ramp(TextureShape::Flat, 4, 4, 1);
  Fetched f = sample(flat, kPoint, SamplerDimension::TexCube, Opcode::Tex, {{1, 0, 0}});
  EXPECT_EQ(f.texels.at(0, 3), 0);
  EXPECT_EQ(f.texels.at(3, 3), 1);
}

TEST(Shapes, FastAndReferenceGiveTheSameBits) {
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> unit(-2, 2);
  for (int round = 0; round < 400; ++round) {
    const bool is_cube = round % 2 == 0;
    const int width = 1 + static_cast<int>(random() % 20);
    MipLevel level{width, is_cube ? width : 1 + static_cast<int>(random() % 9),
                   is_cube ? 6 : 1 + static_cast<int>(random() % 7)};
    const bool is_wide = random() % 4 == 0;
    if (is_wide) level.codes16.resize(level.texel_count() * 4);
    if (!is_wide) level.codes8.resize(level.texel_count() * 4);
    for (auto& code : level.codes8) code = static_cast<std::uint8_t>(random());
    for (auto& code : level.codes16) code = static_cast<std::uint16_t>(random());
    const auto shape = is_cube ? TextureShape::Cube : TextureShape::Volume;
    const Texture t =
        Texture::from_level(shape, std::move(level), !is_wide && random() % 2 == 0, random() % 4 != 0);
    const auto address = [&] { return static_cast<Address>(random() % 3); };
    const auto filter = [&] { return static_cast<Filter>(random() % 2); };
    const SamplerState state{address(), address(),         filter(), filter(),
                             filter(),  random() % 3 != 0, address()};
    std::vector<Lane> lanes(kLanes);
    for (Lane& lane : lanes)
      for (double& x : lane) x = random() % 16 == 0 ? 0 : unit(random) * (random() % 9 == 0 ? 1e5 : 1);
    const Opcode op = std::array{Opcode::Tex, Opcode::TexBias, Opcode::TexLod, Opcode::TexGrad}[random() % 4];
    const auto dimension = is_cube ? SamplerDimension::TexCube : SamplerDimension::Tex3D;
    Fetched a = sample(t, state, dimension, op, lanes), b = sample(t, state, dimension, op, lanes, true);
    ASSERT_EQ(a.cost.cycles, b.cost.cycles);
    for (int lane = 0; lane < kLanes; ++lane)
      for (std::size_t c = 0; c < 4; ++c) {
        ASSERT_EQ(a.texels.at(c, lane), b.texels.at(c, lane)) << round << " " << lane;
        ASSERT_TRUE(a.texels.at(c, lane) >= 0 && a.texels.at(c, lane) <= 1);
      }
  }
}

}  // namespace
}  // namespace aluminate::vm::testing
