// `eval brdf` in the VM against the binary64 reference, over points that stress it: grazing angles, narrow
// lobes, no reflectance at all.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "platform/host/error.hpp"
#include "shading/brdf/specular.hpp"
#include "shading/report/evaluate.hpp"

namespace aluminate::report {
namespace {

struct Point {
  double g, cspec;
  brdf::Cosines cosines;
};

std::vector<Point> stress_points(int count) {
  std::mt19937 random(1337);
  const auto unit = [&] { return std::generate_canonical<double, 53>(random); };
  const auto cosine = [&] {
    switch (random() % 5) {
      case 0:
        return 0.0;
      case 1:
        return 1.0;
      case 2:
        return unit() * unit() * unit() * unit();
      case 3:
        return 1.0 - 0.1 * std::pow(unit(), 4);
      default:
        return unit();
    }
  };
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    const double edge = std::pow(10.0, -7.0 * unit());
    points.push_back({random() % 4 ? unit() : double(random() % 2),
                      random() % 4 ? unit() : double(random() % 2) * 0.04,
                      {cosine(), cosine(), random() % 2 ? 1.0 - edge : unit(), cosine()}});
  }
  return points;
}

Csv csv_of(const std::vector<Point>& points) {
  Csv csv;
  csv.columns = {"g", "n_dot_l", "n_dot_v", "n_dot_h", "h_dot_v", "cspec"};
  for (const Point& p : points)
    csv.rows.push_back(
        {p.g, p.cosines.n_dot_l, p.cosines.n_dot_v, p.cosines.n_dot_h, p.cosines.h_dot_v, p.cspec});
  csv.text.assign(points.size(), std::vector<std::string>(6, "0"));
  return csv;
}

std::vector<double> values_of(const Evaluation& evaluation) {
  const Csv csv = parse_csv(evaluation.csv, "result");
  std::vector<double> values;
  for (const auto& row : csv.rows) values.push_back(row.back());
  return values;
}

TEST(EvalBrdf, AgreesWithTheReferenceInEveryVariant) {
  const std::vector<Point> points = stress_points(3000);
  const Csv csv = csv_of(points);
  for (const auto& visibility : brdf::kVisibilityTerms)
    for (const auto& fresnel : brdf::kFresnelTerms)
      for (const char* format : {"ref64", "fx31"}) {
        const bool exact = std::string(format) == "ref64";
        const std::vector<double> values = values_of(
            evaluate_brdf(csv, "points", visibility.id, fresnel.id, *number::parse_number_format(format)));
        double worst = 0;
        int compared = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const double expected =
              brdf::specular(points[i].g, points[i].cosines, points[i].cspec, {visibility.id, fresnel.id});
          if (exact ? expected < 1e-100 : expected < 1e-3 || expected > 0x1p19) continue;
          ++compared;
          worst = std::max(worst, std::abs(values[i] - expected) / expected);
        }
        EXPECT_GT(compared, 500) << visibility.name << " " << fresnel.name << " " << format;
        EXPECT_LE(worst, exact ? 1e-11 : 2e-4) << visibility.name << " " << fresnel.name << " " << format;
      }
}

TEST(EvalBrdf, ValuesOutOfRangeAreClampedAndReported) {
  // V = 6435 and norm = 1024 at double grazing: 6.6e6 is more than fx31's 2^20.
  const Evaluation evaluation =
      evaluate_brdf(csv_of({{1.0, 1.0, {0, 0, 1, 0}}}), "points", brdf::Visibility::SchlickSmith,
                    brdf::Fresnel::Schlick, *number::parse_number_format("fx31"));
  EXPECT_GT(evaluation.saturations, 0u);
  EXPECT_EQ(evaluation.saturated_rows, std::vector<std::size_t>{1});
  EXPECT_NEAR(values_of(evaluation)[0], 0x1p20, 1e-6);
}

TEST(EvalBrdf, ColumnsAreCheckedByName) {
  const auto format = *number::parse_number_format("fx31");
  EXPECT_THROW(evaluate_brdf(parse_csv("g,n_dot_l\n1,1\n", "t"), "t", {}, {}, format), UserError);
  EXPECT_THROW(evaluate_brdf(parse_csv("g,n_dot_l,n_dot_v,n_dot_h,h_dot_v,cspec,extra\n1,1,1,1,1,1,1\n", "t"),
                             "t", {}, {}, format),
               UserError);
  for (const char* text : {"", "a,a\n1,2\n", "a,b\n1\n", "a\nx\n", "a,\n1,2\n", "a\n1e\n"})
    EXPECT_THROW(parse_csv(text, "t"), UserError) << text;
}

}  // namespace
}  // namespace aluminate::report
