// The only file that includes libjpeg (libjpeg-turbo).
#include <csetjmp>
#include <cstddef>
#include <cstdio>
#include <cstring>

#include <jpeglib.h>

#include "platform/host/error.hpp"
#include "platform/host/exif.hpp"
#include "platform/host/image_readers.hpp"

namespace aluminate::host {
namespace {

struct Errors {
  jpeg_error_mgr base;  // first: the library knows only this part
  std::jmp_buf back;
  char text[JMSG_LENGTH_MAX];
};

[[noreturn]] void on_error(j_common_ptr info) {
  Errors& errors = *reinterpret_cast<Errors*>(info->err);
  errors.base.format_message(info, errors.text);
  std::longjmp(errors.back, 1);
}
// A warning is damaged data that the library would fill with something.
void on_message(j_common_ptr info, int level) {
  if (level < 0) on_error(info);
}

/// libjpeg leaves by longjmp, which runs no destructors: this object lives outside of every frame that is jumped over.
class Decoder {
 public:
  Decoder() {
    info_.err = jpeg_std_error(&errors_.base);
    errors_.base.error_exit = on_error;
    errors_.base.emit_message = on_message;
    errors_.text[0] = '\0';
  }
  ~Decoder() { jpeg_destroy_decompress(&info_); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  bool read_header(std::span<const std::uint8_t> encoded) noexcept {
    if (setjmp(errors_.back) != 0) return false;
    jpeg_create_decompress(&info_);
    jpeg_mem_src(&info_, encoded.data(), encoded.size());
    jpeg_save_markers(&info_, kExif, 0xffff);
    jpeg_read_header(&info_, TRUE);
    return true;
  }
  bool read_rows(std::uint8_t* to, std::size_t row_bytes) noexcept {
    if (setjmp(errors_.back) != 0) return false;
    jpeg_start_decompress(&info_);
    while (info_.output_scanline < info_.output_height) {
      JSAMPROW row = to + info_.output_scanline * row_bytes;
      jpeg_read_scanlines(&info_, &row, 1);
    }
    jpeg_finish_decompress(&info_);
    return true;
  }

  const char* failure() const { return errors_.text; }
  std::int64_t width() const { return info_.image_width; }
  std::int64_t height() const { return info_.image_height; }
  /// 1 or 3; 0 for what has no colours of its own.
  int channels() const {
    return info_.out_color_space == JCS_GRAYSCALE ? 1 : info_.out_color_space == JCS_RGB ? 3 : 0;
  }
  int orientation() const {
    static constexpr char kName[] = "Exif\0";  // and a second 0
    for (const jpeg_marker_struct* m = info_.marker_list; m != nullptr; m = m->next)
      if (m->marker == kExif && m->data_length > sizeof kName && std::memcmp(m->data, kName, sizeof kName) == 0)
        return exif_orientation({m->data + sizeof kName, m->data_length - sizeof kName});
    return 1;
  }

 private:
  static constexpr int kExif = JPEG_APP0 + 1;
  jpeg_decompress_struct info_{};
  Errors errors_{};
};

}  // namespace

std::optional<ImageCodes> decode_jpeg(std::span<const std::uint8_t> encoded, const std::string& name) {
  Decoder decoder;
  const auto refuse = [&] { throw UserError({name}, fmt::format("cannot read the jpeg image: {}", decoder.failure())); };
  if (!decoder.read_header(encoded)) refuse();
  if (decoder.channels() == 0) return std::nullopt;
  check_image_size(name, decoder.width(), decoder.height(), 1, decoder.channels());
  ImageCodes image;
  image.width = static_cast<int>(decoder.width());
  image.height = static_cast<int>(decoder.height());
  image.channels = decoder.channels();
  image.orientation = decoder.orientation();
  const std::size_t row_bytes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.channels);
  image.bytes.resize(row_bytes * static_cast<std::size_t>(image.height));
  if (!decoder.read_rows(image.bytes.data(), row_bytes)) refuse();
  return image;
}

}  // namespace aluminate::host
