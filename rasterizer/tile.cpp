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
  std::array<std::uint16_t, kStampsPerTile * kMaxSamples> pending{};  // lanes by stamp and sample, as in TileMemory
  QuadShader* shader = nullptr;

  KernelOptions kernel_options(bool billing) const {
    KernelOptions kernel;
    kernel.bill = options.bill;
    kernel.samples = frame.samples();
    if (!billing) kernel.bill.kind = BillRule::Kind::Off;
    // A bill without rejection needs the coverage of hidden triangles.
    const bool may_hide = kernel.bill.kind != BillRule::Kind::Everything;
    kernel.occluded = may_hide && options.skips.on(Skip::Occluded);
    kernel.tile_hiz = may_hide && options.skips.on(Skip::TileHiz);
    kernel.block_hiz = may_hide && options.skips.on(Skip::BlockHiz);
    return kernel;
  }

  /// True when the rest of the current run, from this record, lies behind everything in the tile.
  bool skip_run(const KernelOptions& kernel, std::size_t from) {
    const RecordRun& r = runs[run];
    if (!kernel.occluded || !tile_hides(tile, r.z_min, kernel.samples)) return false;
    counters.occluded += r.records.size() - from;
    return true;
  }
  void shade_batch();
  void add_triangle(const SetupTriangle& t, const Draw& draw, const KernelOptions& kernel);
  unsigned billed_lanes(int entry, unsigned covered, unsigned pass, const Draw& draw, const KernelOptions& kernel);
  std::uint32_t block_max(int stamp, unsigned lanes) const;
};

TileRasterizer::TileRasterizer(const Frame& frame, const TileOptions& options) : state_(std::make_unique<State>(frame)) {
  const int block = options.bill.block_px;
  ALU_CHECK(block == 4 || block == 8 || block == 16 || (block == 2 && frame.samples() == 4),
            "hierarchical depth blocks of {} px at {} samples", block, frame.samples());
  state_->options = options;
}
TileRasterizer::~TileRasterizer() = default;
TileRasterizer::TileRasterizer(TileRasterizer&&) noexcept = default;

void TileRasterizer::begin(int number) {
  State& s = *state_;
  TileMemory& tile = s.tile;
  const Viewport& viewport = s.frame.viewport();
  const TileTask task = tile_task(viewport, number);
  tile.origin = task.origin;
  tile.width = std::min(task.size_px, viewport.width - tile.origin.x);
  tile.height = std::min(task.size_px, viewport.height - tile.origin.y);
  const int samples = s.frame.samples();
  clear_tile(tile, samples);
  const int stamps = task.size_px * task.size_px / (kStampPx * kStampPx), blocks = stamps / 16;
  std::fill_n(tile.inside, kStampsPerTile, std::uint16_t{0});
  std::fill_n(tile.inside, stamps, std::uint16_t{0xffff});
  if (tile.width < task.size_px || tile.height < task.size_px) {
    for (int y = 0; y < task.size_px; ++y)
      for (int x = y < tile.height ? tile.width : 0; x < task.size_px; ++x) {
        for (int sample = 0; sample < samples; ++sample) tile.depth[(stamp_of(x, y) * samples + sample) * 16 + lane_of(x, y)] = 0;
        tile.inside[stamp_of(x, y)] &= static_cast<std::uint16_t>(~(1u << lane_of(x, y)));
      }
  }
  std::fill_n(tile.block_max, 16, 0);
  std::fill_n(tile.block_max, blocks, static_cast<std::int32_t>(kDepthMax));
  tile.middle = stamps / 2 * 16 * samples;
  std::fill_n(tile.block_writes, 16, 0u);
  tile.tile_max = kDepthMax;
  tile.tile_writes = 0;

  const std::span<const Draw> draws = s.frame.draws();
  s.first_in_order = static_cast<std::uint32_t>(
      std::find_if(draws.begin(), draws.end(), [](const Draw& d) { return d.draw_class == DrawClass::InOrder; }) - draws.begin());
  s.runs = s.frame.tile_runs(task.tile);
  s.run = s.record = 0;
}

