#include "shading/cost/xenos_packing.hpp"

#include "shading/cost/xenos_rewrite.hpp"

#include <algorithm>
#include <optional>

namespace aluminate::cost {
namespace {

using vm::Opcode;

bool commutes(Opcode op) {
  return op == Opcode::Mul || op == Opcode::Mad || op == Opcode::Add || op == Opcode::Min ||
         op == Opcode::Max;
}

bool packable(Opcode op) {
  return commutes(op) || op == Opcode::CndGe || op == Opcode::CndGt || op == Opcode::CndEq ||
         op == Opcode::Sge || op == Opcode::Sgt;
}

/// Nodes in an order where producers come first; shorter than the graph when it has a cycle.
std::vector<int> topological_order(const Graph& graph) {
  std::vector<std::vector<int>> readers(graph.nodes.size());
  std::vector<int> waiting(graph.nodes.size(), 0), ready, order;
  const auto edge = [&](int from, int to) {
    readers[static_cast<std::size_t>(from)].push_back(to);
    ++waiting[static_cast<std::size_t>(to)];
  };
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!graph.nodes[n].removed)
      for_each_dependency(graph.nodes[n], [&](int from) { edge(from, static_cast<int>(n)); });
  }
  for (const auto& [reader, writer] : graph.write_after_read) edge(reader, writer);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!graph.nodes[n].removed && waiting[n] == 0) ready.push_back(static_cast<int>(n));
  }
  for (std::size_t i = 0; i < ready.size(); ++i) {
    order.push_back(ready[i]);
    for (int reader : readers[static_cast<std::size_t>(ready[i])]) {
      if (--waiting[static_cast<std::size_t>(reader)] == 0) ready.push_back(reader);
    }
  }
  return order;
}

bool depends_on(const Graph& graph, int node, int target) {
  std::vector<int> pending = {node};
  std::vector<bool> seen(graph.nodes.size(), false);
  while (!pending.empty()) {
    const int n = pending.back();
    pending.pop_back();
    if (n == target) return true;
    if (seen[static_cast<std::size_t>(n)]) continue;
    seen[static_cast<std::size_t>(n)] = true;
    for_each_dependency(graph.nodes[static_cast<std::size_t>(n)], [&](int from) { pending.push_back(from); });
  }
  return false;
}

/// The guest's operand may stand behind the host's: same modifiers and one register for all lanes.
bool operands_join(const Graph& graph, RegisterGroups& groups, const Operand& host, const Operand& guest) {
  const bool host_literal = host.refs[0].kind == Ref::Kind::Literal,
             guest_literal = guest.refs[0].kind == Ref::Kind::Literal;
  if (host_literal != guest_literal) return false;
  if (host.negate != guest.negate || host.absolute != guest.absolute) return false;
  return host_literal || share_register(graph, groups, host.refs[0], guest.refs[0]);
}

/// The host with the guest's lanes appended, if it is legal; merges register groups in `groups`.
std::optional<Node> joined(const Graph& graph, RegisterGroups& groups, int host_index, int guest_index) {
  const Node& host = graph.nodes[static_cast<std::size_t>(host_index)];
  const Node& guest = graph.nodes[static_cast<std::size_t>(guest_index)];
  if (!groups.can_merge(host_index, guest_index)) return std::nullopt;
  for (int swap = 0; swap < (commutes(host.op) ? 2 : 1); ++swap) {
    Node turned = guest;
    if (swap == 1) std::swap(turned.src[0], turned.src[1]);
    RegisterGroups trial = groups;
    bool legal = true;
    for (std::size_t s = 0; s < static_cast<std::size_t>(host.sources); ++s)
      legal = legal && operands_join(graph, trial, host.src[s], turned.src[s]);
    if (!legal || !trial.can_merge(host_index, guest_index)) continue;
    Node node = host;
    for (std::size_t s = 0; s < static_cast<std::size_t>(host.sources); ++s) {
      for (int lane = 0; lane < guest.width; ++lane) {
        node.src[s].refs[static_cast<std::size_t>(host.width + lane)] =
            turned.src[s].refs[static_cast<std::size_t>(lane)];
      }
      node.src[s].count = host.width + guest.width;
    }
    node.width = host.width + guest.width;
    if (constant_registers(graph, &node) > 2) continue;
    trial.merge(host_index, guest_index);
    groups = trial;
    return node;
  }
  return std::nullopt;
}

bool takes_lane(const Graph& graph, const Node& node) {
  return !node.removed && node.special == Special::None && node.dest == DestKind::Value &&
         packable(node.op) && (node.width > 1 || !fits_scalar_half(graph, node));
}

}  // namespace

