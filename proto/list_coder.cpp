#include "proto/list_coder.h"

#include <algorithm>
#include <cstring>

#include "proto/list_codec.h"
#include "proto/protocol_error.h"

namespace tessera::proto {

namespace {

/// Copies boundaries of a list, which are what lies in it one after the other, with changes.
class BoundaryCopy {
 public:
  BoundaryCopy(const VisibleList& from, std::size_t mostRanges, VisibleList& to) : from_(from), to_(to) {
    to_.resize(mostRanges);
  }
  void copyUntil(std::uint64_t boundary) {
    const auto count = static_cast<std::size_t>(boundary - read_);
    // A range is its two boundaries.
    static_assert(sizeof(LeafRange) == 2 * sizeof(std::uint32_t));
    if (count == 0) return;
    std::memcpy(at(written_),
                reinterpret_cast<const std::byte*>(from_.data()) + read_ * sizeof(std::uint32_t),
                count * sizeof(std::uint32_t));
    read_ += count;
    written_ += count;
  }
  void skip() { ++read_; }
  void insert(std::uint32_t leaf) { std::memcpy(at(written_++), &leaf, sizeof leaf); }
  void finish() {
    copyUntil(2 * from_.size());
    to_.resize(written_ / 2);
  }

 private:
  std::byte* at(std::size_t boundary) {
    return reinterpret_cast<std::byte*>(to_.data()) + boundary * sizeof(std::uint32_t);
  }
  const VisibleList& from_;
  VisibleList& to_;
  std::size_t read_ = 0, written_ = 0;
};

/// `from` after pieces of it have toggled, which cost what they are and no more than a copy for the rest.
void toggleInto(const VisibleList& from, std::uint32_t leafCount, std::span<const TogglePiece> pieces,
                VisibleList& out) {
  const ListIntervals intervals(from, leafCount);
  BoundaryCopy copy(from, from.size() + pieces.size(), out);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const TogglePiece& piece = pieces[i];
    const LeafRange interval = intervals[piece.interval];
    // Interval i lies between the boundaries i - 1 and i. Where pieces meet, the boundary between them stays.
    if (i == 0 || pieces[i - 1].last != piece.first) {
      if (piece.first == interval.first && piece.interval > 0) {
        copy.copyUntil(piece.interval - 1);
        copy.skip();
      } else {
        copy.copyUntil(piece.interval);
        copy.insert(piece.first);
      }
    }
    if (i + 1 == pieces.size() || pieces[i + 1].first != piece.last) {
      copy.copyUntil(piece.interval);
      if (piece.last == interval.last && piece.interval < 2 * from.size()) {
        copy.skip();
      } else {
        copy.insert(piece.last);
      }
    }
  }
  copy.finish();
}

Error refused(ProtocolError error, const char* detail = "") {
  return protocolError(error, "list delta", detail);
}

/// The first range from `from` on that ends after `leaf`.
std::size_t rangeEndingAfter(const VisibleList& list, std::size_t from, std::uint32_t leaf) {
  // Without branches: which half it is cannot be predicted.
  std::size_t count = list.size() - from;
  while (count > 0) {
    const std::size_t half = (count + 1) / 2;
    from += list[from + half - 1].last <= leaf ? half : 0;
    count -= half;
  }
  return from;
}

/// Cuts what toggles at the boundaries of the list.
void cutToggles(const VisibleList& list, std::uint32_t leafCount, const VisibleList& toggled,
                std::vector<TogglePiece>& pieces) {
  pieces.clear();
  std::size_t range = 0;
  for (const LeafRange run : toggled) {
    range = rangeEndingAfter(list, range, run.first);
    for (std::uint32_t first = run.first; first < run.last;) {
      const bool isLast = range == list.size();
      const bool isIn = !isLast && first >= list[range].first;
      const std::uint32_t boundary = isLast ? leafCount : isIn ? list[range].last : list[range].first;
      const std::uint32_t last = std::min(run.last, boundary);
      pieces.push_back({.interval = 2 * std::uint64_t{range} + (isIn ? 1 : 0), .first = first, .last = last});
      first = last;
      if (isIn && last == boundary) ++range;
    }
  }
}

}  // namespace

void ListEncoder::reset() {
  model_ = ListModel();
  list_.clear();
}

void ListEncoder::encode(const VisibleList& toggled, std::vector<std::byte>& out) {
  out.clear();
  if (toggled.empty()) return;
  cutToggles(list_, leafCount_, toggled, pieces_);
  RangeEncoder coder(out);
  model_.codeCount(coder, static_cast<std::uint32_t>(pieces_.size()));
  const ListIntervals intervals(list_, leafCount_);
  ListModel::Place place = {.interval = intervals.first(),
                            .left = static_cast<std::uint32_t>(pieces_.size())};
  for (TogglePiece& piece : pieces_)
    model_.codePiece(coder, intervals, place, piece);
  coder.finish();
  if (pieces_.size() > mostPieces(out.size())) {
    encodeToggles(toggled, out);
    out.insert(out.begin(), kPlainDelta);
    model_ = ListModel();
  }
  toggleInto(list_, leafCount_, pieces_, next_);
  std::swap(list_, next_);
}

void ListDecoder::reset() {
  model_ = ListModel();
  list_.clear();
}

Status ListDecoder::decode(std::span<const std::byte> bytes) {
  toggled_.clear();
  if (bytes.empty()) return Done{};
  const bool isPlain = bytes.front() == kPlainDelta;
  Status status =
      isPlain ? applyListDeltaInto({}, bytes.subspan(1), leafCount_, toggled_) : readPieces(bytes);
  if (!status) {
    toggled_.clear();
    return status;
  }
  if (isPlain) {
    cutToggles(list_, leafCount_, toggled_, pieces_);
    model_ = ListModel();
  } else {
    for (const TogglePiece& piece : pieces_)
      appendRange(toggled_, {piece.first, piece.last});
  }
  toggleInto(list_, leafCount_, pieces_, next_);
  std::swap(list_, next_);
  return Done{};
}

Status ListDecoder::readPieces(std::span<const std::byte> bytes) {
  RangeDecoder coder(bytes);
  const std::uint32_t count = model_.codeCount(coder, 1);
  if (count > mostPieces(bytes.size()))
    return refused(ProtocolError::BadList, "too many pieces for its bytes");
  const ListIntervals intervals(list_, leafCount_);
  ListModel::Place place = {.interval = intervals.first(), .left = count};
  pieces_.clear();
  while (place.left > 0) {
    if (coder.isPastEnd()) return refused(ProtocolError::Truncated);
    TogglePiece& piece = pieces_.emplace_back();
    if (!model_.codePiece(coder, intervals, place, piece))
      return refused(ProtocolError::BadList, "a leaf id is too large");
  }
  if (!coder.isExact()) {
    return coder.isPastEnd() ? refused(ProtocolError::Truncated)
                             : refused(ProtocolError::BadList, "it ends otherwise than it should");
  }
  return Done{};
}

}  // namespace tessera::proto
