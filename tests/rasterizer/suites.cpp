#include "tests/rasterizer/suites.hpp"

#include <cmath>
#include <limits>
#include <numeric>
#include <algorithm>
#include <random>

namespace aluminate::raster::test {
namespace {

/// Uniform numbers by plain arithmetic: std::uniform_real_distribution differs between standard libraries.
class Random {
 public:
  explicit Random(std::uint32_t seed) : engine_(1337u + 7919u * seed) {}
  double real(double low, double high) { return low + (high - low) * (engine_() * 0x1p-32); }
  int integer(int low, int high) { return low + static_cast<int>(engine_() % static_cast<std::uint32_t>(high - low + 1)); }
  bool coin() { return (engine_() & 0x10000u) != 0; }
  std::mt19937& engine() { return engine_; }

 private:
  std::mt19937 engine_;
};

BillRule any_rule(Random& random) {
  using Kind = BillRule::Kind;
  static constexpr Kind kKinds[] = {Kind::Everything, Kind::Hierarchical, Kind::Hierarchical, Kind::PerPixel};
  static constexpr int kBlocks[] = {4, 4, 8, 16};
  return {kKinds[random.integer(0, 3)], kBlocks[random.integer(0, 3)]};
}

SuiteCase start(Random& random, int width, int height) {
  SuiteCase test;
  test.geometry.viewport = {width, height};
  test.bill = any_rule(random);
  return test;
}

/// A jittered grid of quads; no triangle turns over as long as jitter < 1/4 (a corner and the diagonal opposite it move by
/// at most jitter sqrt 2 cells each, and are 1/sqrt 2 apart) over the rectangle, each split along either diagonal, with random windings and starting corners.
void add_mesh(Geometry& g, Random& random, double left, double top, double right, double bottom, int columns, int rows, double jitter) {
  std::vector<std::uint32_t> corner;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) {
      const double dx = (right - left) / columns, dy = (bottom - top) / rows;
      const double px = left + i * dx + (i > 0 && i < columns ? random.real(-jitter, jitter) * dx : 0);
      const double py = top + j * dy + (j > 0 && j < rows ? random.real(-jitter, jitter) * dy : 0);
      corner.push_back(g.add_pixel_vertex(px, py, random.real(0.1, 0.9), random.real(0.5, 4)));
    }
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    std::uint32_t v[3] = {a, b, c};
    if (random.coin()) std::swap(v[0], v[1]);
    std::rotate(v, v + random.integer(0, 2), v + 3);
    g.add_triangle(v[0], v[1], v[2]);
  };
  const auto stride = static_cast<std::uint32_t>(columns + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j)
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
      const std::uint32_t a = corner[j * stride + i], b = corner[j * stride + i + 1], c = corner[(j + 1) * stride + i], d = corner[(j + 1) * stride + i + 1];
      if (random.coin()) add(a, b, d), add(a, d, c);
      else add(a, b, c), add(b, d, c);
    }
}

void add_soup(Geometry& g, Random& random, int count, double size, double margin) {
  for (int i = 0; i < count; ++i) {
    const double cx = random.real(-margin, g.viewport.width + margin), cy = random.real(-margin, g.viewport.height + margin);
    std::uint32_t v[3];
    for (std::uint32_t& corner : v)
      corner = g.add_pixel_vertex(cx + random.real(-size, size), cy + random.real(-size, size), random.real(0, 1), random.real(0.25, 8));
    g.add_triangle(v[0], v[1], v[2]);
  }
}

SuiteCase shared_edge_mesh(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(40, 200), random.integer(40, 200));
  const Viewport& v = test.geometry.viewport;
  add_mesh(test.geometry, random, -8, -8, v.width + 8, v.height + 8, random.integer(1, 24), random.integer(1, 24), 0.2);
  test.geometry.end_draw();
  test.every_sample_once = true;
  return test;
}

SuiteCase random_soup(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(16, 180), random.integer(16, 180));
  add_soup(test.geometry, random, random.integer(20, 150), random.real(2, 90), 20);
  test.geometry.end_draw(static_cast<CullMode>(random.integer(0, 2)));
  test.may_be_empty = true;
  return test;
}

