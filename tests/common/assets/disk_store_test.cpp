#include "common/assets/disk_store.h"

#include <atomic>
#include <map>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>

#include "common/assets/pack_format.h"
#include "tests/common/assets/store_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

using DiskStoreTest = StoreTest;

void setUsed(const fs::path& path, std::int64_t seconds) {
  const timespec times[2] = {{seconds, 0}, {seconds, 0}};
  ASSERT_EQ(::utimensat(AT_FDCWD, path.c_str(), times, 0), 0) << path;
}

std::int64_t usedAt(const fs::path& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mtim.tv_sec;
}

TEST_F(DiskStoreTest, IsAMapOfWhatWasPutIntoIt) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    options_.folder = folder_ / std::to_string(seed);
    options_.packBytes = seed % 3 == 0 ? 4000 : 1 << 20;
    std::mt19937_64 random(seed);
    std::map<AssetId, std::pair<AssetKind, std::string>> published, pending;
    std::map<std::string, std::string> entries;
    auto store = open();
    for (int step = 0; step < 300; ++step) {
      switch (random() % 10) {
        case 0: {
          ASSERT_TRUE(store->publish().ok());
          published.merge(pending);
          pending.clear();
          break;
        }
        case 1: {
          // What was not published may be gone after that, or not where a pack had become full.
          store.reset();
          store = open();
          for (const auto& [id, asset] : pending) {
            if (store->find(id)) published.insert({id, asset});
          }
          pending.clear();
          break;
        }
        case 2: {
          const std::string name = "entry-" + std::to_string(random() % 4);
          entries[name] = someBytes(random(), random() % 10000);
          ASSERT_TRUE(store->putEntry(name, bytesOf(entries[name])).ok());
          break;
        }
        default: {
          const auto kind = static_cast<AssetKind>(random() % 3);
          const std::string bytes = someBytes(random() % 64, random() % 3 == 0 ? 0 : 10 + random() % 2000);
          const AssetId id = put(*store, bytes, kind);
          if (!published.contains(id)) pending.try_emplace(id, kind, bytes);
        }
      }
      auto all = published;
      all.insert(pending.begin(), pending.end());
      const auto contents = store->contents();
      ASSERT_EQ(contents.size(), all.size());
      auto expected = all.begin();
      for (const auto& content : contents) {
        EXPECT_EQ(content.id, expected->first);
        EXPECT_EQ(content.kind, expected->second.first);
        EXPECT_EQ(content.bytes, expected->second.second.size());
        ++expected;
      }
      if (!all.empty()) {
        auto one = std::next(all.begin(), static_cast<std::ptrdiff_t>(random() % all.size()));
        ASSERT_EQ(get(*store, one->first), one->second.second);
      }
      const std::string name = "entry-" + std::to_string(random() % 4);
      auto entry = store->mapEntry(name);
      ASSERT_TRUE(entry.ok());
      ASSERT_EQ(entry->has_value(), entries.contains(name));
      if (*entry) {
        const auto bytes = (*entry)->bytes();
        EXPECT_EQ(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()), entries[name]);
      }
      EXPECT_FALSE(store->find(assetIdOf(bytesOf("never put"))));
    }
  }
}

TEST_F(DiskStoreTest, WritesAnAssetOnce) {
  auto store = open();
  const std::string bytes = someBytes(2, 1000);
  const AssetId id = put(*store, bytes);
  const auto first = store->find(id);
  put(*store, bytes);
  EXPECT_EQ(store->find(id), first);
  ASSERT_TRUE(store->publish().ok());
  put(*store, bytes);
  ASSERT_TRUE(store->publish().ok());
  EXPECT_EQ(filesIn(folder().packs()).size(), 1u);
  EXPECT_TRUE(filesIn(folder().unpublished()).empty());
  EXPECT_EQ(store->find(id), first);
}

TEST_F(DiskStoreTest, CompressesWhereThatPays) {
  auto store = open();
  const auto random = store->find(put(*store, someBytes(2, 5000)));
  const auto regular = store->find(put(*store, someBytes(3, 5000)));
  EXPECT_EQ(random->storedBytes, 5000u);
  EXPECT_LT(regular->storedBytes, 1000u);
  EXPECT_EQ(regular->bytes, 5000u);
}

