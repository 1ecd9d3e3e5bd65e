// Whole frames drawn flat, to be timed beside another renderer in the same run: vertex transform, set-up,
// tiles, colour into a row-major RGBA8 picture; no shader VM and no bill. Scenes: synth:grid:N (N x N quads
// that fill the picture once), synth:fill:K (K full-screen quads, back to front) or a glTF file seen from
// outside. Prints one line of JSON.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "platform/host/parallel.hpp"
#include "rasterizer/frame.hpp"
#include "rasterizer/tile.hpp"
#include "scenes/loader.hpp"
#include "scenes/view.hpp"

using namespace aluminate;

namespace {

constexpr std::uint32_t kBackground = 0xff140f0du, kSurface = 0xff668099u;

struct Model {
  std::vector<float> x, y, z;  // as another renderer keeps them: binary32
  std::vector<std::uint32_t> indices;
  std::vector<raster::Draw> draws;
  glm::dmat4 to_clip{1};

  std::uint32_t vertex(double px, double py, double pz) {
    x.push_back(static_cast<float>(px));
    y.push_back(static_cast<float>(py));
    z.push_back(static_cast<float>(pz));
    return static_cast<std::uint32_t>(x.size() - 1);
  }
  void end_draw(raster::CullMode cull) {
    const std::uint32_t first =
        draws.empty() ? 0 : draws.back().first_index + 3 * draws.back().triangle_count;
    draws.push_back({.first_index = first,
                     .triangle_count = (static_cast<std::uint32_t>(indices.size()) - first) / 3,
                     .cull = cull});
  }
};

Model grid(int n) {
  Model m;
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) m.vertex(2.0 * x / n - 1, 2.0 * y / n - 1, 0.5);
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const auto b = static_cast<std::uint32_t>(y * (n + 1) + x), up = b + static_cast<std::uint32_t>(n) + 1;
      m.indices.insert(m.indices.end(), {b, b + 1, up + 1, b, up + 1, up});
    }
  m.end_draw(raster::CullMode::Back);
  return m;
}

Model layers(int count) {
  Model m;
  for (int i = 0; i < count; ++i) {
    const double z = 0.95 - 0.9 * (i + 0.5) / count;
    const std::uint32_t b = m.vertex(-1, -1, z);
    m.vertex(1, -1, z);
    m.vertex(1, 1, z);
    m.vertex(-1, 1, z);
    m.indices.insert(m.indices.end(), {b, b + 1, b + 2, b, b + 2, b + 3});
  }
  m.end_draw(raster::CullMode::Back);
  return m;
}

Model from_file(const std::string& path, const std::string& camera, double aspect) {
  const scenes::Scene scene = scenes::load_scene(path);
  const scenes::NormalisedSpace space = scenes::normalised_space(scene);
  Model m;
  m.to_clip = scenes::make_view(scene, space, scenes::parse_camera(camera), aspect).world_to_clip();
  for (const scenes::Mesh& mesh : scene.meshes) {
    const auto first = static_cast<std::uint32_t>(m.x.size());
    for (const glm::dvec3& position : mesh.positions) {
      const glm::dvec3 p = space.point(position);
      m.vertex(p.x, p.y, p.z);
    }
    for (const std::uint32_t index : mesh.indices) m.indices.push_back(first + index);
    m.end_draw(scene.materials[static_cast<std::size_t>(mesh.material)].double_sided
                   ? raster::CullMode::None
                   : raster::CullMode::Back);
  }
  return m;
}

class Renderer {
 public:
  Renderer(const Model& model, raster::Viewport viewport, int samples)
      : model_(model), viewport_(viewport), samples_(samples) {
    for (std::vector<double>* component : {&x_, &y_, &z_, &w_}) component->resize(model.x.size());
    for (int n = 0; n <= samples; ++n) mixed_[n] = mix(n, samples);
    picture_.resize(static_cast<std::size_t>(viewport.width) * static_cast<std::size_t>(viewport.height));
  }

  void draw(const raster::ParallelFor& parallel) {
    constexpr std::size_t kBatch = 4096;
    const std::size_t vertices = model_.x.size();
    parallel.run(static_cast<std::int64_t>((vertices + kBatch - 1) / kBatch), [&](std::int64_t batch, int) {
      const std::size_t first = static_cast<std::size_t>(batch) * kBatch;
      transform(first, std::min(first + kBatch, vertices));
    });
    frame_.set_up({viewport_, {x_, y_, z_, w_}, model_.indices, model_.draws, {}, samples_}, parallel);
    while (tiles_.size() < static_cast<std::size_t>(parallel.workers))
      tiles_.emplace_back(frame_, raster::TileOptions{});
    const auto order = frame_.tile_order();
    if (frame_.empty_tiles() != 0)
      parallel.run(viewport_.tiles_y(), [&](std::int64_t row, int) { clear_empty_tiles(static_cast<int>(row)); });
    parallel.run(static_cast<std::int64_t>(order.size()), [&](std::int64_t i, int worker) {
      raster::TileRasterizer& tile = tiles_[static_cast<std::size_t>(worker)];
      tile.begin(static_cast<int>(order[static_cast<std::size_t>(i)]));
      tile.draw_opaque(nullptr);
      store(tile.view());
    });
  }
  const std::vector<std::uint32_t>& picture() const { return picture_; }

