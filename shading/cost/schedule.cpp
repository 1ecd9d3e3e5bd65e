#include "shading/cost/schedule.hpp"

#include "platform/host/error.hpp"
#include "shading/cost/xenos_packing.hpp"
#include "shading/cost/xenos_rewrite.hpp"

#include <algorithm>
#include <optional>

namespace aluminate::cost {
namespace {

using vm::Opcode;

/// Where an operation can go.
struct SlotChoice {
  bool vector = false, scalar = false, two_slots = false;  // two_slots: movs + _prev (rule 3)
  bool alone = false;                                      // shares a word with nothing
};

SlotChoice slots_of(const Graph& graph, const Node& node, PairingRule pairing) {
  SlotChoice choice;
  if (node.is_fetch()) return choice;
  const vm::Pipe pipe = node.special == Special::None ? vm::info(node.op).pipe : vm::Pipe::Vector;
  choice.vector = pipe != vm::Pipe::Scalar;
  choice.scalar = fits_scalar_half(graph, node);
  if (pairing == PairingRule::Loose && pipe == vm::Pipe::Either && node.width == 1) choice.scalar = true;
  choice.two_slots = !choice.scalar && node.width == 1 && node.special == Special::None &&
                     (node.op == Opcode::Mul || node.op == Opcode::Add) &&
                     !node.src[0].refs[0].is_constant() && !node.src[1].refs[0].is_constant();
  choice.alone = node.special == Special::SetPredicate ||
                 (pairing == PairingRule::Strict && choice.vector && node.sources == 3);
  return choice;
}

enum class Order : std::uint8_t { Chain, Pairs, Late };

/// How ready operations are ranked. shake 0 is the plain rule; others add 0 to 2 words to each operation's
/// chain by a fixed hash, so that a schedule above its bound gets other chances without any chance at all.
struct Priority {
  Order order = Order::Chain;
  std::uint32_t shake = 0;
};

int shaken(std::uint32_t shake, int node) {
  if (shake == 0) return 0;
  std::uint32_t hash = (shake * 0x9E3779B9u) ^ (static_cast<std::uint32_t>(node) * 0x85EBCA6Bu);
  hash ^= hash >> 15;
  hash *= 0x2C1B3C6Du;
  hash ^= hash >> 13;
  return static_cast<int>(hash % 3);
}

/// Places the words of one region (between two levels of fetches) from the last to the first.
class RegionScheduler {
 public:
  RegionScheduler(const Graph& graph, const std::vector<SlotChoice>& slots, const ConstantUse& constants,
                  const ChainLengths& lengths, Priority priority, const std::vector<bool>& member)
      : graph_(graph),
        slots_(slots),
        constants_(constants),
        lengths_(lengths),
        priority_(priority),
        waiting_(graph.nodes.size(), 0),
        before_(graph.nodes.size()) {
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      if (!member[n]) continue;
      ++left_;
      for_each_dependency(graph.nodes[n], [&](int from) {
        if (!member[static_cast<std::size_t>(from)]) return;
        ++waiting_[static_cast<std::size_t>(from)];
      });
    }
    for (const auto& [reader, writer] : graph.write_after_read) {
      if (!member[static_cast<std::size_t>(reader)] || !member[static_cast<std::size_t>(writer)]) continue;
      before_[static_cast<std::size_t>(writer)].push_back(reader);
      ++waiting_[static_cast<std::size_t>(reader)];
    }
    member_ = member;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      if (member[n] && waiting_[n] == 0) ready_.push_back(static_cast<int>(n));
    }
  }

  /// Words in reverse order.
  std::vector<Issue> run() {
    std::vector<Issue> words;
    while (left_ > 0 || carried_ >= 0) {
      Issue word = best_word();
      word.previous_move = carried_;
      release(word);
      words.push_back(word);
    }
    return words;
  }

 private:
  struct Score {
    int first = 0, second = 0, third = 0, fourth = 0;
    auto operator<=>(const Score&) const = default;
  };

  const Node& node(int n) const { return graph_.nodes[static_cast<std::size_t>(n)]; }
  const SlotChoice& slots(int n) const { return slots_[static_cast<std::size_t>(n)]; }
  int chain(int n) const {
    return n < 0 ? 0 : lengths_.depth[static_cast<std::size_t>(n)] + shaken(priority_.shake, n);
  }

