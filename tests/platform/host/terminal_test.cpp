#include "platform/host/terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <functional>

#include "platform/host/log.hpp"
#include "platform/host/progress.hpp"

namespace aluminate::host {
namespace {

TEST(Color, TheOptionDecides) {
  EXPECT_TRUE(color_enabled(ColorChoice::Always, {false, "1", nullptr, "dumb"}));
  EXPECT_FALSE(color_enabled(ColorChoice::Never, {true, nullptr, "1", "xterm"}));
}

TEST(Color, AutoFollowsTheVariablesThenTheTerminal) {
  EXPECT_TRUE(color_enabled(ColorChoice::Auto, {true, nullptr, nullptr, "xterm"}));
  EXPECT_TRUE(color_enabled(ColorChoice::Auto, {true, "", "", "xterm"}));  // empty counts as unset
  EXPECT_FALSE(color_enabled(ColorChoice::Auto, {false, nullptr, nullptr, "xterm"}));
  EXPECT_FALSE(color_enabled(ColorChoice::Auto, {true, nullptr, nullptr, "dumb"}));
  EXPECT_FALSE(color_enabled(ColorChoice::Auto, {true, nullptr, nullptr, nullptr}));
  EXPECT_FALSE(color_enabled(ColorChoice::Auto, {true, "1", "1", "xterm"}));  // NO_COLOR is stronger
  EXPECT_TRUE(color_enabled(ColorChoice::Auto, {false, nullptr, "1", "dumb"}));
  EXPECT_FALSE(color_enabled(ColorChoice::Auto, {true, nullptr, "0", "xterm"}));
}

/// stderr is a pseudo-terminal while it lives.
class FakeTerminal {
 public:
  FakeTerminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY)), saved_(::dup(STDERR_FILENO)) {
    if (!works()) return;
    ::grantpt(master_);
    ::unlockpt(master_);
    const int slave = ::open(::ptsname(master_), O_RDWR | O_NOCTTY);
    winsize size{};
    size.ws_col = 40;
    ::ioctl(slave, TIOCSWINSZ, &size);
    ::dup2(slave, STDERR_FILENO);
    ::close(slave);
  }
  ~FakeTerminal() {
    restore();
    ::close(master_);
  }
  FakeTerminal(const FakeTerminal&) = delete;
  FakeTerminal& operator=(const FakeTerminal&) = delete;

  bool works() const { return master_ >= 0; }

  /// What was written so far. Restores stderr first, so that the read ends.
  std::string text() {
    restore();
    std::string all;
    char buffer[4096];
    ssize_t got = 0;
    while ((got = ::read(master_, buffer, sizeof buffer)) > 0) all.append(buffer, static_cast<std::size_t>(got));
    return all;
  }

 private:
  void restore() {
    if (saved_ >= 0) {
      ::dup2(saved_, STDERR_FILENO);
      ::close(saved_);
    }
    saved_ = -1;
  }
  int master_, saved_;
};

constexpr Progress::Options kAtOnce{0.0, true};

TEST(Progress, LineTellsShareAndTimeLeft) {
  EXPECT_EQ(progress_line("tiles", 36, 144, 4.0), "tiles  36/144  25 %  ETA 0:12");
  EXPECT_EQ(progress_line("tiles", 0, 144, 4.0), "tiles  0/144  0 %");
  EXPECT_EQ(progress_line("tiles", 1, 2, 3725.0), "tiles  1/2  50 %  ETA 1:02:05");
  EXPECT_EQ(progress_line("tiles", 9, 2, 1.0), "tiles  2/2  100 %  ETA 0:00");
}

TEST(Progress, DrawsOneLineAndErasesIt) {
  FakeTerminal terminal;
  if (!terminal.works()) GTEST_SKIP() << "no pseudo-terminals on this machine";
  {
    Progress progress("tiles", 4, kAtOnce);
    progress.advance();
  }
  EXPECT_EQ(terminal.text(), "\r\x1b[Ktiles  1/4  25 %  ETA 0:00\r\x1b[K");
}

TEST(Progress, NeverFillsTheLastColumn) {
  FakeTerminal terminal;
  if (!terminal.works()) GTEST_SKIP() << "no pseudo-terminals on this machine";
  { Progress(std::string(100, 'x'), 4, kAtOnce).advance(); }
  EXPECT_EQ(terminal.text(), "\r\x1b[K" + std::string(39, 'x') + "\r\x1b[K");
}

TEST(Progress, SilentBeforeItsDelay) {
  FakeTerminal terminal;
  if (!terminal.works()) GTEST_SKIP() << "no pseudo-terminals on this machine";
  { Progress("tiles", 4, {3600.0, true}).advance(); }
  EXPECT_EQ(terminal.text(), "");
}

TEST(Progress, SilentWhenQuiet) {
  FakeTerminal terminal;
  if (!terminal.works()) GTEST_SKIP() << "no pseudo-terminals on this machine";
  set_talk(Talk::Quiet);
  { Progress("tiles", 4, kAtOnce).advance(); }
  set_talk(Talk::Normal);
  EXPECT_EQ(terminal.text(), "");
}

std::string stderr_of(const std::function<void()>& body) {
  testing::internal::CaptureStderr();
  body();
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, SilentWithoutATerminal) {
  EXPECT_EQ(stderr_of([] { Progress("tiles", 4, kAtOnce).advance(); }), "");
}

TEST(Log, NotesAndWarningsAreLinesOnStderr) {
  testing::internal::CaptureStdout();
  EXPECT_EQ(stderr_of([] {
              note("wrote out.png {}");
              warning("texture 'brick' is missing");
            }),
            "wrote out.png {}\nwarning: texture 'brick' is missing\n");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(Log, QuietKeepsWarnings) {
  set_talk(Talk::Quiet);
  EXPECT_EQ(stderr_of([] {
              note("nobody sees this");
              warning("quiet but wrong");
            }),
            "warning: quiet but wrong\n");
  set_talk(Talk::Normal);
}

TEST(Log, TheSameWarningOnce) {
  EXPECT_EQ(stderr_of([] {
              for (int i = 0; i < 3; ++i) warning("said once");
            }),
            "warning: said once\n");
}

TEST(Log, ControlCharactersOfAFileNeverReachTheTerminal) {
  EXPECT_EQ(stderr_of([] { note("node '\x1b[2J\a'\tok\nnext"); }), "node '?[2J?'\tok\nnext\n");
}

TEST(Log, ErasesTheStatusLineFirst) {
  FakeTerminal terminal;
  if (!terminal.works()) GTEST_SKIP() << "no pseudo-terminals on this machine";
  show_status_line("tiles");
  note("a note");
  EXPECT_EQ(terminal.text(), "\r\x1b[Ktiles\r\x1b[Ka note\r\n");  // the terminal turns \n into \r\n
}

}  // namespace
}  // namespace aluminate::host