 private:
  void transform(std::size_t first, std::size_t last) {
    const glm::dmat4& m = model_.to_clip;
    for (std::size_t i = first; i < last; ++i) {
      const double px = double{model_.x[i]}, py = double{model_.y[i]}, pz = double{model_.z[i]};
      x_[i] = m[0][0] * px + m[1][0] * py + m[2][0] * pz + m[3][0];
      y_[i] = m[0][1] * px + m[1][1] * py + m[2][1] * pz + m[3][1];
      z_[i] = m[0][2] * px + m[1][2] * py + m[2][2] * pz + m[3][2];
      w_[i] = m[0][3] * px + m[1][3] * py + m[2][3] * pz + m[3][3];
    }
  }

  void clear_empty_tiles(int tile_row) {
    for (int tile = tile_row * viewport_.tiles_x(); tile < (tile_row + 1) * viewport_.tiles_x(); ++tile) {
      if (!frame_.tile_is_empty(tile)) continue;
      const raster::TileOrigin origin = raster::tile_origin(viewport_, tile);
      for (int y = origin.y; y < std::min(origin.y + raster::kTilePx, viewport_.height); ++y) {
        const auto row = picture_.begin() + std::int64_t{y} * viewport_.width;
        std::fill(row + origin.x, row + std::min(origin.x + raster::kTilePx, viewport_.width), kBackground);
      }
    }
  }

  /// Every surface has one colour, so a pixel's colour is how many of its samples are covered.
  static std::uint32_t mix(int covered, int samples) {
    std::uint32_t color = 0;
    for (int shift = 0; shift < 32; shift += 8) {
      const int back = static_cast<int>(kBackground >> shift & 0xff),
                front = static_cast<int>(kSurface >> shift & 0xff);
      color |=
          static_cast<std::uint32_t>((covered * front + (samples - covered) * back + samples / 2) / samples)
          << shift;
    }
    return color;
  }

  /// A band of four rows at a time, so that whole lines of memory are written at once.
  void store(const raster::TileView& view) {
    const auto width = static_cast<std::size_t>(viewport_.width);
    const std::size_t stamp_size = static_cast<std::size_t>(samples_) * 16;
    for (int y = 0; y < view.height; y += raster::kStampPx) {
      alignas(64) std::uint32_t band[raster::kMaxSamples][raster::kStampPx][raster::kTilePx];
      for (int x = 0; x < raster::kTilePx; x += raster::kStampPx) {
        const raster::TriangleId* id = view.visibility.data() + static_cast<std::size_t>(raster::stamp_of(x, y)) * stamp_size;
        for (int s = 0; s < samples_; ++s)
          for (int row = 0; row < raster::kStampPx; ++row)
            for (int column = 0; column < raster::kStampPx; column += 2)  // lanes of a quad's row are neighbours
              std::memcpy(&band[s][row][x + column], id + 16 * s + raster::lane_of(column, row), 2 * sizeof *id);
      }
      for (int row = 0; row < std::min(raster::kStampPx, view.height - y); ++row) {
        std::uint32_t* const out = &picture_[static_cast<std::size_t>(view.origin.y + y + row) * width + static_cast<std::size_t>(view.origin.x)];
        const int visible = view.width;  // a copy: what is stored might alias the original
        if (samples_ == 1) {
          for (int x = 0; x < visible; ++x)
            out[x] = kBackground ^ ((kBackground ^ kSurface) & (0u - static_cast<std::uint32_t>(band[0][row][x] != raster::kNoTriangle)));
          continue;
        }
        for (int x = 0; x < visible; ++x) {
          int covered = 0;
          for (int s = 0; s < raster::kMaxSamples; ++s) covered += band[s][row][x] != raster::kNoTriangle;
          out[x] = mixed_[covered];
        }
      }
    }
  }

  const Model& model_;
  raster::Viewport viewport_;
  int samples_;
  std::uint32_t mixed_[raster::kMaxSamples + 1] = {};  // colour by covered samples
  std::vector<double> x_, y_, z_, w_;
  raster::Frame frame_;
  std::vector<raster::TileRasterizer> tiles_;
  std::vector<std::uint32_t> picture_;
};