  bool legal_pair(int vector, int scalar) const {
    if (vector < 0 || scalar < 0) return true;
    const Node& v = node(vector);
    const Node& s = node(scalar);
    if (slots(vector).alone) return false;
    const bool v_export = v.dest == DestKind::Export, s_export = s.dest == DestKind::Export;
    if (v_export != s_export || (v_export && v.dest_index != s.dest_index)) {
      // An export word names one export register for both halves; an effect writes nothing.
      if ((v_export && s.dest != DestKind::Effect) || (s_export && v.dest != DestKind::Effect)) return false;
    }
    return constants_.registers(vector, scalar) <= 2;
  }

  /// A movs of the carried operand can share the word of this vector operation.
  bool legal_with_move(int vector) const {
    return vector < 0 || (!slots(vector).alone && node(vector).dest != DestKind::Export);
  }

  Score score(int vector, int scalar, bool two_slots) const {
    const int count = (vector >= 0) + (scalar >= 0);
    const int vector_only = vector >= 0 && !slots(vector).scalar ? 1 : 0;
    const int longest = std::max(chain(vector), chain(scalar)), both = chain(vector) + chain(scalar);
    const int late = vector + scalar;
    switch (priority_.order) {
      case Order::Chain:
        return {longest, 2 * count - (two_slots ? 1 : 0), both + vector_only, late};
      case Order::Pairs:
        return {2 * count - (two_slots ? 1 : 0), longest, both + vector_only, late};
      case Order::Late:
        return {std::max(vector, scalar), 2 * count - (two_slots ? 1 : 0), vector_only, longest};
    }
    return {};
  }

  Issue best_word() const {
    Issue best;
    std::optional<Score> best_score;
    const auto offer = [&](int vector, int scalar, bool two_slots) {
      const Score offered = score(vector, scalar, two_slots);
      if (best_score && !(offered > *best_score)) return;
      best_score = offered;
      best.vector = vector;
      best.scalar = scalar;
      best.uses_previous = two_slots;
    };
    for (int v : ready_) {
      if (!slots(v).vector) continue;
      if (carried_ >= 0 && !legal_with_move(v)) continue;
      offer(v, -1, false);
      if (carried_ >= 0) continue;
      for (int s : ready_) {
        if (s == v || !legal_pair(v, s)) continue;
        if (slots(s).scalar) {
          offer(v, s, false);
        } else if (slots(s).two_slots) {
          offer(v, s, true);
        }
      }
    }
    if (carried_ >= 0) return best;
    for (int s : ready_) {
      if (slots(s).scalar) offer(-1, s, false);
    }
    ALU_CHECK(best_score.has_value(), "nothing can issue: dependencies form a cycle");
    return best;
  }

  void unblock(int from) {
    if (!member_[static_cast<std::size_t>(from)]) return;
    if (--waiting_[static_cast<std::size_t>(from)] == 0) ready_.push_back(from);
  }

  /// The nodes of a word leave; what they read may come into earlier words. A carried operand is read one
  /// word earlier.
  void release(const Issue& word) {
    const int finished_move = carried_;
    carried_ = word.uses_previous ? word.scalar : -1;
    for (int n : {word.vector, word.scalar}) {
      if (n < 0) continue;
      --left_;
      std::erase(ready_, n);
      for (int reader : before_[static_cast<std::size_t>(n)]) unblock(reader);
      const int skipped = n == carried_ ? carried_operand(graph_, node(n)) : -1;
      for (int s = 0; s < node(n).sources; ++s) {
        if (s != skipped) unblock_operand(node(n).src[static_cast<std::size_t>(s)]);
      }
      if (node(n).after >= 0) unblock(node(n).after);
    }
    if (finished_move >= 0)
      unblock_operand(
          node(finished_move).src[static_cast<std::size_t>(carried_operand(graph_, node(finished_move)))]);
    std::sort(ready_.begin(), ready_.end());
  }

  void unblock_operand(const Operand& operand) {
    for (int i = 0; i < operand.count; ++i) {
      const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
      if (ref.kind == Ref::Kind::Node) unblock(static_cast<int>(ref.index));
      if (ref.address_node >= 0) unblock(ref.address_node);
    }
  }

