#include "proto/protocol_error.h"

#include <utility>

namespace tessera::proto {

std::string_view sentence(ProtocolError error) {
  switch (error) {
    case ProtocolError::BadMagic:
      return "the bytes do not begin with TSRA, so the peer is not a Tessera program";
    case ProtocolError::WrongVersion:
      return "the peer speaks another version of the protocol";
    case ProtocolError::UnknownType:
      return "no message has this type";
    case ProtocolError::UnexpectedType:
      return "this message may not come at this point";
    case ProtocolError::TooLarge:
      return "the payload is larger than its type allows";
    case ProtocolError::BadHeaderChecksum:
      return "the header does not match its checksum";
    case ProtocolError::BadPayloadChecksum:
      return "the payload does not match its checksum";
    case ProtocolError::Truncated:
      return "the bytes end before the message does";
    case ProtocolError::TrailingBytes:
      return "there are bytes after the end of the message";
    case ProtocolError::Misaligned:
      return "the payload does not start at a multiple of 4 bytes in memory";
    case ProtocolError::Malformed:
      return "the payload is not a well-formed FlatBuffer of its type";
    case ProtocolError::BadNumber:
      return "a number is not finite or outside its range";
    case ProtocolError::BadCount:
      return "there are more elements than allowed or than the payload can hold";
    case ProtocolError::BadEnum:
      return "an enumeration has a value without a name";
    case ProtocolError::BadText:
      return "a name or text is empty, too long, or not printable UTF-8";
    case ProtocolError::BadAxes:
      return "the image axes are not two unit vectors at right angles";
    case ProtocolError::BadDepthRange:
      return "near and far are not 0 < near < far";
    case ProtocolError::BadPicture:
      return "the size of a picture is impossible or does not match its bytes";
    case ProtocolError::BadList:
      return "the list delta is not the encoding of a visible list";
  }
  return "unknown protocol error";
}

Error protocolError(ProtocolError error, std::string where, const std::string& detail) {
  std::string what(sentence(error));
  if (!detail.empty()) what += " (" + detail + ")";
  return runtimeError(std::move(where), std::move(what));
}

std::optional<ProtocolError> protocolErrorOf(const Error& error) {
  for (int i = 0; i < kProtocolErrorCount; ++i) {
    const auto candidate = static_cast<ProtocolError>(i);
    if (std::string_view(error.what).starts_with(sentence(candidate))) return candidate;
  }
  return std::nullopt;
}

}  // namespace tessera::proto
