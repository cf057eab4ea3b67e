#include "common/wall/camera_path.h"

#include <cmath>
#include <numbers>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace tessera {
namespace {

constexpr double kRadiansPerDeg = std::numbers::pi / 180;

std::string withKeyframes(const std::string& keyframes, const std::string& space = "world") {
  return "{\"space\": \"" + space + "\", \"keyframes\": [\n" + keyframes + "]}";
}

CameraPath parsed(const std::string& keyframes, const std::string& space = "world") {
  Result<CameraPath> path = parseCameraPath(withKeyframes(keyframes, space), "c.json");
  EXPECT_TRUE(path.ok()) << path.error().text();
  return *path;
}

void expectError(const std::string& text, int line, std::string_view part) {
  const Result<CameraPath> path = parseCameraPath(text, "c.json");
  ASSERT_FALSE(path.ok()) << text;
  EXPECT_EQ(path.error().kind, ErrorKind::Input);
  EXPECT_EQ(path.error().where, "c.json:" + std::to_string(line)) << path.error().text();
  EXPECT_NE(path.error().text().find(part), std::string::npos) << path.error().text();
}

void expectValid(const CameraPose& pose) {
  ASSERT_TRUE(isFinite(pose.eye) && isFinite(pose.target) && isFinite(pose.up));
  ASSERT_GT((pose.target - pose.eye).stableNorm(), 0);
  ASSERT_NEAR(pose.up.norm(), 1, 1e-12);
  ASSERT_GT((pose.target - pose.eye).stableNormalized().cross(pose.up).norm(), 0.99);
  if (pose.fovYRad) {
    ASSERT_GE(*pose.fovYRad, kMinFovYDeg * kRadiansPerDeg);
    ASSERT_LE(*pose.fovYRad, kMaxFovYDeg * kRadiansPerDeg);
  }
}

const std::string kUneven =
    R"({"time_s": -1.5, "eye": [0.1, 0.2, 0.3], "target": [1, 2, 3], "fov_y_deg": 30},
{"time_s": 0.1, "eye": [3, 0.7, 1], "target": [1, 2.1, 3], "up": [0, 2, 0.5], "fov_y_deg": 60},
{"time_s": 0.7, "eye": [5, -0.7, 1], "target": [1.1, 2, 4], "up": [0.1, 1, 0], "fov_y_deg": 60},
{"time_s": 9, "eye": [5, 0.3, -1], "target": [1, -2, 3], "fov_y_deg": 10})";

TEST(CameraPath, passesExactlyThroughKeyframes) {
  const CameraPath path = parsed(kUneven);
  EXPECT_EQ(path.space(), CameraSpace::World);
  ASSERT_EQ(path.keyframes().size(), 4u);
  EXPECT_EQ(path.keyframes()[0].eye, Vec3(0.1, 0.2, 0.3));
  for (const CameraKeyframe& keyframe : path.keyframes()) {
    const CameraPose pose = path.poseAt(keyframe.timeS, {7, 8, 9}, 11);
    EXPECT_EQ(pose.eye, keyframe.eye);
    EXPECT_EQ(pose.target, keyframe.target);
    EXPECT_EQ(pose.up, keyframe.up);
    EXPECT_EQ(pose.fovYRad, keyframe.fovYRad);
    expectValid(pose);
  }
}

TEST(CameraPath, isContinuousWithItsSlope) {
  const CameraPath path = parsed(kUneven);
  const auto eyeAt = [&](double timeS) { return path.poseAt(timeS, Vec3::Zero(), 1).eye; };
  constexpr double kStepS = 1e-5;
  for (const double timeS : {0.1, 0.7}) {
    const Vec3 before = (eyeAt(timeS) - eyeAt(timeS - kStepS)) / kStepS;
    const Vec3 after = (eyeAt(timeS + kStepS) - eyeAt(timeS)) / kStepS;
    EXPECT_LT((after - before).norm(), 1e-2) << timeS;
  }
  EXPECT_LT((eyeAt(0.1 + 1e-12) - eyeAt(0.1)).norm(), 1e-10);
}

TEST(CameraPath, aStraightEvenFlightStaysStraightAndEven) {
  const CameraPath path = parsed(
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]},
{"time_s": 1, "eye": [1, 0, 0], "target": [1, 0, -1]},
{"time_s": 3, "eye": [3, 0, 0], "target": [3, 0, -1]})");
  for (double timeS = 0; timeS <= 3; timeS += 0.0625) {
    const CameraPose pose = path.poseAt(timeS, Vec3::Zero(), 1);
    EXPECT_LT((pose.eye - Vec3(timeS, 0, 0)).norm(), 1e-14);
    EXPECT_LT((pose.target - Vec3(timeS, 0, -1)).norm(), 1e-14);
    EXPECT_LT((pose.up - Vec3(0, 1, 0)).norm(), 1e-14);
    EXPECT_FALSE(pose.fovYRad.has_value());
  }
}

