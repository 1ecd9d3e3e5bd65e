// The only file that includes libpng.
#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <string>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/exif.hpp"
#include "platform/host/image_readers.hpp"

namespace aluminate::host {
namespace {

struct Source {
  std::span<const std::uint8_t> left;
  std::string failure;
};

void read_bytes_of(png_structp png, png_bytep to, std::size_t count) {
  Source& source = *static_cast<Source*>(png_get_io_ptr(png));
  if (count > source.left.size()) png_error(png, "the data ends early");
  std::memcpy(to, source.left.data(), count);
  source.left = source.left.subspan(count);
}

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  static_cast<Source*>(png_get_error_ptr(png))->failure = text;
  png_longjmp(png, 1);
}
void on_warning(png_structp, png_const_charp) {}  // odd metadata

/// libpng leaves by longjmp, which runs no destructors: this object lives outside of every frame that is jumped over.
class Decoder {
 public:
  explicit Decoder(std::span<const std::uint8_t> encoded) : source_{encoded, {}} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, on_error, on_warning);
    info_ = png_ != nullptr ? png_create_info_struct(png_) : nullptr;
    ALU_CHECK(info_ != nullptr, "libpng");
    png_set_read_fn(png_, &source_, read_bytes_of);
  }
  ~Decoder() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  bool read_header() noexcept {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_user_limits(png_, 0x7fffffff, 0x7fffffff);  // our own limits come with our own words
    png_read_info(png_, info_);
    const int depth = png_get_bit_depth(png_, info_), type = png_get_color_type(png_, info_);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (type == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(png_);
    if (png_get_valid(png_, info_, PNG_INFO_tRNS) != 0) png_set_tRNS_to_alpha(png_);
    if (depth == 16 && std::endian::native == std::endian::little) png_set_swap(png_);
    png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }
  bool read_rows(png_bytepp rows) noexcept {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_read_image(png_, rows);
    png_read_end(png_, info_);  // what follows the texels may be damaged too; EXIF may come last
    return true;
  }

  const std::string& failure() const { return source_.failure; }
  std::int64_t width() const { return png_get_image_width(png_, info_); }
  std::int64_t height() const { return png_get_image_height(png_, info_); }
  int channels() const { return png_get_channels(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_); }
  std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  int orientation() const {
    png_bytep exif = nullptr;
    png_uint_32 size = 0;
    return png_get_eXIf_1(png_, info_, &size, &exif) != 0 ? exif_orientation({exif, size}) : 1;
  }

 private:
  Source source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

ImageCodes decode_png(std::span<const std::uint8_t> encoded, const std::string& name) {
  Decoder decoder(encoded);
  const auto refuse = [&] { throw UserError({name}, fmt::format("cannot read the png image: {}", decoder.failure())); };
  if (!decoder.read_header()) refuse();
  check_image_size(name, decoder.width(), decoder.height(), 1, decoder.channels());
  ImageCodes image;
  image.width = static_cast<int>(decoder.width());
  image.height = static_cast<int>(decoder.height());
  image.channels = decoder.channels();
  image.stored = decoder.bits() == 16 ? StoredAs::Unorm16 : StoredAs::Unorm8;
  const std::size_t row_bytes = decoder.row_bytes();
  image.bytes.resize(row_bytes * static_cast<std::size_t>(image.height));
  std::fill(image.bytes.begin(), image.bytes.end(), std::uint8_t{0});  // interlaced rows are filled bit by bit
  std::vector<png_bytep> rows(static_cast<std::size_t>(image.height));
  for (std::size_t y = 0; y < rows.size(); ++y) rows[y] = image.bytes.data() + y * row_bytes;
  if (!decoder.read_rows(rows.data())) refuse();
  image.orientation = decoder.orientation();
  return image;
}

}  // namespace aluminate::host
