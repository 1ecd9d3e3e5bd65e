// The texture unit on vectors, one quad after the other. Same integers as texture_unit_reference.cpp.
// Volumes, which no shipped shader samples, go to the reference.
#include "shading/vm/texture_unit.hpp"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/vm/texture_unit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <bit>

#if HWY_TARGET != HWY_SCALAR
#include "shading/vm/texture_detail-inl.hpp"
#include "shading/vm/texture_filter-inl.hpp"
#endif

HWY_BEFORE_NAMESPACE();
namespace aluminate::vm {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// One lane at a time there is nothing to gain.
FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                      const number::Grid& grid, const std::array<double*, 4>& results) {
  return fetch_reference(binding, request, masked, grid, results);
}

#else

HWY_INLINE QV fold(Address mode, QV u) {
  const QV one = hn::Set(Q(), 1.0);
  switch (mode) {
    case Address::Wrap:
      return hn::Sub(u, floor_of(u));
    case Address::Clamp: {
      const QV low = hn::IfThenElse(hn::Lt(u, hn::Zero(Q())), hn::Zero(Q()), u);
      return hn::IfThenElse(hn::Gt(low, one), one, low);
    }
    case Address::Mirror:
      break;
  }
  const QV two = hn::Set(Q(), 2.0);
  const QV t = hn::Sub(u, hn::Mul(two, floor_of(hn::Mul(hn::Set(Q(), 0.5), u))));
  return hn::IfThenElse(hn::Gt(t, one), hn::Sub(two, t), t);
}

// The fetch of one texture: what its quads share. kTexelBytes 4: codes of 8 bits, 8:
// Texture::filter_texels(). kFaces: a cube.
template <std::size_t kTexelBytes, bool kFaces>
class Fetch64 {
 public:
  Fetch64(const SamplerBinding& binding, const FetchRequest& request, bool masked, const number::Grid& grid,
          const std::array<double*, 4>& results)
      : texture_(*binding.texture),
        mode_u_(kFaces ? Address::Clamp : binding.state.u),
        mode_v_(kFaces ? Address::Clamp : binding.state.v),
        exec_(request.exec),
        results_(results) {
    choose_levels(binding, request, choices_);
    if constexpr (kFaces) find_faces(request, faces_);
    u_ = kFaces ? faces_.u : request.rows[0];
    v_ = kFaces ? faces_.v : request.rows[1];
    hn::Store(hn::Set(Q64I(), std::bit_cast<std::int64_t>(number::kToInteger)), Q64I(), to_number_);
    hn::Store(hn::Set(Q(), grid.magic), Q(), magic_);
    masked_ = masked;
  }

  FetchCost run(std::uint64_t covered) {
    for (std::size_t i = 0; i < 64; i += kQuadStep) {
      const std::uint64_t lanes = exec_ >> i & kAll;
      if (lanes == 0) {  // nobody reads these lanes, but they stay numbers
        if (!masked_) put_zeros(i);
        continue;
      }
      // Read before anything is written: result rows may be coordinate rows.
      const QV u = hn::LoadU(Q(), u_ + i), v = hn::LoadU(Q(), v_ + i);
      if (choices_.lanes_each == 4) {
        const std::size_t quad = i / 4;
        const std::int64_t fraction = choices_.fraction[quad];
        add_jobs(u, v, i, quad, masked_ ? lanes : kAll, choices_.key[quad], fraction == 0 ? 0 : kAll,
                 hn::Set(Q64I(), fraction));
      } else {
        add_groups(u, v, i, lanes);
      }
    }
    finish_jobs();
    return cost_of(exec_ & covered);
  }

 private:
  static constexpr std::uint64_t kAll = (1u << kQuadStep) - 1;
  static constexpr double kOfCode = kTexelBytes == 4 ? 257.0 : 1.0;  // linear16 of a code
  static constexpr double kOffset =
      kTexelBytes == 4 ? 0.0 : 0x1p39;  // 32768 * 2^24, see Texture::filter_texels()

