// One line on stderr, "label  37/144  26 %  ETA 0:12", only on a terminal, only after a second, never when quiet.
// Erased when done. advance() may be called from any thread; drawing is limited to ten lines a second.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

namespace aluminate::host {

/// The text of the line; pure. ETA is left out while nothing is done. total > 0.
std::string progress_line(std::string_view label, std::int64_t done, std::int64_t total, double elapsed_s);

class Progress {
 public:
  struct Options {
    double delay_s = 1.0;    // before the first line
    bool enabled = true;     // false: never draws
  };

  Progress(std::string label, std::int64_t total);
  Progress(std::string label, std::int64_t total, Options options);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t items = 1);

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_;
  std::int64_t total_;
  bool enabled_;
  Clock::time_point start_;
  std::atomic<std::int64_t> done_{0};
  std::atomic<std::int64_t> next_draw_ns_;  // since start_
  std::atomic<bool> drawn_{false};
};

}  // namespace aluminate::host
