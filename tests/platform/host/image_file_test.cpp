// Round trips: what is written comes back, exactly, and the same input gives the same bytes.
#include "platform/host/image_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "platform/host/color_map.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/parallel.hpp"
#include "tests/platform/host/temporary_folder.hpp"

namespace aluminate::host {
namespace {

Image8 test_image(int width, int height, int channels) {
  Image8 image{width, height, channels, {}};
  for (int i = 0; i < width * height * channels; ++i) image.texels.push_back(static_cast<std::uint8_t>(i * 37 + i / 7));
  return image;
}

TEST(Png, RgbaComesBackEvenUnderZeroAlpha) {
  const Image8 image = test_image(13, 7, 4);  // alpha takes every kind of value, colour stays as it is
  const Image8 back = decode_rgba8(encode_png(image), "test.png");
  EXPECT_EQ(back.width, 13);
  EXPECT_EQ(back.height, 7);
  EXPECT_EQ(back.texels, image.texels);
}

TEST(Png, RgbGetsOpaqueAlpha) {
  const Image8 image = test_image(5, 3, 3);
  const Image8 back = decode_rgba8(encode_png(image), "test.png");
  for (std::size_t i = 0; i < 15; ++i) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(back.texels[i * 4 + c], image.texels[i * 3 + c]);
    EXPECT_EQ(back.texels[i * 4 + 3], 255);
  }
}

TEST(Png, FloatReadingKeepsCodes) {
  Image8 image{256, 1, 3, {}};
  for (int i = 0; i < 256; ++i) image.texels.insert(image.texels.end(), 3, static_cast<std::uint8_t>(i));
  const ImageFloat back = decode_float(encode_png(image), "test.png");
  EXPECT_EQ(back.stored, StoredAs::Unorm8);
  EXPECT_EQ(back.channels, (std::vector<std::string>{"R", "G", "B"}));
  for (std::size_t i = 0; i < image.texels.size(); ++i) {
    EXPECT_EQ(back.texels[i], static_cast<float>(image.texels[i]) / 255.0f);
  }
}

TEST(Png, SameInputSameBytes) {
  const Image8 image = test_image(40, 30, 4);
  const ImageMetadata metadata{{"Title", "cost"}};
  EXPECT_EQ(encode_png(image, metadata), encode_png(image, metadata));
}

// Header text that would make two runs or two machines differ.
void expect_timeless(const std::vector<std::uint8_t>& bytes) {
  const std::string text(bytes.begin(), bytes.end());
  for (const char* varying : {"OpenImageIO", "DateTime", "tIME", "Software", "HostComputer"}) {
    EXPECT_EQ(text.find(varying), std::string::npos) << varying;
  }
  // The EXR writer insists on a date; it must be the fixed one.
  const std::size_t date = text.find("capDate");
  EXPECT_TRUE(date == std::string::npos || text.find("1970:01:01 00:00:00", date) != std::string::npos);
}

TEST(Png, CarriesNoDateAndNoSoftware) { expect_timeless(encode_png(test_image(4, 4, 3))); }

TEST(Png, NoiseThatDoesNotShrinkComesBack) {
  constexpr int kWidth = 701, kHeight = 131;  // two bands and a piece
  std::vector<std::uint16_t> codes(3 * kWidth * kHeight);
  std::uint32_t state = 7;
  for (std::uint16_t& code : codes) {
    state = state * 1664525u + 1013904223u;
    code = static_cast<std::uint16_t>(state >> 16);
  }
  const auto back = std::get<ImageCodes>(decode_stored(encode_png16(kWidth, kHeight, codes, true), "noise.png"));
  ASSERT_EQ(back.bytes.size(), 2 * codes.size());
  EXPECT_EQ(std::memcmp(back.bytes.data(), codes.data(), back.bytes.size()), 0);
  const Image8 picture = test_image(300, 200, 4);
  EXPECT_EQ(decode_rgba8(encode_png(picture), "picture.png").texels, picture.texels);
}

TEST(Png, MetadataIsThereAsText) {
  const auto bytes = encode_png(test_image(4, 4, 3), {{"aluminate:command", "render \xC3\xA4.glb"}});
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_NE(text.find("iTXt" + std::string("aluminate:command\0\0\0\0\0", 22) + "render \xC3\xA4.glb"), std::string::npos);
}

TEST(Png, PalettesTransparencyAndFewBitsBecomeCodes) {
  const auto sample = [](const char* name) {
    return decode_float(read_bytes(std::string(ALUMINATE_SOURCE_DIR "/tests/platform/host/samples/") + name), name);
  };
  EXPECT_EQ(sample("grey.png").channels, (std::vector<std::string>{"Y"}));
  EXPECT_EQ(sample("grey_alpha.png").channels, (std::vector<std::string>{"Y", "A"}));
  // Two pixels of a palette of two colours, one bit each, the second half transparent.
  const Image8 colours = decode_rgba8(read_bytes(ALUMINATE_SOURCE_DIR "/tests/platform/host/samples/palette.png"), "palette.png");
  EXPECT_EQ(colours.texels, (std::vector<std::uint8_t>{10, 20, 30, 255, 40, 50, 60, 128}));
}

std::vector<std::uint8_t> with_exif(const std::vector<std::uint8_t>& jpeg, const std::vector<std::uint8_t>& tiff) {
  std::vector<std::uint8_t> block{0xff, 0xe1, 0, static_cast<std::uint8_t>(2 + 6 + tiff.size()), 'E', 'x', 'i', 'f', 0, 0};
  block.insert(block.end(), tiff.begin(), tiff.end());
  std::vector<std::uint8_t> out = jpeg;
  out.insert(out.begin() + 2, block.begin(), block.end());
  return out;
}

TEST(Jpeg, OrientationIsReadFromExifOfEitherByteOrder) {
  const auto jpeg = read_bytes(ALUMINATE_SOURCE_DIR "/tests/platform/host/samples/sample.jpg");
  const std::vector<std::uint8_t> big{'M', 'M', 0, 42, 0, 0, 0, 8, 0, 1, 0x01, 0x12, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0};
  const std::vector<std::uint8_t> little{'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 0x12, 0x01, 3, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_EQ(decode_float(jpeg, "a.jpg").orientation, 1);
  EXPECT_EQ(decode_float(with_exif(jpeg, big), "a.jpg").orientation, 6);
  EXPECT_EQ(decode_float(with_exif(jpeg, little), "a.jpg").orientation, 3);
  for (std::size_t length = 0; length < 18; ++length)  // damaged: upright, and the picture as it was
    EXPECT_EQ(decode_float(with_exif(jpeg, {big.begin(), big.begin() + static_cast<std::ptrdiff_t>(length)}), "a.jpg").orientation, 1);
  std::vector<std::uint8_t> far = big;
  far[4] = far[5] = far[6] = far[7] = 0xff;
  EXPECT_EQ(decode_float(with_exif(jpeg, far), "a.jpg").orientation, 1);
}

struct Layers {
  std::vector<float> red{0.0f, -1.5f, 1e30f, std::numeric_limits<float>::denorm_min(), 0.1f, 65504.0f};
  std::vector<float> depth{1.0f, 0.999999f, 1e-20f, std::numeric_limits<float>::infinity(), 0.3f, 2.0f};
  std::vector<float> words{0, 1, 2, 1024, 16777216.0f, 12};
  std::vector<std::uint32_t> path{0, 1, 0x1000000, 7, 0xffff00, 3};  // below 2^24, and 2^24: exact as float
  std::vector<ExrLayer> list() const {
    return {{"cost.alu_words", words}, {"depth.Z", depth}, {"R", red}, {"cost.path", path}, {"B", red, true},
            {"G", depth, true}};
  }
};

std::vector<float> plane(const ImageFloat& image, const std::string& name) {
  const int channel = image.channel(name);
  EXPECT_GE(channel, 0) << name;
  std::vector<float> values;
  for (std::size_t i = static_cast<std::size_t>(std::max(channel, 0)); i < image.texels.size(); i += image.channels.size()) {
    values.push_back(image.texels[i]);
  }
  return values;
}

TEST(Exr, LayersKeepNamesAndValues) {
  const Layers layers;
  const ImageFloat back = decode_float(encode_exr(3, 2, layers.list()), "test.exr");
  EXPECT_EQ(back.stored, StoredAs::Float);
  EXPECT_EQ(back.channels, (std::vector<std::string>{"R", "G", "B", "cost.alu_words", "cost.path", "depth.Z"}));
  EXPECT_EQ(plane(back, "R"), layers.red);
  EXPECT_EQ(plane(back, "depth.Z"), layers.depth);
  EXPECT_EQ(plane(back, "cost.alu_words"), layers.words);
  EXPECT_EQ(plane(back, "cost.path"), std::vector<float>(layers.path.begin(), layers.path.end()));
  EXPECT_EQ(back.channel("cost.none"), -1);
}

TEST(Exr, HalvesAreRoundedToNearestEven) {
  const std::vector<float> values{1.0f + 0x1p-11f, 1.0f + 3 * 0x1p-11f, 0x1p-25f, 65519.0f, 65520.0f, -0.0f};
  const std::vector<ExrLayer> layers{{"Y", values, true}};
  const ImageFloat back = decode_float(encode_exr(6, 1, layers), "test.exr");
  EXPECT_EQ(back.texels, (std::vector<float>{1.0f, 1.0f + 0x1p-9f, 0.0f, 65504.0f,
                                             std::numeric_limits<float>::infinity(), -0.0f}));
}

TEST(Exr, SameInputSameBytesAndNothingThatVaries) {
  const Layers layers;
  const ImageMetadata metadata{{"aluminate.command", "render a.glb"}, {"aluminate.scene", "0123abcd"}};
  const auto bytes = encode_exr(3, 2, layers.list(), metadata);
  EXPECT_EQ(bytes, encode_exr(3, 2, layers.list(), metadata));
  expect_timeless(bytes);
  const std::string text(bytes.begin(), bytes.end());
  EXPECT_NE(text.find("aluminate.command"), std::string::npos);
  EXPECT_NE(text.find("render a.glb"), std::string::npos);
}

TEST(Exr, RowsBeyondOneBlockStayInOrder) {
  const int width = 3, height = 200;
  std::vector<float> values;
  for (int i = 0; i < width * height; ++i) values.push_back(static_cast<float>(i));
  const ImageFloat back = decode_float(encode_exr(width, height, std::vector<ExrLayer>{{"Z", values}}), "test.exr");
  EXPECT_EQ(back.height, height);
  EXPECT_EQ(back.texels, values);
}

TEST(Exr, WrongLayersAreBugs) {
  const std::vector<float> two(2), three(3);
  EXPECT_THROW(encode_exr(2, 1, std::vector<ExrLayer>{{"R", three}}), InternalError);
  EXPECT_THROW(encode_exr(2, 1, std::vector<ExrLayer>{{"R", two}, {"R", two}}), InternalError);
  EXPECT_THROW(encode_exr(2, 1, std::vector<ExrLayer>{{"", two}}), InternalError);
  EXPECT_THROW(encode_exr(2, 1, std::vector<ExrLayer>{}), InternalError);
}

TEST(ImageFile, WritesAndReadsByPath) {
  const TemporaryFolder folder;
  const Image8 image = test_image(9, 9, 4);
  write_png(folder.path("a.png"), image);
  const Layers layers;
  write_exr(folder.path("a.exr"), 3, 2, layers.list());
  EXPECT_EQ(read_image_rgba8(folder.path("a.png")).texels, image.texels);
  EXPECT_EQ(plane(read_image(folder.path("a.exr")), "R"), layers.red);
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"a.exr", "a.png"}));
}

