// Compiled once for each instruction set by kernels.cpp; kernels.h has the error analysis.

#if defined(TESSERA_FOOTPRINT_KERNELS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_FOOTPRINT_KERNELS_INL
#undef TESSERA_FOOTPRINT_KERNELS_INL
#else
#define TESSERA_FOOTPRINT_KERNELS_INL
#endif

#include <algorithm>
#include <cmath>

#include <hwy/cache_control.h>
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
  const hn::Rebind<double, hn::Half<F> > d;
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
  V reach;      ///< no point is farther from the eye
};

HWY_INLINE Triple project(const KernelFrame& frame, V x, V y, V z) {
  return {dot(frame.column, x, y, z), dot(frame.row, x, y, z), dot(frame.depth, x, y, z)};
}

HWY_INLINE Triple projectCenter(const KernelFrame& frame, const double (*center)[kLanes], std::size_t at,
                                Box& box) {
  const V x = relative(center[0] + at, frame.eye[0], frame.scale);
  const V y = relative(center[1] + at, frame.eye[1], frame.scale);
  const V z = relative(center[2] + at, frame.eye[2], frame.scale);
  box.magnitude = hn::Add(hn::Add(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
  box.reach = hn::Sqrt(hn::Add(hn::Add(hn::Mul(x, x), hn::Mul(y, y)), hn::Mul(z, z)));
  return project(frame, x, y, z);
}

HWY_INLINE Box boxOf(const KernelFrame& frame, const OrientedBlock& block, std::size_t at) {
  const F f;
  Box box;
  box.center = projectCenter(frame, block.center, at, box);
  for (std::size_t k = 0; k < 3; ++k) {
    box.half[k] = project(frame, hn::LoadU(f, block.half[3 * k] + at),
                          hn::LoadU(f, block.half[3 * k + 1] + at), hn::LoadU(f, block.half[3 * k + 2] + at));
  }
  const V extent = hn::LoadU(f, block.extent + at);
  box.magnitude = hn::Add(box.magnitude, extent);
  box.reach = hn::Add(box.reach, extent);
  return box;
}

HWY_INLINE Box boxOf(const KernelFrame& frame, const AlignedBlock& block, std::size_t at) {
  const F f;
  Box box;
  box.center = projectCenter(frame, block.center, at, box);
  for (std::size_t k = 0; k < 3; ++k) {
    const V h = hn::LoadU(f, block.half[k] + at);
    box.half[k] = {hn::Mul(hn::Set(f, frame.column[k]), h), hn::Mul(hn::Set(f, frame.row[k]), h),
                   hn::Mul(hn::Set(f, frame.depth[k]), h)};
    box.magnitude = hn::Add(box.magnitude, h);
  }
  return box;
}

/// The 8 corners two by two.
template <class Visit>
HWY_INLINE void forEachEdge(const Box& box, Visit visit) {
  const Triple a = box.center + box.half[0], b = box.center - box.half[0];
  for (const Triple& ab : {a, b}) {
    const Triple p = ab + box.half[1], q = ab - box.half[1];
    visit(p + box.half[2], p - box.half[2]);
    visit(q + box.half[2], q - box.half[2]);
  }
}

/// Intervals in tiles before they are widened, and those of depth.
struct Projection {
  V xLeast, xMost, yLeast, yMost, zLeast, zMost;
};

HWY_INLINE Projection projectionOf(const Box& box) {
  const F f;
  const V inf = hn::Set(f, HUGE_VALF), one = hn::Set(f, 1.0F);
  Projection p = {inf, hn::Neg(inf), inf, hn::Neg(inf), inf, inf};
  const auto add = [&](V x, V y) HWY_ATTR {
    p.xLeast = hn::Min(p.xLeast, x);
    p.xMost = hn::Max(p.xMost, x);
    p.yLeast = hn::Min(p.yLeast, y);
    p.yMost = hn::Max(p.yMost, y);
  };
  forEachEdge(box, [&](const Triple& a, const Triple& b) HWY_ATTR {
    const V inverse = hn::Div(one, hn::Mul(a.z, b.z));  // one division for two corners
    const V ofA = hn::Mul(b.z, inverse), ofB = hn::Mul(a.z, inverse);
    add(hn::Mul(a.x, ofA), hn::Mul(a.y, ofA));
    add(hn::Mul(b.x, ofB), hn::Mul(b.y, ofB));
  });
  const V depth = hn::Add(hn::Add(hn::Abs(box.half[0].z), hn::Abs(box.half[1].z)), hn::Abs(box.half[2].z));
  p.zLeast = hn::Sub(box.center.z, depth);
  p.zMost = hn::Add(box.center.z, depth);
  return p;
}

/// By how much all corners of the box are beyond one of the wall's sides, as x - bz and y - bz say it;
/// negative where they are not.
struct Beyond {
  V columns, rows;
};
HWY_INLINE Beyond beyondSides(const KernelFrame& frame, const Box& box) {
  const F f;
  const V inf = hn::Set(f, HUGE_VALF);
  const V left = hn::Set(f, frame.columnLow), right = hn::Set(f, frame.lastColumn + frame.columnHigh);
  const V top = hn::Set(f, frame.rowLow), bottom = hn::Set(f, frame.lastRow + frame.rowHigh);
  V l = hn::Neg(inf), r = inf, t = hn::Neg(inf), b = inf;
  const auto add = [&](const Triple& corner) HWY_ATTR {
    l = hn::Max(l, hn::Sub(corner.x, hn::Mul(left, corner.z)));
    r = hn::Min(r, hn::Sub(corner.x, hn::Mul(right, corner.z)));
    t = hn::Max(t, hn::Sub(corner.y, hn::Mul(top, corner.z)));
    b = hn::Min(b, hn::Sub(corner.y, hn::Mul(bottom, corner.z)));
  };
  forEachEdge(box, [&](const Triple& p, const Triple& q) HWY_ATTR { add(p), add(q); });
  return {hn::Max(hn::Neg(l), r), hn::Max(hn::Neg(t), b)};
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
  V zLeast, zMost, magnitude, reach, beyondColumns, beyondRows;
};

HWY_INLINE Decision decide(const KernelFrame& frame, const Box& box) {
  const F f;
  const I i;
  const Projection p = projectionOf(box);
  const V m = box.magnitude;
  Decision d;
  d.magnitude = m;
  d.reach = box.reach;
  d.zLeast = p.zLeast;
  d.zMost = p.zMost;
  const M isSane = hn::Lt(m, hn::Set(f, frame.mostSize));  // false for NaN
  d.isBefore = hn::And(hn::And(isSane, hn::Gt(p.zLeast, hn::Set(f, frame.leastDepth))),
                       hn::And(hn::Gt(p.zLeast, hn::Mul(hn::Set(f, frame.frontError), m)),
                               hn::Gt(p.zLeast, hn::Mul(hn::Set(f, frame.depthRatio), p.zMost))));
  const V perTile = hn::Div(m, p.zLeast);
  const V xError = hn::Mul(hn::Set(f, frame.columnError), perTile);
  const V yError = hn::Mul(hn::Set(f, frame.rowError), perTile);
  d.xLeast = hn::Sub(p.xLeast, xError);
  d.xMost = hn::Add(p.xMost, xError);
  d.yLeast = hn::Sub(p.yLeast, yError);
  d.yMost = hn::Add(p.yMost, yError);
  d.columns = cellsOf(d.xLeast, d.xMost, frame.columnLow, frame.columnHigh, frame.lastColumn);
  d.rows = cellsOf(d.yLeast, d.yMost, frame.rowLow, frame.rowHigh, frame.lastRow);

  const V zError = hn::Mul(hn::Set(f, frame.depthError), m);
  const M outOfDepth = hn::And(isSane, hn::Or(hn::Lt(hn::Add(p.zMost, zError), hn::Set(f, frame.near)),
                                              hn::Gt(hn::Sub(p.zLeast, zError), hn::Set(f, frame.far))));
  const M offWall =
      hn::And(d.isBefore, hn::Or(hn::Gt(d.columns.first, d.columns.last), hn::Gt(d.rows.first, d.rows.last)));
  d.empty = hn::Or(outOfDepth, offWall);
  d.undecided = hn::Not(hn::Or(d.isBefore, d.empty));
  d.beyondColumns = d.beyondRows = hn::Zero(f);
  if (HWY_UNLIKELY(!hn::AllFalse(f, d.undecided))) {
    const Beyond beyond = beyondSides(frame, box);
    d.beyondColumns = beyond.columns;
    d.beyondRows = beyond.rows;
    const V least = hn::Mul(hn::Set(f, frame.sideError), m);
    const M isBeyond = hn::And(hn::And(isSane, d.undecided),
                               hn::Or(hn::Gt(beyond.columns, least), hn::Gt(beyond.rows, least)));
    d.empty = hn::Or(d.empty, isBeyond);
    d.undecided = hn::AndNot(isBeyond, d.undecided);
  }
  const auto cell = [&](V v) HWY_ATTR { return hn::ConvertTo(i, v); };
  const Ints packed =
      hn::Or(hn::Or(cell(d.columns.first), hn::ShiftLeft<8>(cell(d.columns.last))),
             hn::Or(hn::ShiftLeft<16>(cell(d.rows.first)), hn::ShiftLeft<24>(cell(d.rows.last))));
  const Ints none = hn::Set(i, static_cast<std::int32_t>(kNoTiles));
  d.rects = hn::IfThenElse(hn::RebindMask(i, hn::Or(d.empty, d.undecided)), none, packed);
  return d;
}

HWY_INLINE std::uint32_t bitsOf(M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(F(), mask, bits);
  return bits[0] | static_cast<std::uint32_t>(bits[1]) << 8;
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

/// By how much x - bz and y - bz may change before a lane's rectangle can.
struct Margins {
  V column, row;
};

/// What is computed differs from what is exact by 2 errors in each of two frames; 8 are kept. A change of z
/// is at most two thirds of the change that is allowed to x - bz for the two borders farthest apart.
HWY_INLINE Margins marginsOf(const KernelFrame& frame, const Decision& d) {
  const F f;
  const V zero = hn::Zero(f), inf = hn::Set(f, HUGE_VALF), one = hn::Set(f, 1.0F);
  const V error = hn::Mul(hn::Set(f, 8 * frame.valueError), d.magnitude);
  const V zError = hn::Mul(hn::Set(f, 8 * frame.depthError), d.magnitude);
  const V near = hn::Set(f, frame.near), far = hn::Set(f, frame.far);
  const V borders = hn::Set(f, kBorderSlack);  // the borders themselves move by rounding

  // A rectangle: until an end of an interval reaches another cell, or the depths reach near or far.
  const V depths = hn::Sub(hn::Min(hn::Sub(d.zMost, near), hn::Sub(far, d.zLeast)), zError);
  const auto listed = [&](V least, V most, const Cells& cells, float low, float high, float last) HWY_ATTR {
    const V start = hn::Sub(least, hn::Set(f, high)), end = hn::Sub(most, hn::Set(f, low));
    const V startDown =
        hn::IfThenElse(hn::Gt(cells.first, zero), hn::Sub(start, hn::Sub(cells.first, one)), inf);
    const V endUp =
        hn::IfThenElse(hn::Lt(cells.last, hn::Set(f, last)), hn::Sub(hn::Add(cells.last, one), end), inf);
    const V tiles =
        hn::Min(hn::Min(startDown, endUp), hn::Min(hn::Sub(cells.first, start), hn::Sub(end, cells.last)));
    const V capped = hn::Min(tiles, hn::Set(f, 0.5F));  // so that z never falls below half
    return hn::Min(hn::Sub(hn::Mul(hn::Sub(capped, borders), d.zLeast), error), depths);
  };
  // Outside: until it may be inside again. Outside one pair of sides, the other does not matter.
  const V zSize = hn::Max(d.zMost, hn::Neg(d.zLeast));
  const V offDepths = hn::Sub(hn::Max(hn::Sub(near, d.zMost), hn::Sub(d.zLeast, far)), zError);
  const auto off = [&](V least, V most, V beyond, float low, float high, float last) HWY_ATTR {
    const V tiles = hn::Max(hn::Sub(least, hn::Set(f, last + high)), hn::Sub(hn::Set(f, low), most));
    const V value = hn::IfThenElse(d.isBefore, hn::Mul(tiles, d.zLeast), beyond);
    return hn::Sub(hn::Sub(value, hn::Mul(borders, zSize)), error);
  };
  const V offColumns =
      off(d.xLeast, d.xMost, d.beyondColumns, frame.columnLow, frame.columnHigh, frame.lastColumn);
  const V offRows = off(d.yLeast, d.yMost, d.beyondRows, frame.rowLow, frame.rowHigh, frame.lastRow);
  const V offBoth = offDepths;  // z bounds both

  Margins margins;
  margins.column = listed(d.xLeast, d.xMost, d.columns, frame.columnLow, frame.columnHigh, frame.lastColumn);
  margins.row = listed(d.yLeast, d.yMost, d.rows, frame.rowLow, frame.rowHigh, frame.lastRow);
  // The best of three reasons to be outside.
  const M byDepth = hn::And(hn::Gt(offBoth, offColumns), hn::Gt(offBoth, offRows));
  const M byColumn = hn::Ge(offColumns, offRows);
  const V columnOut = hn::IfThenElse(byDepth, offBoth, hn::IfThenElse(byColumn, offColumns, inf));
  const V rowOut = hn::IfThenElse(byDepth, offBoth, hn::IfThenElse(byColumn, inf, offRows));
  margins.column = hn::IfThenElse(d.empty, columnOut, margins.column);
  margins.row = hn::IfThenElse(d.empty, rowOut, margins.row);
  // While it holds, z may halve and m double, and a box with a rectangle must not be left open for that.
  const auto above = [&](float factor, V of)
                         HWY_ATTR { return hn::Gt(d.zLeast, hn::Mul(hn::Set(f, 4 * factor), of)); };
  const M staysBefore =
      hn::And(hn::And(above(frame.frontError, d.magnitude), above(frame.depthRatio, d.zMost)),
              hn::And(above(frame.leastDepth, one), hn::Lt(d.magnitude, hn::Set(f, frame.mostSize / 4))));
  const M holds = hn::And(hn::AndNot(d.undecided, hn::Or(d.empty, staysBefore)),
                          hn::And(hn::Gt(margins.column, zero), hn::Gt(margins.row, zero)));
  const V never = hn::Neg(inf);  // also for NaN
  margins.column = hn::IfThenElse(holds, margins.column, never);
  margins.row = hn::IfThenElse(holds, margins.row, never);
  return margins;
}

template <bool kCertified>
HWY_INLINE void leavesOf(const KernelFrame& frame, const OrientedBlock* blocks, std::size_t count,
                         TileRect* rects, BlockLanes* open, const KernelDrift* drift, BlockExpiry* expiries) {
  [[maybe_unused]] const F f;
  for (std::size_t b = 0; b < count; ++b) {
    if (b + 2 < count) {  // boxes come from far: a table is used once a frame
      const auto* next = reinterpret_cast<const char*>(blocks + b + 2);
      for (std::size_t line = 0; line < sizeof(OrientedBlock); line += 64)
        hwy::Prefetch(next + line);
    }
    std::uint32_t undecided = 0, wide = 0;
    for (std::size_t at = 0; at < kLanes; at += lanes()) {
      const Decision d = decide(frame, boxOf(frame, blocks[b], at));
      store(d.rects, rects + b * kLanes + at);
      undecided |= bitsOf(d.undecided) << at;
      wide |= bitsOf(isWide(d)) << at;
      if (kCertified) {
        // While it holds, points go no farther away than by the margin. What the check rounds is taken off.
        const Margins margins = marginsOf(frame, d);
        const V size = hn::Min(hn::Max(margins.column, hn::Zero(f)), hn::Max(margins.row, hn::Zero(f)));
        const V reach = hn::Mul(hn::Add(d.reach, size), hn::Set(f, 1 + 0x1p-18F));
        const V rounding = hn::Mul(hn::Add(reach, hn::Set(f, 1.0F)), hn::Set(f, kCheckRounding));
        const auto until = [&](V margin, float turn, float travel) HWY_ATTR {
          const V moved = hn::Add(hn::Mul(reach, hn::Set(f, turn)), hn::Set(f, travel));
          return hn::Sub(hn::Add(hn::Mul(margin, hn::Set(f, 1 - 0x1p-18F)), moved), rounding);
        };
        hn::StoreU(until(margins.column, drift->columnTurn, drift->columnTravel), f,
                   expiries[b].columnUntil + at);
        hn::StoreU(until(margins.row, drift->rowTurn, drift->rowTravel), f, expiries[b].rowUntil + at);
        hn::StoreU(reach, f, expiries[b].reach + at);
      }
    }
    open[b] = {static_cast<std::uint16_t>(undecided), static_cast<std::uint16_t>(wide)};
  }
}

void leaves(const KernelFrame& frame, const OrientedBlock* blocks, std::size_t count, TileRect* rects,
            BlockLanes* open) {
  leavesOf<false>(frame, blocks, count, rects, open, nullptr, nullptr);
}

void leavesCertified(const KernelFrame& frame, const OrientedBlock* blocks, std::size_t count,
                     TileRect* rects, BlockLanes* open, const KernelDrift& drift, BlockExpiry* expiries) {
  leavesOf<true>(frame, blocks, count, rects, open, &drift, expiries);
}

void expired(const BlockExpiry* blocks, std::size_t count, const KernelDrift& drift, std::uint16_t* masks) {
  const F f;
  for (std::size_t b = 0; b < count; ++b) {
    std::uint32_t gone = 0;
    for (std::size_t at = 0; at < kLanes; at += lanes()) {
      const V reach = hn::LoadU(f, blocks[b].reach + at);
      const V columns = hn::Add(hn::Mul(reach, hn::Set(f, drift.columnTurn)), hn::Set(f, drift.columnTravel));
      const V rows = hn::Add(hn::Mul(reach, hn::Set(f, drift.rowTurn)), hn::Set(f, drift.rowTravel));
      const M holds = hn::And(hn::Lt(columns, hn::LoadU(f, blocks[b].columnUntil + at)),
                              hn::Lt(rows, hn::LoadU(f, blocks[b].rowUntil + at)));
      gone |= bitsOf(hn::Not(holds)) << at;
    }
    masks[b] = static_cast<std::uint16_t>(gone);
  }
}

void runs(const TileRect* rects, std::size_t count, std::uint16_t* masks) {
  const F f;
  const I i;
  for (std::size_t b = 0; b < count; ++b) {
    TileRect block[kLanes + 1];
    block[0] = ~rects[b * kLanes];
    std::copy_n(rects + b * kLanes, kLanes, block + 1);
    std::uint32_t starts = 0;
    for (std::size_t at = 0; at < kLanes; at += lanes()) {
      const auto load = [&](const TileRect* from)
                            HWY_ATTR { return hn::LoadU(i, reinterpret_cast<const std::int32_t*>(from)); };
      const auto differs = hn::Ne(load(block + at + 1), load(block + at));
      starts |= bitsOf(hn::RebindMask(f, differs)) << at;
    }
    masks[b] = static_cast<std::uint16_t>(starts);
  }
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
      return hn::And(hn::Ge(least, hn::Add(cell, hn::Set(f, low))),
                     hn::Le(most, hn::Add(cell, hn::Set(f, high))));
    };
    const M inTile = hn::And(within(d.xLeast, d.xMost, d.columns.first, frame.columnLow, frame.columnHigh),
                             within(d.yLeast, d.yMost, d.rows.first, frame.rowLow, frame.rowHigh));
    const M inDepth = hn::And(hn::Ge(hn::Sub(d.zLeast, zError), hn::Set(f, frame.near)),
                              hn::Le(hn::Add(d.zMost, zError), hn::Set(f, frame.far)));
    const M decided = hn::AndNot(d.empty, d.isBefore);
    out.contained |= bitsOf(hn::And(hn::And(decided, single), hn::And(inTile, inDepth))) << at;
  }
}

/// The signs of the half-axes at both ends of a box's 12 edges; the last 4 are there twice.
struct EdgeSigns {
  float a[3][kLanes], b[3][kLanes];
};
constexpr EdgeSigns edgeSigns() {
  EdgeSigns signs = {};
  for (std::size_t e = 0; e < kLanes; ++e) {
    const std::size_t axis = e / 4 % 3, other = e % 4;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t bit = k == (axis + 1) % 3 ? other & 1 : other >> 1;
      signs.a[k][e] = k == axis || bit != 0 ? 1.0F : -1.0F;
      signs.b[k][e] = k == axis || bit == 0 ? -1.0F : 1.0F;
    }
  }
  return signs;
}
inline constexpr EdgeSigns kEdgeSigns = edgeSigns();

