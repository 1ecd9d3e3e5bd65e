// The only file that includes LibRaw. Built as a module that nothing links: see raw_module.hpp.
#include "calibration/raw_module.hpp"

#include <libraw/libraw.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>

namespace {

using namespace aluminate::calibration::raw_module;

template <std::size_t N>
void copy_text(char (&to)[N], const char* from) {
  std::snprintf(to, N, "%s", from);
}

bool decode_mosaic(const std::uint8_t* bytes, std::size_t count, Sink sink, void* context, char* text,
                   std::size_t text_size) {
  const auto fail = [&](const char* what) {
    std::snprintf(text, text_size, "%s", what);
    return false;
  };
  const auto raw = std::make_unique<LibRaw>();   // a megabyte: not for the stack
  raw->set_dataerror_handler(nullptr, nullptr);  // it would print; the error code says it too
  if (const int error = raw->open_buffer(const_cast<std::uint8_t*>(bytes), count); error != LIBRAW_SUCCESS)
    return fail(libraw_strerror(error));
  if (const int error = raw->unpack(); error != LIBRAW_SUCCESS) return fail(libraw_strerror(error));
  if (raw->imgdata.process_warnings & LIBRAW_WARN_RAWSPEED_PROBLEM) return fail("the sensor data is damaged");
  const libraw_data_t& data = raw->imgdata;
  if (data.rawdata.raw_image == nullptr) return fail("the file holds no mosaic of one sample a pixel");
  const auto& size = data.sizes;
  if (size.width < 2 || size.height < 2 || size.raw_pitch < 2) return fail("the sensor area is empty");

  Facts facts{};
  facts.width = size.width;
  facts.height = size.height;
  facts.flip = size.flip == 3 ? 3 : size.flip == 5 ? 8 : size.flip == 6 ? 6 : 1;
  facts.white = static_cast<std::int32_t>(data.color.maximum);
  const char* names = data.idata.cdesc;
  int quad[4];
  for (int i = 0; i < 4; ++i) {
    quad[i] = raw->COLOR(i / 2, i % 2);
    facts.pattern[i] = quad[i] >= 0 && quad[i] < 4 ? names[quad[i]] : '?';
  }
  for (int i = 0; i < 4; ++i) {
    facts.black[i] = static_cast<std::int32_t>(data.color.black + data.color.cblack[i]);
    facts.multipliers[i] = data.color.cam_mul[i];
  }
  // A black level that repeats over a block of pixels: taken when the block is the mosaic's own.
  const unsigned rows = data.color.cblack[4], columns = data.color.cblack[5];
  if (rows * columns > 0 && rows <= 2 && columns <= 2) {
    for (unsigned i = 0; i < 4; ++i) {
      const int colour = quad[i];
      if (colour >= 0 && colour < 4) {
        facts.black[colour] =
            static_cast<std::int32_t>(data.color.black + data.color.cblack[colour] +
                                      data.color.cblack[6 + (i / 2 % rows) * columns + i % 2 % columns]);
      }
    }
  }
  copy_text(facts.maker, data.idata.make);
  copy_text(facts.model, data.idata.model);
  copy_text(facts.lens, data.lens.Lens);
  facts.focal_mm = data.other.focal_len;
  facts.aperture = data.other.aperture;

  const std::size_t pitch = size.raw_pitch / sizeof(std::uint16_t);
  sink(context, &facts, data.rawdata.raw_image + size.top_margin * pitch + size.left_margin, pitch);
  return true;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) bool aluminate_decode_raw_v2(const std::uint8_t* bytes,
                                                                               std::size_t count, Sink sink,
                                                                               void* context, char* text,
                                                                               std::size_t text_size) {
  try {
    return decode_mosaic(bytes, count, sink, context, text, text_size);
  } catch (const std::exception& error) {
    std::snprintf(text, text_size, "%s", error.what());
  } catch (...) {
    std::snprintf(text, text_size, "the raw decoder failed");
  }
  return false;
}
