#include "common/wall/mpcdi/mpcdi.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include <pugixml.hpp>

#include "common/wall/mpcdi/archive.h"
#include "common/wall/mpcdi/maps.h"

namespace tessera {

namespace {

constexpr std::size_t kMaxIdBytes = 256;

bool isSame(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [&](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

/// Reads the description and what it refers to. The case of names is not looked at: programs differ in it.
class Reader {
 public:
  Reader(const Archive& archive, std::string xmlName, std::optional<std::string> onlyRegion)
      : archive_(archive), xmlName_(std::move(xmlName)), onlyRegion_(std::move(onlyRegion)) {}

  Result<Mpcdi> run() {
    const Result<std::string> bytes = archive_.read(xmlName_, kMaxMpcdiXmlBytes);
    if (!bytes) return bytes.error();
    text_ = *bytes;
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(
        text_.data(), text_.size(), pugi::parse_default | pugi::parse_doctype, pugi::encoding_utf8);
    if (!parsed) {
      return inputError(archive_.place(xmlName_) + ':' + std::to_string(lineAt(parsed.offset)),
                        std::string("is no XML: ") + parsed.description());
    }
    for (const pugi::xml_node& node : document.children()) {
      if (node.type() == pugi::node_doctype) fail(node, "holds a document type, which may define entities");
    }
    const pugi::xml_node root = document.document_element();
    if (!isSame(root.name(), "MPCDI")) fail(root, "the outermost element is not <MPCDI>");
    if (!error_) profile(root);
    if (!error_) displays(root);
    if (!error_ && mpcdi_.regions.empty()) fail(root, "describes no region");
    if (!error_ && onlyRegion_ && regionOf(*onlyRegion_) == mpcdi_.regions.end()) {
      fail(root, "the archive has no region \"" + onlyRegion_->substr(0, 64) + '"');
    }
    if (!error_) files(root);
    if (error_) return *error_;
    return std::move(mpcdi_);
  }

 private:
  [[nodiscard]] int lineAt(std::ptrdiff_t offset) const {
    const auto end = std::min(text_.size(), static_cast<std::size_t>(std::max<std::ptrdiff_t>(offset, 0)));
    return static_cast<int>(
        1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
  }

  [[nodiscard]] std::string placeOf(const pugi::xml_node& node) const {
    return archive_.place(xmlName_) + ':' + std::to_string(lineAt(node.offset_debug()));
  }

  void fail(const pugi::xml_node& node, std::string what, std::string mend = {}) {
    if (!error_) error_ = inputError(placeOf(node), std::move(what), std::move(mend));
  }

  /// Once for each kind.
  void leaveOut(const pugi::xml_node& node) {
    constexpr std::size_t kMostKinds = 64;
    const std::string kind = std::string(node.name()).substr(0, 64);
    if (leftOut_.size() >= kMostKinds || !leftOut_.insert(kind).second) return;
    mpcdi_.warnings.push_back(placeOf(node) + ": " + kind + ": not used; left out");
  }

  static pugi::xml_node child(const pugi::xml_node& node, std::string_view name) {
    for (const pugi::xml_node& found : node.children()) {
      if (isSame(found.name(), name)) return found;
    }
    return {};
  }

  static const char* attribute(const pugi::xml_node& node, std::string_view name) {
    for (const pugi::xml_attribute& found : node.attributes()) {
      if (isSame(found.name(), name)) return found.value();
    }
    return nullptr;
  }

  double number(const pugi::xml_node& node, std::string_view label, const char* text, double least,
                double most) {
    const std::string_view digits = trimmed(text ? text : "");
    double value = 0;
    const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || code != std::errc{} || end != digits.data() + digits.size() ||
        !(value >= least && value <= most)) {
      fail(node, '"' + std::string(label) + "\" must be a number from " + std::to_string(least) + " to " +
                     std::to_string(most));
      return least;
    }
    return value;
  }

  double childNumber(const pugi::xml_node& node, std::string_view name, double least, double most) {
    const pugi::xml_node found = child(node, name);
    if (!found) {
      fail(node, std::string("<") + node.name() + "> lacks <" + std::string(name) + '>');
      return least;
    }
    return number(found, name, found.child_value(), least, most);
  }

  std::int32_t pixels(const pugi::xml_node& node, std::string_view name) {
    const double value = number(node, name, attribute(node, name), 1, kMaxMpcdiSidePx);
    if (value != std::floor(value)) fail(node, '"' + std::string(name) + "\" must be a whole number");
    return static_cast<std::int32_t>(value);
  }

  std::string id(const pugi::xml_node& node, std::string_view name) {
    const char* text = attribute(node, name);
    std::string value = text ? text : "";
    if (value.empty() || value.size() > kMaxIdBytes) {
      fail(node,
           '"' + std::string(name) + "\" must be a name of 1 to " + std::to_string(kMaxIdBytes) + " bytes");
    }
    return value;
  }

  void profile(const pugi::xml_node& root) {
    const char* profile = attribute(root, "profile");
    const std::string_view name = profile ? profile : "";
    if (isSame(name, "2d")) {
      mpcdi_.profile = MpcdiProfile::Media2d;
    } else if (isSame(name, "3d")) {
      mpcdi_.profile = MpcdiProfile::Simulation;
    } else if (isSame(name, "a3")) {
      mpcdi_.profile = MpcdiProfile::Advanced3d;
    } else if (isSame(name, "sl")) {
      mpcdi_.profile = MpcdiProfile::ShaderLamps;
    } else {
      fail(root, "the profile \"" + std::string(name.substr(0, 32)) + "\" is none of 2d, 3d, a3 and sl");
    }
    const char* version = attribute(root, "version");
    mpcdi_.version = std::string(version ? version : "").substr(0, 32);
    if (!mpcdi_.version.starts_with("1.") && !mpcdi_.version.starts_with("2.")) {
      fail(root, "the version \"" + mpcdi_.version + "\" is not known; 1 and 2 are");
    }
  }

  void displays(const pugi::xml_node& root) {
    for (const pugi::xml_node& node : root.children()) {
      if (node.type() != pugi::node_element) continue;
      if (isSame(node.name(), "display")) {
        for (const pugi::xml_node& buffer : node.children()) {
          if (buffer.type() != pugi::node_element) continue;
          if (isSame(buffer.name(), "buffer")) {
            this->buffer(buffer);
          } else {
            leaveOut(buffer);
          }
        }
      } else if (!isSame(node.name(), "files")) {
        leaveOut(node);
      }
    }
  }

  void buffer(const pugi::xml_node& node) {
    MpcdiBuffer buffer;
    buffer.id = id(node, "id");
    if (attribute(node, "xresolution")) buffer.widthPx = pixels(node, "xresolution");
    if (attribute(node, "yresolution")) buffer.heightPx = pixels(node, "yresolution");
    for (const MpcdiBuffer& other : mpcdi_.buffers) {
      if (other.id == buffer.id) fail(node, "a second buffer has the id of another");
    }
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element || error_) continue;
      if (isSame(child.name(), "region")) {
        region(child, buffer.id);
      } else {
        leaveOut(child);
      }
    }
    mpcdi_.buffers.push_back(std::move(buffer));
  }

  void region(const pugi::xml_node& node, const std::string& buffer) {
    if (mpcdi_.regions.size() >= kMaxMpcdiRegions) {
      return fail(node, "describes more than " + std::to_string(kMaxMpcdiRegions) + " regions");
    }
    MpcdiRegion region;
    region.buffer = buffer;
    region.id = id(node, "id");
    for (const MpcdiRegion& other : mpcdi_.regions) {
      if (other.id == region.id) fail(node, "a second region has the id of another", "rename one");
    }
    region.widthPx = pixels(node, "xresolution");
    region.heightPx = pixels(node, "yresolution");
    // Rectangles may reach a little over the buffer; nothing real is a hundred buffers away.
    region.x = number(node, "x", attribute(node, "x"), -100, 100);
    region.y = number(node, "y", attribute(node, "y"), -100, 100);
    region.width = number(node, "xsize", attribute(node, "xsize"), 1e-6, 100);
    region.height = number(node, "ysize", attribute(node, "ysize"), 1e-6, 100);
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element || error_) continue;
      if (isSame(child.name(), "frustum")) {
        region.frustum = frustum(child);
      } else if (isSame(child.name(), "coordinateFrame")) {
        region.frame = frame(child);
      } else {
        leaveOut(child);
      }
    }
    if (mpcdi_.profile == MpcdiProfile::Simulation && !region.frustum) {
      fail(node, "a region of the profile 3d lacks <frustum>");
    }
    mpcdi_.regions.push_back(std::move(region));
  }

