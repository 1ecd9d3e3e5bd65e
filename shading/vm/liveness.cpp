#include "shading/vm/liveness.hpp"

#include <algorithm>

#include "shading/vm/operands.hpp"

namespace aluminate::vm {
namespace {

// Where control may go after instruction i, as instruction indices; size() = end of the program.
std::vector<std::vector<std::size_t>> find_successors(const Program& program) {
  const auto& code = program.code;
  std::vector<std::vector<std::size_t>> next(code.size());
  struct Open {
    std::size_t begin, otherwise;  // If or Loop instruction; its Else, or size()
    std::vector<std::size_t> leave, again;
  };
  std::vector<Open> open;
  const auto innermost_loop = [&]() -> Open& {
    return *std::find_if(open.rbegin(), open.rend(), [&](const Open& o) { return code[o.begin].op == Opcode::Loop; });
  };
  for (std::size_t i = 0; i < code.size(); ++i) {
    switch (code[i].op) {
      case Opcode::If:
        open.push_back({i, code.size(), {}, {}});
        next[i].push_back(i + 1);
        break;
      case Opcode::Else: open.back().otherwise = i; break;
      case Opcode::EndIf: {
        const Open o = open.back();
        open.pop_back();
        const bool has_else = o.otherwise != code.size();
        next[o.begin].push_back(has_else ? o.otherwise + 1 : i + 1);
        if (has_else) next[o.otherwise].push_back(i + 1);
        next[i].push_back(i + 1);
        break;
      }
      case Opcode::Loop:
        open.push_back({i, code.size(), {}, {}});
        next[i].push_back(i + 1);
        break;
      case Opcode::EndLoop: {
        const Open o = open.back();
        open.pop_back();
        next[i] = {o.begin + 1, i + 1};
        if (code[o.begin].trip_count == 0) next[o.begin].push_back(i + 1);
        for (std::size_t b : o.leave) next[b].push_back(i + 1);
        for (std::size_t c : o.again) next[c].push_back(i);
        break;
      }
      case Opcode::Break:
        innermost_loop().leave.push_back(i);
        next[i].push_back(i + 1);
        break;
      case Opcode::Continue:
        innermost_loop().again.push_back(i);
        next[i].push_back(i + 1);
        break;
      default: next[i].push_back(i + 1); break;
    }
  }
  return next;
}

// Under an If, or in a loop that lanes may leave on their own, or anywhere such a loop is nested in.
std::vector<bool> find_masked(const Program& program) {
  const auto& code = program.code;
  std::vector<bool> diverges(code.size(), false);  // Loop instructions that contain their own Break or Continue, or are open
  std::vector<std::size_t> loops;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (code[i].op == Opcode::Loop) {
      loops.push_back(i);
      diverges[i] = code[i].trip_count < 0;
    }
    if (code[i].op == Opcode::EndLoop) loops.pop_back();
    if (code[i].op == Opcode::Break || code[i].op == Opcode::Continue) diverges[loops.back()] = true;
  }
  std::vector<bool> masked(code.size(), false);
  std::vector<bool> regions;  // one per open If or Loop: does it diverge
  for (std::size_t i = 0; i < code.size(); ++i) {
    const Opcode op = code[i].op;
    if (op == Opcode::EndIf || op == Opcode::EndLoop) regions.pop_back();
    masked[i] = std::find(regions.begin(), regions.end(), true) != regions.end();
    if (op == Opcode::If) regions.push_back(true);
    if (op == Opcode::Loop) regions.push_back(diverges[i]);
  }
  return masked;
}

class Solver {
 public:
  explicit Solver(const Program& program)
      : program_(program),
        next_(find_successors(program)),
        temp_bits_(static_cast<std::size_t>(program.temp_count) * 4),
        live_(program.code.size() + 1, std::vector<bool>(temp_bits_ + program.outputs.size() * 4, false)) {
    result_.masked = find_masked(program);
    result_.live_mask.assign(program.code.size(), 0);
    result_.temps.resize(static_cast<std::size_t>(program.temp_count));
    result_.outputs.resize(program.outputs.size());
    result_.zero_temps.assign(result_.temps.size(), 0);
    result_.zero_outputs.assign(result_.outputs.size(), 0);
    result_.quad_temps.assign(result_.temps.size(), 0);
  }

