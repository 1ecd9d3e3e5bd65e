#include "platform/host/log.hpp"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace aluminate::host {
namespace {

constexpr std::size_t kMaxRemembered = 1000;  // distinct warnings; past it they repeat

std::atomic<Talk> current_talk{Talk::Normal};
std::atomic<ColorChoice> color_choice{ColorChoice::Auto};

// Not registered with spdlog: no global default logger that would write to stdout.
spdlog::logger& logger() {
  static spdlog::logger instance = [] {
    auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
    sink->set_pattern("%v");
    spdlog::logger made("aluminate", std::move(sink));
    made.flush_on(spdlog::level::trace);
    return made;
  }();
  return instance;
}

// Names come from files: their control characters must not steer the terminal. Line breaks and tabs stay.
std::string printable(std::string_view text) {
  std::string safe(text);
  for (char& c : safe) {
    const auto code = static_cast<unsigned char>(c);
    if ((code < 0x20 && c != '\n' && c != '\t') || code == 0x7f) c = '?';
  }
  return safe;
}

bool first_time(std::string_view text) {
  static std::mutex mutex;
  static std::set<std::string, std::less<>> seen;
  const std::lock_guard lock(mutex);
  if (seen.size() >= kMaxRemembered) return true;
  return seen.emplace(text).second;
}

}  // namespace

void set_talk(Talk talk) { current_talk = talk; }
Talk talk() { return current_talk; }
void set_log_color(ColorChoice choice) { color_choice = choice; }

void note(std::string_view text) {
  if (current_talk == Talk::Quiet) return;
  erase_status_line();
  logger().info("{}", printable(text));
}

void warning(std::string_view text) {
  if (!first_time(text)) return;
  erase_status_line();
  if (color_enabled(Stream::Error, color_choice)) {
    logger().warn("\x1b[1;33mwarning:\x1b[0m {}", printable(text));
  } else {
    logger().warn("warning: {}", printable(text));
  }
}

}  // namespace aluminate::host
