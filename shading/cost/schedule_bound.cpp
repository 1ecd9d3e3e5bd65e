#include "shading/cost/schedule_bound.hpp"

#include "shading/cost/xenos_packing.hpp"

#include <algorithm>
#include <map>
#include <vector>

namespace aluminate::cost {
namespace {

int divide_up(int a, int b) { return (a + b - 1) / b; }

bool belongs(const Graph& graph, std::size_t n, const std::vector<bool>* member) {
  const Node& node = graph.nodes[n];
  return !node.removed && !node.is_fetch() && (member == nullptr || (*member)[n]);
}

/// One operation's place: words at least before it, words at least behind it.
struct Need {
  int head, tail;
  SlotChoice slots;
  int output;  // export register, -1 = none
  bool effect;
};

std::vector<Need> needs_of(const Graph& graph, const PairRules& rules, const ChainLengths& lengths,
                           const std::vector<bool>* member) {
  std::vector<Need> needs;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    const Node& node = graph.nodes[n];
    if (!belongs(graph, n, member)) continue;
    needs.push_back({lengths.depth[n] - 1, lengths.height[n] - 1, rules.slots(static_cast<int>(n)),
                     node.dest == DestKind::Export ? static_cast<int>(node.dest_index) : -1,
                     node.dest == DestKind::Effect});
  }
  return needs;
}

/// Words that a set of operations fills, added one by one. Proof of the second form: a word that writes an
/// export holds nothing else but effects, and only one export register. So words of each export register and
/// words of the values are different words; effects that can share are left out of the count, which can only
/// lower it. No movs stands beside an export, so a two-slot export takes one half there.
class WordCount {
 public:
  explicit WordCount(bool open_front) : open_front_(open_front) {}
  void add(const Need& need) {
    all_.add(need.slots);
    if (need.output >= 0) {
      SlotChoice slots = need.slots;
      slots.two_slots = false;
      slots.scalar = slots.scalar || need.slots.two_slots;
      exports_[need.output].add(slots);
    } else if (!need.effect || need.slots.alone) {
      values_.add(need.slots);
    }
  }
  int words() const {
    int apart = values_.words(open_front_);
    for (const auto& [output, classes] : exports_) apart += classes.words(false);
    return std::max(apart, all_.words(open_front_));
  }

 private:
  bool open_front_;
  HalfCount all_, values_;
  std::map<int, HalfCount> exports_;
};

/// Bit rows: [n] holds what n depends on, directly or not, through results.
class Reach {
 public:
  explicit Reach(const Graph& graph)
      : words_((graph.nodes.size() + 63) / 64), rows_(graph.nodes.size() * words_, 0) {
    std::vector<bool> done(graph.nodes.size(), false);
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) fill(graph, n, done);
  }
  bool depends(int n, int on) const {
    const auto bit = static_cast<std::size_t>(on);
    return (rows_[static_cast<std::size_t>(n) * words_ + bit / 64] >> (bit % 64) & 1) != 0;
  }

 private:
  void fill(const Graph& graph, std::size_t n, std::vector<bool>& done) {
    if (done[n]) return;
    done[n] = true;
    if (graph.nodes[n].removed) return;
    for_each_dependency(graph.nodes[n], [&](int from) {
      const auto f = static_cast<std::size_t>(from);
      fill(graph, f, done);
      for (std::size_t w = 0; w < words_; ++w) rows_[n * words_ + w] |= rows_[f * words_ + w];
      rows_[n * words_ + f / 64] |= std::uint64_t{1} << (f % 64);
    });
  }
  std::size_t words_;
  std::vector<std::uint64_t> rows_;
};

/// Most disjoint edges between two copies of the nodes: twice the most pairs that can be formed, or more (a
/// pair is an edge in both directions). Augmenting paths.
class DoubledMatching {
 public:
  explicit DoubledMatching(const std::vector<std::vector<int>>& edges)
      : edges_(edges), partner_(edges.size(), -1), seen_(edges.size(), -1) {
    for (std::size_t n = 0; n < edges.size(); ++n) size_ += augment(static_cast<int>(n), static_cast<int>(n));
  }
  int size() const { return size_; }

