#include "platform/host/parallel.hpp"

#include <sched.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <optional>

#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"

#ifdef ALUMINATE_THREAD_SANITIZER
#include <sanitizer/tsan_interface.h>
#endif

namespace aluminate::host {
namespace {

// The scheduler's library is not instrumented: ThreadSanitizer has to be told what orders its threads. This file is then
// compiled without instrumentation (see CMakeLists.txt), the items are not.
void tell_released([[maybe_unused]] void* what) {
#ifdef ALUMINATE_THREAD_SANITIZER
  __tsan_release(what);
#endif
}
void tell_acquired([[maybe_unused]] void* what) {
#ifdef ALUMINATE_THREAD_SANITIZER
  __tsan_acquire(what);
#endif
}

int usable_cores() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  const int count = ::sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1;
  return std::clamp(count, 1, kMaxThreads);
}

// Never destroyed: the scheduler's own clean-up at exit would otherwise race with ours.
struct Threads {
  int count = usable_cores();
  std::atomic<int> running{0};
  std::optional<tbb::global_control> allowed;  // raises the scheduler's limit, which is the core count by default
  std::optional<tbb::task_arena> arena;
  std::mutex mutex;

  tbb::task_arena& ready_arena() {
    const std::lock_guard lock(mutex);
    if (!arena) {
      allowed.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
      arena.emplace(count, /*reserved for callers*/ 1);
      arena->initialize();
    }
    return *arena;
  }
};

Threads& threads() {
  static Threads& instance = *new Threads;
  return instance;
}

thread_local int current_worker = -1;  // -1: not inside a parallel_for

// One call of parallel_for: what the items share.
class Job {
 public:
  Job(detail::ItemFunction item, void* context) : item_(item), context_(context) {}

  // Items above the lowest one that threw are skipped, those below still run: the winner does not depend on timing.
  void run(std::int64_t index, int worker) noexcept {
    if (index > lowest_failure_.load(std::memory_order_relaxed)) return;
    try {
      throw_if_interrupted();
      item_(context_, index, worker);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (index < lowest_failure_.load(std::memory_order_relaxed)) {
        lowest_failure_.store(index, std::memory_order_relaxed);
        failure_ = std::current_exception();
      }
    }
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  detail::ItemFunction item_;
  void* context_;
  std::atomic<std::int64_t> lowest_failure_{std::numeric_limits<std::int64_t>::max()};
  std::mutex mutex_;
  std::exception_ptr failure_;
};

struct WorkerScope {
  explicit WorkerScope(int worker) : before(current_worker) { current_worker = worker; }
  ~WorkerScope() { current_worker = before; }
  WorkerScope(const WorkerScope&) = delete;
  WorkerScope& operator=(const WorkerScope&) = delete;
  int before;
};

struct RunningScope {
  RunningScope() { ++threads().running; }
  ~RunningScope() { --threads().running; }
  RunningScope(const RunningScope&) = delete;
  RunningScope& operator=(const RunningScope&) = delete;
};

}  // namespace

void set_thread_count(int count) {
  if (count < 0 || count > kMaxThreads) {
    throw UserError(fmt::format("expected a thread count of 1 to {}, found {}", kMaxThreads, count),
                    "0 uses every core");
  }
  Threads& all = threads();
  ALU_CHECK(all.running == 0, "the thread count was changed while {} parallel_for run", all.running.load());
  const std::lock_guard lock(all.mutex);
  all.arena.reset();
  all.allowed.reset();
  all.count = count == 0 ? usable_cores() : count;
}

int thread_count() { return threads().count; }

namespace detail {

void run_parallel(std::int64_t count, std::int64_t grain, ItemFunction item, void* context) {
  ALU_CHECK(grain > 0, "grain {}", grain);
  if (count <= 0) return;
  Job job(item, context);
  if (current_worker >= 0) {
    for (std::int64_t index = 0; index < count; ++index) job.run(index, current_worker);
  } else {
    const RunningScope running;
    tell_released(&job);
    threads().ready_arena().execute([&] {
      tbb::parallel_for(
          tbb::blocked_range<std::int64_t>(0, count, static_cast<std::size_t>(grain)),
          [&job](const tbb::blocked_range<std::int64_t>& range) {
            tell_acquired(&job);
            const WorkerScope scope(tbb::this_task_arena::current_thread_index());
            for (std::int64_t index = range.begin(); index < range.end(); ++index) job.run(index, current_worker);
            tell_released(&job);
          },
          tbb::simple_partitioner());
    });
    tell_acquired(&job);
  }
  job.rethrow();
}

}  // namespace detail
}  // namespace aluminate::host