SuiteCase many_layers(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 150, 100);
  for (int layer = 0; layer < 12; ++layer) {
    add_mesh(test.geometry, random, -4, -4, 154, 104, random.integer(1, 5), random.integer(1, 5), 0.2);
    test.geometry.end_draw();
  }
  test.every_sample_covered = true;
  return test;
}

SuiteCase mixed_classes(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(60, 140), random.integer(60, 140));
  Geometry& g = test.geometry;
  for (int i = random.integer(1, 3); i > 0; --i) {
    add_soup(g, random, random.integer(5, 40), random.real(5, 60), 5);
    g.end_draw();
  }
  for (int i = random.integer(1, 3); i > 0; --i) {
    if (random.coin()) add_soup(g, random, random.integer(5, 60), random.real(2, 60), 5);
    else add_mesh(g, random, 5, 5, 55, 55, random.integer(2, 20), random.integer(2, 20), 0.3);
    g.end_draw(CullMode::None, DrawClass::InOrder, true).execute_billed = random.coin();
  }
  for (int i = random.integer(0, 2); i > 0; --i) {
    add_soup(g, random, random.integer(5, 60), random.real(2, 60), 5);
    g.end_draw(CullMode::None, DrawClass::InOrder, false);
  }
  return test;
}

SuiteCase sliver_fan(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 128, 128);
  Geometry& g = test.geometry;
  // A fan around a point far outside or inside: its triangles are slivers, together they cover a polygon once.
  const double cx = random.coin() ? random.real(20, 108) : random.real(-9000, -4000), cy = random.real(20, 108);
  const std::uint32_t centre = g.add_pixel_vertex(cx, cy, random.real(0, 1));
  const int spokes = random.integer(3, 300);
  std::vector<std::uint32_t> rim;
  for (int i = 0; i <= spokes; ++i) {
    const double t = 6.283185307179586 * i / spokes;
    rim.push_back(i == spokes ? rim[0] : g.add_pixel_vertex(64 + 60 * std::cos(t), 64 + 60 * std::sin(t), random.real(0, 1)));
  }
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) g.add_triangle(centre, rim[i], rim[i + 1]);
  g.end_draw();
  return test;
}

SuiteCase needles(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 160, 90);
  for (int i = 0; i < 200; ++i) {
    const double x = random.real(-50, 210), y = random.real(-50, 140);
    const double thin = std::ldexp(random.real(-4, 4), -random.integer(0, 9));
    const std::uint32_t a = test.geometry.add_pixel_vertex(x, y, random.real(0, 1));
    const std::uint32_t b = test.geometry.add_pixel_vertex(x + random.real(-150, 150), y + random.real(-150, 150), random.real(0, 1));
    const std::uint32_t c = test.geometry.add_pixel_vertex(x + thin, y + thin * random.real(-1, 1), random.real(0, 1));
    test.geometry.add_triangle(a, b, c);
  }
  test.geometry.end_draw();
  return test;
}

SuiteCase on_pixel_centres(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 64, 64);
  for (int i = 0; i < 120; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) {
      const double half = random.coin() ? 0.5 : 0.0;  // centres, and corners of pixels
      corner = test.geometry.add_pixel_vertex(random.integer(-4, 68) + half, random.integer(-4, 68) + half, random.real(0, 1));
    }
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw();
  return test;
}

SuiteCase centre_grid_partition(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 64, 48);
  // All vertices and all axis-parallel edges exactly on pixel centres.
  const int step = random.integer(1, 8);
  std::vector<std::uint32_t> corner;
  const int columns = 64 / step + 2, rows = 48 / step + 2;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) corner.push_back(test.geometry.add_pixel_vertex(i * step - step + 0.5, j * step - step + 0.5, 0.5));
  const auto stride = static_cast<std::uint32_t>(columns + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rows); ++j)
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
      const std::uint32_t a = corner[j * stride + i], b = corner[j * stride + i + 1], c = corner[(j + 1) * stride + i], d = corner[(j + 1) * stride + i + 1];
      if (random.coin()) test.geometry.add_triangle(a, b, d), test.geometry.add_triangle(d, c, a);
      else test.geometry.add_triangle(b, a, c), test.geometry.add_triangle(c, d, b);
    }
  test.geometry.end_draw();
  test.every_sample_once = true;
  return test;
}

