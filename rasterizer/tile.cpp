#include "rasterizer/tile.hpp"

#include <algorithm>
#include <bit>

#include "platform/host/error.hpp"
#include "rasterizer/tile_kernel.hpp"

namespace aluminate::raster {

namespace {
constexpr std::size_t kPrefetchRuns = 3, kPrefetchRecords = 8;
}

struct TileRasterizer::State {
  explicit State(const Frame& f) : frame(f) {}

  const Frame& frame;
  TileOptions options;
  TileMemory tile;
  BillBuffer bill;
  HizCounters hiz;
  TileCounters counters;
  std::uint32_t first_in_order = 0;          // draw number
  std::span<const RecordRun> runs;
  std::size_t run = 0, record = 0;           // where the in-order draws begin

  // In-order work in progress: quads waiting for the shader and the pixels they hold.
  StampFragments fragments;
  QuadBatch batch;
  std::array<std::uint16_t, kBatchQuads> batch_stamp{};
  std::array<std::uint8_t, kBatchQuads> batch_quad{};
  std::array<std::uint16_t, kStampsPerTile> pending{};
  QuadShader* shader = nullptr;

  KernelOptions kernel_options(bool billing) const {
    KernelOptions kernel;
    kernel.bill = options.bill;
    if (!billing) kernel.bill.kind = BillRule::Kind::Off;
    // A bill without rejection needs the coverage of hidden triangles.
    const bool may_hide = kernel.bill.kind != BillRule::Kind::Everything;
    kernel.tile_hiz = may_hide && options.skips.on(Skip::TileHiz);
    kernel.block_hiz = may_hide && options.skips.on(Skip::BlockHiz);
    return kernel;
  }