TEST_F(DiskStoreTest, RefusesAnAssetThatNoTileCouldGet) {
  auto store = open();
  // Never touched, so it costs no memory.
  const std::unique_ptr<std::byte[]> large(new std::byte[kMaxAssetBytes + 1]);
  const auto place = store->add(AssetId{}, AssetKind::Image, {large.get(), kMaxAssetBytes + 1});
  ASSERT_FALSE(place.ok());
  EXPECT_NE(place.error().text().find("more than"), std::string::npos);
}

TEST_F(DiskStoreTest, SeesWhatOthersPublishLater) {
  auto reader = open();
  auto writer = open();
  for (std::uint64_t i = 0; i < 20; ++i) {
    const std::string bytes = someBytes(i, 100 + i);
    const AssetId id = assetIdOf(bytesOf(bytes));
    EXPECT_FALSE(reader->find(id));
    put(*writer, bytes);
    EXPECT_FALSE(reader->find(id)) << "not published yet";
    EXPECT_EQ(get(*writer, id), bytes) << "its writer may read it at once";
    ASSERT_TRUE(writer->publish().ok());
    EXPECT_EQ(get(*reader, id), bytes);
  }
}

TEST_F(DiskStoreTest, SeesWhatIsPublishedInTheSameTickOfTheClock) {
  auto reader = open(), writer = open();
  const std::string bytes = someBytes(2, 100);
  const AssetId id = assetIdOf(bytesOf(bytes));
  put(*writer, bytes);
  const timespec now[2] = {{0, UTIME_OMIT}, {0, UTIME_NOW}};
  ASSERT_EQ(::utimensat(AT_FDCWD, folder().packs().c_str(), now, 0), 0);
  struct stat before {};
  ASSERT_EQ(::stat(folder().packs().c_str(), &before), 0);
  EXPECT_FALSE(reader->find(id));
  ASSERT_TRUE(writer->publish().ok());
  const timespec same[2] = {{0, UTIME_OMIT}, before.st_mtim};
  ASSERT_EQ(::utimensat(AT_FDCWD, folder().packs().c_str(), same, 0), 0);
  EXPECT_EQ(get(*reader, id), bytes);
}

TEST_F(DiskStoreTest, ServesManyThreads) {
  options_.packBytes = 10000;
  auto store = open();
  std::atomic<int> wrong{0};
  std::vector<std::thread> threads;
  for (std::uint64_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937_64 random(t);
      for (int step = 0; step < 300; ++step) {
        const std::string bytes = someBytes(random() % 50, 500);
        const AssetId id = assetIdOf(bytesOf(bytes));
        if (!store->add(id, AssetKind::State, bytesOf(bytes))) ++wrong;
        if (random() % 100 == 0 && !store->publish()) ++wrong;
        if (random() % 100 == 0) store->evict();
        const auto place = store->find(id);
        if (!place) {
          ++wrong;
          continue;
        }
        // Published by another thread in between, an asset is in the pack that it was in, under the same
        // name.
        const auto got = store->read(id, *place);
        if (!got || *got != bytes) ++wrong;
      }
    });
  }
  for (auto& thread : threads)
    thread.join();
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(store->contents().size(), 50u);
}

TEST_F(DiskStoreTest, ReadsByAPlaceWithoutACatalogue) {
  const std::string bytes = someBytes(5, 3000);
  const AssetId id = assetIdOf(bytesOf(bytes));
  StoredAsset place;
  {
    auto store = open();
    place = *store->find(put(*store, bytes));
    ASSERT_TRUE(store->publish().ok());
  }
  auto store = open();
  EXPECT_EQ(*store->read(id, place), bytes);
  // A place is not trusted.
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    StoredAsset wrong = place;
    switch (random() % 4) {
      case 0:
        wrong.offset = random() % 2 == 0 ? random() : random() % 5000;
        break;
      case 1:
        wrong.storedBytes = static_cast<std::uint32_t>(random());
        break;
      case 2:
        wrong.bytes = static_cast<std::uint32_t>(random());
        break;
      default:
        wrong.kind = static_cast<AssetKind>(random() % 256);
    }
    if (wrong == place) continue;
    ReadProblem problem{};
    ASSERT_FALSE(store->read(id, wrong, &problem).ok());
    ASSERT_EQ(problem, ReadProblem::Damaged);
  }
  ReadProblem problem{};
  StoredAsset gone = place;
  gone.pack = PackId::random();
  ASSERT_FALSE(store->read(id, gone, &problem).ok());
  EXPECT_EQ(problem, ReadProblem::Missing);
  EXPECT_EQ(*store->read(id, place), bytes);
  // The pack is whole, and mending leaves it where it is.
  const auto dropped = store->dropDamaged();
  ASSERT_TRUE(dropped.ok());
  EXPECT_EQ(*dropped, 0u);
  EXPECT_EQ(*store->read(id, place), bytes);
}

