#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "common/hierarchy/visible_list.h"
#include "proto/range_coder.h"

namespace tessera::proto {

/// A part of what toggles, within one interval between boundaries of the list before.
struct TogglePiece {
  std::uint64_t interval = 0;
  std::uint32_t first = 0, last = 0;
};

/// The boundaries of a list cut all leaves into intervals, by turns out of the list (even numbers) and in it
/// (odd ones). The first and the last may be empty.
class ListIntervals {
 public:
  /// `list` must outlive this.
  ListIntervals(const VisibleList& list, std::uint32_t leafCount) : list_(list), leafCount_(leafCount) {}

  [[nodiscard]] std::uint64_t first() const { return !list_.empty() && list_.front().first == 0 ? 1 : 0; }
  [[nodiscard]] std::uint64_t end() const {
    const std::uint64_t all = 2 * std::uint64_t{list_.size()} + 1;
    return leafCount_ == (list_.empty() ? 0 : list_.back().last) ? all - 1 : all;
  }
  [[nodiscard]] LeafRange operator[](std::uint64_t i) const {
    const std::size_t range = static_cast<std::size_t>(i / 2);
    if (i % 2 == 1) return list_[range];
    return {range == 0 ? 0 : list_[range - 1].last, range == list_.size() ? leafCount_ : list_[range].first};
  }

 private:
  const VisibleList& list_;
  std::uint32_t leafCount_;
};

/// Codes one of `choices` numbers that are all as likely; a decoder's may be larger where no encoder has
/// written it.
template <class Coder>
std::uint64_t codeEven(Coder& coder, std::uint64_t number, std::uint64_t choices) {
  if (choices <= kMostChoices)
    return coder.even(static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(choices));
  // From the top, and as if the last part were as large as the others.
  const auto low = static_cast<unsigned>(std::bit_width(choices - 1)) - 16;
  const std::uint64_t high = coder.even(static_cast<std::uint32_t>(number >> low),
                                        static_cast<std::uint32_t>(((choices - 1) >> low) + 1));
  return (high << low) + coder.even(static_cast<std::uint32_t>(number & ((1U << low) - 1)), 1U << low);
}

/// How far on in so many places is the next one of some that lie anywhere.
class StepModel {
 public:
  /// Codes a number from 0 to `most`, where so many pieces are to come. A decoder's may be larger where no
  /// encoder has written it.
  template <class Coder>
  std::uint64_t code(Coder& coder, std::uint64_t step, std::uint64_t most, std::uint32_t pieces) {
    if (pieces == 1) return codeEven(coder, step, most + 1);
    // By strides of about the mean.
    const unsigned stride = std::max(static_cast<unsigned>(std::bit_width(most / pieces)), 1U) - 1;
    auto& more = more_[std::min<std::size_t>(pieces, more_.size() + 1) - 2];
    std::uint64_t strides = 0;
    while (((strides + 1) << stride) <= most &&
           coder.bit(more[std::min<std::size_t>(strides, more.size() - 1)], strides < step >> stride))
      ++strides;
    if (stride == 0) return strides;
    const std::uint64_t base = strides << stride;
    return base + codeEven(coder, step - base, std::min(std::uint64_t{1} << stride, most + 1 - base));
  }

 private:
  std::array<std::array<AdaptiveBit, 8>, 4> more_ = {};  ///< by pieces and by strides
};

/// A whole number: how many bits it has, one decision after the other, then these from the top, of which the
/// first two are learned.
class NumberModel {
 public:
  constexpr NumberModel() = default;
  /// `more[i]` in 256ths: how likely a number of i bits or more has more of them; the last one holds for all
  /// that follow.
  template <std::size_t N>
  constexpr explicit NumberModel(const std::array<std::uint8_t, N>& more) {
    for (std::size_t i = 0; i < more_.size(); ++i)
      more_[i] = AdaptiveBit(more[std::min(i, N - 1)]);
  }

  /// Codes a number from 0 to `most`. A decoder's is `most` + 1 where no encoder has written that.
  template <class Coder>
  std::uint32_t code(Coder& coder, std::uint32_t number, std::uint32_t most) {
    // One more has at least one bit, and its first bit need not be told.
    const std::uint64_t wanted = std::uint64_t{number} + 1;
    const auto width = static_cast<unsigned>(std::bit_width(wanted)) - 1;
    const auto widest = static_cast<unsigned>(std::bit_width(std::uint64_t{most} + 1)) - 1;
    unsigned bits = 0;
    while (bits < widest && coder.bit(more_[std::min<std::size_t>(bits, kLast)], width > bits))
      ++bits;
    auto& top = top_[std::min<std::size_t>(bits, kLast)];
    std::uint64_t value = 1;
    unsigned left = bits;
    for (unsigned told = 0; told < 2 && left > 0; ++told) {
      --left;
      const bool isForced = ((value << 1U | 1U) << left) > std::uint64_t{most} + 1;
      const bool bit =
          !isForced && coder.bit(top[told == 0 ? 0 : 1 + (value & 1U)], ((wanted >> left) & 1U) != 0);
      value = value << 1U | (bit ? 1U : 0U);
    }
    if (left > 0)
      value = (value << left) +
              codeEven(coder, wanted & ((std::uint64_t{1} << left) - 1), std::uint64_t{1} << left);
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(value - 1, std::uint64_t{most} + 1));
  }

