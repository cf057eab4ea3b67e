// Several processes on one folder, processes that are killed, and disks that are full.

#include <csignal>

#include <sys/mount.h>
#include <sys/resource.h>

#include "common/assets/disk_store.h"
#include "common/base/sandbox.h"
#include "tests/common/assets/store_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

using ProcessesTest = StoreTest;

constexpr std::uint64_t kPool = 200;

std::string poolBytes(std::uint64_t i) {
  return someBytes(i, 100 + 37 * i);
}

/// Writes, reads and maps at random; not 0 where anything but right bytes came.
int workOnStore(const DiskStore::Options& options, std::uint64_t seed, int steps, bool evicts) {
  auto opened = DiskStore::open(options);
  if (!opened) return 1;
  DiskStore& store = **opened;
  std::mt19937_64 random(seed);
  for (int step = 0; step < steps; ++step) {
    const std::uint64_t which = random() % kPool;
    const std::string bytes = poolBytes(which);
    const AssetId id = assetIdOf(bytesOf(bytes));
    const std::string name = "e" + std::to_string(which % 5);
    switch (random() % 8) {
      case 0:
        if (!store.publish()) return 2;
        break;
      case 1:
        if (!store.putEntry(name, bytesOf(bytes))) return 3;
        break;
      case 2: {
        auto entry = store.mapEntry(name);
        if (!entry) return 4;
        // Whoever wrote it last: it begins with the seed that it is made of.
        if (!*entry) break;
        const auto got = (*entry)->bytes();
        std::uint64_t by = 0;
        std::memcpy(&by, got.data(), sizeof by);
        if (by >= kPool ||
            poolBytes(by) != std::string(reinterpret_cast<const char*>(got.data()), got.size())) {
          return 5;
        }
        break;
      }
      case 3:
        if (evicts) store.evict();
        break;
      case 4:
      case 5:
        if (!store.add(id, AssetKind::Drawable, bytesOf(bytes))) return 6;
        break;
      default: {
        const auto place = store.find(id);
        if (!place) break;
        ReadProblem problem{};
        const auto got = store.read(id, *place, &problem);
        if (got ? *got != bytes : problem != ReadProblem::Missing) return 7;
      }
    }
  }
  return 0;
}

TEST_F(ProcessesTest, WriteReadAndEvictAtOnce) {
  options_.packBytes = 20000;
  options_.budgetBytes = 300000;
  std::vector<pid_t> children;
  for (std::uint64_t i = 0; i < 5; ++i) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(workOnStore(options_, 10 + i, 1500, i == 4));
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }
  EXPECT_TRUE(filesIn(folder().unpublished()).empty());
  auto store = open();
  EXPECT_GT(store->contents().size(), 0u);
  for (const auto& content : store->contents())
    EXPECT_TRUE(get(*store, content.id));
}

TEST_F(ProcessesTest, NothingIsEvictedUnderOneThatUsesIt) {
  options_.packBytes = 5000;
  {
    auto store = open();
    for (std::uint64_t i = 0; i < kPool; ++i)
      put(*store, poolBytes(i));
    ASSERT_TRUE(store->publish().ok());
  }
  options_.budgetBytes = 0;
  const pid_t evictor = ::fork();
  if (evictor == 0) {
    for (;;)
      open()->evict();
  }
  // What uses() grants is there from then on; what it refuses is gone.
  auto store = open();
  int granted = 0;
  for (int round = 0; round < 200; ++round) {
    const std::string bytes = someBytes(static_cast<std::uint64_t>(round) + 1000, 300);
    const AssetId id = put(*store, bytes);
    const StoredAsset place = *store->find(id);
    ASSERT_TRUE(store->publish().ok());
    if (!store->uses(place.pack)) continue;
    ++granted;
    ::usleep(200);
    EXPECT_TRUE(fs::exists(folder().pack(place.pack)));
    EXPECT_EQ(*store->read(id, place), bytes);
  }
  ::kill(evictor, SIGKILL);
  ::waitpid(evictor, nullptr, 0);
  EXPECT_GT(granted, 0);
}

TEST_F(ProcessesTest, AWriterKilledAtAnyMomentLeavesNothingHalfWritten) {
  options_.packBytes = 10000;
  std::mt19937 random(7);
  std::size_t leftovers = 0;
  for (int round = 0; round < 60; ++round) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(workOnStore(options_, static_cast<std::uint64_t>(round), 1 << 20, false));
    ::usleep(static_cast<useconds_t>(500 + random() % 20000));
    // A living process' files stay.
    auto store = open();
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    leftovers += filesIn(folder().unpublished()).size();
    store = open();
    ASSERT_TRUE(filesIn(folder().unpublished()).empty());
    for (const auto& content : store->contents())
      ASSERT_TRUE(get(*store, content.id));
    for (int i = 0; i < 5; ++i) {
      const auto entry = store->mapEntry("e" + std::to_string(i));
      ASSERT_TRUE(entry.ok());
      ASSERT_EQ(entry->has_value(), fs::exists(folder().entries() / ("e" + std::to_string(i))));
    }
    ASSERT_EQ(*store->dropDamaged(), 0u);
  }
  EXPECT_GT(leftovers, 0u) << "no writer was killed while writing: this test shows nothing";
}