  // One filtered sample of lanes [first, first + kQuadStep), the last of `probes` writes those in `lanes`.
  struct Job {
    Taps<kTexelBytes> fine, coarse;
    alignas(32) std::int64_t fraction[kQuadStep];  // weight of coarse
    std::size_t first;
    std::uint64_t lanes;
    int probes;
    bool is_linear, is_blended;
  };
  static constexpr std::size_t kJobs = 64 / kQuadStep;
  static_assert(kMostProbes <= kJobs);

  // The probes of a group. blended: lanes whose fraction is not 0.
  HWY_INLINE void add_jobs(QV u, QV v, std::size_t i, std::size_t entry, std::uint64_t lanes,
                           std::int64_t key, std::uint64_t blended, hn::Vec<Q64I> fraction) {
    if (HWY_UNLIKELY(key != key_)) set_levels(key);
    blended_ |= blended << i;
    const int probes = probes_of_key(key);
    if (HWY_LIKELY(probes == 1)) {
      if (HWY_UNLIKELY(job_count_ == kJobs)) finish_jobs();
      return add_job(u, v, i, lanes, 1, blended != 0, fraction);
    }
    if (job_count_ + static_cast<std::size_t>(probes) > kJobs) finish_jobs();
    const bool is_shared = choices_.lanes_each == 4;
    const QV du = is_shared ? hn::Set(Q(), choices_.du[entry]) : hn::LoadU(Q(), choices_.du + entry);
    const QV dv = is_shared ? hn::Set(Q(), choices_.dv[entry]) : hn::LoadU(Q(), choices_.dv + entry);
    for (int n = 0; n < probes; ++n) {
      const QV offset = hn::Set(Q(), probe_offset(n, probes));
      add_job(hn::Add(u, hn::Mul(offset, du)), hn::Add(v, hn::Mul(offset, dv)), i, lanes, probes,
              blended != 0, fraction);
    }
  }

  HWY_INLINE void add_job(QV u, QV v, std::size_t i, std::uint64_t lanes, int probes, bool is_blended,
                          hn::Vec<Q64I> fraction) {
    const std::size_t index = job_count_++;
    Job& job = jobs_[index];
    job.first = i;
    job.lanes = lanes;
    job.probes = probes;
    job.is_linear = is_linear_;
    job.is_blended = is_blended;
    hn::Store(fraction, Q64I(), job.fraction);
    const QV folded_u = fold(mode_u_, u), folded_v = fold(mode_v_, v);
    is_linear_ ? locate_job<true>(folded_u, folded_v, i, index)
               : locate_job<false>(folded_u, folded_v, i, index);
  }

  template <bool kLinear>
  HWY_INLINE void locate_job(QV u, QV v, std::size_t i, std::size_t index) {
    Job& job = jobs_[index];
    const std::int64_t* const faces = faces_.face + i;
    locate<kTexelBytes, kFaces, kLinear>(constants_, levels_[0], u, v, faces, edges_[index][0], job.fine);
    if (job.is_blended)
      locate<kTexelBytes, kFaces, kLinear>(constants_, levels_[1], u, v, faces, edges_[index][1], job.coarse);
  }

  // Lanes of different levels: a job for each.
  HWY_NOINLINE void add_groups(QV u, QV v, std::size_t i, std::uint64_t open) {
    if (!masked_) put_zeros(i);
    while (open != 0) {
      const std::int64_t key = choices_.key[i + static_cast<std::size_t>(std::countr_zero(open))];
      std::uint64_t group = 0, blended = 0;
      for (std::size_t k = 0; k < kQuadStep; ++k) {
        group |= std::uint64_t{choices_.key[i + k] == key} << k;
        blended |= std::uint64_t{choices_.fraction[i + k] != 0} << k;
      }
      group &= open;
      open &= ~group;
      add_jobs(u, v, i, i, group, key, blended & group, hn::Load(Q64I(), choices_.fraction + i));
    }
  }

