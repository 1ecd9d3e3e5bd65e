#include "scenes/gltf/document.hpp"

#include "platform/host/error.hpp"
#include "platform/host/hash.hpp"
#include "scenes/gltf/container.hpp"
#include "scenes/gltf/layout.hpp"
#include "scenes/gltf/resources.hpp"
#include "scenes/gltf/schema.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "scenes/gltf/tinygltf.hpp"

namespace aluminate::scenes::gltf {
namespace {

using nlohmann::json;
using Bytes = std::vector<std::uint8_t>;

constexpr std::string_view kSupportedExtensions[] = {
    "KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_unlit", "KHR_mesh_quantization",           "KHR_texture_transform"};

/// Extensions that change nothing when they are ignored, so that a warning would only be noise.
constexpr std::string_view kHarmlessExtensions[] = {"KHR_xmp", "KHR_xmp_json_ld"};

void check_version(const json& root, const std::string& file) {
  const auto version = root.at("asset").at("version").get<std::string>();
  if (!version.starts_with("2."))
    throw UserError(SourcePlace{file},
                    fmt::format("/asset/version: expected glTF 2.x, found {}", shown_name(version)),
                    "export the scene as glTF 2.0");
}

bool listed(std::span<const std::string_view> list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

void check_extensions(const json& root, Document& document) {
  if (const auto required = root.find("extensionsRequired"); required != root.end()) {
    for (std::size_t i = 0; i < required->size(); ++i) {
      const auto name = (*required)[i].get<std::string>();
      if (!listed(kSupportedExtensions, name))
        document.fail(fmt::format("/extensionsRequired/{}", i),
                      fmt::format("the file needs {}, which is not supported", shown_name(name)),
                      "re-export without it; for compressed geometry or textures, convert to plain buffers "
                      "and PNG or JPEG");
    }
  }
  if (const auto used = root.find("extensionsUsed"); used != root.end()) {
    for (const auto& entry : *used) {
      const auto name = entry.get<std::string>();
      if (!listed(kSupportedExtensions, name) && !listed(kHarmlessExtensions, name))
        document.warnings.add(fmt::format("extension {} is not supported and was ignored", shown_name(name)));
    }
  }
}

/// The files a scene names: what tinygltf sees instead of a file system. The key is the name as tinygltf
/// spells it.
struct NamedFile {
  std::string name;  // decoded URI
  Bytes bytes;
  std::uint64_t buffer_bytes = 0;  // byteLength of the buffers made of it, 0 = none
};
using NamedFiles = std::map<std::string, NamedFile>;

/// tinygltf decodes a URI like a web form: '+' is a space. The file on disk is looked up under its true name.
std::string tinygltf_spelling(std::string uri) {
  std::replace(uri.begin(), uri.end(), '+', ' ');
  return percent_decode(uri);
}

NamedFiles read_named_files(const json& root, const std::filesystem::path& path, const Document& document,
                            const LoadLimits& limits) {
  NamedFiles files;
  std::uint64_t total = 0;
  std::optional<ResourceFolder> folder;
  for (const char* array : {"buffers", "images"}) {
    const auto found = root.find(array);
    if (found == root.end()) continue;
    for (std::size_t i = 0; i < found->size(); ++i) {
      const json& entry = (*found)[i];
      if (!entry.contains("uri")) continue;
      const auto uri = entry.at("uri").get<std::string>();
      if (is_data_uri(uri)) continue;
      const std::string place = fmt::format("/{}/{}/uri", array, i);
      const auto [position, first] = files.try_emplace(tinygltf_spelling(uri));
      NamedFile& file = position->second;
      if (first) {
        if (!folder) folder.emplace(path.parent_path(), document.file, limits.file_bytes);
        file.name = percent_decode(uri);
        file.bytes = folder->read(uri, place);
        total += file.bytes.size();
        if (total > limits.file_bytes)
          document.fail(place, fmt::format("the files it names hold more than {} bytes", limits.file_bytes));
      }
      if (file.name != percent_decode(uri))
        document.fail(place, "names two files that differ only in '+' and space");
      if (!entry.contains("byteLength")) continue;
      const auto wanted = entry.at("byteLength").get<std::uint64_t>();
      if (file.bytes.size() < wanted)
        document.fail(place, fmt::format("expected {} bytes, the file has {}", wanted, file.bytes.size()));
      if (file.buffer_bytes != 0 && file.buffer_bytes != wanted)
        document.fail(place, "two buffers of different length share this file");
      file.buffer_bytes = wanted;
    }
  }
  return files;
}

std::string content_hash(std::span<const std::uint8_t> scene, const NamedFiles& files) {
  host::Hasher hasher;
  hasher.add_u64(scene.size()).add(scene);
  for (const auto& [key, file] : files)
    hasher.add_text(file.name).add_u64(file.bytes.size()).add(std::span<const std::uint8_t>(file.bytes));
  return hasher.finish().hex();
}

/// Four base64 digits carry three bytes; '=' fills up the last four.
void check_buffer_data_uri(std::string_view uri, std::uint64_t wanted, const std::string& place,
                           const Document& document) {
  const auto comma = uri.find(',');
  const std::string_view header = uri.substr(0, comma == std::string_view::npos ? uri.size() : comma);
  if (header != "data:application/octet-stream;base64" && header != "data:application/gltf-buffer;base64")
    document.fail(
        place,
        fmt::format("expected data:application/octet-stream;base64 or application/gltf-buffer, found {}",
                    shown_name(std::string(header.substr(0, 80)))));
  std::string_view digits = uri.substr(header.size() + 1);
  while (digits.ends_with('=')) digits.remove_suffix(1);
  if (const std::uint64_t held = digits.size() * 3 / 4; held != wanted)
    document.fail(place, fmt::format("expected {} bytes, the data URI holds {}", wanted, held));
}

void check_buffers(const json& root, const Container& container, const Document& document) {
  const auto buffers = root.find("buffers");
  if (buffers == root.end()) return;
  for (std::size_t i = 0; i < buffers->size(); ++i) {
    const json& buffer = (*buffers)[i];
    const std::string place = fmt::format("/buffers/{}", i);
    const auto wanted = buffer.at("byteLength").get<std::uint64_t>();
    if (buffer.contains("uri")) {
      const auto& uri = buffer.at("uri").get_ref<const std::string&>();
      if (is_data_uri(uri)) check_buffer_data_uri(uri, wanted, place + "/uri", document);
      continue;
    }
    if (!container.binary) document.fail(place, "has no uri, and only a .glb carries its own bytes");
    if (i != 0) document.fail(place, "has no uri; only the first buffer of a glb may be its BIN chunk");
    if (wanted > container.bin.size())
      document.fail(place,
                    fmt::format("expected {} bytes, the BIN chunk has {}", wanted, container.bin.size()));
  }
}

// ---- tinygltf's view of the world: NamedFiles through user_data

const NamedFile* find_file(const std::string& path, void* user_data) {
  const auto& files = *static_cast<const NamedFiles*>(user_data);
  const auto found = files.find(path);
  return found == files.end() ? nullptr : &found->second;
}

bool file_exists(const std::string& path, void* user_data) { return find_file(path, user_data) != nullptr; }
std::string same_path(const std::string& path, void*) { return path; }
bool read_file(std::vector<unsigned char>* out, std::string*, const std::string& path, void* user_data) {
  const NamedFile* file = find_file(path, user_data);
  if (file == nullptr) return false;
  *out = file->bytes;
  // A buffer may be shorter than its file [glTF2 3.6.1.1]; tinygltf wants the exact size.
  if (file->buffer_bytes != 0) out->resize(file->buffer_bytes);
  return true;
}
bool write_nothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

/// Keeps the encoded bytes. Images in buffer views are cut out later, from ranges that check_layout has
/// verified.
bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int,
                  const unsigned char* bytes, int size, void*) {
  if (image->bufferView < 0) image->image.assign(bytes, bytes + size);
  return true;
}

void parse_structure(Document& document, std::span<const std::uint8_t> bytes, const Container& container,
                     NamedFiles& files) {
  tinygltf::TinyGLTF parser;
  parser.SetImageLoader(&keep_encoded, nullptr);
  parser.SetFsCallbacks({&file_exists, &same_path, &read_file, &write_nothing, &files});
  std::string error, ignored_warning;
  bool done = false;
  try {
    if (container.binary) {
      done = parser.LoadBinaryFromMemory(document.model.get(), &error, &ignored_warning, bytes.data(),
                                         static_cast<unsigned>(little_endian_u32(bytes, 8)), "");
    } else {
      done = parser.LoadASCIIFromString(document.model.get(), &error, &ignored_warning,
                                        reinterpret_cast<const char*>(container.json_text.data()),
                                        static_cast<unsigned>(container.json_text.size()), "");
    }
  } catch (const std::exception& thrown) {
    error = thrown.what();
    done = false;
  }
  // With success, remarks are about parts that are not read, such as skins: what is read has passed
  // check_schema.
  if (done) return;
  error = error.substr(0, error.find('\n'));
  if (error.size() > 200) error = error.substr(0, 200) + "...";  // it quotes data URIs in full
  throw UserError(SourcePlace{document.file},
                  fmt::format("not a readable glTF file: {}", error.empty() ? "no reason given" : error));
}

void cut_out_images(Document& document) {
  for (auto& image : document.model->images) {
    if (image.bufferView < 0) continue;
    const auto& view = document.model->bufferViews[static_cast<std::size_t>(image.bufferView)];
    const auto& buffer = document.model->buffers[static_cast<std::size_t>(view.buffer)].data;
    ALU_CHECK(view.byteOffset + view.byteLength <= buffer.size(), "image view {}+{} of {}", view.byteOffset,
              view.byteLength, buffer.size());
    const auto first = buffer.begin() + static_cast<std::ptrdiff_t>(view.byteOffset);
    image.image.assign(first, first + static_cast<std::ptrdiff_t>(view.byteLength));
  }
}

}  // namespace

void Warnings::add(std::string line) {
  if (std::find(lines_.begin(), lines_.end(), line) != lines_.end()) return;
  if (lines_.size() < kMost)
    lines_.push_back(std::move(line));
  else
    ++dropped_;
}

std::vector<std::string> Warnings::take() {
  if (dropped_ > 0) lines_.push_back(fmt::format("and {} more warnings", dropped_));
  dropped_ = 0;
  return std::move(lines_);
}

Document::Document() : model(std::make_unique<tinygltf::Model>()) {}
Document::Document(Document&&) noexcept = default;
Document::~Document() = default;

void Document::fail(const std::string& place, const std::string& what, const std::string& hint) const {
  throw UserError(SourcePlace{file}, place + ": " + what, hint);
}

std::string shown_name(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  std::string out = name.substr(0, kLongest);
  // Do not end within a UTF-8 sequence.
  if (name.size() > kLongest)
    while (!out.empty() && (static_cast<unsigned char>(name[out.size()]) & 0xC0) == 0x80) out.pop_back();
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return out;
}

Document read_document(const std::filesystem::path& path, const LoadLimits& limits) {
  Document document;
  document.file = path.string();
  const Bytes bytes = read_regular_file(path, limits.file_bytes, document.file);
  const Container container = open_container(bytes, document.file);
  NamedFiles files;
  {
    const json root = parse_json(container, document.file, limits);
    check_schema(root, document.file);
    check_version(root, document.file);
    check_extensions(root, document);
    check_layout(root, document.file);
    check_buffers(root, container, document);
    files = read_named_files(root, path, document, limits);
    document.content_hash = content_hash(bytes, files);
  }
  parse_structure(document, bytes, container, files);
  cut_out_images(document);
  return document;
}

}  // namespace aluminate::scenes::gltf
