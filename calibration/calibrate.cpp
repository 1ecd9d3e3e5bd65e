#include "calibration/calibrate.hpp"

#include <algorithm>
#include <filesystem>
#include <span>
#include <variant>
#include <vector>

#include "calibration/calibration_files.hpp"
#include "calibration/polarised.hpp"
#include "calibration/raw_file.hpp"
#include "calibration/report.hpp"
#include "platform/host/error.hpp"
#include "platform/host/hash.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

namespace fs = std::filesystem;

// A photograph and what its file says about the lens.
struct Loaded {
  Photo photo;
  LensQuery lens;
  std::string hash;
};

Loaded load(const std::string& path, const CalibrationOptions& options) {
  Loaded loaded;
  const std::vector<std::uint8_t> bytes = host::read_bytes(path);
  loaded.hash = host::hash_bytes(bytes).hex();
  if (looks_like_raw(bytes, path)) {
    const Mosaic mosaic = decode_raw(bytes, path);
    loaded.lens = {mosaic.maker, mosaic.model, mosaic.lens, mosaic.focal_mm, mosaic.aperture, 0.0};
    loaded.photo = demosaic(mosaic, fmt::format("raw, {} {}", mosaic.maker, mosaic.model));
  } else if (!options.bayer.empty()) {
    loaded.photo = demosaic(mosaic_of_grey(host::decode_float(bytes, path), options.bayer, path),
                            "Bayer mosaic " + options.bayer);
  } else {
    loaded.photo =
        std::visit([&](const auto& image) { return photo_of(image, options.input_encoding, path); },
                   host::decode_stored(bytes, path));
  }
  return loaded;
}

LensModel lens_for(const Loaded& loaded, const CalibrationOptions& options) {
  const int w = loaded.photo.width, h = loaded.photo.height;
  LensModel lens = parse_lens("none", w, h, options.focal_px);
  if (options.lens == "auto")
    lens = lens_from_database(loaded.lens, w, h);
  else if (!options.lens.empty())
    lens = parse_lens(options.lens, w, h, options.focal_px);
  if (options.vignette != std::array<double, 3>{}) lens.vignette = options.vignette;
  if (options.lateral != std::array<double, 2>{1, 1}) {
    lens.channel_scale[0] = {options.lateral[0], 0, 0};
    lens.channel_scale[2] = {options.lateral[1], 0, 0};
  }
  return lens;
}

Loaded load_straight(const std::string& path, const CalibrationOptions& options) {
  Loaded loaded = load(path, options);
  correct_lens(loaded.photo, lens_for(loaded, options));
  return loaded;
}

// What the diffuse transform makes of diffuse and specular light together, less the diffuse: the specular
// light on the albedo's scale. Exact for the linear fit.
Photo calibrated_specular(const Photo& diffuse, Photo specular, const Transform& transform) {
  const std::size_t width = static_cast<std::size_t>(specular.width);
  host::parallel_for(
      specular.height,
      [&](std::int64_t y) {
        const std::size_t first = 3 * width * static_cast<std::size_t>(y);
        const float* const base_rgb = diffuse.rgb_lin.data() + first;
        float* const rgb = specular.rgb_lin.data() + first;
        std::vector<double> columns(6 * width);
        double* const total = columns.data();
        double* const base = total + 3 * width;
        for (std::size_t x = 0; x < width; ++x)
          for (std::size_t c = 0; c < 3; ++c) {
            total[c * width + x] = static_cast<double>(rgb[3 * x + c] + base_rgb[3 * x + c]);
            base[c * width + x] = static_cast<double>(base_rgb[3 * x + c]);
          }
        for (double* of : {total, base}) correct(transform, of, of + width, of + 2 * width, width);
        for (std::size_t x = 0; x < width; ++x)
          for (std::size_t c = 0; c < 3; ++c)
            rgb[3 * x + c] = static_cast<float>(
                std::max(0.0, std::max(0.0, total[c * width + x]) - std::max(0.0, base[c * width + x])));
      },
      16);
  return specular;
}

bool has_ending(const std::string& path, std::string_view ending) { return path.ends_with(ending); }

