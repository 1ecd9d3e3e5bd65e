#include "platform/host/suggest.hpp"

#include <algorithm>
#include <cstddef>

namespace aluminate::host {
namespace {

constexpr std::size_t kMaxListed = 12;

char folded(char c) {
  if (c == '_') return '-';
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool begins_with(std::string_view text, std::string_view start) {
  return start.size() <= text.size() &&
         std::equal(start.begin(), start.end(), text.begin(), [](char a, char b) { return folded(a) == folded(b); });
}

}  // namespace

// Optimal string alignment: the classic three-row table, where a swap may not be edited again.
int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> before_last(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before_last, last);
    std::swap(last, row);
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const bool same = folded(a[i - 1]) == folded(b[j - 1]);
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (same ? 0 : 1)});
      const bool swapped = i > 1 && j > 1 && folded(a[i - 1]) == folded(b[j - 2]) && folded(a[i - 2]) == folded(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::vector<std::string> nearest_names(std::string_view typed, std::span<const std::string> known, std::size_t limit) {
  struct Candidate {
    int distance;
    const std::string* name;
  };
  const int allowed = std::clamp(static_cast<int>(typed.size() / 3), 1, 4);
  std::vector<Candidate> candidates;
  for (const std::string& name : known) {
    const int distance = edit_distance(typed, name);
    // A prefix is a likelier slip than any misspelling of it, but less likely than one wrong letter.
    if (distance <= allowed) {
      candidates.push_back({distance, &name});
    } else if (typed.size() >= 2 && begins_with(name, typed)) {
      candidates.push_back({2, &name});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.distance < b.distance; });
  std::vector<std::string> names;
  for (const Candidate& candidate : candidates) {
    if (names.size() == limit) break;
    names.push_back(*candidate.name);
  }
  return names;
}

std::string did_you_mean(std::string_view typed, std::span<const std::string> known) {
  const std::vector<std::string> near = nearest_names(typed, known);
  std::string text;
  if (!near.empty()) {
    for (std::size_t i = 0; i < near.size(); ++i) {
      text += i == 0 ? "did you mean '" : i + 1 == near.size() ? "' or '" : "', '";
      text += near[i];
    }
    return text + "'?";
  }
  if (known.empty() || known.size() > kMaxListed) return "";
  for (const std::string& name : known) text += (text.empty() ? "one of: " : ", ") + name;
  return text;
}

}  // namespace aluminate::host
