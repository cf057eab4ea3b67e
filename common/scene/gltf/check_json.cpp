#include "common/scene/gltf/check_json.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

namespace tessera::gltf {

namespace {

/// tinygltf reads `extras` and `extensions` recursively. Honest files stay below 20.
constexpr std::size_t kMaxNesting = 128;

constexpr std::array<std::string_view, 4> kSupportedExtensions = {
    "KHR_mesh_quantization", "KHR_texture_transform", "KHR_materials_unlit",
    "KHR_materials_pbrSpecularGlossiness"};

enum class Want { Anything, Array, Object, Index, Size, Boolean };

struct Rule {
  std::string_view section;
  std::string_view key;
  Want want;
};

// Sorted by section; "" is the root object.
constexpr std::array kRules = {
    Rule{"", "accessors", Want::Array},
    Rule{"", "animations", Want::Array},
    Rule{"", "asset", Want::Object},
    Rule{"", "bufferViews", Want::Array},
    Rule{"", "buffers", Want::Array},
    Rule{"", "extensionsRequired", Want::Array},
    Rule{"", "extensionsUsed", Want::Array},
    Rule{"", "images", Want::Array},
    Rule{"", "materials", Want::Array},
    Rule{"", "meshes", Want::Array},
    Rule{"", "nodes", Want::Array},
    Rule{"", "samplers", Want::Array},
    Rule{"", "scene", Want::Index},
    Rule{"", "scenes", Want::Array},
    Rule{"", "skins", Want::Array},
    Rule{"", "textures", Want::Array},
    Rule{"accessors", "bufferView", Want::Index},
    Rule{"accessors", "byteOffset", Want::Size},
    Rule{"accessors", "componentType", Want::Index},
    Rule{"accessors", "count", Want::Size},
    Rule{"accessors", "indices", Want::Object},
    Rule{"accessors", "normalized", Want::Boolean},
    Rule{"accessors", "sparse", Want::Object},
    Rule{"accessors", "values", Want::Object},
    Rule{"animations", "channels", Want::Array},
    Rule{"animations", "input", Want::Index},
    Rule{"animations", "node", Want::Index},
    Rule{"animations", "output", Want::Index},
    Rule{"animations", "sampler", Want::Index},
    Rule{"animations", "samplers", Want::Array},
    Rule{"animations", "target", Want::Object},
    Rule{"bufferViews", "buffer", Want::Index},
    Rule{"bufferViews", "byteLength", Want::Size},
    Rule{"bufferViews", "byteOffset", Want::Size},
    Rule{"bufferViews", "byteStride", Want::Index},
    Rule{"buffers", "byteLength", Want::Size},
    Rule{"images", "bufferView", Want::Index},
    Rule{"materials", "baseColorFactor", Want::Array},
    Rule{"materials", "baseColorTexture", Want::Object},
    Rule{"materials", "doubleSided", Want::Boolean},
    Rule{"materials", "emissiveFactor", Want::Array},
    Rule{"materials", "index", Want::Index},
    Rule{"materials", "pbrMetallicRoughness", Want::Object},
    Rule{"materials", "texCoord", Want::Index},
    Rule{"meshes", "attributes", Want::Object},
    Rule{"meshes", "indices", Want::Index},
    Rule{"meshes", "material", Want::Index},
    Rule{"meshes", "mode", Want::Index},
    Rule{"meshes", "primitives", Want::Array},
    Rule{"meshes", "targets", Want::Array},
    Rule{"meshes", "weights", Want::Array},
    Rule{"nodes", "children", Want::Array},
    Rule{"nodes", "matrix", Want::Array},
    Rule{"nodes", "mesh", Want::Index},
    Rule{"nodes", "rotation", Want::Array},
    Rule{"nodes", "scale", Want::Array},
    Rule{"nodes", "skin", Want::Index},
    Rule{"nodes", "translation", Want::Array},
    Rule{"nodes", "weights", Want::Array},
    Rule{"samplers", "magFilter", Want::Index},
    Rule{"samplers", "minFilter", Want::Index},
    Rule{"samplers", "wrapS", Want::Index},
    Rule{"samplers", "wrapT", Want::Index},
    Rule{"scenes", "nodes", Want::Array},
    Rule{"skins", "inverseBindMatrices", Want::Index},
    Rule{"skins", "joints", Want::Array},
    Rule{"textures", "sampler", Want::Index},
    Rule{"textures", "source", Want::Index},
};

std::span<const Rule> rulesOf(std::string_view section) {
  const auto [first, last] =
      std::equal_range(kRules.begin(), kRules.end(), Rule{section, {}, {}},
                       [](const Rule& a, const Rule& b) { return a.section < b.section; });
  return {first, last};
}

std::string_view describe(Want want) {
  switch (want) {
    case Want::Array:
      return "an array";
    case Want::Object:
      return "an object";
    case Want::Index:
      return "an integer from 0 to 2147483647";
    case Want::Size:
      return "an integer that is not negative";
    case Want::Boolean:
      return "true or false";
    case Want::Anything:
      break;
  }
  return "anything";
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return 0;
}

/// Percent decoding as tinygltf does it; it also turns '+' into a space, which is right for forms only.
std::string decodeUri(std::string_view uri, bool plusIsSpace) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size()) {
      out += static_cast<char>(hexDigit(uri[i + 1]) * 16 + hexDigit(uri[i + 2]));
      i += 2;
    } else {
      out += uri[i] == '+' && plusIsSpace ? ' ' : uri[i];
    }
  }
  return out;
}