SuiteCase guard_band(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(20, 120), random.integer(20, 120));
  // Corners on and beyond +-16384 px; shared edges cross the picture.
  static constexpr double kFar[] = {16383, 16384, 16382.99609375, 16383.5, 40000, 1e6, 1e9};
  const auto far = [&] { return (random.coin() ? 1 : -1) * kFar[random.integer(0, 6)]; };
  for (int i = 0; i < 25; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v)
      corner = test.geometry.add_pixel_vertex(random.coin() ? far() : random.real(0, test.geometry.viewport.width),
                                              random.coin() ? far() : random.real(0, test.geometry.viewport.height), random.real(0, 1));
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw();
  test.may_be_empty = true;
  return test;
}

SuiteCase guard_band_partition(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 96, 64);
  // A square as large as the guard band holds, split at a point in the picture: exact, nothing is cut.
  const double e = random.coin() ? 16383 : random.real(200, 16383);
  const std::uint32_t m = test.geometry.add_pixel_vertex(random.real(10, 80), random.real(10, 50), 0.5);
  const std::uint32_t a = test.geometry.add_pixel_vertex(-e, -e, 0.25), b = test.geometry.add_pixel_vertex(e, -e, 0.5);
  const std::uint32_t c = test.geometry.add_pixel_vertex(e, e, 0.75), d = test.geometry.add_pixel_vertex(-e, e, 0.5);
  test.geometry.add_triangle(m, a, b);
  test.geometry.add_triangle(b, m, c);
  test.geometry.add_triangle(c, d, m);
  test.geometry.add_triangle(m, d, a);
  test.geometry.end_draw();
  test.every_sample_once = true;
  return test;
}

SuiteCase degenerate(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 64, 64);
  Geometry& g = test.geometry;
  const auto sub = [&] { return random.integer(0, 64 * 256) / 256.0; };
  for (int i = 0; i < 60; ++i) {
    const double ax = sub(), ay = sub(), dx = random.integer(-2000, 2000) / 256.0, dy = random.integer(-2000, 2000) / 256.0;
    const std::uint32_t a = g.add_pixel_vertex(ax, ay, random.real(0, 1)), b = g.add_pixel_vertex(ax + dx, ay + dy, random.real(0, 1));
    const std::uint32_t line = g.add_pixel_vertex(ax + 2 * dx, ay + 2 * dy, random.real(0, 1));  // twice the area: 0
    const std::uint32_t next = g.add_pixel_vertex(ax + 2 * dx + 1 / 256.0, ay + 2 * dy, random.real(0, 1));
    g.add_triangle(a, b, line);
    g.add_triangle(a, a, b);
    g.add_triangle(a, b, next);
    g.add_triangle(next, b, a);
  }
  // |twice the area| = 1 sub^2: (0,0) (p,q) (r,s) with p s - q r = 1, and a visible one so that the picture is not empty.
  const std::uint32_t o = g.add_pixel_vertex(10.5, 10.5, 0.1);
  const std::uint32_t p = g.add_pixel_vertex(10.5 + 2584 / 256.0, 10.5 + 1597 / 256.0, 0.2);
  const std::uint32_t q = g.add_pixel_vertex(10.5 + 4181 / 256.0, 10.5 + 2584 / 256.0, 0.3);
  g.add_triangle(o, p, q);
  g.add_triangle(q, p, o);
  add_soup(g, random, 4, 20, 0);
  g.end_draw(static_cast<CullMode>(random.integer(0, 2)));
  test.may_be_empty = true;
  return test;
}

SuiteCase sub_pixel(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 48, 48);
  const double size = std::ldexp(1.5, -random.integer(0, 7));
  add_soup(test.geometry, random, 4000, size, 1);
  test.geometry.end_draw();
  test.may_be_empty = true;
  return test;
}

