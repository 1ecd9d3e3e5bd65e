#include "calibration/raw_file.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

#include "calibration/raw_module.hpp"
#include "platform/host/error.hpp"
#include "platform/host/module_file.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

raw_module::DecodeRaw open_decoder() {
  static const auto decoder = reinterpret_cast<raw_module::DecodeRaw>(host::open_module(
      raw_module::kFile, ALUMINATE_MODULE_DIR, raw_module::kSymbol, "reads camera raw files with LibRaw"));
  return decoder;
}

std::size_t colour_index(char name) { return name == 'R' ? 0 : name == 'B' ? 2 : 1; }

bool is_bayer(const std::array<char, 4>& pattern) {
  static constexpr std::array<std::string_view, 4> kKnown{"RGGB", "BGGR", "GRBG", "GBRG"};
  return std::find(kKnown.begin(), kKnown.end(), std::string_view(pattern.data(), 4)) != kKnown.end();
}

void receive(void* context, const raw_module::Facts* facts, const std::uint16_t* samples) {
  Mosaic& mosaic = *static_cast<Mosaic*>(context);
  mosaic.width = facts->width;
  mosaic.height = facts->height;
  mosaic.samples.assign(
      samples, samples + static_cast<std::size_t>(facts->width) * static_cast<std::size_t>(facts->height));
  std::copy_n(facts->pattern, 4, mosaic.pattern.begin());
  for (std::size_t c = 0; c < 3; ++c) mosaic.black[c] = facts->black[c];
  mosaic.white = facts->white;
  const double smallest =
      static_cast<double>(std::min({facts->multipliers[0], facts->multipliers[1], facts->multipliers[2]}));
  if (smallest > 0.0)
    for (std::size_t c = 0; c < 3; ++c)
      mosaic.multipliers[c] = static_cast<double>(facts->multipliers[c]) / smallest;
  mosaic.orientation = facts->flip;
  mosaic.maker = facts->maker;
  mosaic.model = facts->model;
  mosaic.lens = facts->lens;
  mosaic.focal_mm = static_cast<double>(facts->focal_mm);
  mosaic.aperture = static_cast<double>(facts->aperture);
}

}  // namespace

bool looks_like_raw(std::span<const std::uint8_t> bytes, const std::string& name) {
  const auto starts = [&](std::string_view magic, std::size_t at = 0) {
    return bytes.size() >= at + magic.size() &&
           std::memcmp(bytes.data() + at, magic.data(), magic.size()) == 0;
  };
  if (starts("FUJIFILMCCD-RAW") || starts("ftypcrx", 4) || starts("FOVb") || starts("IIU\0")) return true;
  // The others are TIFF inside: only their names tell them from pictures.
  static constexpr std::array<std::string_view, 14> kEndings{".dng", ".cr2", ".nef", ".nrw", ".arw",
                                                             ".sr2", ".orf", ".pef", ".rw2", ".raf",
                                                             ".cr3", ".srw", ".3fr", ".iiq"};
  std::string lower = name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return std::any_of(kEndings.begin(), kEndings.end(),
                     [&](std::string_view ending) { return lower.ends_with(ending); });
}

Mosaic decode_raw(std::span<const std::uint8_t> bytes, const std::string& name) {
  Mosaic mosaic;
  char text[200] = "";
  if (!open_decoder()(bytes.data(), bytes.size(), receive, &mosaic, text, sizeof text)) {
    throw UserError({name}, fmt::format("cannot read the raw file: {}", text),
                    "is it complete? convert it to DNG when the camera is newer than this LibRaw");
  }
  if (!is_bayer(mosaic.pattern)) {
    throw UserError({name},
                    fmt::format("the sensor's colours are arranged as '{}', expected a Bayer mosaic",
                                std::string_view(mosaic.pattern.data(), 4)),
                    "develop it to a linear 16-bit TIFF and use --encoding linear");
  }
  if (!(mosaic.white > *std::max_element(mosaic.black.begin(), mosaic.black.end()))) {
    throw UserError({name}, fmt::format("the white level {} is not above the black level", mosaic.white));
  }
  return mosaic;
}

Mosaic mosaic_of_grey(const host::ImageFloat& image, const std::string& pattern, const std::string& name) {
  Mosaic mosaic;
  if (pattern.size() == 4) std::copy_n(pattern.data(), 4, mosaic.pattern.begin());
  if (pattern.size() != 4 || !is_bayer(mosaic.pattern)) {
    const std::vector<std::string> known{"RGGB", "BGGR", "GRBG", "GBRG"};
    throw UserError(fmt::format("unknown Bayer pattern '{}'", pattern), host::did_you_mean(pattern, known));
  }
  if (image.channels.size() != 1 || image.stored == host::StoredAs::Float) {
    throw UserError({name}, fmt::format("expected a mosaic of one 8- or 16-bit channel, found {} channels",
                                        image.channels.size()));
  }
  mosaic.width = image.width;
  mosaic.height = image.height;
  mosaic.white = image.stored == host::StoredAs::Unorm8 ? 255 : 65535;
  mosaic.orientation = image.orientation;
  mosaic.samples.resize(image.texels.size());
  const std::size_t row = static_cast<std::size_t>(image.width);
  host::parallel_for(
      image.height,
      [&](std::int64_t y) {
        const std::size_t begin = static_cast<std::size_t>(y) * row;
        for (std::size_t i = begin; i < begin + row; ++i)
          mosaic.samples[i] =
              static_cast<std::uint16_t>(std::lround(static_cast<double>(image.texels[i]) * mosaic.white));
      },
      16);
  return mosaic;
}

