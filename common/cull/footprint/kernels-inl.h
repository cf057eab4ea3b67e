// Compiled once for each instruction set by kernels.cpp; kernels.h has the error analysis.

#if defined(TESSERA_FOOTPRINT_KERNELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_FOOTPRINT_KERNELS_INL
#undef TESSERA_FOOTPRINT_KERNELS_INL
#else
#define TESSERA_FOOTPRINT_KERNELS_INL
#endif

#include <hwy/highway.h>

#include "common/cull/footprint/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace tessera::cull {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using F = hn::CappedTag<float, kLanes>;
using I = hn::RebindToSigned<F>;
using V = hn::Vec<F>;
using M = hn::Mask<F>;
using Ints = hn::Vec<I>;

HWY_INLINE std::size_t lanes() {
  return hn::Lanes(F());
}

/// fl32(scale * fl64(center - eye)) of as many lanes as a vector has.
HWY_INLINE V relative(const double* center, double eye, double scale) {
  const F f;
#if HWY_TARGET == HWY_SCALAR
  const hn::CappedTag<double, 1> d;
  return hn::DemoteTo(f, hn::Mul(hn::Sub(hn::LoadU(d, center), hn::Set(d, eye)), hn::Set(d, scale)));
#else
  const hn::Half<F> half;
  const hn::Rebind<double, hn::Half<F>> d;
  const auto part = [&](const double* from) {
    return hn::DemoteTo(half, hn::Mul(hn::Sub(hn::LoadU(d, from), hn::Set(d, eye)), hn::Set(d, scale)));
  };
  return hn::Combine(f, part(center + hn::Lanes(d)), part(center));
#endif
}

HWY_INLINE V dot(const float* functional, V x, V y, V z) {
  const F f;
  return hn::Add(hn::Add(hn::Mul(hn::Set(f, functional[0]), x), hn::Mul(hn::Set(f, functional[1]), y)),
                 hn::Mul(hn::Set(f, functional[2]), z));
}