void TileRasterizer::draw_opaque(BillSink* bill) {
  State& s = *state_;
  const KernelOptions kernel = s.kernel_options(bill != nullptr);
  s.bill.sink = bill;
  const bool in_order_exists = s.first_in_order < s.frame.draws().size();
  for (; s.run < s.runs.size(); ++s.run) {
    const std::span<const SetupTriangle> run = s.runs[s.run].records;
    if (s.skip_run(kernel, 0)) continue;
    // Runs lie far apart in memory and are short when triangles are small: fetch ahead what the next ones start with.
    if (s.run + kPrefetchRuns < s.runs.size()) {
      const std::span<const SetupTriangle> ahead = s.runs[s.run + kPrefetchRuns].records;
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
  const std::size_t samples = static_cast<std::size_t>(frame.samples());
  for (std::size_t q = 0; q < static_cast<std::size_t>(batch.count); ++q) {
    for (std::size_t sample = 0; sample < samples; ++sample) {
      const std::size_t group = batch_stamp[q] * samples + sample, element = group * 16 + std::size_t{batch_quad[q]} * 4;
      pending[group] = 0;
      const unsigned lanes = (survivors & batch.visible_samples[sample]) >> (4 * q) & 0xf;
      if (!write || lanes == 0) continue;
      for (unsigned l = 0; l < 4; ++l)
        if (lanes >> l & 1) tile.depth[element + l] = batch.depth[sample][4 * q + l];
      const auto written = static_cast<std::uint32_t>(std::popcount(lanes));
      tile.block_writes[batch_stamp[q] >> 4] += written;
      tile.tile_writes += written;
    }
  }
  batch.count = 0;
  batch.visible = batch.billed = 0;
  batch.visible_samples = {};
}

/// The farthest depth stored in the bill's block around these lanes of a stamp (all of it, or one quad).
std::uint32_t TileRasterizer::State::block_max(int stamp, unsigned lanes) const {
  const int samples = frame.samples();
  if (options.bill.block_px >= kStampPx) {
    const int stamps = (options.bill.block_px / kStampPx) * (options.bill.block_px / kStampPx);
    const std::uint32_t* depth = tile.depth + (stamp & ~(stamps - 1)) * samples * 16;
    return *std::max_element(depth, depth + stamps * samples * 16);
  }
  std::uint32_t most = 0;
  for (int sample = 0; sample < samples; ++sample)
    for (unsigned rest = lanes; rest != 0; rest &= rest - 1)
      most = std::max(most, tile.depth[(stamp * samples + sample) * 16 + std::countr_zero(rest)]);
  return most;
}

/// Lanes of one stamp that go on the bill. May run the waiting quads: only their depth tells whether the stamp is hidden.
unsigned TileRasterizer::State::billed_lanes(int entry, unsigned covered, unsigned pass, const Draw& draw, const KernelOptions& kernel) {
  switch (kernel.bill.kind) {
    case BillRule::Kind::Off: return 0;
    case BillRule::Kind::Everything: return covered;
    case BillRule::Kind::PerPixel: return pass;
    case BillRule::Kind::Hierarchical: break;
  }
  const int samples = frame.samples(), stamp = fragments.stamp[entry];
  const bool by_quad = kernel.bill.block_px < kStampPx;
  unsigned billed = 0;
  for (unsigned unit = by_quad ? 0xfu : 0xffffu; (unit & 0xffffu) != 0; unit = by_quad ? unit << 4 : 0) {
    const unsigned lanes = covered & unit;
    if (lanes == 0) continue;
    if ((pass & unit) == 0) {
      std::uint32_t nearest = kDepthMax;
      for (int sample = 0; sample < samples; ++sample)
        for (unsigned rest = unit & fragments.covered[entry * samples + sample]; rest != 0; rest &= rest - 1)
          nearest = std::min(nearest, fragments.depth[entry * samples + sample][std::countr_zero(rest)]);
      // Waiting quads can only lower the maximum: a rejection stands, an acceptance needs their depth.
      if (nearest >= block_max(stamp, unit)) continue;
      if (batch.count != 0 && draw.depth_write) shade_batch();
      if (nearest >= block_max(stamp, unit)) continue;
    }
    billed |= lanes;
  }
  return billed;
}

void TileRasterizer::State::add_triangle(const SetupTriangle& t, const Draw& draw, const KernelOptions& kernel) {
  find_fragments(tile, t, kernel, fragments, hiz);
  if (bill.count > BillBuffer::kCapacity - kStampsPerTile) bill.flush();
  const int samples = frame.samples();
  for (int i = 0; i < fragments.count; ++i) {
    const int stamp = fragments.stamp[i];
    unsigned covered = 0, waiting = 0;
    for (int sample = 0; sample < samples; ++sample) {
      covered |= fragments.covered[i * samples + sample];
      waiting |= fragments.covered[i * samples + sample] & pending[static_cast<std::size_t>(stamp * samples + sample)];
    }
    // A sample may wait for the shader once: the next triangle on it has to see its depth and blend over its colour.
    if (waiting != 0) shade_batch();
    std::array<unsigned, kMaxSamples> sample_pass{};
    unsigned pass = 0;
    for (int sample = 0; sample < samples; ++sample) {
      const std::uint32_t *z = fragments.depth[i * samples + sample], *stored = tile.depth + (stamp * samples + sample) * 16;
      unsigned nearer = 0;
      for (unsigned l = 0; l < 16; ++l) nearer |= static_cast<unsigned>(z[l] < stored[l]) << l;
      sample_pass[static_cast<std::size_t>(sample)] = nearer & fragments.covered[i * samples + sample];
      pass |= sample_pass[static_cast<std::size_t>(sample)];
    }
    const unsigned billed = billed_lanes(i, covered, pass, draw, kernel);
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
      batch_stamp[q] = static_cast<std::uint16_t>(stamp);
      batch_quad[q] = static_cast<std::uint8_t>(quad);
      for (std::size_t sample = 0; sample < static_cast<std::size_t>(samples); ++sample) {
        const unsigned visible = sample_pass[sample] >> 4 * quad & 0xf;
        batch.visible_samples[sample] |= std::uint64_t{visible} << 4 * q;
        std::copy_n(fragments.depth[static_cast<std::size_t>(i * samples) + sample] + 4 * quad, 4, batch.depth[sample].begin() + static_cast<std::ptrdiff_t>(4 * q));
        pending[static_cast<std::size_t>(stamp * samples) + sample] |= static_cast<std::uint16_t>(visible << 4 * quad);
      }
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
    const std::span<const SetupTriangle> run = s.runs[s.run].records;
    if (s.skip_run(kernel, s.record)) continue;
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
  const auto elements = static_cast<std::size_t>(kTilePixels * state_->frame.samples());
  return {tile.origin, tile.width, tile.height, state_->frame.samples(), {tile.visibility, elements}, {tile.depth, elements}};
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
          tile.depth[static_cast<std::size_t>(tile.element(x, y, 0))];
}

}  // namespace aluminate::raster
