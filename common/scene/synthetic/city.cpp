#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "common/scene/synthetic/glb_writer.h"
#include "common/scene/synthetic/parts.h"
#include "common/scene/synthetic/random.h"
#include "common/scene/synthetic/synthetic.h"

namespace tessera {
namespace synthetic {
namespace {

constexpr std::uint64_t kLeastLeaves = 10;
constexpr std::uint64_t kMostLeaves = 1'000'000;
/// Leaves of a full block: two of ground, the rest buildings and trees.
constexpr std::uint32_t kLeavesPerBlock = 16;
constexpr double kBlockM = 40;
constexpr double kPavedM = 33;
constexpr double kLotM = 10;
constexpr std::uint32_t kLots = 3;  ///< along each side of a block

/// Shapes of unit size: x and z in [-0.5, 0.5], y in [0, 1]; nodes scale them.
enum class Form : std::uint8_t { Block, Slabs, Ribs, Steps, Cylinder, Gable, Hip, Cone, Crown, Dome, Count };
constexpr auto kFormCount = static_cast<std::size_t>(Form::Count);

Parts partsOf(Form form) {
  switch (form) {
    case Form::Block:
      return {box({-0.5, 0, -0.5}, {0.5, 1, 0.5})};
    case Form::Slabs:  // floors that stand out from a recessed wall
      return {box({-0.47, 0, -0.47}, {0.47, 0.98, 0.47}),
              repeated(box({-0.5, 0.04, -0.5}, {0.5, 0.075, 0.5}), 12, {0, 0.0841, 0})};
    case Form::Ribs:  // pillars up the facade under a parapet
      return {box({-0.48, 0, -0.48}, {0.48, 0.96, 0.48}), box({-0.5, 0.96, -0.5}, {0.5, 1, 0.5}),
              repeated(box({-0.48, 0, -0.5}, {-0.42, 0.96, 0.5}), 7, {0.15, 0, 0}),
              repeated(box({-0.5, 0, -0.48}, {0.5, 0.96, -0.42}), 7, {0, 0, 0.15})};
    case Form::Steps:  // setbacks
      return {box({-0.5, 0, -0.5}, {0.5, 0.45, 0.5}), box({-0.4, 0.45, -0.4}, {0.4, 0.75, 0.4}),
              box({-0.28, 0.75, -0.28}, {0.28, 0.92, 0.28}), box({-0.06, 0.92, -0.06}, {0.06, 1, 0.06})};
    case Form::Cylinder:
      return {turned({0, 0, 0}, polyline({{0.5, 0}, {0.5, 0.94}, {0.42, 0.94}, {0.42, 1}, {0, 1}}))};
    case Form::Gable:
      return {prism({{-0.5, 0}, {0.5, 0}, {0, 1}}, 1, at(0, 0, -0.5))};
    case Form::Hip: {
      Part pyramid = turned({0, 0, 0}, polyline({{0.5, 0}, {0, 1}}));
      return {pyramid};
    }
    case Form::Cone:
      return {turned({0, 0.15, 0}, polyline({{0, 0}, {0.5, 0}, {0, 0.85}})),
              tube({0, 0, 0}, {0, 0.15, 0}, 0.08)};
    case Form::Crown:
      return {turned({0, 0.25, 0}, {arc({0, 0.375}, {0.5, 0.375}, -kPi / 2, kPi / 2)}),
              tube({0, 0, 0}, {0, 0.3, 0}, 0.07)};
    case Form::Dome:
      return {turned({0, 0, 0}, {line({0.5, 0}, {0.5, 0.45}), arc({0, 0.45}, {0.5, 0.55}, 0, kPi / 2)})};
    case Form::Count:
      break;
  }
  return {};
}

enum class Look : std::uint8_t { Tower, House, Roof, Hall, Green, Street, Pavement, Park, Count };

constexpr std::array<std::uint32_t, 8> kTowers = {0x8fa3b3, 0x6f8796, 0xb9c3c9, 0x9b8f82,
                                                  0x54697a, 0xc7b8a1, 0x7d9a9c, 0xd8d6cf};
constexpr std::array<std::uint32_t, 7> kHouses = {0xe8dfcf, 0xdcc9a8, 0xcfb49a, 0xf0ece2,
                                                  0xc9d0cf, 0xd9b9a0, 0xb98a72};
constexpr std::array<std::uint32_t, 5> kRoofs = {0xa5523c, 0x8c4636, 0x7a5a4c, 0xb5694a, 0x5d6167};
constexpr std::array<std::uint32_t, 4> kHalls = {0xb0b4ae, 0x96a7b5, 0xc4b79c, 0x87908c};
constexpr std::array<std::uint32_t, 3> kGreens = {0x4f7a3c, 0x5f8a45, 0x43693a};
constexpr std::array<std::uint32_t, 1> kStreets = {0x5a5c60};
constexpr std::array<std::uint32_t, 2> kPavements = {0xb4b0a7, 0xa8a59e};
constexpr std::array<std::uint32_t, 2> kParks = {0x7b9a52, 0x86a35c};

/// The shared meshes: every form in every colour of the looks it is used with.
class MeshSet {
 public:
  explicit MeshSet(GlbWriter& writer) : writer_(writer) {
    for (std::size_t f = 0; f < kFormCount; ++f) {
      Mesh mesh;
      for (const Part& part : partsOf(static_cast<Form>(f)))
        build(part, {.level = 1, .dither = 0}, mesh);
      geometries_[f] = writer.addGeometry(mesh);
    }
    add(Look::Tower, "Tower", kTowers, 0.4);
    add(Look::House, "House", kHouses, 0.9);
    add(Look::Roof, "Roof", kRoofs, 0.9);
    add(Look::Hall, "Hall", kHalls, 0.7);
    add(Look::Green, "Tree", kGreens, 1);
    add(Look::Street, "Street", kStreets, 0.95);
    add(Look::Pavement, "Pavement", kPavements, 0.95);
    add(Look::Park, "Park", kParks, 1);
  }

