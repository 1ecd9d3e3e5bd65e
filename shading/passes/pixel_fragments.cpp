#include "shading/passes/pixel_fragments.hpp"

#include "rasterizer/tile.hpp"

namespace aluminate::passes {
namespace {

class FragmentList : public raster::BillSink, public raster::QuadShader {
 public:
  FragmentList(int x, int y) : stamp_(raster::stamp_of(x, y)), lane_(raster::lane_of(x, y)) {}

  void billed(std::span<const raster::BilledStamp> stamps) override {
    for (const raster::BilledStamp& stamp : stamps)
      if (stamp.stamp == stamp_ && (stamp.covered >> lane_ & 1) != 0) draws_.push_back(stamp.draw);
  }
  std::uint64_t shade(const raster::QuadBatch& batch) override { return batch.visible; }

  std::vector<std::uint32_t> take() && { return std::move(draws_); }

 private:
  int stamp_, lane_;
  std::vector<std::uint32_t> draws_;
};

}  // namespace

std::vector<std::uint32_t> fragments_at(const PreparedFrame& prepared, int tile, int x, int y,
                                        raster::BillRule::Kind rule) {
  raster::TileRasterizer rasterizer(prepared.raster_frame,
                                    {.bill = {rule, 4}, .skips = raster::SkipSet::none()});
  FragmentList fragments(x, y);
  rasterizer.begin(tile);
  rasterizer.draw_opaque(&fragments);
  rasterizer.draw_in_order(fragments, &fragments);
  return std::move(fragments).take();
}

}  // namespace aluminate::passes
