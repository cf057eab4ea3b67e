// Whole programs that draw in windows and by EGL. Windows open on an X server without a screen.

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <set>
#include <thread>

#include <dlfcn.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <signal.h>

#include "common/image/picture.h"
#include "common/scene/load_scene.h"
#include "common/wall/wall_file.h"
#include "server/master/master.h"
#include "tests/programs/small_scene.h"
#include "tests/support/process.h"
#include "tests/support/virtual_display.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::seconds;
using Environment = std::map<std::string, std::string>;

constexpr int kScreenWidthPx = 800, kScreenHeightPx = 600;
// 512x384 pixels together.
constexpr const char* kWall = R"({"grid": {"columns": 2, "rows": 2, "tile_px": [256, 192]}})";
// As a path of one keyframe: all frames of a run are alike.
constexpr const char* kStill =
    R"({"space": "scene", "keyframes": [{"time_s": 0, "eye": [0.6, 0.5, 1.2], "target": [0, 0, 0]}]})";

bool eventually(seconds deadline, const std::function<bool()>& isSo) {
  const auto end = std::chrono::steady_clock::now() + deadline;
  while (!isSo()) {
    if (std::chrono::steady_clock::now() >= end) return false;
    std::this_thread::sleep_for(milliseconds(50));
  }
  return true;
}

/// A part of a picture.
Picture cut(const Picture& from, int xPx, int yPx, int widthPx, int heightPx) {
  Picture part(widthPx, heightPx);
  for (int y = 0; y < heightPx && !from.rgb.empty(); ++y) {
    const auto start = from.rgb.begin() + ((yPx + y) * std::ptrdiff_t{from.widthPx} + xPx) * 3;
    std::copy_n(start, std::ptrdiff_t{widthPx} * 3, part.rgb.begin() + y * std::ptrdiff_t{widthPx} * 3);
  }
  return part;
}

std::size_t colours(const Picture& picture) {
  std::set<std::array<std::uint8_t, 3>> all;
  for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3)
    all.insert({picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]});
  return all.size();
}

class Surfaces : public ::testing::Test {
 protected:
  /// A scene with colours, edges and depth.
  std::string plant() {
    const std::string path = folder_ / "plant.glb";
    const Outcome made =
        run({program("tessera"), "scene", "make", "powerplant", "--triangles", "110000", "--out", path},
            seconds(60));
    EXPECT_EQ(made.status, 0) << made.err;
    return path;
  }

  std::vector<std::string> runArguments(const std::string& scene, const std::string& surface, int frames,
                                        std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {program("tessera"), "run",  "--wall",   wall_,
                                          "--scene",          scene,  "--frames", std::to_string(frames),
                                          "--surface",        surface};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static std::vector<std::string> tileArguments(const std::string& surface,
                                                std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {
        program("tessera-tile"), "--connect", "127.0.0.1:1", "--tile", "r0c0", "--surface", surface};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  static Picture pictureOf(const std::string& folder, int frame) {
    const auto picture = readPng(folder + "/frame-00000" + std::to_string(frame) + ".png");
    EXPECT_TRUE(picture) << picture.error().text();
    return picture ? *picture : Picture();
  }

  void expectSamePictures(const std::string& folder, const std::string& expected, int frames) {
    for (int frame = 1; frame <= frames; ++frame) {
      const Picture a = pictureOf(folder, frame), b = pictureOf(expected, frame);
      const auto difference = compare(a, b);
      ASSERT_TRUE(difference) << difference.error().text();
      EXPECT_EQ(difference->differing, 0U) << "frame " << frame;
      EXPECT_GT(colours(b), 100U) << "the reference shows nothing";
    }
  }

  static void expectOneError(const Outcome& outcome, int status, const std::string& text) {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("tessera-tile: error: ")) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }

  TemporaryFolder folder_;
  std::string wall_ = folder_.write("wall.json", kWall);
  const Environment noDisplay_ = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}};
};

