#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tessera::proto {

/// How likely a yes-or-no is to be yes, learned from those there were: fast at first, slower as they add up.
class AdaptiveBit {
 public:
  constexpr AdaptiveBit() = default;
  /// `yes` in 256ths, 1 to 255; stands for a few observations.
  constexpr explicit AdaptiveBit(std::uint8_t yes) : state_(static_cast<std::uint16_t>(yes << 8U | 2U)) {}

  /// In 4096ths, at least 16 and at most 4080.
  [[nodiscard]] std::uint32_t yes() const { return state_ >> kSeenBits; }
  void learn(bool wasYes) {
    const std::uint32_t seen = state_ & kMostSeen;
    const std::int32_t goal = wasYes ? 4096 - kMargin : kMargin;
    const auto now = static_cast<std::int32_t>(yes());
    const std::int32_t next = now + (goal - now) * kShare[seen] / 4096;
    state_ = static_cast<std::uint16_t>(static_cast<std::uint32_t>(next) << kSeenBits |
                                        (seen + (seen < kMostSeen ? 1U : 0U)));
  }

 private:
  static constexpr unsigned kSeenBits = 4;
  static constexpr std::uint32_t kMostSeen = 15;
  static constexpr std::int32_t kMargin = 16;
  /// What share of the distance a decision takes, in 4096ths, by how many there were before.
  static constexpr std::array<std::int32_t, kMostSeen + 1> kShare = {
      2048, 1365, 1024, 819, 683, 585, 512, 455, 410, 342, 293, 256, 216, 178, 152, 128};
  std::uint16_t state_ = 2048U << kSeenBits;  ///< the chance and, in the low bits, the decisions there were
};

// An arithmetic coder of binary decisions in integers. A message is a number in [0, 255/256), written to base
// 256 from the first place behind the point; zeros follow after the last byte. No message begins with the
// byte 0xFF, which is left for other forms.
//
// Each decision cuts the interval that is left in two. The window is the 32 bits in which it still has a
// width of 24 bits at least.

/// Where a message of the interval [low, low + range) of the window ends: the shortest number in it.
struct RangeEnd {
  unsigned bytes = 0;        ///< of the window that are written, 0 to 4
  std::uint64_t number = 0;  ///< at least low; may be 2^32, which is a carry
};
[[nodiscard]] inline RangeEnd endOfRange(std::uint32_t low, std::uint32_t range) {
  for (unsigned bytes = 0;; ++bytes) {
    const std::uint64_t unit = std::uint64_t{1} << (32 - 8 * bytes);
    const std::uint64_t number = (low + unit - 1) / unit * unit;
    if (number < std::uint64_t{low} + range) return {bytes, number};
  }
}

inline constexpr std::uint32_t kWholeRange = 0xFF00'0000U;
inline constexpr std::uint32_t kLeastRange = 0x0100'0000U;
inline constexpr std::uint32_t kMostChoices = 1U << 16U;

class RangeEncoder {
 public:
  /// Appends to `out`, which must outlive this and be empty.
  explicit RangeEncoder(std::vector<std::byte>& out) : out_(out) { assert(out.empty()); }

  bool bit(AdaptiveBit& model, bool yes) {
    const std::uint32_t part = (range_ >> 12U) * model.yes();
    choose(yes, part);
    model.learn(yes);
    return yes;
  }
  /// One of `choices` numbers, at most kMostChoices, that are all as likely.
  std::uint32_t even(std::uint32_t number, std::uint32_t choices) {
    range_ /= choices;
    moveUp(number * range_);
    return number;
  }
  /// To be called once, at the end.
  void finish() {
    const RangeEnd end = endOfRange(low_, range_);
    if (end.number > UINT32_MAX) carry();
    for (unsigned i = 0; i < end.bytes; ++i)
      out_.push_back(static_cast<std::byte>(end.number >> (24 - 8 * i)));
  }

 private:
  void choose(bool yes, std::uint32_t part) {
    // Without branches: which it is cannot be predicted.
    const std::uint32_t skipped = yes ? 0 : part;
    range_ = yes ? part : range_ - part;
    moveUp(skipped);
  }
  void moveUp(std::uint32_t skipped) {
    low_ += skipped;
    if (low_ < skipped) carry();
    while (range_ < kLeastRange) {
      out_.push_back(static_cast<std::byte>(low_ >> 24U));
      low_ <<= 8U;
      range_ <<= 8U;
    }
  }
  /// There is a byte below 0xFF to carry to, for the number stays below 255/256.
  void carry() {
    std::size_t i = out_.size();
    do {
      --i;
      out_[i] = static_cast<std::byte>(std::to_integer<unsigned>(out_[i]) + 1);
    } while (out_[i] == std::byte{0});
  }

  std::vector<std::byte>& out_;
  std::uint32_t low_ = 0, range_ = kWholeRange;
};

/// Reads what a RangeEncoder has written. Any bytes decode to something; isExact() tells whether they are
/// what an encoder would have written.
class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const std::byte> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i)
      number_ = number_ << 8U | nextByte();
    above_ = number_;
  }

  bool bit(AdaptiveBit& model, bool = false) {
    const bool yes = choose((range_ >> 12U) * model.yes());
    model.learn(yes);
    return yes;
  }
  std::uint32_t even(std::uint32_t, std::uint32_t choices) {
    range_ /= choices;
    std::uint32_t number = above_ / range_;
    if (number >= choices) {  // beyond the last one, by what the division has left over
      isBroken_ = true;
      number = choices - 1;
    }
    above_ -= number * range_;
    fill();
    return number;
  }

  /// Whether the bytes have run out so far that no encoder's would have.
  [[nodiscard]] bool isPastEnd() const { return at_ > bytes_.size() + 4; }
  /// Whether the bytes end where, and as, an encoder's do that has written what was read.
  [[nodiscard]] bool isExact() const {
    const RangeEnd end = endOfRange(number_ - above_, range_);
    const std::size_t shifted = at_ - 4;
    return !isBroken_ && bytes_.size() == shifted + end.bytes &&
           end.number - (number_ - above_) == std::uint64_t{above_};
  }

 private:
  bool choose(std::uint32_t part) {
    const bool yes = above_ < part;
    above_ -= yes ? 0 : part;
    range_ = yes ? part : range_ - part;
    fill();
    return yes;
  }
  void fill() {
    while (range_ < kLeastRange) {
      const std::uint32_t byte = nextByte();
      number_ = number_ << 8U | byte;
      above_ = above_ << 8U | byte;
      range_ <<= 8U;
    }
  }
  std::uint32_t nextByte() {
    const std::size_t i = at_++;
    return i < bytes_.size() ? std::to_integer<std::uint32_t>(bytes_[i]) : 0;
  }

  std::span<const std::byte> bytes_;
  bool isBroken_ = false;
  std::size_t at_ = 0;
  std::uint32_t number_ = 0;  ///< the window
  std::uint32_t above_ = 0;   ///< what of it is above the interval's lower end
  std::uint32_t range_ = kWholeRange;
};

}  // namespace tessera::proto
