// A TIFF of one uncompressed strip is its samples behind 200 bytes of header: written here, because large photographs
// should cost no more than a copy.
#include <algorithm>
#include <bit>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::host {
namespace {

enum TiffType : std::uint16_t { kShort = 3, kLong = 4 };

struct TiffEntry {
  std::uint16_t tag;
  TiffType type;
  std::uint32_t count, value;  // value: an offset when it does not fit into four bytes
};

void put(std::vector<std::uint8_t>& bytes, std::uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

}  // namespace

void write_tiff16(int width, int height, const RowOfCodes& row_of, const ByteSink& sink) {
  static_assert(std::endian::native == std::endian::little, "samples are copied as they lie in memory");
  ALU_CHECK(width > 0 && height > 0, "{} x {}", width, height);
  const std::size_t row_codes = 3 * static_cast<std::size_t>(width), size = 2 * row_codes * static_cast<std::size_t>(height);
  ALU_CHECK(size < (std::size_t{1} << 32) - 256, "{} bytes do not fit a TIFF", size);
  constexpr std::uint32_t kEntries = 10, kDirectory = 8, kBitsAt = kDirectory + 2 + 12 * kEntries + 4, kStripAt = kBitsAt + 6 + 4;
  static_assert(kStripAt % 4 == 0);
  const std::uint32_t rows = static_cast<std::uint32_t>(height), bytes_in_strip = static_cast<std::uint32_t>(size);
  const TiffEntry entries[kEntries] = {{256, kLong, 1, static_cast<std::uint32_t>(width)},
                                       {257, kLong, 1, rows},
                                       {258, kShort, 3, kBitsAt},      // bits a sample
                                       {259, kShort, 1, 1},            // not compressed
                                       {262, kShort, 1, 2},            // RGB
                                       {273, kLong, 1, kStripAt},
                                       {277, kShort, 1, 3},            // samples a pixel
                                       {278, kLong, 1, rows},
                                       {279, kLong, 1, bytes_in_strip},
                                       {284, kShort, 1, 1}};           // interleaved
  std::vector<std::uint8_t> bytes;
  for (const char c : {'I', 'I'}) bytes.push_back(static_cast<std::uint8_t>(c));
  put(bytes, 42, 2);
  put(bytes, kDirectory, 4);
  put(bytes, kEntries, 2);
  for (const TiffEntry& entry : entries) {
    put(bytes, entry.tag, 2);
    put(bytes, entry.type, 2);
    put(bytes, entry.count, 4);
    put(bytes, entry.value, 4);  // little-endian: a short stands in the first two of the four bytes
  }
  put(bytes, 0, 4);  // no further directory
  for (int i = 0; i < 3; ++i) put(bytes, 16, 2);
  put(bytes, 0, 4);
  ALU_CHECK(bytes.size() == kStripAt, "{} bytes of header", bytes.size());
  sink(bytes);

  // Some megabytes at a time: made on all threads, then passed on.
  const int rows_a_round = static_cast<int>(std::clamp<std::size_t>((std::size_t{4} << 20) / (2 * row_codes), 1, static_cast<std::size_t>(height)));
  UninitializedVector<std::uint16_t> codes(row_codes * static_cast<std::size_t>(rows_a_round));
  for (int begin = 0; begin < height; begin += rows_a_round) {
    const int count = std::min(rows_a_round, height - begin);
    parallel_for(count, [&](std::int64_t row) {
      row_of(begin + static_cast<int>(row), codes.data() + static_cast<std::size_t>(row) * row_codes);
    }, 8);
    sink({reinterpret_cast<const std::uint8_t*>(codes.data()), 2 * row_codes * static_cast<std::size_t>(count)});
  }
}

std::vector<std::uint8_t> encode_tiff16(int width, int height, std::span<const std::uint16_t> codes) {
  const std::size_t row_codes = 3 * static_cast<std::size_t>(width);
  ALU_CHECK(codes.size() == row_codes * static_cast<std::size_t>(height), "{} x {}, {} codes", width, height, codes.size());
  std::vector<std::uint8_t> all;
  write_tiff16(
      width, height,
      [&](int row, std::uint16_t* to) {
        std::copy_n(codes.data() + static_cast<std::size_t>(row) * row_codes, row_codes, to);
      },
      [&](std::span<const std::uint8_t> bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); });
  return all;
}

}  // namespace aluminate::host
