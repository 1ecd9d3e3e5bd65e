#include "calibration/calibration_files.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

using Json = nlohmann::ordered_json;

Json rounded(double value, double unit) { return std::round(value / unit) * unit; }

Json json_of(const Affine& affine) {
  Json rows = Json::array();
  for (const auto& row : affine.m) rows.push_back(row);
  return rows;
}

Json json_of(const Transform& transform) {
  Json out;
  out["name"] = transform_name(transform);
  if (const auto* linear = std::get_if<LinearFit>(&transform)) {
    out["space"] = "linear sRGB";
    out["formula"] = "out = M (r, g, b, 1)";
    out["matrix"] = json_of(linear->matrix);
  } else if (const auto* tone = std::get_if<ToneLinear>(&transform)) {
    out["space"] = "linear sRGB";
    out["formula"] = "out = M (r^e, g^e, b^e, 1)";
    out["exponent"] = tone->exponent;
    out["matrix"] = json_of(tone->matrix);
  } else if (const auto* root = std::get_if<RootPolynomial>(&transform)) {
    out["space"] = "linear sRGB";
    out["formula"] = "out = sum of term * coefficient; negative r, g, b are 0";
    for (std::size_t t = 0; t < root->coefficients.size(); ++t)
      out["coefficients"][std::string(root_term_names()[t])] = root->coefficients[t];
  } else if (const auto* chain = std::get_if<AffinePolyAffine>(&transform)) {
    out["space"] = "xyY of linear sRGB, D65";
    out["formula"] =
        "xyY = A1 (x, y, Y, 1); each of x, y, Y = sum a[j] v^j, its tangent outside of the range; A2 (x, y, "
        "Y, 1); y >= 1e-4 and Y >= 0 after each";
    out["degree"] = chain->degree;
    out["first"] = json_of(chain->first);
    for (std::size_t c = 0; c < 3; ++c) {
      const Polynomial& p = chain->polynomials[c];
      out["polynomials"].push_back(
          {{"channel", std::array{"x", "y", "Y"}[c]},
           {"coefficients", std::vector<double>(p.a.begin(), p.a.begin() + chain->degree + 1)},
           {"range", {p.low, p.high}}});
    }
    out["last"] = json_of(chain->last);
  }
  return out;
}

}  // namespace

std::string calibration_json(const Calibration& calibration, const std::string& command) {
  const ChartReference& reference = chart_reference(calibration.options.edition);
  const Fit& fit = calibration.fit.fit;
  Json out;
  out["schema"] = "aluminate.calibrate/1";
  out["tool"] = "aluminate";
  out["command"] = command;
  out["inputs"] = {{{"file", calibration.photo}, {"hash", calibration.photo_hash}}};
  out["photo"] = {
      {"width", calibration.width}, {"height", calibration.height}, {"kind", calibration.photo_kind}};
  Json& chart = out["chart"];
  chart["edition"] = edition_name(calibration.options.edition);
  chart["found_by"] = calibration.chart.finder;
  chart["agreement"] = rounded(calibration.chart.agreement, 1e-6);
  chart["edge_width"] = rounded(calibration.chart.edge_width, 1e-6);
  for (const Point& p : calibration.chart.corners)
    chart["corners_px"].push_back({rounded(p.x, 1e-3), rounded(p.y, 1e-3)});
  chart["reference_outside_srgb"] = reference.outside_gamut;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const PatchSample& sample = calibration.patches[i];
    out["patches"].push_back({{"number", i + 1},
                              {"name", patch_names()[i]},
                              {"centre_px", {rounded(sample.centre.x, 1e-3), rounded(sample.centre.y, 1e-3)}},
                              {"photo_lin", sample.mean},
                              {"photo_sd_lin", sample.deviation},
                              {"pixels", sample.pixels},
                              {"outliers", sample.outliers},
                              {"clipped_share", std::max(sample.clipped_high, sample.clipped_low)},
                              {"unevenness", sample.unevenness},
                              {"used", sample.usable()},
                              {"corrected_lin", fit.corrected[i]},
                              {"reference_lin", reference.rgb_lin[i]},
                              {"de2000_before", fit.before.de2000[i]},
                              {"de2000_after", fit.after.de2000[i]},
                              {"de76_after", fit.after.de76[i]}});
  }
  out["transform"] = json_of(fit.transform);
  out["stage_rms_xyy"] = fit.stage_rms;
  out["errors"] = {
      {"mean_de2000_before", fit.before.mean_de2000}, {"mean_de2000_after", fit.after.mean_de2000},
      {"max_de2000_after", fit.after.max_de2000},     {"mean_de76_before", fit.before.mean_de76},
      {"mean_de76_after", fit.after.mean_de76},       {"held_out_de2000", fit.held_out_de2000}};
  for (const Candidate& candidate : calibration.fit.candidates)
    out["candidates"].push_back(
        {{"name", candidate.name},
         {"held_out_de2000", candidate.held_out_de2000 ? Json(*candidate.held_out_de2000) : Json(nullptr)},
         {"objection", candidate.objection}});
  const CorrectionCounts& counts = calibration.counts;
  out["albedo"] = {{"pixels", counts.pixels},
                   {"negative_clipped", counts.negative},
                   {"above_one", counts.above_one},
                   {"darker_than_materials", counts.too_dark},
                   {"brighter_than_materials", counts.too_bright},
                   {"clipped_in_photo", counts.clipped_input},
                   {"white_luminance", rgb_to_xyz(fit.corrected[kWhitePatch])[1]},
                   {"black_luminance", rgb_to_xyz(fit.corrected[kBlackPatch])[1]}};
  out["warnings"] = calibration.warnings;
  return out.dump(2) + "\n";
}

