// Platform files: TOML text in, a checked GpuModel out. The files of this folder are embedded at build time,
// so the program needs no data files; a user may name a file of his own. The schema is one table
// (platform_file.cpp) that drives loading, docs/cost_model.md and `platform show`. Nothing here computes a
// cost.
#pragma once

#include "platform/console/gpu_model.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::console {

/// One number of the schema. low_limit/high_limit refuse the absurd; both ends are allowed values.
struct FigureField {
  std::string_view table, key;  // [texture] trilinear_cyc
  Figure& (*of)(GpuModel&);
  double low_limit, high_limit;
  bool whole;           // must be an integer
  bool optional_table;  // the whole table may be absent
  std::string_view unit, meaning;
};
std::span<const FigureField> figure_fields();

struct PlatformEntry {
  std::string_view id;    // "xenos"
  std::string_view text;  // the TOML, embedded
};
std::span<const PlatformEntry> builtin_platforms();  // sorted by id

/// A built-in id ("xenos") or a path ("my.toml": anything with '/' or ending in ".toml").
/// Throws UserError: unknown name (with the nearest one), unreadable file, or file:line:column for any key
/// that is unknown, missing, wrongly typed, negative, out of limits, without source or without confidence.
GpuModel load_platform(const std::string& name_or_path);

/// The same from text; `path` names it in messages.
GpuModel parse_platform(std::string_view toml_text, const std::string& path);

/// Every figure as a fixed-width text table: value, unit, range, confidence, source. At most 100 columns.
std::string format_platform(const GpuModel& model);

}  // namespace aluminate::console
