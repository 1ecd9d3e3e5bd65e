#include "rasterizer/frame.hpp"

#include <algorithm>

#include "platform/host/error.hpp"
#include "platform/host/parallel.hpp"
#include "rasterizer/chunk_setup.hpp"

namespace aluminate::raster {

ParallelFor host_threads() {
  return {host::thread_count(), [](std::int64_t count, const ParallelFor::Item& item) {
            host::parallel_for_workers(count, [&item](std::int64_t index, int worker) { item(index, worker); });
          }};
}

ParallelFor serial() {
  return {1, [](std::int64_t count, const ParallelFor::Item& item) {
            for (std::int64_t i = 0; i < count; ++i) item(i, 0);
          }};
}

struct Frame::Storage {
  std::unique_ptr<ScreenVertex[]> vertices;
  std::size_t vertex_capacity = 0;
  std::vector<Chunk> chunks;
  std::size_t chunk_count = 0;  // chunks in use; the rest only keep their memory
  std::vector<ChunkScratch> scratch;
};

Frame::Frame() : storage_(std::make_unique<Storage>()) {}
Frame::~Frame() = default;
Frame::Frame(Frame&&) noexcept = default;
Frame& Frame::operator=(Frame&&) noexcept = default;

namespace {

constexpr std::size_t kVerticesPerItem = 4096;

/// Submission position of each draw's first triangle, plus the total.
std::vector<std::uint32_t> check_draws(const FrameInput& input) {
  const Viewport& viewport = input.viewport;
  if (viewport.width < 1 || viewport.height < 1 || viewport.width > kMaxViewportPx || viewport.height > kMaxViewportPx)
    throw UserError(fmt::format("image size must be 1 to {} pixels each way, found {}x{}", kMaxViewportPx, viewport.width,
                                viewport.height));
  ALU_CHECK(input.samples == 1 || input.samples == 4, "{} samples a pixel", input.samples);
  const std::size_t vertices = input.positions.x.size();
  ALU_CHECK(input.positions.y.size() == vertices && input.positions.z.size() == vertices && input.positions.w.size() == vertices,
            "position arrays differ in size: {} {} {} {}", vertices, input.positions.y.size(), input.positions.z.size(),
            input.positions.w.size());
  std::vector<std::uint32_t> start{0};
  start.reserve(input.draws.size() + 1);
  std::uint64_t total = 0;
  bool in_order = false;
  for (std::size_t i = 0; i < input.draws.size(); ++i) {
    const Draw& draw = input.draws[i];
    ALU_CHECK(std::uint64_t{draw.first_index} + 3ull * draw.triangle_count <= input.indices.size(),
              "draw {} reads beyond the {} indices", i, input.indices.size());
    ALU_CHECK(draw.draw_class == DrawClass::InOrder || (!in_order && draw.depth_write),
              "draw {} is opaque but comes after an in-order draw or does not write depth", i);
    in_order = draw.draw_class == DrawClass::InOrder;
    total += draw.triangle_count;
    if (total > kMaxTriangles)
      throw UserError({}, fmt::format("a frame must have at most {} triangles, found more", kMaxTriangles),
                      "draw the scene in several frames");
    start.push_back(static_cast<std::uint32_t>(total));
  }
  return start;
}

}  // namespace

void Frame::set_up(const FrameInput& input, const ParallelFor& parallel) {
  draw_start_ = check_draws(input);
  viewport_ = input.viewport;
  samples_ = input.samples;
  draws_.assign(input.draws.begin(), input.draws.end());
  positions_ = input.positions;
  indices_ = input.indices;
  counters_ = {};
  Storage& storage = *storage_;

  const ScreenMap map(viewport_);
  const std::size_t vertex_count = positions_.x.size();
  if (storage.vertex_capacity < vertex_count) {
    storage.vertices = std::make_unique_for_overwrite<ScreenVertex[]>(vertex_count);
    storage.vertex_capacity = vertex_count;
  }
  parallel.run(static_cast<std::int64_t>((vertex_count + kVerticesPerItem - 1) / kVerticesPerItem),
               [&](std::int64_t item, int) {
                 const std::size_t begin = static_cast<std::size_t>(item) * kVerticesPerItem;
                 project_vertices(map, positions_, begin, std::min(begin + kVerticesPerItem, vertex_count),
                                  storage.vertices.get());
               });

  storage.chunk_count = (draw_start_.back() + kChunkTriangles - 1) / kChunkTriangles;
  if (storage.chunks.size() < storage.chunk_count) storage.chunks.resize(storage.chunk_count);
  storage.scratch.resize(static_cast<std::size_t>(std::max(parallel.workers, 1)));
  const ChunkInput chunk_input{viewport_, map, draws_, draw_start_, indices_, positions_,
                               std::span(storage.vertices.get(), vertex_count), input.skips, samples_};
  parallel.run(static_cast<std::int64_t>(storage.chunk_count), [&](std::int64_t chunk, int worker) {
    set_up_chunk(chunk_input, static_cast<std::uint32_t>(chunk), storage.scratch[static_cast<std::size_t>(worker)],
                 storage.chunks[static_cast<std::size_t>(chunk)]);
  });
  sort_runs();

  order_tiles(input.skips.on(Skip::EmptyTiles));
}

void Frame::order_tiles(bool skip_empty) {
  struct Task {
    std::uint32_t number;
    std::uint64_t cost;  // records, which predict the time of small triangles well and that of large ones badly
  };
  std::vector<Task> tasks;
  empty_tiles_ = 0;
  for (int tile = 0; tile < viewport_.tile_count(); ++tile) {
    std::uint64_t cost = 0;
    for (const RecordRun& run : tile_runs(tile)) cost += run.records.size();
    if (cost == 0 && skip_empty) {
      ++empty_tiles_;
    } else if (cost > kHotTileEntries && cost > counters_.bin_entries / kHotTileShare) {
      for (int quarter = 0; quarter < 4; ++quarter) {
        const int number = quarter_task(viewport_, tile, quarter);
        const TileOrigin origin = tile_task(viewport_, number).origin;
        if (origin.x < viewport_.width && origin.y < viewport_.height) tasks.push_back({static_cast<std::uint32_t>(number), cost / 4});
      }
    } else {
      tasks.push_back({static_cast<std::uint32_t>(tile), cost});
    }
  }
  std::stable_sort(tasks.begin(), tasks.end(), [](const Task& a, const Task& b) { return a.cost > b.cost; });
  tile_order_.clear();
  for (const Task& task : tasks) tile_order_.push_back(task.number);
}

/// Transposes "per chunk, the tiles it touches" into "per tile, the chunks that touch it, in order".
void Frame::sort_runs() {
  const std::span<const Chunk> chunks(storage_->chunks.data(), storage_->chunk_count);
  run_start_.assign(static_cast<std::size_t>(viewport_.tile_count()) + 1, 0);
  for (const Chunk& chunk : chunks) {
    counters_ += chunk.counters;
    for (const ChunkRun& run : chunk.runs) ++run_start_[run.tile + 1];
  }
  for (std::size_t tile = 1; tile < run_start_.size(); ++tile) run_start_[tile] += run_start_[tile - 1];
  runs_.resize(run_start_.back());
  std::vector<std::uint32_t> next(run_start_.begin(), run_start_.end() - 1);
  for (const Chunk& chunk : chunks)
    for (const ChunkRun& run : chunk.runs)
      runs_[next[run.tile]++] = RecordRun{{chunk.records.get() + run.begin, run.count}, run.z_min};
}

std::span<const RecordRun> Frame::tile_runs(int tile) const {
  const std::size_t t = static_cast<std::size_t>(tile);
  return {runs_.data() + run_start_[t], run_start_[t + 1] - run_start_[t]};
}

std::uint32_t Frame::sequence_of(TriangleId id) const {
  if ((id & kClippedBit) == 0) return id;
  const std::uint32_t chunk = (id & ~kClippedBit) >> kClipIndexBits;
  return storage_->chunks[chunk].clipped[id & ((1u << kClipIndexBits) - 1)].sequence;
}

std::uint32_t Frame::draw_of(TriangleId id) const {
  const auto after = std::upper_bound(draw_start_.begin(), draw_start_.end(), sequence_of(id));
  return static_cast<std::uint32_t>(after - draw_start_.begin()) - 1;
}

TriangleInfo Frame::triangle(TriangleId id) const {
  TriangleInfo info;
  const std::uint32_t sequence = sequence_of(id);
  info.draw = draw_of(id);
  info.primitive = sequence - draw_start_[info.draw];
  const Draw& draw = draws_[info.draw];
  for (std::size_t k = 0; k < 3; ++k)
    info.vertex[k] = draw.first_vertex + indices_[draw.first_index + 3 * std::size_t{info.primitive} + k];

  std::array<ScreenVertex, 3> corner;
  std::array<double, 3> w, b1, b2;
  info.clipped = (id & kClippedBit) != 0;
  if (info.clipped) {
    const ClippedTriangle& fragment = storage_->chunks[(id & ~kClippedBit) >> kClipIndexBits].clipped[id & ((1u << kClipIndexBits) - 1)];
    corner = fragment.corner;
    w = fragment.w;
    b1 = fragment.b1;
    b2 = fragment.b2;
  } else {
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = storage_->vertices[info.vertex[k]];
      w[k] = positions_.w[info.vertex[k]];
    }
    b1 = {0, 1, 0};
    b2 = {0, 0, 1};
  }
  const CanonicalOrder order = canonical_order(corner[0], corner[1], corner[2]);
  info.front_facing = order.front_facing;
  info.corner = order.corner;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t from = order.corner[k];
    info.x[k] = corner[from].x;
    info.y[k] = corner[from].y;
    info.w[k] = w[from];
    info.b1[k] = b1[from];
    info.b2[k] = b2[from];
  }
  return info;
}

}  // namespace aluminate::raster
