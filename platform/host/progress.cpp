#include "platform/host/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "platform/host/log.hpp"
#include "platform/host/terminal.hpp"

namespace aluminate::host {
namespace {

constexpr std::int64_t kRedrawNs = 100'000'000;
constexpr double kMaxEtaS = 359'999;  // 99:59:59

std::string clock_text(double seconds) {
  const auto whole = static_cast<std::int64_t>(std::min(seconds, kMaxEtaS) + 0.5);
  const std::int64_t hours = whole / 3600, minutes = whole / 60 % 60, rest = whole % 60;
  return hours > 0 ? fmt::format("{}:{:02}:{:02}", hours, minutes, rest) : fmt::format("{}:{:02}", minutes, rest);
}

bool may_draw() { return talk() != Talk::Quiet && is_terminal(Stream::Error); }

}  // namespace

std::string progress_line(std::string_view label, std::int64_t done, std::int64_t total, double elapsed_s) {
  total = std::max<std::int64_t>(total, 1);
  done = std::clamp<std::int64_t>(done, 0, total);
  const double fraction = static_cast<double>(done) / static_cast<double>(total);
  std::string line = fmt::format("{}  {}/{}  {:.0f} %", label, done, total, 100.0 * fraction);
  if (done > 0) line += "  ETA " + clock_text(elapsed_s * (1.0 - fraction) / fraction);
  return line;
}

Progress::Progress(std::string label, std::int64_t total) : Progress(std::move(label), total, Options{}) {}

Progress::Progress(std::string label, std::int64_t total, Options options)
    : label_(std::move(label)),
      total_(total),
      enabled_(options.enabled && may_draw()),
      start_(Clock::now()),
      next_draw_ns_(static_cast<std::int64_t>(options.delay_s * 1e9)) {}

Progress::~Progress() {
  if (drawn_) erase_status_line();
}

void Progress::advance(std::int64_t items) {
  const std::int64_t done = done_.fetch_add(items, std::memory_order_relaxed) + items;
  if (!enabled_) return;
  const std::int64_t now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_).count();
  std::int64_t due_ns = next_draw_ns_.load(std::memory_order_relaxed);
  // The thread that moves the deadline draws; the others go on working.
  if (now_ns < due_ns || !next_draw_ns_.compare_exchange_strong(due_ns, now_ns + kRedrawNs)) return;
  show_status_line(progress_line(label_, done, total_, static_cast<double>(now_ns) * 1e-9));
  drawn_ = true;
}

}  // namespace aluminate::host
