// Where values that take part in copies are alive, lane by lane: the masked vector program is read as the
// control flow one lane follows.
#pragma once

#include "shading/compiler/ir.hpp"

#include <cstdint>
#include <map>
#include <vector>

namespace aluminate::compiler {

class Liveness {
 public:
  explicit Liveness(const Ir& ir);

  /// True when one of the two is written while the other is still needed, other than by a copy between them.
  bool interfere(NodeId a, NodeId b) const;

 private:
  struct Definition {
    std::size_t position;
    NodeId copy_of;  // 0 = not a copy
  };
  bool live_after(NodeId id, std::size_t position) const;

  std::map<NodeId, std::uint32_t> bit_;
  std::map<NodeId, std::vector<Definition>> definitions_;
  std::vector<std::vector<bool>> live_out_;  // per position
};

}  // namespace aluminate::compiler