SuiteCase sub_pixel_mesh(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 40, 30);
  add_mesh(test.geometry, random, -1, -1, 41, 31, random.integer(40, 110), random.integer(40, 110), 0.2);
  test.geometry.end_draw();
  test.every_sample_once = true;
  return test;
}

SuiteCase viewport_borders(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(1, 130), random.integer(1, 130));
  // Corners on the borders and half a pixel off: coordinates of exactly W * 256 touch no pixel W.
  const Viewport& v = test.geometry.viewport;
  static constexpr double kOffset[] = {0, 0.5, -0.5, 1 / 256.0, -1 / 256.0, 0.5 - 1 / 256.0};
  const auto pick = [&](int size) { return (random.coin() ? size : 0) + kOffset[random.integer(0, 5)]; };
  for (int i = 0; i < 40; ++i) {
    std::uint32_t c[3];
    for (std::uint32_t& corner : c)
      corner = test.geometry.add_pixel_vertex(random.coin() ? pick(v.width) : random.real(0, v.width), random.coin() ? pick(v.height) : random.real(0, v.height), random.real(0, 1));
    test.geometry.add_triangle(c[0], c[1], c[2]);
  }
  test.geometry.end_draw();
  test.may_be_empty = true;
  return test;
}

SuiteCase odd_size(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 333, 217);
  add_mesh(test.geometry, random, -3, -3, 336, 220, random.integer(1, 40), random.integer(1, 30), 0.3);
  test.geometry.end_draw();
  add_soup(test.geometry, random, 40, 60, 10);
  test.geometry.end_draw(CullMode::None, DrawClass::InOrder, true);
  test.every_sample_covered = true;
  return test;
}

SuiteCase large_viewport(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 7680, 4320);
  test.bill = {BillRule::Kind::Hierarchical, 4};
  add_soup(test.geometry, random, 300, 60, 100);
  const std::uint32_t a = test.geometry.add_pixel_vertex(-10, 4300, 0.2), b = test.geometry.add_pixel_vertex(7700, 4310, 0.8), c = test.geometry.add_pixel_vertex(7690, 4200, 0.3);
  test.geometry.add_triangle(a, b, c);
  test.geometry.end_draw();
  return test;
}

SuiteCase permutations(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 70, 70);
  // The same triangle in its six orders: all but the first lose on equal depth everywhere.
  for (int i = 0; i < 12; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) corner = test.geometry.add_pixel_vertex(random.real(-20, 90), random.real(-20, 90), random.real(0, 1));
    int order[3] = {0, 1, 2};
    std::shuffle(order, order + 3, random.engine());
    std::sort(order, order + 3);
    do test.geometry.add_triangle(v[order[0]], v[order[1]], v[order[2]]);
    while (std::next_permutation(order, order + 3));
  }
  test.geometry.end_draw();
  return test;
}

SuiteCase equal_depth(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 100, 70);
  const double z = random.integer(1, 7) / 8.0;
  for (int i = 0; i < 50; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) corner = test.geometry.add_pixel_vertex(random.real(-10, 110), random.real(-10, 80), z, random.real(0.5, 2));
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw();
  return test;
}

