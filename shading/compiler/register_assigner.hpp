// The work behind assign_registers(), in three files: registers.cpp (values that share a place),
// register_groups.cpp (values side by side in one register), gather.cpp (operands that name several
// registers). Private to this folder.
#pragma once

#include "shading/compiler/liveness.hpp"
#include "shading/compiler/registers.hpp"

#include <set>
#include <vector>

namespace aluminate::compiler {

// Values that share a place because one is copied into the other. Lane i of a member is lane lanes[i] of the
// unit.
struct Unit {
  int width = 0;
  std::vector<NodeId> members;
  int group = -1;
  std::array<std::uint8_t, 4> component{};  // position of each lane in the group's register
};

// Units that live in one register, in different components.
struct Group {
  std::vector<int> units;
  unsigned taken = 0;  // components
  bool fixed = false;  // positions cannot be permuted: a texture result
  int output = -1;     // an output register instead
  int reg = -1;
};

class Assigner {
 public:
  explicit Assigner(Ir& ir) : ir_(ir) {}
  std::map<NodeId, Place> run(int& register_count);

 private:
  // What the hardware reads as one register: a group, or one input, uniform, constant or counter.
  struct Origin {
    int kind = 0;  // 0 group, 1 literal, 2 other leaf
    std::uint64_t id = 0;
    bool negate = false, absolute = false;
    auto operator<=>(const Origin&) const = default;
  };
  using Key = std::vector<Ref>;
  using Known = std::vector<std::map<Key, Lanes>>;  // by scope of the control flow

  Node& node(NodeId id) { return ir_.nodes[id]; }
  bool has_place(NodeId id) const;
  void make_units();
  bool plain_copy(const Lanes& value, NodeId from, const std::vector<std::uint8_t>& to_lanes,
                  std::array<int, 4>& map) const;
  void try_unite(NodeId target, NodeId from, const std::array<int, 4>& map, const Liveness& live);
  void coalesce_copies();
  void make_groups();
  void new_group(int u);
  unsigned texture_lanes(NodeId id);
  Group& group_of(NodeId id);
  bool merge_groups(int a, int b);
  void direct_outputs();
  Origin origin_of(Ref r);
  bool one_origin(const Lanes& v);
  NodeId insert_mov(const Lanes& v, const Node& before);
  Lanes gathered(const Lanes& v, const Node& user);
  Lanes remember(const std::vector<Ref>& key, const Lanes& v);
  Lanes fetchable(const Lanes& v, const Node& user);
  static Lanes lanes_of(NodeId id, int width);
  Ref addressable(Ref r, const Node& user);
  void gather_operands();
  void split_copy(NodeId id);
  std::map<NodeId, Place> places(int& register_count);

  Ir& ir_;
  std::vector<int> unit_of_;                        // by node, -1 = no place
  std::vector<std::array<std::uint8_t, 4>> lanes_;  // by node: lane of its unit for each lane
  std::vector<Unit> units_;
  std::vector<Group> groups_;
  std::map<NodeId, unsigned> texture_lanes_;
  std::vector<NodeId> order_;  // the new list of instructions
  Known known_, fetch_known_, address_known_;
  std::map<std::pair<NodeId, Ref>, NodeId> readdressed_;
};

}  // namespace aluminate::compiler
