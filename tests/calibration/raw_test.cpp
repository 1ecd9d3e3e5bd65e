// Sensor data: a DNG made here decodes to its samples; mosaics, demosaicing, damaged files.
#include "calibration/raw_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "tests/calibration/dng_writer.hpp"

namespace aluminate::calibration {
namespace {

using test::DngWriter;

std::vector<std::uint16_t> random_samples(int count, int low, int high) {
  std::mt19937 random(11);
  std::vector<std::uint16_t> samples;
  for (int i = 0; i < count; ++i)
    samples.push_back(
        static_cast<std::uint16_t>(low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1))));
  return samples;
}

TEST(Raw, DngDecodesToItsExactSamplesAndLevels) {
  const std::vector<std::uint16_t> samples = random_samples(96 * 64, 256, 60000);
  for (const char* pattern : {"RGGB", "BGGR", "GRBG", "GBRG"}) {
    const std::vector<std::uint8_t> file =
        DngWriter(96, 64, pattern, samples, 256, 60000, {0.5, 1.0, 0.8}).file();
    const Mosaic mosaic = decode_raw(file, "test.dng");
    ASSERT_EQ(mosaic.width, 96);
    ASSERT_EQ(mosaic.height, 64);
    EXPECT_TRUE(std::ranges::equal(mosaic.samples, samples));
    EXPECT_EQ(std::string_view(mosaic.pattern.data(), 4), pattern);
    EXPECT_EQ(mosaic.white, 60000.0);
    for (const double black : mosaic.black) EXPECT_EQ(black, 256.0) << pattern;
    EXPECT_NEAR(mosaic.multipliers[0], 2.0, 1e-5);  // 1/0.5 over 1/1; LibRaw keeps floats
    EXPECT_NEAR(mosaic.multipliers[2], 1.25, 1e-5);
  }
}

TEST(Raw, BlackAndWhiteBecomeZeroAndOneTimesTheMultiplier) {
  Mosaic mosaic;
  mosaic.width = mosaic.height = 8;
  mosaic.black = {100, 110, 120};
  mosaic.white = 1000;
  mosaic.multipliers = {2.0, 1.0, 1.5};
  for (const double level : {0.0, 0.25, 1.0}) {
    mosaic.samples.clear();
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const std::size_t c = y % 2 == 0 ? (x % 2 == 0 ? 0 : 1) : (x % 2 == 0 ? 1 : 2);
        mosaic.samples.push_back(
            static_cast<std::uint16_t>(std::lround(mosaic.black[c] + level * (1000 - mosaic.black[c]))));
      }
    const Photo photo = demosaic(mosaic, "test");
    const double step = 1.0 / 880.0;  // rounding of a sample
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        EXPECT_NEAR(photo.pixel(x, y)[0], 2.0 * level, 2.0 * step);
        EXPECT_NEAR(photo.pixel(x, y)[1], level, step);
        EXPECT_NEAR(photo.pixel(x, y)[2], 1.5 * level, 2.0 * step);
      }
  }
}

TEST(Raw, DemosaicKeepsEverySampleAndIsExactOnRamps) {
  for (const char* pattern : {"RGGB", "BGGR", "GRBG", "GBRG"}) {
    Mosaic mosaic;
    mosaic.width = 24;
    mosaic.height = 20;
    std::copy_n(pattern, 4, mosaic.pattern.begin());
    const auto ramp = [](std::size_t c, int x, int y) {
      return 1000.0 * (static_cast<double>(c) + 1.0) + 40.0 * x + 30.0 * y;
    };
    const auto colour = [&](int x, int y) {
      return std::string_view("RGB").find(pattern[(y & 1) * 2 + (x & 1)]);
    };
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 24; ++x)
        mosaic.samples.push_back(static_cast<std::uint16_t>(ramp(colour(x, y), x, y)));
    const Photo photo = demosaic(mosaic, "test");
    for (int y = 2; y < 18; ++y)
      for (int x = 2; x < 22; ++x)
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(photo.pixel(x, y)[c] * 65535.0, ramp(c, x, y), 0.01)
              << pattern << ' ' << x << ',' << y;  // float: 6e-8 * 4000
  }
}

TEST(Raw, GreyPictureBecomesItsCodes) {
  host::ImageFloat image;
  image.width = 4;
  image.height = 2;
  image.channels = {"Y"};
  image.stored = host::StoredAs::Unorm16;
  const std::vector<std::uint16_t> codes{0, 1, 255, 256, 32767, 32768, 65534, 65535};
  for (const std::uint16_t code : codes) image.texels.push_back(static_cast<float>(code) / 65535.0f);
  EXPECT_TRUE(std::ranges::equal(mosaic_of_grey(image, "GBRG", "x").samples, codes));
  EXPECT_THROW(mosaic_of_grey(image, "RGBG", "x"), UserError);
  image.channels = {"R", "G", "B"};
  EXPECT_THROW(mosaic_of_grey(image, "RGGB", "x"), UserError);
}

TEST(Raw, DamagedFilesAreErrorsThatNameTheFile) {
  const std::vector<std::uint8_t> good =
      DngWriter(96, 64, "RGGB", random_samples(96 * 64, 0, 65535), 0, 65535, {1, 1, 1}).file();
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{4}, std::size_t{100}, good.size() / 2, good.size() - 5000}) {
    try {
      decode_raw(std::span(good).first(size), "broken.dng");
      ADD_FAILURE() << size << " bytes of " << good.size() << " were accepted";
    } catch (const UserError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("broken.dng"));
    }
  }
  std::mt19937 random(5);
  for (int trial = 0; trial < 200;
       ++trial) {  // must not crash; may be read when the damage is in the samples
    std::vector<std::uint8_t> bad = good;
    for (int i = 0; i < 4; ++i) bad[random() % 400] = static_cast<std::uint8_t>(random());
    try {
      decode_raw(bad, "broken.dng");
    } catch (const UserError&) {
    }
  }
}

TEST(Raw, PublicDngHoldsThePublicMosaic) {
  const std::string folder = std::string(ALUMINATE_SHARED_DIR) + "/colorchecker/";
  const std::string dng = folder + "mosaic_gbrg_black0.dng",
                    tif = folder + "bllanos_d2_colorChecker30cm_raw01.tif";
  if (!std::filesystem::exists(dng) || !std::filesystem::exists(tif))
    GTEST_SKIP() << "no public photographs at " << folder;
  const Mosaic raw = decode_raw(host::read_bytes(dng), dng),
               grey = mosaic_of_grey(host::read_image(tif), "GBRG", tif);
  ASSERT_EQ(raw.samples.size(), grey.samples.size());
  EXPECT_EQ(raw.pattern, grey.pattern);
  for (std::size_t i = 0; i < raw.samples.size(); ++i) ASSERT_EQ(raw.samples[i], grey.samples[i] * 257u) << i;
}

}  // namespace
}  // namespace aluminate::calibration
