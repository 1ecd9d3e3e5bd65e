#include "tests/rasterizer/candidate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <random>

#include "rasterizer/quads.hpp"

namespace aluminate::raster::test {

std::uint32_t Geometry::add_vertex(double vx, double vy, double vz, double vw) {
  x.push_back(vx);
  y.push_back(vy);
  z.push_back(vz);
  w.push_back(vw);
  return static_cast<std::uint32_t>(x.size() - 1);
}

std::uint32_t Geometry::add_pixel_vertex(double px, double py, double depth, double vw) {
  return add_vertex((2 * px / viewport.width - 1) * vw, (1 - 2 * py / viewport.height) * vw, depth * vw, vw);
}

void Geometry::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) { indices.insert(indices.end(), {a, b, c}); }

Draw& Geometry::end_draw(CullMode cull, DrawClass draw_class, bool depth_write) {
  const std::uint32_t begin = draws.empty() ? 0 : draws.back().first_index + 3 * draws.back().triangle_count;
  Draw draw;
  draw.first_index = begin;
  draw.triangle_count = (static_cast<std::uint32_t>(indices.size()) - begin) / 3;
  draw.cull = cull;
  draw.draw_class = draw_class;
  draw.depth_write = depth_write;
  return draws.emplace_back(draw);
}

FrameInput Geometry::input(SkipSet skips) const { return {viewport, {x, y, z, w}, indices, draws, skips, samples}; }

bool survives(std::uint32_t sequence, int x, int y) {
  std::uint32_t h = sequence * 0x9e3779b1u ^ static_cast<std::uint32_t>(x) * 0x85ebca6bu ^ static_cast<std::uint32_t>(y) * 0xc2b2ae35u;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  return (h >> 12 & 3) != 0;
}

namespace {

std::uint32_t blend(std::uint32_t colour, std::uint32_t sequence) { return colour * 31 + sequence + 1; }

// One worker's. Tiles touch pixels of their own, so all may write to one picture.
class Recorder : public BillSink, public QuadShader {
 public:
  Recorder(const Frame& frame, Picture& picture) : frame_(frame), picture_(picture) {
    for (const Draw& draw : frame.draws()) start_.push_back(start_.empty() ? 0 : start_.back() + last_), last_ = draw.triangle_count;
    billed_per_draw_.assign(frame.draws().size(), 0);
  }
  const std::vector<std::uint64_t>& billed_per_draw() const { return billed_per_draw_; }
  void begin(int task) { origin_ = tile_task(frame_.viewport(), task).origin; }

  std::uint32_t sequence(TriangleId id) const {
    const TriangleInfo info = frame_.triangle(id);
    return start_[info.draw] + info.primitive;
  }

  void billed(std::span<const BilledStamp> stamps) override {
    ReferenceImage& image = picture_.planes;
    for_each_billed_quad(stamps, [&](std::uint32_t draw, int x, int y, unsigned lanes) {
      billed_per_draw_[draw] += 4;
      for (int lane = 0; lane < 4; ++lane) {
        const int px = origin_.x + x + (lane & 1), py = origin_.y + y + (lane >> 1);
        if (px >= image.width || py >= image.height) continue;
        ++(lanes >> lane & 1 ? image.covered : image.helpers)[at(px, py)];
      }
    });
  }

  std::uint64_t shade(const QuadBatch& batch) override {
    std::uint64_t kept = 0;
    for (std::size_t q = 0; q < static_cast<std::size_t>(batch.count); ++q) {
      const std::uint32_t id = sequence(batch.triangle[q]);
      for (unsigned lane = 0; lane < 4; ++lane) {
        if ((batch.visible >> (4 * q + lane) & 1) == 0) continue;
        const int px = batch.x[q] + static_cast<int>(lane & 1), py = batch.y[q] + static_cast<int>(lane >> 1);
        if (!survives(id, px, py)) continue;
        kept |= std::uint64_t{1} << (4 * q + lane);
        for (int sample = 0; sample < frame_.samples(); ++sample)
          if (batch.visible_samples[static_cast<std::size_t>(sample)] >> (4 * q + lane) & 1) {
            std::uint32_t& colour = picture_.colour[at(px, py) * static_cast<std::size_t>(frame_.samples()) + static_cast<std::size_t>(sample)];
            colour = blend(colour, id);
          }
      }
    }
    return kept;
  }

 private:
  std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_.planes.width) + static_cast<std::size_t>(x);
  }
  const Frame& frame_;
  Picture& picture_;
  TileOrigin origin_{};
  std::vector<std::uint32_t> start_;
  std::vector<std::uint64_t> billed_per_draw_;
  std::uint32_t last_ = 0;
};

Picture blank(const Geometry& geometry) {
  Picture picture;
  ReferenceImage& image = picture.planes;
  image.width = geometry.viewport.width;
  image.height = geometry.viewport.height;
  image.samples = geometry.samples;
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  const std::size_t samples = pixels * static_cast<std::size_t>(image.samples);
  image.visibility.assign(samples, kNoTriangle);
  image.depth.assign(samples, kDepthMax);
  image.covered.assign(pixels, 0);
  image.helpers.assign(pixels, 0);
  image.billed_per_draw.assign(geometry.draws.size(), 0);
  picture.colour.assign(samples, 0);
  return picture;
}

}  // namespace

