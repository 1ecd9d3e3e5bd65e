// Bytes that are no good image: each is a UserError that names the image, none a crash, a hang or a half picture.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/image_signature.hpp"
#include "tests/platform/host/sample_images.hpp"

namespace aluminate::host {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string refusal(const Bytes& bytes, const std::string& name) {
  try {
    decode_float(bytes, name);
  } catch (const UserError& error) {
    EXPECT_EQ(error.place().file, name);
    return error.what();
  }
  return "";
}

TEST(HostileImage, SamplesAreGood) {
  for (const auto& [name, bytes] : sample_images()) EXPECT_EQ(refusal(bytes, name), "") << name;
}

TEST(HostileImage, TruncationIsNeverSilent) {
  for (const auto& [name, bytes] : sample_images()) {
    // A TGA is whole after header and texels; what follows describes the program that wrote it.
    const std::size_t needed = name.ends_with(".tga") ? 18 + 16 * 12 * 3 : bytes.size();
    for (std::size_t length = 0; length < needed; ++length) {
      const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
      EXPECT_NE(refusal(cut, name), "") << name << " cut to " << length << " of " << bytes.size();
    }
  }
}

TEST(HostileImage, FlippedBytesNeverCrash) {
  for (const auto& [name, bytes] : sample_images()) {
    // A fixed linear congruential sequence: the same damage on every run.
    std::uint32_t state = 12345;
    for (int round = 0; round < 300; ++round) {
      Bytes damaged = bytes;
      for (int i = 0; i < 1 + round % 4; ++i) {
        state = state * 1664525u + 1013904223u;
        damaged[(state >> 8) % damaged.size()] ^= static_cast<std::uint8_t>(1u << (state >> 29));
      }
      try {
        const ImageFloat image = decode_float(damaged, name);
        EXPECT_EQ(image.texels.size(), static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                                           image.channels.size());
      } catch (const UserError&) {
      }
    }
  }
}

TEST(HostileImage, OtherDataIsNoImage) {
  for (const std::string text : {"", "x", "<svg xmlns='http://www.w3.org/2000/svg'/>", "DDS |", "BM"}) {
    EXPECT_NE(refusal(Bytes(text.begin(), text.end()), "picture"), "") << text;
  }
}

// A PNG of the given size in its header; the decoder never gets to the missing data.
Bytes png_header(std::uint32_t width, std::uint32_t height) {
  Bytes bytes{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13};
  Bytes chunk{'I', 'H', 'D', 'R'};
  for (const std::uint32_t value : {width, height}) {
    for (int shift = 24; shift >= 0; shift -= 8) chunk.push_back(static_cast<std::uint8_t>(value >> shift));
  }
  chunk.insert(chunk.end(), {8, 6, 0, 0, 0});
  std::uint32_t crc = 0xffffffffu;  // CRC-32 as PNG defines it
  for (const std::uint8_t byte : chunk) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  crc = ~crc;
  bytes.insert(bytes.end(), chunk.begin(), chunk.end());
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(crc >> shift));
  bytes.insert(bytes.end(), {0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e});
  bytes.insert(bytes.end(), {0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82});
  return bytes;
}

TEST(HostileImage, HugeSizesAreRefusedFromTheHeader) {
  EXPECT_NE(refusal(png_header(16385, 1), "wide.png").find("16385 x 1"), std::string::npos);
  EXPECT_NE(refusal(png_header(1, 16385), "tall.png").find("limit is 16384"), std::string::npos);
  EXPECT_NE(refusal(png_header(1000000, 1000000), "huge.png"), "");
  EXPECT_NE(refusal(png_header(0, 4), "empty.png"), "");
  // At the limit the size itself is accepted; the data is then missing.
  EXPECT_EQ(refusal(png_header(16384, 2), "long.png").find("limit is 16384"), std::string::npos);
}

TEST(HostileImage, FloatImagesAreNoTextures) {
  EXPECT_THROW(decode_rgba8(sample_images().at("sample.exr"), "sample.exr"), UserError);
}

TEST(ImageSignature, ContentDecidesNotTheName) {
  for (const auto& [name, bytes] : sample_images()) {
    if (name.ends_with(".tga")) continue;
    EXPECT_STREQ(image_format(bytes, "wrong.tga"), image_format(bytes, name)) << name;
  }
}

TEST(JpegEnd, AThumbnailsEndIsNotTheImages) {
  // Start, an APP1 segment that holds an end marker, a scan header without data.
  const Bytes jpeg{0xff, 0xd8, 0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, 0xd9, 0xff, 0xda, 0, 2, 0x12, 0xff, 0x00};
  EXPECT_TRUE(is_cut_off(jpeg, "jpeg"));
  Bytes whole = jpeg;
  whole.insert(whole.end(), {0xff, 0xff, 0xd9});
  EXPECT_FALSE(is_cut_off(whole, "jpeg"));
}

}  // namespace
}  // namespace aluminate::host