TEST(CameraPath, clampsTimes) {
  const CameraPath path = parsed(kUneven);
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(path.poseAt(-100, Vec3::Zero(), 1).eye, path.keyframes().front().eye);
  EXPECT_EQ(path.poseAt(-infinity, Vec3::Zero(), 1).eye, path.keyframes().front().eye);
  EXPECT_EQ(path.poseAt(std::nan(""), Vec3::Zero(), 1).eye, path.keyframes().front().eye);
  EXPECT_EQ(path.poseAt(100, Vec3::Zero(), 1).eye, path.keyframes().back().eye);
  EXPECT_EQ(path.poseAt(infinity, Vec3::Zero(), 1).eye, path.keyframes().back().eye);
}

TEST(CameraPath, sceneSpaceIsMeasuredInRadiiFromTheCentre) {
  const CameraPath path = parsed(R"({"time_s": 0, "eye": [0, 1, 2], "target": [0, 0, 0]})", "scene");
  EXPECT_EQ(path.space(), CameraSpace::Scene);
  const CameraPose pose = path.poseAt(0, {10, 20, 30}, 4);
  EXPECT_EQ(pose.eye, Vec3(10, 24, 38));
  EXPECT_EQ(pose.target, Vec3(10, 20, 30));
  expectValid(pose);
}

TEST(CameraPath, tinyScenesFarOutKeepTheDirectionOfView) {
  const CameraPath path = parsed(R"({"time_s": 0, "eye": [0, 1, 2], "target": [0, 0, 0]})", "scene");
  for (const double radius : {1e-12, 1e-9, 1e-8, 1e-6, 1e-3, 1.0, 1e9}) {
    const CameraPose pose = path.poseAt(0, {1e8, -1e8, 1e8}, radius);
    expectValid(pose);
    EXPECT_GT((pose.target - pose.eye).normalized().dot(Vec3(0, -1, -2).normalized()), 0.999) << radius;
  }
}

TEST(CameraPath, samplesIncludeFirstAndLast) {
  const CameraPath path = parsed(kUneven);
  EXPECT_TRUE(path.sampleTimes(0).empty());
  EXPECT_EQ(path.sampleTimes(1), std::vector<double>{-1.5});
  EXPECT_EQ(path.sampleTimes(2), (std::vector<double>{-1.5, 9}));
  for (const std::size_t frames : {3u, 7u, 60u, 1001u}) {
    const std::vector<double> timesS = path.sampleTimes(frames);
    ASSERT_EQ(timesS.size(), frames);
    EXPECT_EQ(timesS.front(), -1.5);
    EXPECT_EQ(timesS.back(), 9);
    const double stepS = 10.5 / static_cast<double>(frames - 1);
    for (std::size_t i = 1; i < frames; ++i)
      EXPECT_NEAR(timesS[i] - timesS[i - 1], stepS, 1e-12);
  }
  const CameraPath still = parsed(R"({"time_s": 4, "eye": [0, 1, 2], "target": [0, 0, 0]})");
  EXPECT_EQ(still.sampleTimes(3), (std::vector<double>{4, 4, 4}));
}

TEST(CameraPath, posesBetweenKeyframesAreNeverDegenerate) {
  const std::string awkward[] = {
      // Eye and target change places, and meet half way.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [2, 0, 0]}, {"time_s": 2, "eye": [2, 0, 0], "target": [0, 0, 0]})",
      // Over the pole: the view comes to lie along up.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [1, -1, 0]}, {"time_s": 2, "eye": [0, 0, 0], "target": [-1, -1, 0]})",
      // Up turns upside down.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1], "up": [0, 1, 0]},
         {"time_s": 2, "eye": [0, 0, 0], "target": [0, 0, -1], "up": [0, -1, 0]})",
      // About face.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]}, {"time_s": 2, "eye": [0, 0, 0], "target": [0, 0, 1]})",
      // A jump within a microsecond, then a long way.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]}, {"time_s": 0.000002, "eye": [100, 0, 0], "target": [100, 0, -1]},
         {"time_s": 2, "eye": [0, 0, 0], "target": [0, 0, -1]})",
      // As far out as may be.
      R"({"time_s": -1e9, "eye": [1e15, 0, 0], "target": [1e15, 0, -1]}, {"time_s": 1e9, "eye": [-1e15, 1e15, 0], "target": [0, 0, 1e-300]})",
      // Extreme fields of view swing beyond what is allowed.
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 50}, {"time_s": 1, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 179.9},
         {"time_s": 2, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 179.9}, {"time_s": 3, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 0.001},
         {"time_s": 4, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 0.001})"};
  for (const std::string& keyframes : awkward) {
    for (const char* space : {"world", "scene"}) {
      const CameraPath path = parsed(keyframes, space);
      for (const double timeS : path.sampleTimes(1001)) {
        SCOPED_TRACE(keyframes + " at " + std::to_string(timeS));
        ASSERT_NO_FATAL_FAILURE(expectValid(path.poseAt(timeS, {0.1, 0.2, 0.3}, 2)));
      }
    }
  }
}

