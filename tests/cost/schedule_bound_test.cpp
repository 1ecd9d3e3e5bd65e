// The bound against the truth: for programs small enough, every order of words is tried.
#include "shading/cost/schedule_bound.hpp"
#include "shading/cost/xenos_program.hpp"
#include "tests/cost/program_builder.hpp"
#include "tests/cost/random_program.hpp"

#include <gtest/gtest.h>

#include <map>

namespace aluminate::test {
namespace {

/// Shortest word count of a graph by exhaustion, from the first word to the last; fetches issue as soon as
/// they can and take no word. A state is what has issued and which movs is in flight.
class Exhaustive {
 public:
  Exhaustive(const cost::Graph& graph, const cost::PairRules& rules) : graph_(graph), rules_(rules) {
    for (std::size_t n = 0; n < graph.nodes.size(); ++n)
      if (!graph.nodes[n].removed) all_ |= std::uint64_t{1} << n;
  }
  int words() { return least(0, -1); }

 private:
  static bool has(std::uint64_t set, int n) { return (set >> n & 1) != 0; }

  bool ready(std::uint64_t done, int n, int skipped_source) const {
    const cost::Node& node = graph_.nodes[static_cast<std::size_t>(n)];
    bool ready = !has(done, n) && has(all_, n);
    for (int s = 0; s < node.sources && ready; ++s) {
      if (s == skipped_source) continue;
      const cost::Operand& operand = node.src[static_cast<std::size_t>(s)];
      for (int i = 0; i < operand.count; ++i) {
        const cost::Ref& ref = operand.refs[static_cast<std::size_t>(i)];
        if (ref.kind == cost::Ref::Kind::Node) ready = ready && has(done, static_cast<int>(ref.index));
        if (ref.address_node >= 0) ready = ready && has(done, ref.address_node);
      }
    }
    return ready && (node.after < 0 || has(done, node.after));
  }
  bool overwrites(std::uint64_t done, int n) const {  // something n overwrites is still to be read
    for (const auto& [reader, writer] : graph_.write_after_read)
      if (writer == n && !has(done, reader)) return true;
    return false;
  }

  int least(std::uint64_t done, int carried) {
    for (bool fetched = true; fetched;) {
      fetched = false;
      for (std::size_t n = 0; n < graph_.nodes.size(); ++n)
        if (graph_.nodes[n].is_fetch() && ready(done, static_cast<int>(n), -1)) {
          done |= std::uint64_t{1} << n;
          fetched = true;
        }
    }
    if (done == all_) return 0;
    const auto key = std::make_pair(done, carried);
    if (const auto known = known_.find(key); known != known_.end()) return known->second;
    int best = 1000;
    const int count = static_cast<int>(graph_.nodes.size());
    const auto finish = [&](std::uint64_t word, int next_carried) {
      for (int n = 0; n < count; ++n)
        if (has(word, n) && overwrites(done | word, n)) return;
      best = std::min(best, 1 + least(done | word, next_carried));
    };
    for (int v = -1; v < count; ++v) {
      if (v >= 0 && (!rules_.slots(v).vector || !ready(done, v, -1))) continue;
      const std::uint64_t with_vector = v < 0 ? 0 : std::uint64_t{1} << v;
      for (int s = -1; s < count; ++s) {
        if (s == v && s >= 0) continue;
        const bool previous = carried >= 0;
        if (previous && s != carried) continue;
        if (s < 0) {
          if (v >= 0) finish(with_vector, -1);
          // A movs alone or beside the vector operation, for each operation that takes two slots.
          for (int p = 0; p < count; ++p)
            if (rules_.slots(p).two_slots && !has(done, p) && p != v && (v < 0 || rules_.beside_move(v)) &&
                carried_ready(done, p))
              finish(with_vector, p);
          continue;
        }
        const cost::Node& node = graph_.nodes[static_cast<std::size_t>(s)];
        if (!ready(done, s, previous ? cost::carried_operand(graph_, node) : -1)) continue;
        if (!previous && !rules_.slots(s).scalar) continue;
        if (v >= 0 && !rules_.legal(v, s)) continue;
        finish(with_vector | std::uint64_t{1} << s, -1);
      }
    }
    known_[key] = best;
    return best;
  }
  bool carried_ready(std::uint64_t done, int p) const {
    const cost::Node& node = graph_.nodes[static_cast<std::size_t>(p)];
    const cost::Ref& ref = node.src[static_cast<std::size_t>(cost::carried_operand(graph_, node))].refs[0];
    return ref.kind != cost::Ref::Kind::Node || has(done, static_cast<int>(ref.index));
  }

  const cost::Graph& graph_;
  const cost::PairRules& rules_;
  std::uint64_t all_ = 0;
  std::map<std::pair<std::uint64_t, int>, int> known_;
};

TEST(ScheduleBound, IsNeverAboveTheShortestSchedule) {
  int compared = 0, tight = 0, optimal = 0;
  for (std::uint32_t seed = 0; seed < 1500; ++seed) {
    RandomShape shape;
    shape.instructions = 3 + static_cast<int>(seed % 9);
    shape.flow = seed % 3 == 0;
    shape.fetches = seed % 4 == 1;
    const vm::Program program = random_program(seed, shape);
    for (const cost::ScheduledBlock& block :
         cost::schedule_program(program, cost::PairingRule::Strict).scheduled) {
      std::size_t operations = 0;
      for (const cost::Node& node : block.graph.nodes) operations += node.removed ? 0 : 1;
      if (operations < 2 || operations > 12 || block.graph.nodes.size() > 64) continue;
      const cost::PairRules rules(block.graph, cost::PairingRule::Strict);
      const int shortest = Exhaustive(block.graph, rules).words();
      const int window = cost::window_bound_words(block.graph, rules);
      const int pairing = cost::pairing_bound_words(block.graph, rules, window);
      ASSERT_LE(window, shortest) << "seed " << seed;
      ASSERT_LE(pairing, shortest) << "seed " << seed;
      ASSERT_LE(shortest, block.schedule.words) << "seed " << seed;
      ++compared;
      tight += pairing == shortest;
      optimal += block.schedule.words == shortest;
    }
  }
  std::cout << compared << " blocks: the bound is the shortest schedule in " << tight
            << ", the scheduler finds it in " << optimal << "\n";
  EXPECT_GT(compared, 300);
  EXPECT_GE(optimal, compared * 95 / 100);
}

}  // namespace
}  // namespace aluminate::test
