#include "platform/host/image_file.hpp"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string_view>

#include "platform/host/error.hpp"
#include "platform/host/image_module.hpp"
#include "platform/host/image_readers.hpp"
#include "platform/host/image_signature.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"

namespace aluminate::host {
namespace {

namespace fs = std::filesystem;
using image_module::Failure;

constexpr std::size_t kMaxTextBytes = 1000;  // with kMaxTextSizePx it bounds what a line can need
constexpr const char* kModuleFile = "libaluminate_image_module.so";

// Beside the program first, so that an installed or copied build never picks up another build's module.
std::vector<fs::path> module_places() {
  std::vector<fs::path> places;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    places.push_back(program.parent_path() / kModuleFile);
    places.push_back(program.parent_path().parent_path() / "lib" / "aluminate" / kModuleFile);
  }
  places.push_back(fs::path(ALUMINATE_IMAGE_MODULE_DIR) / kModuleFile);
  return places;
}

const image_module::Interface* load_module() {
  std::string reasons;
  for (const fs::path& place : module_places()) {
    std::error_code error;
    if (!fs::exists(place, error)) continue;
    void* library = ::dlopen(place.c_str(), RTLD_LAZY | RTLD_LOCAL);
    if (library == nullptr) {
      reasons += fmt::format("{}{}", reasons.empty() ? ": " : "; ", ::dlerror());
      continue;
    }
    const auto entry = reinterpret_cast<image_module::Entry>(::dlsym(library, image_module::kEntrySymbol));
    const image_module::Interface* module = entry != nullptr ? entry() : nullptr;
    if (module != nullptr && module->version == image_module::kInterfaceVersion) return module;
    reasons += fmt::format("{}{} is of another version", reasons.empty() ? ": " : "; ", place.string());
  }
  throw UserError(fmt::format("cannot open {}, which reads and writes images{}", kModuleFile, reasons),
                  "it belongs beside the program; building the project puts it there");
}

// Stays open until the end: its library starts threads and statics that cannot be unloaded safely.
const image_module::Interface& module() {
  static const image_module::Interface* const loaded = load_module();  // a throw leaves it to the next call
  return *loaded;
}

struct CloseReader {
  void operator()(image_module::Reader* reader) const { module().close(reader); }
};
using ReaderHandle = std::unique_ptr<image_module::Reader, CloseReader>;

struct OpenImage {
  ReaderHandle reader;
  image_module::Facts facts{};
  std::size_t texel_count() const {
    return static_cast<std::size_t>(facts.width) * static_cast<std::size_t>(facts.height);
  }
};

[[noreturn]] void refuse(const std::string& name, const std::string& what, std::string hint = {}) {
  throw UserError({name}, what, std::move(hint));
}

const char* format_of(std::span<const std::uint8_t> encoded, const std::string& name) {
  const char* format = image_format(encoded, name);
  if (format == nullptr) {
    refuse(name, "expected a PNG, JPEG, TIFF, OpenEXR, Radiance HDR, BMP or TGA image, found other data",
           "convert the image to PNG or OpenEXR");
  }
  if (is_cut_off(encoded, format)) refuse(name, fmt::format("the {} image is truncated", format));
  return format;
}

// Nothing for a format, or a flavour of one, that is OpenImageIO's.
std::optional<ImageCodes> decode_without_module(std::span<const std::uint8_t> encoded, const char* format,
                                                const std::string& name) {
  if (std::string_view(format) == "png") return decode_png(encoded, name);
  if (std::string_view(format) == "jpeg") return decode_jpeg(encoded, name);
  return std::nullopt;
}

OpenImage open_image(std::span<const std::uint8_t> encoded, const char* format, const std::string& name) {
  OpenImage image;
  Failure failure{};
  image.reader.reset(module().open(format, encoded.data(), encoded.size(), &image.facts, &failure));
  if (!image.reader) refuse(name, fmt::format("cannot read the {} image: {}", format, failure.text));
  const image_module::Facts& facts = image.facts;
  check_image_size(name, facts.width, facts.height, facts.depth, facts.channels);
  if (image.facts.sample == image_module::Sample::Other) {
    refuse(name, "expected 8 or 16 bit unsigned or floating point channels, found another type");
  }
  return image;
}

// Calls to(index of a value, its code) for every value.
template <class To>
void for_codes(const ImageCodes& image, const To& to) {
  const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                            static_cast<std::size_t>(image.channels);
  if (image.stored == StoredAs::Unorm8) {
    for (std::size_t i = 0; i < count; ++i) to(i, image.bytes[i]);
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::uint16_t code;
    std::memcpy(&code, image.bytes.data() + 2 * i, sizeof code);
    to(i, code);
  }
}

Image8 rgba8_of(const ImageCodes& image) {
  const std::size_t texels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height),
                    channels = static_cast<std::size_t>(image.channels);
  Image8 out{image.width, image.height, 4, std::vector<std::uint8_t>(texels * 4, 255)};
  const bool is_short = image.stored == StoredAs::Unorm16, is_grey = channels < 3;
  std::uint8_t* to = out.texels.data();
  std::size_t channel = 0;
  for_codes(image, [&](std::size_t, std::uint32_t code) {
    const auto code8 = static_cast<std::uint8_t>(is_short ? (code * 255u + 32767u) / 65535u : code);
    if (is_grey && channel == 0)
      to[0] = to[1] = to[2] = code8;
    else
      to[is_grey ? 3 : channel] = code8;
    if (++channel == channels) {
      channel = 0;
      to += 4;
    }
  });
  return out;
}