  Liveness solve() {
    find_quad_temps();
    auto& at_end = live_.back();
    for (const Instruction& i : program_.code)
      if (i.dst.mask != 0 && i.dst.file == RegisterFile::Output)
        for (std::size_t c = 0; c < 4; ++c)
          if ((i.dst.mask >> c & 1) != 0) at_end[temp_bits_ + i.dst.index * 4u + c] = true;
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t i = program_.code.size(); i-- > 0;) changed |= update(i);
    }
    collect();
    return std::move(result_);
  }

 private:
  std::size_t bit(RegisterFile file, std::size_t index, std::size_t component) const {
    return (file == RegisterFile::Output ? temp_bits_ : 0) + index * 4 + component;
  }

  void find_quad_temps() {
    for (std::size_t i = 0; i < program_.code.size(); ++i) {
      const Instruction& in = program_.code[i];
      if (!reads_quad(in.op) || !result_.masked[i] || in.src[0].file != RegisterFile::Temp) continue;
      for (std::size_t p = 0; p < 4; ++p)
        if ((positions_read(program_, in, 0, in.dst.mask) >> p & 1) != 0)
          result_.quad_temps[in.src[0].index] |= static_cast<std::uint8_t>(1u << in.src[0].swizzle[p]);
    }
  }

  // Recomputes what is live before instruction i; true when it changed.
  bool update(std::size_t i) {
    const Instruction& in = program_.code[i];
    std::vector<bool> live(live_[i].size(), false);
    for (std::size_t n : next_[i])
      for (std::size_t b = 0; b < live.size(); ++b)
        if (live_[n][b]) live[b] = true;
    std::uint8_t used = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      if ((in.dst.mask >> c & 1) == 0) continue;
      const std::size_t b = bit(in.dst.file, in.dst.index, c);
      const bool shared_with_quad = in.dst.file == RegisterFile::Temp && (result_.quad_temps[in.dst.index] >> c & 1) != 0;
      if (live[b] || shared_with_quad) used |= static_cast<std::uint8_t>(1u << c);
      live[b] = false;
    }
    result_.live_mask[i] = used;
    for (int s = 0; s < info(in.op).sources; ++s) {
      const Source& source = in.src[static_cast<std::size_t>(s)];
      const std::uint8_t positions = positions_read(program_, in, s, used);
      for (std::size_t p = 0; p < 4; ++p)
        if ((positions >> p & 1) != 0 && source.file == RegisterFile::Temp)
          live[bit(RegisterFile::Temp, source.index, source.swizzle[p])] = true;
      if (positions != 0 && source.relative.base == RelativeBase::Temp)
        live[bit(RegisterFile::Temp, source.relative.index, source.relative.component)] = true;
    }
    if (live == live_[i]) return false;
    live_[i] = std::move(live);
    return true;
  }

  LiveRange& range(std::size_t b) {
    return b < temp_bits_ ? result_.temps[b / 4][b % 4]
                          : result_.outputs[(b - temp_bits_) / 4][(b - temp_bits_) % 4];
  }

  void collect() {
    const auto size = static_cast<std::int32_t>(program_.code.size());
    const auto touch = [&](std::size_t b, std::int32_t at) {
      range(b).first = std::min(range(b).first, at);
      range(b).last = std::max(range(b).last, at);
    };
    for (std::int32_t i = 0; i <= size; ++i) {
      const auto& live = live_[static_cast<std::size_t>(i)];
      for (std::size_t b = 0; b < live.size(); ++b)
        if (live[b]) touch(b, i);
      if (i == size) break;
      const Instruction& in = program_.code[static_cast<std::size_t>(i)];
      for (std::size_t c = 0; c < 4; ++c)
        if ((result_.live_mask[static_cast<std::size_t>(i)] >> c & 1) != 0) touch(bit(in.dst.file, in.dst.index, c), i);
    }
    for (std::size_t t = 0; t < result_.temps.size(); ++t)
      for (std::size_t c = 0; c < 4; ++c) {
        const bool quad = (result_.quad_temps[t] >> c & 1) != 0;
        if (quad) result_.temps[t][c] = {0, size};
        if (quad || live_[0][t * 4 + c]) result_.zero_temps[t] |= static_cast<std::uint8_t>(1u << c);
      }
    for (std::size_t o = 0; o < result_.outputs.size(); ++o)
      for (std::size_t c = 0; c < 4; ++c)
        if (live_[0][temp_bits_ + o * 4 + c]) result_.zero_outputs[o] |= static_cast<std::uint8_t>(1u << c);
  }

  const Program& program_;
  std::vector<std::vector<std::size_t>> next_;
  std::size_t temp_bits_;
  std::vector<std::vector<bool>> live_;  // before each instruction, and at the end
  Liveness result_;
};

}  // namespace

Liveness find_liveness(const Program& program) { return Solver(program).solve(); }

}  // namespace aluminate::vm
