#include "platform/host/interrupt.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <string>
#include <vector>

#include "platform/host/output_file.hpp"
#include "tests/platform/host/temporary_folder.hpp"

namespace aluminate::host {
namespace {

using Names = std::vector<std::string>;

// ThreadSanitizer delays signal handlers, and for good in a child of a process with threads.
#if defined(__SANITIZE_THREAD__)
constexpr bool kSignalsArrive = false;
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
constexpr bool kSignalsArrive = false;
#else
constexpr bool kSignalsArrive = true;
#endif
#else
constexpr bool kSignalsArrive = true;
#endif

class Interrupt : public testing::Test {
 protected:
  void SetUp() override {
    if (!kSignalsArrive) GTEST_SKIP() << "no signal handlers in a child under ThreadSanitizer";
  }
};

/// Runs `work` in a child, sends it `signals` one by one as soon as it says it is ready (a byte on the pipe for each),
/// and returns the exit status, or 1000 + the signal that killed it. ignored: a signal that keeps its disposition.
int run_and_signal(const std::function<void(std::function<void()> ready)>& work, const std::vector<int>& signals,
                   int ignored = 0) {
  int channel[2];
  if (::pipe(channel) != 0) return -1;
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(channel[0]);
    ::alarm(30);  // a child that ignores its signals must not outlive the test
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      // A shell starts background jobs with SIGINT ignored, and that would be inherited down to here.
      if (signal != ignored) ::signal(signal, SIG_DFL);
    }
    install_interrupt_handlers();
    int code = 0;
    try {
      work([&] { (void)!::write(channel[1], "r", 1); });
    } catch (const Interrupted&) {
      code = kExitInterrupted;
    }
    ::_exit(code);
  }
  ::close(channel[1]);
  char byte = 0;
  for (const int signal : signals) {
    if (::read(channel[0], &byte, 1) == 1) ::kill(child, signal);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(channel[0]);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

void wait_for_the_flag() {
  while (true) {
    throw_if_interrupted();
    ::usleep(500);
  }
}

TEST_F(Interrupt, FirstSignalUnwindsAndRemovesOutputs) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const TemporaryFolder folder;
    const int code = run_and_signal(
        [&](const auto& ready) {
          OutputSet outputs;
          outputs.add(folder.path("a.png")).write("half");
          outputs.add(folder.path("b.json")).write("half");
          ready();
          wait_for_the_flag();
        },
        {signal});
    EXPECT_EQ(code, kExitInterrupted);
    EXPECT_EQ(folder.names(), Names{});
  }
}

TEST_F(Interrupt, WorkThatHasEndedIsNotCommittedAfterTheSignal) {
  const TemporaryFolder folder;
  const int code = run_and_signal(
      [&](const auto& ready) {
        OutputSet outputs;
        outputs.add(folder.path("a.png")).write("whole");
        ready();
        while (!interrupted()) ::usleep(500);
        outputs.commit();
      },
      {SIGINT});
  EXPECT_EQ(code, kExitInterrupted);
  EXPECT_EQ(folder.names(), Names{});
}

TEST_F(Interrupt, SecondSignalRemovesOutputsOfWorkThatNeverLooks) {
  const TemporaryFolder folder;
  const int code = run_and_signal(
      [&](const auto& ready) {
        OutputFile first(folder.path("a.png")), second(folder.path("b.json"));
        ready();
        while (!interrupted()) ::usleep(500);
        ready();
        while (true) ::usleep(500);
      },
      {SIGINT, SIGINT});
  EXPECT_EQ(code, kExitInterrupted);
  EXPECT_EQ(folder.names(), Names{});
}

TEST_F(Interrupt, SecondSignalKeepsCommittedFiles) {
  const TemporaryFolder folder;
  const int code = run_and_signal(
      [&](const auto& ready) {
        write_file(folder.path("done.png"), "whole");
        OutputFile pending(folder.path("pending.png"));
        ready();
        while (!interrupted()) ::usleep(500);
        ready();
        while (true) ::usleep(500);
      },
      {SIGINT, SIGTERM});
  EXPECT_EQ(code, kExitInterrupted);
  EXPECT_EQ(folder.names(), Names{"done.png"});
}

TEST_F(Interrupt, AnIgnoredSignalStaysIgnored) {
  ::signal(SIGHUP, SIG_IGN);  // as nohup does
  const int code = run_and_signal(
      [&](const auto& ready) {
        ready();
        for (int i = 0; i < 100; ++i) {
          throw_if_interrupted();
          ::usleep(500);
        }
      },
      {SIGHUP}, SIGHUP);
  ::signal(SIGHUP, SIG_DFL);
  EXPECT_EQ(code, 0);
}

TEST_F(Interrupt, MorePendingFilesThanTheTableHolds) {
  const TemporaryFolder folder;
  const int code = run_and_signal(
      [&](const auto& ready) {
        OutputSet outputs;
        for (int i = 0; i < kMaxPendingRemovals + 10; ++i) outputs.add(folder.path(std::to_string(i)));
        ready();
        wait_for_the_flag();
      },
      {SIGINT});
  EXPECT_EQ(code, kExitInterrupted);
  EXPECT_EQ(folder.names(), Names{});
}

TEST(RemovalTable, SlotsAreUsedAgain) {
  for (int i = 0; i < 3 * kMaxPendingRemovals; ++i) {
    const int slot = arm_removal("/nonexistent/aluminate");
    ASSERT_GE(slot, 0);
    disarm_removal(slot);
  }
  EXPECT_EQ(arm_removal(std::string(5000, 'x').c_str()), -1);
}

}  // namespace
}  // namespace aluminate::host
