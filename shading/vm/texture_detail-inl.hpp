// Which mip levels each quad or lane samples, in vectors: the definitions of texture_unit_reference.cpp,
// operation by operation.
//   in   a fetch and the level-0 size of its texture
//   out  LevelChoices: one choice a quad for an implicit level of detail, one a lane otherwise
// Included once per instruction set, see simd_lanes-inl.hpp.
#if defined(ALUMINATE_TEXTURE_DETAIL) == defined(HWY_TARGET_TOGGLE)
#ifdef ALUMINATE_TEXTURE_DETAIL
#undef ALUMINATE_TEXTURE_DETAIL
#else
#define ALUMINATE_TEXTURE_DETAIL
#endif

#include <bit>

#include "shading/vm/cube_map.hpp"
#include "shading/vm/simd_lanes-inl.hpp"
#include "shading/vm/texture_unit.hpp"

#ifndef ALUMINATE_TEXTURE_CHOICES
#define ALUMINATE_TEXTURE_CHOICES
namespace aluminate::vm {

// One choice for `lanes_each` lanes: entry lane / lanes_each.
struct LevelChoices {
  alignas(64) std::int64_t key[64];       // 64 * probes + 2 * level + (1 if linear)
  alignas(64) std::int64_t fraction[64];  // weight of the next level, 0..255
  alignas(64) double du[64], dv[64];      // longer axis of the footprint; only if is_anisotropic
  std::size_t lanes_each = 1;             // 4 or 1
  bool is_anisotropic = false;
};

constexpr std::size_t level_of_key(std::int64_t key) { return static_cast<std::size_t>(key >> 1 & 31); }
constexpr bool is_linear_key(std::int64_t key) { return (key & 1) != 0; }
constexpr int probes_of_key(std::int64_t key) { return static_cast<int>(key >> 6); }

// Where each lane of a cube fetch looks: its place on a face.
struct FaceLanes {
  alignas(64) double u[64];
  alignas(64) double v[64];
  alignas(64) std::int64_t face[64];
};

}  // namespace aluminate::vm
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {

using I = hn::RebindToSigned<D>;

HWY_INLINE V rounded(V x) {
  const V to_integer = constant(number::kToInteger);
  return hn::Sub(hn::Add(x, to_integer), to_integer);
}

// An integer in binary64, as one.
HWY_INLINE hn::Vec<I> integer(V x) {
  const V to_integer = constant(number::kToInteger);
  return hn::Sub(hn::BitCast(I(), hn::Add(x, to_integer)), hn::BitCast(I(), to_integer));
}

// lod_of_square(), as a number.
HWY_INLINE V detail_of_square(V rho2) {
  const V bounded = greater_of(less_of(rho2, constant(0x1p60)), constant(0x1p-60));
  return rounded(hn::Mul(constant(128.0), log2_unrounded<true>(bounded)));
}

// Derivatives of (u, v) along both axes of the screen.
struct Gradients {
  V du_dx, dv_dx, du_dy, dv_dy;
};
// Squares of their lengths in texels.
struct Squares {
  V along_x, along_y;
};
HWY_INLINE Squares squares_of(const Gradients& g, V width, V height) {
  const V ux = hn::Mul(g.du_dx, width), vx = hn::Mul(g.dv_dx, height);
  const V uy = hn::Mul(g.du_dy, width), vy = hn::Mul(g.dv_dy, height);
  return {hn::Add(hn::Mul(ux, ux), hn::Mul(vx, vx)), hn::Add(hn::Mul(uy, uy), hn::Mul(vy, vy))};
}

// to_lod().
HWY_INLINE V explicit_detail(V level) {
  return rounded(hn::Mul(constant(256.0), greater_of(less_of(level, constant(1024.0)), constant(-1024.0))));
}

struct Direction3 {
  V x, y, z;
};
HWY_INLINE Direction3 step_between(const Direction3& from, const Direction3& to) {
  return {hn::Sub(to.x, from.x), hn::Sub(to.y, from.y), hn::Sub(to.z, from.z)};
}

// cube_face() as masks, and in_face() of any direction for that face.
class Face {
 public:
  explicit HWY_INLINE Face(const Direction3& d) {
    const V x = hn::Abs(d.x), y = hn::Abs(d.y), z = hn::Abs(d.z);
    is_z_ = hn::And(hn::Ge(z, x), hn::Ge(z, y));
    is_y_ = hn::AndNot(is_z_, hn::Ge(y, x));
    is_negative_ = hn::Lt(along(d), hn::Zero(D()));
  }

  HWY_INLINE hn::Vec<I> index() const {
    const V axis = hn::IfThenElse(is_z_, constant(4.0), hn::IfThenElseZero(is_y_, constant(2.0)));
    const V face = hn::Add(axis, hn::IfThenElseZero(is_negative_, constant(1.0)));
    return integer(face);
  }

  // s, t, m of in_face().
  HWY_INLINE Direction3 frame(const Direction3& d) const {
    const V s_x = negated_where(hn::Not(is_negative_), d.z), s_z = negated_where(is_negative_, d.x);
    const V s = hn::IfThenElse(is_z_, s_z, hn::IfThenElse(is_y_, d.x, s_x));
    const V t = hn::IfThenElse(is_y_, negated_where(is_negative_, d.z), hn::Neg(d.y));
    return {s, t, negated_where(is_negative_, along(d))};
  }

 private:
  HWY_INLINE V along(const Direction3& d) const {
    return hn::IfThenElse(is_z_, d.z, hn::IfThenElse(is_y_, d.y, d.x));
  }
  static HWY_INLINE V negated_where(M where, V x) { return hn::IfThenElse(where, hn::Neg(x), x); }

  M is_z_, is_y_, is_negative_;
};

// Derivatives on the face of `at`, by face_step().
HWY_INLINE Gradients face_gradients(const Direction3& at, const Direction3& along_x,
                                    const Direction3& along_y) {
  const Face face(at);
  const Direction3 here = face.frame(at);
  const M none = hn::Eq(here.z, hn::Zero(D()));
  const V scale = hn::Div(constant(0.5), hn::Mul(here.z, here.z));
  const auto change = [&](V by, V by_m, V at_s) HWY_ATTR {
    const V cross = hn::Sub(hn::Mul(by, here.z), hn::Mul(at_s, by_m));
    return hn::IfThenZeroElse(none, hn::Mul(cross, scale));
  };
  const Direction3 x = face.frame(along_x), y = face.frame(along_y);
  return {change(x.x, x.z, here.x), change(x.y, x.z, here.y), change(y.x, y.z, here.x),
          change(y.y, y.z, here.y)};
}

// face_point() of all lanes.
void find_faces(const FetchRequest& request, FaceLanes& lanes) {
  for (std::size_t i = 0; i < 64; i += hn::Lanes(D())) {
    const Direction3 d = {hn::LoadU(D(), request.rows[0] + i), hn::LoadU(D(), request.rows[1] + i),
                          hn::LoadU(D(), request.rows[2] + i)};
    const Face face(d);
    const Direction3 f = face.frame(d);
    const V half = constant(0.5);
    const M none = hn::Eq(f.z, hn::Zero(D()));
    const auto place = [&](V s) HWY_ATTR {
      return hn::IfThenElse(none, half, hn::Add(hn::Mul(half, hn::Div(s, f.z)), half));
    };
    hn::Store(place(f.x), D(), lanes.u + i);
    hn::Store(place(f.y), D(), lanes.v + i);
    hn::Store(face.index(), I(), lanes.face + i);
  }
}

// choose_mip() without a branch: all values are integers in binary64.
class LevelChooser {
 public:
  LevelChooser(const SamplerState& state, std::size_t levels)
      : last_(constant(state.mipmapped ? 256.0 * static_cast<double>(levels - 1) : 0.0)),
        magnify_(constant(state.magnify == Filter::Linear ? 1.0 : 0.0)),
        minify_(constant(state.minify == Filter::Linear ? 1.0 : 0.0)),
        is_nearest_(state.mip == Filter::Point) {}

  HWY_INLINE void choose(V lod, V probes, std::size_t entry, LevelChoices& choices) const {
    V place = less_of(greater_of(lod, hn::Zero(D())), last_);
    if (is_nearest_) {
      const V level = floor_of(hn::Mul(hn::Add(place, constant(128.0)), constant(0x1p-8)));
      place = less_of(hn::Mul(level, constant(256.0)), last_);
    }
    const V level = floor_of(hn::Mul(place, constant(0x1p-8)));
    const V filter = hn::IfThenElse(hn::Gt(lod, hn::Zero(D())), minify_, magnify_);
    const V key = hn::Add(hn::Mul(constant(64.0), probes), hn::Add(hn::Add(level, level), filter));
    hn::Store(integer(key), I(), choices.key + entry);
    hn::Store(integer(hn::Sub(place, hn::Mul(level, constant(256.0)))), I(), choices.fraction + entry);
  }

 private:
  V last_, magnify_, minify_;
  bool is_nearest_;
};

// Derivatives of quads [first, first + Lanes(D)): differences of lanes 1 - 0 and 2 - 0.
HWY_INLINE Gradients quad_gradients(const FetchRequest& request, std::size_t first) {
  const auto row = [&](std::size_t r, V& at, V& x, V& y) HWY_ATTR {
    V unused;
    hn::LoadInterleaved4(D(), request.rows[r] + 4 * first, at, x, y, unused);
  };
  Direction3 at, x, y;
  row(0, at.x, x.x, y.x);
  row(1, at.y, x.y, y.y);
  if (request.dimension != SamplerDimension::TexCube)
    return {hn::Sub(x.x, at.x), hn::Sub(x.y, at.y), hn::Sub(y.x, at.x), hn::Sub(y.y, at.y)};
  row(2, at.z, x.z, y.z);
  return face_gradients(at, step_between(at, x), step_between(at, y));
}

// texgrad: derivatives of each lane.
HWY_INLINE Gradients lane_gradients(const FetchRequest& request, std::size_t i) {
  const auto row = [&](std::size_t r) HWY_ATTR { return hn::LoadU(D(), request.rows[r] + i); };
  if (request.dimension != SamplerDimension::TexCube) return {row(2), row(3), row(4), row(5)};
  return face_gradients({row(0), row(1), row(2)}, {row(3), row(4), row(5)}, {row(6), row(7), row(8)});
}

// footprint_of() of one vector: its longer axis, its probes, the square of a probe's share.
HWY_INLINE V footprints_of(const Gradients& g, const Squares& squares, int max_anisotropy, std::size_t entry,
                           double* probe_counts, LevelChoices& choices) {
  const M is_x = hn::Ge(squares.along_x, squares.along_y);
  const V longer = hn::IfThenElse(is_x, squares.along_x, squares.along_y);
  const V least = greater_of(hn::IfThenElse(is_x, squares.along_y, squares.along_x), constant(1.0));
  V probes = constant(1.0);
  for (int n = 1; n < max_anisotropy; ++n) {
    const M is_short = hn::Lt(hn::Mul(constant(static_cast<double>(n * n)), least), longer);
    probes = hn::Add(probes, hn::IfThenElseZero(is_short, constant(1.0)));
  }
  hn::Store(probes, D(), probe_counts + entry);
  hn::Store(hn::IfThenElse(is_x, g.du_dx, g.du_dy), D(), choices.du + entry);
  hn::Store(hn::IfThenElse(is_x, g.dv_dx, g.dv_dy), D(), choices.dv + entry);
  return hn::Mul(longer, hn::Div(constant(1.0), hn::Mul(probes, probes)));
}

// In several passes, because one entry's chain of dependent steps is longer than a core looks ahead.
void choose_levels(const SamplerBinding& binding, const FetchRequest& request, LevelChoices& choices) {
  constexpr std::size_t kStep = hn::MaxLanes(D());
  const MipLevel& base = binding.texture->levels().front();
  const V width = constant(base.width), height = constant(base.height);
  const LevelChooser chooser(binding.state, binding.texture->levels().size());
  const int max_anisotropy = most_probes(binding.state, request);
  const double* const level = request.rows[coordinate_count(request.dimension)];
  alignas(64) double lods[64], probes[64];
  choices.is_anisotropic = max_anisotropy > 1;
  std::size_t count = request.op == Opcode::TexGrad || request.op == Opcode::TexLod ? 64 : 16;
  if (request.op != Opcode::TexLod) {
    for (std::size_t i = 0; i < count; i += kStep) {
      const Gradients g = count == 64 ? lane_gradients(request, i) : quad_gradients(request, i);
      const Squares squares = squares_of(g, width, height);
      const V square = choices.is_anisotropic ? footprints_of(g, squares, max_anisotropy, i, probes, choices)
                                              : greater_of(squares.along_x, squares.along_y);
      hn::Store(square, D(), lods + i);
    }
    for (std::size_t i = 0; i < count; i += kStep)
      hn::Store(detail_of_square(hn::Load(D(), lods + i)), D(), lods + i);
  }
  if (request.op == Opcode::TexLod || request.op == Opcode::TexBias) {
    for (std::size_t lane = 64; request.op == Opcode::TexBias && lane-- > 0;) {  // from quads to lanes
      lods[lane] = lods[lane / 4];
      if (!choices.is_anisotropic) continue;
      probes[lane] = probes[lane / 4];
      choices.du[lane] = choices.du[lane / 4];
      choices.dv[lane] = choices.dv[lane / 4];
    }
    for (std::size_t i = 0; i < 64; i += kStep) {
      const V lod = explicit_detail(hn::LoadU(D(), level + i));
      hn::Store(request.op == Opcode::TexLod ? lod : hn::Add(hn::Load(D(), lods + i), lod), D(), lods + i);
    }
    count = 64;
  }
  choices.lanes_each = 64 / count;
  for (std::size_t i = 0; i < count; i += kStep)
    chooser.choose(hn::Load(D(), lods + i),
                   choices.is_anisotropic ? hn::Load(D(), probes + i) : constant(1.0), i, choices);
}

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#endif
