#include "server/master/predictor.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "common/wall/camera_path.h"
#include "common/wall/wall_file.h"

namespace {

std::size_t allocations = 0;

void* countedNew(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  void* memory = alignment > alignof(std::max_align_t)
                     ? std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment)
                     : std::malloc(bytes ? bytes : 1);
  if (!memory) throw std::bad_alloc();
  return memory;
}

// Not inline: compilers would warn of free() after operator new.
[[gnu::noinline]] void give(void* memory) {
  std::free(memory);
}

}  // namespace

// The other forms of new and delete come to these.
void* operator new(std::size_t bytes) {
  return countedNew(bytes, 1);
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return countedNew(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  give(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  give(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  give(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  give(memory);
}

namespace tessera::test {
namespace {

constexpr double kWalkingSpeed = 1.4;  // m/s
constexpr double kFramesPerS = 60;
constexpr double kPitchM = 10;
constexpr int kCitySide = 128;  // houses

/// Houses on a square of streets, in a tree of quarters.
struct City {
  ObjectHierarchy hierarchy;
  Sphere sphere;

  City() {
    ObjectHierarchyBuilder builder;
    add(builder, 0, 0, kCitySide);
    hierarchy = builder.finish();
    sphere = {Vec3::Zero(), kCitySide * kPitchM / std::numbers::sqrt2};
  }

 private:
  void add(ObjectHierarchyBuilder& builder, int x, int z, int side) {
    if (side == 1) {
      const double height = std::uniform_real_distribution<double>(4, 40)(random_);
      const Vec3 low((x - kCitySide / 2) * kPitchM, -80, (z - kCitySide / 2) * kPitchM);
      const Vec3 high = low + Vec3(7, height, 7);
      std::array<Vec3, 8> corners;
      for (std::size_t i = 0; i < corners.size(); ++i)
        corners[i] = Vec3((i & 1U) != 0 ? high.x() : low.x(), (i & 2U) != 0 ? high.y() : low.y(),
                          (i & 4U) != 0 ? high.z() : low.z());
      builder.addLeaf(boundsOf(corners, Vec3::Zero()));
      return;
    }
    builder.openNode();
    for (const int quarter : {0, 1, 2, 3})
      add(builder, x + (quarter & 1) * side / 2, z + (quarter >> 1) * side / 2, side / 2);
    builder.closeNode();
  }
  std::mt19937 random_{7};
};

const City& city() {
  static const City city;
  return city;
}

Wall smallWall() {
  return gridWall(4, 4, 480, 270, 50 * std::numbers::pi / 180);
}

const CameraPath& fly() {
  static const CameraPath path =
      *readCameraPath(std::filesystem::path(TESSERA_SOURCE_DIR) / "configs" / "fly.camera.json");
  return path;
}

CameraPose flyAt(double timeS) {
  return fly().poseAt(timeS, city().sphere.center, city().sphere.radius);
}

/// So many seconds of the path are one frame where the camera goes at `speed`, on average.
double pathSecondsPerFrame(double speed) {
  double length = 0;
  constexpr double kStepS = 0.01;
  for (double timeS = 0; timeS < 40; timeS += kStepS)
    length += (flyAt(timeS + kStepS).eye - flyAt(timeS).eye).norm();
  return speed / kFramesPerS / (length / 40);
}

struct Foresight {
  std::uint64_t came = 0, foreseen = 0, visible = 0, beyond = 0, frames = 0;
  double plainUs = 0, predictUs = 0;
  [[nodiscard]] double recall() const { return static_cast<double>(foreseen) / static_cast<double>(came); }
  /// Pairs that were predicted and not in view, for each that was.
  [[nodiscard]] double excess() const { return static_cast<double>(beyond) / static_cast<double>(visible); }
};

/// Along the path at a speed, in stretches. Leaves that come into a tile's view count as foreseen that were
/// predicted for the tile 5 frames before or earlier, and not more than 40.
Foresight walk(double speed) {
  using Clock = std::chrono::steady_clock;
  constexpr int kWarmUp = 45, kFrames = 400, kStretches = 6;
  const Wall wall = smallWall();
  const std::uint32_t leaves = city().hierarchy.leafCount();
  const double step = pathSecondsPerFrame(speed);
  WallView view;
  Foresight found;
  for (int stretch = 0; stretch < kStretches; ++stretch) {
    Predictor predictor(city().hierarchy, wall);
    WallCuller culler(city().hierarchy, wall, {.algorithm = cull::Algorithm::Auto});
    // By tile and leaf: in which of the last frames it was predicted, the last one lowest.
    std::vector<std::vector<std::uint64_t>> predicted(wall.tiles.size(),
                                                      std::vector<std::uint64_t>(leaves, 0));
    std::vector<std::vector<bool>> seen(wall.tiles.size(), std::vector<bool>(leaves, false));
    for (int frame = 0; frame < kWarmUp + kFrames; ++frame) {
      const CameraPose pose = flyAt(stretch * 40.0 / kStretches + 1.1 + frame * step);
      auto start = Clock::now();
      viewInto(wall, pose, city().sphere.center, city().sphere.radius, view);
      culler.update(view);
      const auto& lists = culler.cull().lists;
      const std::chrono::duration<double, std::micro> plain = Clock::now() - start;
      for (std::size_t t = 0; t < lists.size(); ++t) {
        std::vector<bool> now(leaves, false);
        forEachLeaf(lists[t], [&](std::uint32_t leaf) {
          now[leaf] = true;
          if (seen[t][leaf] || frame < kWarmUp) return;
          ++found.came;
          constexpr std::uint64_t kInTime = ((std::uint64_t{1} << 40U) - 1) & ~std::uint64_t{15};
          found.foreseen += (predicted[t][leaf] & kInTime) != 0 ? 1 : 0;
        });
        seen[t] = std::move(now);
      }
      start = Clock::now();
      const auto& ahead = predictor.predict(pose, city().sphere);
      const std::chrono::duration<double, std::micro> predicting = Clock::now() - start;
      if (frame >= kWarmUp) {
        found.plainUs += plain.count();
        found.predictUs += predicting.count();
        ++found.frames;
      }
      for (std::size_t t = 0; t < ahead.size(); ++t) {
        for (std::uint64_t& frames : predicted[t])
          frames <<= 1U;
        EXPECT_TRUE(isCanonical(ahead[t], leaves));
        forEachLeaf(ahead[t], [&](std::uint32_t leaf) {
          predicted[t][leaf] |= 1;
          found.beyond += seen[t][leaf] ? 0 : 1;
        });
        found.visible += leafCount(lists[t]);
      }
    }
  }
  return found;
}

void report(const char* name, const Foresight& found) {
  std::printf(
      "%s: %llu came into view, recall %.4f; predicted beyond the view for each in view: %.3f; "
      "cull %.0f us, prediction %.0f us\n",
      name, static_cast<unsigned long long>(found.came), found.recall(), found.excess(),
      found.plainUs / static_cast<double>(found.frames), found.predictUs / static_cast<double>(found.frames));
}

TEST(Predictor, ForeseesWhatComesIntoViewAtWalkingSpeed) {
  const Foresight found = walk(kWalkingSpeed);
  report("walking", found);
  ASSERT_GT(found.came, 100U);
  EXPECT_GE(found.recall(), 0.95);
  EXPECT_LT(found.excess(), 1.5);
}

TEST(Predictor, ForeseesMostAtTenTimesWalkingSpeed) {
  const Foresight found = walk(10 * kWalkingSpeed);
  report("ten times as fast", found);
  ASSERT_GT(found.came, 1000U);
  EXPECT_GE(found.recall(), 0.9);
  EXPECT_LT(found.excess(), 1.5);
}

std::vector<VisibleList> grownListsAt(const CameraPose& pose) {
  const GrownWall grown = grownWall(smallWall(), 0.125);
  WallCuller culler(city().hierarchy, grown.wall, {.algorithm = cull::Algorithm::Auto});
  culler.update(viewOf(grown.wall, grown.poseFor(pose), city().sphere.center, city().sphere.radius));
  return culler.cull().lists;
}

TEST(Predictor, OfAStandingCameraTheGrownViewIsPredicted) {
  Predictor predictor(city().hierarchy, smallWall());
  const CameraPose pose = flyAt(3);
  const std::vector<VisibleList> grown = grownListsAt(pose);
  WallCuller culler(city().hierarchy, smallWall(), {.algorithm = cull::Algorithm::Auto});
  culler.update(viewOf(smallWall(), pose, city().sphere.center, city().sphere.radius));
  const std::vector<VisibleList> plain = culler.cull().lists;
  for (int frame = 0; frame < 7; ++frame) {
    ASSERT_EQ(predictor.predict(pose, city().sphere), grown);
    for (std::size_t t = 0; t < plain.size(); ++t)
      ASSERT_TRUE(differenceOf(plain[t], grown[t]).empty());
  }
}

TEST(Predictor, NothingIsMadeOfAJump) {
  Predictor predictor(city().hierarchy, smallWall());
  const double step = pathSecondsPerFrame(10 * kWalkingSpeed);
  for (int frame = 0; frame < 20; ++frame)
    predictor.predict(flyAt(3 + frame * step), city().sphere);
  // To elsewhere, and on from there.
  for (int frame = 0; frame < 2; ++frame) {
    const CameraPose pose = flyAt(23 + frame * step);
    ASSERT_EQ(predictor.predict(pose, city().sphere), grownListsAt(pose)) << frame;
  }
  const CameraPose third = flyAt(23 + 2 * step);
  EXPECT_NE(predictor.predict(third, city().sphere), grownListsAt(third));
}

TEST(CameraMotion, GoesOnEvenly) {
  for (const double frames : {1.0, 7.5, 30.0}) {
    CameraMotion motion;
    const auto poseAt = [](double frame) {
      const Mat3 turn(Eigen::AngleAxisd(0.004 * frame, Vec3(0.2, 1, -0.1).normalized()));
      CameraPose pose;
      pose.eye = Vec3(1, 2, 3) + frame * Vec3(0.02, 0, -0.05);
      pose.target = pose.eye + turn * Vec3(0, -1, -7);
      pose.up = turn * Vec3(0, 7, -1).normalized();
      return pose;
    };
    for (int frame = 0; frame < 20; ++frame)
      motion.add(poseAt(frame));
    const CameraPose meant = poseAt(19 + frames), got = motion.ahead(frames, 1e9);
    EXPECT_LT((meant.eye - got.eye).norm(), 1e-9);
    EXPECT_LT((meant.target - got.target).norm(), 1e-7);
    EXPECT_LT((meant.up - got.up).norm(), 1e-7);
  }
}

TEST(CameraMotion, IsBoundedAndIgnoresNoise) {
  CameraMotion motion;
  CameraPose pose;
  for (int frame = 0; frame < 10; ++frame) {
    pose.eye = Vec3(frame * 100.0, 0, 0);
    pose.target = pose.eye + Vec3(std::sin(0.3 * frame), 0, -std::cos(0.3 * frame));
    motion.add(pose);
  }
  const CameraPose ahead = motion.ahead(30, 50);
  EXPECT_NEAR((ahead.eye - pose.eye).norm(), 50, 1e-9);
  EXPECT_NEAR((ahead.target - ahead.eye).dot(pose.target - pose.eye), std::cos(CameraMotion::kMostTurnRad),
              1e-9);

  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.001);
  CameraMotion shaking;
  int moving = 0;
  for (int frame = 0; frame < 200; ++frame) {
    pose.eye = Vec3(noise(random), noise(random), noise(random));
    pose.target = pose.eye + Vec3(noise(random), noise(random), -1);
    shaking.add(pose);
    moving += shaking.isStanding() ? 0 : 1;
  }
  EXPECT_LT(moving, 30);
}

TEST(Predictor, DoesNotAllocateOnceWarm) {
  Predictor predictor(city().hierarchy, smallWall());
  const double step = pathSecondsPerFrame(kWalkingSpeed);
  std::vector<CameraPose> poses;
  for (int frame = 0; frame < 400; ++frame)
    poses.push_back(flyAt(3 + (frame < 200 ? frame : 400 - frame) * step));
  for (const CameraPose& pose : poses)
    predictor.predict(pose, city().sphere);
  const std::size_t before = allocations;
  for (const CameraPose& pose : poses)
    predictor.predict(pose, city().sphere);
  EXPECT_EQ(allocations, before);
}

TEST(Predictor, WallsOfEveryShapeArePredicted) {
  for (const auto& entry :
       std::filesystem::directory_iterator(std::filesystem::path(TESSERA_SOURCE_DIR) / "configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("wall-") || !name.ends_with(".json")) continue;
    const auto wall = readWallFile(entry.path());
    ASSERT_TRUE(wall.ok());
    if (wall->tiles.size() > 64) continue;
    Predictor predictor(city().hierarchy, *wall);
    WallCuller culler(city().hierarchy, *wall, {.algorithm = cull::Algorithm::Auto});
    const CameraPose pose = flyAt(5);
    culler.update(viewOf(*wall, pose, city().sphere.center, city().sphere.radius));
    const auto& lists = culler.cull().lists;
    const auto& ahead = predictor.predict(pose, city().sphere);
    for (std::size_t t = 0; t < lists.size(); ++t)
      ASSERT_TRUE(differenceOf(lists[t], ahead[t]).empty()) << name << " tile " << t;
  }
}

}  // namespace
}  // namespace tessera::test
