#include "shading/vm/srgb.hpp"

#include <gtest/gtest.h>
#include <mpfr.h>

#include <cmath>

namespace aluminate::vm {
namespace {

// decode(numerator / denominator) times scale, to 160 bits, compared with or rounded to what the tables hold.
class ExactDecode {
 public:
  ExactDecode(long numerator, long denominator) {
    mpfr_inits2(160, s_, t_, nullptr);
    mpfr_set_si(s_, numerator, MPFR_RNDN);
    mpfr_div_si(s_, s_, denominator, MPFR_RNDN);
    if (numerator * 100000 <= 4045 * denominator) {  // s <= 0.04045
      mpfr_mul_si(s_, s_, 100, MPFR_RNDN);
      mpfr_div_si(s_, s_, 1292, MPFR_RNDN);
    } else {
      mpfr_set_si(t_, 55, MPFR_RNDN);
      mpfr_div_si(t_, t_, 1000, MPFR_RNDN);
      mpfr_add(s_, s_, t_, MPFR_RNDN);
      mpfr_mul_si(s_, s_, 1000, MPFR_RNDN);
      mpfr_div_si(s_, s_, 1055, MPFR_RNDN);
      mpfr_set_si(t_, 24, MPFR_RNDN);
      mpfr_div_si(t_, t_, 10, MPFR_RNDN);
      mpfr_pow(s_, s_, t_, MPFR_RNDN);
    }
  }
  ~ExactDecode() { mpfr_clears(s_, t_, nullptr); }
  long times_65535() {
    mpfr_mul_si(s_, s_, 65535, MPFR_RNDN);
    return mpfr_get_si(s_, MPFR_RNDN);
  }
  double rounded_up() { return mpfr_get_d(s_, MPFR_RNDU); }

 private:
  mpfr_t s_, t_;
};

TEST(Srgb, DecodeTableIsTheExactFunctionRounded) {
  for (long i = 0; i < 256; ++i) EXPECT_EQ(srgb_decode16(static_cast<std::uint8_t>(i)), ExactDecode(i, 255).times_65535()) << i;
}

TEST(Srgb, ThresholdsAreTheExactHalfCodesRoundedUp) {
  for (long c = 1; c < 256; ++c) EXPECT_EQ(kSrgbThreshold[c], ExactDecode(2 * c - 1, 510).rounded_up()) << c;
}

TEST(Srgb, EightBitRoundTripIsTheIdentity) {
  for (int i = 0; i < 256; ++i) EXPECT_EQ(srgb_encode8(srgb_decode16(static_cast<std::uint8_t>(i)) / 65535.0), i);
}

TEST(Srgb, EncodeChangesExactlyAtItsThresholds) {
  for (int c = 1; c < 256; ++c) {
    EXPECT_EQ(srgb_encode8(kSrgbThreshold[c]), c);
    EXPECT_EQ(srgb_encode8(std::nextafter(kSrgbThreshold[c], 0.0)), c - 1);
  }
}

TEST(Srgb, EncodeIsMonotoneAndTotal) {
  int previous = 0;
  for (double x = 0; x < 1.01; x += 0x1p-20) {
    const int code = srgb_encode8(x);
    ASSERT_GE(code, previous) << x;
    ASSERT_LE(code, previous + 1) << x;
    previous = code;
  }
  EXPECT_EQ(previous, 255);
  EXPECT_EQ(srgb_encode8(std::nan("")), 0);
  EXPECT_EQ(srgb_encode8(-1), 0);
  EXPECT_EQ(srgb_encode8(INFINITY), 255);
}

TEST(Srgb, EncodeOfABinary32IsTheSame) {
  const auto expect_same = [](float x) { ASSERT_EQ(srgb_encode8_single(x), srgb_encode8(double{x})) << std::hexfloat << x; };
  for (int c = 1; c < 256; ++c) {
    const auto near = static_cast<float>(kSrgbThreshold[c]);
    float x = near;
    for (int i = 0; i < 4; ++i) x = std::nextafter(x, 0.0f);
    for (int i = 0; i < 9; ++i, x = std::nextafter(x, 2.0f)) expect_same(x);
  }
  for (std::uint32_t bits = 0; bits < 0x3f800000u + 70000; bits += 509) expect_same(std::bit_cast<float>(bits));
  for (const float x : {0.0f, -0.0f, -1.0f, 1.0f, 2.0f, 1e30f, -1e30f, INFINITY, -INFINITY, std::nanf("")}) expect_same(x);
}

}  // namespace
}  // namespace aluminate::vm
