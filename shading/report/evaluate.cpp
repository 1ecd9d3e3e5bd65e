#include "shading/report/evaluate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "platform/host/error.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/workers.hpp"
#include "shading/passes/programs.hpp"
#include "shading/vm/executable.hpp"

namespace aluminate::report {
namespace {

std::string trimmed(std::string_view cell) {
  const auto first = cell.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return "";
  return std::string(cell.substr(first, cell.find_last_not_of(" \t\r") - first + 1));
}

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells;
  while (true) {
    const auto comma = line.find(',');
    cells.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// A column's place in the program: an input component or a uniform component.
struct Target {
  bool uniform = false;
  std::size_t at = 0;  // input: row; uniform: index into the constant bank
};

using Targets = std::map<std::string, Target, std::less<>>;

Targets targets_of(const vm::Program& program, const vm::Executable& executable) {
  Targets targets;
  const auto inputs = executable.inputs();
  for (std::size_t row = 0; row < inputs.size(); ++row)
    targets[fmt::format("{}.{}", program.inputs[inputs[row].index].semantic, "xyzw"[inputs[row].component])] =
        {false, row};
  for (const vm::UniformSymbol& symbol : program.uniforms)
    for (int r = 0; r < symbol.registers; ++r)
      for (int c = 0; c < symbol.components; ++c) {
        const std::size_t at =
            static_cast<std::size_t>(symbol.reg + r) * 4 + static_cast<std::size_t>(symbol.component + c);
        const std::string base = symbol.registers > 1 ? fmt::format("{}[{}]", symbol.name, r) : symbol.name;
        if (symbol.components == 1) targets[base] = {true, at};
        targets[fmt::format("{}.{}", base, "xyzw"[c])] = {true, at};
      }
  return targets;
}

std::uint64_t saturations_of(const vm::Counters& counters) {
  std::uint64_t sum = counters.sanitised_inputs;
  for (const std::uint64_t count : counters.saturations) sum += count;
  return sum;
}

// Runs every row as one lane. `results` receives one vector of output components a row.
struct Run {
  std::vector<std::vector<double>> results;
  std::uint64_t saturations = 0;
  std::vector<std::size_t> saturated_rows;
};

Run run_rows(const Csv& csv, const std::vector<Target>& column_targets, const vm::Program& program,
             const vm::Executable& executable) {
  Run run;
  vm::Scratch scratch(executable);
  vm::Counters counters(executable);
  host::AlignedRows inputs(executable.inputs().size()), outputs(executable.outputs().size());
  const std::vector<vm::SamplerBinding> samplers(program.samplers.size());
  std::vector<double> constants(static_cast<std::size_t>(program.uniform_count) * 4);
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    for (std::size_t c = 0; c < column_targets.size(); ++c) {
      const Target& target = column_targets[c];
      // All four lanes of the quad get the row, so that derivatives are 0.
      if (target.uniform)
        constants[target.at] = csv.rows[row][c];
      else
        std::fill_n(inputs.row(target.at), 4, csv.rows[row][c]);
    }
    const vm::ConstantBank bank = vm::quantise_constants(executable.format(), constants);
    vm::Batch batch;
    batch.inputs = inputs.data();
    batch.outputs = outputs.data();
    batch.constants = bank.values.data();
    batch.samplers = samplers;
    batch.active = 0xf;
    batch.covered = 1;
    const std::uint64_t before = saturations_of(counters);
    vm::run(executable, batch, scratch, counters);
    vm::raise_loop_overrun(program, counters);
    const std::uint64_t saturated = saturations_of(counters) - before + bank.sanitised;
    run.saturations += saturated;
    if (saturated && run.saturated_rows.size() < 10) run.saturated_rows.push_back(row + 1);
    std::vector<double> result;
    for (std::size_t r = 0; r < outputs.count() && r < executable.outputs().size(); ++r)
      result.push_back(outputs.row(r)[0]);
    run.results.push_back(std::move(result));
  }
  return run;
}

std::string joined(const Csv& csv, const std::vector<std::string>& added,
                   const std::vector<std::vector<double>>& results, const std::vector<std::size_t>& picked) {
  std::string text = fmt::format("{},{}\n", fmt::join(csv.columns, ","), fmt::join(added, ","));
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    text += fmt::format("{}", fmt::join(csv.text[row], ","));
    for (const std::size_t component : picked) text += fmt::format(",{:.17g}", results[row][component]);
    text += "\n";
  }
  return text;
}

[[noreturn]] void unknown_column(const std::string& path, const std::string& column,
                                 const std::vector<std::string>& known) {
  throw UserError(SourcePlace{path, 1, 0}, fmt::format("unknown column '{}'", column),
                  host::did_you_mean(column, known));
}

}  // namespace

