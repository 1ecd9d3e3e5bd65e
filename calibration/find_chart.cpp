#include "calibration/find_chart.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "calibration/opencv_chart.hpp"
#include "calibration/patch_grid.hpp"
#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"

namespace aluminate::calibration {
namespace {

constexpr std::size_t kMinGridNodes = 8;
constexpr double kPatchReach =
    0.42;  // from its centre a patch reaches this far: it must lie inside of the photograph

PatchColours all_colours(const Photo& photo, const Corners& corners) {
  // Colours that tell charts from other things need no more; proposals come by the hundred.
  constexpr int kPixels = 400;
  const PatchSamples samples = sample_patches(photo, corners, kPixels);
  PatchColours colours = colours_of(samples);
  for (std::size_t i = 0; i < kPatchCount; ++i)
    colours.usable[i] = samples[i].pixels > 0;  // a clipped white is still white
  return colours;
}

bool patch_inside(const Photo& photo, const Homography& to_photo, const Point& centre) {
  for (const double dx : {-kPatchReach, kPatchReach})
    for (const double dy : {-kPatchReach, kPatchReach}) {
      const Point p = to_photo(centre + Point{dx, dy});
      if (!(p.x >= -0.5 && p.y >= -0.5 && p.x <= photo.width - 0.5 && p.y <= photo.height - 0.5))
        return false;
    }
  return true;
}

int patches_inside(const Photo& photo, const Corners& corners) {
  const Homography to_photo(corners);
  int count = 0;
  for (int row = 0; row < kChartRows; ++row)
    for (int column = 0; column < kChartColumns; ++column)
      count += patch_inside(photo, to_photo, {static_cast<double>(column), static_cast<double>(row)}) ? 1 : 0;
  return count;
}

// What the search has seen so far, for the answer or for the reason why there is none.
struct Search {
  const Photo& photo;
  const ChartReference& reference;
  FoundChart best;
  std::size_t largest_grid = 0;
  int cut_off_patches = 0;  // patches inside of the best chart that leaves the photograph
  double cut_off_agreement = 0.0;

  bool done() const { return best.agreement >= 0.88; }

  // A quadrilateral whose corners may be any turn of the right ones.
  void judge(const Corners& quadrilateral, const char* finder) {
    for (std::size_t turn = 0; turn < 4; ++turn) {
      Corners corners{};
      for (std::size_t i = 0; i < 4; ++i) corners[i] = quadrilateral[(i + turn) % 4];
      const double columns = length(corners[1] - corners[0]) + length(corners[2] - corners[3]);
      const double rows = length(corners[2] - corners[1]) + length(corners[3] - corners[0]);
      if (!(columns > rows * 0.7)) continue;  // 5 : 3, however foreshortened a readable chart is
      judge_oriented(corners, finder);
    }
  }

