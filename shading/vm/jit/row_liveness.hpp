// Which rows are read later: what a stretch of compiled code has to leave in memory when it ends.
//   in   a decoded program
//   out  for any operation and any block, the rows somebody may still read
#pragma once

#include <vector>

#include "shading/vm/decoded.hpp"

namespace aluminate::vm::jit {

using RowSet = std::vector<bool>;  // by row number: offset / kLanes

/// Number of leading entries of Operation::src that the kernel reads.
int source_count(const Operation& op);

class RowLiveness {
 public:
  explicit RowLiveness(const Decoded& decoded);
  /// Rows that may be read after operation `index` of block `block` has run.
  RowSet after(std::size_t block, std::uint32_t index) const;

 private:
  void step_back(const Operation& op, RowSet& live) const;

  const Decoded& d_;
  std::vector<RowSet> end_;  // per block: live where its operations end
};

}  // namespace aluminate::vm::jit
