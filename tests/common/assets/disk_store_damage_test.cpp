// Damaged packs and entries: never a crash, never wrong bytes, and what is good stays.

#include <map>

#include "common/assets/disk_store.h"
#include "common/base/log.h"
#include "tests/common/assets/store_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

class DamageTest : public StoreTest {
 protected:
  DamageTest() {
    level_ = spdlog::get_level();
    spdlog::set_level(spdlog::level::off);  // Each damage is told, and there are thousands.
  }
  ~DamageTest() override { spdlog::set_level(level_); }

  /// A small pack, both stored raw and compressed. `others` is in a pack of its own.
  void fill() {
    auto store = open();
    other_ = put(*store, someBytes(100, 50));
    otherPack_ = folder().pack(store->find(other_)->pack);
    ASSERT_TRUE(store->publish().ok());
    StoredAsset place;
    for (std::uint64_t i = 0; i < 6; ++i) {
      const std::string bytes = someBytes(i, 20 + 40 * i);
      const AssetId id = put(*store, bytes, static_cast<AssetKind>(i % 3));
      place = *store->find(id);
      assets_[id] = {bytes, place.offset, place};
    }
    ASSERT_TRUE(store->publish().ok());
    pack_ = folder().pack(place.pack);
    good_ = contentOf(pack_);
  }

  /// How many of the assets a store can read; nothing but right bytes may come.
  std::size_t readable(const DiskStore& store) {
    std::size_t count = 0;
    for (const auto& [id, asset] : assets_) {
      const auto bytes = get(store, id);
      if (!bytes) continue;
      EXPECT_EQ(*bytes, asset.bytes);
      EXPECT_EQ(store.find(id)->kind, asset.place.kind);
      ++count;
    }
    EXPECT_EQ(get(store, other_), someBytes(100, 50)) << "another pack suffered";
    return count;
  }

  struct Asset {
    std::string bytes;
    std::uint64_t offset;
    StoredAsset place;
  };
  std::map<AssetId, Asset> assets_;
  AssetId other_;
  fs::path pack_, otherPack_;
  std::string good_;
  spdlog::level::level_enum level_;
};

TEST_F(DamageTest, EveryTruncationOfAPackLeavesWhatStandsBeforeIt) {
  fill();
  for (std::size_t length = 0; length < good_.size(); ++length) {
    SCOPED_TRACE(length);
    overwrite(pack_, good_.substr(0, length));
    std::size_t whole = 0;
    for (const auto& [id, asset] : assets_)
      whole += asset.offset + 56 + asset.place.storedBytes <= length;
    ASSERT_EQ(readable(*open()), whole);
    // By their places too, without a catalogue.
    auto store = open();
    for (const auto& [id, asset] : assets_) {
      ReadProblem problem = ReadProblem::Missing;
      const auto bytes = store->read(id, asset.place, &problem);
      if (bytes) {
        ASSERT_EQ(*bytes, asset.bytes);
      } else {
        ASSERT_EQ(problem, ReadProblem::Damaged);
      }
    }
  }
}

TEST_F(DamageTest, EveryFlippedBitOfAPackCostsOneAssetAtMost) {
  fill();
  for (std::size_t at = 0; at < good_.size(); ++at) {
    SCOPED_TRACE(at);
    std::string bad = good_;
    bad[at] = static_cast<char>(bad[at] ^ (1 << (at % 8)));
    overwrite(pack_, bad);
    auto store = open();
    ASSERT_GE(readable(*store) + 1, assets_.size());
  }
}

TEST_F(DamageTest, MendingKeepsWhatIsGoodAndMakesRoomForTheRest) {
  fill();
  std::mt19937 random(5);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE(round);
    for (const auto& path : filesIn(folder().packs())) {
      if (path != otherPack_) fs::remove(path);
    }
    std::string bad = good_;
    if (round % 2 == 0) bad.resize(random() % bad.size());
    for (int i = 0; i < 3 && !bad.empty(); ++i)
      bad[random() % bad.size()] ^= 0x10;
    overwrite(pack_, bad);
    std::size_t before, after;
    {
      auto store = open();
      before = readable(*store);
      const auto dropped = store->dropDamaged();
      ASSERT_TRUE(dropped.ok()) << dropped.error().text();
      ASSERT_EQ(readable(*store), before);
      for (const auto& [id, asset] : assets_)
        put(*store, asset.bytes, asset.place.kind);
      ASSERT_TRUE(store->publish().ok());
      ASSERT_EQ(readable(*store), assets_.size());
    }
    auto store = open();
    after = readable(*store);
    ASSERT_EQ(after, assets_.size());
    ASSERT_EQ(*store->dropDamaged(), 0u) << "nothing is damaged any more";
  }
}