  MpcdiFrustum frustum(const pugi::xml_node& node) {
    MpcdiFrustum frustum;
    frustum.yawDeg = childNumber(node, "yaw", -360, 360);
    frustum.pitchDeg = childNumber(node, "pitch", -360, 360);
    frustum.rollDeg = childNumber(node, "roll", -360, 360);
    frustum.leftDeg = childNumber(node, "leftAngle", -89.9, 89.9);
    frustum.rightDeg = childNumber(node, "rightAngle", -89.9, 89.9);
    frustum.downDeg = childNumber(node, "downAngle", -89.9, 89.9);
    frustum.upDeg = childNumber(node, "upAngle", -89.9, 89.9);
    if (!(frustum.leftDeg + 0.01 < frustum.rightDeg) || !(frustum.downDeg + 0.01 < frustum.upDeg)) {
      fail(node, "the frustum is empty: leftAngle must be below rightAngle, downAngle below upAngle");
    }
    return frustum;
  }

  MpcdiFrame frame(const pugi::xml_node& node) {
    const auto vector = [&](const char* name, double most) -> Vec3 {
      const std::string prefix = name;
      return {childNumber(node, prefix + 'x', -most, most), childNumber(node, prefix + 'y', -most, most),
              childNumber(node, prefix + 'z', -most, most)};
    };
    MpcdiFrame frame;
    frame.position = vector("pos", 1e6);
    frame.yawAxis = vector("yaw", 1e3);
    frame.pitchAxis = vector("pitch", 1e3);
    frame.rollAxis = vector("roll", 1e3);
    return frame;
  }