bool fits_scalar_half(const Graph& graph, const Node& node) {
  if (node.width != 1 || node.special != Special::None || node.is_reduction()) return false;
  const vm::Pipe pipe = vm::info(node.op).pipe;
  if (pipe == vm::Pipe::Scalar) return true;
  if (pipe != vm::Pipe::Either) return false;
  if (node.sources == 1) return true;
  const Ref& a = node.src[0].refs[0];
  const Ref& b = node.src[1].refs[0];
  const bool compare =
      node.op == Opcode::Sge || node.op == Opcode::Sgt || node.op == Opcode::Seq || node.op == Opcode::Sne;
  if (compare)
    return b.kind == Ref::Kind::Literal && b.value == 0.0 && !a.is_constant();  // s**s compare with zero
  if (a.is_constant() && b.is_constant()) return false;
  if (a.is_constant() != b.is_constant())
    return node.op == Opcode::Add || node.op == Opcode::Mul;  // addsc, subsc, mulsc
  // One register, read twice: modifiers are the register's, except that the second sign is addition or
  // subtraction.
  const bool signs = node.src[0].absolute == node.src[1].absolute;
  return signs && place_of(graph, a) == place_of(graph, b);
}

ChainLengths chain_lengths(const Graph& graph, const std::vector<bool>* member) {
  const auto words_of = [&](int n) {
    const auto at = static_cast<std::size_t>(n);
    return !graph.nodes[at].is_fetch() && (member == nullptr || (*member)[at]) ? 1 : 0;
  };
  ChainLengths lengths;
  lengths.depth.assign(graph.nodes.size(), 0);
  lengths.height.assign(graph.nodes.size(), 0);
  const std::vector<int> order = topological_order(graph);
  for (int n : order) {
    const Node& node = graph.nodes[static_cast<std::size_t>(n)];
    int before = 0;
    for_each_dependency(
        node, [&](int from) { before = std::max(before, lengths.depth[static_cast<std::size_t>(from)]); });
    lengths.depth[static_cast<std::size_t>(n)] = before + words_of(n);
    lengths.longest = std::max(lengths.longest, before + words_of(n));
  }
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    const Node& node = graph.nodes[static_cast<std::size_t>(*it)];
    int& own = lengths.height[static_cast<std::size_t>(*it)];
    own += words_of(*it);
    for_each_dependency(node, [&](int from) {
      lengths.height[static_cast<std::size_t>(from)] =
          std::max(lengths.height[static_cast<std::size_t>(from)], own);
    });
  }
  return lengths;
}

int home_writer_on_cycle(const Graph& graph) {
  const std::vector<int> order = topological_order(graph);
  std::vector<bool> done(graph.nodes.size(), false);
  for (int n : order) done[static_cast<std::size_t>(n)] = true;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Node& node = graph.nodes[n];
    if (done[n] || node.removed || node.dest != DestKind::Home) continue;
    // Behind a cycle but not on it: some result of its own must lead back to it.
    for (const auto& [reader, writer] : graph.write_after_read) {
      if (writer == static_cast<int>(n) && !done[static_cast<std::size_t>(reader)])
        return static_cast<int>(n);
    }
  }
  return -1;
}

void pack_lanes(Graph& graph, Packing packing) {
  const bool watch_chains = packing == Packing::OffCriticalPath;
  ChainLengths lengths;
  if (watch_chains) lengths = chain_lengths(graph);
  const int longest = lengths.longest;
  for (std::size_t guest = 0; guest < graph.nodes.size(); ++guest) {
    if (!takes_lane(graph, graph.nodes[guest])) continue;
    for (std::size_t host = 0; host < graph.nodes.size(); ++host) {
      const Node& a = graph.nodes[host];
      const Node& b = graph.nodes[guest];
      if (host == guest || !takes_lane(graph, a) || a.op != b.op || a.saturate != b.saturate ||
          a.width < b.width || a.width + b.width > 4)
        continue;
      if (watch_chains && std::max(lengths.depth[host], lengths.depth[guest]) +
                                  std::max(lengths.height[host], lengths.height[guest]) - 1 >
                              longest)
        continue;
      if (depends_on(graph, static_cast<int>(host), static_cast<int>(guest)) ||
          depends_on(graph, static_cast<int>(guest), static_cast<int>(host)))
        continue;
      RegisterGroups groups = graph.groups;
      const std::optional<Node> node = joined(graph, groups, static_cast<int>(host), static_cast<int>(guest));
      if (!node) continue;
      const int offset = a.width;
      graph.groups = groups;
      graph.nodes[host] = *node;
      graph.nodes[guest].removed = true;
      for (Node& reader : graph.nodes) {
        for (std::size_t s = 0; s < static_cast<std::size_t>(reader.sources); ++s) {
          for (int i = 0; i < reader.src[s].count; ++i) {
            Ref& ref = reader.src[s].refs[static_cast<std::size_t>(i)];
            if (ref.kind == Ref::Kind::Node && ref.index == guest)
              ref = node_ref(static_cast<int>(host), offset + ref.component);
          }
        }
      }
      if (watch_chains) lengths = chain_lengths(graph);
      break;
    }
  }
}

}  // namespace aluminate::cost