 private:
  bool augment(int n, int round) {
    for (int to : edges_[static_cast<std::size_t>(n)]) {
      if (seen_[static_cast<std::size_t>(to)] == round) continue;
      seen_[static_cast<std::size_t>(to)] = round;
      int& partner = partner_[static_cast<std::size_t>(to)];
      if (partner >= 0 && !augment(partner, round)) continue;
      partner = n;
      return true;
    }
    return false;
  }
  const std::vector<std::vector<int>>& edges_;
  std::vector<int> partner_, seen_;
  int size_ = 0;
};

}  // namespace

void HalfCount::add(const SlotChoice& slots) {
  if (slots.alone) {
    ++alone;
  } else if (!slots.vector) {
    ++scalar;
  } else if (slots.two_slots) {
    ++two_slots;
  } else if (slots.scalar) {
    ++either;
  } else {
    ++vector;
  }
}

void HalfCount::add(const HalfCount& more) {
  alone += more.alone;
  vector += more.vector;
  scalar += more.scalar;
  either += more.either;
  two_slots += more.two_slots;
}

int HalfCount::words(bool open_front) const {
  int least = vector + scalar + either + 2 * two_slots;
  for (int t = 0; t <= two_slots; ++t) {
    const int pairs = two_slots - t;
    const int scalar_slots = scalar + 2 * pairs - (open_front && pairs > 0 ? 1 : 0);
    const int halves = vector + t + scalar_slots + either;
    least = std::min(least, std::max({vector + t, scalar_slots, divide_up(halves, 2)}));
  }
  return alone + least;
}

int window_bound_words(const Graph& graph, const PairRules& rules, const std::vector<bool>* member) {
  // An operation with `head` words before it and `tail` words after it issues in between; so does every other
  // operation with as many.
  const ChainLengths lengths = chain_lengths(graph, member);
  std::vector<std::vector<Need>> by_tail(static_cast<std::size_t>(lengths.longest));
  for (const Need& need : needs_of(graph, rules, lengths, member)) by_tail[static_cast<std::size_t>(need.tail)].push_back(need);
  int bound = lengths.longest;
  for (int head = 0; head < lengths.longest; ++head) {
    WordCount between(head > 0);
    for (int tail = lengths.longest - 1; tail >= 0; --tail) {
      bool more = false;
      for (const Need& need : by_tail[static_cast<std::size_t>(tail)]) {
        if (need.head < head) continue;
        between.add(need);
        more = true;
      }
      if (more) bound = std::max(bound, head + tail + between.words());
    }
  }
  return bound;
}

int pairing_bound_words(const Graph& graph, const PairRules& rules, int bound,
                        const std::vector<bool>* member) {
  const ChainLengths lengths = chain_lengths(graph, member);
  const Reach reach(graph);
  std::vector<int> operations;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    if (belongs(graph, n, member)) operations.push_back(static_cast<int>(n));
  if (operations.size() > kMostPaired) return bound;
  const int count = static_cast<int>(operations.size());
  // Proof: were there a schedule of `length` words, each operation would stand in [depth - 1, length -
  // height]. A word holds one operation or two, so it has at least count - pairs words; its pairs share a
  // word, hence overlap, do not depend on each other, and are allowed by the machine. The most pairs of that
  // kind are at most half a matching of the doubled graph.
  for (int length = bound;; ++length) {
    std::vector<std::vector<int>> edges(operations.size());
    for (std::size_t i = 0; i < operations.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        const int a = operations[i], b = operations[k];
        if (!rules.legal(a, b) && !rules.legal(b, a)) continue;
        const auto first = [&](int n) { return lengths.depth[static_cast<std::size_t>(n)] - 1; };
        const auto last = [&](int n) { return length - lengths.height[static_cast<std::size_t>(n)]; };
        if (std::max(first(a), first(b)) > std::min(last(a), last(b))) continue;
        if (reach.depends(a, b) || reach.depends(b, a)) continue;
        edges[i].push_back(static_cast<int>(k));
        edges[k].push_back(static_cast<int>(i));
      }
    const int pairs = DoubledMatching(edges).size() / 2;
    if (count - pairs <= length) return length;
  }
}

}  // namespace aluminate::cost