TEST_F(DiskStoreTest, EntriesAreCopiesOnWrite) {
  auto store = open();
  const std::string bytes = someBytes(2, 100000);
  ASSERT_TRUE(store->putEntry("index", bytesOf(bytes)).ok());
  auto first = *store->mapEntry("index");
  ASSERT_TRUE(first);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(first->bytes().data()) % 64, 0u);
  for (std::byte& b : first->bytes())
    b = std::byte{7};
  auto second = *store->mapEntry("index");
  EXPECT_EQ(std::memcmp(second->bytes().data(), bytes.data(), bytes.size()), 0);
  *second = std::move(*first);
  EXPECT_EQ(second->bytes()[17], std::byte{7});
  ASSERT_TRUE(store->putEntry("empty", {}).ok());
  EXPECT_TRUE((*store->mapEntry("empty"))->bytes().empty());
  for (const char* name : {"", ".", "..", "../x", "a/b", ".x", "a b", "\n"}) {
    EXPECT_FALSE(store->putEntry(name, {}).ok()) << name;
    EXPECT_FALSE(store->mapEntry(name)->has_value()) << name;
  }
  EXPECT_FALSE(store->putEntry(std::string(129, 'a'), {}).ok());
  EXPECT_TRUE(store->putEntry(std::string(128, 'a'), {}).ok());
  EXPECT_TRUE(store->mapEntry(std::string(128, 'a'))->has_value());
}

TEST_F(DiskStoreTest, EvictsTheLeastRecentlyUsedFirst) {
  auto store = open();
  std::vector<std::pair<fs::path, AssetId>> packs;
  for (std::uint64_t i = 0; i < 10; ++i) {
    const AssetId id = put(*store, someBytes(2 * i, 10000));
    const fs::path path = folder().pack(store->find(id)->pack);
    ASSERT_TRUE(store->publish().ok());
    packs.emplace_back(path, id);
  }
  ASSERT_TRUE(store->putEntry("old", bytesOf(someBytes(2, 10000))).ok());
  ASSERT_TRUE(store->putEntry("new", bytesOf(someBytes(2, 10000))).ok());
  std::mt19937 random(3);
  std::shuffle(packs.begin(), packs.end(), random);
  for (std::size_t i = 0; i < packs.size(); ++i)
    setUsed(packs[i].first, 1000 + static_cast<int>(i));
  setUsed(folder().entries() / "old", 500);
  setUsed(folder().entries() / "new", 5000);
  // A file that is not of the store neither counts nor goes.
  overwrite(folder().packs() / "notes.txt", std::string(200000, 'x'));
  setUsed(folder().packs() / "notes.txt", 1);

  auto untouched = store->evict();
  EXPECT_EQ(untouched.removed, 0u);
  EXPECT_LT(untouched.bytesBefore, 130000u);
  options_.budgetBytes = 65000;
  auto evictor = open();
  const auto result = evictor->evict();
  EXPECT_EQ(result.removed, 6u);  // the old entry and five packs; each is a little over 10,000 bytes
  EXPECT_LE(result.bytesAfter, 65000u);
  EXPECT_FALSE(fs::exists(folder().entries() / "old"));
  EXPECT_TRUE(fs::exists(folder().entries() / "new"));
  EXPECT_TRUE(fs::exists(folder().packs() / "notes.txt"));
  for (std::size_t i = 0; i < packs.size(); ++i) {
    EXPECT_EQ(fs::exists(packs[i].first), i >= 5) << i;
    EXPECT_EQ(get(*evictor, packs[i].second).has_value(), i >= 5) << i;
    EXPECT_EQ(open()->find(packs[i].second).has_value(), i >= 5) << i;
  }
  EXPECT_EQ(evictor->contents().size(), 5u);
}

