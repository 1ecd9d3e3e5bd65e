#include "platform/host/interrupt.hpp"

#include <signal.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstring>

namespace aluminate::host {
namespace {

constexpr std::size_t kMaxPathBytes = 4096;

// What a handler may touch: lock-free atomics and plain memory that a release store has published.
struct Removal {
  enum State : int { Free, Filling, Armed };
  std::atomic<int> state{Free};
  std::array<char, kMaxPathBytes> path{};
};
std::array<Removal, kMaxPendingRemovals> removals;
std::atomic<bool> received{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

extern "C" void on_signal(int) {
  if (!received.exchange(true)) return;
  for (const Removal& removal : removals) {
    if (removal.state.load(std::memory_order_acquire) == Removal::Armed) ::unlink(removal.path.data());
  }
  ::_exit(kExitInterrupted);
}

}  // namespace

void install_interrupt_handlers() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction old {};
    if (::sigaction(signal, nullptr, &old) == 0 && old.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    ::sigemptyset(&action.sa_mask);
    ::sigaction(signal, &action, nullptr);
  }
}

bool interrupted() noexcept { return received.load(std::memory_order_relaxed); }

void throw_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

void reset_interrupted() noexcept { received = false; }

int arm_removal(const char* path) noexcept {
  const std::size_t length = std::strlen(path);
  if (length >= kMaxPathBytes) return -1;
  for (int slot = 0; slot < kMaxPendingRemovals; ++slot) {
    Removal& removal = removals[static_cast<std::size_t>(slot)];
    int expected = Removal::Free;
    if (!removal.state.compare_exchange_strong(expected, Removal::Filling)) continue;
    std::memcpy(removal.path.data(), path, length + 1);
    removal.state.store(Removal::Armed, std::memory_order_release);
    return slot;
  }
  return -1;
}

void disarm_removal(int slot) noexcept {
  if (slot >= 0) removals[static_cast<std::size_t>(slot)].state.store(Removal::Free, std::memory_order_release);
}

}  // namespace aluminate::host
