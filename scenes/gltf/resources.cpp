#include "scenes/gltf/resources.hpp"

#include "platform/host/error.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>

namespace aluminate::scenes::gltf {
namespace fs = std::filesystem;
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// "http:", "file:", "C:": letters, digits, + - . up to the first colon, before any slash [RFC3986 3.1].
bool has_scheme(std::string_view uri) {
  const auto colon = uri.find(':');
  if (colon == std::string_view::npos || colon == 0) return false;
  return std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.';
  });
}

bool lies_within(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

std::string printable(std::string text) {
  constexpr std::size_t kLongest = 120;
  if (text.size() > kLongest) text = text.substr(0, kLongest) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return text;
}

}  // namespace

bool is_data_uri(std::string_view uri) { return uri.starts_with("data:"); }

std::string percent_decode(std::string_view uri) {
  std::string out;
  out.reserve(uri.size());
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0) {
      out += static_cast<char>(hex_digit(uri[i + 1]) * 16 + hex_digit(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i];
    }
  }
  return out;
}

std::vector<std::uint8_t> read_regular_file(const fs::path& path, std::uint64_t max_bytes,
                                            const std::string& shown_as) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found)
    throw UserError(SourcePlace{shown_as}, "no such file", "check the path");
  if (error) throw UserError(SourcePlace{shown_as}, fmt::format("cannot be read: {}", error.message()));
  if (status.type() == fs::file_type::directory)
    throw UserError(SourcePlace{shown_as}, "expected a file, found a folder");
  if (status.type() != fs::file_type::regular)
    throw UserError(SourcePlace{shown_as}, "expected a regular file, found a device or pipe");
  const std::uint64_t size = fs::file_size(path, error);
  if (error) throw UserError(SourcePlace{shown_as}, fmt::format("cannot be read: {}", error.message()));
  if (size == 0) throw UserError(SourcePlace{shown_as}, "the file is empty");
  if (size > max_bytes)
    throw UserError(SourcePlace{shown_as},
                    fmt::format("the file has {} bytes, more than the limit of {}", size, max_bytes));
  std::ifstream stream(path, std::ios::binary);
  std::vector<std::uint8_t> bytes(size);
  if (!stream || !stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
    throw UserError(SourcePlace{shown_as}, "cannot be read to its end", "check the file's permissions");
  return bytes;
}

ResourceFolder::ResourceFolder(fs::path folder, std::string scene_file, std::uint64_t max_bytes)
    : scene_file_(std::move(scene_file)), max_bytes_(max_bytes) {
  std::error_code error;
  folder_ = fs::canonical(folder.empty() ? fs::path(".") : folder, error);
  if (error)
    throw UserError(SourcePlace{scene_file_},
                    fmt::format("its folder cannot be resolved: {}", error.message()));
}

std::vector<std::uint8_t> ResourceFolder::read(const std::string& uri, const std::string& place) const {
  const auto refuse = [&](const std::string& why) {
    throw UserError(SourcePlace{scene_file_}, fmt::format("{}: '{}' {}", place, printable(uri), why),
                    "a scene may name files in its own folder and below it");
  };
  if (uri.empty()) refuse("names no file");
  if (has_scheme(uri)) refuse("is not a relative file name: nothing is fetched over a network or by scheme");
  for (std::size_t i = uri.find('%'); i != std::string::npos; i = uri.find('%', i + 1))
    if (i + 2 >= uri.size() || hex_digit(uri[i + 1]) < 0 || hex_digit(uri[i + 2]) < 0)
      refuse("holds a '%' without two hex digits");
  const std::string name = percent_decode(uri);
  if (name.find('\0') != std::string::npos || name.find('\\') != std::string::npos)
    refuse("holds a character no file name may have");
  const fs::path relative(name);
  if (relative.is_absolute()) refuse("is an absolute path");
  if (has_scheme(name)) refuse("is not a relative file name");
  for (const fs::path& part : relative.lexically_normal())
    if (part == "..") refuse("leaves the scene's folder");

  std::error_code error;
  const fs::path target = fs::canonical(folder_ / relative, error);
  if (error == std::errc::no_such_file_or_directory || error == std::errc::not_a_directory)
    throw UserError(SourcePlace{scene_file_},
                    fmt::format("{}: there is no file '{}' beside the scene", place, printable(name)),
                    "put the file into the scene's folder");
  if (error) refuse(fmt::format("cannot be resolved: {}", error.message()));
  if (!lies_within(target, folder_)) refuse("is a link that leads outside the scene's folder");
  return read_regular_file(target, max_bytes_,
                           fmt::format("{}: {}: '{}'", scene_file_, place, printable(name)));
}

}  // namespace aluminate::scenes::gltf
