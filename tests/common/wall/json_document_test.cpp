#include "common/wall/json_document.h"

#include <string>

#include <gtest/gtest.h>

#include "common/wall/json_reader.h"

namespace tessera {
namespace {

Result<JsonDocument> parsed(std::string_view text) {
  return JsonDocument::parse(text, "f.json");
}

std::string errorOf(std::string_view text) {
  const Result<JsonDocument> document = parsed(text);
  return document ? "no error" : document.error().text();
}

std::string whereOf(std::string_view text) {
  const Result<JsonDocument> document = parsed(text);
  return document ? "no error" : document.error().where;
}

TEST(JsonDocument, knowsTheLineOfEveryValue) {
  const Result<JsonDocument> document = parsed(
      "// comment\n"
      "{\n"
      "  \"a\": 1,\n"
      "  \"b\":\n"
      "    -2.5e0\n"
      "  ,\n"
      "  \"c\": [ 3\n"
      "    , true /* two\n"
      "lines */, null, \"s\", {}\n"
      "  ]}\n");
  ASSERT_TRUE(document.ok()) << document.error().text();
  const JsonValue root = document->root();
  EXPECT_EQ(root.kind(), JsonKind::Object);
  EXPECT_EQ(root.line(), 2);
  EXPECT_EQ(root.find("a")->line(), 3);
  EXPECT_EQ(root.find("b")->keyLine(), 4);
  EXPECT_EQ(root.find("b")->line(), 5);
  EXPECT_EQ(root.find("b")->number(), -2.5);
  const std::vector<JsonValue> elements = root.find("c")->children();
  ASSERT_EQ(elements.size(), 5u);
  EXPECT_EQ(elements[0].line(), 7);
  EXPECT_EQ(elements[1].line(), 8);
  EXPECT_TRUE(elements[1].isTrue());
  EXPECT_EQ(elements[1].number(), 0) << "a truth value is no number";
  EXPECT_FALSE(elements[0].isTrue());
  EXPECT_EQ(elements[2].line(), 9);
  EXPECT_EQ(elements[3].string(), "s");
  EXPECT_EQ(elements[4].kind(), JsonKind::Object);
  EXPECT_TRUE(elements[4].children().empty());
  EXPECT_FALSE(root.find("d").has_value());
  EXPECT_FALSE(elements[0].find("a").has_value());
}

TEST(JsonDocument, findLooksAtOneLevelOnly) {
  const Result<JsonDocument> document = parsed(R"({"a": {"b": 1, "c": [{"b": 2}]}, "b": 3})");
  ASSERT_TRUE(document.ok());
  EXPECT_EQ(document->root().find("b")->number(), 3);
  EXPECT_EQ(document->root().find("a")->find("b")->number(), 1);
}

TEST(JsonDocument, acceptsByteOrderMarkAndWindowsLineEnds) {
  const Result<JsonDocument> document = parsed("\xEF\xBB\xBF{\r\n\"a\":\r\n1}\r\n");
  ASSERT_TRUE(document.ok()) << document.error().text();
  EXPECT_EQ(document->root().find("a")->line(), 3);
}

TEST(JsonDocument, refusesDuplicateKeysAndNamesBothPlaces) {
  const std::string text = errorOf("{\n\"a\": 1,\n\"b\": {\"a\": 2},\n\"a\": 3}");
  EXPECT_NE(text.find("f.json:4: the key \"a\""), std::string::npos) << text;
  EXPECT_NE(text.find("first on line 2"), std::string::npos) << text;
}

TEST(JsonDocument, syntaxErrorsGiveTheRightLine) {
  EXPECT_EQ(whereOf("{\n\"a\": 1\n\"b\": 2\n}\n"), "f.json:3");
  EXPECT_EQ(whereOf("{\n\"a\": 1,\n}\n"), "f.json:3");
  EXPECT_EQ(whereOf("[\n1,\n2"), "f.json:3");
  EXPECT_EQ(whereOf("{\n\"a\": \"open\n\n\n}"), "f.json:2");
  EXPECT_EQ(whereOf("{\n\n\"a\": NaN}"), "f.json:3");
  EXPECT_EQ(whereOf("{\n\n\"a\": Infinity}"), "f.json:3");
  EXPECT_EQ(whereOf("[1,\n1e999,\n2]"), "f.json:2");
  EXPECT_EQ(whereOf("[1,\n-1e999\n]"), "f.json:2");
  EXPECT_EQ(whereOf("{}\n{}"), "f.json:2");
  EXPECT_EQ(whereOf("{\n/* never\nclosed"), "f.json:3");
}

TEST(JsonDocument, refusesEmptyFilesInvalidUtf8AndNul) {
  EXPECT_EQ(errorOf("").rfind("f.json:1: the file is empty", 0), 0u);
  EXPECT_EQ(errorOf(" \n\n").rfind("f.json:1: the file is empty", 0), 0u);
  EXPECT_EQ(whereOf("// only a comment\n"), "f.json:1");
  EXPECT_EQ(whereOf("[\n\"\xff\"]"), "f.json:2");
  EXPECT_EQ(whereOf("[\n\"\xc3\"]"), "f.json:2");
  EXPECT_EQ(whereOf("[\n\xff]"), "f.json:2");
  EXPECT_EQ(whereOf(std::string_view("[1]\n\0{", 6)), "f.json:2");
}

TEST(JsonDocument, boundsDepth) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') +
           std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_TRUE(parsed(nested(JsonDocument::kMaxDepth)).ok());
  EXPECT_NE(errorOf(std::string("\n").append(nested(JsonDocument::kMaxDepth + 1)))
                .find("f.json:2: brackets nested deeper"),
            std::string::npos);
  EXPECT_FALSE(parsed(std::string(10'000'000, '[')).ok());
}

TEST(JsonDocument, boundsTheNumberOfValues) {
  std::string text = "[";
  for (std::size_t i = 0; i < JsonDocument::kMaxValues; ++i)
    text += "1,";
  text += "1]";
  EXPECT_NE(errorOf(text).find("values"), std::string::npos);
}

TEST(JsonDocument, quotesHostileTextOnlyInPart) {
  EXPECT_LT(errorOf("[\"" + std::string(1'000'000, 'x')).size(), 1000u);
  const std::string key = '"' + std::string(1'000'000, 'x') + '"';
  EXPECT_LT(errorOf("{" + key + ":1," + key + ":1}").size(), 1000u);
  EXPECT_EQ(excerpt("\xC3\xA4\xC3\xA4", 3), "\xC3\xA4...");
}

TEST(JsonReader, findsTheNearestWord) {
  EXPECT_EQ(nearestWord("colums", {"rows", "columns", "tile_px"}), "columns");
  EXPECT_EQ(nearestWord("tilepx", {"rows", "columns", "tile_px"}), "tile_px");
  EXPECT_EQ(nearestWord("", {"rows", "up"}), "up");
}

TEST(JsonReader, firstErrorSticks) {
  const Result<JsonDocument> document = parsed("[\n1,\n\"x\"]");
  ASSERT_TRUE(document.ok());
  const std::vector<JsonValue> elements = document->root().children();
  JsonReader json("f.json");
  EXPECT_TRUE(json.ok());
  json.number(elements[0], "low", {2, 3});
  json.number(elements[1], "word", {2, 3});
  ASSERT_TRUE(json.error().has_value());
  EXPECT_EQ(json.error()->text(), "f.json:2: \"low\" must be from 2 to 3, not 1");
}

}  // namespace
}  // namespace tessera