 private:
  static constexpr std::size_t kLast = 15;  ///< longer numbers share what is learned
  std::array<AdaptiveBit, kLast + 1> more_ = {};
  std::array<std::array<AdaptiveBit, 3>, kLast + 1> top_ = {};
};

/// What was learned of the deltas of one list, and how a delta is told with it. Encoder and decoder go
/// through the same steps with a Coder each.
class ListModel {
 public:
  /// Codes how many pieces there are, 1 at the least.
  template <class Coder>
  std::uint32_t codeCount(Coder& coder, std::uint32_t count) {
    const std::uint32_t coded = counts_[lastCount_].code(coder, count - 1, kMostCount - 1) + 1;
    lastCount_ = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(coded)), counts_.size()) - 1;
    return coded;
  }

  /// Where a delta has got to.
  struct Place {
    std::uint64_t interval = 0;
    std::uint32_t first = 0;  ///< the leaf from which on pieces may begin
    bool isWithin = false;    ///< after a piece of the same interval
    std::uint32_t left = 0;   ///< pieces to come
  };

  /// Codes the next piece and moves on. False where there is no room for one, which no encoder has written.
  template <class Coder>
  bool codePiece(Coder& coder, const ListIntervals& intervals, Place& place, TogglePiece& piece) {
    if (place.isWithin && place.first >= intervals[place.interval].last) {
      ++place.interval;
      place.isWithin = false;
    }
    const std::uint64_t end = intervals.end();
    if (place.interval >= end || place.left == 0) return false;
    const std::uint64_t most = end - place.interval - 1;
    if (most > 0) {
      const std::uint64_t step = steps_.code(coder, piece.interval - place.interval, most, place.left);
      if (step > most) return false;
      if (step > 0) place.isWithin = false;
      place.interval += step;
    }
    piece.interval = place.interval;
    LeafRange room = intervals[place.interval];
    if (place.isWithin) room.first = place.first;
    if (!codeWithin(coder, room, place, piece)) return false;
    place.isWithin = piece.last < room.last;
    if (place.isWithin) {
      place.first = piece.last + 1;
    } else {
      ++place.interval;
    }
    --place.left;
    return true;
  }

 private:
  /// By the kind of interval: out of the list, in it; each also after a piece of the same interval.
  struct Within {
    std::array<AdaptiveBit, 8> isWhole = {}, isAtFirst = {}, isAtLast = {}, isFromFirst = {};
    NumberModel gap{std::array<std::uint8_t, 1>{150}};
    NumberModel edgeLength{std::array<std::uint8_t, 2>{60, 100}},
        innerLength{std::array<std::uint8_t, 2>{60, 100}};
  };

  template <class Coder>
  bool codeWithin(Coder& coder, LeafRange room, const Place& place, TogglePiece& piece) {
    const std::uint32_t size = room.last - room.first;
    const std::uint32_t length = piece.last - piece.first;
    const auto setTo = [&](std::uint32_t first, std::uint32_t coded) {
      piece.first = first;
      piece.last = first + coded;
    };
    if (size == 1) {
      setTo(room.first, 1);
      return true;
    }
    Within& model = within_[(place.interval % 2) * 2 + (place.isWithin ? 1 : 0)];
    const auto sizeClass = std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(size)) - 2, 7);
    if (coder.bit(model.isWhole[sizeClass], length == size)) {
      setTo(room.first, size);
      return true;
    }
    if (coder.bit(model.isAtFirst[sizeClass], piece.first == room.first)) {
      const std::uint32_t coded = model.edgeLength.code(coder, length - 1, size - 2) + 1;
      if (coded >= size) return false;
      setTo(room.first, coded);
      return true;
    }
    if (size == 2 || coder.bit(model.isAtLast[sizeClass], piece.last == room.last)) {
      const std::uint32_t coded = model.edgeLength.code(coder, length - 1, size - 2) + 1;
      if (coded >= size) return false;
      setTo(room.last - coded, coded);
      return true;
    }
    // Neither end is reached, so that there are three leaves at least. The gap is the shorter one of two.
    const bool isFromFirst = size == 3 || coder.bit(model.isFromFirst[sizeClass],
                                                    piece.first - room.first <= room.last - piece.last);
    const std::uint32_t mostGap = (size - (isFromFirst ? 1 : 2)) / 2;
    const std::uint32_t shorter = isFromFirst ? piece.first - room.first : room.last - piece.last;
    const std::uint32_t gap = model.gap.code(coder, shorter - 1, mostGap - 1) + 1;
    if (gap > mostGap) return false;
    const std::uint32_t mostLength = size - 2 * gap - (isFromFirst ? 0 : 1);
    const std::uint32_t coded = model.innerLength.code(coder, length - 1, mostLength - 1) + 1;
    if (coded > mostLength) return false;
    setTo(isFromFirst ? room.first + gap : room.last - gap - coded, coded);
    return true;
  }

  static constexpr std::uint32_t kMostCount = 0x8000'0000U;
  std::size_t lastCount_ = 0;
  std::array<NumberModel, 6> counts_;
  StepModel steps_;
  std::array<Within, 4> within_;
};

}  // namespace tessera::proto
