// Ctrl-C. First signal (SIGINT, SIGTERM, SIGHUP): a flag that work checks between items, so that the stack unwinds and
// every uncommitted output removes itself; apps/ catches Interrupted and exits 130. Second signal: unlinks whatever is
// still pending from a fixed table with async-signal-safe calls only and _exit(130)s.
#pragma once

namespace aluminate::host {

/// Not a std::exception: code that turns std::exception into a message must not swallow it.
struct Interrupted {};

inline constexpr int kExitInterrupted = 130;

/// Once, at the start of main. A signal that was ignored at start (nohup) stays ignored.
void install_interrupt_handlers();

[[nodiscard]] bool interrupted() noexcept;
void throw_if_interrupted();

/// For tests: forgets a signal that was received.
void reset_interrupted() noexcept;

inline constexpr int kMaxPendingRemovals = 64;

/// A file the second signal must unlink. path: absolute, below 4096 bytes. Returns a slot, or -1 when the table is full
/// (the file is then only removed by unwinding). Thread-safe.
int arm_removal(const char* path) noexcept;
void disarm_removal(int slot) noexcept;

}  // namespace aluminate::host
