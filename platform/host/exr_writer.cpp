// Uncompressed scan-line OpenEXR [OpenEXR3] of three 32-bit channels, written as the rows are made:
// OpenImageIO would hold the file and a second copy of the picture in memory.
#include <algorithm>
#include <bit>
#include <cstring>
#include <string_view>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::host {
namespace {

using Bytes = std::vector<std::uint8_t>;

template <class Value>
void put(Bytes& bytes, Value value) {
  static_assert(std::endian::native == std::endian::little, "numbers are copied as they lie in memory");
  std::uint8_t raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.insert(bytes.end(), raw, raw + sizeof value);
}

void put_text(Bytes& bytes, std::string_view text) {
  bytes.insert(bytes.end(), text.begin(), text.end());
  bytes.push_back(0);
}

void put_attribute(Bytes& bytes, std::string_view name, std::string_view type, const Bytes& value) {
  put_text(bytes, name);
  put_text(bytes, type);
  put(bytes, static_cast<std::int32_t>(value.size()));
  bytes.insert(bytes.end(), value.begin(), value.end());
}

template <class... Values>
Bytes packed(Values... values) {
  Bytes bytes;
  (put(bytes, values), ...);
  return bytes;
}

Bytes header_of(std::int32_t width, std::int32_t height) {
  constexpr std::int32_t kMagic = 20000630, kVersion = 2, kFloat = 2;
  Bytes bytes = packed(kMagic, kVersion), channels;
  for (const std::string_view name : {"B", "G", "R"}) {  // sorted by name
    put_text(channels, name);
    put(channels, kFloat);
    put(channels, std::int32_t{0});  // values are linear to the eye: no, and three reserved bytes
    for (int i = 0; i < 2; ++i) put(channels, std::int32_t{1});  // every column, every row
  }
  channels.push_back(0);
  const Bytes window = packed(std::int32_t{0}, std::int32_t{0}, width - 1, height - 1);
  put_attribute(bytes, "channels", "chlist", channels);
  put_attribute(bytes, "compression", "compression", {0});
  put_attribute(bytes, "dataWindow", "box2i", window);
  put_attribute(bytes, "displayWindow", "box2i", window);
  put_attribute(bytes, "lineOrder", "lineOrder", {0});  // row 0 first
  put_attribute(bytes, "pixelAspectRatio", "float", packed(1.0f));
  put_attribute(bytes, "screenWindowCenter", "v2f", packed(0.0f, 0.0f));
  put_attribute(bytes, "screenWindowWidth", "float", packed(1.0f));
  bytes.push_back(0);
  return bytes;
}

}  // namespace

void write_exr_rgb(int width, int height, const RowOfFloats& row_of, const ByteSink& sink) {
  ALU_CHECK(width > 0 && height > 0 && width <= kMaxImageSidePx, "{} x {}", width, height);
  // A line: its number, its size, then each channel's values.
  const std::size_t columns = static_cast<std::size_t>(width), values_bytes = 3 * columns * sizeof(float),
                    line_bytes = 8 + values_bytes;
  static_assert(12 * std::int64_t{kMaxImageSidePx} < std::int64_t{1} << 31);
  Bytes header = header_of(width, height);
  const std::uint64_t first_line = header.size() + 8 * static_cast<std::uint64_t>(height);
  for (int y = 0; y < height; ++y) put(header, first_line + static_cast<std::uint64_t>(y) * line_bytes);
  sink(header);

  const int rows_a_round = static_cast<int>(
      std::clamp<std::size_t>((std::size_t{4} << 20) / line_bytes, 1, static_cast<std::size_t>(height)));
  UninitializedVector<std::uint8_t> lines(line_bytes * static_cast<std::size_t>(rows_a_round));
  for (int begin = 0; begin < height; begin += rows_a_round) {
    const int count = std::min(rows_a_round, height - begin);
    parallel_for(
        count,
        [&](std::int64_t row) {
          const std::int32_t facts[2]{begin + static_cast<std::int32_t>(row),
                                      static_cast<std::int32_t>(values_bytes)};
          std::uint8_t* const line = lines.data() + static_cast<std::size_t>(row) * line_bytes;
          std::memcpy(line, facts, sizeof facts);
          thread_local UninitializedVector<float> rgb;
          thread_local UninitializedVector<float> planes;
          rgb.resize(3 * columns);
          planes.resize(3 * columns);
          row_of(begin + static_cast<int>(row), rgb.data());
          for (std::size_t x = 0; x < columns; ++x) {
            planes[x] = rgb[3 * x + 2];
            planes[columns + x] = rgb[3 * x + 1];
            planes[2 * columns + x] = rgb[3 * x];
          }
          std::memcpy(line + sizeof facts, planes.data(), values_bytes);
        },
        8);
    sink({lines.data(), line_bytes * static_cast<std::size_t>(count)});
  }
}

}  // namespace aluminate::host
