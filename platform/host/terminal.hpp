// What stderr and stdout are allowed to look like: colour rules, and the one status line that progress draws and log
// lines must not run into. Never writes to stdout.
#pragma once

#include <string_view>

namespace aluminate::host {

enum class ColorChoice { Auto, Always, Never };  // --color
enum class Stream { Out, Error };

/// What the rules look at; a null pointer is an unset variable.
struct TerminalFacts {
  bool is_terminal = false;
  const char* no_color = nullptr;     // NO_COLOR: not empty = off
  const char* force_color = nullptr;  // FORCE_COLOR: not empty and not "0" = on
  const char* term = nullptr;         // TERM: "dumb" or unset = off
};

/// --color always|never decides; else NO_COLOR, then FORCE_COLOR, then a terminal that is not dumb.
[[nodiscard]] bool color_enabled(ColorChoice choice, const TerminalFacts& facts) noexcept;
/// The same with this process's facts.
[[nodiscard]] bool color_enabled(Stream stream, ColorChoice choice);
[[nodiscard]] bool is_terminal(Stream stream) noexcept;

/// Columns of the terminal behind a stream, 80 when unknown.
[[nodiscard]] int terminal_columns(Stream stream) noexcept;

/// The status line on stderr: replaced in place, no newline. Thread-safe; log lines erase it first.
void show_status_line(std::string_view text);
void erase_status_line();

}  // namespace aluminate::host