Picture draw_candidate(const Geometry& geometry, const CandidateOptions& options) {
  Frame frame;
  frame.set_up(geometry.input(options.skips), options.threads);
  Picture picture = blank(geometry);
  ReferenceImage& image = picture.planes;
  std::vector<std::uint32_t> order(frame.tile_order().begin(), frame.tile_order().end());
  if (options.tile_order_seed != 0) std::shuffle(order.begin(), order.end(), std::mt19937(options.tile_order_seed));

  struct Worker {
    TileRasterizer tiles;
    Recorder recorder;
    std::vector<VisibleQuad> quads;
  };
  std::vector<Worker> workers;
  for (int i = 0; i < options.threads.workers; ++i) workers.push_back({TileRasterizer(frame, {options.bill, options.skips}), Recorder(frame, picture), {}});
  options.threads.run(static_cast<std::int64_t>(order.size()), [&](std::int64_t i, int number) {
    auto& [tiles, recorder, quads] = workers[static_cast<std::size_t>(number)];
    const int tile = static_cast<int>(order[static_cast<std::size_t>(i)]);
    BillSink* const bill = options.with_bill ? &recorder : nullptr;
    tiles.begin(tile);
    recorder.begin(tile);
    tiles.draw_opaque(bill);
    gather_visible_quads(frame, tiles.view(), quads);
    for (const VisibleQuad& quad : quads)
      for (int bit = 0; bit < 4 * image.samples; ++bit)
        if (quad.samples >> bit & 1) {
          const int px = quad.x + (bit & 1), py = quad.y + (bit >> 1 & 1), sample = bit >> 2;
          image.visibility[static_cast<std::size_t>((py * image.width + px) * image.samples + sample)] = recorder.sequence(quad.triangle);
        }
    tiles.draw_in_order(recorder, bill);
    const TileView view = tiles.view();
    for (int y = 0; y < view.height; ++y)
      for (int x = 0; x < view.width; ++x)
        for (int sample = 0; sample < image.samples; ++sample)
          image.depth[static_cast<std::size_t>(((view.origin.y + y) * image.width + view.origin.x + x) * image.samples + sample)] =
              view.depth[static_cast<std::size_t>(view.element(x, y, sample))];
  });
  picture.setup = frame.counters();
  for (const Worker& worker : workers) {
    picture.tiles += worker.tiles.counters();
    for (std::size_t draw = 0; draw < image.billed_per_draw.size(); ++draw) image.billed_per_draw[draw] += worker.recorder.billed_per_draw()[draw];
  }
  return picture;
}

Picture draw_expected(const Geometry& geometry, const BillRule& bill) {
  Picture picture = blank(geometry);
  const auto shade = [&picture, &geometry](std::uint32_t, std::uint32_t sequence, int x, int y, unsigned samples) {
    if (!survives(sequence, x, y)) return false;
    for (int sample = 0; sample < geometry.samples; ++sample)
      if (samples >> sample & 1) {
        std::uint32_t& colour = picture.colour[static_cast<std::size_t>((y * geometry.viewport.width + x) * geometry.samples + sample)];
        colour = blend(colour, sequence);
      }
    return true;
  };
  picture.planes = draw_reference(geometry.input(), bill, shade);
  return picture;
}

std::string difference(const Picture& candidate, const Picture& expected) {
  const auto compare = [&](const char* plane, const std::vector<std::uint32_t>& got, const std::vector<std::uint32_t>& want) -> std::string {
    if (got == want) return {};
    const auto [g, e] = std::mismatch(got.begin(), got.end(), want.begin());
    const std::size_t width = static_cast<std::size_t>(candidate.planes.width), pixels = width * static_cast<std::size_t>(candidate.planes.height);
    const std::size_t element = static_cast<std::size_t>(g - got.begin()), samples = got.size() / pixels, pixel = element / samples;
    std::size_t count = 0;
    for (std::size_t i = 0; i < got.size(); ++i) count += got[i] != want[i];
    return fmt::format("{} differs at {} samples, first ({}, {}) sample {}: {} ({:#x}), expected {} ({:#x})", plane, count, pixel % width, pixel / width, element % samples, *g, *g, *e, *e);
  };
  std::string text = compare("visibility", candidate.planes.visibility, expected.planes.visibility);
  if (text.empty()) text = compare("depth", candidate.planes.depth, expected.planes.depth);
  if (text.empty()) text = compare("colour", candidate.colour, expected.colour);
  if (text.empty()) text = compare("billed covered invocations", candidate.planes.covered, expected.planes.covered);
  if (text.empty()) text = compare("billed helper invocations", candidate.planes.helpers, expected.planes.helpers);
  if (text.empty() && candidate.planes.billed_per_draw != expected.planes.billed_per_draw) text = "bill per draw differs";
  return text;
}

}  // namespace aluminate::raster::test
