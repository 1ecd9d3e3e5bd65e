// 16-bit PNG [PNG-W3C], compressed band by band on all threads: one thread takes seconds for a large
// photograph. The only file that includes zlib. Bands have a fixed height, so the bytes are the same on any
// number of threads.
#include <zlib.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::host {
namespace {

constexpr int kBandRows = 64;
// Runs and Huffman codes: after the filter, photographs hardly shrink further, and searching costs the most
// time.
constexpr int kLevel = 1;

void put_big_endian(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

void put_chunk(std::vector<std::uint8_t>& bytes, std::string_view kind, std::span<const std::uint8_t> data) {
  put_big_endian(bytes, static_cast<std::uint32_t>(data.size()));
  const std::size_t begin = bytes.size();
  bytes.insert(bytes.end(), kind.begin(), kind.end());
  bytes.insert(bytes.end(), data.begin(), data.end());
  put_big_endian(bytes, static_cast<std::uint32_t>(::crc32_z(0, bytes.data() + begin, bytes.size() - begin)));
}

// Filter 1, Sub: each byte less the byte one pixel to the left. Samples are big-endian.
UninitializedVector<std::uint8_t> filtered(std::span<const std::uint16_t> codes, std::size_t row_codes) {
  constexpr std::size_t kPixelBytes = 6;
  UninitializedVector<std::uint8_t> bytes;
  bytes.resize(codes.size() / row_codes * (1 + row_codes * 2));
  std::uint8_t* to = bytes.data();
  for (const std::uint16_t* row = codes.data(); row != codes.data() + codes.size(); row += row_codes) {
    *to++ = 1;
    std::uint8_t* const begin = to;
    for (std::size_t i = 0; i < row_codes; ++i) {
      *to++ = static_cast<std::uint8_t>(row[i] >> 8);
      *to++ = static_cast<std::uint8_t>(row[i] & 255u);
    }
    for (std::uint8_t* at = to - 1; at >= begin + kPixelBytes; --at)
      *at = static_cast<std::uint8_t>(*at - *(at - kPixelBytes));
  }
  return bytes;
}

struct Band {
  std::vector<std::uint8_t> deflated;
  uLong adler = 0;
  std::size_t raw_bytes = 0;
};

// A piece of one deflate stream: a sync flush ends it on a byte border, so that pieces can be put one behind
// the other.
Band deflate_band(const UninitializedVector<std::uint8_t>& raw, bool is_last) {
  Band band;
  band.raw_bytes = raw.size();
  band.adler = ::adler32_z(::adler32_z(0, nullptr, 0), raw.data(), raw.size());
  z_stream stream{};
  constexpr int kRawDeflate = -15, kMemory = 9;
  ALU_CHECK(::deflateInit2(&stream, kLevel, Z_DEFLATED, kRawDeflate, kMemory, Z_RLE) == Z_OK, "zlib");
  band.deflated.resize(::deflateBound(&stream, static_cast<uLong>(raw.size())) + 16);
  stream.next_in = const_cast<Bytef*>(raw.data());
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = band.deflated.data();
  stream.avail_out = static_cast<uInt>(band.deflated.size());
  const int status = ::deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  const bool complete =
      status == (is_last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0 && stream.avail_out > 0;
  band.deflated.resize(stream.total_out);
  ::deflateEnd(&stream);
  ALU_CHECK(complete, "zlib status {}", status);
  return band;
}

}  // namespace

void write_png16(int width, int height, bool is_srgb, const RowOfCodes& row_of, const ByteSink& sink) {
  ALU_CHECK(width > 0 && height > 0, "{} x {}", width, height);
  // avail_in is 32 bits: 64 rows of the widest image are 6.3 MB.
  static_assert(std::int64_t{kBandRows} * (1 + 6 * std::int64_t{kMaxImageSidePx}) < std::int64_t{1} << 31);
  ALU_CHECK(width <= kMaxImageSidePx, "{} px wide", width);
  std::vector<std::uint8_t> bytes{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::vector<std::uint8_t> header;
  put_big_endian(header, static_cast<std::uint32_t>(width));
  put_big_endian(header, static_cast<std::uint32_t>(height));
  header.insert(header.end(), {16, 2, 0, 0, 0});  // 16 bits, RGB, deflate, adaptive filters, not interlaced
  put_chunk(bytes, "IHDR", header);
  if (is_srgb) {
    put_chunk(bytes, "sRGB", std::array<std::uint8_t, 1>{0});  // perceptual
  } else {
    put_chunk(bytes, "gAMA", std::array<std::uint8_t, 4>{0, 1, 0x86, 0xa0});  // 1.0 in units of 1/100000
  }
  sink(bytes);

  const std::size_t row_codes = 3 * static_cast<std::size_t>(width);
  const int band_count = (height + kBandRows - 1) / kBandRows;
  // A round of bands is compressed while the disk takes the one before.
  const int bands_a_round = 4 * thread_count();
  uLong adler = ::adler32_z(0, nullptr, 0);
  for (int begin = 0; begin < band_count; begin += bands_a_round) {
    std::vector<Band> bands(static_cast<std::size_t>(std::min(bands_a_round, band_count - begin)));
    parallel_for(static_cast<std::int64_t>(bands.size()), [&](std::int64_t index) {
      const int band = begin + static_cast<int>(index), first = band * kBandRows,
                rows = std::min(kBandRows, height - first);
      UninitializedVector<std::uint16_t> codes(static_cast<std::size_t>(rows) * row_codes);
      for (int row = 0; row < rows; ++row)
        row_of(first + row, codes.data() + static_cast<std::size_t>(row) * row_codes);
      bands[static_cast<std::size_t>(index)] =
          deflate_band(filtered(codes, row_codes), band + 1 == band_count);
    });
    for (std::size_t i = 0; i < bands.size(); ++i) {
      const int band = begin + static_cast<int>(i);
      adler = ::adler32_combine(adler, bands[i].adler, static_cast<z_off_t>(bands[i].raw_bytes));
      std::vector<std::uint8_t>& data = bands[i].deflated;
      if (band == 0) data.insert(data.begin(), {0x78, 0x01});  // zlib header: 32 KiB window, fastest
      if (band + 1 == band_count) put_big_endian(data, static_cast<std::uint32_t>(adler));
      bytes.clear();
      put_chunk(bytes, "IDAT", data);
      sink(bytes);
    }
  }
  bytes.clear();
  put_chunk(bytes, "IEND", {});
  sink(bytes);
}

std::vector<std::uint8_t> encode_png16(int width, int height, std::span<const std::uint16_t> codes,
                                       bool is_srgb) {
  const std::size_t row_codes = 3 * static_cast<std::size_t>(width);
  ALU_CHECK(codes.size() == row_codes * static_cast<std::size_t>(height), "{} x {}, {} codes", width, height,
            codes.size());
  std::vector<std::uint8_t> all;
  write_png16(
      width, height, is_srgb,
      [&](int row, std::uint16_t* to) {
        std::copy_n(codes.data() + static_cast<std::size_t>(row) * row_codes, row_codes, to);
      },
      [&](std::span<const std::uint8_t> bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); });
  return all;
}

}  // namespace aluminate::host
