#include "calibration/report.hpp"

#include <algorithm>
#include <cmath>

#include "calibration/srgb_codes.hpp"
#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"

namespace aluminate::calibration {
namespace {

constexpr int kLongestPx = 900;

// Calls paint(mean linear colour, target) for every texel of a reduced picture.
template <class Paint>
host::Image8 reduced(const Photo& photo, Paint&& paint) {
  const double scale = std::min(1.0, static_cast<double>(kLongestPx) / std::max(photo.width, photo.height));
  host::Image8 image{std::max(1, static_cast<int>(photo.width * scale)),
                     std::max(1, static_cast<int>(photo.height * scale)),
                     3,
                     {}};
  image.texels.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
  host::parallel_for(
      image.height,
      [&](std::int64_t row) {
        const int y0 = static_cast<int>(row * photo.height / image.height),
                  y1 = std::max(y0 + 1, static_cast<int>((row + 1) * photo.height / image.height));
        std::uint8_t* to =
            image.texels.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) * 3;
        for (int x = 0; x < image.width; ++x, to += 3) {
          const int x0 = static_cast<int>(std::int64_t{x} * photo.width / image.width);
          const int x1 =
              std::max(x0 + 1, static_cast<int>((std::int64_t{x} + 1) * photo.width / image.width));
          Colour sum{};
          for (int yy = y0; yy < y1; ++yy)
            for (int xx = x0; xx < x1; ++xx)
              for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(photo.pixel(xx, yy)[c]);
          for (double& value : sum) value /= static_cast<double>((x1 - x0) * (y1 - y0));
          paint(sum, to);
        }
      },
      4);
  return image;
}

void paint_srgb(const Colour& colour, std::uint8_t* to) {
  for (std::size_t c = 0; c < 3; ++c) to[c] = SrgbCodes::instance().code8(static_cast<float>(colour[c]));
}

std::string base64(const std::vector<std::uint8_t>& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) three = three << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63u];
  }
  return text;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<'   ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '&' ? "&amp;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

std::string css_colour(const Colour& linear) {
  std::uint8_t code[3];
  paint_srgb(linear, code);
  return fmt::format("#{:02x}{:02x}{:02x}", code[0], code[1], code[2]);
}

Colour xyy_of(const Colour& rgb) { return xyz_to_xyy(rgb_to_xyz(rgb)); }

// The diagram's window: x 0.1 .. 0.7, y 0.0 .. 0.65, one unit 700 px.
constexpr double kDiagramPx = 700.0, kLeftX = 0.1, kTopY = 0.65, kDiagramWidth = 0.6, kDiagramHeight = 0.65;
Point diagram(const Colour& xyy) { return {(xyy[0] - kLeftX) * kDiagramPx, (kTopY - xyy[1]) * kDiagramPx}; }

struct Outline {
  std::array<Point, 4> corners;  // of one patch's sampled window, in thumbnail px
};

std::vector<Outline> sampled_windows(const Calibration& calibration, int thumbnail_width) {
  const double scale = static_cast<double>(thumbnail_width) / calibration.width;
  const Homography to_photo(calibration.chart.corners);
  std::vector<Outline> outlines;
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    Outline outline;
    static constexpr std::array<Point, 4> kAround{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
    for (std::size_t k = 0; k < 4; ++k) {
      const Point p =
          to_photo(Point{static_cast<double>(i % kChartColumns), static_cast<double>(i / kChartColumns)} +
                   kSampledHalfWidth * kAround[k]);
      outline.corners[k] = scale * p;
    }
    outlines.push_back(outline);
  }
  return outlines;
}

std::string picture_html(const host::Image8& image, const std::string& over = "") {
  return fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\"><image width=\"{0}\" height=\"{1}\" "
      "href=\"data:image/png;base64,{2}\"/>{3}</svg>\n",
      image.width, image.height, base64(host::encode_png(image)), over);
}

