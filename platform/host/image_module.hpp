// The C-like border between the program and the image module (opened with dlopen by image_file.cpp). Plain data and
// function pointers only: no exception, no container and no ownership crosses it. A call that fails writes one line
// into its Failure and returns false or null.
#pragma once

#include <cstddef>
#include <cstdint>

namespace aluminate::host::image_module {

inline constexpr int kInterfaceVersion = 6;  // both sides are built together; a stale module must not be used

struct Failure {
  char text[400];
};

struct Reader;  // one open image

enum class Sample : std::int32_t { Unorm8, Unorm16, Float, Other };

struct Facts {
  std::int32_t width, height, depth, channels;
  Sample sample;  // of the widest channel; Other: a type without a meaning here
  std::int32_t orientation;
};

struct Pair {
  const char* name;
  const char* value;
};

struct Layer {
  const char* name;
  const float* floats;          // exactly one of the two is set
  const std::uint32_t* uints;
  bool as_half;
};

struct Box {
  std::int32_t left, top, right, bottom;  // right and bottom lie outside
};

/// Receives encoded bytes.
using Sink = void (*)(void* context, const std::uint8_t* bytes, std::size_t count);

struct Interface {
  std::int32_t version;

  /// Reads the header only. format: OpenImageIO's name ("tiff"). The bytes must outlive the reader.
  Reader* (*open)(const char* format, const std::uint8_t* bytes, std::size_t count, Facts* facts, Failure* failure);
  const char* (*channel_name)(const Reader* reader, int channel);
  /// rgba: width*height*4. Unorm8 and Unorm16 images only.
  bool (*read_rgba8)(Reader* reader, std::uint8_t* rgba, Failure* failure);
  /// values: width*height*channels.
  bool (*read_float)(Reader* reader, float* values, Failure* failure);
  /// codes: width*height*channels of 1 or 2 bytes. Unorm8 and Unorm16 images only.
  bool (*read_codes)(Reader* reader, std::uint8_t* codes, Failure* failure);
  void (*close)(Reader* reader);

  bool (*encode_exr)(int width, int height, const Layer* layers, std::size_t layer_count, const Pair* metadata,
                     std::size_t metadata_count, Sink sink, void* context, Failure* failure);

  /// Where the ink of one line of text lies, relative to the left end of its baseline (y down).
  bool (*text_box)(const char* text, int size, const char* font_file, Box* box, Failure* failure);
  /// Ink coverage 0..255 added to coverage, width*height texels that must be 0 before; the baseline starts at (x, y).
  bool (*draw_text)(int width, int height, std::uint8_t* coverage, int x, int y, const char* text, int size,
                    const char* font_file, Failure* failure);
};

/// The one symbol the module exports.
inline constexpr const char* kEntrySymbol = "aluminate_image_module";
using Entry = const Interface* (*)();

}  // namespace aluminate::host::image_module
