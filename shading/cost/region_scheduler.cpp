#include "shading/cost/region_scheduler.hpp"

#include "platform/host/error.hpp"
#include "shading/cost/xenos_packing.hpp"

#include <algorithm>
#include <limits>

namespace aluminate::cost {
namespace {

constexpr int kPlaced = -1;  // in State::waiting

int shaken(std::uint32_t shake, int node) {
  if (shake == 0) return 0;
  std::uint32_t hash = (shake * 0x9E3779B9u) ^ (static_cast<std::uint32_t>(node) * 0x85EBCA6Bu);
  hash ^= hash >> 15;
  hash *= 0x2C1B3C6Du;
  hash ^= hash >> 13;
  return static_cast<int>(hash % 3);
}

}  // namespace

RegionScheduler::RegionScheduler(const Graph& graph, const PairRules& rules, std::vector<bool> member)
    : graph_(graph), rules_(rules), member_(std::move(member)), before_(graph.nodes.size()) {
  start_.waiting.assign(graph.nodes.size(), 0);
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (!member_[n]) continue;
    ++start_.left;
    members_.push_back(static_cast<int>(n));
    for_each_dependency(graph.nodes[n], [&](int from) {
      if (member_[static_cast<std::size_t>(from)]) ++start_.waiting[static_cast<std::size_t>(from)];
    });
  }
  for (const auto& [reader, writer] : graph.write_after_read) {
    if (!member_[static_cast<std::size_t>(reader)] || !member_[static_cast<std::size_t>(writer)]) continue;
    before_[static_cast<std::size_t>(writer)].push_back(reader);
    ++start_.waiting[static_cast<std::size_t>(reader)];
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    if (member_[n] && start_.waiting[n] == 0) start_.ready.push_back(static_cast<int>(n));
  const ChainLengths lengths = chain_lengths(graph, &member_);
  depth_ = lengths.depth;
  longest_ = lengths.longest;
}

std::vector<int> RegionScheduler::ranks(std::uint32_t shake) const {
  std::vector<int> ranks = depth_;
  for (int n : members_) ranks[static_cast<std::size_t>(n)] += shaken(shake, n);
  return ranks;
}

RegionScheduler::Score RegionScheduler::score(Order order, const std::vector<int>& ranks, int vector,
                                              int scalar, bool two_slots) const {
  const int count = (vector >= 0) + (scalar >= 0);
  const int vector_only = vector >= 0 && !rules_.slots(vector).scalar ? 1 : 0;
  const int a = vector < 0 ? 0 : ranks[static_cast<std::size_t>(vector)],
            b = scalar < 0 ? 0 : ranks[static_cast<std::size_t>(scalar)];
  const int longest = std::max(a, b), both = a + b, late = vector + scalar;
  const int filled = 2 * count - (two_slots ? 1 : 0);
  switch (order) {
    case Order::Chain:
      return {longest, filled, both + vector_only, late};
    case Order::Pairs:
      return {filled, longest, both + vector_only, late};
    case Order::Late:
      return {std::max(vector, scalar), filled, vector_only, longest};
  }
  return {};
}

/// Calls offer(vector, scalar, two_slots) for every word that could stand before those placed.
template <class Offer>
void RegionScheduler::offer_words(const State& state, Offer&& offer) const {
  for (int v : state.ready) {
    if (!rules_.slots(v).vector) continue;
    if (state.carried >= 0 && !rules_.beside_move(v)) continue;
    offer(v, -1, false);
    if (state.carried >= 0) continue;
    for (int s : state.ready)
      if (rules_.legal(v, s)) offer(v, s, !rules_.slots(s).scalar);
  }
  if (state.carried >= 0) {
    offer(-1, -1, false);
    return;
  }
  for (int s : state.ready)
    if (rules_.slots(s).scalar) offer(-1, s, false);
}

void RegionScheduler::unblock(State& state, int from) const {
  if (!member_[static_cast<std::size_t>(from)]) return;
  if (--state.waiting[static_cast<std::size_t>(from)] == 0)
    state.ready.insert(std::lower_bound(state.ready.begin(), state.ready.end(), from), from);
}

void RegionScheduler::unblock_operand(State& state, const Operand& operand) const {
  for (int i = 0; i < operand.count; ++i) {
    const Ref& ref = operand.refs[static_cast<std::size_t>(i)];
    if (ref.kind == Ref::Kind::Node) unblock(state, static_cast<int>(ref.index));
    if (ref.address_node >= 0) unblock(state, ref.address_node);
  }
}

/// The nodes of a word leave; what they read may come into earlier words. A carried operand is read one word
/// earlier.
void RegionScheduler::place(State& state, const Candidate& candidate) const {
  Issue word;
  word.vector = candidate.vector;
  word.scalar = candidate.scalar;
  word.uses_previous = candidate.two_slots;
  word.previous_move = state.carried;
  state.words.push_back(word);
  const int finished_move = state.carried;
  state.carried = word.uses_previous ? word.scalar : -1;
  for (int n : {word.vector, word.scalar}) {
    if (n < 0) continue;
    const Node& node = graph_.nodes[static_cast<std::size_t>(n)];
    --state.left;
    std::erase(state.ready, n);
    state.waiting[static_cast<std::size_t>(n)] = kPlaced;
    for (int reader : before_[static_cast<std::size_t>(n)]) unblock(state, reader);
    const int skipped = n == state.carried ? carried_operand(graph_, node) : -1;
    for (int s = 0; s < node.sources; ++s)
      if (s != skipped) unblock_operand(state, node.src[static_cast<std::size_t>(s)]);
    if (node.after >= 0) unblock(state, node.after);
  }
  if (finished_move >= 0) {
    const Node& node = graph_.nodes[static_cast<std::size_t>(finished_move)];
    unblock_operand(state, node.src[static_cast<std::size_t>(carried_operand(graph_, node))]);
  }
}

RegionScheduler::State RegionScheduler::greedy(const Priority& priority, int give_up) const {
  State state = start_;
  const std::vector<int> ranked = ranks(priority.shake);
  while (!done(state) && static_cast<int>(state.words.size()) < give_up) {
    std::optional<Candidate> best;
    offer_words(state, [&](int vector, int scalar, bool two_slots) {
      const Score offered = score(priority.order, ranked, vector, scalar, two_slots);
      if (!best || offered > best->score) best = Candidate{offered, vector, scalar, two_slots};
    });
    ALU_CHECK(best.has_value(), "nothing can issue: dependencies form a cycle");
    place(state, *best);
  }
  return state;
}

RegionScheduler::State RegionScheduler::plain() const {
  State best = greedy({}, std::numeric_limits<int>::max());
  for (Order order : {Order::Pairs, Order::Late}) {
    State state = greedy({order, 0}, static_cast<int>(best.words.size()));
    if (done(state) && state.words.size() < best.words.size()) best = std::move(state);
  }
  return best;
}

std::vector<Issue> RegionScheduler::in_order(State state) {
  std::reverse(state.words.begin(), state.words.end());
  return std::move(state.words);
}

std::vector<Issue> RegionScheduler::run() const { return in_order(plain()); }

std::vector<Issue> RegionScheduler::run_hard(int enough) const {
  constexpr std::uint32_t kShakes = 8;
  constexpr int kMostDetours = 3, kBudget = 800;
  State best = plain();
  const auto words = [&] { return static_cast<int>(best.words.size()); };
  for (std::uint32_t shake = 1; shake <= kShakes && words() > enough; ++shake) {
    State state = greedy({shake % 2 == 0 ? Order::Pairs : Order::Chain, shake}, words());
    if (done(state) && static_cast<int>(state.words.size()) < words()) best = std::move(state);
  }
  Search search{kBudget};
  for (int detours = 0; detours <= kMostDetours && words() > enough && search.budget > 0;) {
    State state = start_;
    if (descend(state, words() - 1, detours, search)) {
      best = std::move(state);
    } else {
      ++detours;
    }
  }
  return in_order(std::move(best));
}

bool RegionScheduler::can_fit(const State& state, int words, Search& search) const {
  // Operations whose chain is longer than d all issue behind the first d words.
  search.by_depth.assign(static_cast<std::size_t>(longest_) + 1, {});
  int deepest = 0;
  for (int n : members_) {
    const auto at = static_cast<std::size_t>(n);
    if (state.waiting[at] == kPlaced) continue;
    search.by_depth[static_cast<std::size_t>(depth_[at])].add(rules_.slots(n));
    deepest = std::max(deepest, depth_[at]);
  }
  HalfCount longer;
  for (int d = deepest - 1; d >= 0; --d) {
    longer.add(search.by_depth[static_cast<std::size_t>(d) + 1]);
    if (d + longer.words(d > 0) > words) return false;
  }
  return true;
}

bool RegionScheduler::descend(State& state, int words, int detours, Search& search) const {
  if (done(state)) return true;
  if (--search.budget < 0 || words == 0 || !can_fit(state, words, search)) return false;
  std::vector<Candidate> best;  // the first few, best first
  const auto most = static_cast<std::size_t>(std::min(detours, 3) + 1);
  offer_words(state, [&](int vector, int scalar, bool two_slots) {
    const Candidate offered{score(Order::Chain, depth_, vector, scalar, two_slots), vector, scalar,
                            two_slots};
    const auto at =
        std::find_if(best.begin(), best.end(), [&](const Candidate& c) { return offered.score > c.score; });
    if (at == best.end() && best.size() == most) return;
    best.insert(at, offered);
    if (best.size() > most) best.pop_back();
  });
  for (std::size_t i = 0; i < best.size(); ++i) {
    const bool last = i + 1 == best.size();
    State next = last ? std::move(state) : state;
    place(next, best[i]);
    const bool found = descend(next, words - 1, detours - (i > 0 ? 1 : 0), search);
    if (found || last) state = std::move(next);
    if (found) return true;
  }
  return false;
}

}  // namespace aluminate::cost
