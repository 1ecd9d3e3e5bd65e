// The words between two levels of fetches, ordered from the last to the first: list scheduling under several
// priorities, and a bounded search for one word less. Comes in: the graph, its pair rules, which operations
// belong to the region. Goes out: their words. Deterministic.
#pragma once

#include "shading/cost/schedule.hpp"
#include "shading/cost/schedule_bound.hpp"
#include "shading/cost/slot_choice.hpp"

#include <optional>
#include <vector>

namespace aluminate::cost {

class RegionScheduler {
 public:
  /// member: parallel to graph.nodes; fetches and removed nodes are not members.
  RegionScheduler(const Graph& graph, const PairRules& rules, std::vector<bool> member);

  /// The shortest of the plain greedy orders, first to last.
  std::vector<Issue> run() const;
  /// The same, or what shaken orders and the search find below it. `enough`: no attempt is made to be shorter
  /// than this.
  std::vector<Issue> run_hard(int enough) const;

 private:
  enum class Order : std::uint8_t { Chain, Pairs, Late };
  /// How ready operations are ranked. shake 0 is the plain rule; others add 0 to 2 words to each operation's
  /// chain by a fixed hash, so that a schedule above its bound gets other chances without any chance at all.
  struct Priority {
    Order order = Order::Chain;
    std::uint32_t shake = 0;
  };
  struct Score {
    int first = 0, second = 0, third = 0, fourth = 0;
    auto operator<=>(const Score&) const = default;
  };
  struct Candidate {
    Score score;
    int vector = -1, scalar = -1;
    bool two_slots = false;
  };
  /// Words placed so far, from the last.
  struct State {
    std::vector<int> waiting;  // readers and later writers not placed yet; -1: placed itself
    std::vector<int> ready;    // ascending
    int left = 0;
    int carried = -1;
    std::vector<Issue> words;
  };

  /// Chain of each node, shaken.
  std::vector<int> ranks(std::uint32_t shake) const;
  Score score(Order order, const std::vector<int>& ranks, int vector, int scalar, bool two_slots) const;
  template <class Offer>
  void offer_words(const State& state, Offer&& offer) const;
  void place(State& state, const Candidate& word) const;
  void unblock(State& state, int from) const;
  void unblock_operand(State& state, const Operand& operand) const;
  State greedy(const Priority& priority, int give_up) const;
  State plain() const;
  bool done(const State& state) const { return state.left == 0 && state.carried < 0; }
  static std::vector<Issue> in_order(State state);

  struct Search {
    int budget;                         // words it may still place
    std::vector<HalfCount> by_depth{};  // scratch of can_fit
  };
  /// The rest of `state` can still fit into `words`.
  bool can_fit(const State& state, int words, Search& search) const;
  bool descend(State& state, int words, int detours, Search& search) const;

  const Graph& graph_;
  const PairRules& rules_;
  std::vector<bool> member_;
  std::vector<int> members_;
  std::vector<int> depth_;                // chain of members that ends here
  std::vector<std::vector<int>> before_;  // writer: readers that issue in the same word or earlier
  int longest_ = 0;
  State start_;
};

}  // namespace aluminate::cost