TEST_F(Surfaces, EglDrawsTheSamePicturesWithoutADisplay) {
  const std::string scene = plant(), offscreen = folder_ / "offscreen", egl = folder_ / "egl";
  const Outcome a = run(runArguments(scene, "offscreen", 3, {"--out", offscreen}), seconds(100), noDisplay_);
  ASSERT_EQ(a.status, 0) << a.err;
  const Outcome b = run(runArguments(scene, "egl", 3, {"--out", egl}), seconds(100), noDisplay_);
  // No driver, no picture; but where Mesa's is installed there must be one.
  const bool hasDriver = ::dlopen("libEGL_mesa.so.0", RTLD_LAZY | RTLD_LOCAL) != nullptr;
  if (b.status != 0 && !hasDriver && b.err.find("no OpenGL can be had") != std::string::npos)
    GTEST_SKIP() << b.err;
  ASSERT_EQ(b.status, 0) << b.err;
  expectSamePictures(egl, offscreen, 3);
}

TEST_F(Surfaces, AMissingDisplayIsOneError) {
  expectOneError(run(tileArguments("window"), seconds(20), noDisplay_), 1, "no window can be opened");
}

TEST_F(Surfaces, FlagsOfAnotherSurfaceAreRefused) {
  expectOneError(run(tileArguments("offscreen", {"--monitor", "HDMI-1"}), seconds(20)), 2, "--monitor");
  expectOneError(run(tileArguments("egl", {"--window", "0,0"}), seconds(20)), 2, "--window");
  expectOneError(run(tileArguments("none", {"--no-vsync"}), seconds(20)), 2, "--vsync");
  expectOneError(run(tileArguments("offscreen", {"--egl-device", "0"}), seconds(20)), 2, "--egl-device");
  expectOneError(run(tileArguments("window", {"--window", "0,0", "--monitor", "X"}), seconds(20)), 2,
                 "leave out --monitor or --window");
  expectOneError(run(tileArguments("window", {"--window", "1"}), seconds(20)), 2, "neither X,Y nor X,Y,WxH");
  const Outcome wall = run(runArguments("none.glb", "offscreen", 1, {"--no-vsync"}), seconds(20));
  EXPECT_EQ(wall.status, 2);
  EXPECT_NE(wall.err.find("--no-vsync: is for windows alone"), std::string::npos) << wall.err;
}

TEST_F(Surfaces, AnEglDeviceThatIsNotThereIsOneError) {
  expectOneError(run(tileArguments("egl", {"--egl-device", "250"}), seconds(20)), 2,
                 "there is no device 250");
}

TEST_F(Surfaces, AMissingProgramIsNamed) {
  const std::string lonely = folder_ / "tessera-tile";
  fs::copy_file(program("tessera-tile"), lonely);
  for (const char* surface : {"window", "egl"}) {
    std::vector<std::string> arguments = tileArguments(surface);
    arguments[0] = lonely;
    expectOneError(run(arguments, seconds(20)), 1, folder_ / "tessera-tile-gl");
  }
}

TEST_F(Surfaces, EachOfTheTwoProgramsIsTheOther) {
  std::vector<std::string> arguments = tileArguments("offscreen");
  arguments[0] = program("tessera-tile-gl");
  expectOneError(run(arguments, seconds(20)), 1, "cannot connect");
}

#ifndef __SANITIZE_ADDRESS__
TEST_F(Surfaces, TheWrongOpenGlIsNoticed) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  const struct {
    const char *surface, *preloaded;
  } cases[] = {{"offscreen", "libGL.so.1"}, {"egl", "libOSMesa.so.8"}};
  for (const auto& [surface, preloaded] : cases) {
    const Outcome outcome = run(runArguments(scene, surface, 1), seconds(60), {{"LD_PRELOAD", preloaded}});
    EXPECT_EQ(outcome.status, 1) << surface << outcome.err;
    EXPECT_NE(outcome.err.find("OpenGL calls go to"), std::string::npos) << outcome.err;
  }
}
#endif