TEST(ImageFile, DecodesFromManyThreadsAtOnce) {
  const auto png = encode_png(test_image(64, 64, 4));
  const Layers layers;
  const auto exr = encode_exr(3, 2, layers.list());
  const Image8 expected = decode_rgba8(png, "test.png");
  const ImageFloat expected_float = decode_float(exr, "test.exr");
  set_thread_count(8);
  std::vector<int> wrong(200);
  parallel_for(200, [&](std::int64_t index) {
    int& bad = wrong[static_cast<std::size_t>(index)];
    if (index % 2 == 0) bad = decode_rgba8(png, "test.png").texels != expected.texels;
    if (index % 2 == 1) bad = decode_float(exr, "test.exr").texels != expected_float.texels;
    bad += encode_exr(3, 2, layers.list()) != exr;
  });
  set_thread_count(0);
  EXPECT_EQ(wrong, std::vector<int>(200));
}

TEST(DrawText, ChangesPixelsOnlyInsideItsBox) {
  if (!text_available()) GTEST_SKIP() << "no font file";
  Image8 image{200, 40, 3, std::vector<std::uint8_t>(200 * 40 * 3, 10)};
  draw_text(image, 20, 30, "alu 12", 20, {250, 10, 10});
  const int width = text_width("alu 12", 20);
  EXPECT_GT(width, 30);
  EXPECT_LT(width, 120);
  int changed = 0, outside = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 200; ++x) {
      const std::uint8_t* texel = image.texels.data() + (y * 200 + x) * 3;
      EXPECT_EQ(texel[1], 10);  // the colour differs from the ground in red alone
      if (texel[0] == 10) continue;
      ++changed;
      if (x < 18 || x > 22 + width || y < 8 || y > 36) ++outside;
    }
  }
  EXPECT_GT(changed, 100);
  EXPECT_EQ(outside, 0);
}

