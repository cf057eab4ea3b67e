#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/hierarchy/visible_list.h"

namespace tessera::proto {

// A list delta is the set of leaves that are in exactly one of two visible lists, itself written as a
// canonical visible list of ranges [first, last):
//
//   varint  rangeCount
//   varint  first of range 0;              varint  last - first - 1
//   varint  first - last of the one before - 1;   varint  last - first - 1      for each further range
//
// A varint is LEB128 in its shortest form. As gaps and lengths are written less one, every sequence of
// numbers that stays within leafCount is a canonical list: there is exactly one encoding for each delta.

/// The bytes that lead from `before` to `now`; both must be canonical. `out` is cleared and refilled, so its
/// capacity is reused.
void encodeListDelta(const VisibleList& before, const VisibleList& now, std::vector<std::byte>& out);

/// The same bytes where the delta itself is known: `toggled` are the leaves in exactly one of the two lists,
/// canonical.
void encodeToggles(const VisibleList& toggled, std::vector<std::byte>& out);

/// Applies a delta. Safe for untrusted bytes: anything but the one encoding of a delta within `leafCount` is
/// refused (ProtocolError::BadList, Truncated or TrailingBytes). `before` must be canonical and within
/// `leafCount`; the result then is, too. Its size is at most before.size() + delta.size() / 2.
[[nodiscard]] Result<VisibleList> applyListDelta(const VisibleList& before, std::span<const std::byte> delta,
                                                 std::uint32_t leafCount);

/// The same into `out`, whose capacity is reused; it must not be `before`. Empty after a failure.
[[nodiscard]] Status applyListDeltaInto(const VisibleList& before, std::span<const std::byte> delta,
                                        std::uint32_t leafCount, VisibleList& out);

}  // namespace tessera::proto
