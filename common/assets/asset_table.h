#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "common/assets/asset.h"
#include "common/base/column.h"
#include "common/base/result.h"

namespace tessera {

/// Where the bytes of numbered assets are kept.
class AssetKeeper {
 public:
  virtual ~AssetKeeper() = default;
  /// Takes the bytes of the next number.
  [[nodiscard]] virtual Status put(const AssetRow& row, std::string bytes) = 0;
  /// Thread-safe; `row` is the asset's. What comes back has the hash of `row.id`.
  [[nodiscard]] virtual Result<AssetBytes> read(std::uint32_t number, const AssetRow& row) const = 0;
};

/// The assets of a scene by number: equal ones once, each with the numbers of those without which it cannot
/// be used. The bytes are somebody else's (in memory, unless told otherwise). Filled by one thread; free to
/// read by many after that.
class AssetTable {
 public:
  AssetTable();
  explicit AssetTable(std::shared_ptr<AssetKeeper> keeper);
  AssetTable(Column<AssetRow> rows, Column<std::uint32_t> needs, std::shared_ptr<AssetKeeper> keeper);

  /// Adds the asset unless it is there already. Returns its number. An error is the keeper's.
  [[nodiscard]] Result<std::uint32_t> add(AssetKind kind, std::string bytes,
                                          std::span<const std::uint32_t> needs = {});

  /// The bytes are somebody else's from now on.
  void keepIn(std::shared_ptr<AssetKeeper> keeper) { keeper_ = std::move(keeper); }

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  /// Of all assets together.
  [[nodiscard]] std::uint64_t bytes() const;
  [[nodiscard]] const AssetRow& row(std::uint32_t number) const { return rows_[number]; }
  [[nodiscard]] std::span<const std::uint32_t> needsOf(std::uint32_t number) const {
    return needs_.rows().subspan(rows_[number].needsBegin, rows_[number].needsCount);
  }
  /// None: there is no such asset. Thread-safe; the first call sorts all.
  [[nodiscard]] std::optional<std::uint32_t> numberOf(const AssetId& id) const;
  /// Thread-safe. An error for a number that is none.
  [[nodiscard]] Result<AssetBytes> read(std::uint32_t number) const;

  [[nodiscard]] const Column<AssetRow>& rows() const { return rows_; }
  [[nodiscard]] const Column<std::uint32_t>& needs() const { return needs_; }

 private:
  Column<AssetRow> rows_;
  Column<std::uint32_t> needs_;
  std::shared_ptr<AssetKeeper> keeper_;
  std::unordered_map<AssetId, std::uint32_t, AssetIdHash> numbers_;  ///< while assets are added
  struct ById {
    std::mutex mutex;
    std::vector<std::uint32_t> numbers;
  };
  std::shared_ptr<ById> byId_ =
      std::make_shared<ById>();  ///< numbers in the order of their ids, once asked for
};

/// Keeps bytes in memory.
class MemoryAssets : public AssetKeeper {
 public:
  [[nodiscard]] Status put(const AssetRow& row, std::string bytes) override;
  [[nodiscard]] Result<AssetBytes> read(std::uint32_t number, const AssetRow& row) const override;

 private:
  std::vector<AssetBytes> bytes_;
};

}  // namespace tessera
