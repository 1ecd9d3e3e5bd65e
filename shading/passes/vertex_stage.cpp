#include "shading/passes/vertex_stage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "platform/host/workers.hpp"

namespace aluminate::passes {
namespace {

// Vertices of one task. A multiple of the batch width, the same for any thread count.
constexpr std::size_t kChunk = 4096;
static_assert(kChunk % vm::kLanes == 0);

// One attribute component of vertices [first, first + count), whatever type the mesh stores it in.
using FillRow = void (*)(const scenes::Mesh&, const scenes::NormalisedSpace&, std::size_t first,
                         std::size_t count, int component, double* row);

void fill_position(const scenes::Mesh& mesh, const scenes::NormalisedSpace& space, std::size_t first,
                   std::size_t count, int c, double* row) {
  const double centre = space.centre[c], scale = space.scale;  // NormalisedSpace::point
  for (std::size_t i = 0; i < count; ++i) row[i] = (mesh.positions[first + i][c] - centre) * scale;
}
void fill_normal(const scenes::Mesh& mesh, const scenes::NormalisedSpace&, std::size_t first,
                 std::size_t count, int c, double* row) {
  for (std::size_t i = 0; i < count; ++i) row[i] = mesh.normals[first + i][c];
}
void fill_tangent(const scenes::Mesh& mesh, const scenes::NormalisedSpace&, std::size_t first,
                  std::size_t count, int c, double* row) {
  for (std::size_t i = 0; i < count; ++i) row[i] = mesh.tangents[first + i][c];
}
void fill_uv(const scenes::Mesh& mesh, const scenes::NormalisedSpace&, std::size_t first, std::size_t count,
             int c, double* row) {
  const std::vector<glm::vec2>& set = c < 2 ? mesh.uv0 : mesh.uv1;
  for (std::size_t i = 0; i < count; ++i) row[i] = set.empty() ? 0.0 : double{set[first + i][c % 2]};
}
void fill_color(const scenes::Mesh& mesh, const scenes::NormalisedSpace&, std::size_t first,
                std::size_t count, int c, double* row) {
  for (std::size_t i = 0; i < count; ++i) row[i] = mesh.colors.empty() ? 1.0 : double{mesh.colors[first + i][c]};
}

FillRow attribute(const std::string& semantic) {
  if (semantic == "POSITION0") return fill_position;
  if (semantic == "NORMAL0") return fill_normal;
  if (semantic == "TANGENT0") return fill_tangent;
  if (semantic == "TEXCOORD0") return fill_uv;
  if (semantic == "COLOR0") return fill_color;
  throw UserError(fmt::format("the vertex shader reads {}, which meshes do not carry", semantic),
                  "meshes carry POSITION0, NORMAL0, TANGENT0, TEXCOORD0 and COLOR0");
}

// Row of the executable's outputs that holds a varying.
std::size_t output_row(const VertexProgram& program, const std::string& semantic, int component) {
  const auto outputs = program.executable.outputs();
  for (std::size_t row = 0; row < outputs.size(); ++row)
    if (outputs[row].component == component &&
        program.program.outputs[outputs[row].index].semantic == semantic)
      return row;
  throw UserError(fmt::format("the pixel shader reads {}.{}, which the vertex shader does not write",
                              semantic, "xyzw"[component]));
}

}  // namespace

void shade_vertices(const VertexProgram& program, const scenes::Mesh& mesh,
                    const scenes::NormalisedSpace& space, const std::vector<Varying>& wanted,
                    const VertexTarget& target, vm::Counters& counters) {
  const auto inputs = program.executable.inputs();
  const std::size_t output_count = program.executable.outputs().size();
  std::vector<FillRow> fill;
  for (const vm::RowBinding& input : inputs)
    fill.push_back(attribute(program.program.inputs[input.index].semantic));
  std::size_t clip_row[4];
  for (int c = 0; c < 4; ++c) clip_row[c] = output_row(program, "POSITION0", c);
  std::vector<std::size_t> varying_row;
  for (const Varying& varying : wanted)
    varying_row.push_back(output_row(program, varying.semantic, varying.component));

  const std::size_t count = mesh.positions.size();
  double* const clip[4] = {target.x, target.y, target.z, target.w};
  struct Worker {
    vm::Scratch scratch;
    vm::Counters counters;
    host::AlignedRows inputs, outputs;
  };
  host::PerWorker<Worker> workers([&] {
    return Worker{vm::Scratch(program.executable), vm::Counters(program.executable),
                  host::AlignedRows(inputs.size()), host::AlignedRows(output_count)};
  });
  host::parallel_for_workers(
      static_cast<std::int64_t>((count + kChunk - 1) / kChunk), [&](std::int64_t chunk, int slot) {
        Worker& worker = workers[slot];
        const std::size_t first = static_cast<std::size_t>(chunk) * kChunk,
                          last = std::min(count, first + kChunk);
        for (std::size_t base = first; base < last; base += vm::kLanes) {
          const std::size_t lanes = std::min<std::size_t>(vm::kLanes, last - base);
          for (std::size_t row = 0; row < inputs.size(); ++row)
            fill[row](mesh, space, base, lanes, inputs[row].component, worker.inputs.row(row));
          vm::Batch batch;
          batch.inputs = worker.inputs.data();
          batch.outputs = worker.outputs.data();
          batch.constants = program.constants.data();
          batch.active = batch.covered = lanes == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << lanes) - 1;
          vm::run(program.executable, batch, worker.scratch, worker.counters);
          for (std::size_t c = 0; c < 4; ++c) std::copy_n(worker.outputs.row(clip_row[c]), lanes, clip[c] + base);
          for (std::size_t k = 0; k < varying_row.size(); ++k) {
            const double* const from = worker.outputs.row(varying_row[k]);
            double* const to = target.varyings + base * varying_row.size() + k;
            for (std::size_t lane = 0; lane < lanes; ++lane) to[lane * varying_row.size()] = from[lane];
          }
          // The VM replaces what is not a number at its border; the rasterizer has to see it, to drop the
          // triangle whole.
          for (std::size_t v = base; v < base + lanes; ++v) {
            const glm::dvec3& p = mesh.positions[v];
            if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)))
              target.x[v] = std::numeric_limits<double>::quiet_NaN();
          }
        }
      });
  workers.for_each([&](const Worker& worker) { counters += worker.counters; });
}

}  // namespace aluminate::passes
