#include "shading/vm/value_webs.hpp"

#include <algorithm>
#include <map>
#include <numeric>

namespace aluminate::vm {
namespace {

using Web = ValueWebs::Web;

class Finder {
 public:
  explicit Finder(const Program& program)
      : program_(program), parent_(static_cast<std::size_t>(program.temp_count) * 4), now_(parent_.size()) {
    std::iota(parent_.begin(), parent_.end(), Web{0});
    now_ = parent_;
  }

  ValueWebs find() {
    const auto& code = program_.code;
    webs_.written.resize(code.size());
    webs_.read.resize(code.size());
    for (std::size_t i = 0; i < code.size(); ++i) {
      read(i);
      follow(i);
      write(i);
    }
    name_webs();
    return std::move(webs_);
  }

 private:
  struct Region {
    bool loop = false;
    std::vector<std::pair<std::size_t, Web>> hidden;   // component and its web before each write of this branch
    std::map<std::size_t, Web> first_branch;           // components the branch before Else wrote, as it left them
    std::vector<std::pair<std::size_t, Web>> carried;  // loop: components its body writes, with the web they enter by
  };

  Web root(Web w) {
    while (parent_[w] != w) w = parent_[w] = parent_[parent_[w]];
    return w;
  }
  void join(Web a, Web b) { parent_[root(a)] = root(b); }

  static std::size_t slot(int reg, std::size_t component) { return static_cast<std::size_t>(reg) * 4 + component; }

  void read(std::size_t index) {
    const Instruction& i = program_.code[index];
    for (std::size_t s = 0; s < static_cast<std::size_t>(info(i.op).sources); ++s)
      if (i.src[s].file == RegisterFile::Temp)
        for (std::size_t c = 0; c < 4; ++c) webs_.read[index][s][c] = now_[slot(i.src[s].index, c)];
  }

  void write(std::size_t index) {
    const Destination& d = program_.code[index].dst;
    if (d.mask == 0 || d.file != RegisterFile::Temp) return;
    for (std::size_t c = 0; c < 4; ++c) {
      if ((d.mask >> c & 1) == 0) continue;
      const auto web = static_cast<Web>(parent_.size());
      parent_.push_back(web);
      webs_.written[index][c] = web;
      set(slot(d.index, c), web);
    }
  }
  void set(std::size_t component, Web web) {
    if (!open_.empty()) open_.back().hidden.emplace_back(component, now_[component]);
    now_[component] = web;
  }

  void follow(std::size_t index) {
    switch (program_.code[index].op) {
      case Opcode::If: open_.emplace_back(); break;
      case Opcode::Else: start_second_branch(); break;
      case Opcode::EndIf: join_branches(); break;
      case Opcode::Loop: start_loop(index); break;
      case Opcode::Break:
      case Opcode::Continue: carry(); break;
      case Opcode::EndLoop:
        carry();
        end_loop();
        break;
      default: break;
    }
  }

  void restore(const Region& region) {
    for (auto h = region.hidden.rbegin(); h != region.hidden.rend(); ++h) now_[h->first] = h->second;
  }

  void start_second_branch() {
    Region& region = open_.back();
    for (const auto& [component, before] : region.hidden) region.first_branch[component] = now_[component];
    restore(region);
    region.hidden.clear();
  }

  void join_branches() {
    Region region = std::move(open_.back());
    open_.pop_back();
    auto& other = region.first_branch;
    std::map<std::size_t, Web> merged;
    for (const auto& [component, before] : region.hidden) merged.emplace(component, now_[component]);
    restore(region);
    // now_ holds the values before the If again: what a branch that did not write leaves.
    for (auto& [component, web] : merged) {
      const auto o = other.find(component);
      join(web, o == other.end() ? now_[component] : o->second);
    }
    for (const auto& [component, web] : other)
      if (merged.emplace(component, web).second) join(web, now_[component]);
    for (const auto& [component, web] : merged) set(component, web);
  }

  void start_loop(std::size_t begin) {
    Region region;
    region.loop = true;
    std::vector<std::size_t> components;
    int depth = 0;
    for (std::size_t i = begin + 1;; ++i) {
      const Instruction& body = program_.code[i];
      depth += body.op == Opcode::Loop ? 1 : 0;
      if (body.op == Opcode::EndLoop && depth-- == 0) break;
      if (body.dst.mask == 0 || body.dst.file != RegisterFile::Temp) continue;
      for (std::size_t c = 0; c < 4; ++c)
        if ((body.dst.mask >> c & 1) != 0) components.push_back(slot(body.dst.index, c));
    }
    std::sort(components.begin(), components.end());
    components.erase(std::unique(components.begin(), components.end()), components.end());
    for (std::size_t component : components) region.carried.emplace_back(component, now_[component]);
    open_.push_back(std::move(region));
  }

  // Lanes go from here to the next iteration or out of the innermost loop.
  void carry() {
    const auto loop = std::find_if(open_.rbegin(), open_.rend(), [](const Region& r) { return r.loop; });
    for (const auto& [component, web] : loop->carried) join(now_[component], web);
  }

  void end_loop() {
    const Region region = std::move(open_.back());
    open_.pop_back();
    for (const auto& [component, web] : region.carried) {
      now_[component] = web;
      if (!open_.empty()) open_.back().hidden.emplace_back(component, web);
    }
  }

  void name_webs() {
    if (parent_.empty()) return;
    std::vector<Web> name(parent_.size(), 0);
    for (Web w = 0; w < parent_.size(); ++w)
      if (root(w) == w) name[w] = webs_.count++;
    for (std::size_t i = 0; i < program_.code.size(); ++i) {
      for (Web& w : webs_.written[i]) w = name[root(w)];
      for (auto& source : webs_.read[i])
        for (Web& w : source) w = name[root(w)];
    }
  }

  const Program& program_;
  ValueWebs webs_;
  std::vector<Web> parent_;  // union-find; the first temp_count * 4 are the components before any write
  std::vector<Web> now_;     // per component
  std::vector<Region> open_;
};

}  // namespace

ValueWebs find_value_webs(const Program& program) { return Finder(program).find(); }

}  // namespace aluminate::vm