/// A closed box around the eye, seen through a perspective: corners behind the eye have w < 0.
SuiteCase closed_room(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, random.integer(40, 160), random.integer(40, 120));
  Geometry& g = test.geometry;
  const double near = 0.05, far = 100, focal = random.real(0.6, 2.5), aspect = static_cast<double>(g.viewport.width) / g.viewport.height;
  const double yaw = random.real(0, 6.283185307179586), pitch = random.real(-1.3, 1.3);
  const double eye[3] = {random.real(-0.8, 0.8), random.real(-0.8, 0.8), random.real(-0.8, 0.8)};
  const auto project = [&](double px, double py, double pz) {
    const double dx = px - eye[0], dy = py - eye[1], dz = pz - eye[2];
    const double vx = std::cos(yaw) * dx - std::sin(yaw) * dz, z1 = std::sin(yaw) * dx + std::cos(yaw) * dz;
    const double vy = std::cos(pitch) * dy - std::sin(pitch) * z1, vz = std::sin(pitch) * dy + std::cos(pitch) * z1;
    return g.add_vertex(vx * focal / aspect, vy * focal, (vz - near) * far / (far - near), vz);
  };
  const int n = random.integer(1, 6);
  for (int axis = 0; axis < 3; ++axis)
    for (int side = -1; side <= 1; side += 2) {
      std::vector<std::uint32_t> corner;
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          double p[3];
          p[axis] = side;
          p[(axis + 1) % 3] = 2.0 * i / n - 1;
          p[(axis + 2) % 3] = 2.0 * j / n - 1;
          corner.push_back(project(p[0], p[1], p[2]));
        }
      const auto stride = static_cast<std::uint32_t>(n + 1);
      for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(n); ++j)
        for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(n); ++i) {
          g.add_triangle(corner[j * stride + i], corner[j * stride + i + 1], corner[(j + 1) * stride + i]);
          g.add_triangle(corner[(j + 1) * stride + i], corner[j * stride + i + 1], corner[(j + 1) * stride + i + 1]);
        }
    }
  g.end_draw();
  test.every_sample_covered = true;
  return test;
}

SuiteCase depth_range(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 90, 90);
  // Triangles that cross the near and the far plane with w > 0, and exact limits.
  for (int i = 0; i < 60; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) {
      static constexpr double kExact[] = {0, 1, 0.5};
      corner = test.geometry.add_pixel_vertex(random.real(-20, 110), random.real(-20, 110), random.coin() ? random.real(-1, 2) : kExact[random.integer(0, 2)], random.real(0.1, 10));
    }
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw();
  return test;
}

/// Triangles of a few subs around samples (the centre, or one of four), cut by the near or far plane: snapping folds some of their fragments over.
SuiteCase cut_sub_pixel(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 32, 32);
  for (int i = 0; i < 3000; ++i) {
    static constexpr double kX[] = {128, 128, 128, 128, 96, 224, 32, 160}, kY[] = {128, 128, 128, 128, 32, 96, 160, 224};
    const int place = random.integer(0, 7);
    const double cx = random.integer(0, 31) + kX[place] / 256, cy = random.integer(0, 31) + kY[place] / 256;
    std::uint32_t v[3];
    for (std::uint32_t& corner : v)
      corner = test.geometry.add_pixel_vertex(cx + random.real(-5, 5) / 256, cy + random.real(-5, 5) / 256, random.real(-1, 2));
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw(static_cast<CullMode>(random.integer(0, 2)));
  return test;
}

SuiteCase interpenetration(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 128, 96);
  for (int i = 0; i < 10; ++i) {
    std::uint32_t v[3];
    for (std::uint32_t& corner : v) corner = test.geometry.add_pixel_vertex(random.real(-100, 230), random.real(-100, 200), 0.5 + random.real(-1, 1) * std::ldexp(1.0, -random.integer(1, 22)));
    test.geometry.add_triangle(v[0], v[1], v[2]);
  }
  test.geometry.end_draw();
  test.may_be_empty = true;
  return test;
}

SuiteCase t_junctions(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 64, 64);
  Geometry& g = test.geometry;
  // The long edge's other side has a corner on it. Snapped collinear (multiples of 1/256 px along an axis or 45 degrees):
  // still a partition. Anything else may crack, and then both sides must crack alike.
  const bool exact = random.coin();
  const double k = exact ? random.integer(1, 16383) / 256.0 : random.real(1, 63);
  const bool diagonal = random.coin();
  const std::uint32_t a = g.add_pixel_vertex(-10, diagonal ? -10 : 20.5, 0.5), b = g.add_pixel_vertex(74, diagonal ? 74 : exact ? 20.5 : 33, 0.5);
  const double on_y = diagonal ? k : 20.5 + (exact ? 0 : (k + 10) / 84 * 12.5);
  const std::uint32_t m = g.add_pixel_vertex(k, on_y, 0.5);
  const std::uint32_t up = g.add_pixel_vertex(200, -300, 0.5), down = g.add_pixel_vertex(-200, 300, 0.5);
  g.add_triangle(a, b, up);
  g.add_triangle(a, m, down);
  g.add_triangle(m, b, down);
  g.end_draw();
  return test;
}

