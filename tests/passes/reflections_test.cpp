// Captured cube maps: the same renderer as the picture, a sky that follows the time of day, a polariser that
// reaches sky texels and nothing else.
#include "shading/passes/reflections.hpp"

#include <gtest/gtest.h>

#include "platform/host/error.hpp"
#include "scenes/scene.hpp"
#include "shading/passes/frame.hpp"
#include "shading/sky/sun.hpp"
#include "tests/passes/cube_map_file.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

FrameOptions options_for(const std::string& assignments) {
  FrameOptions options;
  options.width = 96;
  options.height = 54;
  set_options(options, assignments);
  return options;
}

CubeMap captured(const std::string& assignments) {
  return capture_cube_map(test::sample_scene("beach_hut"), options_for(assignments),
                          {.face_px = 16, .at_given = true, .at = {0, 1.5, 6}});
}

TEST(CubeMap, SkyTexelsAreTheSkyInTheirDirection) {
  const FrameOptions options = options_for("sky=fc3,time=16:00");
  const CubeMap map = captured("sky=fc3,time=16:00,ambient=sky");
  const sky::Sky sky = make_sky_setup(options)->sky;
  int open = 0, closed = 0, between = 0;
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 16; ++x) {
        const std::size_t i = map.seen.index(face, x, y);
        const glm::dvec4& texel = map.seen.texels[i];
        texel.w == 1 ? ++open : texel.w == 0 ? ++closed : ++between;
        for (int c = 0; c < 3; ++c) {
          if (texel.w == 1) {
            EXPECT_EQ(map.surface[i][c], 0);
          }
          if (texel.w == 0) {
            EXPECT_EQ(map.surface[i][c], texel[c]);
          }
        }
        if (texel.w != 1) continue;
        // The mean of the 16 pixels drawn; the shader's sky errs by 2.5e-4 (sky_frame_test.cpp).
        glm::dvec3 mean(0);
        for (int j = 0; j < 4; ++j)
          for (int k = 0; k < 4; ++k)
            mean += sky::extended_radiance(
                        sky, sky::world_to_z_up(filter::cube_direction(face, 4 * x + k, 4 * y + j, 64))) /
                    16.0;
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(texel[c], mean[c], 2.5e-4 * mean[c] + 1e-5);
      }
  EXPECT_GT(open, 300);
  EXPECT_GT(closed, 300);
  EXPECT_GT(between, 20);
}

TEST(CubeMap, PolariserChangesExactlyTheSkyTexels) {
  const std::string sky = "sky=fc3,time=16:00,ambient=sky";
  const CubeMap plain = captured(sky), one = captured(sky + ",polarizer=1,1,1"),
                filtered = captured(sky + ",polarizer=0.5,0.75,2");
  EXPECT_EQ(one.seen.texels, plain.seen.texels);
  EXPECT_EQ(filtered.surface, plain.surface);
  const glm::dvec3 factor(0.5, 0.75, 2);
  for (std::size_t i = 0; i < plain.seen.texels.size(); ++i) {
    EXPECT_EQ(filtered.seen.texels[i].w, plain.seen.texels[i].w);
    for (int c = 0; c < 3; ++c) {
      const double of_sky = plain.seen.texels[i][c] - plain.surface[i][c];
      EXPECT_NEAR(filtered.seen.texels[i][c], plain.surface[i][c] + of_sky * factor[c], 1e-6 * (1 + of_sky));
      if (plain.seen.texels[i].w == 0) {
        EXPECT_EQ(filtered.seen.texels[i][c], plain.seen.texels[i][c]);
      }
    }
  }
}

TEST(Reflections, SkyFollowsTheTimeOfDayAndSurfacesStay) {
  const CubeMap morning = captured("sky=fc3,time=08:00,ambient=sky"),
                evening = captured("sky=fc3,time=17:30,ambient=sky");
  const auto at = [](const std::string& more) { return make_sky_setup(options_for("sky=fc3," + more)); };
  const Reflections relit = make_reflections(morning, at("time=17:30"), glm::dvec3(1));
  const Reflections again = make_reflections(evening, at("time=17:30"), glm::dvec3(1));
  const Reflections dimmed = make_reflections(morning, at("time=17:30"), glm::dvec3(0.5));
  int open = 0;
  for (std::size_t i = 0; i < morning.seen.texels.size(); ++i) {
    const double share = morning.seen.texels[i].w;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto value = [&](const Reflections& r) {
        return r.texture.linear16(0, i, c) / 65535.0 * r.uniform.x;
      };
      const double step = std::max({relit.uniform.x, again.uniform.x, dimmed.uniform.x}) / 65535;
      if (share == 1) {  // one sky, whatever was captured
        EXPECT_NEAR(value(relit), value(again), step);
      }
      if (share == 1) {
        EXPECT_NEAR(value(dimmed), 0.5 * value(relit), step);
      }
      if (share == 0) {
        EXPECT_NEAR(value(relit), morning.seen.texels[i][static_cast<int>(c)], step);
      }
      if (share == 0) {
        EXPECT_NEAR(value(dimmed), value(relit), step);
      }
    }
    open += share == 1;
  }
  EXPECT_GT(open, 300);
}

TEST(Reflections, AFileIsReadAsItWasWritten) {
  const CubeMap map = captured("sky=fc3,time=16:00");
  const test::CubeMapFile file(map);
  const CubeMap read = read_cube_map(file.path());
  ASSERT_EQ(read.seen.size, map.seen.size);
  for (std::size_t i = 0; i < map.seen.texels.size(); ++i) {
    for (int c = 0; c < 4; ++c) EXPECT_EQ(read.seen.texels[i][c], static_cast<float>(map.seen.texels[i][c]));
    for (int c = 0; c < 3; ++c) EXPECT_EQ(read.surface[i][c], static_cast<float>(map.surface[i][c]));
  }
  EXPECT_THROW(read_cube_map(std::string(ALUMINATE_SOURCE_DIR) + "/docs/images/beach_hut_day.png"),
               UserError);
}

TEST(Reflections, AreLightOfTheSurfaceAndOneMoreFetch) {
  const test::CubeMapFile file(captured("sky=fc3,time=16:00"));
  for (const char* pipeline : {"pipeline=forward", "pipeline=deferred"}) {
    FrameOptions options = options_for("sky=fc3,time=16:00,ambient=sky," + std::string(pipeline));
    const Frame without = render_frame(test::sample_scene("material_wall"), options);
    set_option(options, "reflections", file.path());
    const Frame with = render_frame(test::sample_scene("material_wall"), options);
    std::uint64_t lit = 0, changed = 0;
    for (std::size_t i = 0; i < with.pixel_count(); ++i) {
      if (with.depth_d24[i] == 0xffffff) {
        for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(with.linear[4 * i + c], without.linear[4 * i + c]);
        continue;
      }
      ++lit;
      changed += with.linear[4 * i] != without.linear[4 * i];
    }
    EXPECT_GT(changed, lit * 9 / 10);
    const auto of = [](const Frame& frame, const char* pass) {
      for (const PassTotals& totals : frame.passes)
        if (totals.name == pass) return totals;
      return PassTotals{};
    };
    const char* pass = options.pipeline == Pipeline::Deferred ? "sun" : "forward";
    const PassTotals a = of(without, pass), b = of(with, pass);
    const std::uint64_t lanes = 4 * b.quads;
    EXPECT_EQ(a.pixels, b.pixels);
    EXPECT_EQ(b.fetches - a.fetches, lanes) << pipeline;
    EXPECT_GT(b.alu_words, a.alu_words + 5 * lanes);
  }
}

}  // namespace
}  // namespace aluminate::passes