std::string diagram_svg(const Calibration& calibration) {
  const ChartReference& reference = chart_reference(calibration.options.edition);
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" class=\"diagram\">\n"
      "<defs><marker id=\"tip\" markerWidth=\"6\" markerHeight=\"6\" refX=\"5\" refY=\"3\" "
      "orient=\"auto\"><path d=\"M0,0 L6,3 L0,6\"/></marker></defs>\n",
      kDiagramWidth * kDiagramPx, kDiagramHeight * kDiagramPx);
  const Point r = diagram({0.64, 0.33, 0}), g = diagram({0.30, 0.60, 0}), b = diagram({0.15, 0.06, 0});
  svg += fmt::format("<path class=\"gamut\" d=\"M{:.1f},{:.1f} L{:.1f},{:.1f} L{:.1f},{:.1f} Z\"/>\n", r.x,
                     r.y, g.x, g.y, b.x, b.y);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const Point target = diagram(xyy_of(reference.rgb_lin[i])),
                before = diagram(xyy_of(calibration.patches[i].mean)),
                after = diagram(xyy_of(calibration.fit.fit.corrected[i]));
    svg += fmt::format("<line class=\"before\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>",
                       before.x, before.y, target.x, target.y);
    svg += fmt::format(
        "<line class=\"after\" marker-end=\"url(#tip)\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" "
        "y2=\"{:.1f}\"/>",
        target.x, target.y, after.x, after.y);
    svg +=
        fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\" fill=\"{}\"><title>{} {}</title></circle>\n",
                    target.x, target.y, css_colour(reference.rgb_lin[i]), i + 1, patch_names()[i]);
  }
  return svg + "</svg>\n";
}

void draw_line(host::Image8& image, Point a, Point b, host::Rgb8 colour) {
  const int steps =
      std::max(1, static_cast<int>(std::ceil(std::max(std::fabs(b.x - a.x), std::fabs(b.y - a.y)))));
  for (int i = 0; i <= steps; ++i) {
    const Point p = a + static_cast<double>(i) / steps * (b - a);
    const int x = static_cast<int>(std::lround(p.x)), y = static_cast<int>(std::lround(p.y));
    if (x < 0 || y < 0 || x >= image.width || y >= image.height) continue;
    std::uint8_t* to =
        image.texels.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                                   static_cast<std::size_t>(x));
    to[0] = colour.r;
    to[1] = colour.g;
    to[2] = colour.b;
  }
}

void draw_arrow(host::Image8& image, Point from, Point to, host::Rgb8 colour) {
  draw_line(image, from, to, colour);
  const double size = length(to - from);
  if (size < 2.0) return;
  const Point along = (5.0 / size) * (to - from), across{-along.y, along.x};
  draw_line(image, to, to - along + 0.5 * across, colour);
  draw_line(image, to, to - along - 0.5 * across, colour);
}

void paste(host::Image8& page, const host::Image8& picture, int left, int top) {
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(
        picture.texels.data() + 3 * static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width),
        3 * static_cast<std::size_t>(picture.width),
        page.texels.data() + 3 * (static_cast<std::size_t>(y + top) * static_cast<std::size_t>(page.width) +
                                  static_cast<std::size_t>(left)));
}

constexpr const char* kStyle =
    "body{font:14px "
    "sans-serif;margin:2em;max-width:960px;color:#222}table{border-collapse:collapse}td,th{padding:2px "
    "10px;text-align:right}"
    "td:nth-child(2),th:nth-child(2){text-align:left}tr:nth-child(even){background:#f4f4f4}.swatch{width:"
    "28px}svg{max-width:100%;height:auto;margin:.3em 0}"
    ".window{fill:none;stroke:#0f0;stroke-width:1.5}.unused{stroke:#f00}.diagram{border:1px solid "
    "#ccc}.gamut{fill:none;stroke:#bbb}"
    ".before{stroke:#c60;stroke-dasharray:3 "
    "3}.after{stroke:#06c;stroke-width:1.5}circle{stroke:#333}.warning{color:#a00}.number{font:11px "
    "sans-serif;fill:#0f0;text-anchor:middle}";

}  // namespace

host::Image8 thumbnail(const Photo& photo) { return reduced(photo, paint_srgb); }

