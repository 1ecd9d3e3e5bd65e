// Image files in and out. In: encoded bytes or a path. Out: texels, or encoded bytes ready for an OutputFile.
// PNG and JPEG are libpng's and libjpeg's; everything else is OpenImageIO's. That takes 0.2 s and more to load, so it lives
// in a module that is opened on the first call; a program that needs no other format (and draws no text) never pays. Never: converts colour, premultiplies alpha, applies a rotation, or prints.
// All functions may be called from several threads at once. Errors are UserError and name the image.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "platform/host/uninitialized.hpp"

namespace aluminate::host {

/// Larger images are refused from their header, before any texel is allocated.
inline constexpr int kMaxImageSidePx = 16384;
inline constexpr std::int64_t kMaxImageTexels = std::int64_t{1} << 28;
inline constexpr std::int64_t kMaxImageSamples = std::int64_t{1} << 30;  // texels * channels
inline constexpr int kMaxImageChannels = 64;

/// 8 bits a channel, row-major, row 0 is the top, channels interleaved; 3 = RGB, 4 = RGBA (alpha not premultiplied).
struct Image8 {
  int width = 0, height = 0, channels = 4;
  std::vector<std::uint8_t> texels;  // width*height*channels
};

enum class StoredAs : std::uint8_t { Unorm8, Unorm16, Float };  // Float: half, float32 or uint32 (EXR), read literally

/// Float texels, row-major, row 0 is the top, channels interleaved in the order of `channels`.
struct ImageFloat {
  int width = 0, height = 0;
  std::vector<std::string> channels;  // names as stored ("R", "cost.alu_words"); R, G, B, A come first when present
  std::vector<float> texels;          // Unorm8: code/255, Unorm16: code/65535 (round(x*65535) is the code again)
  StoredAs stored = StoredAs::Float;
  int orientation = 1;                // EXIF orientation 1..8; the texels are *not* rotated

  /// Index of a channel name, or -1.
  int channel(std::string_view name) const;
};

/// Codes of 8 or 16 bits as the file holds them, row-major, row 0 is the top, channels interleaved.
struct ImageCodes {
  int width = 0, height = 0, channels = 0;
  StoredAs stored = StoredAs::Unorm8;       // never Float
  int orientation = 1;                      // as in ImageFloat
  UninitializedVector<std::uint8_t> bytes;  // width*height*channels codes; 16-bit ones in the machine's order
};

/// PNG, JPEG, TIFF, OpenEXR, Radiance HDR, BMP, TGA or WebP from memory, told apart by content. Grey becomes RGB, a
/// missing alpha 255, 16-bit codes are rounded to 8. Float formats are refused: use decode_float.
/// Truncated or corrupt data is an error, never a half image. `name` is for messages.
Image8 decode_rgba8(std::span<const std::uint8_t> encoded, const std::string& name);
ImageFloat decode_float(std::span<const std::uint8_t> encoded, const std::string& name);
/// Whichever of the two the file holds: a large photograph is not converted more often than it must be.
std::variant<ImageCodes, ImageFloat> decode_stored(std::span<const std::uint8_t> encoded, const std::string& name);

/// The same from a file.
ImageFloat read_image(const std::string& path);
Image8 read_image_rgba8(const std::string& path);

/// (name, value) strings stored in the file's header. Nothing else that varies is stored: the same texels and metadata
/// give the same bytes on every run.
using ImageMetadata = std::vector<std::pair<std::string, std::string>>;

/// PNG, 3 or 4 channels of 8 bits, marked sRGB.
std::vector<std::uint8_t> encode_png(const Image8& image, const ImageMetadata& metadata = {});

/// Pictures of three channels as they are made, for those too large to be held twice. The rows are asked for once
/// each, in any order and by several threads; the bytes are passed on in order by the calling thread. The bytes do not
/// depend on the number of threads.
using RowOfCodes = std::function<void(int row, std::uint16_t* codes)>;  // width*3, interleaved
using RowOfFloats = std::function<void(int row, float* values)>;        // width*3, interleaved
using ByteSink = std::function<void(std::span<const std::uint8_t> bytes)>;

/// Compressed on all threads. is_srgb: what the codes mean, stored in the file; otherwise they are linear.
void write_png16(int width, int height, bool is_srgb, const RowOfCodes& row_of, const ByteSink& sink);
/// Uncompressed baseline TIFF [TIFF6], one strip. At most 4 GiB.
void write_tiff16(int width, int height, const RowOfCodes& row_of, const ByteSink& sink);
/// Scan-line OpenEXR of 32-bit R, G, B, not compressed: the noise of a photograph hardly shrinks and takes seconds.
void write_exr_rgb(int width, int height, const RowOfFloats& row_of, const ByteSink& sink);

/// The same of width*height*3 codes, interleaved.
std::vector<std::uint8_t> encode_png16(int width, int height, std::span<const std::uint16_t> codes, bool is_srgb);
std::vector<std::uint8_t> encode_tiff16(int width, int height, std::span<const std::uint16_t> codes);

/// One EXR channel: width*height values, row-major. Names are file-level: "R", "cost.alu_words", "depth.Z".
struct ExrLayer {
  std::string name;
  std::variant<std::span<const float>, std::span<const std::uint32_t>> values;
  bool as_half = false;  // float values only: store 16-bit halves
};

/// Scan-line OpenEXR with ZIP compression. EXR itself orders channels by name. Names must be unique and not empty.
std::vector<std::uint8_t> encode_exr(int width, int height, std::span<const ExrLayer> layers,
                                     const ImageMetadata& metadata = {});

/// Encodes and writes through an OutputFile (temporary name, renamed when complete).
void write_png(const std::string& path, const Image8& image, const ImageMetadata& metadata = {});
void write_exr(const std::string& path, int width, int height, std::span<const ExrLayer> layers,
               const ImageMetadata& metadata = {});

inline constexpr int kMaxTextSizePx = 256;

/// Text for legends: DejaVu Sans, anti-aliased, clipped to the image. (x, y) is the left end of the baseline in px,
/// size the em height in px, 1..kMaxTextSizePx. Alpha stays as it is. Without the font file nothing is drawn and text_width is 0. UTF-8, one line.
/// Glyph coverage comes from FreeType and may differ between its versions: not for hashed images.
struct Rgb8 {
  std::uint8_t r = 0, g = 0, b = 0;
  bool operator==(const Rgb8&) const = default;
};
void draw_text(Image8& image, int x, int y, const std::string& text, int size, Rgb8 colour);
int text_width(const std::string& text, int size);
bool text_available();

}  // namespace aluminate::host