class Walker : public nlohmann::json_sax<nlohmann::json> {
 public:
  bool null() override { return scalar(Want::Anything); }
  bool boolean(bool) override { return scalar(Want::Boolean); }
  bool number_integer(number_integer_t) override {
    return scalar(Want::Anything);
  }  // only called for negatives
  bool number_unsigned(number_unsigned_t value) override {
    if (inSection("buffers") && key_ == "byteLength") file_.byteLength = value;
    return scalar(value <= INT_MAX ? Want::Index : Want::Size);
  }
  bool number_float(number_float_t, const string_t&) override { return scalar(Want::Anything); }
  bool string(string_t& value) override;
  bool binary(binary_t&) override { return scalar(Want::Anything); }
  bool start_object(std::size_t) override { return open(Want::Object); }
  bool key(string_t& value) override {
    key_ = value;
    return true;
  }
  bool end_object() override {
    if (!isSkipping() && levels_.size() == 3) commitFile();
    return close();
  }
  bool start_array(std::size_t) override { return open(Want::Array); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) override;

  /// The facts, or the most telling of all complaints.
  Result<JsonFacts> finish(bool parsed) &&;

 private:
  struct Level {
    std::string key;  ///< of the member that holds this container; an element takes its array's
    bool isArray = false;
    std::size_t elements = 0;
  };

  [[nodiscard]] bool isSkipping() const { return skipFrom_ > 0; }
  [[nodiscard]] bool inSection(std::string_view section) const {
    return !isSkipping() && levels_.size() == 3 && levels_[1].key == section;
  }
  [[nodiscard]] Want wanted() const;
  [[nodiscard]] std::string place() const;
  void check(Want got);
  bool scalar(Want got);
  bool open(Want got);
  bool close();
  void commitFile();

  std::vector<Level> levels_;
  std::string key_;
  std::span<const Rule> sectionRules_;
  std::size_t skipFrom_ = 0;
  std::string uri_;
  NamedFile file_;
  std::string version_;
  std::string minVersion_;
  JsonFacts facts_;
  std::string syntaxFault_;
  std::string firstFault_;
};

Want Walker::wanted() const {
  if (levels_.empty()) return Want::Object;
  const Level& top = levels_.back();
  if (top.isArray) {
    if (levels_.size() == 2) {
      return top.key.starts_with("extensions") || rulesOf(top.key).empty() ? Want::Anything : Want::Object;
    }
    const std::string& section = levels_[1].key;
    if (section == "nodes" && top.key == "children") return Want::Index;
    if (section == "scenes" && top.key == "nodes") return Want::Index;
    if (section == "meshes" && top.key == "primitives") return Want::Object;
    return Want::Anything;
  }
  if (levels_.size() > 3 && top.key == "attributes" && levels_[1].key == "meshes") return Want::Index;
  const std::span<const Rule> rules = levels_.size() == 1 ? rulesOf("") : sectionRules_;
  for (const Rule& rule : rules) {
    if (rule.key != key_) continue;
    // tinygltf keeps the offsets and counts of sparse parts in 32 bits.
    return rule.want == Want::Size && levels_.size() > 3 ? Want::Index : rule.want;
  }
  return Want::Anything;
}

