// aluminate eval brdf|SHADER --inputs IN.csv -o OUT.csv: shaders as functions of a table.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/input_file.hpp"
#include "platform/host/log.hpp"
#include "platform/host/output_file.hpp"
#include "shading/compiler/compile.hpp"
#include "shading/programs/shipped.hpp"
#include "shading/report/energy_report.hpp"
#include "shading/report/evaluate.hpp"

namespace aluminate::apps {
namespace {

struct Arguments {
  FrameArguments frame;
  std::string subject, inputs, output;
  double cspec = 1;
};

void run_energy(const Arguments& arguments, const passes::FrameOptions& options) {
  if (!arguments.output.empty()) host::write_file(arguments.output, report::energy_csv());
  fmt::print("{}", report::energy_text(arguments.cspec, options.fresnel));
}

void run(const Arguments& arguments) {
  const passes::FrameOptions options = arguments.frame.resolve();
  if (arguments.subject == "energy") return run_energy(arguments, options);
  if (arguments.inputs.empty() || arguments.output.empty())
    throw UserError(fmt::format("eval {}: expected --inputs IN.csv and -o OUT.csv", arguments.subject),
                    "only eval energy works without a table");
  const number::NumberFormat format = number::parse_number_format(options.number).value();
  host::OutputFile output(arguments.output);
  const report::Csv csv = report::parse_csv(host::read_text(arguments.inputs), arguments.inputs);
  report::Evaluation result;
  if (arguments.subject == "brdf") {
    result = report::evaluate_brdf(csv, arguments.inputs, options.visibility, options.fresnel, format);
  } else {
    compiler::Options compile;
    compile.source_path = arguments.subject;
    compile.defines = options.defines;
    programs::add_shipped_includes(compile);
    result = report::evaluate_shader(csv, arguments.inputs, compiler::compile(compile), format);
  }
  output.write(result.csv);
  output.commit();
  if (result.saturations)
    host::warning(fmt::format("{} results left the range of {} and were clamped; data rows {}{}",
                              result.saturations, format.name, fmt::join(result.saturated_rows, ", "),
                              result.saturated_rows.size() == 10 ? ", ..." : ""));
}

}  // namespace

void add_eval(CLI::App& app, Session&) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("eval", "run the BRDF or a shader over a table of inputs");
  command->footer(
      "Example:\n  aluminate eval brdf --inputs angles.csv -o values.csv --visibility cheap --number fx31\n"
      "  (columns g,n_dot_l,n_dot_v,n_dot_h,h_dot_v,cspec; adds value = pi * specular f)");
  command->add_option("SUBJECT", arguments->subject, "brdf, energy, or a pixel shader file")->required();
  command->add_option("--inputs", arguments->inputs, "CSV, first line names the columns");
  command->add_option("-o,--output", arguments->output, "CSV with the results added; energy: the curves");
  command->add_option("--cspec", arguments->cspec, "energy: specular colour of the furnace (1)")
      ->check(CLI::Range(0.0, 1.0));
  arguments->frame.add_to(*command, {"visibility", "fresnel", "number", "D"});
  command->callback([arguments] { run(*arguments); });
}

}  // namespace aluminate::apps
