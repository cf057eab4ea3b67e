// Thousands of damaged and hostile copies of every small scene, each imported in a confined process of its
// own: this process lives, each of them ends in time, our own glTF import neither crashes nor hangs, and
// nothing reaches for files or servers outside of the scene's folder. Stock OpenSceneGraph readers do crash;
// that their process dies and no other is what it is for.
//   TESSERA_MUTANTS=N        how many (200)
//   TESSERA_MUTANT_FIRST=S   the first seed (1)
//   TESSERA_MUTANT_SEED=S    this one alone, with what the import says; its file is kept
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/inotify.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/scene/load_scene.h"
#include "tests/support/confined_import.h"
#include "tests/support/process.h"
#include "tests/support/scene_mutator.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxSceneBytes = 2'600'000;
constexpr std::chrono::seconds kDeadline{20};
constexpr std::size_t kAtOnce = 2;
constexpr std::uint64_t kReportEvery = 500;

std::uint64_t setting(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// A file and a server that nobody may touch, and that notice who does.
class Traps {
 public:
  explicit Traps(const fs::path& folder) : file_(folder / "canary.png") {
    fs::create_directories(folder);
    std::ofstream(file_) << "canary";
    watch_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    // The file and not its folder: whoever lists folders meanwhile is not meant.
    ::inotify_add_watch(watch_, file_.c_str(), IN_OPEN | IN_ACCESS | IN_MODIFY);
    server_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address_;
    if (::bind(server_, reinterpret_cast<const sockaddr*>(&address_), size) != 0 ||
        ::listen(server_, 16) != 0 ||
        ::getsockname(server_, reinterpret_cast<sockaddr*>(&address_), &size) != 0) {
      ADD_FAILURE() << "there is no loopback network";
    }
  }
  ~Traps() {
    ::close(watch_);
    ::close(server_);
  }
  Traps(const Traps&) = delete;
  Traps& operator=(const Traps&) = delete;

  [[nodiscard]] Bait bait() const {
    return {.paths = {file_.string(), "../outside/canary.png",
                      "../../" + file_.parent_path().filename().string() + "/canary.png"},
            .url = "http://127.0.0.1:" + std::to_string(ntohs(address_.sin_port)) + "/x.osgt"};
  }
  /// True once after somebody opened the file.
  bool fileWasTouched() {
    std::array<char, 4096> events;
    return ::read(watch_, events.data(), events.size()) > 0;
  }
  bool serverWasAsked() {
    const int connection = ::accept(server_, nullptr, nullptr);
    if (connection < 0) return false;
    ::close(connection);
    return true;
  }
  /// What an import must not do.
  void touch() const {
    ::close(::open(file_.c_str(), O_RDONLY));
    const int client = ::socket(AF_INET, SOCK_STREAM, 0);
    ::connect(client, reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
    ::close(client);
  }

 private:
  fs::path file_;
  int watch_ = -1, server_ = -1;
  sockaddr_in address_{};
};

/// A scene with what lies beside it, in a folder of its own.
struct Original {
  std::string name, extension, bytes;
  fs::path folder;
  bool isGood = false;  ///< this process could load it
};

/// Copies what a scene may refer to.
void copyCompanions(const fs::path& from, const fs::path& to, int depth) {
  fs::create_directories(to);
  for (const auto& entry : fs::directory_iterator(from)) {
    const std::string extension = entry.path().extension().string();
    if (entry.is_directory() && depth > 0)
      copyCompanions(entry.path(), to / entry.path().filename(), depth - 1);
    const bool isCompanion = extension == ".bin" || extension == ".png" || extension == ".jpg" ||
                             extension == ".JPG" || extension == ".rgb" || extension == ".rgba" ||
                             extension == ".mtl";
    if (entry.is_regular_file() && isCompanion && entry.file_size() < 8'000'000) {
      fs::copy_file(entry.path(), to / entry.path().filename(), fs::copy_options::overwrite_existing);
    }
  }
}

std::vector<Original> originals(const TemporaryFolder& folder) {
  std::vector<fs::path> files;
  const fs::path scenes = fs::path(TESSERA_SOURCE_DIR).parent_path() / "shared/scenes";
  const char* other = std::getenv("TESSERA_SCENES");
  const fs::path root = other == nullptr ? scenes : fs::path(other);
  if (!fs::exists(root)) return {};
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension().string();
    const bool isScene = extension == ".gltf" || extension == ".glb" || extension == ".osgt" ||
                         extension == ".obj" || extension == ".ac";
    if (isScene && entry.is_regular_file() && entry.file_size() < kMaxSceneBytes)
      files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Original> all;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    Original original{.name = fs::relative(file, root).string(),
                      .extension = file.extension().string(),
                      .bytes = std::string(std::istreambuf_iterator<char>(in), {}),
                      .folder = folder / std::to_string(all.size()),
                      .isGood = false};
    copyCompanions(file.parent_path(), original.folder, 1);
    // Loads the reader and the plugins that it needs into this process, for all children to have. Its file is
    // in order; one that is refused, because it needs an extension, is of use all the same.
    const fs::path copy = original.folder / ("original" + original.extension);
    std::ofstream(copy, std::ios::binary) << original.bytes;
    original.isGood = loadScene(copy).ok();
    fs::remove(copy);
    all.push_back(std::move(original));
  }
  return all;
}

struct Counts {
  std::array<std::uint64_t, kImportEnds> ends{};
};

/// One mutant under way.
struct Running {
  std::uint64_t seed = 0;
  const Original* original = nullptr;
  std::string what;
  fs::path file;
  std::unique_ptr<ConfinedImport> import;
};

/// Own code is met more often than that of others, small files as often as large ones; originals that are
/// refused for an extension that they need teach little, and are taken seldom.
const Original& pick(const std::vector<Original>& all, std::uint64_t seed) {
  static constexpr std::array kExtensions = {".gltf", ".glb",  ".gltf", ".glb", ".gltf",
                                             ".glb",  ".osgt", ".osgt", ".obj", ".ac"};
  const std::string extension = kExtensions[seed % kExtensions.size()];
  const std::uint64_t round = seed / kExtensions.size();
  std::vector<const Original*> some;
  for (const Original& original : all) {
    if (original.extension == extension && (original.isGood || round % 16 == 0)) some.push_back(&original);
  }
  return some.empty() ? all[round % all.size()] : *some[round % some.size()];
}

bool isOurs(const std::string& extension) {
  return extension == ".gltf" || extension == ".glb";
}

void report(const std::map<std::string, Counts>& counts) {
  std::printf("%-8s", "format");
  for (std::size_t i = 0; i < kImportEnds; ++i)
    std::printf("%11s", nameOf(static_cast<ImportEnd>(i)));
  std::printf("\n");
  for (const auto& [extension, count] : counts) {
    std::printf("%-8s", extension.c_str());
    for (const std::uint64_t n : count.ends)
      std::printf("%11llu", static_cast<unsigned long long>(n));
    std::printf("\n");
  }
  std::fflush(stdout);
}

TEST(SceneMutants, HarmNobody) {
  TemporaryFolder folder;
  const std::vector<Original> all = originals(folder);
  if (all.empty()) GTEST_SKIP() << "the folder of scenes is not there (../shared/scenes, or TESSERA_SCENES)";
  const std::uint64_t alone = setting("TESSERA_MUTANT_SEED", 0);
  const std::uint64_t first = alone != 0 ? alone : setting("TESSERA_MUTANT_FIRST", 1);
  const std::uint64_t last = alone != 0 ? alone : first + setting("TESSERA_MUTANTS", 200) - 1;
  Traps traps(folder / "outside");
  const Bait bait = traps.bait();

  std::map<std::string, Counts> counts;
  std::vector<Running> running;
  std::uint64_t seed = first, judged = 0;
  const auto judge = [&](const Running& one) {
    const ImportEnd end = one.import->end();
    ++counts[one.original->extension].ends[static_cast<std::size_t>(end)];
    const bool isBad =
        end == ImportEnd::Broken ||
        (isOurs(one.original->extension) && (end == ImportEnd::Crashed || end == ImportEnd::TimedOut));
    const std::string story = "TESSERA_MUTANT_SEED=" + std::to_string(one.seed) + " " + one.original->name +
                              " " + nameOf(end) + " (" + one.import->detail() + "): " + one.what;
    EXPECT_FALSE(isBad) << story;
    EXPECT_FALSE(traps.fileWasTouched()) << "a file outside was opened: " << story;
    EXPECT_FALSE(traps.serverWasAsked()) << "a server was asked: " << story;
    if (alone != 0) {
      const fs::path kept =
          fs::temp_directory_path() / ("mutant-" + std::to_string(one.seed) + one.original->extension);
      fs::copy_file(one.file, kept, fs::copy_options::overwrite_existing);
      std::printf("%s\nkept as %s\n", story.c_str(), kept.c_str());
    } else if (end == ImportEnd::Crashed || end == ImportEnd::TimedOut || end == ImportEnd::Memory) {
      std::printf("%s\n", story.substr(0, 200).c_str());
    }
    fs::remove(one.file);
    if (++judged % kReportEvery == 0) report(counts);
  };
  while (seed <= last || !running.empty()) {
    while (seed <= last && running.size() < kAtOnce) {
      const Original& original = pick(all, seed);
      Mutant mutant = mutateScene(original.bytes, original.extension, seed, bait);
      Running one{.seed = seed, .original = &original, .what = mutant.what, .file = {}, .import = nullptr};
      one.file = original.folder / ("mutant-" + std::to_string(seed) + original.extension);
      std::ofstream(one.file, std::ios::binary) << mutant.bytes;
      std::fflush(stdout);
      one.import = std::make_unique<ConfinedImport>(one.file, kDeadline, alone != 0);
      running.push_back(std::move(one));
      ++seed;
    }
    for (auto it = running.begin(); it != running.end();) {
      if (!it->import->poll()) {
        ++it;
        continue;
      }
      judge(*it);
      it = running.erase(it);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  report(counts);
}

TEST(SceneMutants, TheOriginalsAreLoadedAsWithoutConfinement) {
  TemporaryFolder folder;
  const std::vector<Original> all = originals(folder);
  if (all.empty()) GTEST_SKIP() << "the folder of scenes is not there (../shared/scenes, or TESSERA_SCENES)";
  std::size_t good = 0;
  for (const Original& original : all) {
    const fs::path file = original.folder / ("scene" + original.extension);
    std::ofstream(file, std::ios::binary) << original.bytes;
    ConfinedImport import(file, kDeadline, true);
    while (!import.poll())
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(import.end(), original.isGood ? ImportEnd::Good : ImportEnd::Refused) << original.name;
    if (original.isGood) ++good;
  }
  EXPECT_GT(good, all.size() / 2);
}

TEST(SceneMutants, TheTrapsNotice) {
  TemporaryFolder folder;
  Traps traps(folder / "outside");
  EXPECT_FALSE(traps.fileWasTouched());
  EXPECT_FALSE(traps.serverWasAsked());
  const pid_t child = ::fork();
  if (child == 0) {
    traps.touch();
    ::_exit(0);
  }
  ::waitpid(child, nullptr, 0);
  EXPECT_TRUE(traps.fileWasTouched());
  EXPECT_TRUE(traps.serverWasAsked());
}

TEST(SceneMutator, MakesTheSameOfTheSameSeed) {
  const std::string bytes = R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0},{"mesh":1,"name":"x"}]})";
  std::map<std::string, int> different;
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    const Bait bait{.paths = {"/a"}, .url = "http://b/"};
    const Mutant mutant = mutateScene(bytes, ".gltf", seed, bait);
    EXPECT_EQ(mutant.bytes, mutateScene(bytes, ".gltf", seed, bait).bytes);
    EXPECT_FALSE(mutant.what.empty());
    ++different[mutant.bytes];
  }
  EXPECT_GT(different.size(), 300u);
  EXPECT_LT(different[bytes], 50);
}

}  // namespace
}  // namespace tessera::test
