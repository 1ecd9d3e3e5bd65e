#include "platform/host/parallel.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"

namespace aluminate::host {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};
INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 3, 7, 64));

TEST_P(Parallel, EveryIndexExactlyOnce) {
  for (const std::int64_t count : {0, 1, 2, 63, 64, 65, 1000}) {
    for (const std::int64_t grain : {1, 7, 1000}) {
      std::vector<std::atomic<int>> runs(static_cast<std::size_t>(count));
      parallel_for(count, [&](std::int64_t index) { ++runs[static_cast<std::size_t>(index)]; }, grain);
      for (const auto& run : runs) ASSERT_EQ(run, 1) << count << " items, grain " << grain;
    }
  }
}

TEST_P(Parallel, WorkersNeverOverlap) {
  std::vector<std::atomic<bool>> busy(static_cast<std::size_t>(thread_count()));
  std::atomic<int> collisions{0}, out_of_range{0};
  parallel_for_workers(2000, [&](std::int64_t, int worker) {
    if (worker < 0 || worker >= thread_count()) {
      ++out_of_range;
      return;
    }
    auto& mine = busy[static_cast<std::size_t>(worker)];
    if (mine.exchange(true)) ++collisions;
    std::this_thread::yield();
    mine = false;
  });
  EXPECT_EQ(out_of_range, 0);
  EXPECT_EQ(collisions, 0);
}

// Items that wait for each other can only end when as many threads as asked for are in them at once.
TEST_P(Parallel, AllThreadsAreReallyUsed) {
  const int wanted = GetParam();
  std::atomic<int> arrived{0};
  std::atomic<bool> gave_up{false};
  std::mutex mutex;
  std::set<int> workers;
  parallel_for_workers(wanted, [&](std::int64_t, int worker) {
    {
      const std::lock_guard lock(mutex);
      workers.insert(worker);
    }
    ++arrived;
    // The limit only turns a hang into a failure; it is no measurement.
    for (int tries = 0; arrived < wanted && !gave_up; ++tries) {
      if (tries > 20000) gave_up = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  EXPECT_FALSE(gave_up) << arrived << " of " << wanted << " threads came";
  EXPECT_EQ(workers.size(), static_cast<std::size_t>(wanted));
}

TEST_P(Parallel, TheLowestFailingIndexIsReported) {
  for (int repeat = 0; repeat < 20; ++repeat) {
    try {
      parallel_for(500, [](std::int64_t index) {
        if (index % 10 == 3 && index >= 123) throw UserError("item " + std::to_string(index));
      });
      FAIL() << "no error";
    } catch (const UserError& error) {
      EXPECT_STREQ(error.what(), "item 123");
    }
  }
}

TEST_P(Parallel, ALaterFailureOfAHigherIndexDoesNotReplaceIt) {
  if (GetParam() == 1) GTEST_SKIP() << "one thread never runs two items at once";
  std::atomic<bool> high_is_in{false}, low_is_out{false};
  try {
    parallel_for(2, [&](std::int64_t index) {
      if (index == 1) {
        high_is_in = true;
        while (!low_is_out) std::this_thread::yield();
        std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the throw below is long recorded
      } else {
        while (!high_is_in) std::this_thread::yield();
        low_is_out = true;
      }
      throw UserError("item " + std::to_string(index));
    });
    FAIL() << "no error";
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "item 0");
  }
}

TEST_P(Parallel, NestedRunsOnTheSameWorker) {
  for (const std::int64_t outer_items : {1, 50}) {  // with 1 the other threads have nothing to do but steal
    std::atomic<int> inner_items{0}, moved{0};
    parallel_for_workers(outer_items, [&](std::int64_t, int outer) {
      parallel_for_workers(20, [&, outer](std::int64_t, int inner) {
        std::this_thread::sleep_for(std::chrono::microseconds(50));
        ++inner_items;
        if (inner != outer) ++moved;
      });
    });
    EXPECT_EQ(inner_items, 20 * outer_items);
    EXPECT_EQ(moved, 0);
  }
}

TEST_P(Parallel, TwoCallersAtOnce) {
  std::atomic<int> items{0};
  const auto work = [&] { parallel_for(300, [&](std::int64_t) { ++items; }); };
  std::thread other(work);
  work();
  other.join();
  EXPECT_EQ(items, 600);
}

TEST_P(Parallel, StopsAtAnInterrupt) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);  // a parent may have ignored them
  install_interrupt_handlers();
  std::atomic<int> late{0};
  EXPECT_THROW(parallel_for(100000,
                            [&](std::int64_t index) {
                              if (interrupted()) ++late;
                              if (index == 10) ::raise(SIGINT);
                            }),
               Interrupted);
  // Each thread may stand between the check and its item when the signal comes.
  EXPECT_LE(late, GetParam());
  reset_interrupted();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_DFL);
}

TEST(ThreadCount, IsTheCoresUnlessSet) {
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  set_thread_count(5);
  EXPECT_EQ(thread_count(), 5);
  set_thread_count(0);
}

TEST(ThreadCount, RefusesNonsense) {
  EXPECT_THROW(set_thread_count(-1), UserError);
  EXPECT_THROW(set_thread_count(kMaxThreads + 1), UserError);
}

TEST(ThreadCount, CannotChangeUnderRunningWork) {
  EXPECT_THROW(parallel_for(1, [](std::int64_t) { set_thread_count(2); }), InternalError);
}

}  // namespace
}  // namespace aluminate::host