Csv parse_csv(const std::string& contents, const std::string& path) {
  Csv csv;
  std::string_view rest = contents;
  if (rest.starts_with("\xef\xbb\xbf")) rest.remove_prefix(3);  // byte order mark of spreadsheets
  for (int line = 1; !rest.empty(); ++line) {
    const auto end = rest.find('\n');
    const std::string_view text = rest.substr(0, end);
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    const std::string content = trimmed(text);
    if (content.empty() || content[0] == '#') continue;
    const std::vector<std::string> cells = cells_of(text);
    if (csv.columns.empty()) {
      csv.columns = cells;
      for (std::size_t i = 0; i < cells.size(); ++i)
        if (cells[i].empty() || std::find(cells.begin(), cells.begin() + static_cast<std::ptrdiff_t>(i),
                                          cells[i]) != cells.begin() + static_cast<std::ptrdiff_t>(i))
          throw UserError(SourcePlace{path, line, static_cast<int>(i) + 1},
                          fmt::format("column name '{}' is empty or used twice", cells[i]));
      continue;
    }
    if (cells.size() != csv.columns.size())
      throw UserError(SourcePlace{path, line, 0},
                      fmt::format("expected {} values, got {}", csv.columns.size(), cells.size()),
                      "every line has one value for each column of the first");
    std::vector<double> values;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      double value = 0;
      const auto [stop, error] = std::from_chars(cells[i].data() + (cells[i].starts_with('+') ? 1 : 0),
                                                 cells[i].data() + cells[i].size(), value);
      if (error != std::errc{} || stop != cells[i].data() + cells[i].size())
        throw UserError(SourcePlace{path, line, static_cast<int>(i) + 1},
                        fmt::format("column {}: '{}' is not a number", csv.columns[i], cells[i]));
      values.push_back(value);
    }
    csv.rows.push_back(std::move(values));
    csv.text.push_back(cells);
  }
  if (csv.columns.empty())
    throw UserError(SourcePlace{path, 1, 0}, "no columns: the file is empty",
                    "the first line names the columns");
  return csv;
}

Evaluation evaluate_brdf(const Csv& inputs, const std::string& path, brdf::Visibility visibility,
                         brdf::Fresnel fresnel, const number::NumberFormat& format) {
  const vm::Program program = passes::compile_eval_brdf(visibility, fresnel);
  const vm::Executable executable = vm::prepare(program, format);
  static const std::map<std::string, std::string, std::less<>> kColumns = {
      {"n_dot_l", "TEXCOORD0.x"}, {"n_dot_v", "TEXCOORD0.y"}, {"n_dot_h", "TEXCOORD0.z"},
      {"h_dot_v", "TEXCOORD0.w"}, {"g", "TEXCOORD1.x"},       {"cspec", "TEXCOORD1.y"}};
  const Targets targets = targets_of(program, executable);
  std::vector<std::string> names;
  for (const auto& [name, unused] : kColumns) names.push_back(name);
  for (const std::string& name : names)
    if (std::find(inputs.columns.begin(), inputs.columns.end(), name) == inputs.columns.end())
      throw UserError(SourcePlace{path, 1, 0}, fmt::format("column '{}' is missing", name),
                      "eval brdf reads g,n_dot_l,n_dot_v,n_dot_h,h_dot_v,cspec");
  // A variant may not read every column (cheap never reads n.l): those go to a component nobody uses.
  Csv used;
  std::vector<Target> column_targets;
  used.rows.resize(inputs.rows.size());
  for (std::size_t c = 0; c < inputs.columns.size(); ++c) {
    const auto semantic = kColumns.find(inputs.columns[c]);
    if (semantic == kColumns.end()) unknown_column(path, inputs.columns[c], names);
    const auto target = targets.find(semantic->second);
    if (target == targets.end()) continue;
    column_targets.push_back(target->second);
    for (std::size_t row = 0; row < inputs.rows.size(); ++row) used.rows[row].push_back(inputs.rows[row][c]);
  }
  const Run run = run_rows(used, column_targets, program, executable);
  return {joined(inputs, {"value"}, run.results, {0}), run.saturations, run.saturated_rows};
}

Evaluation evaluate_shader(const Csv& inputs, const std::string& path, const vm::Program& program,
                           const number::NumberFormat& format) {
  const vm::Executable executable = vm::prepare(program, format);
  const Targets targets = targets_of(program, executable);
  std::vector<std::string> names;
  for (const auto& [name, unused] : targets) names.push_back(name);
  std::vector<Target> column_targets;
  for (const std::string& column : inputs.columns) {
    const auto target = targets.find(column);
    if (target == targets.end()) unknown_column(path, column, names);
    column_targets.push_back(target->second);
  }
  const Run run = run_rows(inputs, column_targets, program, executable);
  std::vector<std::string> added;
  std::vector<std::size_t> picked;
  for (const vm::RowBinding& output : executable.outputs()) {
    picked.push_back(added.size());
    added.push_back(fmt::format("{}.{}", program.outputs[output.index].semantic, "xyzw"[output.component]));
  }
  return {joined(inputs, added, run.results, picked), run.saturations, run.saturated_rows};
}

}  // namespace aluminate::report
