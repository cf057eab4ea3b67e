#include "proto/utf8.h"

#include <algorithm>

namespace tessera::proto {

namespace {

unsigned byteAt(std::string_view text, std::size_t at) {
  return static_cast<unsigned char>(text[at]);
}

bool isContinuation(unsigned byte) {
  return (byte & 0xC0U) == 0x80U;
}

std::size_t lengthByLead(unsigned lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return 2;
  if (lead >= 0xE0 && lead <= 0xEF) return 3;
  if (lead >= 0xF0 && lead <= 0xF4) return 4;
  return 0;
}

// Some leads narrow the second byte, which keeps out overlong forms, surrogates and what is past U+10FFFF.
bool isSecondByte(unsigned lead, unsigned second) {
  if (!isContinuation(second)) return false;
  if (lead == 0xE0) return second >= 0xA0;
  if (lead == 0xED) return second <= 0x9F;
  if (lead == 0xF0) return second >= 0x90;
  if (lead == 0xF4) return second <= 0x8F;
  return true;
}

/// Bytes of the well-formed character at the front of `text`, which is not empty; 0 where there is none.
std::size_t characterBytes(std::string_view text) {
  const unsigned lead = byteAt(text, 0);
  const std::size_t length = lengthByLead(lead);
  if (length > text.size()) return 0;
  if (length > 1 && !isSecondByte(lead, byteAt(text, 1))) return 0;
  for (std::size_t i = 2; i < length; ++i) {
    if (!isContinuation(byteAt(text, i))) return 0;
  }
  return length;
}

}  // namespace

bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = characterBytes(text);
    if (length == 0) return false;
    text.remove_prefix(length);
  }
  return true;
}

bool hasControlCharacter(std::string_view text) {
  return std::any_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte < 0x20 || byte == 0x7F;
  });
}

std::string fitUtf8(std::string_view text, std::size_t maxBytes) {
  std::string fit;
  while (!text.empty()) {
    const std::size_t length = characterBytes(text);
    const std::size_t taken = std::max<std::size_t>(length, 1);
    if (fit.size() + taken > maxBytes) break;
    if (length == 0) {
      fit += '?';
    } else {
      fit += text.substr(0, length);
    }
    text.remove_prefix(taken);
  }
  return fit;
}

}  // namespace tessera::proto
