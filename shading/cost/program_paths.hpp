// The least and the most a program can run, from its structure alone: If takes the cheaper or the dearer
// side, a counted loop its count, a loop of unknown length none or one. Quantities are bounded one by one.
#pragma once

#include "shading/vm/program.hpp"

#include <array>
#include <vector>

namespace aluminate::cost {

/// What a path adds up, per block: issue words, fetch cycles, exec clauses (flow words are counted here).
inline constexpr int kPathQuantities = 3;
using PathSum = std::array<double, kPathQuantities>;

struct PathBounds {
  PathSum shortest{}, longest{};
  bool straight_line = true;  // both ends are the same path
  bool known = true;          // no loop of unknown length
};

/// `of_block` is parallel to `blocks`; each Flow instruction that ends a block adds one to the third
/// quantity.
PathBounds bound_paths(const vm::Program& program, const std::vector<vm::Block>& blocks,
                       const std::vector<PathSum>& of_block);

}  // namespace aluminate::cost