SuiteCase not_finite(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 64, 64);
  static const double kBad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                                1e308, -1e308, std::numeric_limits<double>::denorm_min(), 0.0, -0.0, 1e-300};
  add_soup(test.geometry, random, 60, 25, 5);
  Geometry& g = test.geometry;
  for (int i = 0; i < 60; ++i) {
    const std::size_t vertex = static_cast<std::size_t>(random.integer(0, static_cast<int>(g.x.size()) - 1));
    std::vector<double>* component[] = {&g.x, &g.y, &g.z, &g.w};
    (*component[random.integer(0, 3)])[vertex] = kBad[random.integer(0, 8)];
  }
  g.end_draw();
  test.may_be_empty = true;
  return test;
}

SuiteCase any_clip_space(std::uint32_t seed) {
  Random random(seed);
  SuiteCase test = start(random, 72, 56);
  for (int i = 0; i < 150; ++i) {
    for (int k = 0; k < 3; ++k) test.geometry.add_vertex(random.real(-4, 4), random.real(-4, 4), random.real(-1, 2), random.real(-1, 3));
    const auto n = static_cast<std::uint32_t>(test.geometry.x.size());
    test.geometry.add_triangle(n - 3, n - 2, n - 1);
  }
  test.geometry.end_draw(static_cast<CullMode>(random.integer(0, 2)));
  test.may_be_empty = true;
  return test;
}

constexpr Suite kSuites[] = {
    {"shared-edge-mesh", "a jittered mesh covers every pixel exactly once", shared_edge_mesh},
    {"random-soup", "triangles of all sizes, all cull modes", random_soup},
    {"many-layers", "overdraw: hierarchical depth and the bill", many_layers},
    {"mixed-classes", "opaque, masked and blended draws in one frame", mixed_classes},
    {"sliver-fan", "fans of slivers around near and far points", sliver_fan},
    {"needles", "triangles thinner than a pixel, down to 1/256", needles},
    {"on-pixel-centres", "corners exactly on pixel centres and pixel corners", on_pixel_centres},
    {"centre-grid-partition", "edges through pixel centres: each pixel still once", centre_grid_partition},
    {"guard-band", "corners at and beyond 16384 px", guard_band},
    {"guard-band-partition", "the largest uncut square, split in the picture", guard_band_partition},
    {"degenerate", "twice the area 0 and 1, both windings", degenerate},
    {"sub-pixel", "soup of triangles below a pixel", sub_pixel},
    {"sub-pixel-mesh", "a mesh finer than the pixels, each pixel once", sub_pixel_mesh},
    {"viewport-borders", "corners on the borders of pictures of any size", viewport_borders},
    {"odd-size", "333x217: partial quads, stamps and tiles", odd_size},
    {"large-viewport", "7680x4320", large_viewport},
    {"permutations", "six ways to submit a triangle", permutations},
    {"equal-depth", "the first submitted wins", equal_depth},
    {"closed-room", "near plane through a closed box: no background", closed_room},
    {"depth-range", "near and far plane crossings, depth exactly 0 and 1", depth_range},
    {"cut-sub-pixel", "fragments of a few subs, folded over by snapping", cut_sub_pixel},
    {"interpenetration", "planes that cross at shallow angles", interpenetration},
    {"t-junctions", "corners on a neighbour's edge", t_junctions},
    {"not-finite", "NaN, infinities, overflow, w = 0", not_finite},
    {"any-clip-space", "corners anywhere, w of both signs", any_clip_space},
};

}  // namespace

std::span<const Suite> suites() { return kSuites; }

void use_samples(SuiteCase& test, int samples, std::uint32_t seed) {
  test.geometry.samples = samples;
  // At four samples the console's block of 16 samples is a quad: half of the cases use it.
  if (samples == 4 && seed % 2 == 0 && test.bill.block_px == 4) test.bill.block_px = 2;
}

}  // namespace aluminate::raster::test