TEST_F(ProcessesTest, OpeningLeavesTheFilesOfTheLivingAlone) {
  auto writer = open();
  const AssetId id = put(*writer, someBytes(2, 100));
  EXPECT_EQ(inChild([&] { return open() ? 0 : 1; }), 0);
  ASSERT_TRUE(writer->publish().ok());
  EXPECT_TRUE(get(*open(), id));
}

TEST_F(ProcessesTest, AConfinedProcessFillsAndMendsAStore) {
  ASSERT_TRUE(open());  // A folder must be there before a process is confined to it.
  const std::string bytes = someBytes(2, 1000);
  const AssetId id = assetIdOf(bytesOf(bytes));
  const int outcome = inChild([&] {
    const auto done = confine({.readable = systemReadable(), .writable = {options_.folder}});
    if (!done) return 1;
    if (!done->files) return 77;
    options_.budgetBytes = 0;
    auto store = DiskStore::open(options_);
    if (!store || !(*store)->add(id, AssetKind::Image, bytesOf(bytes)) || !(*store)->publish()) return 2;
    if (get(**store, id) != bytes || !(*store)->uses((*store)->find(id)->pack)) return 3;
    if (!(*store)->putEntry("index", bytesOf(bytes)) || !(*store)->putEntry("index", bytesOf(bytes)))
      return 4;
    {
      auto entry = (*store)->mapEntry("index");
      if (!entry || !*entry || (*entry)->bytes().size() != bytes.size()) return 5;
    }
    if (!(*store)->putEntry("other", bytesOf(bytes)) || (*store)->evict().removed != 2) return 6;
    return (*store)->dropDamaged() ? 0 : 7;
  });
  if (outcome == 77) GTEST_SKIP() << "this kernel cannot hold files back";
  EXPECT_EQ(outcome, 0);
  EXPECT_EQ(get(*open(), id), bytes);
}

/// Adds until the disk is full. 0: all errors were told well, and nothing half-written was seen.
int fillDisk(const DiskStore::Options& options, const std::string& folder) {
  const auto isTold = [&](const Error& error) {
    return error.text().find(folder) != std::string::npos &&
           error.text().find("free space there") != std::string::npos;
  };
  auto store = DiskStore::open(options);
  if (!store) return 1;
  bool wasFull = false;
  for (std::uint64_t i = 0; i < 100; ++i) {
    const std::string bytes = someBytes(2 * i, 30000);
    const auto place = (*store)->add(assetIdOf(bytesOf(bytes)), AssetKind::Drawable, bytesOf(bytes));
    if (place) continue;
    wasFull = true;
    if (!isTold(place.error())) return 2;
  }
  if (!wasFull) return 3;
  const Status published = (*store)->publish();
  if (!published && !isTold(published.error())) return 4;
  const Status entry = (*store)->putEntry("index", bytesOf(someBytes(2, 3'000'000)));
  if (entry || !isTold(entry.error())) return 5;
  if (!filesIn(fs::path(folder) / "tmp").empty()) return 6;
  if ((*store)->mapEntry("index")->has_value()) return 7;
  // What there is can be read, here and by others.
  for (const auto& content : (*store)->contents()) {
    if (!(*store)->read(content.id, *(*store)->find(content.id))) return 8;
  }
  auto other = DiskStore::open(options);
  for (const auto& content : (*other)->contents()) {
    if (!(*other)->read(content.id, *(*other)->find(content.id))) return 9;
  }
  if ((*other)->contents().size() != (*store)->contents().size()) return 10;
  const auto dropped = (*other)->dropDamaged();
  return dropped && *dropped == 0 ? 0 : 11;
}

TEST_F(ProcessesTest, AFileThatMayNotGrowIsToldAsAFullDisk) {
  for (const std::uint64_t packBytes : {std::uint64_t{1} << 16, std::uint64_t{1} << 26}) {
    options_.packBytes = packBytes;
    options_.folder = folder_ / std::to_string(packBytes);
    EXPECT_EQ(inChild([&] {
                ::signal(SIGXFSZ, SIG_IGN);
                const rlimit limit{50000, 50000};
                ::setrlimit(RLIMIT_FSIZE, &limit);
                return fillDisk(options_, options_.folder.string());
              }),
              0)
        << packBytes;
  }
}

TEST_F(ProcessesTest, AFullDiskIsToldAndLeavesNothingHalfWritten) {
  const std::string disk = folder_ / "disk";
  fs::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=2m,mode=0700") != 0) {
    GTEST_SKIP() << "this user may not mount a small disk";
  }
  for (const std::uint64_t packBytes : {std::uint64_t{1} << 17, std::uint64_t{1} << 26}) {
    options_.packBytes = packBytes;
    options_.folder = disk + "/" + std::to_string(packBytes);
    EXPECT_EQ(inChild([&] { return fillDisk(options_, options_.folder.string()); }), 0) << packBytes;
    fs::remove_all(options_.folder);
  }
  // An entry is mapped even where there is no room for its copy.
  options_.folder = disk + "/entries";
  auto store = open();
  const std::string bytes = someBytes(2, 1'500'000);
  EXPECT_TRUE(store->putEntry("index", bytesOf(bytes)).ok());
  auto entry = store->mapEntry("index");
  ASSERT_TRUE(entry.ok() && entry->has_value());
  EXPECT_EQ(std::memcmp((*entry)->bytes().data(), bytes.data(), bytes.size()), 0);
  entry = std::optional<MappedEntry>();
  store.reset();
  EXPECT_EQ(::umount2(disk.c_str(), MNT_DETACH), 0);
}

}  // namespace
}  // namespace tessera::test