host::Image8 range_picture(const Photo& corrected) {
  return reduced(corrected, [](const Colour& colour, std::uint8_t* to) {
    const double luminance = rgb_to_xyz(colour)[1];
    if (luminance > kBrightestAlbedo) return paint_srgb({1, 0, 1}, to);
    if (luminance < kDarkestAlbedo) return paint_srgb({0, 1, 1}, to);
    paint_srgb(colour, to);
  });
}

std::string report_html(const Calibration& calibration, const ReportPictures& pictures) {
  const ChartReference& reference = chart_reference(calibration.options.edition);
  const Fit& fit = calibration.fit.fit;
  std::string overlay;
  const std::vector<Outline> windows = sampled_windows(calibration, pictures.before.width);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    std::string points;
    Point middle;
    for (const Point& p : windows[i].corners) {
      points += fmt::format("{:.1f},{:.1f} ", p.x, p.y);
      middle = middle + 0.25 * p;
    }
    overlay += fmt::format("<polygon class=\"window{}\" points=\"{}\"><title>{} {}</title></polygon>",
                           calibration.patches[i].usable() ? "" : " unused", points, i + 1, patch_names()[i]);
    if (i == 0 || i == 5 || i == 18 || i == 23)
      overlay += fmt::format("<text class=\"number\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>", middle.x,
                             middle.y + 4, i + 1);
  }
  std::string html = fmt::format(
      "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>calibration of "
      "{0}</title><style>{1}</style>\n<h1>{0}</h1>\n<p>{2}</p>\n",
      escaped(calibration.photo), kStyle, escaped(verdict_line(calibration)));
  for (const std::string& warning : calibration.warnings)
    html += fmt::format("<p class=\"warning\">{}</p>\n", escaped(warning));
  html +=
      "<h2>The chart in the photograph</h2>\n<p>Green: what was sampled. Red: patches that were not "
      "used.</p>\n" +
      picture_html(pictures.before, overlay);
  html += "<h2>Albedo</h2>\n" + picture_html(pictures.after);
  const CorrectionCounts& c = calibration.counts;
  const double percent = 100.0 / static_cast<double>(std::max<std::int64_t>(c.pixels, 1));
  html += fmt::format(
      "<h2>Plausible materials</h2>\n<p>Luminance above {:g} in magenta ({:.2f} % of pixels), below {:g} in "
      "cyan ({:.2f} %). Negative and clipped: {:.2f} %. "
      "Above 1: {:.2f} %. At a limit of the photograph, and therefore a guess: {:.2f} %.</p>\n",
      kBrightestAlbedo, percent * static_cast<double>(c.too_bright), kDarkestAlbedo,
      percent * static_cast<double>(c.too_dark), percent * static_cast<double>(c.negative),
      percent * static_cast<double>(c.above_one), percent * static_cast<double>(c.clipped_input));
  html += picture_html(pictures.range);
  html +=
      "<h2>Chromaticity</h2>\n<p>Orange: from the photograph to the reference. Blue: what remains. Triangle: "
      "sRGB.</p>\n" +
      diagram_svg(calibration);
  html +=
      "<h2>Patches</h2>\n<table><tr><th></th><th>patch</th><th>photo</th><th>albedo</th><th>reference</"
      "th><th>dE2000 before</th><th>after</th><th>luminance</th><th>note</th></tr>\n";
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const PatchSample& sample = calibration.patches[i];
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td class=\"swatch\" style=\"background:{}\"></td><td class=\"swatch\" "
        "style=\"background:{}\"></td><td class=\"swatch\" style=\"background:{}\"></td>"
        "<td>{:.2f}</td><td>{:.2f}</td><td>{:.3f}</td><td>{}</td></tr>\n",
        i + 1, patch_names()[i], css_colour(sample.mean), css_colour(fit.corrected[i]),
        css_colour(reference.rgb_lin[i]), fit.before.de2000[i], fit.after.de2000[i],
        rgb_to_xyz(fit.corrected[i])[1],
        sample.is_clipped()                   ? "clipped"
        : sample.is_uneven()                  ? "uneven"
        : outside_gamut(reference.rgb_lin[i]) ? "outside of sRGB"
                                              : "");
  }
  return html + "</table></html>\n";
}