  void judge_oriented(const Corners& corners, const char* finder) {
    try {
      const int inside_count = patches_inside(photo, corners);
      const double agreement = chart_agreement(all_colours(photo, corners), reference);
      if (inside_count < static_cast<int>(kPatchCount)) {
        if (inside_count >= 6 && agreement > cut_off_agreement) {
          cut_off_agreement = agreement;
          cut_off_patches = inside_count;
        }
        return;
      }
      check_corners(corners, photo.width, photo.height);
      if (agreement < 0.55 || agreement < best.agreement - 0.15) return;
      const Corners aligned = align_to_patches(photo, corners);
      const double aligned_agreement = chart_agreement(all_colours(photo, aligned), reference);
      if (aligned_agreement > best.agreement) best = {aligned, aligned_agreement, 0.0, finder};
    } catch (const UserError&) {
      // A proposal that is no quadrilateral or too small: not a chart.
    }
  }
};

// A homography through the nodes that agree with it.
Homography fit_grid(const PatchGrid& grid) {
  std::vector<Point> from, to;
  for (const GridNode& node : grid.nodes) {
    from.push_back({static_cast<double>(node.column), static_cast<double>(node.row)});
    to.push_back(node.centre);
  }
  for (int pass = 0; pass < 3; ++pass) {
    const Homography map(from, to);
    std::vector<Point> kept_from, kept_to;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const double pitch = length(map(from[i] + Point{1, 0}) - map(from[i]));
      if (length(map(from[i]) - to[i]) < 0.15 * pitch) {
        kept_from.push_back(from[i]);
        kept_to.push_back(to[i]);
      }
    }
    if (kept_from.size() == from.size() || kept_from.size() < kMinGridNodes) return map;
    from = std::move(kept_from);
    to = std::move(kept_to);
  }
  return Homography(from, to);
}

// All 6 x 4 and 4 x 6 windows of lattice coordinates that hold most of the grid's nodes.
void judge_grid(Search& search, const SmallPicture& picture, const PatchGrid& grid) {
  search.largest_grid = std::max(search.largest_grid, grid.nodes.size());
  std::set<std::pair<int, int>> places;
  int column_low = 100, column_high = -100, row_low = 100, row_high = -100;
  for (const GridNode& node : grid.nodes) {
    places.insert({node.column, node.row});
    column_low = std::min(column_low, node.column);
    column_high = std::max(column_high, node.column);
    row_low = std::min(row_low, node.row);
    row_high = std::max(row_high, node.row);
  }
  if (column_high == column_low || row_high == row_low) return;
  const Homography to_picture = fit_grid(grid);
  const auto corner = [&](int column, int row) {
    return picture.to_photo(to_picture({static_cast<double>(column), static_cast<double>(row)}));
  };
  for (const auto& [columns, rows] : {std::pair{6, 4}, std::pair{4, 6}})
    for (int row = row_low - rows + 2; row <= row_high - 1; ++row)
      for (int column = column_low - columns + 2; column <= column_high - 1; ++column) {
        std::size_t held = 0;
        for (int r = row; r < row + rows; ++r)
          for (int c = column; c < column + columns; ++c) held += places.contains({c, r}) ? 1 : 0;
        if (held < kMinGridNodes || held * 10 < std::min<std::size_t>(grid.nodes.size(), kPatchCount) * 7)
          continue;
        search.judge({corner(column, row), corner(column + columns - 1, row),
                      corner(column + columns - 1, row + rows - 1), corner(column, row + rows - 1)},
                     "grid");
      }
}

void search_grids(Search& search) {
  // From coarse to fine, so that a large chart is found at once; enlarged for patches of a few pixels.
  const double longest = std::max(search.photo.width, search.photo.height);
  for (const double side : {700.0, 1400.0, 2800.0}) {
    double scale = side / longest;
    if (scale > 1.0) scale = std::min(4.0, std::floor(scale));
    if (side > 700.0 && scale > 4.0) break;
    const SmallPicture picture = scaled_picture(search.photo, scale);
    const std::vector<float> steepness = steepness_of(picture);
    // Edges in lightness: noise of a dim photograph needs a high bar, a chart out of focus a low one.
    for (const float edge : {0.05f, 0.025f, 0.1f, 0.012f}) {
      for (const PatchGrid& grid : find_grids(picture, steepness, edge, kMinGridNodes)) {
        try {
          judge_grid(search, picture, grid);
        } catch (const UserError&) {
          // Nodes on one line determine no position.
        }
        if (search.done()) return;
      }
    }
    if (search.best.agreement >= kMinAgreement || scale >= 4.0) return;
  }
}

// How wide the sharpest edges of the photograph are, in px of a picture of 700 px: contrast over slope.
double sharpest_edges_px(const Photo& photo) {
  const SmallPicture picture =
      scaled_picture(photo, std::min(1.0, 700.0 / std::max(photo.width, photo.height)));
  std::vector<double> widths;
  constexpr int kReach = 40;  // an edge wider than twice this is none
  for (int y = kReach; y + kReach < picture.height; y += 3)
    for (int x = kReach; x + kReach < picture.width; x += 3) {
      double slope = 0.0, low = 1e9, high = -1e9;
      for (int t = -kReach; t <= kReach; ++t) {
        const double v = static_cast<double>(picture.pixel(x + t, y)[1]);
        low = std::min(low, v);
        high = std::max(high, v);
        if (t > -kReach)
          slope = std::max(slope, std::fabs(v - static_cast<double>(picture.pixel(x + t - 1, y)[1])));
      }
      if (high - low > 0.15) widths.push_back((high - low) / slope);
    }
  if (widths.size() < 20) return 0.0;  // nothing to see: not a question of focus
  std::nth_element(widths.begin(), widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 20),
                   widths.end());
  return widths[widths.size() / 20];
}