/// With a screen of 800x600.
class Windows : public Surfaces {
 protected:
  void SetUp() override {
    if (!display_.missing().empty()) GTEST_SKIP() << display_.missing();
  }
  [[nodiscard]] Environment here() const { return {{"DISPLAY", display_.name()}, {"WAYLAND_DISPLAY", ""}}; }
  [[nodiscard]] Picture shown(int xPx, int yPx, int widthPx, int heightPx) const {
    return cut(display_.screen(), xPx, yPx, widthPx, heightPx);
  }
  /// A master of one tile, "[WIDTH, HEIGHT]".
  std::vector<std::string> serveArguments(const std::string& scene, const std::string& tilePx) {
    const std::string wall = R"({"grid": {"columns": 1, "rows": 1, "tile_px": )" + tilePx + "}}";
    return {program("tessera"), "serve", "--wall",   folder_.write("one.json", wall),
            "--scene",          scene,   "--listen", "127.0.0.1:0"};
  }
  /// Its tile.
  static std::vector<std::string> windowOf(const Process& master, std::vector<std::string> more) {
    EXPECT_TRUE(master.waitForOut("listening on ", seconds(60))) << master.err();
    const std::string said = master.out();
    const std::string port = std::to_string(std::atoi(said.c_str() + said.find("127.0.0.1:") + 10));
    std::vector<std::string> arguments = {
        program("tessera-tile"), "--connect", "127.0.0.1:" + port, "--tile", "r0c0", "--surface", "window"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static std::vector<pid_t> childrenOf(pid_t parent) {
    std::vector<pid_t> children;
    std::ifstream in("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
    for (pid_t child; in >> child;)
      children.push_back(child);
    return children;
  }
  nlohmann::json report() {
    std::ifstream in(folder_ / "report.json");
    return nlohmann::json::parse(in);
  }

  VirtualDisplay display_{kScreenWidthPx, kScreenHeightPx};
};

TEST_F(Windows, DrawTheSamePicturesAsOffscreen) {
  const std::string scene = plant(), offscreen = folder_ / "offscreen", window = folder_ / "window";
  const Outcome a = run(runArguments(scene, "offscreen", 3, {"--out", offscreen}), seconds(100));
  ASSERT_EQ(a.status, 0) << a.err;
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{}, {"--no-vsync", "--window", "100,50"}}) {
    std::vector<std::string> arguments = runArguments(scene, "window", 3, {"--out", window});
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome b = run(arguments, seconds(100), here());
    ASSERT_EQ(b.status, 0) << b.err;
    expectSamePictures(window, offscreen, 3);
  }
}

TEST_F(Windows, TheScreenShowsTheWallAtItsPlace) {
  const std::string out = folder_ / "out";
  Process wall(runArguments(plant(), "window", 100'000,
                            {"--camera", folder_.write("still.json", kStill), "--fps", "20", "--out", out,
                             "--picture-every", "1000000", "--window", "100,50"}),
               here());
  ASSERT_TRUE(eventually(seconds(60), [&] { return fs::exists(out + "/frame-000001.png"); })) << wall.err();
  const Picture expected = pictureOf(out, 1);
  ASSERT_GT(colours(expected), 100U);
  EXPECT_TRUE(eventually(seconds(20), [&] { return shown(100, 50, 512, 384).rgb == expected.rgb; }))
      << "the screen does not show the stitched picture";
  EXPECT_EQ(colours(shown(0, 0, kScreenWidthPx, 50)), 1U) << "above the wall is nothing";
  EXPECT_EQ(colours(shown(612, 0, kScreenWidthPx - 612, kScreenHeightPx)), 1U) << "nor right of it";
  wall.signal(SIGINT);
  EXPECT_EQ(wall.wait(seconds(10)).status, 0);
}

TEST_F(Windows, AWindowOfAnotherSizeShowsThePictureScaled) {
  const std::string out = folder_ / "out";
  Process wall(runArguments(plant(), "window", 100'000,
                            {"--camera", folder_.write("still.json", kStill), "--fps", "20", "--out", out,
                             "--picture-every", "1000000", "--window", "10,20,256x192"}),
               here());
  ASSERT_TRUE(eventually(seconds(60), [&] { return fs::exists(out + "/frame-000001.png"); })) << wall.err();
  const Picture picture = pictureOf(out, 1);
  EXPECT_EQ(picture.widthPx, 512);
  // Each pixel of the window stands for four of the picture that was sent.
  Picture expected(256, 192);
  for (std::size_t y = 0; y < 192; ++y) {
    for (std::size_t x = 0; x < 256; ++x)
      std::copy_n(picture.rgb.begin() + static_cast<std::ptrdiff_t>((2 * y * 512 + 2 * x) * 3), 3,
                  expected.rgb.begin() + static_cast<std::ptrdiff_t>((y * 256 + x) * 3));
  }
  ASSERT_GT(colours(expected), 100U);
  EXPECT_TRUE(eventually(seconds(20), [&] { return shown(10, 20, 256, 192).rgb == expected.rgb; }));
  EXPECT_EQ(colours(shown(266, 0, kScreenWidthPx - 266, kScreenHeightPx)), 1U)
      << "right of the wall is nothing";
  wall.signal(SIGINT);
  EXPECT_EQ(wall.wait(seconds(10)).status, 0);
}

TEST_F(Windows, FullScreenFillsTheMonitor) {
  Process master(serveArguments(plant(), "[400, 300]"));
  Process tile(windowOf(master, {"--monitor", "screen"}), here());
  EXPECT_TRUE(eventually(seconds(20), [&] {
    const Picture now = display_.screen();
    return now.rgb.front() != 0 && now.rgb.back() != 0 && colours(now) > 100;
  })) << tile.err();
  EXPECT_NE(tile.err().find("is drawn with the 800x600 of monitor screen"), std::string::npos) << tile.err();
  master.signal(SIGINT);
  EXPECT_EQ(tile.wait(seconds(10)).status, 0);
}

TEST_F(Windows, AnUnknownMonitorIsAnErrorThatListsThem) {
  expectOneError(run(tileArguments("window", {"--monitor", "HDMI-7"}), seconds(20), here()), 2,
                 "there is no monitor named \"HDMI-7\"; there are: screen (800x600 at 0,0)");
}

TEST_F(Windows, AWindowThatTheDesktopDoesNotHoldIsAnError) {
  for (const char* place : {"0,0,801x600", "0,0,800x601", "1,0,800x600", "-1,0,800x600", "700,500,200x50"}) {
    const Outcome outcome =
        run(tileArguments("window", {std::string("--window=") + place}), seconds(20), here());
    expectOneError(outcome, 2, "reaches beyond the desktop of 800x600 at 0,0");
  }
}

TEST_F(Windows, ATileThatTheScreenDoesNotHoldIsAnError) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  Process master(serveArguments(scene, "[900, 300]"));
  expectOneError(run(windowOf(master, {}), seconds(20), here()), 1,
                 "a window of 900x300 at 0,0 reaches beyond the desktop");
  expectOneError(run(windowOf(master, {"--monitor", "screen"}), seconds(20), here()), 1,
                 "the tile's 900x300 pixels are more than its 800x600");
  EXPECT_EQ(colours(display_.screen()), 1U) << "no window was opened";
  const Outcome wall = run(runArguments(scene, "window", 10, {"--window", "400,0"}), seconds(60), here());
  EXPECT_EQ(wall.status, 1);
  EXPECT_NE(wall.err.find("a window of 256x192 at 656,0 reaches beyond"), std::string::npos) << wall.err;
}