  std::vector<MpcdiRegion>::iterator regionOf(const std::string& id) {
    return std::find_if(mpcdi_.regions.begin(), mpcdi_.regions.end(),
                        [&](const MpcdiRegion& region) { return region.id == id; });
  }

  void files(const pugi::xml_node& root) {
    const pugi::xml_node files = child(root, "files");
    for (const pugi::xml_node& set : files.children()) {
      if (set.type() != pugi::node_element || error_) continue;
      if (!isSame(set.name(), "fileset")) {
        leaveOut(set);
        continue;
      }
      const std::string name = id(set, "region");
      const auto region = regionOf(name);
      if (region == mpcdi_.regions.end()) {
        fail(set, "files for the region \"" + name.substr(0, 64) + "\", which is not there");
        return;
      }
      if (onlyRegion_ && *onlyRegion_ != name) continue;
      for (const pugi::xml_node& file : set.children()) {
        if (file.type() != pugi::node_element || error_) continue;
        if (isSame(file.name(), "geometryWarpFile")) {
          if (region->warp) fail(file, "a second geometryWarpFile for one region");
          if (!error_) warp(file, *region);
        } else if (isSame(file.name(), "alphaMap")) {
          map(file, region->alpha);
        } else if (isSame(file.name(), "betaMap")) {
          map(file, region->beta);
        } else {
          leaveOut(file);
        }
      }
    }
  }

  /// The bytes of the file that <path> names, counted against what all maps may hold.
  std::string bytesOf(const pugi::xml_node& node) {
    const pugi::xml_node path = child(node, "path");
    const std::string name(trimmed(path.child_value()));
    if (name.empty()) {
      fail(node, std::string("<") + node.name() + "> lacks <path>");
      return {};
    }
    fileName_ = name;
    constexpr std::int64_t kHeader = 4096;
    Result<std::string> bytes = archive_.read(name, std::min(budget_, kMaxMpcdiMapSamples * 12 + kHeader));
    if (!bytes) {
      if (!error_) error_ = bytes.error();
      return {};
    }
    return std::move(*bytes);
  }