  /// The mesh of a form in one of the look's colours; made when first asked for.
  std::uint32_t mesh(Form form, Look look, Random& random) {
    const auto& materials = materials_[static_cast<std::size_t>(look)];
    const std::uint32_t material = materials[random.index(static_cast<std::uint32_t>(materials.size()))];
    const auto f = static_cast<std::size_t>(form);
    auto& known = meshes_[f];
    if (known.size() <= material) known.resize(material + 1, GlbWriter::kNone);
    if (known[material] == GlbWriter::kNone) known[material] = writer_.addMesh(geometries_[f], material);
    return known[material];
  }

 private:
  template <std::size_t N>
  void add(Look look, const std::string& name, const std::array<std::uint32_t, N>& colours,
           double roughness) {
    for (std::size_t i = 0; i < N; ++i) {
      materials_[static_cast<std::size_t>(look)].push_back(writer_.addMaterial(
          {.name = name + ' ' + std::to_string(i + 1), .rgb = colours[i], .roughness = roughness}));
    }
  }

  GlbWriter& writer_;
  std::array<std::uint32_t, kFormCount> geometries_ = {};
  std::array<std::vector<std::uint32_t>, static_cast<std::size_t>(Look::Count)> materials_;
  std::array<std::vector<std::uint32_t>, kFormCount> meshes_;
};

/// To a tenth of a metre: short numbers in the file.
double tenths(double valueM) {
  return std::round(valueM * 10) / 10;
}

class CityBuilder {
 public:
  explicit CityBuilder(const CityOptions& options)
      : options_(options),
        random_(options.seed),
        blockCount_(static_cast<std::uint32_t>((options.leaves + kLeavesPerBlock - 1) / kLeavesPerBlock)),
        columns_(static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(blockCount_))))),
        rows_((blockCount_ + columns_ - 1) / columns_),
        meshes_(writer_) {}

  Result<std::string> build() && {
    writer_.reserveNodes(options_.leaves + blockCount_ * 3ULL / 2 + 16);
    addRegion(GlbWriter::kNone, {0, 0, columns_, rows_}, Vec3::Zero());
    return std::move(writer_).finish();
  }

 private:
  /// Blocks [column0, column1) x [row0, row1).
  struct Region {
    std::uint32_t column0 = 0, row0 = 0, column1 = 0, row1 = 0;
  };

