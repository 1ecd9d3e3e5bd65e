#include "calibration/calibrate.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <new>

#include "calibration/calibration_files.hpp"
#include "calibration/polarised.hpp"
#include "calibration/raw_file.hpp"
#include "calibration/report.hpp"
#include "platform/host/error.hpp"
#include "platform/host/hash.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/interrupt.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/progress.hpp"
#include "platform/host/text_table.hpp"

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
    loaded.photo = photo_of(host::decode_float(bytes, path), options.input_encoding, path);
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
  Photo total = specular;
  for (std::size_t i = 0; i < total.rgb_lin.size(); ++i) total.rgb_lin[i] += diffuse.rgb_lin[i];
  correct_photo(total, transform);
  Photo base = diffuse;
  correct_photo(base, transform);
  for (std::size_t i = 0; i < specular.rgb_lin.size(); ++i)
    specular.rgb_lin[i] = std::max(0.0f, total.rgb_lin[i] - base.rgb_lin[i]);
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
  if (specular_file != nullptr)
    specular_file->write(encode_corrected(calibrated_specular(photo, std::move(*specular), transform),
                                          outputs.specular, options.format));
  result.counts = correct_photo(photo, transform);
  if (report != nullptr) {
    pictures.after = thumbnail(photo);
    pictures.range = range_picture(photo);
    if (has_ending(outputs.report, ".html"))
      report->write(report_html(result, pictures));
    else
      report->write(report_png(result, pictures));
  }
  if (image != nullptr) image->write(encode_corrected(photo, outputs.image, options.format));
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

std::string verdict_line(const Calibration& calibration) {
  const Fit& fit = calibration.fit.fit;
  return fmt::format("{}: dE2000 mean {:.2f} -> {:.2f}, max {:.2f}, held out {:.2f}",
                     transform_name(fit.transform), fit.before.mean_de2000, fit.after.mean_de2000,
                     fit.after.max_de2000, fit.held_out_de2000);
}

std::string summary_text(const Calibration& calibration) {
  const Fit& fit = calibration.fit.fit;
  const ChartReference& reference = chart_reference(calibration.options.edition);
  host::TextTable table({{"#", host::Align::Right},
                         {"patch"},
                         {"dE2000 before", host::Align::Right},
                         {"after", host::Align::Right},
                         {"luminance", host::Align::Right},
                         {"note"}});
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const PatchSample& sample = calibration.patches[i];
    std::string note;
    const auto add = [&](const std::string& text) { note += (note.empty() ? "" : ", ") + text; };
    if (sample.is_clipped())
      add(fmt::format("clipped ({:.0f} %), not used",
                      100.0 * std::max(sample.clipped_high, sample.clipped_low)));
    if (sample.is_uneven())
      add(fmt::format("uneven ({:.0f} %){}", 100.0 * sample.unevenness,
                      sample.unevenness > kUnevenRefused ? ", not used" : ""));
    if (outside_gamut(reference.rgb_lin[i])) add("reference outside of sRGB");
    table.add_row({fmt::format("{}", i + 1), std::string(patch_names()[i]),
                   fmt::format("{:.2f}", fit.before.de2000[i]), fmt::format("{:.2f}", fit.after.de2000[i]),
                   fmt::format("{:.3f}", rgb_to_xyz(fit.corrected[i])[1]), note});
  }
  std::string text = fmt::format(
      "{}: {} x {}, {}; chart {} (agreement {:.2f})\n", calibration.photo, calibration.width,
      calibration.height, calibration.photo_kind,
      calibration.chart.finder == "corners" ? "at the given corners" : "found by " + calibration.chart.finder,
      calibration.chart.agreement);
  text += table.text();
  if (calibration.fit.candidates.size() > 1) {
    text += "fits, by dE2000 of patches they were not fitted to:";
    for (const Candidate& candidate : calibration.fit.candidates)
      text += fmt::format(" {} {}{}", candidate.name,
                          candidate.held_out_de2000 ? fmt::format("{:.2f}", *candidate.held_out_de2000) : "-",
                          &candidate == &calibration.fit.candidates.back() ? "\n" : ";");
  }
  if (!fit.stage_rms.empty())
    text += fmt::format("xyY rms: photo {:.5f}, affine {:.5f}, polynomial {:.5f}, affine {:.5f}\n",
                        fit.stage_rms[0], fit.stage_rms[1], fit.stage_rms[2], fit.stage_rms[3]);
  text += fmt::format("{}; dE76 mean {:.2f} -> {:.2f}\n", verdict_line(calibration), fit.before.mean_de76,
                      fit.after.mean_de76);
  const CorrectionCounts& counts = calibration.counts;
  const double percent = 100.0 / static_cast<double>(std::max<std::int64_t>(counts.pixels, 1));
  const auto share = [&](std::int64_t count) { return percent * static_cast<double>(count); };
  text += fmt::format(
      "albedo: white {:.3f}, black {:.3f}; pixels darker than {:g}: {:.2f} %, brighter than {:g}: {:.2f} %, "
      "clipped at 0: {:.2f} %, above 1: {:.2f} %, at a limit of the photo: {:.2f} %\n",
      rgb_to_xyz(fit.corrected[kWhitePatch])[1], rgb_to_xyz(fit.corrected[kBlackPatch])[1], kDarkestAlbedo,
      share(counts.too_dark), kBrightestAlbedo, share(counts.too_bright), share(counts.negative),
      share(counts.above_one), share(counts.clipped_input));
  return text;
}

std::vector<BatchItem> calibrate_folder(const std::string& folder, const std::string& output_folder,
                                        const std::string& ending, const CalibrationOptions& options,
                                        const std::string& command) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw UserError({folder}, "expected a folder of photographs",
                    "without --batch one photograph is calibrated");
  static constexpr std::array<std::string_view, 14> kEndings{".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                                             ".exr", ".dng", ".cr2",  ".cr3", ".nef",
                                                             ".arw", ".orf", ".rw2",  ".pef"};
  std::vector<BatchItem> items;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::string kind = entry.path().extension().string();
    std::transform(kind.begin(), kind.end(), kind.begin(),
                   [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
    if (!entry.is_regular_file() || std::find(kEndings.begin(), kEndings.end(), kind) == kEndings.end())
      continue;
    items.push_back({entry.path().string(),
                     (fs::path(output_folder) / (entry.path().filename().string() + ending)).string(),
                     std::nullopt, ""});
  }
  if (items.empty()) throw UserError({folder}, "there is no picture in this folder");
  std::sort(items.begin(), items.end(),
            [](const BatchItem& a, const BatchItem& b) { return a.photo < b.photo; });
  host::make_directories(output_folder);
  host::Progress progress("calibrate", static_cast<std::int64_t>(items.size()));
  for (BatchItem& item : items) {
    host::throw_if_interrupted();
    try {
      item.done =
          calibrate(item.photo, options, {item.output, item.output + ".json", "", "", "", ""}, command);
    } catch (const UserError& refusal) {
      item.reason = refusal.what();
    } catch (const std::bad_alloc&) {
      item.reason = item.photo + ": not enough memory";
    }
    progress.advance();
  }
  return items;
}

std::string batch_text(const std::vector<BatchItem>& items) {
  std::string text;
  std::size_t done = 0;
  for (const BatchItem& item : items) {
    done += item.done ? 1 : 0;
    text += item.done ? fmt::format("ok      {}: {}\n", item.photo, verdict_line(*item.done))
                      : fmt::format("refused {}\n", item.reason);
  }
  return text + fmt::format("{} of {} photographs calibrated, {} refused\n", done, items.size(),
                            items.size() - done);
}

}  // namespace aluminate::calibration