TEST(CameraPath, swingsOutNoFartherThanItsChords) {
  const CameraPath path = parsed(
      R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]}, {"time_s": 0.000002, "eye": [100, 0, 0], "target": [100, 0, -1]},
         {"time_s": 20, "eye": [100, 0, 0], "target": [100, 0, -1]})");
  for (const double timeS : path.sampleTimes(1000)) {
    EXPECT_LT(path.poseAt(timeS, Vec3::Zero(), 1).eye.norm(), 200);
  }
}

TEST(CameraPath, refusesWhatIsWrongWithFileAndLine) {
  const std::string good = R"({"time_s": 0, "eye": [0, 0, 0], "target": [0, 0, -1]})";
  expectError("[]", 1, "\"camera path\" must be an object");
  expectError("{\n\"keyframes\": []}", 1, "lacks \"space\"");
  expectError("{\n\"space\": \"world\"}", 1, "lacks \"keyframes\"");
  expectError("{\"keyframes\": [],\n\"space\": \"worl\"}", 2, "did you mean \"world\"?");
  expectError("{\"keyframes\": [],\n\"space\": 1}", 2, "\"space\" must be a string");
  expectError("{\"space\": \"world\",\n\"keyframs\": []}", 2, "did you mean \"keyframes\"?");
  expectError("{\"space\": \"world\",\n\"keyframes\": {}}", 2, "must be an array");
  expectError("{\"space\": \"world\",\n\"keyframes\": []}", 2, "is empty");
  expectError(withKeyframes(good + ",\n3"), 3, "keyframe 1: \"keyframe\" must be an object");
  expectError(withKeyframes(R"({"time": 0})"), 2, "did you mean \"time_s\"?");
  expectError(withKeyframes(R"({"eye": [0, 0, 0], "target": [0, 0, -1]})"), 2, "lacks \"time_s\"");
  expectError(withKeyframes(R"({"time_s": 0, "target": [0, 0, -1]})"), 2, "lacks \"eye\"");
  expectError(withKeyframes(R"({"time_s": 0, "eye": [0, 0, -1]})"), 2, "lacks \"target\"");
  expectError(withKeyframes("{\"time_s\": 0,\n\"eye\": [0, 0], \"target\": [0, 0, -1]}"), 3, "not of 2");
  expectError(withKeyframes("{\"time_s\": 0,\n\"eye\": [0, 0, 1e16], \"target\": [0, 0, -1]}"), 3,
              "\"eye\" must");
  expectError(withKeyframes("{\"time_s\": 0,\n\"eye\": [0, 0, 1e999], \"target\": [0, 0, -1]}"), 3,
              "overflow");
  expectError(withKeyframes("{\"time_s\": 0,\n\"eye\": [0, 0, NaN], \"target\": [0, 0, -1]}"), 3, "");
  expectError(withKeyframes("{\"time_s\": 0, \"eye\": [0, 0, 1],\n\"target\": [0, 0, 1]}"), 3, "same point");
  expectError(withKeyframes("{\"time_s\": 0, \"eye\": [0, 0, 1],\n\"target\": [0, 5, 1]}"), 2, "lies along");
  expectError(
      withKeyframes("{\"time_s\": 0, \"eye\": [0, 0, 1], \"target\": [3, 5, 1],\n\"up\": [-3, -5, 0]}"), 3,
      "lies along");
  expectError(withKeyframes("{\"time_s\": 0, \"eye\": [0, 0, 1], \"target\": [3, 5, 1],\n\"up\": [0, 0, 0]}"),
              3, "no length");
  expectError(
      withKeyframes("{\"time_s\": 0, \"eye\": [0, 0, 1], \"target\": [3, 5, 1],\n\"fov_y_deg\": 180}"), 3,
      "179.9");
  expectError(withKeyframes(good + ",\n" + good), 3, "keyframe 1: \"time_s\" (0) must be greater");
  expectError(withKeyframes(good + ",\n" + R"({"time_s": -1, "eye": [0, 0, 0], "target": [0, 0, -1]})"), 3,
              "must be greater than that of the keyframe before (0)");
  expectError(withKeyframes(good + ",\n" +
                            R"({"time_s": 1, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 9})"),
              3, "in all keyframes or in none");
  expectError(withKeyframes(R"({"time_s": -1, "eye": [0, 0, 0], "target": [0, 0, -1], "fov_y_deg": 9})"
                            ",\n" +
                            good),
              3, "in all keyframes or in none");
}

TEST(CameraPath, everyTruncationIsACleanError) {
  const std::string text = withKeyframes(kUneven);
  for (std::size_t length = 0; length < text.size(); ++length) {
    const Result<CameraPath> path = parseCameraPath(text.substr(0, length), "c.json");
    ASSERT_FALSE(path.ok()) << length;
    EXPECT_EQ(path.error().where.rfind("c.json:", 0), 0u);
  }
}

TEST(CameraPath, missingFileIsNamed) {
  const Result<CameraPath> path = readCameraPath("/no/such/path.json");
  ASSERT_FALSE(path.ok());
  EXPECT_EQ(path.error().where, "/no/such/path.json");
}

}  // namespace
}  // namespace tessera
