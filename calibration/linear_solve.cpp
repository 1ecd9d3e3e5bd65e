#include "calibration/linear_solve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "platform/host/error.hpp"

namespace aluminate::calibration {
namespace {

// A pivot of the scaled normal matrix below this is rounding: entries are sums of some 24 products of
// magnitude at most 1, each wrong by at most 2^-53, and elimination with partial pivoting keeps such errors
// below about 1e-14. Every system that an honest chart gives stays above 1e-9 (degree 5 of a channel mapped
// to [-1, 1]).
constexpr double kSingularPivot = 1e-13;

[[noreturn]] void refuse_singular(std::string_view what, std::size_t unknowns) {
  throw UserError(
      fmt::format("{}: the samples do not determine its {} coefficients: they have too few different colours",
                  what, unknowns),
      "use a simpler fit or a photograph in which more patches are usable");
}

}  // namespace

bool gauss_jordan(Table& a, Table& b, double singular) noexcept {
  const std::size_t n = a.rows;
  double largest = 0.0;
  for (const double value : a.values) {
    if (!std::isfinite(value)) return false;
    largest = std::max(largest, std::fabs(value));
  }
  for (std::size_t column = 0; column < n; ++column) {
    std::size_t pivot = column;
    for (std::size_t row = column + 1; row < n; ++row)
      if (std::fabs(a.at(row, column)) > std::fabs(a.at(pivot, column))) pivot = row;
    const double value = a.at(pivot, column);
    if (!(std::fabs(value) > singular * largest)) return false;
    for (std::size_t i = 0; i < n; ++i) std::swap(a.at(pivot, i), a.at(column, i));
    for (std::size_t i = 0; i < b.columns; ++i) std::swap(b.at(pivot, i), b.at(column, i));
    for (std::size_t i = 0; i < n; ++i) a.at(column, i) /= value;
    for (std::size_t i = 0; i < b.columns; ++i) b.at(column, i) /= value;
    for (std::size_t row = 0; row < n; ++row) {
      const double factor = a.at(row, column);
      if (row == column || factor == 0.0) continue;
      for (std::size_t i = 0; i < n; ++i) a.at(row, i) -= factor * a.at(column, i);
      for (std::size_t i = 0; i < b.columns; ++i) b.at(row, i) -= factor * b.at(column, i);
    }
  }
  return true;
}

Table least_squares(const Table& predictors, const Table& targets, std::span<const double> weights,
                    std::string_view what) {
  ALU_CHECK(predictors.rows == targets.rows && (weights.empty() || weights.size() == predictors.rows),
            "{} rows, {} targets, {} weights", predictors.rows, targets.rows, weights.size());
  const std::size_t n = predictors.columns, outputs = targets.columns;
  const auto weight = [&](std::size_t row) { return weights.empty() ? 1.0 : weights[row]; };
  std::size_t used = 0;
  std::vector<double> scale(n, 0.0);
  for (std::size_t row = 0; row < predictors.rows; ++row) {
    if (!(weight(row) > 0.0)) continue;  // an unusable patch may hold anything
    ++used;
    for (const Table* table : {&predictors, &targets})
      for (std::size_t i = 0; i < table->columns; ++i)
        if (!std::isfinite(table->at(row, i)))
          throw UserError(fmt::format("{}: a sample is not a finite number", what),
                          "is the photograph damaged?");
    for (std::size_t i = 0; i < n; ++i)
      scale[i] += weight(row) * predictors.at(row, i) * predictors.at(row, i);
  }
  if (used < n) {
    throw UserError(fmt::format("{}: {} usable patches for {} unknowns", what, used, n),
                    "use a simpler fit or a photograph in which more patches are usable");
  }
  for (double& s : scale) {
    if (!(s > 0.0)) refuse_singular(what, n);
    s = 1.0 / std::sqrt(s);
  }

  // Refinement: the residual of the first solution is solved for as well, which takes back most of what
  // squaring the condition number cost.
  Table solution(n, outputs);
  for (int pass = 0; pass < 3; ++pass) {
    Table normal(n, n), right(n, outputs);
    for (std::size_t row = 0; row < predictors.rows; ++row) {
      const double w = weight(row);
      if (!(w > 0.0)) continue;
      for (std::size_t i = 0; i < n; ++i) {
        const double p = w * predictors.at(row, i) * scale[i];
        for (std::size_t j = 0; j < n; ++j) normal.at(i, j) += p * predictors.at(row, j) * scale[j];
        for (std::size_t o = 0; o < outputs; ++o) {
          double rest = targets.at(row, o);
          for (std::size_t j = 0; j < n; ++j) rest -= predictors.at(row, j) * solution.at(j, o);
          right.at(i, o) += p * rest;
        }
      }
    }
    if (!gauss_jordan(normal, right, kSingularPivot)) refuse_singular(what, n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t o = 0; o < outputs; ++o) solution.at(i, o) += right.at(i, o) * scale[i];
  }
  return solution;
}

}  // namespace aluminate::calibration