TEST_F(Windows, EscapeEndsTheWholeWallInOrder) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  Process wall(runArguments(scene, "window", 100'000, {"--fps", "30", "--json", folder_ / "report.json"}),
               here());
  // The background of the last tile.
  ASSERT_TRUE(eventually(seconds(30), [&] { return shown(500, 370, 1, 1).rgb[0] != 0; })) << wall.err();
  if (!display_.movePointer(400, 100)) GTEST_SKIP() << "libXtst, which plays the person, is not installed";
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U);
  ASSERT_TRUE(display_.pressKey('a'));
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_EQ(childrenOf(wall.pid()), tiles) << "another key ends nothing";
  ASSERT_TRUE(display_.pressKey(kEscapeKeysym));
  const Outcome outcome = wall.wait(seconds(10));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("was asked to end the wall"), std::string::npos) << outcome.err;
  const auto json = report();
  EXPECT_GT(json.at("frames"), 1);
  EXPECT_LT(json.at("frames"), 100'000);
  for (const auto& [name, tile] : json.at("tiles").items())
    EXPECT_GT(tile.at("peak_resident_bytes"), 1'000'000) << name << " did not say Bye";
}

/// Without --frames a wall of several shapes stands on the desktop as it hangs, and its operator steers it.
TEST_F(Windows, AnOperatorSteersAWallInItsShape) {
  const std::string scene = plant();
  Process wall({program("tessera"), "run", "--wall", config("wall-mixed.json"), "--scene", scene, "--surface",
                "window", "--window", "0,0,782x240", "--fps", "30", "--json", folder_ / "report.json"},
               here());
  const auto isDark = [&](int x, int y) {
    const Picture pixel = shown(x, y, 1, 1);
    return pixel.rgb[0] + pixel.rgb[1] + pixel.rgb[2] == 0;
  };
  // In the large, the upper, the lower and the portrait tile.
  const std::pair<int, int> inTiles[] = {{100, 20}, {500, 20}, {500, 220}, {700, 20}, {700, 230}};
  for (const auto& [x, y] : inTiles)
    ASSERT_TRUE(eventually(seconds(60), [&, x = x, y = y] { return !isDark(x, y); }))
        << x << ", " << y << wall.err();
  // In the bezels between them.
  EXPECT_TRUE(isDark(429, 120));
  EXPECT_TRUE(isDark(530, 119));
  EXPECT_TRUE(isDark(643, 120));
  if (!display_.movePointer(200, 120)) GTEST_SKIP() << "libXtst, which plays the person, is not installed";
  // Nobody does anything: the picture stands still.
  const Picture before = shown(0, 0, 420, 240);
  std::this_thread::sleep_for(milliseconds(500));
  EXPECT_EQ(shown(0, 0, 420, 240).rgb, before.rgb);
  for (int i = 0; i < 4; ++i)
    ASSERT_TRUE(display_.clickButton(4));  // the wheel: nearer
  EXPECT_TRUE(eventually(seconds(10), [&] { return shown(0, 0, 420, 240).rgb != before.rgb; }));
  const std::size_t sceneColours = colours(shown(650, 0, 130, 240));
  constexpr unsigned long kF2Keysym = 0xffbf;
  ASSERT_TRUE(display_.pressKey(kF2Keysym));  // every tile says its name, on a colour of its own
  EXPECT_TRUE(eventually(seconds(10), [&] {
    const Picture large = shown(2, 2, 1, 200), portrait = shown(650, 100, 1, 1);
    return large.rgb[0] > large.rgb[2] && portrait.rgb[2] > portrait.rgb[0];
  })) << sceneColours;
  ASSERT_TRUE(display_.pressKey(kEscapeKeysym));
  const Outcome outcome = wall.wait(seconds(10));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_GT(report().at("frames"), 10);
}