  const Graph& graph_;
  const std::vector<SlotChoice>& slots_;
  const ConstantUse& constants_;
  const ChainLengths& lengths_;
  Priority priority_;
  std::vector<int> waiting_;
  std::vector<std::vector<int>> before_;
  std::vector<bool> member_;
  std::vector<int> ready_;
  int left_ = 0;
  int carried_ = -1;
};

/// Fetches go as early as they can: a level holds those that wait for the same number of fetches. ALU words
/// that a level needs stand in front of it, all others after the last fetch.
struct FetchLevels {
  std::vector<int> of_node;  // level whose region the node belongs to; `count` = after the last fetch
  int count = 0;
};

FetchLevels find_levels(const Graph& graph) {
  const std::size_t size = graph.nodes.size();
  std::vector<int> earliest(size, 0);
  const auto after = [&](int from, std::size_t n) {  // least level of n, which comes after `from`
    const Node& source = graph.nodes[static_cast<std::size_t>(from)];
    return earliest[static_cast<std::size_t>(from)] +
           (source.is_fetch() && source.special == Special::None ? 1 : 0) +
           (source.special == Special::FetchSetup && !graph.nodes[n].is_fetch() ? 1 : 0);
  };
  for (bool changed = true; changed;) {  // blocks are small: relax until stable
    changed = false;
    const auto raise = [&](std::size_t n, int level) {
      if (level > earliest[n]) {
        earliest[n] = level;
        changed = true;
      }
    };
    for (std::size_t n = 0; n < size; ++n) {
      if (!graph.nodes[n].removed)
        for_each_dependency(graph.nodes[n], [&](int from) { raise(n, after(from, n)); });
    }
    for (const auto& [reader, writer] : graph.write_after_read)
      raise(static_cast<std::size_t>(writer), after(reader, static_cast<std::size_t>(writer)));
    for (const Node& node : graph.nodes) {  // a fetch and its set-up issue together
      if (!node.removed && node.is_fetch() && node.after >= 0) {
        raise(static_cast<std::size_t>(node.after),
              earliest[static_cast<std::size_t>(&node - graph.nodes.data())]);
      }
    }
  }
  FetchLevels levels;
  for (std::size_t n = 0; n < size; ++n) {
    if (!graph.nodes[n].removed && graph.nodes[n].is_fetch())
      levels.count = std::max(levels.count, earliest[n] + 1);
  }
  levels.of_node.assign(size, levels.count);
  for (std::size_t n = 0; n < size; ++n) {
    if (!graph.nodes[n].removed && graph.nodes[n].is_fetch()) levels.of_node[n] = earliest[n];
  }
  for (bool changed = true; changed;) {
    changed = false;
    const auto lower = [&](int from, int level) {
      if (levels.of_node[static_cast<std::size_t>(from)] > level) {
        levels.of_node[static_cast<std::size_t>(from)] = level;
        changed = true;
      }
    };
    for (std::size_t n = 0; n < size; ++n) {
      if (!graph.nodes[n].removed)
        for_each_dependency(graph.nodes[n], [&](int from) { lower(from, levels.of_node[n]); });
    }
    for (const auto& [reader, writer] : graph.write_after_read)
      lower(reader, levels.of_node[static_cast<std::size_t>(writer)]);
  }
  return levels;
}

int divide_up(int a, int b) { return (a + b - 1) / b; }

BlockSchedule try_priority(const Graph& graph, const std::vector<SlotChoice>& slots,
                           const ConstantUse& constants, const ChainLengths& lengths,
                           const FetchLevels& levels, Priority priority) {
  BlockSchedule schedule;
  for (int level = 0; level <= levels.count; ++level) {
    std::vector<bool> member(graph.nodes.size(), false);
    std::vector<int> fetches;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
      if (graph.nodes[n].removed || levels.of_node[n] != level) continue;
      if (graph.nodes[n].is_fetch()) {
        fetches.push_back(static_cast<int>(n));
      } else {
        member[n] = true;
      }
    }
    std::vector<Issue> words = RegionScheduler(graph, slots, constants, lengths, priority, member).run();
    std::reverse(words.begin(), words.end());
    schedule.words += static_cast<int>(words.size());
    schedule.issues.insert(schedule.issues.end(), words.begin(), words.end());
    // Set-up words directly precede their fetch.
    std::vector<bool> issued(graph.nodes.size(), false);
    for (int fetch : fetches) {
      std::vector<int> chain;
      for (int n = fetch; n >= 0 && !issued[static_cast<std::size_t>(n)];
           n = graph.nodes[static_cast<std::size_t>(n)].after)
        chain.push_back(n);
      if (graph.nodes[static_cast<std::size_t>(fetch)].special == Special::FetchSetup) continue;
      for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
        Issue issue;
        issue.fetch = *it;
        issued[static_cast<std::size_t>(*it)] = true;
        schedule.issues.push_back(issue);
        ++schedule.fetch_words;
      }
    }
    if (level + 1 == levels.count || levels.count == 0)
      schedule.export_start = static_cast<int>(schedule.issues.size());
  }
  if (levels.count == 0) schedule.export_start = 0;
  const int total = static_cast<int>(schedule.issues.size());
  if (graph.has_export) {
    schedule.clauses = divide_up(schedule.export_start, kClauseIssues) +
                       divide_up(total - schedule.export_start, kClauseIssues);
  } else {
    schedule.export_start = -1;
    schedule.clauses = divide_up(total, kClauseIssues);
  }
  return schedule;
}

}  // namespace