void check_outputs(const CalibrationOptions& options, const CalibrationOutputs& outputs) {
  if (!outputs.image.empty()) check_output_name(outputs.image, options.format);
  if (!outputs.specular.empty()) {
    check_output_name(outputs.specular, options.format);
    if (options.parallel.empty())
      throw UserError("--specular needs two photographs", "give the parallel-polarised one with --parallel");
  }
  if (!outputs.report.empty() && !has_ending(outputs.report, ".html") &&
      !has_ending(outputs.report, ".png")) {
    throw UserError({outputs.report}, "expected a report that ends in .html or .png");
  }
  if (!outputs.material.empty()) {
    if (!has_ending(outputs.material, ".gltf"))
      throw UserError({outputs.material}, "expected a material that ends in .gltf");
    if (!has_ending(outputs.image, ".png"))
      throw UserError("a glTF material needs its albedo as a PNG", "let -o end in .png");
    if (options.format.encoding != Encoding::Srgb)
      throw UserError("a glTF base colour is stored as sRGB", "leave out --output-encoding linear");
  }
}

}  // namespace

Calibration calibrate(const std::string& photo_path, const CalibrationOptions& options,
                      const CalibrationOutputs& outputs, const std::string& command) {
  check_outputs(options, outputs);
  host::OutputSet files;  // before the work: an unwritable place is known at once
  const auto open = [&](const std::string& path) { return path.empty() ? nullptr : &files.add(path); };
  host::OutputFile *image = open(outputs.image), *json = open(outputs.json), *cube = open(outputs.cube),
                   *report = open(outputs.report), *material = open(outputs.material),
                   *specular_file = open(outputs.specular);

  Loaded loaded = load_straight(photo_path, options);
  Photo& photo = loaded.photo;
  std::optional<Photo> specular;
  if (!options.parallel.empty()) {
    Separated separated =
        separate_polarised(std::move(photo), load_straight(options.parallel, options).photo, options.leakage);
    photo = std::move(separated.diffuse);
    specular = std::move(separated.specular);
  }

  Calibration result;
  result.photo = photo_path;
  result.photo_kind = photo.kind;
  result.photo_hash = loaded.hash;
  result.width = photo.width;
  result.height = photo.height;
  result.options = options;
  const ChartReference& reference = chart_reference(options.edition);
  result.chart = options.corners ? check_chart(photo, *options.corners, reference, photo_path)
                                 : find_chart(photo, reference, photo_path, options.finder);
  result.patches = sample_patches(photo, result.chart.corners);
  try {
    result.fit = choose_fit(options.fit, options.degree, colours_of(result.patches), reference);
  } catch (const UserError& error) {
    throw UserError({photo_path}, error.what(), error.hint());
  }
  const Transform& transform = result.fit.fit.transform;

  ReportPictures pictures;
  if (report != nullptr) pictures.before = thumbnail(photo);
  const auto to = [](host::OutputFile& file) {
    return [&file](std::span<const std::uint8_t> bytes) { file.write(bytes); };
  };
  if (specular_file != nullptr)
    write_corrected(calibrated_specular(photo, std::move(*specular), transform), outputs.specular,
                    options.format, to(*specular_file));
  result.counts = image != nullptr
                      ? correct_and_write(photo, transform, outputs.image, options.format, to(*image))
                      : correct_photo(photo, transform);
  result.warnings = warnings_of(result);
  if (report != nullptr) {
    pictures.after = thumbnail(photo);
    pictures.range = range_picture(photo);
    if (has_ending(outputs.report, ".html"))
      report->write(report_html(result, pictures));
    else
      report->write(report_png(result, pictures));
  }
  if (json != nullptr) json->write(calibration_json(result, command));
  if (cube != nullptr)
    cube->write(cube_text(transform, options.cube_size, fs::path(photo_path).filename().string()));
  if (material != nullptr) {
    const fs::path folder = fs::absolute(outputs.material).parent_path();
    material->write(material_gltf(fs::absolute(outputs.image).lexically_relative(folder).generic_string(),
                                  result.width, result.height));
  }
  files.commit();
  return result;
}

}  // namespace aluminate::calibration