  [[nodiscard]] bool hasBlocks(const Region& r) const {
    return r.column0 < r.column1 && r.row0 < r.row1 && r.row0 * columns_ + r.column0 < blockCount_;
  }

  [[nodiscard]] Vec3 cornerOf(const Region& r) const {
    return {kBlockM * (r.column0 - columns_ / 2.0), 0, kBlockM * (r.row0 - rows_ / 2.0)};
  }

  /// A quadtree node, or the block itself. `originM` is where the parent's frame is in the city.
  void addRegion(std::uint32_t parent, const Region& region, const Vec3& originM) {
    if (region.column1 - region.column0 == 1 && region.row1 - region.row0 == 1) {
      addBlock(parent, region, originM);
      return;
    }
    const std::uint32_t middleColumn = (region.column0 + region.column1 + 1) / 2;
    const std::uint32_t middleRow = (region.row0 + region.row1 + 1) / 2;
    const Region quarters[] = {{region.column0, region.row0, middleColumn, middleRow},
                               {middleColumn, region.row0, region.column1, middleRow},
                               {region.column0, middleRow, middleColumn, region.row1},
                               {middleColumn, middleRow, region.column1, region.row1}};
    const auto filled = std::count_if(std::begin(quarters), std::end(quarters),
                                      [&](const Region& q) { return hasBlocks(q); });
    std::uint32_t node = parent;
    // A district of one part would add nothing.
    if (filled > 1) {
      node = addGroup(parent, parent == GlbWriter::kNone ? "City" : "District", cornerOf(region) - originM);
    }
    for (const Region& quarter : quarters) {
      if (hasBlocks(quarter)) addRegion(node, quarter, filled > 1 ? cornerOf(region) : originM);
    }
  }

  std::uint32_t addGroup(std::uint32_t parent, const char* name, const Vec3& positionM) {
    return writer_.addNode(
        {.parent = parent, .mesh = GlbWriter::kNone, .name = name, .placement = at(positionM)});
  }

  /// How central a block is: 1 in the middle, 0 at the rim.
  [[nodiscard]] double centrality(const Region& r) const {
    const double x = (r.column0 + 0.5) / columns_ * 2 - 1;
    const double z = (r.row0 + 0.5) / rows_ * 2 - 1;
    return std::max(0.0, 1 - std::sqrt(x * x + z * z));
  }

  void leaf(Form form, Look look, const Vec3& positionM, const Vec3& sizeM, double turnRad = 0) {
    writer_.addNode(
        {.parent = block_,
         .mesh = meshes_.mesh(form, look, random_),
         .name = {},
         .placement = {.positionM = {tenths(positionM.x()), tenths(positionM.y()), tenths(positionM.z())},
                       .rotation = turnRad == 0 ? Quat::Identity() : turnY(turnRad),
                       .scale = {tenths(sizeM.x()), tenths(sizeM.y()), tenths(sizeM.z())}}});
    --left_;
  }

  void addBlock(std::uint32_t parent, const Region& region, const Vec3& originM) {
    const std::uint64_t index = std::uint64_t{region.row0} * columns_ + region.column0;
    // Spread what does not divide: every block gets its share, the sum is exact.
    left_ = static_cast<std::uint32_t>(options_.leaves * (index + 1) / blockCount_ -
                                       options_.leaves * index / blockCount_);
    const double central = centrality(region);
    block_ = addGroup(parent, parent == GlbWriter::kNone ? "City" : "Block",
                      cornerOf(region) + Vec3(kBlockM / 2, 0, kBlockM / 2) - originM);
    leaf(Form::Block, Look::Street, {0, -0.5, 0}, {kBlockM, 0.5, kBlockM});
    const bool park = random_.chance(central > 0.6 ? 0.03 : 0.06);
    leaf(Form::Block, park ? Look::Park : Look::Pavement, {0, 0, 0}, {kPavedM, 0.2, kPavedM});
    if (!park) addLots(central);
    while (left_ > 0)
      addTree();
  }