int carried_operand(const Graph& graph, const Node& node) {
  const auto made_late = [&](const Operand& operand) {
    return operand.refs[0].kind == Ref::Kind::Node && !graph.nodes[operand.refs[0].index].is_fetch();
  };
  const bool late0 = made_late(node.src[0]), late1 = made_late(node.src[1]);
  if (late0 != late1) return late0 ? 1 : 0;
  return node.src[0].refs[0].index <= node.src[1].refs[0].index ? 0 : 1;
}

int lower_bound_words(const Graph& graph, PairingRule pairing) {
  // For every head and tail: operations with at least `head` words before them and `tail` words after them
  // all issue in between, and need at least the words their halves need.
  const ChainLengths lengths = chain_lengths(graph);
  struct Need {
    int head, tail;
    int alone, vector, scalar, either;
  };
  std::vector<Need> needs;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Node& node = graph.nodes[n];
    if (node.removed || node.is_fetch()) continue;
    const SlotChoice choice = slots_of(graph, node, pairing);
    Need need{lengths.depth[n] - 1, lengths.height[n] - 1, 0, 0, 0, 0};
    if (choice.alone) {
      need.alone = 1;
    } else if (choice.vector && !choice.scalar && !choice.two_slots) {
      need.vector = 1;
    } else if (!choice.vector) {
      need.scalar = 1;
    } else {
      need.either = 1;  // a two-slot form never needs fewer halves than one vector operation
    }
    needs.push_back(need);
  }
  int bound = lengths.longest;
  for (int head = 0; head < lengths.longest; ++head) {
    for (int tail = 0; head + tail < lengths.longest; ++tail) {
      int alone = 0, vector = 0, scalar = 0, either = 0;
      for (const Need& need : needs) {
        if (need.head < head || need.tail < tail) continue;
        alone += need.alone;
        vector += need.vector;
        scalar += need.scalar;
        either += need.either;
      }
      const int halves = divide_up(vector + scalar + either, 2);
      bound = std::max(bound, head + tail + alone + std::max({vector, scalar, halves}));
    }
  }
  return bound;
}

BlockSchedule schedule_block(const Graph& graph, PairingRule pairing) {
  std::vector<SlotChoice> slots;
  slots.reserve(graph.nodes.size());
  for (const Node& node : graph.nodes) slots.push_back(slots_of(graph, node, pairing));
  const ConstantUse constants(graph);
  const ChainLengths lengths = chain_lengths(graph);
  const FetchLevels levels = find_levels(graph);
  const int bound = lower_bound_words(graph, pairing);
  BlockSchedule best;
  bool first = true;
  const auto attempt = [&](Priority priority) {
    BlockSchedule schedule = try_priority(graph, slots, constants, lengths, levels, priority);
    if (first || schedule.words < best.words) best = std::move(schedule);
    first = false;
  };
  for (Order order : {Order::Chain, Order::Pairs, Order::Late}) attempt({order, 0});
  constexpr std::uint32_t kShakes = 16;
  for (std::uint32_t shake = 1; shake <= kShakes && best.words > bound; ++shake)
    attempt({shake % 2 == 0 ? Order::Pairs : Order::Chain, shake});
  best.bound_words = bound;
  return best;
}

}  // namespace aluminate::cost