/// Processor time of the process, all its threads: hardly moved by what else the machine does.
double cpu_ms() {
  std::timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e3 + static_cast<double>(now.tv_nsec) * 1e-6;
}

double now_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// What every task of a frame takes when it runs alone: the least over several frames, and what lies between
/// the phases.
class TaskTimes {
 public:
  void frame(Renderer& renderer) {
    phase_ = 0;
    double inside = 0;
    const double start = now_us();
    renderer.draw({1, [&](std::int64_t count, const raster::ParallelFor::Item& item) {
                     if (phase_ == tasks_.size()) tasks_.emplace_back(static_cast<std::size_t>(count), 1e30);
                     std::vector<double>& times = tasks_[phase_++];
                     const double phase_start = now_us();
                     for (std::int64_t i = 0; i < count; ++i) {
                       const double task_start = now_us();
                       item(i, 0);
                       times[static_cast<std::size_t>(i)] =
                           std::min(times[static_cast<std::size_t>(i)], now_us() - task_start);
                     }
                     inside += now_us() - phase_start;
                   }});
    serial_ = std::min(serial_, now_us() - start - inside);
  }
  std::string json() const {
    // Without empty tiles there is no background phase.
    const bool background = tasks_.size() == 5;
    static constexpr const char* kPhases[] = {"transform", "project", "set-up chunks", "background", "tiles"};
    std::string text = fmt::format("{{\"serial_us\":{:.1f}", serial_);
    for (std::size_t i = 0; i < tasks_.size(); ++i)
      text += fmt::format(",\"{}\":[{:.2f}]", kPhases[i + (!background && i == 3)], fmt::join(tasks_[i], ","));
    return text + "}";
  }

 private:
  std::vector<std::vector<double>> tasks_;
  std::size_t phase_ = 0;
  double serial_ = 1e30;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"frames drawn flat, for comparison with other renderers"};
  std::string scene, out, camera = "outside";
  bool tasks = false;
  int width = 1280, height = 720, frames = 20, threads = 1, samples = 1;
  app.add_option("--scene", scene, "synth:grid:N, synth:fill:K or a glTF file")->required();
  app.add_option("--width", width);
  app.add_option("--height", height);
  app.add_option("--frames", frames);
  app.add_option("--threads", threads);
  app.add_option("--msaa", samples)->check(CLI::IsMember({1, 4}));
  app.add_option("--camera", camera);
  app.add_flag("--tasks", tasks, "time every task on one thread instead, microseconds");
  app.add_option("-o", out, "the last frame as PNG");
  CLI11_PARSE(app, argc, argv);
  try {
    const auto synthetic = [&](const std::string& kind) {
      return scene.rfind("synth:" + kind + ":", 0) == 0;
    };
    const auto count = [&] { return std::stoi(scene.substr(scene.rfind(':') + 1)); };
    const Model model = synthetic("grid")   ? grid(count())
                        : synthetic("fill") ? layers(count())
                                            : from_file(scene, camera, static_cast<double>(width) / height);
    host::set_thread_count(threads);
    const raster::ParallelFor parallel = threads == 1 ? raster::serial() : raster::host_threads();
    Renderer renderer(model, {width, height}, samples);
    if (tasks) {
      TaskTimes times;
      for (int i = 0; i < frames; ++i) times.frame(renderer);
      fmt::print("{}\n", times.json());
      return 0;
    }
    std::vector<double> ms, cpu;
    for (int i = 0; i < frames + 3; ++i) {
      const auto start = std::chrono::steady_clock::now();
      const double cpu_start = cpu_ms();
      renderer.draw(parallel);
      if (i < 3) continue;
      cpu.push_back(cpu_ms() - cpu_start);
      ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
    std::sort(ms.begin(), ms.end());
    std::sort(cpu.begin(), cpu.end());
    const std::size_t covered =
        static_cast<std::size_t>(std::count_if(renderer.picture().begin(), renderer.picture().end(),
                                               [](std::uint32_t c) { return c != kBackground; }));
    fmt::print(
        "{{\"scene\":\"{}\",\"threads\":{},\"samples\":{},\"triangles\":{},\"vertices\":{},\"covered_"
        "pixels\":{},\"ms_min\":{:.3f},\"ms_median\":{:.3f},\"cpu_ms_median\":{:.3f}}}\n",
        scene, threads, samples, model.indices.size() / 3, model.x.size(), covered, ms.front(),
        ms[ms.size() / 2], cpu[cpu.size() / 2]);
    if (!out.empty()) {
      host::Image8 image{width, height, 4, std::vector<std::uint8_t>(renderer.picture().size() * 4)};
      std::memcpy(image.texels.data(), renderer.picture().data(), image.texels.size());
      host::write_png(out, image);
    }
  } catch (const UserError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