TEST_F(DiskStoreTest, NeverEvictsWhatALivingProcessUses) {
  auto store = open();
  const AssetId used = put(*store, someBytes(2, 10000));
  ASSERT_TRUE(store->publish().ok());
  const AssetId idle = put(*store, someBytes(4, 10000));
  ASSERT_TRUE(store->publish().ok());
  ASSERT_TRUE(store->putEntry("used", bytesOf("abc")).ok());
  auto entry = *store->mapEntry("used");
  ASSERT_TRUE(store->uses(store->find(used)->pack).ok());
  ASSERT_TRUE(store->uses(store->find(used)->pack).ok()) << "twice is no harm";
  options_.budgetBytes = 0;
  EXPECT_EQ(inChild([&] { return open()->evict().inUse == 2 ? 0 : 1; }), 0);
  EXPECT_TRUE(get(*open(), used));
  EXPECT_FALSE(get(*open(), idle));
  EXPECT_TRUE(fs::exists(folder().entries() / "used"));
  // Not even by the store that uses it.
  EXPECT_EQ(open()->evict().removed, 0u);
  entry.reset();
  store.reset();
  EXPECT_EQ(open()->evict().removed, 2u);
  EXPECT_FALSE(open()->uses(PackId::random()).ok());
}

TEST_F(DiskStoreTest, UsingAndReadingIsRemembered) {
  auto store = open();
  const AssetId id = put(*store, someBytes(2, 100));
  const StoredAsset place = *store->find(id);
  ASSERT_TRUE(store->publish().ok());
  ASSERT_TRUE(store->putEntry("e", bytesOf("abc")).ok());
  const fs::path path = folder().pack(place.pack);
  setUsed(path, 1000);
  ASSERT_TRUE(store->uses(place.pack).ok());
  EXPECT_GT(usedAt(path), 1000);
  setUsed(path, 1000);
  setUsed(folder().entries() / "e", 1000);
  auto other = open();
  ASSERT_TRUE(get(*other, id));
  EXPECT_GT(usedAt(path), 1000);
  ASSERT_TRUE(*other->mapEntry("e"));
  EXPECT_GT(usedAt(folder().entries() / "e"), 1000);

  setUsed(path, 1000);
  setUsed(folder().entries() / "e", 1000);
  options_.mayWrite = false;
  auto reader = open();
  ASSERT_TRUE(get(*reader, id));
  ASSERT_TRUE(*reader->mapEntry("e"));
  ASSERT_TRUE(reader->uses(place.pack).ok());
  EXPECT_EQ(usedAt(path), 1000);
  EXPECT_EQ(usedAt(folder().entries() / "e"), 1000);
  EXPECT_FALSE(reader->add(AssetId{}, AssetKind::State, {}).ok());
  EXPECT_FALSE(reader->putEntry("f", {}).ok());
  options_.budgetBytes = 0;
  EXPECT_EQ(open()->evict().removed, 0u);
}

TEST_F(DiskStoreTest, AddingWhatIsThereUsesItAndWritesAnewWhatWasEvicted) {
  auto store = open();
  const std::string bytes = someBytes(2, 1000);
  const AssetId id = put(*store, bytes);
  const fs::path path = folder().pack(store->find(id)->pack);
  ASSERT_TRUE(store->publish().ok());
  setUsed(path, 1000);
  auto other = open();
  put(*other, bytes);
  EXPECT_GT(usedAt(path), 1000);
  EXPECT_EQ(filesIn(folder().packs()).size(), 1u);
  ASSERT_TRUE(fs::remove(path));
  put(*other, bytes);
  ASSERT_TRUE(other->publish().ok());
  EXPECT_EQ(get(*other, id), bytes);
  EXPECT_EQ(get(*open(), id), bytes);
}

TEST_F(DiskStoreTest, AnotherVersionsPacksAreLeftAlone) {
  auto store = open();
  const AssetId id = put(*store, someBytes(2, 100));
  ASSERT_TRUE(store->publish().ok());
  const fs::path path = filesIn(folder().packs()).front();
  std::string pack = contentOf(path);
  pack[offsetof(PackHeader, version)] = 2;
  pack[pack.size() - sizeof(PackTrailer) + offsetof(PackTrailer, version)] = 2;
  overwrite(path, pack);
  store = open();
  EXPECT_FALSE(store->find(id));
  EXPECT_EQ(*store->dropDamaged(), 0u);
  EXPECT_TRUE(fs::exists(path));
  put(*store, someBytes(2, 100));
  ASSERT_TRUE(store->publish().ok());
  EXPECT_TRUE(get(*open(), id));
}

