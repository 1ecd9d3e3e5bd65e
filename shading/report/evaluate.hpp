// Shaders as functions: a CSV of inputs through the VM, a CSV of results out. Columns are found by name; what
// is not a number, missing or unknown is an error with line and column.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "platform/number/format.hpp"
#include "shading/brdf/fresnel.hpp"
#include "shading/brdf/visibility.hpp"
#include "shading/vm/program.hpp"

namespace aluminate::report {

/// Rows of numbers with named columns. `text` keeps every cell as it was written.
struct Csv {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;
  std::vector<std::vector<std::string>> text;
};

/// Comma-separated, first line names the columns, '#' starts a comment line. `path` names the file in
/// messages.
Csv parse_csv(const std::string& contents, const std::string& path);

struct Evaluation {
  std::string csv;                // the input columns as written, then the results (17 significant digits)
  std::uint64_t saturations = 0;  // results clamped to the format's range, over all rows
  std::vector<std::size_t> saturated_rows;  // 1-based data rows, at most the first 10
};

/// Columns g,n_dot_l,n_dot_v,n_dot_h,h_dot_v,cspec in any order; adds `value` = pi * specular f.
Evaluation evaluate_brdf(const Csv& inputs, const std::string& path, brdf::Visibility visibility,
                         brdf::Fresnel fresnel, const number::NumberFormat& format);

/// Columns named after the program's inputs ("TEXCOORD0.x") and uniforms ("light_color[1].y", "shininess");
/// those not given are 0. Adds one column for each component the program writes ("COLOR0.x").
Evaluation evaluate_shader(const Csv& inputs, const std::string& path, const vm::Program& program,
                           const number::NumberFormat& format);

}  // namespace aluminate::report
