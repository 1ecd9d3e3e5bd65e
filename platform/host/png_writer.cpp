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
// Runs and Huffman codes: after the filter, photographs hardly shrink further, and searching costs the most time.
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
std::vector<std::uint8_t> filtered(std::span<const std::uint16_t> codes, std::size_t row_codes) {
  constexpr std::size_t kPixelBytes = 6;
  std::vector<std::uint8_t> bytes;
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
Band deflate_band(const std::vector<std::uint8_t>& raw, bool is_last) {
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

std::vector<std::uint8_t> encode_png16(int width, int height, std::span<const std::uint16_t> codes,
                                       bool is_srgb) {
  ALU_CHECK(width > 0 && height > 0 &&
                codes.size() == 3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
            "{} x {}, {} codes", width, height, codes.size());
  // avail_in is 32 bits: 64 rows of the widest image are 6.3 MB.
  static_assert(std::int64_t{kBandRows} * (1 + 6 * std::int64_t{kMaxImageSidePx}) < std::int64_t{1} << 31);
  ALU_CHECK(width <= kMaxImageSidePx, "{} px wide", width);
  const std::size_t row_codes = 3 * static_cast<std::size_t>(width);
  const int band_count = (height + kBandRows - 1) / kBandRows;
  std::vector<Band> bands(static_cast<std::size_t>(band_count));
  parallel_for(band_count, [&](std::int64_t index) {
    const std::size_t first = static_cast<std::size_t>(index) * kBandRows * row_codes;
    const std::size_t count = std::min(kBandRows * row_codes, codes.size() - first);
    bands[static_cast<std::size_t>(index)] =
        deflate_band(filtered(codes.subspan(first, count), row_codes), index + 1 == band_count);
  });

  std::vector<std::uint8_t> bytes{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::size_t total = 200;
  for (const Band& band : bands) total += band.deflated.size() + 12;
  bytes.reserve(total);
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
  uLong adler = ::adler32_z(0, nullptr, 0);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    adler = ::adler32_combine(adler, bands[i].adler, static_cast<z_off_t>(bands[i].raw_bytes));
    if (i == 0)
      bands[i].deflated.insert(bands[i].deflated.begin(),
                               {0x78, 0x01});  // zlib header: 32 KiB window, fastest
    if (i + 1 == bands.size()) put_big_endian(bands[i].deflated, static_cast<std::uint32_t>(adler));
    put_chunk(bytes, "IDAT", bands[i].deflated);
    bands[i].deflated = {};
  }
  put_chunk(bytes, "IEND", {});
  return bytes;
}

}  // namespace aluminate::host
