#include "proto/list_codec.h"

#include <cassert>
#include <cstddef>
#include <optional>

#include "proto/protocol_error.h"

namespace tessera::proto {

namespace {

constexpr std::size_t kMaxVarintBytes = 5;  // of 32 bits

void appendVarint(std::uint32_t number, std::vector<std::byte>& out) {
  while (number >= 0x80U) {
    out.push_back(static_cast<std::byte>((number & 0x7FU) | 0x80U));
    number >>= 7U;
  }
  out.push_back(static_cast<std::byte>(number));
}

std::size_t boundaryCount(const VisibleList& list) {
  return 2 * list.size();
}

std::uint32_t boundaryAt(const VisibleList& list, std::size_t i) {
  return i % 2 == 0 ? list[i / 2].first : list[i / 2].last;
}

/// Calls visit(boundary) for each place where exactly one of two canonical lists begins or ends a range: the
/// boundaries of their symmetric difference, ascending.
template <class Visit>
void forEachDifferingBoundary(const VisibleList& a, const VisibleList& b, Visit visit) {
  std::size_t i = 0, j = 0;
  const std::size_t countA = boundaryCount(a), countB = boundaryCount(b);
  while (i < countA && j < countB) {
    const std::uint32_t atA = boundaryAt(a, i), atB = boundaryAt(b, j);
    if (atA < atB) visit(atA);
    if (atB < atA) visit(atB);
    if (atA <= atB) ++i;
    if (atB <= atA) ++j;
  }
  for (; i < countA; ++i)
    visit(boundaryAt(a, i));
  for (; j < countB; ++j)
    visit(boundaryAt(b, j));
}

std::uint32_t countDifferingRanges(const VisibleList& a, const VisibleList& b) {
  std::uint32_t boundaries = 0;
  forEachDifferingBoundary(a, b, [&](std::uint32_t) { ++boundaries; });
  return boundaries / 2;
}

Error listError(ProtocolError error, const char* detail = "") {
  return protocolError(error, "list delta", detail);
}

/// Reads the ranges of a delta one after the other; the first failure stays.
class DeltaReader {
 public:
  DeltaReader(std::span<const std::byte> bytes, std::uint32_t leafCount)
      : rest_(bytes), leafCount_(leafCount) {
    rangesLeft_ = varint();
    // Each range takes two bytes at least, which bounds all later work by what was really sent.
    if (!failure_ && rangesLeft_ > rest_.size() / 2) failure_ = listError(ProtocolError::Truncated);
  }

  /// The next range; nothing at the end or after a failure.
  std::optional<LeafRange> next() {
    if (failure_ || rangesLeft_ == 0) return std::nullopt;
    --rangesLeft_;
    // A later range starts one past the end of the one before at the least: that they do not touch.
    const std::uint64_t first = end_ + (isFirst_ ? 0U : 1U) + varint();
    const std::uint64_t last = first + varint() + 1U;
    if (!failure_ && last > leafCount_)
      failure_ = listError(ProtocolError::BadList, "a leaf id is too large");
    if (failure_) return std::nullopt;
    isFirst_ = false;
    end_ = last;
    return LeafRange{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(last)};
  }

  /// To be asked when next() has given nothing.
  Status finish() const {
    if (failure_) return *failure_;
    if (!rest_.empty()) return listError(ProtocolError::TrailingBytes);
    return Done{};
  }

 private:
  std::uint32_t varint() {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < kMaxVarintBytes && !failure_; ++i) {
      if (i >= rest_.size()) {
        failure_ = listError(ProtocolError::Truncated);
        return 0;
      }
      const auto byte = std::to_integer<std::uint64_t>(rest_[i]);
      number |= (byte & 0x7FU) << (7U * i);
      if ((byte & 0x80U) == 0) return endVarint(number, i + 1, byte);
    }
    if (!failure_) failure_ = listError(ProtocolError::BadList, "a number is too long");
    return 0;
  }