  void shade_batch();
  void add_triangle(const SetupTriangle& t, const Draw& draw, const KernelOptions& kernel);
  std::uint32_t block_max(int stamp) const;
};

TileRasterizer::TileRasterizer(const Frame& frame, const TileOptions& options) : state_(std::make_unique<State>(frame)) {
  const int block = options.bill.block_px;
  ALU_CHECK(block == 4 || block == 8 || block == 16, "hierarchical depth blocks of {} px", block);
  state_->options = options;
}
TileRasterizer::~TileRasterizer() = default;
TileRasterizer::TileRasterizer(TileRasterizer&&) noexcept = default;

void TileRasterizer::begin(int tile_number) {
  State& s = *state_;
  TileMemory& tile = s.tile;
  const Viewport& viewport = s.frame.viewport();
  tile.origin = tile_origin(viewport, tile_number);
  tile.width = std::min(kTilePx, viewport.width - tile.origin.x);
  tile.height = std::min(kTilePx, viewport.height - tile.origin.y);
  clear_tile(tile);
  std::fill_n(tile.inside, kStampsPerTile, std::uint16_t{0xffff});
  if (tile.width < kTilePx || tile.height < kTilePx) {
    for (int y = 0; y < kTilePx; ++y)
      for (int x = 0; x < kTilePx; ++x) {
        if (x < tile.width && y < tile.height) continue;
        tile.depth[TileView::element(x, y)] = 0;
        tile.inside[stamp_of(x, y)] &= static_cast<std::uint16_t>(~(1u << lane_of(x, y)));
      }
  }
  std::fill_n(tile.block_max, 16, static_cast<std::int32_t>(kDepthMax));
  std::fill_n(tile.block_writes, 16, 0u);
  tile.tile_max = kDepthMax;
  tile.tile_writes = 0;

  const std::span<const Draw> draws = s.frame.draws();
  s.first_in_order = static_cast<std::uint32_t>(
      std::find_if(draws.begin(), draws.end(), [](const Draw& d) { return d.draw_class == DrawClass::InOrder; }) - draws.begin());
  s.runs = s.frame.tile_runs(tile_number);
  s.run = s.record = 0;
}

void TileRasterizer::draw_opaque(BillSink* bill) {
  State& s = *state_;
  const KernelOptions kernel = s.kernel_options(bill != nullptr);
  s.bill.sink = bill;
  const bool in_order_exists = s.first_in_order < s.frame.draws().size();
  for (; s.run < s.runs.size(); ++s.run) {
    const RecordRun& run = s.runs[s.run];
    // Runs lie far apart in memory and are short when triangles are small: fetch ahead what the next ones start with.
    if (s.run + kPrefetchRuns < s.runs.size()) {
      const RecordRun& ahead = s.runs[s.run + kPrefetchRuns];
      for (std::size_t i = 0; i < std::min<std::size_t>(ahead.size(), kPrefetchRecords); ++i) __builtin_prefetch(&ahead[i]);
    }
    std::size_t count = run.size();
    if (in_order_exists && run.back().draw() >= s.first_in_order)
      count = static_cast<std::size_t>(
          std::partition_point(run.begin(), run.end(), [&](const SetupTriangle& t) { return t.draw() < s.first_in_order; }) - run.begin());
    draw_opaque_records(s.tile, run.data(), count, kernel, s.bill, s.hiz);
    if (count < run.size()) {
      s.record = count;
      break;
    }
  }
  s.bill.flush();
}

/// Runs the shader on the waiting quads and writes the depth of the survivors.
void TileRasterizer::State::shade_batch() {
  if (batch.count == 0) return;
  const std::uint64_t survivors = shader->shade(batch) & batch.visible;
  const bool write = frame.draws()[batch.draw].depth_write;
  for (std::size_t q = 0; q < static_cast<std::size_t>(batch.count); ++q) {
    const unsigned lanes = survivors >> (4 * q) & 0xf;
    const std::size_t element = std::size_t{batch_stamp[q]} * 16 + std::size_t{batch_quad[q]} * 4;
    pending[batch_stamp[q]] = 0;
    if (!write || lanes == 0) continue;
    for (unsigned l = 0; l < 4; ++l)
      if (lanes >> l & 1) tile.depth[element + l] = batch.depth[4 * q + l];
    const auto written = static_cast<std::uint32_t>(std::popcount(lanes));
    tile.block_writes[batch_stamp[q] >> 4] += written;
    tile.tile_writes += written;
  }
  batch.count = 0;
  batch.visible = batch.billed = 0;
}

std::uint32_t TileRasterizer::State::block_max(int stamp) const {
  const int stamps = (options.bill.block_px / kStampPx) * (options.bill.block_px / kStampPx);
  const std::uint32_t* depth = tile.depth + (stamp & ~(stamps - 1)) * 16;
  return *std::max_element(depth, depth + stamps * 16);
}

void TileRasterizer::State::add_triangle(const SetupTriangle& t, const Draw& draw, const KernelOptions& kernel) {
  find_fragments(tile, t, kernel, fragments, hiz);
  if (bill.count > BillBuffer::kCapacity - kStampsPerTile) bill.flush();
  for (int i = 0; i < fragments.count; ++i) {
    const int stamp = fragments.stamp[i];
    const std::size_t s = static_cast<std::size_t>(stamp);
    const unsigned covered = fragments.covered[i];
    // A pixel may wait for the shader once: the next triangle on it has to see its depth and blend over its colour.
    if (pending[s] & covered) shade_batch();
    const std::uint32_t* z = fragments.depth[i];
    const auto depth_test = [&] {
      unsigned pass = 0;
      for (unsigned l = 0; l < 16; ++l) pass |= static_cast<unsigned>(z[l] < tile.depth[s * 16 + l]) << l;
      return pass & covered;
    };
    const unsigned pass = depth_test();
    unsigned billed = 0;
    switch (kernel.bill.kind) {
      case BillRule::Kind::Off: break;
      case BillRule::Kind::Everything: billed = covered; break;
      case BillRule::Kind::PerPixel: billed = pass; break;
      case BillRule::Kind::Hierarchical:
        if (pass != 0) {
          billed = covered;
        } else {
          std::uint32_t nearest = kDepthMax;
          for (unsigned rest = covered; rest != 0; rest &= rest - 1) nearest = std::min(nearest, z[std::countr_zero(rest)]);
          // Waiting quads can only lower the maximum: a rejection stands, an acceptance needs their depth.
          if (nearest < block_max(stamp)) {
            if (batch.count != 0 && draw.depth_write) shade_batch();
            if (nearest < block_max(stamp)) billed = covered;
          }
        }
        break;
    }
    if (billed != 0)
      bill.stamps[bill.count++] = {t.draw(), static_cast<std::uint16_t>(billed), static_cast<std::uint8_t>(stamp)};

    for (unsigned quad = 0; quad < 4; ++quad) {
      const unsigned quad_visible = pass >> 4 * quad & 0xf, quad_billed = billed >> 4 * quad & 0xf;
      if ((covered >> 4 * quad & 0xf) == 0) continue;
      if (quad_visible == 0 && options.skips.on(Skip::EarlyZ) && !(draw.execute_billed && quad_billed != 0)) {
        ++counters.early_z;
        continue;
      }
      const std::size_t q = static_cast<std::size_t>(batch.count++);
      batch.draw = t.draw();
      batch.triangle[q] = t.id;
      batch.x[q] = static_cast<std::uint16_t>(tile.origin.x + stamp_x(stamp) + static_cast<int>(quad & 1) * 2);
      batch.y[q] = static_cast<std::uint16_t>(tile.origin.y + stamp_y(stamp) + static_cast<int>(quad >> 1) * 2);
      batch.visible |= std::uint64_t{quad_visible} << 4 * q;
      batch.billed |= std::uint64_t{quad_billed} << 4 * q;
      std::copy_n(z + 4 * quad, 4, batch.depth.begin() + static_cast<std::ptrdiff_t>(4 * q));
      batch_stamp[q] = static_cast<std::uint16_t>(stamp);
      batch_quad[q] = static_cast<std::uint8_t>(quad);
      pending[s] |= static_cast<std::uint16_t>(quad_visible << 4 * quad);
      ++counters.quads_shaded;
      if (batch.count == kBatchQuads) shade_batch();
    }
  }
}

void TileRasterizer::draw_in_order(QuadShader& shader, BillSink* bill) {
  State& s = *state_;
  const KernelOptions kernel = s.kernel_options(bill != nullptr);
  s.bill.sink = bill;
  s.shader = &shader;
  for (; s.run < s.runs.size(); ++s.run, s.record = 0) {
    const RecordRun& run = s.runs[s.run];
    for (; s.record < run.size(); ++s.record) {
      const SetupTriangle& t = run[s.record];
      if (s.batch.count != 0 && s.batch.draw != t.draw()) s.shade_batch();
      s.add_triangle(t, s.frame.draws()[t.draw()], kernel);
    }
  }
  s.shade_batch();
  s.bill.flush();
}

TileView TileRasterizer::view() const {
  const TileMemory& tile = state_->tile;
  return {tile.origin, tile.width, tile.height, std::span<const TriangleId, kTilePixels>(tile.visibility),
          std::span<const std::uint32_t, kTilePixels>(tile.depth)};
}

const TileCounters& TileRasterizer::counters() const {
  state_->counters.tile_hiz = state_->hiz.tile;
  state_->counters.block_hiz = state_->hiz.block;
  return state_->counters;
}

void store_depth(const TileView& tile, std::span<std::uint32_t> image, int image_width) {
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x)
      image[static_cast<std::size_t>(tile.origin.y + y) * static_cast<std::size_t>(image_width) + static_cast<std::size_t>(tile.origin.x + x)] =
          tile.depth[static_cast<std::size_t>(TileView::element(x, y))];
}

}  // namespace aluminate::raster