TEST(DrawText, IsClippedToTheImage) {
  Image8 image{8, 8, 3, std::vector<std::uint8_t>(8 * 8 * 3, 0)};
  draw_text(image, -30, 4, "wide text", 20, {255, 255, 255});
  draw_text(image, 5, 500, "below", 20, {255, 255, 255});
  draw_text(image, 0, 0, "", 20, {255, 255, 255});
  EXPECT_EQ(image.texels.size(), 8u * 8u * 3u);
}

TEST(TextWidth, GrowsWithTextAndSize) {
  if (!text_available()) GTEST_SKIP() << "no font file";
  EXPECT_EQ(text_width("", 20), 0);
  EXPECT_LT(text_width("alu", 20), text_width("alu words", 20));
  EXPECT_LT(text_width("alu", 10), text_width("alu", 20));
}

TEST(Viridis, EndsAndMiddle) {
  EXPECT_EQ(viridis(std::uint8_t{0}), (Rgb8{0x44, 0x01, 0x54}));
  EXPECT_EQ(viridis(std::uint8_t{128}), (Rgb8{0x21, 0x91, 0x8c}));
  EXPECT_EQ(viridis(std::uint8_t{255}), (Rgb8{0xfd, 0xe7, 0x25}));
}

TEST(Viridis, LumaGrows) {
  // Integer luma weights; lightness rises evenly, and eight entries are more than what rounding to 8 bits hides.
  const auto luma = [](int index) {
    const Rgb8 colour = viridis(static_cast<std::uint8_t>(index));
    return 2126 * colour.r + 7152 * colour.g + 722 * colour.b;
  };
  for (int i = 8; i < 256; ++i) EXPECT_GT(luma(i), luma(i - 8)) << i;
}

TEST(Viridis, ScalesAnyRange) {
  EXPECT_EQ(viridis(0, 0), viridis(std::uint8_t{0}));
  EXPECT_EQ(viridis(9, 9), viridis(std::uint8_t{255}));
  EXPECT_EQ(viridis(20, 9), viridis(std::uint8_t{255}));
  EXPECT_EQ(viridis(1, 2), viridis(std::uint8_t{128}));
  const std::uint64_t huge = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(viridis(huge, huge), viridis(std::uint8_t{255}));
  EXPECT_EQ(viridis(huge / 2, huge), viridis(std::uint8_t{127}));
}

}  // namespace
}  // namespace aluminate::host
