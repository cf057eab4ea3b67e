#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/base/result.h"
#include "common/hierarchy/visible_list.h"
#include "proto/list_model.h"

namespace tessera::proto {

// How Frame.toggles are written; PROTOCOL.md says it in full. Both sides keep the list and what they have
// learned of its deltas, so a delta can be read only by a decoder that has read all since the last reset().

/// The master's side of one tile's list.
class ListEncoder {
 public:
  explicit ListEncoder(std::uint32_t leafCount) : leafCount_(leafCount) {}

  /// Back to the empty list and to having learned nothing.
  void reset();
  /// Writes the leaves that come or go, canonical and within the leaf count, to `out`, which is cleared and
  /// refilled; the list moves on. Nothing toggled is no bytes. Does not allocate once warm.
  void encode(const VisibleList& toggled, std::vector<std::byte>& out);

  [[nodiscard]] const VisibleList& list() const { return list_; }

 private:
  std::uint32_t leafCount_;
  ListModel model_;
  VisibleList list_, next_;
  std::vector<TogglePiece> pieces_;
};

/// The tile's side.
class ListDecoder {
 public:
  explicit ListDecoder(std::uint32_t leafCount) : leafCount_(leafCount) {}

  void reset();
  /// Moves the list on. Safe for untrusted bytes: anything that an encoder cannot have written from this list
  /// is refused (ProtocolError::BadList, Truncated or TrailingBytes), and after that only reset() is of use.
  /// The work and the memory are bounded by the list and 64 ranges for each byte.
  [[nodiscard]] Status decode(std::span<const std::byte> bytes);

  /// Canonical and within the leaf count.
  [[nodiscard]] const VisibleList& list() const { return list_; }
  /// What the last decode() has toggled, canonical.
  [[nodiscard]] const VisibleList& toggled() const { return toggled_; }

 private:
  [[nodiscard]] Status readPieces(std::span<const std::byte> bytes);

  std::uint32_t leafCount_;
  ListModel model_;
  VisibleList list_, next_, toggled_;
  std::vector<TogglePiece> pieces_;
};

/// The first byte of a delta in the plain form: a list delta of list_codec.h from the empty list follows.
inline constexpr std::byte kPlainDelta{0xFF};
/// A delta has no more pieces than this: so nobody is made to keep much by little.
[[nodiscard]] constexpr std::uint64_t mostPieces(std::size_t bytes) {
  return 64 + 64 * std::uint64_t{bytes};
}

}  // namespace tessera::proto
