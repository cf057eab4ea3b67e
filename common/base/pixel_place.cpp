#include "common/base/pixel_place.h"

#include <charconv>
#include <string_view>

namespace tessera {

namespace {

constexpr int kMostPlacePx = 1 << 16, kMostSidePx = 16384;

/// Takes a number and what must follow it (nothing: the end) off the front of `text`.
std::optional<int> takeNumber(std::string_view& text, std::string_view separator, int least, int most) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < least || number > most) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (separator.empty() ? !text.empty() : !text.starts_with(separator)) return std::nullopt;
  text.remove_prefix(separator.size());
  return number;
}

}  // namespace

std::string textOf(PixelSize size) {
  return std::to_string(size.widthPx) + "x" + std::to_string(size.heightPx);
}

Result<PixelPlace> parsePixelPlace(const std::string& flag, const std::string& text) {
  std::string_view rest = text;
  const bool hasSize = text.find('x') != std::string::npos;
  const auto x = takeNumber(rest, ",", -kMostPlacePx, kMostPlacePx);
  const auto y = x ? takeNumber(rest, hasSize ? "," : "", -kMostPlacePx, kMostPlacePx) : std::nullopt;
  const auto width = y && hasSize ? takeNumber(rest, "x", 1, kMostSidePx) : std::nullopt;
  const auto height = width ? takeNumber(rest, "", 1, kMostSidePx) : std::nullopt;
  if (!y || (hasSize && !height)) {
    return inputError(flag, "\"" + text + "\" is neither X,Y nor X,Y,WxH",
                      "for example " + flag + " 1920,0 or " + flag + " 0,0,960x540");
  }
  PixelPlace place{.xPx = *x, .yPx = *y};
  if (hasSize) place.size = PixelSize{*width, *height};
  return place;
}

}  // namespace tessera