std::string cube_text(const Transform& transform, int size, const std::string& title) {
  if (size < 2 || size > 129)
    throw UserError(fmt::format("a cube of {} points a side", size), "expected 2 to 129; 33 is usual");
  const std::size_t n = static_cast<std::size_t>(size);
  std::vector<double> linear(n);
  for (std::size_t i = 0; i < n; ++i) linear[i] = srgb_to_linear(static_cast<double>(i) / (size - 1));
  std::vector<std::string> slices(n);
  host::parallel_for(size, [&](std::int64_t blue) {
    std::string& text = slices[static_cast<std::size_t>(blue)];
    for (std::size_t green = 0; green < n; ++green)
      for (std::size_t red = 0; red < n; ++red) {
        const Colour out =
            correct(transform, {linear[red], linear[green], linear[static_cast<std::size_t>(blue)]});
        for (std::size_t c = 0; c < 3; ++c)
          text += fmt::format("{:.6f}{}", std::clamp(linear_to_srgb(std::max(out[c], 0.0)), 0.0, 1.0),
                              c < 2 ? ' ' : '\n');
      }
  });
  std::string quoted = title;
  std::replace(quoted.begin(), quoted.end(), '"', '\'');
  std::string text = fmt::format(
      "# sRGB-encoded photograph in, sRGB-encoded albedo out\nTITLE \"{}\"\nLUT_3D_SIZE {}\nDOMAIN_MIN 0.0 "
      "0.0 0.0\nDOMAIN_MAX 1.0 1.0 1.0\n",
      quoted, size);
  for (const std::string& slice : slices) text += slice;
  return text;
}

std::string material_gltf(const std::string& texture, int width, int height) {
  const float x = static_cast<float>(width) / static_cast<float>(std::max(width, height)),
              y = static_cast<float>(height) / static_cast<float>(std::max(width, height));
  // Four corners: position, normal, texture coordinate; then two triangles, counter-clockwise from the front.
  const std::array<float, 32> vertices{-x, -y, 0, 0, 0, 1, 0, 1, x,  -y, 0, 0, 0, 1, 1, 1,
                                       x,  y,  0, 0, 0, 1, 1, 0, -x, y,  0, 0, 0, 1, 0, 0};
  const std::array<std::uint16_t, 6> indices{0, 1, 2, 0, 2, 3};
  std::string bytes;
  for (const float value : vertices)
    for (int i = 0; i < 4; ++i)
      bytes += static_cast<char>(std::bit_cast<std::uint32_t>(value) >> (8 * i) & 255u);
  for (const std::uint16_t value : indices)
    for (int i = 0; i < 2; ++i) bytes += static_cast<char>(value >> (8 * i) & 255u);
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      base64 += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63u];
  }
  const auto accessor = [](int offset, const char* type, int component, int count, int view) {
    return Json{{"bufferView", view},
                {"byteOffset", offset},
                {"componentType", component},
                {"count", count},
                {"type", type}};
  };
  Json position = accessor(0, "VEC3", 5126, 4, 0);
  position["min"] = {-x, -y, 0.0f};
  position["max"] = {x, y, 0.0f};
  Json out;
  out["asset"] = {{"version", "2.0"}, {"generator", "aluminate calibrate"}};
  out["scene"] = 0;
  out["scenes"] = {{{"nodes", {0}}}};
  out["nodes"] = {{{"mesh", 0}, {"name", "albedo"}}};
  out["meshes"] = {{{"primitives",
                     {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
                       {"indices", 3},
                       {"material", 0}}}}}};
  out["materials"] = {
      {{"name", "measured albedo"},
       {"pbrMetallicRoughness",
        {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}}}};
  out["textures"] = {{{"source", 0}}};
  out["images"] = {{{"uri", texture}}};
  out["accessors"] = {position, accessor(12, "VEC3", 5126, 4, 0), accessor(24, "VEC2", 5126, 4, 0),
                      accessor(0, "SCALAR", 5123, 6, 1)};
  out["bufferViews"] = {
      {{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 128}, {"byteStride", 32}, {"target", 34962}},
      {{"buffer", 0}, {"byteOffset", 128}, {"byteLength", 12}, {"target", 34963}}};
  out["buffers"] = {
      {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64}}};
  return out.dump(2) + "\n";
}

}  // namespace aluminate::calibration
