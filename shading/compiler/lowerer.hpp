// The walk from SPIR-V to Ir, shared by the lower_*.cpp files: one file per family of instructions.
//   lower_flow.cpp      structured control flow, joins, loops, unrolling
//   lower_memory.cpp    variables, uniforms, arrays, pointers
//   lower_interface.cpp inputs, outputs, uniform registers, samplers
//   lower_arithmetic.cpp, lower_integer.cpp, lower_glsl_std.cpp, lower_texture.cpp
// Private to this folder.
#pragma once

#include "platform/host/error.hpp"
#include "shading/compiler/builder.hpp"
#include "shading/compiler/limits.hpp"
#include "shading/compiler/lower.hpp"

#include <functional>
#include <set>
#include <unordered_map>
#include <unordered_set>

namespace aluminate::compiler {

using SpvId = std::uint32_t;

/// A place in memory: a variable, how far in, and what lies there.
struct Pointer {
  SpvId variable = 0;
  SpvId type = 0;  // of the pointee
  std::uint32_t storage = 0;
  // Function, Private, Input, Output: scalars.
  std::uint32_t scalar = 0;
  struct Step {
    Ref index;
    std::uint32_t stride = 0;  // scalars, or bytes in a uniform block
    std::uint32_t count = 0;   // elements
  };
  std::vector<Step> steps;
  // Uniform: bytes from the first register of the member.
  std::uint32_t reg = 0, byte = 0;
  std::uint32_t matrix_stride = 16;
  bool row_major = false;
  bool strided = false;  // a column of a row-major matrix
};

/// Where each scalar of an input or output variable lives.
struct InterfaceSlot {
  int reg = -1;  // -1: not representable, an error once it is used
  std::uint8_t lane = 0;
};

class Lowerer {
 public:
  Lowerer(const SpirvModule& module, vm::Stage stage, LoopMode loops,
          std::set<std::string> explicit_registers);
  Lowered run();

 private:
  struct Counted {  // a loop whose trip count is known
    SpvId phi = 0;  // the counting value
    double init = 0, step = 0;
    int trips = 0;
    bool at_head = true;   // tested before the body, else after it
    SpvId stepped = 0;     // the counting value of the next iteration
    SpvId exit_block = 0;  // block whose test leaves the loop when the count is reached
    SpvId stay = 0;        // where that test goes otherwise
  };
  struct Exit {  // a label control may jump to from inside
    SpvId label = 0;
    bool is_continue = false;  // Continue instead of Break
    int depth = 0;             // machine loops open when the label's own loop is innermost
    SpvId header = 0;          // is_continue: the loop whose back edge is taken
  };
  struct Join {  // values that flow into a block over several edges
    std::vector<SpvId> phis;
    std::vector<std::vector<NodeId>> variables;
  };
  using Memory = std::unordered_map<SpvId, Tuple>;

  // interface
  void map_interface();
  void check_interface_size(SpvId variable, SpvId type) const;
  void map_input(SpvId variable);
  void map_output(SpvId variable);
  void map_uniform_block(SpvId variable);
  void map_sampler(SpvId variable);
  void name_uniform(const std::string& name, SpvId type, int reg, std::uint32_t byte,
                    std::uint32_t matrix_stride, bool row_major);
  std::uint32_t bytes_of(SpvId type, std::uint32_t matrix_stride, bool row_major) const;
  std::string semantic_of(SpvId variable, bool input) const;

  // flow
  void spend(std::size_t steps) const;
  bool walk(SpvId pred, SpvId label, SpvId stop, bool inside = false);
  void selection(SpvId from, SpvId merge, SpvId stop, SpvId& next, bool& done, bool& falls);
  void switch_case(SpvId from, SpvId merge);
  void loop(SpvId pred, SpvId header);
  void rolled_loop(SpvId pred, SpvId header, SpvId merge, SpvId cont, const std::optional<Counted>& counted,
                   bool breaks, const std::unordered_set<SpvId>& inside);
  void unrolled_loop(SpvId pred, SpvId header, SpvId merge, SpvId cont, const Counted& counted);
  void iteration(SpvId pred, SpvId header, SpvId cont);
  void final_head(SpvId pred, SpvId header, const Counted& counted);
  SpvId back_edge(SpvId header) const;
  std::optional<Counted> count_trips(SpvId pred, SpvId header, SpvId merge,
                                     const std::unordered_set<SpvId>& inside);
  bool used_outside(const std::set<SpvId>& ids, const std::unordered_set<SpvId>& inside) const;
  std::uint32_t open_machine_loop(int trips, const Counted& counted);
  void close_machine_loop();
  void open_flags(const std::unordered_set<SpvId>& inside, SpvId own, std::vector<SpvId>& opened);
  void pass_on_flags(const std::vector<SpvId>& opened);
  struct OnceLoop {  // a machine loop around a construct that is left by Break
    Lowerer& l;
    std::vector<SpvId> flags;
    OnceLoop(Lowerer& owner, SpvId label, const std::unordered_set<SpvId>& inside);
    void close();
  };
  const Exit* find_exit(SpvId label) const;
  void leave(const Exit& exit, SpvId from, std::optional<Ref> condition);
  void enter_block(SpvId pred, SpvId label);
  void open_join(SpvId label);
  void edge(SpvId from, SpvId to);
  bool edge_is_empty(SpvId from, SpvId to);
  std::vector<std::pair<NodeId, Lanes>> edge_copies(SpvId from, SpvId to);
  void parallel_copy(const std::vector<std::pair<NodeId, Lanes>>& copies);
  std::set<SpvId> exits_from(SpvId label, SpvId merge, SpvId stop) const;
  bool nestable(SpvId label, SpvId stop) const;
  std::vector<SpvId> successors(const SpirvBlock& block) const;
  std::unordered_set<SpvId> region(SpvId first, const std::vector<SpvId>& bounds) const;
  bool is_kill_block(SpvId label, SpvId merge) const;
  void begin_if(Ref condition);
  void begin_else();
  void end_if();
  std::pair<SpvId, SpvId> jump_target(SpvId from, SpvId label, SpvId stop, SpvId merge) const;

