#include "scenes/gltf/container.hpp"

#include "platform/host/error.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>

namespace aluminate::scenes::gltf {
namespace {

using nlohmann::json;

constexpr std::uint32_t kMagic = 0x46546C67, kJson = 0x4E4F534A, kBin = 0x004E4942;  // "glTF", "JSON", "BIN"
constexpr std::uint64_t kHeader = 12, kChunkHeader = 8;

SourcePlace place_of_byte(std::span<const std::uint8_t> text, std::size_t byte, const std::string& file) {
  SourcePlace place{file, 1, 1};
  for (std::size_t i = 0; i + 1 < byte && i < text.size(); ++i) {
    if (text[i] == '\n') {
      ++place.line;
      place.column = 1;
    } else {
      ++place.column;
    }
  }
  return place;
}

}  // namespace

std::uint32_t little_endian_u32(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint32_t>(bytes[at]) | static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 16 | static_cast<std::uint32_t>(bytes[at + 3]) << 24;
}

Container open_container(std::span<const std::uint8_t> bytes, const std::string& file) {
  const SourcePlace place{file};
  Container container;
  if (bytes.size() < 4 || std::memcmp(bytes.data(), "glTF", 4) != 0) {
    container.json_text = bytes;
    constexpr std::array<std::uint8_t, 3> kByteOrderMark{0xEF, 0xBB, 0xBF};
    if (bytes.size() >= 3 && std::equal(kByteOrderMark.begin(), kByteOrderMark.end(), bytes.begin()))
      container.json_text = bytes.subspan(3);
    return container;
  }
  container.binary = true;
  if (bytes.size() < kHeader + kChunkHeader) throw UserError(place, "the file ends within its glb header");
  const std::uint32_t version = little_endian_u32(bytes, 4);
  if (version != 2)
    throw UserError(place, fmt::format("expected glb version 2, found {}", version),
                    "export the scene as glTF 2.0");
  const std::uint64_t length = little_endian_u32(bytes, 8);
  if (length > bytes.size())
    throw UserError(place, fmt::format("the file is cut off: its header promises {} bytes, it has {}", length,
                                       bytes.size()));
  const std::uint64_t json_bytes = little_endian_u32(bytes, 12);
  if (little_endian_u32(bytes, 16) != kJson) throw UserError(place, "the first chunk of the glb is not JSON");
  const std::uint64_t json_end = kHeader + kChunkHeader + json_bytes;
  if (json_end > length)
    throw UserError(place,
                    fmt::format("the JSON chunk ends at byte {}, beyond the file's {}", json_end, length));
  container.json_text = bytes.subspan(kHeader + kChunkHeader, json_bytes);
  if (json_end + kChunkHeader > length) return container;
  const std::uint64_t bin_bytes = little_endian_u32(bytes, json_end);
  if (little_endian_u32(bytes, json_end + 4) != kBin) return container;  // unknown chunks are to be ignored
  if (json_end + kChunkHeader + bin_bytes > length)
    throw UserError(place, fmt::format("the BIN chunk ends at byte {}, beyond the file's {}",
                                       json_end + kChunkHeader + bin_bytes, length));
  container.bin = bytes.subspan(json_end + kChunkHeader, bin_bytes);
  return container;
}

json parse_json(const Container& container, const std::string& file, const LoadLimits& limits) {
  std::uint64_t values = 0;
  const auto count = [&](int depth, json::parse_event_t, const json&) {
    if (depth > limits.json_depth)
      throw UserError(SourcePlace{file},
                      fmt::format("its JSON is nested more than {} levels deep", limits.json_depth));
    if (++values > limits.json_values)
      throw UserError(SourcePlace{file},
                      fmt::format("its JSON holds more than {} values", limits.json_values));
    return true;
  };
  try {
    return json::parse(container.json_text.begin(), container.json_text.end(), count);
  } catch (const json::parse_error& error) {
    const SourcePlace place =
        container.binary ? SourcePlace{file} : place_of_byte(container.json_text, error.byte, file);
    throw UserError(place,
                    fmt::format("the {} is not valid JSON at byte {}",
                                container.binary ? "glb's JSON chunk" : "file", error.byte),
                    "a scene is a .gltf (JSON) or .glb file");
  } catch (const json::exception&) {
    throw UserError(SourcePlace{file}, "its JSON holds a number outside the range of a double");
  }
}

std::vector<std::uint8_t> glb_bytes(const json& root, std::span<const std::uint8_t> bin,
                                    const std::string& file) {
  std::string text = root.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const std::uint64_t padded_bin = (bin.size() + 3) / 4 * 4;
  const std::uint64_t total = kHeader + 2 * kChunkHeader + text.size() + padded_bin;
  if (total >= std::uint64_t{1} << 32)
    throw UserError(SourcePlace{file}, fmt::format("a glb of {} bytes", total), "the format ends at 4 GiB");
  std::vector<std::uint8_t> out;
  out.reserve(total);
  const auto put = [&out](std::uint64_t value) {
    for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<std::uint8_t>(value >> shift));
  };
  put(kMagic);
  put(2);
  put(total);
  put(text.size());
  put(kJson);
  out.insert(out.end(), text.begin(), text.end());
  put(padded_bin);
  put(kBin);
  out.insert(out.end(), bin.begin(), bin.end());
  out.resize(total, 0);
  return out;
}

}  // namespace aluminate::scenes::gltf
