#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tessera::proto {

/// True for well-formed UTF-8 (Unicode 15, table 3-7): no overlong forms, no surrogates, nothing past
/// U+10FFFF.
[[nodiscard]] bool isUtf8(std::string_view text);

/// True where the text has a C0 control character or DEL.
[[nodiscard]] bool hasControlCharacter(std::string_view text);

/// The text with each byte that is no part of well-formed UTF-8 replaced by '?', cut to at most `maxBytes`
/// without splitting a character.
[[nodiscard]] std::string fitUtf8(std::string_view text, std::size_t maxBytes);

}  // namespace tessera::proto