  HWY_NOINLINE void finish_jobs() {
    for (std::size_t index = 0; index < job_count_;) {
      const Job& job = jobs_[index];
      Sums sums = job.is_linear ? sums_of<true>(job) : sums_of<false>(job);
      for (int n = 1; n < job.probes; ++n) {  // |sums| <= 16 * 2^39
        const Job& probe = jobs_[index + static_cast<std::size_t>(n)];
        sums = sum_of(sums, probe.is_linear ? sums_of<true>(probe) : sums_of<false>(probe));
      }
      index += static_cast<std::size_t>(job.probes);
      if (HWY_LIKELY(job.lanes == kAll)) {
        put_channels(sums, job.probes, job.first, results_);
      } else {
        put_some(sums, job);
      }
    }
    job_count_ = 0;
  }

  template <bool kLinear>
  HWY_INLINE Sums sums_of(const Job& job) const {
    const Channels fine = filtered<kTexelBytes, kLinear>(constants_, job.fine);
    const auto one = hn::Set(Q64I(), 256);
    if (!job.is_blended) return weighted(fine, one);
    const auto fraction = hn::Load(Q64I(), job.fraction);
    return sum_of(weighted(fine, hn::Sub(one, fraction)),
                  weighted(filtered<kTexelBytes, kLinear>(constants_, job.coarse), fraction));
  }

  HWY_NOINLINE void put_some(const Sums& sums, const Job& job) const {
    alignas(32) double texels[4][kQuadStep];
    std::array<double*, 4> rows{};
    for (std::size_t c = 0; c < 4; ++c) rows[c] = results_[c] == nullptr ? nullptr : texels[c];
    put_channels(sums, job.probes, 0, rows);
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t k = 0; k < kQuadStep; ++k)
        if (rows[c] != nullptr && (job.lanes >> k & 1) != 0) results_[c][job.first + k] = texels[c][k];
  }

  FetchCost cost_of(std::uint64_t billed) const {
    const auto count = [](std::uint64_t lanes) { return static_cast<std::uint64_t>(std::popcount(lanes)); };
    FetchCost cost{count(billed), count(billed) + count(billed & blended_)};
    if (!choices_.is_anisotropic) return cost;
    cost.cycles = 0;
    for (std::size_t lane = 0; lane < 64; ++lane)
      if ((billed >> lane & 1) != 0)
        cost.cycles += static_cast<std::uint64_t>(probes_of_key(choices_.key[lane / choices_.lanes_each])) *
                       ((blended_ >> lane & 1) != 0 ? 2 : 1);
    return cost;
  }

  HWY_NOINLINE void set_levels(std::int64_t key) {
    key_ = key;
    is_linear_ = is_linear_key(key);
    const std::size_t index = level_of_key(key);
    set_level(index, levels_[0]);
    if (index + 1 < texture_.levels().size()) set_level(index + 1, levels_[1]);
  }

  void set_level(std::size_t index, FilterLevel& to) const {
    const MipLevel& mip = texture_.levels()[index];
    const void* const texels =
        kTexelBytes == 4 ? static_cast<const void*>(mip.codes8.data()) : texture_.filter_texels(index);
    to.width = mip.width;
    to.height = mip.height;
    to.pitch = kTexelBytes * static_cast<std::size_t>(mip.width);
    to.slice = to.pitch * static_cast<std::size_t>(mip.height);
    to.wraps_u = mode_u_ == Address::Wrap;
    to.wraps_v = mode_v_ == Address::Wrap;
    hn::Store(hn::Set(Q64(), reinterpret_cast<std::uintptr_t>(texels)), Q64(), to.texels);
    hn::Store(hn::Set(Q(), 256.0 * mip.width), Q(), to.scale_u);
    hn::Store(hn::Set(Q(), 256.0 * mip.height), Q(), to.scale_v);
    const auto alternating = [](std::int32_t x, std::int32_t y, std::int32_t* pairs) HWY_ATTR {
      hn::Store(hn::OddEven(hn::Set(Q32(), y), hn::Set(Q32(), x)), Q32(), pairs);
    };
    constexpr std::int32_t kBias = -0x7fffffff - 1;
    alternating(kTexelBytes, static_cast<std::int32_t>(to.pitch), to.step);
    alternating(kBias + mip.width - 1, kBias + mip.height - 1, to.inside);
  }

  HWY_INLINE void put_channels(const Sums& sums, int probes, std::size_t to,
                               const std::array<double*, 4>& rows) const {
    // What the conversion below subtracts: the shift, and one offset a probe.
    const QV offset = hn::Set(Q(), kOffset * probes - number::kToInteger * kOfCode);
    const QV scale = hn::Set(Q(), texel_scale(probes));
    put<0>(sums, offset, scale, to, rows[0]);
    put<1>(sums, offset, scale, to, rows[1]);
    put<2>(sums, offset, scale, to, rows[2]);
    put<3>(sums, offset, scale, to, rows[3]);
  }

  // To binary64, to a sum scaled by 65535 * 2^24, both exact; then one rounding to the grid: texel_value().
  template <std::size_t kChannel>
  HWY_INLINE void put(const Sums& sums, QV offset, QV scale, std::size_t to, double* row) const {
    if (row == nullptr) return;
    const QV shifted = hn::BitCast(Q(), hn::Add(sums.channel<kChannel>(), hn::Load(Q64I(), to_number_)));
    const QV sum = kOfCode == 1.0 ? hn::Add(shifted, offset) : fma(shifted, hn::Set(Q(), kOfCode), offset);
    const QV magic = hn::Load(Q(), magic_);
    hn::StoreU(hn::Sub(fma(sum, scale, magic), magic), Q(), row + to);
  }

  void put_zeros(std::size_t i) const {
    for (double* const row : results_)
      if (row != nullptr) hn::StoreU(hn::Zero(Q()), Q(), row + i);
  }

  const Texture& texture_;
  Address mode_u_, mode_v_;
  bool masked_;
  bool is_linear_ = false;
  std::uint64_t exec_;
  std::uint64_t blended_ = 0;  // lanes that took two levels
  std::int64_t key_ = -1;      // what levels_ holds
  const double* u_;
  const double* v_;
  std::array<double*, 4> results_;
  alignas(32) std::int64_t to_number_[4];
  alignas(32) double magic_[4];
  FilterConstants constants_;
  FilterLevel levels_[2];
  LevelChoices choices_;
  FaceLanes faces_;
  std::size_t job_count_ = 0;
  Job jobs_[kJobs];
  EdgeTexels<kTexelBytes> edges_[kJobs][2];  // fine and coarse
};

