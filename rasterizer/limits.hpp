// Every capacity of the rasterizer with the inequality that keeps its arithmetic exact. Nothing here is tunable without
// the static_assert beside it still holding; the rest of the folder relies on these facts and does not repeat them.
#pragma once

#include <cstdint>

namespace aluminate::raster {

// Positions: s15.8 pixels ("sub": 1/256 px), absolute in the viewport, +x right, +y down. Pixel (i, j) has its centre at
// (256 i + 128, 256 j + 128).
inline constexpr int kSubpixelBits = 8;
inline constexpr std::int32_t kSubpixels = 1 << kSubpixelBits;
inline constexpr std::int32_t kHalfPixel = kSubpixels / 2;
inline constexpr int kGuardBandPx = 16384;   // |x|, |y| <= this after clipping: shared edges are almost never cut
inline constexpr std::int32_t kGuardBandSub = kGuardBandPx * kSubpixels;
inline constexpr int kMaxViewportPx = 16384; // the viewport is [0, width) x [0, height): inside the guard band
static_assert(kMaxViewportPx <= kGuardBandPx);

// Tiles, the unit of work, and the three levels of 16: tile 64x64 -> 16 blocks of 16x16 -> 16 stamps of 4x4 -> 16 pixels.
inline constexpr int kTilePx = 64;
inline constexpr int kBlockPx = 16;
inline constexpr int kStampPx = 4;
inline constexpr int kTilePixels = kTilePx * kTilePx;
inline constexpr int kStampsPerTile = kTilePixels / (kStampPx * kStampPx);
static_assert(kStampsPerTile == 256, "a stamp number fits in a byte");

// Edge functions. E(p) = dx (py - ay) - dy (px - ax) with |dx|, |dy|, |py - ay|, |px - ax| <= 2^23 sub.
inline constexpr std::int64_t kMaxEdgeDelta = 2LL * kGuardBandSub;
static_assert(kMaxEdgeDelta == 1LL << 23);
static_assert(2 * kMaxEdgeDelta * kMaxEdgeDelta == 1LL << 47, "edge values and twice the area fit in int64 and binary64");
// In a tile the samples lie on a 256-sub grid, so E(p) >= bias <=> floor(E(origin) - bias / 256) - dy i + dx j >= 0 in whole
// pixels i, j: 32 bits are enough once the origin value is clamped beyond everything 63 steps each way can reach.
inline constexpr std::int64_t kMaxStepSum = 2 * (kTilePx - 1) * kMaxEdgeDelta;
inline constexpr std::int64_t kEdgeClampHigh = 1LL << 30;
inline constexpr std::int64_t kEdgeClampLow = -(1LL << 30) - 1;
static_assert(kMaxStepSum < kEdgeClampHigh, "a clamped edge keeps its sign at every pixel of the tile");
static_assert(kEdgeClampHigh + kMaxStepSum <= INT32_MAX && kEdgeClampLow - kMaxStepSum >= INT32_MIN);

// Depth. Vertices carry D24 with 4 more bits ("z4"); planes are evaluated modulo 2^64 in units of 2^-38 D24 steps.
inline constexpr std::uint32_t kDepthMax = (1u << 24) - 1;
inline constexpr int kVertexDepthBits = 4;
inline constexpr int kPlaneBits = 38;        // fraction bits of the plane
inline constexpr int kStampDepthBits = 7;    // fraction bits of the 32-bit lanes
// Slope numerators dz1 dy2 - dz2 dy1: |dz| < 2^28, |dy| <= 2^23: below 2^52, so binary64 holds them exactly.
static_assert(24 + kVertexDepthBits + 23 + 1 <= 53);
// Depth at a covered pixel, with 38 fraction bits and half a step for rounding: 2^62 + 2^37 < 2^63, one bit to spare.
static_assert(24 + kPlaneBits + 1 <= 63);
static_assert(24 + kStampDepthBits <= 31, "with 7 fraction bits a covered pixel's depth is a positive int32");

// A tile with more than this share of the frame's (triangle, tile) pairs, and more than this number, is drawn in quarters: 4 for
// each of 8 threads, so that no task is much longer than a thread's part on machines several times that size. The rule looks
// at the frame alone: counters depend on it and must not depend on threads.
inline constexpr std::uint64_t kHotTileShare = 32, kHotTileEntries = 2048;
static_assert(kMaxViewportPx / kTilePx * (kMaxViewportPx / kTilePx) <= INT32_MAX / 5, "numbers of tasks fit an int");

// Submission. A chunk is the unit of set-up; its size does not depend on the number of threads, so nothing else does.
inline constexpr std::uint32_t kChunkTriangles = 1024;
// A triangle cut by near, far and 4 guard planes has at most 3 + 6 corners, hence at most 7 fragments.
inline constexpr int kMaxClipCorners = 9;
inline constexpr int kMaxClipFragments = kMaxClipCorners - 2;
inline constexpr int kClipIndexBits = 13;
static_assert(kChunkTriangles * kMaxClipFragments <= 1u << kClipIndexBits);
// Triangle ids: bit 31 clear = position in submission order; set = chunk << 13 | fragment number within the chunk.
inline constexpr std::uint32_t kMaxTriangles = 1u << (31 - kClipIndexBits + 10);
static_assert(kMaxTriangles / kChunkTriangles <= 1u << (31 - kClipIndexBits));
inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;  // visibility of a pixel nothing covers
inline constexpr std::uint32_t kClippedBit = 0x80000000u;
static_assert(kNoTriangle != (kClippedBit | (kMaxTriangles / kChunkTriangles - 1) << kClipIndexBits |
                              (kChunkTriangles * kMaxClipFragments - 1)), "the largest id is not the empty mark");

// Batches: 64 lanes = 16 quads of 2x2 pixels, lane order (0,0) (1,0) (0,1) (1,1) inside a quad.
inline constexpr int kBatchQuads = 16;
inline constexpr int kBatchLanes = 4 * kBatchQuads;

}  // namespace aluminate::raster
