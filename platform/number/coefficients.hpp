// Polynomial coefficients of the defined functions, as hex-float literals so that no compiler or start-up code can
// round them differently. Each block shows the Sollya 8 command (prec = 200) that made it and the error Sollya bounds
// (dirtyinfnorm) for exact evaluation; tests/number measures the whole function. Order: constant term first.
#pragma once

namespace aluminate::number {

// p = fpminimax(2^x, [|1..7|], [|D...|], [-h; h], 1, relative), h = 0.5 + 2^-20; relative error 2^-34.3.
inline constexpr double kExp2[8] = {
    0x1p0,                    0x1.62e42ff0e1931p-1,   0x1.ebfbe07787837p-3,   0x1.c6b08ac06a2b3p-5,
    0x1.3b29f39cec2e3p-7,     0x1.5d8a85ffbf0bfp-10,  0x1.445c8458ecfffp-13,  0x1.fde5fdb58dbe1p-17};

// Same with [|1..11|]: relative error 2^-57.2. For ref64.
inline constexpr double kExp2Reference[12] = {
    0x1p0,                    0x1.62e42fefa39efp-1,   0x1.ebfbdff82c5a6p-3,   0x1.c6b08d704a12cp-5,
    0x1.3b2ab6fb9fda6p-7,     0x1.5d87fe789e97p-10,   0x1.4309130f6cbf1p-13,  0x1.ffcbfc668569ap-17,
    0x1.62bfc6596443p-20,     0x1.b52522bd7be7cp-24,  0x1.e61d43466fdf4p-28,  0x1.e973153c5c00cp-32};

// q(z) = log2((1+s)/(1-s))/s with z = s^2, z <= ((sqrt(2)-1)/(sqrt(2)+1))^2:
// fpminimax(log2((1+sqrt(x))/(1-sqrt(x)))/sqrt(x), 4, [|D...|], [2^-40; zmax], relative); relative error 2^-37.8.
inline constexpr double kLog2[5] = {0x1.71547652bede5p1, 0x1.ec709d12e1573p-1, 0x1.27777fda65c64p-1,
                                    0x1.a58d8fc10c5d8p-2, 0x1.5ce7cd8b15e21p-2};

// Same with degree 7: relative error 2^-56. For ref64.
inline constexpr double kLog2Reference[8] = {
    0x1.71547652b82fep1,      0x1.ec709dc3a062ap-1,   0x1.2776c50ebd14p-1,    0x1.a61763075bcc5p-2,
    0x1.484aeba271424p-2,     0x1.0ca421afab133p-2,   0x1.c3f12ec2b84ccp-3,   0x1.b9ff113f8785fp-3};

// sin(r) = r + r^3 S(r^2) on |r| <= pi/4 + 2^-20:
// fpminimax(sin(x), [|3,5,7,9,11,13|], [|D...|], [2^-20; h], x, absolute); absolute error 2^-59.1.
inline constexpr double kSin[6] = {-0x1.555555555553dp-3, 0x1.111111110eaabp-7,  -0x1.a01a019aaa0d6p-13,
                                   0x1.71de346e1e3cp-19,  -0x1.ae5dafc2965dep-26, 0x1.5d639e8bcf70ap-33};

// cos(r) = 1 + r^2 C(r^2) on the same interval:
// fpminimax(cos(x), [|2,4,6,8,10,12,14|], [|D...|], [2^-20; h], 1, absolute); absolute error 2^-64.
inline constexpr double kCos[7] = {-0x1p-1,
                                   0x1.555555555554bp-5,
                                   -0x1.6c16c16c1504cp-10,
                                   0x1.a01a019c97a14p-16,
                                   -0x1.27e4f7f911fc7p-22,
                                   0x1.1ee9e17e7e341p-29,
                                   -0x1.8fa9a74b9a7ddp-37};

inline constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
inline constexpr double kPiOver2High = 0x1.921fb54442d18p0;   // binary64(pi/2)
inline constexpr double kPiOver2Low = 0x1.1a62633145c07p-54;  // binary64(pi/2 - kPiOver2High)
inline constexpr double kSqrtHalf = 0x1.6a09e667f3bcdp-1;     // binary64(sqrt(1/2)), where log2 splits its binades

}  // namespace aluminate::number