TEST_F(Windows, WhatAPersonDoesReachesTheMaster) {
  if (!display_.movePointer(700, 500)) GTEST_SKIP() << "libXtst, which plays the person, is not installed";
  const auto scene = loadScene(folder_.write("scene.obj", smallScene()));
  ASSERT_TRUE(scene) << scene.error().text();
  const auto wall = parseWall(R"({"grid": {"columns": 1, "rows": 1, "tile_px": [400, 300]}})", "test");
  const auto path = parseCameraPath(kStill, "test");
  MasterOptions options;
  options.framesPerSecond = 60;
  const auto setups = TileSetups::make(*wall);
  Master master(*scene, *wall, *path, *setups, options);
  const auto port = master.listen({"127.0.0.1", "0"});
  ASSERT_TRUE(port) << port.error().text();
  Process tile({program("tessera-tile"), "--connect", "127.0.0.1:" + std::to_string(*port), "--tile", "r0c0",
                "--surface", "window", "--window", "100,50"},
               here());
  std::vector<proto::Input> seen;
  Master::Hooks hooks;
  hooks.whileWaitingForTiles = [] { return Status(Done{}); };
  hooks.input = [&seen](std::uint32_t, const proto::Input& input) { seen.push_back(input); };
  auto running = std::async(std::launch::async, [&] { return master.run(hooks, false); });
  EXPECT_TRUE(eventually(seconds(30), [&] { return shown(499, 349, 1, 1).rgb[0] != 0; })) << tile.err();
  const auto pause = [] { std::this_thread::sleep_for(milliseconds(200)); };
  pause();
  (void)display_.movePointer(200, 275);
  pause();
  (void)display_.clickButton(3);
  (void)display_.clickButton(4);
  (void)display_.pressKey('a');
  pause();
  (void)display_.pressKey(kEscapeKeysym);
  const bool hasEnded = running.wait_for(seconds(10)) == std::future_status::ready;
  if (!hasEnded) master.stop();
  const auto report = running.get();
  EXPECT_TRUE(hasEnded) << "Escape does not end the run";
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(tile.wait(seconds(10)).status, 0);

  using proto::InputKind;
  const auto told = [&](const proto::Input& wanted) { return std::count(seen.begin(), seen.end(), wanted); };
  EXPECT_EQ(told({.kind = InputKind::Move, .x = 0.25, .y = 0.75}), 1);
  EXPECT_EQ(told({.kind = InputKind::Button, .code = 1, .pressed = true, .x = 0.25, .y = 0.75}), 1);
  EXPECT_EQ(told({.kind = InputKind::Button, .code = 1, .pressed = false, .x = 0.25, .y = 0.75}), 1);
  EXPECT_EQ(told({.kind = InputKind::Scroll, .y = 1}), 1);
  EXPECT_EQ(told({.kind = InputKind::Key, .code = 'A', .pressed = true}), 1);
  EXPECT_EQ(told({.kind = InputKind::Key, .code = 'A', .pressed = false}), 1);
  EXPECT_EQ(told({.kind = InputKind::Quit}), 1);
}

