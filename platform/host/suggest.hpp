// "did you mean": known names near a mistyped one, for options, keys, scenes and variants. Pure; order is deterministic.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace aluminate::host {

/// Insertions, deletions, substitutions and swaps of neighbours that turn a into b. Case, '-' and '_' do not count.
[[nodiscard]] int edit_distance(std::string_view a, std::string_view b);

/// Known names within a third of the typed length (at least 1, at most 4 edits) or that the typed text begins, nearest
/// first, then in the order of `known`; at most `limit`.
std::vector<std::string> nearest_names(std::string_view typed, std::span<const std::string> known, std::size_t limit = 3);

/// "did you mean 'x'?" / "did you mean 'x' or 'y'?", or "one of: a, b, c" when nothing is near and the list is short
/// (at most 12), else "". Ready to be a UserError hint.
std::string did_you_mean(std::string_view typed, std::span<const std::string> known);

}  // namespace aluminate::host