template <std::size_t kTexelBytes, bool kFaces>
FetchCost fetch_as(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                   const number::Grid& grid, const std::array<double*, 4>& results) {
  return Fetch64<kTexelBytes, kFaces>(binding, request, masked, grid, results).run(request.covered);
}

FetchCost fetch_lanes(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                      const number::Grid& grid, const std::array<double*, 4>& results) {
  const bool is_wide = binding.texture->has_filter_texels();
  const auto fetch = request.dimension == SamplerDimension::TexCube
                         ? (is_wide ? fetch_as<8, true> : fetch_as<4, true>)
                         : (is_wide ? fetch_as<8, false> : fetch_as<4, false>);
  return fetch(binding, request, masked, grid, results);
}

#endif  // HWY_TARGET == HWY_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace aluminate::vm
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace aluminate::vm {
HWY_EXPORT(fetch_lanes);

FetchCost fetch(const SamplerBinding& binding, const FetchRequest& request, bool masked,
                const number::Grid& grid, const std::array<double*, 4>& results) noexcept {
  if (!has_shape(binding.texture, request.dimension) || request.dimension == SamplerDimension::Tex3D)
    return fetch_reference(binding, request, masked, grid, results);
  return HWY_DYNAMIC_DISPATCH(fetch_lanes)(binding, request, masked, grid, results);
}

}  // namespace aluminate::vm
#endif
