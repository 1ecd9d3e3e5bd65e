#include "platform/host/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <string>

namespace aluminate::host {
namespace {

constexpr int kDefaultColumns = 80;

int descriptor(Stream stream) { return stream == Stream::Out ? STDOUT_FILENO : STDERR_FILENO; }

bool is_set(const char* variable) { return variable != nullptr && *variable != '\0'; }

// Straight to the descriptor: no buffer that could be written late, in another order or twice after a fork.
void write_stderr(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return;  // nobody listens; talk must never fail a job
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::mutex status_mutex;
bool status_visible = false;

}  // namespace

bool color_enabled(ColorChoice choice, const TerminalFacts& facts) noexcept {
  if (choice != ColorChoice::Auto) return choice == ColorChoice::Always;
  if (is_set(facts.no_color)) return false;
  if (is_set(facts.force_color)) return std::string_view(facts.force_color) != "0";
  if (!is_set(facts.term) || std::string_view(facts.term) == "dumb") return false;
  return facts.is_terminal;
}

bool color_enabled(Stream stream, ColorChoice choice) {
  return color_enabled(choice, TerminalFacts{is_terminal(stream), std::getenv("NO_COLOR"),
                                             std::getenv("FORCE_COLOR"), std::getenv("TERM")});
}

bool is_terminal(Stream stream) noexcept { return ::isatty(descriptor(stream)) == 1; }

int terminal_columns(Stream stream) noexcept {
  winsize size{};
  const bool known = ::ioctl(descriptor(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : kDefaultColumns;
}

void show_status_line(std::string_view text) {
  const auto columns = static_cast<std::size_t>(terminal_columns(Stream::Error));
  const std::lock_guard lock(status_mutex);
  // One column stays free: a line that fills the terminal wraps, and then cannot be erased.
  write_stderr("\r\x1b[K" + std::string(text.substr(0, columns - 1)));
  status_visible = true;
}

void erase_status_line() {
  const std::lock_guard lock(status_mutex);
  if (status_visible) write_stderr("\r\x1b[K");
  status_visible = false;
}

}  // namespace aluminate::host