/// Edges of one box's outline on the wall, from the lower end to the upper in y.
struct Edges {
  V ax, ay, bx, by, slope;
  M isFlat;
};

bool spans(const KernelFrame& frame, const OrientedBlock& block, std::size_t lane, const TileCells& cells,
           ColumnSpan* spans) {
  const F f;
  constexpr std::size_t kParts = kLanes / hn::MaxLanes(F());
  float d[3], parts[3][4];  // of center and half-axes: x, y, z
  for (std::size_t i = 0; i < 3; ++i)
    d[i] = static_cast<float>((block.center[i][lane] - frame.eye[i]) * frame.scale);
  const float* const functionals[3] = {frame.column, frame.row, frame.depth};
  for (std::size_t i = 0; i < 3; ++i) {
    const float* const g = functionals[i];
    parts[i][0] = g[0] * d[0] + g[1] * d[1] + g[2] * d[2];
    for (std::size_t k = 0; k < 3; ++k) {
      parts[i][k + 1] = g[0] * block.half[3 * k][lane] + g[1] * block.half[3 * k + 1][lane] +
                        g[2] * block.half[3 * k + 2][lane];
    }
  }

  Edges edges[kParts];
  V most = hn::Zero(f);
  for (std::size_t part = 0; part < kParts; ++part) {
    const auto ends = [&](const float(*signs)[kLanes], V& x, V& y) HWY_ATTR {
      const auto at = [&](const float* p) HWY_ATTR {
        V sum = hn::Set(f, p[0]);
        for (std::size_t k = 0; k < 3; ++k)
          sum = hn::Add(sum, hn::Mul(hn::LoadU(f, signs[k] + part * lanes()), hn::Set(f, p[k + 1])));
        return sum;
      };
      const V inverse = hn::Div(hn::Set(f, 1.0F), at(parts[2]));
      x = hn::Mul(at(parts[0]), inverse);
      y = hn::Mul(at(parts[1]), inverse);
      most = hn::Max(most, hn::Max(hn::Abs(x), hn::Abs(y)));
    };
    V ax, ay, bx, by;
    ends(kEdgeSigns.a, ax, ay);
    ends(kEdgeSigns.b, bx, by);
    const M isUp = hn::Le(ay, by);
    edges[part].ax = hn::IfThenElse(isUp, ax, bx);
    edges[part].bx = hn::IfThenElse(isUp, bx, ax);
    edges[part].ay = hn::Min(ay, by);
    edges[part].by = hn::Max(ay, by);
  }
  const float magnitude = std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) + block.extent[lane];
  const float zLeast = parts[2][0] - (std::abs(parts[2][1]) + std::abs(parts[2][2]) + std::abs(parts[2][3]));
  const float farError = frame.farError * hn::GetLane(hn::MaxOfLanes(f, most));
  const float xError = (frame.columnError + farError) * (magnitude / zLeast);
  const float yError = (frame.rowError + farError) * (magnitude / zLeast);
  for (Edges& e : edges) {
    const V height = hn::Sub(e.by, e.ay);
    e.isFlat = hn::Not(hn::Gt(height, hn::Set(f, 4 * yError)));
    e.slope = hn::Div(hn::Sub(e.bx, e.ax), hn::IfThenElse(e.isFlat, hn::Set(f, 1.0F), height));
  }

  const V inf = hn::Set(f, HUGE_VALF);
  bool sparesAny = false;
  for (int row = cells.firstRow; row <= cells.lastRow; ++row) {
    const V low = hn::Set(f, static_cast<float>(row) + (frame.rowLow - 2 * yError));
    const V high = hn::Set(f, static_cast<float>(row) + (frame.rowHigh + 2 * yError));
    V least = inf, last = hn::Neg(inf);
    for (const Edges& e : edges) {
      const V start = hn::Max(e.ay, low), end = hn::Min(e.by, high);
      const M isThere = hn::Le(start, end);
      const auto at = [&](V y, V otherwise) HWY_ATTR {
        return hn::IfThenElse(e.isFlat, otherwise, hn::Add(e.ax, hn::Mul(hn::Sub(y, e.ay), e.slope)));
      };
      const V p = at(start, e.ax), q = at(end, e.bx);
      least = hn::IfThenElse(isThere, hn::Min(least, hn::Min(p, q)), least);
      last = hn::IfThenElse(isThere, hn::Max(last, hn::Max(p, q)), last);
    }
    const float start = hn::GetLane(hn::MinOfLanes(f, least)) - (xError + frame.columnHigh);
    const float end = hn::GetLane(hn::MaxOfLanes(f, last)) + (xError - frame.columnLow);
    const auto firstCell = static_cast<float>(cells.firstColumn),
               lastCell = static_cast<float>(cells.lastColumn);
    const int first = static_cast<int>(std::ceil(std::min(std::max(start, firstCell), lastCell + 1)));
    const int final = static_cast<int>(std::floor(std::max(std::min(end, lastCell), firstCell - 1)));
    const bool isEmpty = first > final;
    spans[row - cells.firstRow] = {static_cast<std::uint8_t>(isEmpty ? 1 : first),
                                   static_cast<std::uint8_t>(isEmpty ? 0 : final)};
    sparesAny = sparesAny || first != cells.firstColumn || final != cells.lastColumn;
  }
  return sparesAny;
}

Kernels makeKernels() {
  return {leaves, leavesCertified, expired, runs, nodes, spans};
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera::cull
HWY_AFTER_NAMESPACE();

#endif  // TESSERA_FOOTPRINT_KERNELS_INL
