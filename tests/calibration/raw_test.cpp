// Sensor data: a DNG made here decodes to its samples; mosaics, demosaicing, damaged files.
#include "calibration/raw_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <random>

#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"

namespace aluminate::calibration {
namespace {

// A minimal DNG: one uncompressed 16-bit strip, little-endian.
class DngWriter {
 public:
  DngWriter(int width, int height, std::string pattern, std::vector<std::uint16_t> samples, int black,
            int white, std::array<double, 3> neutral)
      : samples_(std::move(samples)) {
    static constexpr std::string_view kNames = "RGB";
    std::vector<std::uint8_t> cfa;
    for (const char name : pattern) cfa.push_back(static_cast<std::uint8_t>(kNames.find(name)));
    longs(254, {0});
    longs(256, {static_cast<std::uint32_t>(width)});
    longs(257, {static_cast<std::uint32_t>(height)});
    shorts(258, {16});
    shorts(259, {1});
    shorts(262, {32803});
    text(271, "Test");
    text(272, "Mosaic");
    longs(273, {0});  // where the strip is: filled in below
    shorts(274, {1});
    shorts(277, {1});
    longs(278, {static_cast<std::uint32_t>(height)});
    longs(279, {static_cast<std::uint32_t>(samples_.size() * 2)});
    shorts(33421, {2, 2});
    bytes(33422, cfa);
    bytes(50706, {1, 4, 0, 0});
    text(50708, "Test Mosaic");
    longs(50714, {static_cast<std::uint32_t>(black)});
    longs(50717, {static_cast<std::uint32_t>(white)});
    rationals(50721, 10,
              {3.2404542, -1.5371385, -0.4985314, -0.9692660, 1.8760108, 0.0415560, 0.0556434, -0.2040259,
               1.0572252});
    rationals(50728, 5, {neutral[0], neutral[1], neutral[2]});
    shorts(50778, {21});
  }

  std::vector<std::uint8_t> file() {
    const std::size_t directory = 8, end_of_directory = directory + 2 + 12 * entries_.size() + 4;
    std::size_t data_at = end_of_directory;
    for (const Entry& entry : entries_)
      data_at += entry.data.size() > 4 ? entry.data.size() + (entry.data.size() & 1) : 0;
    const std::size_t strip_at = data_at;
    std::vector<std::uint8_t> out{'I', 'I', 42, 0, 8, 0, 0, 0};
    put(out, entries_.size(), 2);
    std::vector<std::uint8_t> extra;
    for (Entry& entry : entries_) {
      if (entry.tag == 273) entry.data = number(strip_at, 4);
      put(out, entry.tag, 2);
      put(out, entry.type, 2);
      put(out, entry.count, 4);
      if (entry.data.size() > 4) {
        put(out, end_of_directory + extra.size(), 4);
        extra.insert(extra.end(), entry.data.begin(), entry.data.end());
        if (extra.size() & 1) extra.push_back(0);
      } else {
        std::vector<std::uint8_t> value = entry.data;
        value.resize(4);
        out.insert(out.end(), value.begin(), value.end());
      }
    }
    put(out, 0, 4);
    out.insert(out.end(), extra.begin(), extra.end());
    for (const std::uint16_t sample : samples_) put(out, sample, 2);
    return out;
  }

 private:
  struct Entry {
    std::size_t tag, type, count;
    std::vector<std::uint8_t> data;
  };
  static void put(std::vector<std::uint8_t>& out, std::size_t value, int size) {
    for (int i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  static std::vector<std::uint8_t> number(std::size_t value, int size) {
    std::vector<std::uint8_t> out;
    put(out, value, size);
    return out;
  }
  void bytes(std::size_t tag, const std::vector<std::uint8_t>& values) {
    entries_.push_back({tag, 1, values.size(), values});
  }
  void text(std::size_t tag, const std::string& value) {
    std::vector<std::uint8_t> data(value.begin(), value.end());
    data.push_back(0);
    entries_.push_back({tag, 2, data.size(), data});
  }
  void shorts(std::size_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> data;
    for (const std::uint32_t value : values) put(data, value, 2);
    entries_.push_back({tag, 3, values.size(), data});
  }
  void longs(std::size_t tag, const std::vector<std::uint32_t>& values) {
    std::vector<std::uint8_t> data;
    for (const std::uint32_t value : values) put(data, value, 4);
    entries_.push_back({tag, 4, values.size(), data});
  }
  void rationals(std::size_t tag, std::size_t type, const std::vector<double>& values) {
    std::vector<std::uint8_t> data;
    for (const double value : values) {
      put(data, static_cast<std::size_t>(static_cast<std::int64_t>(std::lround(value * 1000000.0))), 4);
      put(data, 1000000, 4);
    }
    entries_.push_back({tag, type, values.size(), data});
  }
  std::vector<Entry> entries_;
  std::vector<std::uint16_t> samples_;
};

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
    EXPECT_EQ(mosaic.samples, samples);
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
  EXPECT_EQ(mosaic_of_grey(image, "GBRG", "x").samples, codes);
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
