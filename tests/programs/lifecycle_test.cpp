// Starting, stopping, dying and misbehaving: whole programs over loopback.

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <thread>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "proto/codec.h"
#include "tests/programs/small_scene.h"
#include "tests/support/process.h"

namespace tessera::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A peer that says what it likes.
class RawPeer {
 public:
  explicit RawPeer(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0;
    const timeval limit{10, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  }
  ~RawPeer() { ::close(socket_); }
  RawPeer(const RawPeer&) = delete;
  RawPeer& operator=(const RawPeer&) = delete;
  [[nodiscard]] bool connected() const { return connected_; }
  void say(std::span<const std::byte> bytes) const {
    (void)!::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  void endWriting() const { ::shutdown(socket_, SHUT_WR); }
  /// Everything until the other side closes.
  [[nodiscard]] std::string hear() const {
    std::string all;
    char block[4096];
    for (ssize_t n; (n = ::recv(socket_, block, sizeof block, 0)) > 0;)
      all.append(block, static_cast<std::size_t>(n));
    return all;
  }

 private:
  int socket_;
  bool connected_ = false;
};

std::vector<std::byte> bytesOf(const std::string& text) {
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

class Lifecycle : public ::testing::Test {
 protected:
  std::vector<std::string> runArguments(int frames, std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {program("tessera"), "run",  "--wall",   wall_,
                                          "--scene",          scene_, "--frames", std::to_string(frames)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  std::vector<std::string> serveArguments(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {
        program("tessera"), "serve",       "--wall", wall_, "--scene", scene_,
        "--listen",         "127.0.0.1:0", "--fps",  "50"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static int portOf(const Process& master) {
    EXPECT_TRUE(master.waitForOut("listening on 127.0.0.1:", seconds(20))) << master.err();
    const std::string out = master.out();
    return std::atoi(out.c_str() + out.find("127.0.0.1:") + 10);
  }
  static std::vector<std::string> tileArguments(int port, const std::string& name,
                                                const std::string& surface = "none") {
    return {program("tessera-tile"),
            "--connect",
            "127.0.0.1:" + std::to_string(port),
            "--tile",
            name,
            "--surface",
            surface};
  }
  /// Tiles of a wall run by `tessera run` whose arguments hold this test's folder are found by their parent.
  static std::vector<pid_t> childrenOf(pid_t parent) {
    std::vector<pid_t> children;
    std::ifstream in("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
    for (pid_t child; in >> child;)
      children.push_back(child);
    return children;
  }
  /// A process that has ended but that nobody has collected yet is gone, too.
  static bool isGone(pid_t pid) {
    std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
    std::string stat;
    std::getline(in, stat);
    const std::size_t end = stat.rfind(')');
    return end == std::string::npos || stat.substr(end).starts_with(") Z");
  }
  nlohmann::json report(const std::string& file) {
    std::ifstream in(file);
    return nlohmann::json::parse(in);
  }

  TemporaryFolder folder_;
  std::string wall_ = folder_.write("wall.json", smallWall());
  std::string scene_ = folder_.write("scene.obj", smallScene());
};

TEST_F(Lifecycle, RunEndsByItselfAndLeavesPicturesAndAReport) {
  const Outcome outcome = run(runArguments(5, {"--out", folder_ / "out"}), seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto json = report(folder_ / "out/report.json");
  EXPECT_EQ(json.at("frames"), 5);
  EXPECT_EQ(json.at("pictures").at("written"), 5);
  for (const auto& [name, tile] : json.at("tiles").items()) {
    EXPECT_EQ(tile.at("frames_shown"), 5) << name;
    EXPECT_GT(tile.at("peak_resident_bytes"), 1'000'000) << name;
  }
  EXPECT_FALSE(json.at("swap_skew_us").is_null());
  EXPECT_GT(json.at("stages_ms").at("master").at("p50"), 0);
  EXPECT_GT(json.at("master_share_of_60hz_percent").at("max"), 0);
  const auto& mode = json.at("mode");
  EXPECT_TRUE(mode.at("picked").is_string());
  EXPECT_EQ(mode.at("hierarchy"), "graph");
  EXPECT_EQ(mode.at("mtpl"), 0);
  EXPECT_TRUE(mode.at("switches").empty());
}

TEST_F(Lifecycle, TheReportNamesWhatRan) {
  const Outcome outcome =
      run(runArguments(3, {"--surface", "none", "--hierarchy", "bvh", "--mtpl", "50", "--algorithm",
                           "adaptive", "--octant-test", "--json", folder_ / "report.json"}),
          seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto mode = report(folder_ / "report.json").at("mode");
  EXPECT_EQ(mode.at("algorithm"), "adaptive");
  EXPECT_EQ(mode.at("picked"), "adaptive");
  EXPECT_EQ(mode.at("hierarchy"), "bvh");
  EXPECT_EQ(mode.at("mtpl"), 50);
  EXPECT_EQ(mode.at("switches"), nlohmann::json::array({"octant-test"}));
}

class LifecycleSignal : public Lifecycle, public ::testing::WithParamInterface<int> {};

TEST_P(LifecycleSignal, EndsEverythingWithinTwoSecondsWithoutOrphans) {
  Process wall(runArguments(100'000, {"--fps", "30", "--json", folder_ / "report.json"}));
  ASSERT_TRUE(wall.waitForErr("frames", seconds(60)) || childrenOf(wall.pid()).size() == 4);
  std::this_thread::sleep_for(seconds(2));
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U) << wall.err();
  const auto start = std::chrono::steady_clock::now();
  wall.signal(GetParam());
  const Outcome outcome = wall.wait(seconds(10));
  EXPECT_LT(std::chrono::steady_clock::now() - start, milliseconds(2000));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (const pid_t tile : tiles)
    EXPECT_TRUE(isGone(tile)) << "tile process " << tile << " is left";
  EXPECT_GT(report(folder_ / "report.json").at("frames"), 1);
}

INSTANTIATE_TEST_SUITE_P(Signals, LifecycleSignal, ::testing::Values(SIGINT, SIGTERM),
                         [](const auto& test) { return test.param == SIGINT ? "CtrlC" : "Terminate"; });

TEST_F(Lifecycle, TilesDieWithAMasterThatIsKilled) {
  Process wall(runArguments(100'000, {"--fps", "30"}));
  std::this_thread::sleep_for(seconds(2));
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U) << wall.err();
  wall.signal(SIGKILL);
  (void)wall.wait(seconds(5));
  std::this_thread::sleep_for(seconds(1));
  for (const pid_t tile : tiles)
    EXPECT_TRUE(isGone(tile)) << "tile process " << tile << " is left";
}

TEST_F(Lifecycle, ATileThatDiesIsStartedAgainAndTheWallGoesOn) {
  Process wall(runArguments(200, {"--fps", "40", "--json", folder_ / "report.json"}));
  std::this_thread::sleep_for(seconds(2));
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U) << wall.err();
  ::kill(tiles[1], SIGKILL);
  const Outcome outcome = wall.wait(seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("starting it again"), std::string::npos) << outcome.err;
  const auto json = report(folder_ / "report.json");
  int whole = 0, reconnected = 0;
  for (const auto& [name, tile] : json.at("tiles").items()) {
    whole += tile.at("frames_shown") == 200 ? 1 : 0;
    reconnected += tile.at("reconnects") == 1 && tile.at("frames_shown") > 50 ? 1 : 0;
  }
  EXPECT_EQ(whole, 3) << "the other tiles must not miss a frame";
  EXPECT_EQ(reconnected, 1);
}

TEST_F(Lifecycle, SeveralTilesInAProcessCompleteARun) {
  for (const char* perProcess : {"0", "3"}) {
    const Outcome outcome = run(runArguments(40, {"--surface", "none", "--tiles-per-process", perProcess,
                                                  "--json", folder_ / "report.json"}),
                                seconds(60));
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto json = report(folder_ / "report.json");
    for (const auto& [name, tile] : json.at("tiles").items()) {
      EXPECT_EQ(tile.at("frames_shown"), 40) << name;
      EXPECT_GT(tile.at("received_bytes"), 0) << name;
    }
  }
}

TEST_F(Lifecycle, AProcessOfSeveralTilesThatDiesIsStartedAgainWithAllOfThem) {
  Process wall(runArguments(200, {"--fps", "40", "--surface", "none", "--tiles-per-process", "3", "--json",
                                  folder_ / "report.json"}));
  std::this_thread::sleep_for(seconds(2));
  const std::vector<pid_t> helpers = childrenOf(wall.pid());
  ASSERT_EQ(helpers.size(), 2U) << wall.err();
  ::kill(helpers[0], SIGKILL);
  const Outcome outcome = wall.wait(seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("tiles r0c0 to r1c0: its process was ended by the signal"), std::string::npos)
      << outcome.err;
  const auto json = report(folder_ / "report.json");
  for (const auto& [name, tile] : json.at("tiles").items()) {
    const bool isHit = name != "r1c1";
    EXPECT_EQ(tile.at("reconnects"), isHit ? 1 : 0) << name;
    EXPECT_GT(tile.at("frames_shown"), 50) << name;
    EXPECT_TRUE(isHit || tile.at("frames_shown") == 200) << name;
  }
}

TEST_F(Lifecycle, AProcessDrawsOneTile) {
  const Outcome tile = run({program("tessera-tile"), "--connect", "127.0.0.1:1", "--tile", "r0c0", "--tile",
                            "r0c1", "--surface", "offscreen"},
                           seconds(10));
  const Outcome wall = run(runArguments(5, {"--tiles-per-process", "2"}), seconds(10));
  for (const Outcome& outcome : {tile, wall}) {
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find("a process draws one tile"), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(Lifecycle, AProcessOfSeveralTilesEndsWhereOneIsRefused) {
  Process master(serveArguments());
  const int port = portOf(master);
  std::vector<std::string> arguments = tileArguments(port, "r0c0");
  arguments.insert(arguments.end(), {"--tile", "r9c9"});
  const Outcome outcome = run(arguments, seconds(10));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("no tile named \"r9c9\""), std::string::npos) << outcome.err;
}

TEST_F(Lifecycle, ATileThatStopsIsLeftBehind) {
  Process wall(
      runArguments(150, {"--fps", "50", "--frame-deadline", "0.8", "--json", folder_ / "report.json"}));
  std::this_thread::sleep_for(seconds(2));
  const std::vector<pid_t> tiles = childrenOf(wall.pid());
  ASSERT_EQ(tiles.size(), 4U) << wall.err();
  ::kill(tiles[2], SIGSTOP);
  const Outcome outcome = wall.wait(seconds(60));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("left behind"), std::string::npos) << outcome.err;
  EXPECT_TRUE(isGone(tiles[2]));
  int whole = 0;
  const auto json = report(folder_ / "report.json");
  for (const auto& [name, tile] : json.at("tiles").items())
    whole += tile.at("frames_shown") == 150 ? 1 : 0;
  EXPECT_EQ(whole, 3);
}

TEST_F(Lifecycle, ATileThatCannotStartIsNamedWithItsLastWords) {
  const std::string broken = folder_.write("broken-tile", "#!/bin/sh\necho no screen here >&2\nexit 3\n");
  ::chmod(broken.c_str(), 0755);
  const Outcome outcome = run(runArguments(5), seconds(30), {{"TESSERA_TILE_PROGRAM", broken}});
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("tessera: error: tile r"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("no screen here"), std::string::npos) << outcome.err;
}

TEST_F(Lifecycle, ServeSpeaksWithTilesFromElsewhere) {
  Process master(serveArguments({"--frames", "20", "--json", folder_ / "report.json"}));
  const int port = portOf(master);
  std::vector<std::unique_ptr<Process>> tiles;
  for (const char* name : {"r0c0", "r0c1", "r1c0", "r1c1"}) {
    tiles.push_back(std::make_unique<Process>(tileArguments(port, name)));
  }
  const Outcome outcome = master.wait(seconds(30));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  for (auto& tile : tiles) {
    const Outcome ended = tile->wait(seconds(5));
    EXPECT_EQ(ended.status, 0) << ended.err;
  }
  const auto json = report(folder_ / "report.json");
  for (const auto& [name, tile] : json.at("tiles").items())
    EXPECT_EQ(tile.at("frames_shown"), 20) << name;
}

TEST_F(Lifecycle, AnUnknownTileAndASecondOneOfTheSameNameAreRefused) {
  Process master(serveArguments());
  const int port = portOf(master);
  const Outcome unknown = run(tileArguments(port, "r9c9"), seconds(10));
  EXPECT_EQ(unknown.status, 1);
  EXPECT_NE(unknown.err.find("no tile named \"r9c9\""), std::string::npos) << unknown.err;

  Process first(tileArguments(port, "r0c0"));
  std::this_thread::sleep_for(milliseconds(500));
  const Outcome second = run(tileArguments(port, "r0c0"), seconds(10));
  EXPECT_EQ(second.status, 1);
  EXPECT_NE(second.err.find("connected already"), std::string::npos) << second.err;
  EXPECT_FALSE(isGone(first.pid()));
}

TEST_F(Lifecycle, APortInUseIsOneClearError) {
  Process master(serveArguments());
  const int port = portOf(master);
  const Outcome second = run({program("tessera"), "serve", "--wall", wall_, "--scene", scene_, "--listen",
                              "127.0.0.1:" + std::to_string(port)},
                             seconds(10));
  EXPECT_EQ(second.status, 2);
  EXPECT_NE(second.err.find("the port is in use"), std::string::npos) << second.err;
}

TEST_F(Lifecycle, NobodyThereIsOneClearError) {
  const Outcome outcome = run(tileArguments(1, "r0c0"), seconds(20));
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("cannot connect"), std::string::npos) << outcome.err;
}

TEST_F(Lifecycle, GarbagePeersDisturbNobody) {
  Process master(serveArguments({"--frames", "150", "--json", folder_ / "report.json"}));
  const int port = portOf(master);
  std::vector<std::unique_ptr<Process>> tiles;
  for (const char* name : {"r0c0", "r0c1", "r1c0", "r1c1"})
    tiles.push_back(std::make_unique<Process>(tileArguments(port, name)));
  ASSERT_TRUE(tiles.back()->pid() > 0);

  proto::Hello hello;
  hello.tileName = "r0c0";
  const proto::Bytes good = proto::encode(hello);
  // Cut everywhere: a Hello that ends early.
  for (std::size_t n = 0; n < good.size(); n += 7) {
    const RawPeer peer(port);
    ASSERT_TRUE(peer.connected());
    peer.say(std::span(good).first(n));
  }
  // Garbled everywhere: each is refused.
  for (std::size_t n = 0; n < good.size(); n += 5) {
    proto::Bytes bad = good;
    bad[n] ^= std::byte{0x41};
    const RawPeer peer(port);
    peer.say(bad);
    peer.endWriting();
  }
  {
    const RawPeer peer(port);
    peer.say(bytesOf("GET / HTTP/1.1\r\nHost: wall\r\n\r\n"));
    const std::string answer = peer.hear();
    EXPECT_NE(answer.find("TSRA"), std::string::npos) << "an error message is due";
  }
  {  // Another version: told so.
    proto::Bytes other = good;
    other[4] = std::byte{9};
    const RawPeer peer(port);
    peer.say(other);
    EXPECT_NE(peer.hear().find("version"), std::string::npos);
  }
  const Outcome outcome = master.wait(seconds(60));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto json = report(folder_ / "report.json");
  for (const auto& [name, tile] : json.at("tiles").items()) {
    EXPECT_EQ(tile.at("frames_shown"), 150) << name;
    EXPECT_EQ(tile.at("reconnects"), 0) << name;
  }
}

TEST_F(Lifecycle, LateTilesJoinARunningWall) {
  Process master(
      serveArguments({"--frames", "150", "--tiles-deadline", "0.5", "--json", folder_ / "report.json"}));
  const int port = portOf(master);
  Process early(tileArguments(port, "r0c0", "offscreen"));
  std::this_thread::sleep_for(milliseconds(1500));
  Process late(tileArguments(port, "r1c1", "offscreen"));
  const Outcome outcome = master.wait(seconds(60));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("starting without them"), std::string::npos) << outcome.err;
  const auto json = report(folder_ / "report.json");
  EXPECT_GT(json.at("tiles").at("r1c1").at("frames_shown"), 20);
  EXPECT_LT(json.at("tiles").at("r1c1").at("frames_shown"), json.at("tiles").at("r0c0").at("frames_shown"));
  EXPECT_EQ(json.at("tiles").at("r0c1").at("frames_shown"), 0);
}

}  // namespace
}  // namespace tessera::test
