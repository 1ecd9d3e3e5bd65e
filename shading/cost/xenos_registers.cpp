#include "shading/cost/xenos_registers.hpp"

#include "platform/host/error.hpp"

#include <algorithm>
#include <map>

namespace aluminate::cost {
namespace {

/// Issues are numbered through the program. A component is occupied from the issue that writes it up to, not
/// including, the issue that reads it last: both halves of a word read before either writes.
struct Span {
  int begin = 0, end = 0;
  void cover(int position) { end = std::max(end, position); }
};

class RegisterFile {
 public:
  bool is_free(int gpr, int component, const Span& span) const {
    if (gpr >= static_cast<int>(used_.size())) return true;
    for (const Span& other : used_[static_cast<std::size_t>(gpr)][static_cast<std::size_t>(component)]) {
      if (span.begin < other.end && other.begin < span.end) return false;
    }
    return true;
  }
  void take(int gpr, int component, const Span& span) {
    if (gpr >= static_cast<int>(used_.size())) used_.resize(static_cast<std::size_t>(gpr) + 1);
    used_[static_cast<std::size_t>(gpr)][static_cast<std::size_t>(component)].push_back(span);
  }
  int size() const { return static_cast<int>(used_.size()); }

 private:
  std::vector<std::array<std::vector<Span>, 4>> used_;
};

/// Lanes that must end up in one register, each with its own lifetime.
struct Request {
  int begin = 0;
  std::vector<std::pair<int, int>> lanes;  // (node, lane)
  std::vector<Span> spans;
};

/// First register, lowest components first, with room for all spans. Components in order of `lanes`.
std::pair<int, std::vector<int>> place(const RegisterFile& file, const std::vector<Span>& spans) {
  for (int gpr = 0;; ++gpr) {
    std::array<int, 4> order = {0, 1, 2, 3};
    do {
      bool fits = true;
      for (std::size_t i = 0; i < spans.size() && fits; ++i) fits = file.is_free(gpr, order[i], spans[i]);
      if (fits) return {gpr, {order.begin(), order.begin() + static_cast<std::ptrdiff_t>(spans.size())}};
    } while (std::next_permutation(order.begin(), order.end()));
  }
}

}  // namespace

RegisterMap assign_registers(const vm::Program& program, const std::vector<vm::Block>& blocks,
                             const std::vector<std::uint8_t>& homes, std::vector<ScheduledBlock>& scheduled) {
  // Positions: block b owns [first[b], first[b] + issues + 1); the last one is the end of the block.
  std::vector<int> first(blocks.size() + 1, 0);
  for (std::size_t b = 0; b < blocks.size(); ++b)
    first[b + 1] = first[b] + static_cast<int>(scheduled[b].schedule.issues.size()) + 1;

  // What lives across iterations lives through the outermost loop.
  std::vector<Span> loop_of(blocks.size());
  for (std::size_t b = 0; b < blocks.size(); ++b) loop_of[b] = {first[b], first[b + 1] - 1};
  for (std::size_t b = 0; b < blocks.size();) {
    if (blocks[b].loop_depth == 0) {
      ++b;
      continue;
    }
    std::size_t end = b;
    while (end < blocks.size() && blocks[end].loop_depth > 0) ++end;
    for (std::size_t inside = b; inside < end; ++inside) loop_of[inside] = {first[b], first[end]};
    b = end;
  }

  std::vector<Span> input_span(program.inputs.size(), Span{-1, -1});
  std::vector<Span> home_span(homes.size(), Span{-2, -2});
  std::vector<Request> requests;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    ScheduledBlock& block = scheduled[b];
    const Graph& graph = block.graph;
    block.results.assign(graph.nodes.size(), {});
    std::vector<int> issued(graph.nodes.size(), -1);
    std::vector<std::array<Span, 4>> lane_span(graph.nodes.size());
    const auto touch_home = [&](std::uint32_t temp, int position) {
      Span& span = home_span[temp];
      const Span around = blocks[b].loop_depth > 0 ? loop_of[b] : Span{position, position + 1};
      if (span.begin == -2) span = around;
      span.begin = std::min(span.begin, around.begin);
      span.cover(around.end);
    };
    const auto read = [&](const Operand& operand, int position) {
      for (int i = 0; i < operand.count; ++i) {
        const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
        if (ref.kind == Ref::Kind::Node) {
          const Node& source = graph.nodes[ref.index];
          if (source.dest == DestKind::Home) {
            touch_home(source.dest_index, position);
          } else {
            lane_span[ref.index][ref.component].cover(position);
          }
        } else if (ref.kind == Ref::Kind::Input) {
          input_span[ref.index].cover(blocks[b].loop_depth > 0 ? loop_of[b].end : position);
        } else if (ref.kind == Ref::Kind::Home) {
          touch_home(ref.index, position);
        }
      }
    };
    const auto write = [&](int n, int position) {
      if (n < 0) return;
      issued[static_cast<std::size_t>(n)] = position;
      const Node& node = graph.nodes[static_cast<std::size_t>(n)];
      if (node.dest == DestKind::Home) touch_home(node.dest_index, position);
      if (node.dest != DestKind::Value) return;
      for (int lane = 0; lane < node.width; ++lane)
        lane_span[static_cast<std::size_t>(n)][static_cast<std::size_t>(lane)] = {position, position + 1};
    };
    for (std::size_t i = 0; i < block.schedule.issues.size(); ++i) {
      const Issue& issue = block.schedule.issues[i];
      const int position = first[b] + static_cast<int>(i);
      for (int n : {issue.fetch, issue.vector, issue.scalar}) {
        if (n < 0) continue;
        const Node& node = graph.nodes[static_cast<std::size_t>(n)];
        const int skipped = n == issue.scalar && issue.uses_previous ? carried_operand(graph, node) : -1;
        for (int s = 0; s < node.sources; ++s) {
          if (s != skipped) read(node.src[static_cast<std::size_t>(s)], position);
        }
      }
      if (issue.previous_move >= 0) {
        const Node& node = graph.nodes[static_cast<std::size_t>(issue.previous_move)];
        read(node.src[static_cast<std::size_t>(carried_operand(graph, node))], position);
      }
      for (int n : {issue.fetch, issue.vector, issue.scalar}) write(n, position);
    }
    std::map<int, Request> groups;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      const Node& node = graph.nodes[n];
      if (node.removed || node.dest != DestKind::Value) continue;
      ALU_CHECK(issued[n] >= 0, "operation {} was never issued", n);
      Request& request = groups[graph.groups.find(static_cast<int>(n))];
      for (int lane = 0; lane < node.width; ++lane) {
        request.lanes.emplace_back(static_cast<int>(n), lane);
        request.spans.push_back(lane_span[n][static_cast<std::size_t>(lane)]);
      }
      request.begin = request.lanes.size() == static_cast<std::size_t>(node.width)
                          ? issued[n]
                          : std::min(request.begin, issued[n]);
    }
    std::vector<Request> ordered;
    for (auto& [root, request] : groups) ordered.push_back(std::move(request));
    std::stable_sort(ordered.begin(), ordered.end(),
                     [](const Request& a, const Request& c) { return a.begin < c.begin; });
    for (Request& request : ordered) {
      ALU_CHECK(request.lanes.size() <= 4, "a register group has {} components", request.lanes.size());
      request.begin = static_cast<int>(b);  // from here on: the block
      requests.push_back(std::move(request));
    }
  }

  RegisterFile file;
  RegisterMap map;
  map.input_gpr.assign(program.inputs.size(), -1);
  map.home_gpr.assign(homes.size(), -1);
  int next = 0;
  for (std::size_t v = 0; v < program.inputs.size(); ++v) {
    if (input_span[v].end < 0) continue;
    map.input_gpr[v] = next;
    for (int c = 0; c < 4; ++c) {
      if (program.inputs[v].mask >> c & 1) file.take(next, c, input_span[v]);
    }
    ++next;
  }
  for (std::size_t temp = 0; temp < homes.size(); ++temp) {
    if (home_span[temp].begin == -2) continue;
    int gpr = 0;
    const auto fits = [&] {
      for (int c = 0; c < 4; ++c) {
        if ((homes[temp] >> c & 1) != 0 && !file.is_free(gpr, c, home_span[temp])) return false;
      }
      return true;
    };
    while (!fits()) ++gpr;
    for (int c = 0; c < 4; ++c) {
      if (homes[temp] >> c & 1) file.take(gpr, c, home_span[temp]);
    }
    map.home_gpr[temp] = gpr;
  }
  for (const Request& request : requests) {
    const auto [gpr, components] = place(file, request.spans);
    ScheduledBlock& block = scheduled[static_cast<std::size_t>(request.begin)];
    for (std::size_t i = 0; i < request.lanes.size(); ++i) {
      file.take(gpr, components[i], request.spans[i]);
      Location& location = block.results[static_cast<std::size_t>(request.lanes[i].first)];
      location.gpr = gpr;
      location.component[static_cast<std::size_t>(request.lanes[i].second)] =
          static_cast<std::uint8_t>(components[i]);
    }
  }
  for (ScheduledBlock& block : scheduled) {
    for (std::size_t n = 0; n < block.graph.nodes.size(); ++n) {
      const Node& node = block.graph.nodes[n];
      if (node.removed || node.dest != DestKind::Home) continue;
      Location& location = block.results[n];
      location.gpr = map.home_gpr[node.dest_index];
      for (std::uint8_t c = 0; c < 4; ++c) {
        if (node.dest_lane[c] >= 0) location.component[static_cast<std::size_t>(node.dest_lane[c])] = c;
      }
    }
  }
  map.gprs = std::max({1, file.size(), next});
  return map;
}

}  // namespace aluminate::cost