std::vector<std::uint8_t> report_png(const Calibration& calibration, const ReportPictures& pictures) {
  constexpr int kMargin = 16, kTitle = 30, kTextPx = 16, kLinePx = 22;
  const int diagram_width = static_cast<int>(kDiagramWidth * kDiagramPx),
            diagram_height = static_cast<int>(kDiagramHeight * kDiagramPx);
  // Two columns, two rows: photograph and albedo over plausibility and chromaticity; sentences at the bottom.
  const host::Image8& first = pictures.before;
  static constexpr std::array<const char*, 4> kTitles{
      "photograph; green: sampled, red: not used", "albedo",
      "magenta: brighter, cyan: darker than materials are",
      "xy; orange: photograph to reference, blue: what remains"};
  int column = std::max(first.width, diagram_width);
  for (const char* title : kTitles) column = std::max(column, host::text_width(title, kTextPx));
  const int left = kMargin, right = column + 2 * kMargin, top = kMargin + kTitle,
            below = top + first.height + kMargin + kTitle;
  std::vector<std::string> lines{verdict_line(calibration)};
  for (const std::string& warning : calibration.warnings) lines.push_back("warning: " + warning);
  const int text_top = below + std::max(first.height, diagram_height) + kMargin;
  int width = right + column + kMargin;
  for (const std::string& line : lines)
    width = std::max(width, left + host::text_width(line, kTextPx) + kMargin);
  host::Image8 page{width, text_top + static_cast<int>(lines.size()) * kLinePx + kMargin, 3, {}};
  page.texels.assign(static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height) * 3, 250);
  const auto write = [&](int x, int y, const std::string& text) {
    host::draw_text(page, x, y, text, kTextPx, {40, 40, 40});
  };
  for (std::size_t i = 0; i < kTitles.size(); ++i)
    write(i % 2 == 0 ? left : right, (i < 2 ? top : below) - 8, kTitles[i]);
  for (std::size_t i = 0; i < lines.size(); ++i)
    write(left, text_top + static_cast<int>(i + 1) * kLinePx - 6, lines[i]);

  host::Image8 before = pictures.before;
  const std::vector<Outline> windows = sampled_windows(calibration, before.width);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    for (std::size_t k = 0; k < 4; ++k)
      draw_line(before, windows[i].corners[k], windows[i].corners[(k + 1) % 4],
                calibration.patches[i].usable() ? host::Rgb8{0, 255, 0} : host::Rgb8{255, 0, 0});
  paste(page, before, left, top);
  paste(page, pictures.after, right, top);
  paste(page, pictures.range, left, below);
  const Point origin{static_cast<double>(right), static_cast<double>(below)};
  const auto at = [&](const Colour& xyy) { return origin + diagram(xyy); };
  const std::array<Colour, 3> gamut{{{0.64, 0.33, 0}, {0.30, 0.60, 0}, {0.15, 0.06, 0}}};
  for (std::size_t i = 0; i < 3; ++i) draw_line(page, at(gamut[i]), at(gamut[(i + 1) % 3]), {180, 180, 180});
  const ChartReference& reference = chart_reference(calibration.options.edition);
  for (std::size_t i = 0; i < kPatchCount; ++i) {
    const Point target = at(xyy_of(reference.rgb_lin[i])),
                found = at(xyy_of(calibration.fit.fit.corrected[i]));
    draw_line(page, at(xyy_of(calibration.patches[i].mean)), target, {204, 102, 0});
    for (const double angle : {0.0, 0.8, 1.6, 2.4}) {
      const Point arm{3.0 * std::cos(angle), 3.0 * std::sin(angle)};
      draw_line(page, target - arm, target + arm, {60, 60, 60});
    }
    draw_arrow(page, target, found, {0, 102, 204});
  }
  return host::encode_png(page);
}

}  // namespace aluminate::calibration
