#include "shading/cost/schedule.hpp"

#include "shading/cost/region_scheduler.hpp"
#include "shading/cost/schedule_bound.hpp"
#include "shading/cost/xenos_packing.hpp"

#include <algorithm>

namespace aluminate::cost {
namespace {

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

/// What issues between two levels of fetches, and the fetches behind it.
struct Region {
  std::vector<bool> member;
  std::vector<Issue> words;
  std::vector<int> fetches;
};

class BlockScheduler {
 public:
  BlockScheduler(const Graph& graph, const PairRules& rules, Effort effort)
      : graph_(graph), rules_(rules), effort_(effort), lengths_(chain_lengths(graph)) {}

  /// enough: no attempt is made below this many words.
  BlockSchedule run(int enough) {
    const FetchLevels levels = find_levels(graph_);
    regions_.resize(static_cast<std::size_t>(levels.count) + 1);
    for (Region& region : regions_) region.member.assign(graph_.nodes.size(), false);
    for (std::size_t n = 0; n < graph_.nodes.size(); ++n) {
      if (graph_.nodes[n].removed) continue;
      Region& region = regions_[static_cast<std::size_t>(levels.of_node[n])];
      if (graph_.nodes[n].is_fetch()) {
        region.fetches.push_back(static_cast<int>(n));
      } else {
        region.member[n] = true;
      }
    }
    for (Region& region : regions_) region.words = order(region.member);
    for (std::size_t k = 0; k + 1 < regions_.size() && total() > enough; ++k) fill_from_behind(k);
    return assemble(levels.count);
  }

 private:
  std::vector<Issue> order(const std::vector<bool>& member) const {
    const RegionScheduler region(graph_, rules_, member);
    return effort_ == Effort::Plain ? region.run()
                                    : region.run_hard(window_bound_words(graph_, rules_, &member));
  }

  int total() const {
    std::size_t words = 0;
    for (const Region& region : regions_) words += region.words.size();
    return static_cast<int>(words);
  }

  /// Halves of region k's words that are free take operations of later regions that wait for nothing but what
  /// is done by then; kept when the regions behind become shorter.
  void fill_from_behind(std::size_t k) {
    std::vector<bool> done(graph_.nodes.size(), false);
    for (std::size_t earlier = 0; earlier < k; ++earlier) {
      for (std::size_t n = 0; n < done.size(); ++n) done[n] = done[n] || regions_[earlier].member[n];
      for (int fetch : regions_[earlier].fetches) done[static_cast<std::size_t>(fetch)] = true;
    }
    std::vector<Region> filled(regions_.begin(), regions_.end());
    bool moved = false;
    for (Issue& word : filled[k].words) {
      const int guest = best_guest(word, k, filled, done);
      if (guest >= 0) {
        (word.vector < 0 ? word.vector : word.scalar) = guest;
        for (Region& region : filled) region.member[static_cast<std::size_t>(guest)] = false;
        filled[k].member[static_cast<std::size_t>(guest)] = true;
        moved = true;
      }
      for (int n : {word.vector, word.scalar})
        if (n >= 0) done[static_cast<std::size_t>(n)] = true;
    }
    if (!moved) return;
    std::size_t before = 0, after = 0;
    for (std::size_t later = k + 1; later < regions_.size(); ++later) {
      before += regions_[later].words.size();
      if (filled[later].member != regions_[later].member) filled[later].words = order(filled[later].member);
      after += filled[later].words.size();
    }
    if (after < before) regions_ = std::move(filled);
  }

  int best_guest(const Issue& word, std::size_t k, const std::vector<Region>& regions,
                 const std::vector<bool>& done) const {
    const bool scalar_free = word.scalar < 0 && word.previous_move < 0;
    if (word.vector >= 0 && !scalar_free) return -1;
    int best = -1;
    for (std::size_t later = k + 1; later < regions.size(); ++later)
      for (std::size_t n = 0; n < done.size(); ++n) {
        const Node& node = graph_.nodes[n];
        // Exports wait for their allocation, behind the last fetch; effects stay where they are.
        if (!regions[later].member[n] || node.dest != DestKind::Value) continue;
        const int guest = static_cast<int>(n);
        const SlotChoice& slots = rules_.slots(guest);
        const bool fits = word.vector >= 0   ? slots.scalar && rules_.legal(word.vector, guest)
                          : word.scalar >= 0 ? slots.vector && rules_.legal(guest, word.scalar)
                                             : slots.vector && rules_.beside_move(guest);
        if (!fits) continue;
        bool ready = true;
        for_each_dependency(node, [&](int from) { ready = ready && done[static_cast<std::size_t>(from)]; });
        if (ready && (best < 0 || lengths_.height[n] > lengths_.height[static_cast<std::size_t>(best)]))
          best = guest;
      }
    return best;
  }

  BlockSchedule assemble(int fetch_levels) const {
    BlockSchedule schedule;
    for (std::size_t level = 0; level < regions_.size(); ++level) {
      const Region& region = regions_[level];
      schedule.words += static_cast<int>(region.words.size());
      schedule.issues.insert(schedule.issues.end(), region.words.begin(), region.words.end());
      append_fetches(region.fetches, schedule);
      if (static_cast<int>(level) + 1 == fetch_levels)
        schedule.export_start = static_cast<int>(schedule.issues.size());
    }
    if (fetch_levels == 0) schedule.export_start = 0;
    const int all = static_cast<int>(schedule.issues.size());
    if (graph_.has_export) {
      schedule.clauses = divide_up(schedule.export_start, kClauseIssues) +
                         divide_up(all - schedule.export_start, kClauseIssues);
    } else {
      schedule.export_start = -1;
      schedule.clauses = divide_up(all, kClauseIssues);
    }
    return schedule;
  }

  /// Set-up words directly precede their fetch.
  void append_fetches(const std::vector<int>& fetches, BlockSchedule& schedule) const {
    std::vector<bool> issued(graph_.nodes.size(), false);
    for (int fetch : fetches) {
      if (graph_.nodes[static_cast<std::size_t>(fetch)].special == Special::FetchSetup) continue;
      std::vector<int> chain;
      for (int n = fetch; n >= 0 && !issued[static_cast<std::size_t>(n)];
           n = graph_.nodes[static_cast<std::size_t>(n)].after)
        chain.push_back(n);
      for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
        Issue issue;
        issue.fetch = *it;
        issued[static_cast<std::size_t>(*it)] = true;
        schedule.issues.push_back(issue);
        ++schedule.fetch_words;
      }
    }
  }

  const Graph& graph_;
  const PairRules& rules_;
  Effort effort_;
  ChainLengths lengths_;
  std::vector<Region> regions_;
};

}  // namespace

BlockSchedule schedule_block(const Graph& graph, PairingRule pairing, Effort effort) {
  const PairRules rules(graph, pairing);
  int bound = effort == Effort::Plain ? 0 : window_bound_words(graph, rules);
  BlockSchedule schedule = BlockScheduler(graph, rules, effort).run(bound);
  if (effort == Effort::Full && schedule.words > bound) bound = pairing_bound_words(graph, rules, bound);
  schedule.bound_words = bound;
  return schedule;
}

}  // namespace aluminate::cost
