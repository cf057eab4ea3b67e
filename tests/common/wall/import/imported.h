#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "common/wall/import/wall_import.h"

namespace tessera::test {

/// The wall file that importing `text` gives, parsed; null and a failed test where it gives none.
inline nlohmann::json imported(std::string_view text, const std::string& name) {
  const Result<ImportedWall> wall = importWallText(text, name);
  if (!wall) {
    ADD_FAILURE() << wall.error().text();
    return nullptr;
  }
  return nlohmann::json::parse(wall->json, nullptr, true, /*ignore_comments=*/true);
}

inline std::string errorOf(std::string_view text, const std::string& name) {
  const Result<ImportedWall> wall = importWallText(text, name);
  return wall ? "no error" : wall.error().text();
}

/// All warnings, one a line.
inline std::string warningsOf(std::string_view text, const std::string& name) {
  const Result<ImportedWall> wall = importWallText(text, name);
  if (!wall) return "error: " + wall.error().text();
  std::string all;
  for (const std::string& warning : wall->warnings)
    all += warning + '\n';
  return all;
}

inline bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

/// `text` with the first `from` replaced.
inline std::string with(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) ADD_FAILURE() << "the test's text has no \"" << from << '"';
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

inline void expectPoint(const nlohmann::json& point, double x, double y, double z) {
  ASSERT_EQ(point.size(), 3u);
  EXPECT_NEAR(point[0], x, 1e-6);
  EXPECT_NEAR(point[1], y, 1e-6);
  EXPECT_NEAR(point[2], z, 1e-6);
}

inline void expectPair(const nlohmann::json& pair, double x, double y) {
  ASSERT_EQ(pair.size(), 2u);
  EXPECT_NEAR(pair[0], x, 1e-6);
  EXPECT_NEAR(pair[1], y, 1e-6);
}

}  // namespace tessera::test
