// Two pictures of one size on one page that needs no server and no network: side by side under a slider,
// blinking, their difference, and the values under the pointer. In: stored pixels. Out: HTML text, the same
// bytes for the same input.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace aluminate::report {

struct DifferencePage {
  std::string title, name_a, name_b;
  std::string command;  // makes B again; may be empty
  std::string accept;   // command that accepts B; may be empty
  int width = 0, height = 0;
  std::span<const std::uint8_t> a, b;  // RGBA, width*height*4
};

std::string difference_page(const DifferencePage& page);

/// [RFC4648], with padding.
std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace aluminate::report
