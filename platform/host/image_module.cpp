// The only file that includes OpenImageIO. Built as a module that nothing links: see image_module.hpp.
#include "platform/host/image_module.hpp"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/half.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <string>
#include <vector>

namespace aluminate::host::image_module {

struct Reader {
  Reader(const std::uint8_t* bytes, std::size_t count) : memory(bytes, count) {}
  OIIO::Filesystem::IOMemReader memory;
  std::unique_ptr<OIIO::ImageInput> input;  // declared last: closed before its bytes go away
};

namespace {

// Rows encoded at a time; a multiple of the 16 rows that OpenEXR compresses together.
constexpr int kRowsPerWrite = 64;

constexpr const char* kNoDate = "1970:01:01 00:00:00";

bool set(Failure* failure, std::string text) {
  text = text.substr(0, text.find('\n'));
  text.resize(std::min(text.size(), sizeof failure->text - 1));
  std::memcpy(failure->text, text.c_str(), text.size() + 1);
  return false;
}

// No exception may cross the border.
template <class Body>
bool guarded(Failure* failure, Body&& body) {
  try {
    return body();
  } catch (const std::exception& error) {
    return set(failure, error.what());
  } catch (...) {
    return set(failure, "the decoder failed");
  }
}

OIIO::TypeDesc channel_type(const OIIO::ImageSpec& spec, int channel) {
  return spec.channelformats.empty() ? spec.format : spec.channelformats[static_cast<std::size_t>(channel)];
}

Sample sample_of(const OIIO::ImageSpec& spec) {
  Sample widest = Sample::Unorm8;
  for (int channel = 0; channel < spec.nchannels; ++channel) {
    switch (channel_type(spec, channel).basetype) {
      case OIIO::TypeDesc::UINT8: break;
      case OIIO::TypeDesc::UINT16: widest = std::max(widest, Sample::Unorm16); break;
      case OIIO::TypeDesc::UINT32:
      case OIIO::TypeDesc::HALF:
      case OIIO::TypeDesc::FLOAT:
      case OIIO::TypeDesc::DOUBLE: widest = std::max(widest, Sample::Float); break;
      default: return Sample::Other;
    }
  }
  return widest;
}

// Codes as stored: OpenImageIO would premultiply alpha and scale integers on its own.
OIIO::ImageSpec reading_hints() {
  OIIO::ImageSpec hints;
  hints["oiio:UnassociatedAlpha"] = 1;
  hints["oiio:RawColor"] = 0;  // CMYK and YCbCr still become RGB
  return hints;
}

// Photographs take seconds on one thread. Small images are read and written by workers that run side by side already.
// The result is the same on any number. OpenEXR looks when a file is opened, before it knows the size.
void allow_threads(bool is_large) {
  const int threads = is_large ? 0 : 1;  // 0: one per core
  OIIO::attribute("threads", threads);
  OIIO::attribute("exr_threads", threads);
}

Reader* open(const char* format, const std::uint8_t* bytes, std::size_t count, Facts* facts, Failure* failure) {
  std::unique_ptr<Reader> reader;
  const bool good = guarded(failure, [&] {
    constexpr std::size_t kLargeBytes = std::size_t{4} << 20;
    allow_threads(count >= kLargeBytes);
    reader = std::make_unique<Reader>(bytes, count);
    reader->input = OIIO::ImageInput::create(format);
    if (!reader->input) return set(failure, std::string("this OpenImageIO cannot read ") + format);
    OIIO::ImageSpec spec;
    if (!reader->input->supports("ioproxy") || !reader->input->set_ioproxy(&reader->memory)) {
      return set(failure, std::string("this OpenImageIO cannot read ") + format + " from memory");
    }
    if (!reader->input->open(std::string("memory.") + format, spec, reading_hints())) {
      return set(failure, reader->input->geterror());
    }
    *facts = {spec.width, spec.height, std::max(spec.depth, 1), spec.nchannels, sample_of(spec),
              spec.get_int_attribute("Orientation", 1)};
    return true;
  });
  return good ? reader.release() : nullptr;
}

const char* channel_name(const Reader* reader, int channel) {
  const std::vector<std::string>& names = reader->input->spec().channelnames;
  return channel < static_cast<int>(names.size()) ? names[static_cast<std::size_t>(channel)].c_str() : "";
}

// The whole image, channels interleaved; TypeUnknown: each in the type it is stored in. False also when the data ends early.
bool read_as(Reader* reader, OIIO::TypeDesc type, std::uint8_t* to, Failure* failure) {
  if (reader->input->read_image(0, 0, 0, -1, type, to) && !reader->input->has_error()) return true;
  const std::string reason = reader->input->geterror();
  return set(failure, reason.empty() ? "the data is truncated or corrupt" : reason);
}

bool read_stored(Reader* reader, std::vector<std::uint8_t>& stored, Failure* failure) {
  stored.resize(static_cast<std::size_t>(reader->input->spec().image_bytes(true)));
  return read_as(reader, OIIO::TypeUnknown, stored.data(), failure);
}

template <class Value>
Value load(const std::uint8_t* from) {
  Value value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

std::uint8_t load_code8(const std::uint8_t* from, OIIO::TypeDesc type) {
  if (type.basetype == OIIO::TypeDesc::UINT8) return *from;
  return static_cast<std::uint8_t>((std::uint32_t{load<std::uint16_t>(from)} * 255u + 32767u) / 65535u);
}

float load_float(const std::uint8_t* from, OIIO::TypeDesc type) {
  switch (type.basetype) {
    case OIIO::TypeDesc::UINT8: return static_cast<float>(*from) / 255.0f;
    case OIIO::TypeDesc::UINT16: return static_cast<float>(load<std::uint16_t>(from)) / 65535.0f;
    case OIIO::TypeDesc::UINT32: return static_cast<float>(load<std::uint32_t>(from));
    case OIIO::TypeDesc::HALF: return static_cast<float>(load<half>(from));
    case OIIO::TypeDesc::DOUBLE: return static_cast<float>(load<double>(from));
    default: return load<float>(from);
  }
}

bool read_rgba8(Reader* reader, std::uint8_t* rgba, Failure* failure) {
  return guarded(failure, [&] {
    std::vector<std::uint8_t> stored;
    if (!read_stored(reader, stored, failure)) return false;
    const OIIO::ImageSpec& spec = reader->input->spec();
    const OIIO::TypeDesc type = channel_type(spec, 0);
    const std::size_t sample_bytes = type.size(), texel_bytes = spec.pixel_bytes(true);
    const bool is_colour = spec.nchannels >= 3;
    const int alpha = spec.alpha_channel >= 0 ? spec.alpha_channel : spec.nchannels == 4 ? 3 : -1;
    const std::uint8_t* end = stored.data() + stored.size();
    for (const std::uint8_t* texel = stored.data(); texel != end; texel += texel_bytes, rgba += 4) {
      for (std::size_t i = 0; i < 3; ++i) rgba[i] = load_code8(texel + (is_colour ? i : 0) * sample_bytes, type);
      rgba[3] = alpha < 0 ? 255 : load_code8(texel + static_cast<std::size_t>(alpha) * sample_bytes, type);
    }
    return true;
  });
}

bool is_float(OIIO::TypeDesc type) { return type == OIIO::TypeFloat || type == OIIO::TypeHalf; }

bool read_float(Reader* reader, float* values, Failure* failure) {
  return guarded(failure, [&] {
    const OIIO::ImageSpec& own = reader->input->spec();
    bool all_float = true;
    for (int channel = 0; channel < own.nchannels; ++channel) all_float = all_float && is_float(channel_type(own, channel));
    if (all_float) return read_as(reader, OIIO::TypeFloat, reinterpret_cast<std::uint8_t*>(values), failure);
    std::vector<std::uint8_t> stored;
    if (!read_stored(reader, stored, failure)) return false;
    const OIIO::ImageSpec& spec = reader->input->spec();
    std::vector<OIIO::TypeDesc> types;
    for (int channel = 0; channel < spec.nchannels; ++channel) types.push_back(channel_type(spec, channel));
    const std::uint8_t* from = stored.data();
    const std::uint8_t* end = from + stored.size();
    while (from != end) {
      for (const OIIO::TypeDesc& type : types) {
        *values++ = load_float(from, type);
        from += type.size();
      }
    }
    return true;
  });
}

bool read_codes(Reader* reader, std::uint8_t* codes, Failure* failure) {
  return guarded(failure, [&] {
    if (!reader->input->spec().channelformats.empty()) return set(failure, "its channels are of several types");
    return read_as(reader, OIIO::TypeUnknown, codes, failure);
  });
}

void close(Reader* reader) { delete reader; }

void add_metadata(OIIO::ImageSpec& spec, const Pair* metadata, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) spec.attribute(metadata[i].name, OIIO::string_view(metadata[i].value));
}

// Opens the encoder on a growing memory buffer, lets `write` feed it, and passes the bytes on.
template <class Write>
bool encode(const char* format, const OIIO::ImageSpec& spec, Sink sink, void* context, Failure* failure, Write&& write) {
  return guarded(failure, [&] {
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(format);
    if (!output) return set(failure, std::string("this OpenImageIO cannot write ") + format);
    if (!output->set_ioproxy(&memory) || !output->open(std::string("memory.") + format, spec) || !write(*output) ||
        !output->close()) {
      return set(failure, output->geterror());
    }
    sink(context, bytes.data(), bytes.size());
    return true;
  });
}

void store_sample(std::uint8_t* to, const Layer& layer, std::size_t texel) {
  if (layer.uints != nullptr) {
    std::memcpy(to, layer.uints + texel, sizeof *layer.uints);
  } else if (layer.as_half) {
    const half value(layer.floats[texel]);
    std::memcpy(to, &value, sizeof value);
  } else {
    std::memcpy(to, layer.floats + texel, sizeof *layer.floats);
  }
}

bool encode_exr(int width, int height, const Layer* layers, std::size_t layer_count, const Pair* metadata,
                std::size_t metadata_count, Sink sink, void* context, Failure* failure) {
  OIIO::ImageSpec spec(width, height, static_cast<int>(layer_count), OIIO::TypeFloat);
  spec.channelnames.clear();
  spec.alpha_channel = spec.z_channel = -1;
  for (std::size_t i = 0; i < layer_count; ++i) {
    spec.channelnames.emplace_back(layers[i].name);
    spec.channelformats.push_back(layers[i].uints != nullptr ? OIIO::TypeUInt32
                                  : layers[i].as_half        ? OIIO::TypeHalf
                                                             : OIIO::TypeFloat);
  }
  spec.attribute("compression", "zip");
  constexpr std::uint64_t kLargeTexels = std::uint64_t{1} << 21;
  allow_threads(spec.image_pixels() >= kLargeTexels);
  spec.attribute("DateTime", kNoDate);  // left unset, the writer stores the time of day
  add_metadata(spec, metadata, metadata_count);
  return encode("openexr", spec, sink, context, failure, [&](OIIO::ImageOutput& output) {
    std::vector<std::uint8_t> rows(spec.pixel_bytes(true) * static_cast<std::size_t>(width) * kRowsPerWrite);
    for (int begin = 0; begin < height; begin += kRowsPerWrite) {
      const int end = std::min(begin + kRowsPerWrite, height);
      std::uint8_t* to = rows.data();
      const std::size_t first = static_cast<std::size_t>(begin) * static_cast<std::size_t>(width);
      const std::size_t last = static_cast<std::size_t>(end) * static_cast<std::size_t>(width);
      for (std::size_t texel = first; texel < last; ++texel) {
        for (std::size_t i = 0; i < layer_count; ++i) {
          store_sample(to, layers[i], texel);
          to += spec.channelformats[i].size();
        }
      }
      if (!output.write_scanlines(begin, end, 0, OIIO::TypeUnknown, rows.data())) return false;
    }
    return true;
  });
}

bool text_box(const char* text, int size, const char* font_file, Box* box, Failure* failure) {
  return guarded(failure, [&] {
    const OIIO::ROI ink = OIIO::ImageBufAlgo::text_size(text, size, font_file);
    if (!ink.defined()) return set(failure, "the font cannot be used");
    *box = {ink.xbegin, ink.ybegin, ink.xend, ink.yend};
    return true;
  });
}

bool draw_text(int width, int height, std::uint8_t* coverage, int x, int y, const char* text, int size,
               const char* font_file, Failure* failure) {
  return guarded(failure, [&] {
    OIIO::ImageBuf image(OIIO::ImageSpec(width, height, 1, OIIO::TypeUInt8), coverage);  // wraps, no copy
    const bool drawn = OIIO::ImageBufAlgo::render_text(image, x, y, text, size, font_file, 1.0f);
    return drawn || set(failure, image.geterror());
  });
}

}  // namespace
}  // namespace aluminate::host::image_module

extern "C" __attribute__((visibility("default"))) const aluminate::host::image_module::Interface*
aluminate_image_module() {
  namespace module = aluminate::host::image_module;
  static const module::Interface interface {
    module::kInterfaceVersion, module::open, module::channel_name, module::read_rgba8, module::read_float,
        module::read_codes, module::close, module::encode_exr, module::text_box, module::draw_text
  };
  return &interface;
}
