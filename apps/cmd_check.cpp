// aluminate check [NAME..] [--update NAME..]: pictures and costs against what was accepted. Exit 0 all as
// accepted, 1 something differs, is missing or extra, 2 a mistake in a file.
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/parallel.hpp"
#include "shading/report/check_report.hpp"

namespace aluminate::apps {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  report::CheckRequest request;
  std::string file, junit, markdown;
  bool update_given = false, list = false;
  int threads = 0;
};

// The file that was named, or aluminate.toml here or in a folder above.
fs::path find_file(const std::string& named) {
  if (!named.empty()) return named;
  for (fs::path folder = fs::current_path();; folder = folder.parent_path()) {
    if (fs::exists(folder / "aluminate.toml")) return folder / "aluminate.toml";
    if (folder == folder.root_path())
      throw UserError("there is no aluminate.toml here or in a folder above",
                      "docs/checks.md shows one; --file names another");
  }
}

void run(Arguments& a, Session& session) {
  std::erase(a.request.update, "");  // CLI11's way of saying that no name followed
  if (a.update_given && a.request.update.empty())
    throw UserError("--update needs the name of a check",
                    "changes are accepted by name, one after the other: aluminate check --update NAME");
  if (!a.request.update.empty() && !a.request.names.empty())
    throw UserError("names to check and names to accept cannot be mixed", "give the names after --update");
  host::set_thread_count(a.threads);
  const fs::path file = find_file(a.file);
  for (std::string* output : {&a.junit, &a.markdown})
    if (!output->empty() && *output != "-") *output = fs::absolute(*output).string();
  // Paths in the file are relative to it, so that every command line in a golden is the same wherever it was
  // made.
  const fs::path folder = file.parent_path();
  if (!fs::exists(file)) throw UserError(SourcePlace{file.string()}, "cannot be read: no such file");
  if (!folder.empty()) fs::current_path(folder);
  a.request.file = report::load_check_file(file.filename().string());
  if (a.list) {
    for (const report::CheckSpec& spec : a.request.file.checks) fmt::print("{}\n", spec.name);
    return;
  }
  host::OutputSet outputs;
  host::OutputFile* junit = a.junit.empty() ? nullptr : &outputs.add(a.junit);
  host::OutputFile* markdown = a.markdown.empty() || a.markdown == "-" ? nullptr : &outputs.add(a.markdown);
  const report::CheckRun done = report::run_checks(a.request);
  if (junit) junit->write(report::check_junit(done));
  if (markdown) markdown->write(report::check_markdown(done));
  outputs.commit();
  fmt::print("{}", a.markdown == "-" ? report::check_markdown(done) : report::check_text(done));
  session.exit_code = done.exit_code();
}

}  // namespace

void add_check(CLI::App& app, Session& session) {
  auto a = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("check", "pictures and costs against what was accepted (aluminate.toml)");
  command->footer(
      "Examples:\n  aluminate check\n  aluminate check wall/cheap --verify\n  aluminate check --update "
      "wall/cheap\n"
      "  aluminate check --junit checks.xml --markdown - > summary.md");
  command->add_option("NAME", a->request.names, "checks to run (all)");
  CLI::Option* update =
      command
          ->add_option("--update", a->request.update,
                       "accept what these checks give now, or remove goldens that no check names")
          ->expected(0, 1 << 20)
          ->type_name("NAME..");
  command->add_flag("--verify", a->request.verify,
                    "render everything twice, with other threads and vector widths");
  command->add_flag("--list", a->list, "the names, one a line");
  command->add_option("--file", a->file, "check file (aluminate.toml here or in a folder above)");
  command->add_option("--junit", a->junit, "write the results as JUnit XML");
  command->add_option("--markdown", a->markdown,
                      "write the results as Markdown; '-': to stdout instead of the text");
  command->add_option("--threads", a->threads, "threads to use; never changes a result (0: every core)")
      ->type_name("N");
  command->callback([a, update, &session] {
    a->update_given = update->count() > 0;
    run(*a, session);
  });
}

}  // namespace aluminate::apps