TEST_F(DamageTest, ACopyInAnotherPackStandsInForADamagedOne) {
  auto first = open(), second = open();
  const std::string bytes = someBytes(2, 500);
  const AssetId id = assetIdOf(bytesOf(bytes));
  ASSERT_FALSE(first->find(id) || second->find(id));
  put(*first, bytes);
  put(*second, bytes);
  ASSERT_TRUE(first->publish().ok() && second->publish().ok());
  const auto packs = filesIn(folder().packs());
  ASSERT_EQ(packs.size(), 2u);
  for (const fs::path& path : packs) {
    const std::string good = contentOf(path);
    std::string bad = good;
    bad[16 + 56 + 3] ^= 1;
    overwrite(path, bad);
    auto store = open();
    // The first attempt may meet the bad one, not the second.
    const auto once = get(*store, id);
    EXPECT_EQ(once.value_or(bytes), bytes);
    EXPECT_EQ(get(*store, id), bytes);
    overwrite(path, good);
  }
}

TEST_F(DamageTest, APackThatIsCutWhileInUseIsAnErrorAndNoMore) {
  fill();
  auto store = open();
  ASSERT_EQ(readable(*store), assets_.size());
  ASSERT_TRUE(store->uses(assets_.begin()->second.place.pack).ok());
  fs::resize_file(pack_, 100);
  for (const auto& [id, asset] : assets_) {
    if (asset.offset + 56 + asset.place.storedBytes <= 100) continue;
    ReadProblem problem{};
    EXPECT_FALSE(store->read(id, asset.place, &problem).ok());
    EXPECT_EQ(problem, ReadProblem::Damaged);
    EXPECT_FALSE(store->find(id));
  }
  EXPECT_EQ(*store->dropDamaged(), 1u);
  EXPECT_FALSE(fs::exists(pack_));
  EXPECT_EQ(get(*store, other_), someBytes(100, 50));
}

TEST_F(DamageTest, ADamagedPackIsReplacedUnderThoseWhoUseIt) {
  fill();
  auto user = open();
  readable(*user);
  ASSERT_TRUE(user->uses(assets_.begin()->second.place.pack).ok());
  fs::resize_file(pack_, 500);
  auto store = open();
  const std::size_t before = readable(*store);
  EXPECT_GT(before, 0u);
  EXPECT_EQ(*store->dropDamaged(), 1u);
  EXPECT_FALSE(fs::exists(pack_));
  EXPECT_EQ(readable(*store), before);
  std::size_t good = 0;
  for (const auto& [id, asset] : assets_)
    good += user->read(id, asset.place).ok();
  EXPECT_EQ(good, before);
  for (const auto& [id, asset] : assets_)
    put(*store, asset.bytes, asset.place.kind);
  ASSERT_TRUE(store->publish().ok());
  readable(*user);  // Meets what is lost, once.
  EXPECT_EQ(readable(*user), assets_.size());
}

TEST_F(DamageTest, EveryTruncatedOrFlippedEntryCountsAsNone) {
  auto store = open();
  const std::string bytes = someBytes(2, 300);
  ASSERT_TRUE(store->putEntry("index", bytesOf(bytes)).ok());
  ASSERT_TRUE(store->putEntry("other", bytesOf(bytes)).ok());
  const fs::path path = folder().entries() / "index";
  const std::string good = contentOf(path);
  const auto isNone = [&](const std::string& content) {
    overwrite(path, content);
    auto entry = store->mapEntry("index");
    return entry.ok() && !entry->has_value() && !fs::exists(path);
  };
  for (std::size_t length = 0; length < good.size(); ++length)
    ASSERT_TRUE(isNone(good.substr(0, length)));
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ (1 << (at % 8)));
    ASSERT_TRUE(isNone(bad)) << at;
  }
  EXPECT_TRUE(isNone(good + "x"));
  EXPECT_TRUE(isNone(contentOf(folder().entries() / "other"))) << "an entry under another's name";
  overwrite(path, good);
  EXPECT_TRUE(*store->mapEntry("index"));
  EXPECT_TRUE(*store->mapEntry("other"));
}

TEST_F(DamageTest, AnEntryThatIsCutWhileMappedKeepsItsBytes) {
  auto store = open();
  const std::string bytes = someBytes(2, 5'000'000);
  ASSERT_TRUE(store->putEntry("index", bytesOf(bytes)).ok());
  auto entry = *store->mapEntry("index");
  ASSERT_TRUE(entry);
  fs::resize_file(folder().entries() / "index", 0);
  EXPECT_EQ(std::memcmp(entry->bytes().data(), bytes.data(), bytes.size()), 0);
  EXPECT_TRUE(filesIn(folder().unpublished()).empty()) << "the copy has no name";
}

TEST_F(DamageTest, AReaderDoesNotMendWhatItMayNotWrite) {
  fill();
  overwrite(pack_, good_.substr(0, good_.size() / 2));
  { ASSERT_TRUE(open()->putEntry("index", bytesOf("abc")).ok()); }
  overwrite(folder().entries() / "index", "rubbish");
  options_.mayWrite = false;
  auto store = open();
  EXPECT_GT(readable(*store), 0u);
  EXPECT_EQ(*store->dropDamaged(), 0u);
  EXPECT_FALSE(*store->mapEntry("index"));
  EXPECT_TRUE(fs::exists(pack_));
  EXPECT_TRUE(fs::exists(folder().entries() / "index"));
}

}  // namespace
}  // namespace tessera::test
