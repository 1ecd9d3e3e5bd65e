// Threads. In: a count and a function of an index; every index runs exactly once, on any thread, in any order, so a
// result must not depend on either. Work is stolen between threads. Ctrl-C is checked between items (Interrupted).
// When items throw, the exception of the lowest throwing index is rethrown: errors are the same on any thread count.
// A parallel_for inside a parallel_for runs on the calling thread alone: a worker slot is never entered twice.
#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

namespace aluminate::host {

inline constexpr int kMaxThreads = 256;

/// Threads used from now on, the caller included. 0 = the cores this process may run on (the default). More than the
/// machine has are really started. Not while a parallel_for runs. UserError outside 0..kMaxThreads.
void set_thread_count(int count);
[[nodiscard]] int thread_count();

namespace detail {
using ItemFunction = void (*)(void* context, std::int64_t index, int worker);
void run_parallel(std::int64_t count, std::int64_t grain, ItemFunction item, void* context);
}  // namespace detail

/// work(index, worker) for index in [0, count). worker < thread_count(); no two items run at the same time with the same
/// worker, so it selects scratch memory. grain: items taken at once, for items below ~10 us.
template <class Work>
void parallel_for_workers(std::int64_t count, Work&& work, std::int64_t grain = 1) {
  using Plain = std::remove_reference_t<Work>;
  const auto item = [](void* context, std::int64_t index, int worker) {
    (*static_cast<Plain*>(context))(index, worker);
  };
  detail::run_parallel(count, grain, item, const_cast<void*>(static_cast<const void*>(std::addressof(work))));
}

/// work(index) for index in [0, count).
template <class Work>
void parallel_for(std::int64_t count, Work&& work, std::int64_t grain = 1) {
  parallel_for_workers(count, [&work](std::int64_t index, int) { work(index); }, grain);
}

}  // namespace aluminate::host
