#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/base/result.h"

namespace tessera::proto {

/// Every reason for which bytes from a peer are refused.
enum class ProtocolError {
  BadMagic,
  WrongVersion,
  UnknownType,
  UnexpectedType,
  TooLarge,
  BadHeaderChecksum,
  BadPayloadChecksum,
  Truncated,
  TrailingBytes,
  Misaligned,
  Malformed,
  BadNumber,
  BadCount,
  BadEnum,
  BadText,
  BadAxes,
  BadDepthRange,
  BadPicture,
  BadList,
};

inline constexpr int kProtocolErrorCount = static_cast<int>(ProtocolError::BadList) + 1;

/// One English sentence, without a final stop; no sentence begins another.
[[nodiscard]] std::string_view sentence(ProtocolError error);

/// An Error of the runtime kind whose `what` is the sentence, with `detail` in brackets where there is one.
/// `where` names the message ("Frame message").
[[nodiscard]] Error protocolError(ProtocolError error, std::string where, const std::string& detail = {});

/// Which ProtocolError an Error was made from; nothing if it was made by other means.
[[nodiscard]] std::optional<ProtocolError> protocolErrorOf(const Error& error);

}  // namespace tessera::proto
