// Linear least squares by the normal equations and Gauss-Jordan elimination with partial pivoting
// [McAuley12], in double. Columns are scaled to unit length first, which costs nothing and removes the worst
// of the squared condition number. In: rows of predictors and of targets. Out: coefficients. A system that
// does not determine them is a UserError.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace aluminate::calibration {

/// rows * columns values, row-major.
struct Table {
  std::size_t rows = 0, columns = 0;
  std::vector<double> values;

  Table() = default;
  Table(std::size_t row_count, std::size_t column_count)
      : rows(row_count), columns(column_count), values(row_count * column_count, 0.0) {}
  double& at(std::size_t row, std::size_t column) { return values[row * columns + column]; }
  double at(std::size_t row, std::size_t column) const { return values[row * columns + column]; }
};

/// Reduces [a | b] to [1 | x] in place; the largest remaining pivot of a column is used. False when a pivot
/// is below `singular` times the largest entry of a (or a value is not finite): b is then meaningless.
[[nodiscard]] bool gauss_jordan(Table& a, Table& b, double singular) noexcept;

/// x (columns of predictors * columns of targets) that minimises sum_r w_r |p_r x - t_r|^2. Empty weights are
/// all 1. Throws UserError "what: ..." when there are fewer rows with weight than unknowns, when a value is
/// not finite, or when the predictors do not span their columns.
Table least_squares(const Table& predictors, const Table& targets, std::span<const double> weights,
                    std::string_view what);

}  // namespace aluminate::calibration