  // memory
  Pointer pointer(SpvId id);
  void access_chain(const SpirvInstruction& i);
  void load(const SpirvInstruction& i);
  void store(const SpirvInstruction& i);
  void declare(const SpirvInstruction& variable);
  Tuple load_uniform(const Pointer& p);
  void load_uniform_into(Tuple& out, const Pointer& p, SpvId type, std::uint32_t byte,
                         std::uint32_t matrix_stride, bool row_major, bool strided);
  Ref uniform_scalar(const Pointer& p, std::uint32_t byte);
  Address address_of(const std::vector<Pointer::Step>& steps, std::uint32_t unit, std::uint32_t& shift);
  Tuple load_local(const Pointer& p);
  Tuple load_input(const Pointer& p);
  std::optional<Tuple> load_table(const Pointer& p, const Tuple& from);
  Tuple read_variable(SpvId variable);
  void write_scalars(SpvId variable, std::uint32_t first, const Tuple& value);
  void keep_in_registers(const std::unordered_set<SpvId>& blocks, std::vector<SpvId>& kept);
  void release_registers(const std::vector<SpvId>& kept);
  void write_outputs();

  // instructions
  void instruction(const SpirvInstruction& i);
  bool arithmetic(const SpirvInstruction& i);
  bool integer_arithmetic(const SpirvInstruction& i);
  bool comparison(const SpirvInstruction& i);
  bool composite(const SpirvInstruction& i);
  bool matrix(const SpirvInstruction& i);
  bool texture(const SpirvInstruction& i);
  [[noreturn]] void refuse_image(const SpirvInstruction& i) const;
  void glsl_std(const SpirvInstruction& i);
  bool glsl_geometric(std::uint32_t op, const SpirvInstruction& i);
  bool glsl_transcendental(std::uint32_t op, const SpirvInstruction& i);

  // values
  const Tuple& value(SpvId id);
  Lanes vec(SpvId id);
  Ref scalar(SpvId id) { return value(id).at(0); }
  void define(const SpirvInstruction& i, Tuple v);
  void hold(const SpirvInstruction& i, std::size_t scalars);
  void define(const SpirvInstruction& i, const Lanes& v) { define(i, Tuple(v.begin(), v.end())); }
  std::vector<Lanes> columns(SpvId id);
  Tuple constant(SpvId id, const SpirvInstruction& definition);
  Ref num(double v) { return b_.constant(v); }
  [[noreturn]] void refuse(const SpirvInstruction& i, const std::string& what,
                           const std::string& hint = {}) const;
  SourcePlace place(const vm::SourceLine& line) const;

  // pieces of arithmetic shared by several instructions
  Lanes clamp(const Lanes& x, const Lanes& low, const Lanes& high);
  Lanes mix(const Lanes& a, const Lanes& b, const Lanes& t) { return b_.add(b_.mul(t, b_.sub(b, a)), a); }
  Lanes normalize(const Lanes& v);
  Lanes power(const Lanes& x, const Lanes& y);
  Lanes divide_integers(const Lanes& a, const Lanes& b, bool is_signed);
  Lanes arc_tangent(const Lanes& x);
  Lanes arc_cosine(const Lanes& x);

  const SpirvModule& m_;
  vm::Stage stage_;
  LoopMode loops_;
  std::set<std::string> explicit_registers_;
  Lowered out_;
  Builder b_;

  std::unordered_map<SpvId, Tuple> values_;
  std::unordered_map<SpvId, Pointer> pointers_;
  std::unordered_map<SpvId, SpvId> images_;            // image or sampled image value -> variable
  std::unordered_map<SpvId, std::uint32_t> samplers_;  // variable -> sampler index
  std::unordered_map<SpvId, std::vector<InterfaceSlot>> inputs_, outputs_;
  std::map<std::pair<SpvId, std::uint32_t>, int> member_register_;
  std::map<std::vector<double>, std::uint32_t> tables_;
  Memory memory_;  // current values of private, local and output variables
  std::unordered_map<SpvId, std::vector<NodeId>>
      registers_;                                      // variables kept in registers inside control flow
  std::set<std::pair<SpvId, std::uint32_t>> written_;  // scalars of outputs that were stored

  std::unordered_map<SpvId, Join> joins_;
  std::vector<Exit> exits_;
  std::unordered_map<SpvId, Counted> counted_;  // by exit block
  std::map<SpvId, NodeId> flags_;               // exit label -> "leave further" flag
  std::unordered_set<SpvId> open_loops_;        // headers being walked
  SpvId next_pred_ = 0;                         // block control comes from after a construct
  bool unreachable_ = false;                    // nothing falls out of the switch just walked
  int machine_depth_ = 0;
  std::uint32_t next_loop_id_ = 1;
  int walk_depth_ = 0;
  mutable std::size_t spent_ = 0;  // steps of kMaxLoweringSteps
  std::size_t held_ = 0;           // numbers of kMaxHeldScalars
  std::vector<Counted> counters_;  // by loop id - 1
};

}  // namespace aluminate::compiler