[[noreturn]] void refuse(const Search& search, const std::string& name) {
  const char* const corners_hint =
      "if it is there, give the centres of its corner patches: --corners x,y;x,y;x,y;x,y (dark skin, bluish "
      "green, black, white)";
  if (search.cut_off_agreement >= 0.9 && search.cut_off_patches < static_cast<int>(kPatchCount)) {
    throw UserError({name},
                    fmt::format("the chart is cut off: {} of its 24 patches are inside of the picture",
                                search.cut_off_patches),
                    "photograph the whole chart");
  }
  if (const double width = sharpest_edges_px(search.photo); width > 7.0) {
    throw UserError({name},
                    fmt::format("no ColorChecker was found, and the picture is blurred: its sharpest edges "
                                "are {:.0f} px wide in a width of 700",
                                width),
                    "focus on the chart");
  }
  if (search.largest_grid >= 10) {
    throw UserError({name},
                    fmt::format("no complete ColorChecker was found: a grid of {} areas is there, but its "
                                "colours are not those of the chart's 24 patches",
                                search.largest_grid),
                    "is a part of it cut off or covered? photograph the whole chart");
  }
  throw UserError({name}, "no ColorChecker was found", corners_hint);
}

}  // namespace

ChartFinder parse_chart_finder(std::string_view name) {
  static const std::vector<std::string> known{"auto", "grid", "opencv"};
  const auto found = std::find(known.begin(), known.end(), name);
  if (found == known.end())
    throw UserError(fmt::format("unknown finder '{}'", name), host::did_you_mean(name, known));
  return static_cast<ChartFinder>(found - known.begin());
}

FoundChart find_chart(const Photo& photo, const ChartReference& reference, const std::string& name,
                      ChartFinder finder) {
  Search search{photo, reference, {}};
  if (finder != ChartFinder::OpenCv) search_grids(search);
  if (finder == ChartFinder::OpenCv ||
      (finder == ChartFinder::Auto && search.best.agreement < kMinAgreement)) {
    for (const Corners& quadrilateral : opencv_charts(photo)) search.judge(quadrilateral, "opencv mcc");
  }
  if (search.best.agreement < kMinAgreement) refuse(search, name);
  search.best.edge_width = chart_edge_width(photo, search.best.corners);
  if (search.best.edge_width > kMaxEdgeWidth) {
    throw UserError(
        {name},
        fmt::format(
            "the chart is blurred: its edges are {:.0f} % of a patch wide, so that colours of neighbours mix",
            100.0 * search.best.edge_width),
        "focus on the chart, or hold the camera still");
  }
  return search.best;
}

FoundChart check_chart(const Photo& photo, const Corners& corners, const ChartReference& reference,
                       const std::string& name) {
  check_corners(corners, photo.width, photo.height);
  const int inside_count = patches_inside(photo, corners);
  if (inside_count < static_cast<int>(kPatchCount)) {
    throw UserError(
        {name},
        fmt::format("the chart is cut off: {} of its 24 patches are inside of the picture", inside_count),
        "photograph the whole chart");
  }
  const auto agreement_of = [&](const Corners& trial) {
    return chart_agreement(all_colours(photo, trial), reference);
  };
  const double agreement = agreement_of(corners);
  if (agreement < kMinAgreement) {
    static constexpr std::array<std::string_view, 4> kNames{"dark skin", "bluish green", "black", "white"};
    for (std::size_t turn = 1; turn < 4; ++turn) {
      Corners trial{};
      for (std::size_t i = 0; i < 4; ++i) trial[i] = corners[(i + turn) % 4];
      if (agreement_of(trial) < kMinAgreement) continue;
      throw UserError({name},
                      fmt::format("the corners are in a wrong order: the first is {}, expected dark skin",
                                  kNames[(4 - turn) % 4]),
                      "the order is dark skin, bluish green, black, white");
    }
    throw UserError(
        {name},
        fmt::format(
            "the colours between the corners are not a ColorChecker's (agreement {:.2f}, {:.2f} is needed)",
            agreement, kMinAgreement),
        "give the centres of the corner patches dark skin, bluish green, black, white");
  }
  const double edge_width = chart_edge_width(photo, corners);
  if (edge_width > kMaxEdgeWidth) {
    throw UserError(
        {name},
        fmt::format(
            "the chart is blurred: its edges are {:.0f} % of a patch wide, so that colours of neighbours mix",
            100.0 * edge_width),
        "focus on the chart, or hold the camera still");
  }
  return {corners, agreement, edge_width, "corners"};
}

}  // namespace aluminate::calibration