// Malvar, He and Cutler's linear 5 x 5 interpolation: bilinear plus a share of the Laplacian of the colour
// that was measured at the pixel [Malvar04]. Exact on areas of one colour, which is all a chart needs, and
// sharp on edges.
Photo demosaic(const Mosaic& mosaic, const std::string& kind) {
  if (mosaic.width < 2 || mosaic.height < 2) throw UserError("a mosaic needs at least 2 x 2 pixels");
  const int w = mosaic.width, h = mosaic.height;
  std::array<std::size_t, 4> colours{};
  for (std::size_t i = 0; i < 4; ++i) colours[i] = colour_index(mosaic.pattern[i]);
  const auto colour_at = [&](int x, int y) {
    return colours[static_cast<std::size_t>((y & 1) * 2 + (x & 1))];
  };

  // Black 0, white 1, times the multiplier; with a border of two pixels, so that the filter below needs no
  // bounds.
  constexpr int kBorder = 2;
  const auto mirrored = [](int at, int size) {  // keeps the parity, and with it the colour
    if (at < 0) at = -at;
    if (at >= size) at = 2 * (size - 1) - at;
    return std::clamp(at, 0, size - 1);
  };
  const std::ptrdiff_t stride = w + 2 * kBorder;
  host::UninitializedVector<float> level(static_cast<std::size_t>(stride) *
                                         static_cast<std::size_t>(h + 2 * kBorder));
  host::parallel_for(
      h + 2 * kBorder,
      [&](std::int64_t row) {
        const int y = mirrored(static_cast<int>(row) - kBorder, h);
        const std::uint16_t* from =
            mosaic.samples.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
        float* to = level.data() + row * stride;
        const auto put = [&](int column, int x) {
          const std::size_t c = colour_at(x, y);
          to[column] = static_cast<float>((from[x] - mosaic.black[c]) / (mosaic.white - mosaic.black[c]) *
                                          mosaic.multipliers[c]);
        };
        for (int x = 0; x < w; ++x) put(x + kBorder, x);
        for (const int column : {0, 1, w + 2, w + 3}) put(column, mirrored(column - kBorder, w));
      },
      16);

  Photo photo;
  photo.width = w;
  photo.height = h;
  photo.kind = kind;
  // 0.5 % below full: interpolation mixes full pixels with others.
  for (std::size_t c = 0; c < 3; ++c) photo.clip_high[c] = 0.995 * mosaic.multipliers[c];
  photo.rgb_lin.resize(mosaic.samples.size() * 3);
  host::parallel_for(
      h,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        const float* const line = level.data() + (row + kBorder) * stride + kBorder;
        for (int x = 0; x < w; ++x) {
          const auto at = [&](int dx, int dy) { return static_cast<double>(line[dy * stride + x + dx]); };
          const double here = at(0, 0);
          const double beside = at(-1, 0) + at(1, 0), above = at(0, -1) + at(0, 1),
                       diagonal = at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1);
          const double far_beside = at(-2, 0) + at(2, 0), far_above = at(0, -2) + at(0, 2);
          Colour rgb{};
          const std::size_t mine = colour_at(x, y);
          rgb[mine] = here;
          if (mine == 1) {
            const std::size_t row_colour = colour_at(x + 1, y), column_colour = 2 - row_colour;
            rgb[row_colour] = (5 * here + 4 * beside - diagonal - far_beside + 0.5 * far_above) / 8;
            rgb[column_colour] = (5 * here + 4 * above - diagonal - far_above + 0.5 * far_beside) / 8;
          } else {
            rgb[1] = (4 * here + 2 * (beside + above) - far_beside - far_above) / 8;
            rgb[2 - mine] = (6 * here + 2 * diagonal - 1.5 * (far_beside + far_above)) / 8;
          }
          float* to = photo.rgb_lin.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(w) +
                                                  static_cast<std::size_t>(x));
          for (std::size_t c = 0; c < 3; ++c) to[c] = static_cast<float>(rgb[c]);
        }
      },
      8);
  apply_orientation(photo, mosaic.orientation);
  return photo;
}

}  // namespace aluminate::calibration