  void spend(const pugi::xml_node& node, std::size_t bytes) {
    budget_ -= static_cast<std::int64_t>(bytes);
    if (budget_ < 0) {
      fail(node, "the maps together hold more than " + std::to_string(kMaxMpcdiBytes) + " bytes");
    }
  }

  void warp(const pugi::xml_node& node, MpcdiRegion& region) {
    const std::string bytes = bytesOf(node);
    if (error_) return;
    Result<MpcdiWarp> warp = parsePfm(bytes, archive_.place(fileName_));
    if (!warp) {
      error_ = warp.error();
      return;
    }
    spend(node, warp->xyz.size() * sizeof(float));
    if (mpcdi_.profile == MpcdiProfile::Advanced3d || mpcdi_.profile == MpcdiProfile::ShaderLamps) {
      const auto unit = static_cast<float>(unitM(node));
      for (float& value : warp->xyz)
        value *= unit;
      warp->isInSpace = true;
      warp->origin = origin(node);
    }
    region.warp = std::move(*warp);
  }

  double unitM(const pugi::xml_node& node) {
    const pugi::xml_node unit = child(node, "geometricUnit");
    const std::string_view name = trimmed(unit.child_value());
    constexpr std::pair<std::string_view, double> kUnits[] = {
        {"mm", 0.001}, {"cm", 0.01}, {"dm", 0.1}, {"m", 1}, {"in", 0.0254}, {"ft", 0.3048}, {"yd", 0.9144}};
    for (const auto& [known, metres] : kUnits) {
      if (isSame(name, known)) return metres;
    }
    fail(unit ? unit : node, "the geometricUnit is none of mm, cm, dm, m, in, ft and yd");
    return 1;
  }

  static MpcdiWarp::Origin origin(const pugi::xml_node& node) {
    const std::string_view name = trimmed(child(node, "originOf3DData").child_value());
    if (isSame(name, "idealEyePoint")) return MpcdiWarp::Origin::IdealEyePoint;
    if (isSame(name, "floorCenter")) return MpcdiWarp::Origin::FloorCenter;
    if (isSame(name, "centerOfMass")) return MpcdiWarp::Origin::CenterOfMass;
    return MpcdiWarp::Origin::Unknown;
  }

  void map(const pugi::xml_node& node, MpcdiMap& map) {
    if (!map.isEmpty()) return fail(node, std::string("a second ") + node.name() + " for one region");
    const std::string bytes = bytesOf(node);
    if (error_) return;
    Result<MpcdiMap> read = parsePngMap(bytes, archive_.place(fileName_));
    if (!read) {
      error_ = read.error();
      return;
    }
    spend(node, read->values.size() * sizeof(std::uint16_t));
    if (child(node, "gammaEmbedded")) read->gammaEmbedded = childNumber(node, "gammaEmbedded", 0.1, 10);
    map = std::move(*read);
  }

  const Archive& archive_;
  std::string xmlName_, text_, fileName_;
  std::optional<std::string> onlyRegion_;
  std::optional<Error> error_;
  std::set<std::string> leftOut_;
  std::int64_t budget_ = kMaxMpcdiBytes;
  Mpcdi mpcdi_;
};

}  // namespace

Result<Mpcdi> readMpcdi(const std::filesystem::path& path, std::optional<std::string> onlyRegion) {
  const Result<Archive> archive = Archive::open(path);
  if (!archive) return archive.error();
  std::string xml = archive->find("mpcdi.xml");
  if (xml.empty()) xml = archive->find("mpacs.xml");
  if (xml.empty()) {
    return inputError(path.string(), "is an archive without mpcdi.xml, so no MPCDI archive");
  }
  return Reader(*archive, xml, std::move(onlyRegion)).run();
}

}  // namespace tessera
