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

void receive(void* context, const raw_module::Facts* facts, const std::uint16_t* samples, std::size_t pitch) {
  Mosaic& mosaic = *static_cast<Mosaic*>(context);
  mosaic.width = facts->width;
  mosaic.height = facts->height;
  const std::size_t width = static_cast<std::size_t>(facts->width);
  mosaic.samples.resize(width * static_cast<std::size_t>(facts->height));
  host::parallel_for(
      facts->height,
      [&](std::int64_t y) {
        const std::size_t row = static_cast<std::size_t>(y);
        std::copy_n(samples + row * pitch, width, mosaic.samples.data() + row * width);
      },
      64);
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

namespace {

// Linear light of every code of each colour: black 0, white 1, times the multiplier.
std::array<std::vector<float>, 3> levels_by_code(const Mosaic& mosaic) {
  const int greatest = mosaic.samples.empty() ? 0 : *std::max_element(mosaic.samples.begin(), mosaic.samples.end());
  std::array<std::vector<float>, 3> levels;
  for (std::size_t c = 0; c < 3; ++c) {
    levels[c].resize(static_cast<std::size_t>(greatest) + 1);
    for (int code = 0; code <= greatest; ++code)
      levels[c][static_cast<std::size_t>(code)] = static_cast<float>(
          (code - mosaic.black[c]) / (mosaic.white - mosaic.black[c]) * mosaic.multipliers[c]);
  }
  return levels;
}

// One row of Malvar, He and Cutler's linear 5 x 5 interpolation: bilinear plus a share of the Laplacian of the
// colour that was measured at the pixel [Malvar04]. Exact on areas of one colour, which is all a chart needs, and
// sharp on edges. line: with two pixels around it on every side, rows `stride` apart; green_x: 0 or 1, where the
// row's first green is; colour: 0 or 2, the row's other one. to: 3*width.
void interpolate_row(const float* line, std::ptrdiff_t stride, int width, int green_x, std::size_t colour,
                     float* to) noexcept {
  const auto at = [&](int x, int dx, int dy) { return static_cast<double>(line[dy * stride + x + dx]); };
  for (int x = green_x; x < width; x += 2) {
    const double here = at(x, 0, 0), beside = at(x, -1, 0) + at(x, 1, 0), above = at(x, 0, -1) + at(x, 0, 1),
                 diagonal = at(x, -1, -1) + at(x, 1, -1) + at(x, -1, 1) + at(x, 1, 1),
                 far_beside = at(x, -2, 0) + at(x, 2, 0), far_above = at(x, 0, -2) + at(x, 0, 2);
    float* rgb = to + 3 * x;
    rgb[colour] = static_cast<float>((5 * here + 4 * beside - diagonal - far_beside + 0.5 * far_above) / 8);
    rgb[1] = line[x];
    rgb[2 - colour] = static_cast<float>((5 * here + 4 * above - diagonal - far_above + 0.5 * far_beside) / 8);
  }
  for (int x = 1 - green_x; x < width; x += 2) {
    const double here = at(x, 0, 0), near = at(x, -1, 0) + at(x, 1, 0) + (at(x, 0, -1) + at(x, 0, 1)),
                 diagonal = at(x, -1, -1) + at(x, 1, -1) + at(x, -1, 1) + at(x, 1, 1),
                 far_beside = at(x, -2, 0) + at(x, 2, 0), far_above = at(x, 0, -2) + at(x, 0, 2);
    float* rgb = to + 3 * x;
    rgb[colour] = line[x];
    rgb[1] = static_cast<float>((4 * here + 2 * near - far_beside - far_above) / 8);
    rgb[2 - colour] = static_cast<float>((6 * here + 2 * diagonal - 1.5 * (far_beside + far_above)) / 8);
  }
}

}  // namespace

Photo demosaic(const Mosaic& mosaic, const std::string& kind) {
  if (mosaic.width < 2 || mosaic.height < 2) throw UserError("a mosaic needs at least 2 x 2 pixels");
  const int w = mosaic.width, h = mosaic.height;
  std::array<std::size_t, 4> colours{};
  for (std::size_t i = 0; i < 4; ++i) colours[i] = colour_index(mosaic.pattern[i]);
  const auto colour_at = [&](int x, int y) {
    return colours[static_cast<std::size_t>((y & 1) * 2 + (x & 1))];
  };

  // With a border of two pixels, so that the filter needs no bounds.
  constexpr int kBorder = 2;
  const auto mirrored = [](int at, int size) {  // keeps the parity, and with it the colour
    if (at < 0) at = -at;
    if (at >= size) at = 2 * (size - 1) - at;
    return std::clamp(at, 0, size - 1);
  };
  const std::ptrdiff_t stride = w + 2 * kBorder;
  const std::array<std::vector<float>, 3> levels = levels_by_code(mosaic);
  const auto put_levels = [&](int y, float* to) {
    const std::uint16_t* from = mosaic.samples.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(w);
    const float* const of_column[2] = {levels[colour_at(0, y)].data(), levels[colour_at(1, y)].data()};
    for (int x = 0; x < w; ++x) to[x + kBorder] = of_column[x & 1][from[x]];
    for (const int column : {0, 1, w + 2, w + 3}) {
      const int x = mirrored(column - kBorder, w);
      to[column] = of_column[x & 1][from[x]];
    }
  };

  Photo photo;
  photo.width = w;
  photo.height = h;
  photo.kind = kind;
  // 0.5 % below full: interpolation mixes full pixels with others.
  for (std::size_t c = 0; c < 3; ++c) photo.clip_high[c] = 0.995 * mosaic.multipliers[c];
  photo.rgb_lin.resize(mosaic.samples.size() * 3);
  constexpr int kBandRows = 32;  // its levels stay in the second-level cache
  host::parallel_for((h + kBandRows - 1) / kBandRows, [&](std::int64_t band) {
    const int begin = static_cast<int>(band) * kBandRows, end = std::min(begin + kBandRows, h);
    host::UninitializedVector<float> level(static_cast<std::size_t>(stride) * (kBandRows + 2 * kBorder));
    for (int row = begin - kBorder; row < end + kBorder; ++row)
      put_levels(mirrored(row, h), level.data() + (row - begin + kBorder) * stride);
    for (int y = begin; y < end; ++y) {
      const int green_x = colour_at(0, y) == 1 ? 0 : 1;
      interpolate_row(level.data() + (y - begin + kBorder) * stride + kBorder, stride, w, green_x, colour_at(1 - green_x, y),
                      photo.rgb_lin.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(w));
    }
  });
  apply_orientation(photo, mosaic.orientation);
  return photo;
}

}  // namespace aluminate::calibration