struct Triple {
  V x, y, z;
};
HWY_INLINE Triple operator+(const Triple& a, const Triple& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Triple operator-(const Triple& a, const Triple& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

/// A box in homogeneous tile coordinates.
struct Box {
  Triple center, half[3];
  V magnitude;  ///< m
};

HWY_INLINE Triple project(const KernelFrame& frame, V x, V y, V z) {
  return {dot(frame.column, x, y, z), dot(frame.row, x, y, z), dot(frame.depth, x, y, z)};
}

HWY_INLINE Triple projectCenter(const KernelFrame& frame, const double (*center)[kLanes], std::size_t at,
                                V& magnitude) {
  const V x = relative(center[0] + at, frame.eye[0], frame.scale);
  const V y = relative(center[1] + at, frame.eye[1], frame.scale);
  const V z = relative(center[2] + at, frame.eye[2], frame.scale);
  magnitude = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
  return project(frame, x, y, z);
}

HWY_INLINE Box boxOf(const KernelFrame& frame, const OrientedBlock& block, std::size_t at) {
  const F f;
  Box box;
  box.center = projectCenter(frame, block.center, at, box.magnitude);
  for (std::size_t k = 0; k < 3; ++k) {
    box.half[k] = project(frame, hn::LoadU(f, block.half[3 * k] + at), hn::LoadU(f, block.half[3 * k + 1] + at),
                          hn::LoadU(f, block.half[3 * k + 2] + at));
  }
  box.magnitude = hn::Add(box.magnitude, hn::LoadU(f, block.extent + at));
  return box;
}

HWY_INLINE Box boxOf(const KernelFrame& frame, const AlignedBlock& block, std::size_t at) {
  const F f;
  Box box;
  box.center = projectCenter(frame, block.center, at, box.magnitude);
  for (std::size_t k = 0; k < 3; ++k) {
    const V h = hn::LoadU(f, block.half[k] + at);
    box.half[k] = {hn::Mul(hn::Set(f, frame.column[k]), h), hn::Mul(hn::Set(f, frame.row[k]), h),
                   hn::Mul(hn::Set(f, frame.depth[k]), h)};
    box.magnitude = hn::Add(box.magnitude, h);
  }
  return box;
}

template <class Visit>
HWY_INLINE void forEachCorner(const Box& box, Visit visit) {
  const Triple a = box.center + box.half[0], b = box.center - box.half[0];
  for (const Triple& ab : {a, b}) {
    const Triple p = ab + box.half[1], q = ab - box.half[1];
    visit(p + box.half[2]);
    visit(p - box.half[2]);
    visit(q + box.half[2]);
    visit(q - box.half[2]);
  }
}

/// Intervals in tiles before they are widened, and what decides about them.
struct Projection {
  V xLeast, xMost, yLeast, yMost, zLeast, zMost, inverseMost;
};

HWY_INLINE Projection projectionOf(const Box& box) {
  const F f;
  const V inf = hn::Set(f, HUGE_VALF), one = hn::Set(f, 1.0F);
  Projection p = {inf, hn::Neg(inf), inf, hn::Neg(inf), inf, hn::Neg(inf), hn::Neg(inf)};
  forEachCorner(box, [&](const Triple& corner) HWY_ATTR {
    const V inverse = hn::Div(one, corner.z);
    const V x = hn::Mul(corner.x, inverse), y = hn::Mul(corner.y, inverse);
    p.xLeast = hn::Min(p.xLeast, x);
    p.xMost = hn::Max(p.xMost, x);
    p.yLeast = hn::Min(p.yLeast, y);
    p.yMost = hn::Max(p.yMost, y);
    p.zLeast = hn::Min(p.zLeast, corner.z);
    p.zMost = hn::Max(p.zMost, corner.z);
    p.inverseMost = hn::Max(p.inverseMost, inverse);
  });
  return p;
}

/// By how much all corners of the box are beyond one of the wall's sides, as x - bz (or y) says it; negative
/// where they are not.
HWY_INLINE V beyondSides(const KernelFrame& frame, const Box& box) {
  const F f;
  const V inf = hn::Set(f, HUGE_VALF);
  const V left = hn::Set(f, frame.columnLow), right = hn::Set(f, frame.lastColumn + frame.columnHigh);
  const V top = hn::Set(f, frame.rowLow), bottom = hn::Set(f, frame.lastRow + frame.rowHigh);
  V l = hn::Neg(inf), r = inf, t = hn::Neg(inf), b = inf;
  forEachCorner(box, [&](const Triple& corner) HWY_ATTR {
    l = hn::Max(l, hn::Sub(corner.x, hn::Mul(left, corner.z)));
    r = hn::Min(r, hn::Sub(corner.x, hn::Mul(right, corner.z)));
    t = hn::Max(t, hn::Sub(corner.y, hn::Mul(top, corner.z)));
    b = hn::Min(b, hn::Sub(corner.y, hn::Mul(bottom, corner.z)));
  });
  return hn::Max(hn::Max(hn::Neg(l), r), hn::Max(hn::Neg(t), b));
}

/// First and last cell of an interval of one axis, as whole floats; [0, -1] to [last + 1, last] where empty.
struct Cells {
  V first, last;
};
HWY_INLINE Cells cellsOf(V least, V most, float low, float high, float lastCell) {
  const F f;
  const V zero = hn::Zero(f), end = hn::Set(f, lastCell);
  return {hn::Min(hn::Max(hn::Ceil(hn::Sub(least, hn::Set(f, high))), zero), hn::Add(end, hn::Set(f, 1.0F))),
          hn::Max(hn::Min(hn::Floor(hn::Sub(most, hn::Set(f, low))), end), hn::Set(f, -1.0F))};
}

/// Everything about the lanes of one vector.
struct Decision {
  Ints rects;
  M undecided;  ///< neither a rectangle nor certainly outside
  M empty;
  M isBefore;  ///< all corners certainly before the eye, and numbers of sane size
  Cells columns, rows;
  V xLeast, xMost, yLeast, yMost;  ///< widened
  V zLeast, zMost, xError, yError, magnitude, beyond;
};

HWY_INLINE Decision decide(const KernelFrame& frame, const Box& box) {
  const F f;
  const I i;
  const Projection p = projectionOf(box);
  const V m = box.magnitude;
  Decision d;
  d.magnitude = m;
  d.zLeast = p.zLeast;
  d.zMost = p.zMost;
  const M isSane = hn::Lt(m, hn::Set(f, frame.mostSize));  // false for NaN
  d.isBefore = hn::And(hn::And(isSane, hn::Gt(p.zLeast, hn::Set(f, frame.leastDepth))),
                       hn::And(hn::Gt(p.zLeast, hn::Mul(hn::Set(f, frame.frontError), m)),
                               hn::Gt(p.zLeast, hn::Mul(hn::Set(f, frame.depthRatio), p.zMost))));
  const V perTile = hn::Mul(m, p.inverseMost);
  d.xError = hn::Mul(hn::Set(f, frame.columnError), perTile);
  d.yError = hn::Mul(hn::Set(f, frame.rowError), perTile);
  d.xLeast = hn::Sub(p.xLeast, d.xError);
  d.xMost = hn::Add(p.xMost, d.xError);
  d.yLeast = hn::Sub(p.yLeast, d.yError);
  d.yMost = hn::Add(p.yMost, d.yError);
  d.columns = cellsOf(d.xLeast, d.xMost, frame.columnLow, frame.columnHigh, frame.lastColumn);
  d.rows = cellsOf(d.yLeast, d.yMost, frame.rowLow, frame.rowHigh, frame.lastRow);

  const V zError = hn::Mul(hn::Set(f, frame.depthError), m);
  const M outOfDepth =
      hn::And(isSane, hn::Or(hn::Lt(hn::Add(p.zMost, zError), hn::Set(f, frame.near)),
                                 hn::Gt(hn::Sub(p.zLeast, zError), hn::Set(f, frame.far))));
  const M offWall = hn::And(d.isBefore, hn::Or(hn::Gt(d.columns.first, d.columns.last),
                                               hn::Gt(d.rows.first, d.rows.last)));
  d.empty = hn::Or(outOfDepth, offWall);
  d.undecided = hn::Not(hn::Or(d.isBefore, d.empty));
  d.beyond = hn::Zero(f);
  if (HWY_UNLIKELY(!hn::AllFalse(f, d.undecided))) {
    d.beyond = beyondSides(frame, box);
    const M isBeyond = hn::And(
        isSane, hn::And(d.undecided, hn::Gt(d.beyond, hn::Mul(hn::Set(f, frame.sideError), m))));
    d.empty = hn::Or(d.empty, isBeyond);
    d.undecided = hn::AndNot(isBeyond, d.undecided);
  }
  const auto cell = [&](V v) HWY_ATTR { return hn::ConvertTo(i, v); };
  const Ints packed = hn::Or(hn::Or(cell(d.columns.first), hn::ShiftLeft<8>(cell(d.columns.last))),
                             hn::Or(hn::ShiftLeft<16>(cell(d.rows.first)), hn::ShiftLeft<24>(cell(d.rows.last))));
  const Ints none = hn::Set(i, static_cast<std::int32_t>(kNoTiles));
  d.rects = hn::IfThenElse(hn::RebindMask(i, hn::Or(d.empty, d.undecided)), none, packed);
  return d;
}

HWY_INLINE std::uint32_t bitsOf(M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(F(), mask, bits);
  return bits[0];
}

HWY_INLINE M isWide(const Decision& d) {
  const F f;
  const V one = hn::Set(f, 1.0F);
  const V columns = hn::Sub(d.columns.last, d.columns.first), rows = hn::Sub(d.rows.last, d.rows.first);
  const M isLarge = hn::Ge(hn::Mul(hn::Add(columns, one), hn::Add(rows, one)),
                           hn::Set(f, static_cast<float>(kLeastRefined)));
  const M isTwo = hn::And(hn::Ge(columns, one), hn::Ge(rows, one));
  return hn::AndNot(hn::Or(d.empty, d.undecided), hn::And(isLarge, isTwo));
}

HWY_INLINE void store(Ints rects, TileRect* to) {
  hn::StoreU(rects, I(), reinterpret_cast<std::int32_t*>(to));
}

void leaves(const KernelFrame& frame, const OrientedBlock* blocks, std::size_t count, TileRect* rects,
            BlockLanes* open) {
  for (std::size_t b = 0; b < count; ++b) {
    std::uint32_t undecided = 0, wide = 0;
    for (std::size_t at = 0; at < kLanes; at += lanes()) {
      const Decision d = decide(frame, boxOf(frame, blocks[b], at));
      store(d.rects, rects + b * kLanes + at);
      undecided |= bitsOf(d.undecided) << at;
      wide |= bitsOf(isWide(d)) << at;
    }
    open[b] = {static_cast<std::uint8_t>(undecided), static_cast<std::uint8_t>(wide)};
  }
}

void leavesCertified(const KernelFrame& frame, const OrientedBlock* blocks, std::size_t count,
                     TileRect* rects, BlockLanes* open, BlockCertificate* certificates) {
  for (std::size_t b = 0; b < count; ++b)
    certificates[b] = {0, 0};
  leaves(frame, blocks, count, rects, open);
}

void nodes(const KernelFrame& frame, const AlignedBlock& block, NodeFootprints& out) {
  const F f;
  out.contained = out.unknown = 0;
  for (std::size_t at = 0; at < kLanes; at += lanes()) {
    const Decision d = decide(frame, boxOf(frame, block, at));
    store(d.rects, out.rects + at);
    out.unknown |= bitsOf(d.undecided) << at;
    const V zError = hn::Mul(hn::Set(f, frame.depthError), d.magnitude);
    const M single = hn::And(hn::Eq(d.columns.first, d.columns.last), hn::Eq(d.rows.first, d.rows.last));
    const auto within = [&](V least, V most, V cell, float low, float high) HWY_ATTR {
      return hn::And(hn::Ge(least, hn::Add(cell, hn::Set(f, low))), hn::Le(most, hn::Add(cell, hn::Set(f, high))));
    };
    const M inTile =
        hn::And(within(d.xLeast, d.xMost, d.columns.first, frame.columnLow, frame.columnHigh),
                within(d.yLeast, d.yMost, d.rows.first, frame.rowLow, frame.rowHigh));
    const M inDepth = hn::And(hn::Ge(hn::Sub(d.zLeast, zError), hn::Set(f, frame.near)),
                              hn::Le(hn::Add(d.zMost, zError), hn::Set(f, frame.far)));
    const M decided = hn::AndNot(d.empty, d.isBefore);
    out.contained |= bitsOf(hn::And(hn::And(decided, single), hn::And(inTile, inDepth))) << at;
  }
}

Kernels makeKernels() {
  return {leaves, leavesCertified, nodes};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::cull
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_FOOTPRINT_KERNELS_INL