// A tile that does not answer keeps the whole wall at the frame before, though its window has drawn the next.
TEST_F(Windows, APictureIsHeldBackUntilTheWallSwaps) {
  const auto scene = loadScene(plant());
  ASSERT_TRUE(scene) << scene.error().text();
  const auto wall = parseWall(R"({"grid": {"columns": 2, "rows": 1, "tile_px": [200, 150]}})", "test");
  const auto path = readCameraPath(config("orbit.camera.json"));
  ASSERT_TRUE(path) << path.error().text();
  MasterOptions options;
  options.frames = 40;
  options.framesPerSecond = 10;
  options.pictureFolder = folder_.path();
  const auto setups = TileSetups::make(*wall);
  Master master(*scene, *wall, *path, *setups, options);
  const auto port = master.listen({"127.0.0.1", "0"});
  ASSERT_TRUE(port) << port.error().text();
  const std::string address = "127.0.0.1:" + std::to_string(*port);
  Process window({program("tessera-tile"), "--connect", address, "--tile", "r0c0", "--surface", "window"},
                 here());
  Process other({program("tessera-tile"), "--connect", address, "--tile", "r0c1", "--surface", "none"});
  std::atomic<std::uint64_t> sent = 0;
  Master::Hooks hooks;
  hooks.whileWaitingForTiles = [] { return Status(Done{}); };
  hooks.progress = [&sent](std::uint64_t frame, std::uint64_t) { sent = frame; };
  auto running = std::async(std::launch::async, [&] { return master.run(hooks, false); });
  EXPECT_TRUE(eventually(seconds(30), [&] { return sent >= 5; })) << window.err();
  other.signal(SIGSTOP);
  std::this_thread::sleep_for(seconds(1));
  const std::uint64_t held = sent;
  const Picture screen = shown(0, 0, 200, 150);
  other.signal(SIGCONT);
  const auto report = running.get();
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->frames, 40U);
  const auto pictureOfFrame = [&](std::uint64_t frame) {
    const std::string number = std::to_string(frame);
    const auto picture =
        readPng(folder_ / ("frame-" + std::string(6 - number.size(), '0') + number + ".png"));
    EXPECT_TRUE(picture) << picture.error().text();
    return picture ? cut(*picture, 0, 0, 200, 150) : Picture();
  };
  EXPECT_GT(colours(screen), 100U);
  EXPECT_FALSE(pictureOfFrame(held).rgb == pictureOfFrame(held - 1).rgb);
  EXPECT_TRUE(screen.rgb == pictureOfFrame(held - 1).rgb)
      << "frame " << held << " was drawn, and not to be seen yet";
}

TEST_F(Windows, AWindowThatIsKilledLeavesTheOthersAlone) {
  const std::string scene = folder_.write("scene.obj", smallScene());
  Process wall(runArguments(scene, "window", 200, {"--fps", "30", "--json", folder_ / "report.json"}),
               here());
  ASSERT_TRUE(eventually(seconds(30), [&] { return shown(500, 370, 1, 1).rgb[0] != 0; })) << wall.err();
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U) << wall.err();
  ::kill(tiles[1], SIGKILL);
  const Outcome outcome = wall.wait(seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("starting it again"), std::string::npos) << outcome.err;
  int whole = 0, reconnected = 0;
  const auto json = report();
  for (const auto& [name, tile] : json.at("tiles").items()) {
    whole += tile.at("frames_shown") == 200 ? 1 : 0;
    reconnected += tile.at("reconnects") == 1 && tile.at("frames_shown") > 50 ? 1 : 0;
  }
  EXPECT_EQ(whole, 3) << "the other tiles must not miss a frame";
  EXPECT_EQ(reconnected, 1);
}

}  // namespace
}  // namespace tessera::test
