// How far the console's schedules of the shipped programs are from what no schedule can beat: every program
// the beach hut and the material wall need under ten settings, each once. Prints the table; holds the total.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <set>

#include "platform/console/platform_file.hpp"
#include "shading/passes/light_plan.hpp"
#include "shading/passes/programs.hpp"
#include "tests/passes/sample_scene.hpp"

namespace aluminate::passes {
namespace {

constexpr const char* kSettings[] = {"lights=rig:1",
                                     "lights=rig:4",
                                     "lights=rig:16",
                                     "visibility=cheap",
                                     "fresnel=sg,tonemap=filmic",
                                     "sky=fc3,ambient=sky",
                                     "pipeline=deferred",
                                     "pipeline=deferred,shadows=on",
                                     "toksvig=texture",
                                     "msaa=4,lights=rig:4"};

struct Totals {
  double words = 0, bound = 0;
  int programs = 0;
  void add(const cost::StaticCost& cost) {
    words += cost.alu_words;
    bound += cost.bound_words;
    ++programs;
  }
  double gap() const { return bound > 0 ? 100 * (words / bound - 1) : 0; }
};

std::string code_of(const vm::Program& program) {
  std::string text;
  for (const vm::Instruction& instruction : program.code)
    text += vm::disassemble(program, instruction) +
            (instruction.trip_count >= 0 ? std::to_string(instruction.trip_count) : "");
  for (const auto& literal : program.literals)
    for (double x : literal) text += fmt::format("{} ", x);
  return text;
}

TEST(ScheduleGap, ShippedProgramsAreWithinFivePerCentOfTheirBound) {
  const console::GpuModel xenos = console::load_platform("xenos");
  std::set<std::string> known;
  Totals all, rolled;
  std::string table = "  words  bound    gap  program\n";
  const auto count = [&](const vm::Program& program) {
    if (!known.insert(code_of(program)).second) return;
    const cost::StaticCost cost = cost::price(program, xenos);
    all.add(cost);
    for (const cost::BlockCost& block : cost.blocks)
      if (block.static_trips > 1) {
        rolled.add(cost);
        break;
      }
    table += fmt::format("{:7} {:6} {:5.1f} %  {}\n", cost.alu_words, cost.bound_words,
                         100 * (cost.alu_words / std::max(1, static_cast<int>(cost.bound_words)) - 1),
                         program.name);
  };
  for (const char* scene : {"beach_hut", "material_wall"})
    for (const char* setting : kSettings) {
      FrameOptions options;
      options.width = 64;
      options.height = 36;
      set_options(options, setting);
      DrawList list = make_draw_list(test::sample_scene(scene), options);
      const LightPlan plan = make_light_plan(list, options);
      for (const PixelProgram& program : list.pixel_programs) count(program.program);
      for (const VertexProgram& program : list.vertex_programs) count(program.program);
      for (const PixelProgram& program : plan.programs) count(program.program);
      if (options.tonemap != Tonemap::None) count(compile_tonemap(options.tonemap));
    }
  table += fmt::format(
      "{} programs: {} words over {}, {:.2f} %; {} with rolled loops: {} over {}, {:.2f} %\n", all.programs,
      all.words, all.bound, all.gap(), rolled.programs, rolled.words, rolled.bound, rolled.gap());
  std::cout << table;
  EXPECT_LE(all.words, 1.05 * all.bound);
}

}  // namespace
}  // namespace aluminate::passes