  void addLots(double central) {
    // Sometimes one building takes the whole block.
    if (left_ > 0 && random_.chance(0.02 + 0.05 * central)) {
      addLandmark(central);
      return;
    }
    for (std::uint32_t lot = 0; lot < kLots * kLots && left_ > 0; ++lot) {
      const double x = (lot % kLots - 1.0) * (kLotM + 0.7);
      const std::uint32_t row = lot / kLots;
      const double z = (row - 1.0) * (kLotM + 0.7);
      if (random_.chance(0.06)) continue;
      const double height =
          6 + 14 * random_.unit() + 150 * central * central * central * (0.3 + random_.unit());
      const bool tall = height > 28 || random_.chance(0.25 + 0.6 * central);
      tall ? addTower({x, 0.2, z}, height) : addHouse({x, 0.2, z});
    }
  }

  void addTower(const Vec3& foot, double heightM) {
    constexpr Form kForms[] = {Form::Slabs, Form::Ribs, Form::Block,   Form::Steps,
                               Form::Slabs, Form::Ribs, Form::Cylinder};
    const Form form = kForms[random_.index(7)];
    const double w = random_.between(7.6, 9.8);
    const double d = form == Form::Cylinder ? w : random_.between(7.6, 9.8);
    leaf(form, Look::Tower, foot, {w, heightM, d});
    // Lifts and fans on the roof.
    if (left_ > 0 && form != Form::Steps && random_.chance(0.35)) {
      leaf(Form::Block, Look::Hall, foot + Vec3(random_.between(-1, 1), heightM, 0), {w * 0.4, 2.6, d * 0.4});
    }
  }

  void addHouse(const Vec3& foot) {
    const double w = random_.between(6, 8.6);
    const double d = random_.between(6.5, 9.4);
    const double heightM = random_.between(3, 8);
    const bool turned = random_.chance(0.5);
    leaf(Form::Block, Look::House, foot, {w, heightM, d});
    if (left_ == 0) return;
    const double roofM = random_.between(1.8, 3.6);
    const Vec3 eaves = foot + Vec3(0, heightM, 0);
    if (turned) {
      leaf(Form::Gable, Look::Roof, eaves, {d + 0.6, roofM, w + 0.6}, kPi / 2);
    } else {
      leaf(Form::Gable, Look::Roof, eaves, {w + 0.6, roofM, d + 0.6});
    }
  }

  void addLandmark(double central) {
    if (random_.chance(0.4 + 0.4 * central)) {
      const double heightM = 20 + 190 * central * central;
      leaf(Form::Block, Look::Hall, {0, 0.2, 0}, {30, 9, 30});
      if (left_ > 0) leaf(Form::Steps, Look::Tower, {0, 9.2, 0}, {20, heightM, 20});
    } else {
      leaf(Form::Ribs, Look::Hall, {0, 0.2, 0}, {26, 11, 26});
      if (left_ > 0) leaf(Form::Dome, Look::Roof, {0, 11.2, 0}, {17, 12, 17});
    }
  }

  void addTree() {
    // Along the kerb, so that houses are left alone.
    const double along = random_.between(-15.5, 15.5);
    const double edge = random_.chance(0.5) ? 15.9 : -15.9;
    const bool onX = random_.chance(0.5);
    const double heightM = random_.between(4, 8);
    const double w = heightM * random_.between(0.45, 0.65);
    leaf(random_.chance(0.3) ? Form::Cone : Form::Crown, Look::Green,
         {onX ? along : edge, 0.2, onX ? edge : along}, {w, heightM, w});
  }

  CityOptions options_;
  Random random_;
  std::uint32_t blockCount_, columns_, rows_;
  GlbWriter writer_{"City"};
  MeshSet meshes_;
  std::uint32_t block_ = 0;  ///< node of the block under construction
  std::uint32_t left_ = 0;   ///< leaves that it still must get
};

}  // namespace
}  // namespace synthetic

Result<std::string> makeCityGlb(const CityOptions& options) {
  using namespace synthetic;
  if (options.leaves < kLeastLeaves || options.leaves > kMostLeaves) {
    return inputError(
        "city", "leaves must be " + std::to_string(kLeastLeaves) + " to " + std::to_string(kMostLeaves));
  }
  return CityBuilder(options).build();
}

}  // namespace tessera