ImageFloat float_of(const ImageCodes& image) {
  ImageFloat out;
  out.width = image.width;
  out.height = image.height;
  out.orientation = image.orientation;
  out.stored = image.stored;
  if (image.channels < 3)
    out.channels = {"Y", "A"};
  else
    out.channels = {"R", "G", "B", "A"};
  out.channels.resize(static_cast<std::size_t>(image.channels));
  out.texels.resize(image.bytes.size() / (image.stored == StoredAs::Unorm8 ? 1 : 2));
  const float full = image.stored == StoredAs::Unorm8 ? 255.0f : 65535.0f;
  for_codes(image, [&](std::size_t i, std::uint32_t code) { out.texels[i] = static_cast<float>(code) / full; });
  return out;
}

void check_texels(const Image8& image) {
  ALU_CHECK(image.channels == 3 || image.channels == 4, "{} channels", image.channels);
  ALU_CHECK(image.width > 0 && image.height > 0, "{} x {}", image.width, image.height);
  const std::size_t expected = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                               static_cast<std::size_t>(image.channels);
  ALU_CHECK(image.texels.size() == expected, "{} bytes, expected {}", image.texels.size(), expected);
}

std::vector<image_module::Pair> pairs_of(const ImageMetadata& metadata) {
  std::vector<image_module::Pair> pairs;
  for (const auto& [name, value] : metadata) pairs.push_back({name.c_str(), value.c_str()});
  return pairs;
}

// One line of text as coverage. Empty without a font: a legend without its text is still a picture.
struct Ink {
  image_module::Box box{};  // of `coverage`, relative to the left end of the baseline
  int right = 0;            // right edge of the ink itself
  std::vector<std::uint8_t> coverage;
  int width() const { return box.right - box.left; }
  int height() const { return box.bottom - box.top; }
};

Ink ink_of(std::string text, int size) {
  ALU_CHECK(size >= 1 && size <= kMaxTextSizePx, "text of {} px", size);
  text.resize(std::min(text.size(), kMaxTextBytes));
  std::replace_if(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  Ink ink;
  Failure failure{};
  image_module::Box box{};
  if (text.find_first_not_of(' ') == std::string::npos || !text_available() ||
      !module().text_box(text.c_str(), size, ALUMINATE_FONT_FILE, &box, &failure)) {
    return ink;
  }
  ink.right = box.right;
  // The box is measured from glyph advances; ink may lean over it by less than an em.
  ink.box = {std::min(box.left, 0) - size, box.top - size, box.right + size, box.bottom + size};
  ink.coverage.resize(static_cast<std::size_t>(ink.width()) * static_cast<std::size_t>(ink.height()));
  if (!module().draw_text(ink.width(), ink.height(), ink.coverage.data(), -ink.box.left, -ink.box.top, text.c_str(), size,
                          ALUMINATE_FONT_FILE, &failure)) {
    return Ink{};
  }
  return ink;
}

void append_bytes(void* context, const std::uint8_t* bytes, std::size_t count) {
  auto& all = *static_cast<std::vector<std::uint8_t>*>(context);
  all.insert(all.end(), bytes, bytes + count);
}

}  // namespace