  std::uint32_t endVarint(std::uint64_t number, std::size_t bytes, std::uint64_t lastByte) {
    const bool isOverlong = bytes > 1 && lastByte == 0;
    if (isOverlong || number > UINT32_MAX) {
      failure_ =
          listError(ProtocolError::BadList, isOverlong ? "a number is padded" : "a number is too large");
      return 0;
    }
    rest_ = rest_.subspan(bytes);
    return static_cast<std::uint32_t>(number);
  }

  std::span<const std::byte> rest_;
  std::uint32_t leafCount_;
  std::uint32_t rangesLeft_ = 0;
  std::uint64_t end_ = 0;
  bool isFirst_ = true;
  std::optional<Error> failure_;
};

/// Collects ascending boundaries into ranges.
class RangeCollector {
 public:
  explicit RangeCollector(VisibleList& out) : out_(out) {}

  void add(std::uint32_t boundary) {
    if (isOpen_) out_.push_back({first_, boundary});
    first_ = boundary;
    isOpen_ = !isOpen_;
  }

 private:
  VisibleList& out_;
  std::uint32_t first_ = 0;
  bool isOpen_ = false;
};

/// Merges the boundaries of a list, taken up to a limit, with boundaries that come from outside: a boundary
/// in both cancels out.
class BoundaryMerger {
 public:
  BoundaryMerger(const VisibleList& before, VisibleList& out)
      : before_(before), count_(boundaryCount(before)), collector_(out) {}

  void toggle(std::uint32_t boundary) {
    while (at_ < count_ && boundaryAt(before_, at_) < boundary)
      collector_.add(boundaryAt(before_, at_++));
    if (at_ < count_ && boundaryAt(before_, at_) == boundary) {
      ++at_;
    } else {
      collector_.add(boundary);
    }
  }

  void finish() {
    while (at_ < count_)
      collector_.add(boundaryAt(before_, at_++));
  }

 private:
  const VisibleList& before_;
  std::size_t count_;
  std::size_t at_ = 0;
  RangeCollector collector_;
};

}  // namespace

void encodeListDelta(const VisibleList& before, const VisibleList& now, std::vector<std::byte>& out) {
  out.clear();
  appendVarint(countDifferingRanges(before, now), out);
  // The first boundary is written as it is; every other one is at least one above the boundary before it.
  std::uint32_t least = 0;
  forEachDifferingBoundary(before, now, [&](std::uint32_t boundary) {
    appendVarint(boundary - least, out);
    least = boundary + 1;
  });
}

void encodeToggles(const VisibleList& toggled, std::vector<std::byte>& out) {
  out.clear();
  appendVarint(static_cast<std::uint32_t>(toggled.size()), out);
  std::uint32_t least = 0;
  for (const LeafRange range : toggled) {
    appendVarint(range.first - least, out);
    appendVarint(range.last - range.first - 1, out);
    least = range.last + 1;
  }
}

Status applyListDeltaInto(const VisibleList& before, std::span<const std::byte> delta,
                          std::uint32_t leafCount, VisibleList& out) {
  assert(&before != &out);
  out.clear();
  if (!before.empty() && before.back().last > leafCount) {
    return listError(ProtocolError::BadList, "the list before is of another scene");
  }
  DeltaReader reader(delta, leafCount);
  BoundaryMerger merger(before, out);
  while (const std::optional<LeafRange> range = reader.next()) {
    merger.toggle(range->first);
    merger.toggle(range->last);
  }
  Status status = reader.finish();
  if (status) {
    merger.finish();
  } else {
    out.clear();
  }
  return status;
}

Result<VisibleList> applyListDelta(const VisibleList& before, std::span<const std::byte> delta,
                                   std::uint32_t leafCount) {
  VisibleList now;
  if (Status status = applyListDeltaInto(before, delta, leafCount, now); !status) return status.error();
  return now;
}

}  // namespace tessera::proto
