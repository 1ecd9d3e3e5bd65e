// aluminate: one binary, verbs first. stdout carries results, stderr talk.
// Exit: 0 done, 1 the answer is no, 2 usage or input error, 3 our bug, 130 interrupted.
#include <fmt/format.h>

#include <cstdio>
#include <new>

#include "apps/session.hpp"
#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"
#include "platform/host/log.hpp"
#include "platform/host/suggest.hpp"
#include "platform/host/terminal.hpp"

namespace aluminate::apps {
namespace {

void print_error(const std::string& what, const std::string& hint) {
  host::erase_status_line();
  fmt::print(stderr, "aluminate: {}\n", what);
  if (!hint.empty()) fmt::print(stderr, "  {}\n", hint);
}

std::vector<std::string> subcommand_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(sub->get_name());
  return names;
}

// The innermost subcommand that was reached: its options are what a mistyped one was meant to be.
const CLI::App& innermost(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

int usage_error(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = innermost(app);
  std::string what = error.what();
  std::string hint = fmt::format("'{} --help' lists what it takes",
                                 &command == &app ? "aluminate" : "aluminate " + command.get_name());
  const std::vector<std::string> left = app.remaining(true);
  if (!left.empty()) {
    const std::string word = left.front().substr(0, left.front().find('='));
    if (word.starts_with('-')) {
      std::vector<std::string> names;
      for (const CLI::Option* option : command.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
      what = fmt::format("unknown option {}", word);
      if (const std::string near = host::did_you_mean(word, names); !near.empty()) hint = near;
    } else if (!subcommand_names(command).empty()) {
      what = fmt::format("unknown command '{}'", word);
      if (const std::string near = host::did_you_mean(word, subcommand_names(command)); !near.empty())
        hint = near;
    } else {
      what = fmt::format("unexpected argument '{}'", word);
    }
  }
  print_error(what, hint);
  return kUsageError;
}

int run(int argc, char** argv) {
  Session session;
  for (int i = 0; i < argc; ++i) session.command += (i ? " " : "") + std::string(i ? argv[i] : "aluminate");

  CLI::App app{
      "Renders glTF scenes with Far Cry 3's shading model and prices every pixel on a console of its time."};
  app.name("aluminate");
  app.set_version_flag("--version", std::string("aluminate " ALUMINATE_VERSION));
  app.require_subcommand(1);
  app.add_flag_callback(
      "-q,--quiet", [&] { host::set_talk(host::Talk::Quiet); }, "warnings only: no notes, no progress");
  app.fallthrough();
  add_render(app, session);
  add_compare(app, session);
  add_cost(app, session);
  add_pixel(app, session);
  add_eval(app, session);
  add_platform(app, session);
  add_scene(app, session);
  add_check(app, session);
  add_diff(app, session);
  add_sweep(app, session);
  add_sky(app, session);
  add_toksvig(app, session);
  add_cubemap(app, session);
  add_calibrate(app, session);
  add_doctor(app, session);

  if (argc < 2) {
    fmt::print(stderr, "{}", app.help());
    return kUsageError;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    return usage_error(app, error);
  }
  return session.exit_code;
}

}  // namespace
}  // namespace aluminate::apps

int main(int argc, char** argv) {
  using namespace aluminate;
  host::install_interrupt_handlers();
  try {
    return apps::run(argc, argv);
  } catch (const UserError& error) {
    apps::print_error(error.what(), error.hint());
    return apps::kUsageError;
  } catch (const host::Interrupted&) {
    host::erase_status_line();
    return host::kExitInterrupted;
  } catch (const std::bad_alloc&) {
    apps::print_error("not enough memory for this job", "try a smaller --size or a smaller scene");
    return apps::kUsageError;
  } catch (const std::exception& error) {
    apps::print_error(error.what(),
                      "this is a bug in aluminate: please report it with the command and its input");
    return apps::kOurBug;
  }
}
