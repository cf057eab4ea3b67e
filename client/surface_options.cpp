#include "client/surface_options.h"

#include <charconv>
#include <string_view>

namespace tessera {

namespace {

constexpr int kMaxPlacePx = 1 << 16;

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

Result<WindowPlace> parseWindowPlace(const std::string& text) {
  std::string_view rest = text;
  const bool hasSize = text.find('x') != std::string::npos;
  const auto x = takeNumber(rest, ",", -kMaxPlacePx, kMaxPlacePx);
  const auto y = x ? takeNumber(rest, hasSize ? "," : "", -kMaxPlacePx, kMaxPlacePx) : std::nullopt;
  const auto width = y && hasSize ? takeNumber(rest, "x", 1, proto::kMaxImagePx) : std::nullopt;
  const auto height = width ? takeNumber(rest, "", 1, proto::kMaxImagePx) : std::nullopt;
  if (!y || (hasSize && !height)) {
    return inputError("--window", "\"" + text + "\" is neither X,Y nor X,Y,WxH",
                      "for example --window 1920,0 or --window 0,0,960x540");
  }
  WindowPlace place{.xPx = *x, .yPx = *y};
  if (hasSize) place.size = PixelSize{*width, *height};
  return place;
}

}  // namespace tessera