void check_image_size(const std::string& name, std::int64_t width, std::int64_t height, std::int64_t depth,
                      std::int64_t channels) {
  if (width < 1 || height < 1 || channels < 1 || depth != 1) {
    refuse(name, fmt::format("expected a flat image, found {} x {} x {} texels of {} channels", width, height, depth, channels));
  }
  // Sides first: the products below then fit.
  if (width > kMaxImageSidePx || height > kMaxImageSidePx || width * height > kMaxImageTexels) {
    refuse(name, fmt::format("the image has {} x {} texels, the limit is {} a side and {} in all", width, height,
                             kMaxImageSidePx, kMaxImageTexels));
  }
  if (channels > kMaxImageChannels || width * height * channels > kMaxImageSamples) {
    refuse(name, fmt::format("the image has {} channels of {} x {} texels, the limit is {} channels and {} values", channels,
                             width, height, kMaxImageChannels, kMaxImageSamples));
  }
}

int ImageFloat::channel(std::string_view name) const {
  const auto found = std::find(channels.begin(), channels.end(), name);
  return found == channels.end() ? -1 : static_cast<int>(found - channels.begin());
}

Image8 decode_rgba8(std::span<const std::uint8_t> encoded, const std::string& name) {
  const char* const format = format_of(encoded, name);
  if (const auto codes = decode_without_module(encoded, format, name)) return rgba8_of(*codes);
  const OpenImage open = open_image(encoded, format, name);
  if (open.facts.sample == image_module::Sample::Float) {
    refuse(name, "expected an image of 8 or 16 bit codes, found floating point values", "convert it to PNG");
  }
  Image8 image{open.facts.width, open.facts.height, 4, std::vector<std::uint8_t>(open.texel_count() * 4)};
  Failure failure{};
  if (!module().read_rgba8(open.reader.get(), image.texels.data(), &failure)) {
    refuse(name, fmt::format("cannot read the image: {}", failure.text));
  }
  return image;
}

namespace {

StoredAs stored_as(const image_module::Facts& facts) {
  return facts.sample == image_module::Sample::Unorm8    ? StoredAs::Unorm8
         : facts.sample == image_module::Sample::Unorm16 ? StoredAs::Unorm16
                                                         : StoredAs::Float;
}

ImageFloat read_floats(const OpenImage& open, const std::string& name) {
  ImageFloat image;
  image.width = open.facts.width;
  image.height = open.facts.height;
  image.orientation = std::clamp(open.facts.orientation, 1, 8);
  image.stored = stored_as(open.facts);
  for (int i = 0; i < open.facts.channels; ++i) {
    image.channels.emplace_back(module().channel_name(open.reader.get(), i));
  }
  image.texels.resize(open.texel_count() * image.channels.size());
  Failure failure{};
  if (!module().read_float(open.reader.get(), image.texels.data(), &failure)) {
    refuse(name, fmt::format("cannot read the image: {}", failure.text));
  }
  return image;
}

}  // namespace

ImageFloat decode_float(std::span<const std::uint8_t> encoded, const std::string& name) {
  const char* const format = format_of(encoded, name);
  if (const auto codes = decode_without_module(encoded, format, name)) return float_of(*codes);
  return read_floats(open_image(encoded, format, name), name);
}

std::variant<ImageCodes, ImageFloat> decode_stored(std::span<const std::uint8_t> encoded, const std::string& name) {
  const char* const format = format_of(encoded, name);
  if (auto codes = decode_without_module(encoded, format, name)) return std::move(*codes);
  const OpenImage open = open_image(encoded, format, name);
  const StoredAs stored = stored_as(open.facts);
  if (stored == StoredAs::Float) return read_floats(open, name);
  ImageCodes image{open.facts.width, open.facts.height, open.facts.channels, stored,
                   std::clamp(open.facts.orientation, 1, 8), {}};
  image.bytes.resize(open.texel_count() * static_cast<std::size_t>(image.channels) * (stored == StoredAs::Unorm8 ? 1 : 2));
  Failure failure{};
  if (!module().read_codes(open.reader.get(), image.bytes.data(), &failure)) {
    refuse(name, fmt::format("cannot read the image: {}", failure.text));
  }
  return image;
}

