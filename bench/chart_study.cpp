// How robust is the search for the chart? Random photographs of a chart, with a known answer: any turn,
// perspective, size, exposure, colour cast, tone curve, noise, blur and uneven light; and photographs without
// a whole chart. `chart_study COUNT` (100 without it) prints how many were found rightly, wrongly and not at all, and what
// the missed ones had in common. The figures in docs/calibration.md come from here.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>

#include "calibration/find_chart.hpp"
#include "platform/host/error.hpp"
#include "tests/calibration/synthetic_photo.hpp"

namespace {

using namespace aluminate;
using namespace aluminate::calibration;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0;
  }

 private:
  std::mt19937 engine_;
};

struct Trial {
  test::Scene scene;
  double width = 0, gradient = 0, exposure = 1;
  std::string text() const {
    return fmt::format(
        "chart {:.0f} px wide at {:.0f},{:.0f}, exposure {:.2f}, gamma {:.2f}, noise {:.3f}, blur {:.1f} px, "
        "light {:.0f} % uneven",
        width, scene.corners[0].x, scene.corners[0].y, exposure, scene.camera.gamma, scene.camera.noise,
        scene.blur_px, 100 * gradient);
  }
};

Trial random_trial(unsigned seed) {
  Random random(seed);
  Trial trial;
  test::Scene& scene = trial.scene;
  scene.width = 800;
  scene.height = 600;
  scene.seed = seed;
  scene.edition = seed % 2 == 0 ? ChartEdition::After2014 : ChartEdition::Before2014;
  trial.width = random.between(90, 480);
  const double angle = random.between(0, 2 * std::numbers::pi), c = std::cos(angle), s = std::sin(angle);
  const double reach = 0.5 * trial.width * 1.3;
  const Point middle{random.between(std::min(reach, 399.0), 800 - std::min(reach, 399.0)),
                     random.between(std::min(reach, 299.0), 600 - std::min(reach, 299.0))};
  for (std::size_t i = 0; i < 4; ++i) {
    const Point arm = (trial.width / 5.0) * (kChartCorners[i] - Point{2.5, 1.5});
    // Perspective: each corner moves by up to 6 % of the width.
    const Point jitter{random.between(-0.06, 0.06) * trial.width, random.between(-0.06, 0.06) * trial.width};
    scene.corners[i] = middle + Point{c * arm.x - s * arm.y, s * arm.x + c * arm.y} + jitter;
  }
  scene.camera = test::realistic_camera();
  trial.exposure = std::exp2(random.between(-3.0, 0.1));
  for (double& gain : scene.camera.balance) gain = trial.exposure * random.between(0.6, 1.0);
  scene.camera.gamma = random.between(0.8, 1.25);
  scene.camera.noise = random.between(0.0, 0.03);
  scene.blur_px = random.between(0.0, 0.08) * trial.width / 5.0;
  trial.gradient = random.between(0.0, 0.5);
  const double turn = random.between(0, 2 * std::numbers::pi), gradient = trial.gradient;
  scene.change = [=](const Point& chart, const Colour& colour) {
    const double across =
        (std::cos(turn) * (chart.x - 2.5) + std::sin(turn) * (chart.y - 1.5)) / 3.0;  // about -1 .. 1
    const double light = 1.0 - 0.5 * gradient * (1.0 + std::max(-1.0, std::min(across, 1.0)));
    return Colour{light * colour[0], light * colour[1], light * colour[2]};
  };
  return trial;
}

double worst_centre_error(const Corners& found, const Corners& truth) {
  const auto a = patch_centres(found), b = patch_centres(truth);
  double worst = 0.0;
  for (std::size_t i = 0; i < kPatchCount; ++i) worst = std::max(worst, length(a[i] - b[i]));
  return worst / chart_width_px(truth);
}

bool whole(const test::Scene& scene) {
  const Homography to_photo(scene.corners);
  for (const double x : {-0.45, 5.45})
    for (const double y : {-0.45, 3.45}) {
      const Point p = to_photo({x, y});
      if (p.x < 0 || p.y < 0 || p.x > scene.width - 1 || p.y > scene.height - 1) return false;
    }
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  const int trials = count > 1 ? std::atoi(arguments[1]) : 100;
  int right = 0, wrong = 0, refused = 0, without = 0, false_alarms = 0;
  for (int i = 0; i < trials; ++i) {
    Trial trial = random_trial(static_cast<unsigned>(i) + 1);
    if (i % 10 == 4) trial.scene.has_chart = false;
    if (i % 10 == 9) {  // its middle on the right edge
      const double middle = 0.5 * (trial.scene.corners[0].x + trial.scene.corners[2].x);
      for (Point& p : trial.scene.corners) p.x += trial.scene.width - middle;
    }
    const bool has_whole = trial.scene.has_chart && whole(trial.scene);
    const Photo photo = photo_of(test::photograph(trial.scene), Encoding::Srgb, "photo");
    without += has_whole ? 0 : 1;
    try {
      const FoundChart found = find_chart(photo, chart_reference(ChartEdition::After2014), "photo");
      const double error = worst_centre_error(found.corners, trial.scene.corners);
      if (!has_whole) {
        ++false_alarms;
        fmt::print("{}: found where there is no whole chart, agreement {:.2f}: {}\n", i, found.agreement,
                   trial.text());
      } else if (error < 0.02) {
        ++right;
      } else {
        ++wrong;
        fmt::print("{}: wrong by {:.0f} % of the width, agreement {:.2f}: {}\n", i, 100 * error,
                   found.agreement, trial.text());
      }
    } catch (const UserError& error) {
      if (!has_whole) continue;
      ++refused;
      fmt::print("{}: {}: {}\n", i, error.what(), trial.text());
    }
  }
  fmt::print("with a whole chart: {} right, {} wrong, {} refused; without: {}, of them {} found\n", right,
             wrong, refused, without, false_alarms);
  return 0;
}