TEST_F(DiskStoreTest, ForeignFilesDoNoHarm) {
  auto store = open();
  const AssetId id = put(*store, someBytes(2, 100));
  ASSERT_TRUE(store->publish().ok());
  fs::create_directory(folder().packs() / (PackId::random().hex() + ".pack"));
  fs::create_symlink("/etc/passwd", folder().packs() / (PackId::random().hex() + ".pack"));
  ASSERT_EQ(::mkfifo((folder().packs() / (PackId::random().hex() + ".pack")).c_str(), 0600), 0);
  ASSERT_EQ(::mkfifo((folder().entries() / "fifo").c_str(), 0600), 0);
  fs::create_directory(folder().entries() / "folder");
  fs::create_symlink("/etc/passwd", folder().entries() / "link");
  overwrite(folder().packs() / "x.pack", "not a pack");
  overwrite(folder().packs() / (PackId::random().hex() + ".pack"), "");
  overwrite(folder().entries() / "text", "not an entry");
  overwrite(folder().unpublished() / "keep.txt", "not ours");
  store = open();
  EXPECT_EQ(get(*store, id), someBytes(2, 100));
  EXPECT_FALSE(*store->mapEntry("text"));
  EXPECT_FALSE(fs::exists(folder().entries() / "text"));
  EXPECT_FALSE(*store->mapEntry("link"));
  for (const char* name : {"fifo", "folder"}) {
    const auto entry = store->mapEntry(name);
    EXPECT_TRUE(!entry.ok() || !entry->has_value()) << name;
  }
  EXPECT_TRUE(store->dropDamaged().ok());
  store->evict();
  EXPECT_TRUE(fs::exists(folder().unpublished() / "keep.txt"));
  EXPECT_TRUE(fs::exists(folder().packs() / "x.pack"));
  EXPECT_TRUE(fs::exists("/etc/passwd"));
  EXPECT_EQ(get(*open(), id), someBytes(2, 100));
}

TEST_F(DiskStoreTest, SaysWhyItCannotBeOpened) {
  const auto why = [&](const fs::path& path, bool mayWrite = true) {
    DiskStore::Options options;
    options.folder = path;
    options.mayWrite = mayWrite;
    const auto store = DiskStore::open(options);
    return store ? std::string("opened") : store.error().text();
  };
  const auto contains = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos ? std::string() : text;
  };
  overwrite(folder_ / "file", "x");
  EXPECT_EQ(contains(why(folder_ / "file"), "is not a folder"), "");
  EXPECT_EQ(contains(why(folder_ / "file/below"), "Not a directory"), "");
  EXPECT_EQ(contains(why(folder_ / "absent", false), "No such file"), "");
  EXPECT_EQ(contains(why(""), "needs a folder"), "");
  fs::create_directory(folder_ / "open");
  fs::permissions(folder_ / "open", fs::perms::all);
  EXPECT_EQ(contains(why(folder_ / "open"), "everybody may write"), "");
  EXPECT_EQ(why(folder_ / "made/with/parents"), "opened");
  EXPECT_EQ(fs::status(folder_ / "made").permissions(), fs::perms::owner_all);

  fs::create_directory(folder_ / "read-only");
  const auto refused = [&](const fs::path& path) {
    return inChild([&] {
      // Rights do not hold the super-user back.
      if (::getuid() == 0 && ::setuid(65534) != 0) return 77;
      return contains(why(path), "use a folder that this user may write").empty() ? 0 : 1;
    });
  };
  fs::permissions(folder_.path(), fs::perms::owner_all | fs::perms::group_all | fs::perms::others_read |
                                      fs::perms::others_exec);
  fs::permissions(folder_ / "read-only", fs::perms::owner_read | fs::perms::owner_exec |
                                             fs::perms::others_read | fs::perms::others_exec);
  EXPECT_EQ(refused(folder_ / "read-only"), 0);
  EXPECT_EQ(refused(folder_ / "read-only/below"), 0);
}

TEST(DefaultCacheFolder, FollowsTheConvention) {
  EXPECT_EQ(inChild([] {
              ::setenv("XDG_CACHE_HOME", "/a/b", 1);
              if (*defaultCacheFolder("tile") != "/a/b/tessera/tile") return 1;
              ::setenv("XDG_CACHE_HOME", "relative", 1);
              ::setenv("HOME", "/home/x", 1);
              if (*defaultCacheFolder("tile") != "/home/x/.cache/tessera/tile") return 2;
              ::unsetenv("XDG_CACHE_HOME");
              if (*defaultCacheFolder("tile") != "/home/x/.cache/tessera/tile") return 3;
              ::unsetenv("HOME");
              return defaultCacheFolder("tile").ok() ? 0 : 4;
            }),
            0);
}

}  // namespace
}  // namespace tessera::test
