// aluminate doctor: versions, CPU features, and whether this machine gives the bits it should.
#include <fmt/format.h>

#include "apps/session.hpp"
#include "shading/report/self_test.hpp"

namespace aluminate::apps {

void add_doctor(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "doctor", "versions, CPU features and the determinism self-test; exit 1 when it fails");
  command->callback([&session] {
    const report::SelfTest test = report::self_test();
    fmt::print("{}", test.text);
    session.exit_code = test.passed ? kDone : kAnswerIsNo;
  });
}

}  // namespace aluminate::apps