std::string Walker::place() const {
  std::string text;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    if (levels_[i].isArray) {
      text += "[" + std::to_string(levels_[i].elements) + "]";
    } else {
      const std::string& name = i + 1 < levels_.size() ? levels_[i + 1].key : key_;
      text += (text.empty() ? "" : ".") + name.substr(0, 60);
    }
  }
  return text.empty() ? "the file" : text;
}

void Walker::check(Want got) {
  if (isSkipping() || !firstFault_.empty()) return;
  const Want want = wanted();
  if (want == Want::Anything || want == got || (want == Want::Size && got == Want::Index)) return;
  firstFault_ = place() + " must be " + std::string(describe(want));
}

bool Walker::scalar(Want got) {
  check(got);
  if (!levels_.empty() && levels_.back().isArray) ++levels_.back().elements;
  return true;
}

bool Walker::open(Want got) {
  check(got);
  if (levels_.size() >= kMaxNesting) {
    syntaxFault_ = "nests its JSON deeper than " + std::to_string(kMaxNesting) + " levels";
    return false;
  }
  const bool isElement = !levels_.empty() && levels_.back().isArray;
  levels_.push_back({isElement ? levels_.back().key : key_, got == Want::Array, 0});
  if (levels_.size() == 2) sectionRules_ = rulesOf(levels_.back().key);
  if (levels_.size() == 3) {
    file_ = {};
    uri_.clear();
  }
  if (!isSkipping() && !isElement && levels_.size() > 1 && (key_ == "extras" || key_ == "extensions")) {
    skipFrom_ = levels_.size();
  }
  return true;
}

bool Walker::close() {
  if (levels_.size() == skipFrom_) skipFrom_ = 0;
  levels_.pop_back();
  if (!levels_.empty() && levels_.back().isArray) ++levels_.back().elements;
  return true;
}

bool Walker::string(string_t& value) {
  if (levels_.size() == 2 && !isSkipping()) {
    if (levels_[1].key == "extensionsUsed") facts_.extensionsUsed.push_back(value);
    if (levels_[1].key == "extensionsRequired") facts_.extensionsRequired.push_back(value);
    if (levels_[1].key == "asset" && key_ == "version") version_ = value;
    if (levels_[1].key == "asset" && key_ == "minVersion") minVersion_ = value;
  }
  if ((inSection("buffers") || inSection("images")) && key_ == "uri") uri_ = std::move(value);
  return scalar(Want::Anything);
}

void Walker::commitFile() {
  if (uri_.empty() || uri_.starts_with("data:")) return;
  file_.isBuffer = levels_[1].key == "buffers";
  file_.path = decodeUri(uri_, false);
  file_.written = uri_;
  facts_.files.emplace(decodeUri(uri_, true), file_);
}

bool Walker::parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& e) {
  std::string text = e.what();
  const std::size_t afterId = text.find("] ");
  if (afterId != std::string::npos) text.erase(0, afterId + 2);
  syntaxFault_ = "is not glTF: " + text.substr(0, 200);
  return false;
}

bool isVersion2(const std::string& version) {
  return version.starts_with("2.") || version == "2";
}

Result<JsonFacts> Walker::finish(bool parsed) && {
  if (!parsed) {
    return inputError({}, syntaxFault_.empty() ? "is not glTF" : syntaxFault_,
                      "export it again, or check that it was copied whole");
  }
  if (version_.empty())
    return inputError({}, "names no glTF version (asset.version)", "export it as glTF 2.0");
  if (!isVersion2(version_) || (!minVersion_.empty() && minVersion_ != "2.0")) {
    const std::string& version = isVersion2(version_) ? minVersion_ : version_;
    return inputError({}, "is glTF " + version.substr(0, 20) + ", only 2.0 is supported",
                      "export it as glTF 2.0");
  }
  for (const std::string& name : facts_.extensionsRequired) {
    if (std::find(kSupportedExtensions.begin(), kSupportedExtensions.end(), name) ==
        kSupportedExtensions.end()) {
      return inputError({}, "requires the extension " + name.substr(0, 80) + ", which is not supported",
                        "export the scene without it");
    }
  }
  if (!firstFault_.empty()) return inputError({}, firstFault_, "export it again");
  return std::move(facts_);
}

}  // namespace

Result<JsonFacts> checkJson(std::string_view json) {
  Walker walker;
  const bool parsed = nlohmann::json::sax_parse(json.begin(), json.end(), &walker);
  return std::move(walker).finish(parsed);
}

}  // namespace tessera::gltf
