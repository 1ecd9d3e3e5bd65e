// Writes the photograph that docs/calibration.md times: 24 megapixels of a chart beside a material, through a
// camera with white balance, cross-talk, a wrong gamma and noise. `large_photo FILE.png` has 8 bits,
// `FILE.dng` is a Bayer mosaic of 14-bit samples. Made by the tests' model of a photograph, so the right
// answer is known.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "platform/host/error.hpp"
#include "platform/host/output_file.hpp"
#include "tests/calibration/dng_writer.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace {

using namespace aluminate;
using namespace aluminate::calibration;

test::Scene scene_of(double noise) {
  test::Scene scene;
  scene.width = 6000;
  scene.height = 4000;
  scene.corners = {{{1510, 1200}, {3390, 1260}, {3360, 2420}, {1540, 2330}}};
  scene.camera = test::realistic_camera();
  scene.camera.noise = noise;
  scene.blur_px = 0.8;
  return scene;
}

void write_dng(test::Scene scene, const std::string& path) {
  constexpr int kBlack = 512, kWhite = 16383;
  scene.camera.gamma = 1.0;
  scene.camera.code_max = 65535;
  const host::ImageFloat seen = test::photograph(scene);
  std::vector<std::uint16_t> samples;
  samples.reserve(seen.texels.size() / 3);
  for (int y = 0; y < seen.height; ++y)
    for (int x = 0; x < seen.width; ++x) {
      const std::size_t channel = static_cast<std::size_t>((x & 1) + (y & 1));  // RGGB
      const std::size_t texel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(seen.width) + static_cast<std::size_t>(x);
      const double linear = srgb_to_linear(static_cast<double>(seen.texels[3 * texel + channel]));
      samples.push_back(static_cast<std::uint16_t>(std::lround(kBlack + linear * (kWhite - kBlack))));
    }
  test::DngWriter writer(seen.width, seen.height, "RGGB", std::move(samples), kBlack, kWhite,
                         {0.95, 0.80, 0.55});
  host::write_file(path, writer.file());
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    fmt::print(stderr,
               "usage: large_photo FILE.png|FILE.dng [NOISE]   (standard deviation of encoded values)\n");
    return 2;
  }
  try {
    const std::string path = arguments[1];
    const test::Scene scene = scene_of(count > 2 ? std::stod(arguments[2]) : 0.01);
    if (path.ends_with(".dng"))
      write_dng(scene, path);
    else
      test::write_photograph(scene, path);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
