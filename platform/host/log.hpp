// Talk to the person at the terminal: one line each on stderr, no time stamps. Never for results (stdout), user errors
// (UserError) or bugs (ALU_CHECK). Thread-safe. A line break inside a message is kept.
#pragma once

#include <string_view>

#include "platform/host/terminal.hpp"

namespace aluminate::host {

enum class Talk { Quiet, Normal };

/// Quiet (-q): warnings only, no notes, no progress.
void set_talk(Talk talk);
[[nodiscard]] Talk talk();

/// Colours the "warning:" prefix; default Auto.
void set_log_color(ColorChoice choice);

/// "text".
void note(std::string_view text);

/// "warning: text". The same text is printed once a process.
void warning(std::string_view text);

}  // namespace aluminate::host
