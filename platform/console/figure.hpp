// One hardware number with where it comes from. Platform files hold nothing else: a figure without a source
// or a confidence is refused on loading, so every verdict can say what it rests on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace aluminate::console {

enum class Confidence : std::uint8_t {
  Doc,       // read in a published source
  Inferred,  // derived from, or fitted to, published numbers
  Guess,     // plausible, no source seen
};

constexpr std::string_view confidence_word(Confidence confidence) {
  return confidence == Confidence::Doc ? "doc" : confidence == Confidence::Inferred ? "inferred" : "guess";
}

/// A non-negative number. low <= value <= high is the range a verdict is tested against; low == high == value
/// for documented figures and wherever the file gives no range. unit and meaning live in the schema
/// (platform_file.hpp).
struct Figure {
  double value = 0.0;
  double low = 0.0, high = 0.0;
  Confidence confidence = Confidence::Guess;
  std::string source;    // key of docs/references.md
  bool present = false;  // false only in optional tables a platform does not have ([edram])

  bool has_range() const { return low < high; }
};

}  // namespace aluminate::console