ImageFloat read_image(const std::string& path) { return decode_float(read_bytes(path), path); }
Image8 read_image_rgba8(const std::string& path) { return decode_rgba8(read_bytes(path), path); }

std::vector<std::uint8_t> encode_exr(int width, int height, std::span<const ExrLayer> layers,
                                     const ImageMetadata& metadata) {
  ALU_CHECK(width > 0 && height > 0 && !layers.empty(), "{} x {}, {} layers", width, height, layers.size());
  const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<image_module::Layer> plain;
  std::set<std::string_view> names;
  for (const ExrLayer& layer : layers) {
    const bool is_float = std::holds_alternative<std::span<const float>>(layer.values);
    const std::size_t count = std::visit([](const auto& values) { return values.size(); }, layer.values);
    ALU_CHECK(count == texels, "layer {} has {} values, expected {}", layer.name, count, texels);
    ALU_CHECK(!layer.name.empty() && names.insert(layer.name).second, "layer name '{}'", layer.name);
    ALU_CHECK(is_float || !layer.as_half, "layer {}: integers are stored as 32 bits", layer.name);
    plain.push_back({layer.name.c_str(), is_float ? std::get<0>(layer.values).data() : nullptr,
                     is_float ? nullptr : std::get<1>(layer.values).data(), layer.as_half});
  }
  const std::vector<image_module::Pair> pairs = pairs_of(metadata);
  std::vector<std::uint8_t> bytes;
  Failure failure{};
  const bool good = module().encode_exr(width, height, plain.data(), plain.size(), pairs.data(), pairs.size(),
                                        append_bytes, &bytes, &failure);
  ALU_CHECK(good, "EXR encoder: {}", failure.text);
  return bytes;
}

void write_png(const std::string& path, const Image8& image, const ImageMetadata& metadata) {
  OutputFile file(path);  // before the encoding: an unwritable place is known at once
  file.write(encode_png(image, metadata));
  file.commit();
}

void write_exr(const std::string& path, int width, int height, std::span<const ExrLayer> layers,
               const ImageMetadata& metadata) {
  OutputFile file(path);
  file.write(encode_exr(width, height, layers, metadata));
  file.commit();
}

bool text_available() {
  std::error_code error;
  return *ALUMINATE_FONT_FILE != '\0' && fs::exists(ALUMINATE_FONT_FILE, error);
}

void draw_text(Image8& image, int x, int y, const std::string& text, int size, Rgb8 colour) {
  check_texels(image);
  constexpr int kFarPx = 1 << 20;  // far outside of any image; keeps the sums below in range
  if (x < -kFarPx || x > kFarPx || y < -kFarPx || y > kFarPx) return;
  const Ink ink = ink_of(text, size);
  const std::array<int, 3> target{colour.r, colour.g, colour.b};
  // Coverage is made in a buffer of its own: the text renderer must not be given a box that leaves the image.
  const int first_row = std::max(0, -(y + ink.box.top)), last_row = std::min(ink.height(), image.height - (y + ink.box.top));
  const int first_column = std::max(0, -(x + ink.box.left));
  const int last_column = std::min(ink.width(), image.width - (x + ink.box.left));
  for (int row = first_row; row < last_row; ++row) {
    for (int column = first_column; column < last_column; ++column) {
      const int cover = ink.coverage[static_cast<std::size_t>(row) * static_cast<std::size_t>(ink.width()) +
                                     static_cast<std::size_t>(column)];
      const std::size_t texel = static_cast<std::size_t>(y + ink.box.top + row) * static_cast<std::size_t>(image.width) +
                                static_cast<std::size_t>(x + ink.box.left + column);
      std::uint8_t* to = image.texels.data() + texel * static_cast<std::size_t>(image.channels);
      for (std::size_t i = 0; i < 3; ++i) {
        to[i] = static_cast<std::uint8_t>((to[i] * (255 - cover) + target[i] * cover + 127) / 255);
      }
    }
  }
}

int text_width(const std::string& text, int size) { return std::max(ink_of(text, size).right, 0); }

}  // namespace aluminate::host
