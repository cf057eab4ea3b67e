#include "common/assets/store_assets.h"

#include "tests/common/assets/store_fixture.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;

class StoreAssetsTest : public StoreTest {
 protected:
  static constexpr std::uint32_t kCount = 8;

  static std::string bytesOfAsset(std::uint32_t number) { return someBytes(2 * number, 300 + number); }
  static AssetRow row(std::uint32_t number) {
    AssetRow row;
    row.id = assetIdOf(bytesOf(bytesOfAsset(number)));
    return row;
  }
  /// What an import does; all assets come into one pack where none is there yet.
  [[nodiscard]] std::vector<StoredAsset> import() const {
    const std::shared_ptr<DiskStore> store = open();
    StoreAssets assets(store);
    for (std::uint32_t i = 0; i < kCount; ++i)
      EXPECT_TRUE(assets.put(row(i), bytesOfAsset(i)).ok());
    EXPECT_TRUE(store->publish().ok());
    return {assets.places().begin(), assets.places().end()};
  }
  static std::size_t readable(const StoreAssets& assets) {
    std::size_t count = 0;
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const auto bytes = assets.read(i, row(i));
      if (!bytes) continue;
      EXPECT_EQ(**bytes, bytesOfAsset(i));
      ++count;
    }
    return count;
  }
  [[nodiscard]] Result<std::shared_ptr<StoreAssets>> reopen(const std::vector<StoredAsset>& places) const {
    Column<StoredAsset> column;
    for (const StoredAsset& place : places)
      column.push_back(place);
    return StoreAssets::open(open(), std::move(column));
  }
};

TEST_F(StoreAssetsTest, ADamagedAssetIsMadeAnewByTheNextImport) {
  const std::vector<StoredAsset> places = import();
  auto assets = reopen(places);
  ASSERT_TRUE(assets.ok());
  const fs::path pack = folder().pack(places[3].pack);
  std::string bad = contentOf(pack);
  bad[places[3].offset + 100] ^= 1;
  overwrite(pack, bad);

  EXPECT_FALSE((*assets)->read(3, row(3)).ok());
  EXPECT_EQ(readable(**assets), kCount - 1) << "the others go on";
  EXPECT_FALSE(reopen(places).ok()) << "the loss is seen at the next opening";
  const auto again = reopen(import());
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(readable(**again), kCount);
  EXPECT_EQ(readable(**assets), kCount) << "who read all the time finds it too";
}

TEST_F(StoreAssetsTest, AnotherCopyIsAsGood) {
  const std::vector<StoredAsset> places = import();
  ASSERT_TRUE(reopen(places).ok());
  const fs::path first = folder().pack(places[0].pack);
  const std::string good = contentOf(first);
  fs::remove(first);
  static_cast<void>(import());
  std::string bad = good;
  bad[places[3].offset + 100] ^= 1;
  overwrite(first, bad);
  const auto assets = reopen(places);
  ASSERT_TRUE(assets.ok());
  EXPECT_EQ(readable(**assets), kCount);
}

}  // namespace
}  // namespace tessera::test
