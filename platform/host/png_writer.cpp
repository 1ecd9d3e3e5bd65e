// PNG [PNG-W3C] of 8 and 16 bits, compressed band by band on all threads: one thread takes seconds for a large
// photograph. ISA-L compresses and checks, in a third of zlib's time; zlib is here because it can join the
// checksums of bands. Bands have a fixed height, so the bytes are the same on any number of threads.
#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::host {
namespace {

using Bytes = UninitializedVector<std::uint8_t>;

constexpr int kBandRows = 64;
// Short searches and Huffman codes of the band's own: after the filter, photographs hardly shrink further.
constexpr int kLevel = 1;

void put_big_endian(Bytes& bytes, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// Length and kind before the data, a checksum of kind and data behind it.
constexpr std::size_t kChunkHead = 8;

void begin_chunk(Bytes& bytes, std::string_view kind) {
  put_big_endian(bytes, 0);
  bytes.insert(bytes.end(), kind.begin(), kind.end());
}

// begin: where begin_chunk() began.
void end_chunk(Bytes& bytes, std::size_t begin) {
  const std::size_t size = bytes.size() - begin - kChunkHead;
  for (std::size_t i = 0; i < 4; ++i) bytes[begin + i] = static_cast<std::uint8_t>(size >> (24 - 8 * i));
  put_big_endian(bytes, ::crc32_gzip_refl(0, bytes.data() + begin + 4, size + 4));
}

void put_chunk(Bytes& bytes, std::string_view kind, std::span<const std::uint8_t> data) {
  const std::size_t begin = bytes.size();
  begin_chunk(bytes, kind);
  bytes.insert(bytes.end(), data.begin(), data.end());
  end_chunk(bytes, begin);
}

// Rows as they lie in the file, big-endian, to rows behind filter 1, Sub: each byte less the one a pixel to the left.
void filter(const Bytes& rows, std::size_t row_bytes, std::size_t pixel_bytes, Bytes& out) {
  out.resize(rows.size() / row_bytes * (1 + row_bytes));
  std::uint8_t* __restrict to = out.data();
  for (const std::uint8_t* row = rows.data(); row != rows.data() + rows.size(); row += row_bytes) {
    *to++ = 1;
    for (std::size_t i = 0; i < pixel_bytes; ++i) *to++ = row[i];
    for (std::size_t i = pixel_bytes; i < row_bytes; ++i) *to++ = static_cast<std::uint8_t>(row[i] - row[i - pixel_bytes]);
  }
}

// One band after the other uses the same memory: fresh pages take as long to get as the data to compress.
struct Band {
  Bytes rows, filtered, chunk;  // chunk: a whole IDAT
  Bytes work = Bytes(ISAL_DEF_LVL1_DEFAULT);
  std::uint32_t adler = 1;  // of `filtered`
};

// A piece of one deflate stream: a sync flush ends it on a byte border, so that pieces can be put one behind
// the other.
void deflate_band(Band& band, bool is_first, bool is_last) {
  const Bytes& raw = band.filtered;
  band.adler = ::isal_adler32(1, raw.data(), raw.size());
  band.chunk.clear();
  begin_chunk(band.chunk, "IDAT");
  if (is_first) band.chunk.insert(band.chunk.end(), {0x78, 0x01});  // zlib header: 32 KiB window, fastest
  const std::size_t begin = band.chunk.size();
  isal_zstream stream;
  ::isal_deflate_init(&stream);  // a raw stream, without zlib's or gzip's frame
  stream.level = kLevel;
  stream.level_buf = band.work.data();
  stream.level_buf_size = ISAL_DEF_LVL1_DEFAULT;
  stream.end_of_stream = is_last;
  stream.flush = is_last ? NO_FLUSH : SYNC_FLUSH;
  // Data that does not shrink is stored in blocks of at most 65535 bytes with five of their own.
  band.chunk.resize(begin + raw.size() + raw.size() / 1000 + 1024);
  stream.next_in = const_cast<std::uint8_t*>(raw.data());
  stream.avail_in = static_cast<std::uint32_t>(raw.size());
  stream.next_out = band.chunk.data() + begin;
  stream.avail_out = static_cast<std::uint32_t>(band.chunk.size() - begin);
  const int status = ::isal_deflate(&stream);
  ALU_CHECK(status == COMP_OK && stream.avail_in == 0 && stream.avail_out > 0, "status {}, {} and {} bytes left", status,
            stream.avail_in, stream.avail_out);
  band.chunk.resize(begin + stream.total_out);
  end_chunk(band.chunk, 0);
}

struct Layout {
  int width, height;
  std::size_t channels, sample_bytes;
  std::size_t pixel_bytes() const { return channels * sample_bytes; }
  std::size_t row_bytes() const { return static_cast<std::size_t>(width) * pixel_bytes(); }
};

void put_text(Bytes& bytes, const std::string& name, const std::string& text) {
  constexpr std::size_t kMaxKeyword = 79;
  ALU_CHECK(!name.empty() && name.size() <= kMaxKeyword, "keyword '{}'", name);
  Bytes chunk(name.begin(), name.end());
  chunk.insert(chunk.end(), {0, 0, 0, 0, 0});  // the keyword's end, not compressed, no language, no translation
  chunk.insert(chunk.end(), text.begin(), text.end());
  put_chunk(bytes, "iTXt", chunk);
}

// fill(first row, rows, to): `rows` rows as they lie in the file.
template <class Fill>
void stream_png(const Layout& layout, bool is_srgb, const ImageMetadata& metadata, const Fill& fill, const ByteSink& sink) {
  const int width = layout.width, height = layout.height;
  ALU_CHECK(width > 0 && height > 0, "{} x {}", width, height);
  // avail_in is 32 bits: 64 rows of the widest image are 8.4 MB.
  static_assert(std::int64_t{kBandRows} * (1 + 8 * std::int64_t{kMaxImageSidePx}) < std::int64_t{1} << 31);
  ALU_CHECK(width <= kMaxImageSidePx && layout.pixel_bytes() <= 8, "{} px wide, {} bytes a pixel", width, layout.pixel_bytes());
  Bytes bytes{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  Bytes header;
  put_big_endian(header, static_cast<std::uint32_t>(width));
  put_big_endian(header, static_cast<std::uint32_t>(height));
  // Bits, RGB or RGBA, deflate, adaptive filters, not interlaced.
  header.insert(header.end(), {static_cast<std::uint8_t>(8 * layout.sample_bytes),
                               static_cast<std::uint8_t>(layout.channels == 4 ? 6 : 2), 0, 0, 0});
  put_chunk(bytes, "IHDR", header);
  if (is_srgb) {
    put_chunk(bytes, "sRGB", std::array<std::uint8_t, 1>{0});  // perceptual
  } else {
    put_chunk(bytes, "gAMA", std::array<std::uint8_t, 4>{0, 1, 0x86, 0xa0});  // 1.0 in units of 1/100000
  }
  for (const auto& [name, text] : metadata) put_text(bytes, name, text);
  sink(bytes);

  const int band_count = (height + kBandRows - 1) / kBandRows;
  const int bands_a_round = 4 * thread_count();
  uLong adler = 1;
  std::vector<Band> bands(static_cast<std::size_t>(std::min(bands_a_round, band_count)));
  for (int begin = 0; begin < band_count; begin += bands_a_round) {
    const int count = std::min(bands_a_round, band_count - begin);
    parallel_for(count, [&](std::int64_t index) {
      const int number = begin + static_cast<int>(index), first = number * kBandRows,
                rows = std::min(kBandRows, height - first);
      Band& band = bands[static_cast<std::size_t>(index)];
      band.rows.resize(static_cast<std::size_t>(rows) * layout.row_bytes());
      fill(first, rows, band.rows.data());
      filter(band.rows, layout.row_bytes(), layout.pixel_bytes(), band.filtered);
      deflate_band(band, number == 0, number + 1 == band_count);
    });
    for (const Band& band : std::span(bands).first(static_cast<std::size_t>(count))) {
      adler = ::adler32_combine(adler, band.adler, static_cast<z_off_t>(band.filtered.size()));
      sink(band.chunk);
    }
  }
  bytes.clear();
  Bytes checksum;
  put_big_endian(checksum, static_cast<std::uint32_t>(adler));
  put_chunk(bytes, "IDAT", checksum);
  put_chunk(bytes, "IEND", {});
  sink(bytes);
}

}  // namespace

void write_png16(int width, int height, bool is_srgb, const RowOfCodes& row_of, const ByteSink& sink) {
  const Layout layout{width, height, 3, 2};
  const std::size_t row_codes = 3 * static_cast<std::size_t>(width);
  stream_png(
      layout, is_srgb, {},
      [&](int first, int rows, std::uint8_t* to) {
        UninitializedVector<std::uint16_t> codes(row_codes);
        for (int row = first; row < first + rows; ++row) {
          row_of(row, codes.data());
          for (const std::uint16_t code : codes) {
            *to++ = static_cast<std::uint8_t>(code >> 8);
            *to++ = static_cast<std::uint8_t>(code & 255u);
          }
        }
      },
      sink);
}

std::vector<std::uint8_t> encode_png(const Image8& image, const ImageMetadata& metadata) {
  ALU_CHECK(image.channels == 3 || image.channels == 4, "{} channels", image.channels);
  const Layout layout{image.width, image.height, static_cast<std::size_t>(image.channels), 1};
  ALU_CHECK(image.texels.size() == layout.row_bytes() * static_cast<std::size_t>(image.height), "{} x {}, {} bytes", image.width,
            image.height, image.texels.size());
  std::vector<std::uint8_t> all;
  stream_png(
      layout, true, metadata,
      [&](int first, int rows, std::uint8_t* to) {
        std::copy_n(image.texels.data() + static_cast<std::size_t>(first) * layout.row_bytes(),
                    static_cast<std::size_t>(rows) * layout.row_bytes(), to);
      },
      [&](std::span<const std::uint8_t> bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); });
  return all;
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
