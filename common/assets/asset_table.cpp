#include "common/assets/asset_table.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tessera {

AssetTable::AssetTable() : keeper_(std::make_shared<MemoryAssets>()) {}

AssetTable::AssetTable(std::shared_ptr<AssetKeeper> keeper) : keeper_(std::move(keeper)) {}

AssetTable::AssetTable(Column<AssetRow> rows, Column<std::uint32_t> needs,
                       std::shared_ptr<AssetKeeper> keeper)
    : rows_(std::move(rows)), needs_(std::move(needs)), keeper_(std::move(keeper)) {}

Result<std::uint32_t> AssetTable::add(AssetKind kind, std::string bytes,
                                      std::span<const std::uint32_t> needs) {
  AssetRow row;
  row.id = assetIdOf(std::as_bytes(std::span(bytes)));
  row.bytes = static_cast<std::uint32_t>(bytes.size());
  row.kind = kind;
  row.needsBegin = static_cast<std::uint32_t>(needs_.size());
  row.needsCount = static_cast<std::uint32_t>(needs.size());
  const auto number = static_cast<std::uint32_t>(rows_.size());
  const auto [known, isNew] = numbers_.try_emplace(row.id, number);
  if (!isNew) return known->second;
  if (Status status = keeper_->put(row, std::move(bytes)); !status) return status.error();
  rows_.push_back(row);
  needs_.append(needs.begin(), needs.end());
  return number;
}

std::uint64_t AssetTable::bytes() const {
  std::uint64_t sum = 0;
  for (const AssetRow& row : rows_)
    sum += row.bytes;
  return sum;
}

Result<AssetBytes> AssetTable::read(std::uint32_t number) const {
  if (number >= rows_.size())
    return runtimeError("asset " + std::to_string(number), "is not among the scene's assets");
  return keeper_->read(number, rows_[number]);
}

std::optional<std::uint32_t> AssetTable::numberOf(const AssetId& id) const {
  const std::lock_guard lock(byId_->mutex);
  std::vector<std::uint32_t>& numbers = byId_->numbers;
  if (numbers.size() != rows_.size()) {
    numbers.resize(rows_.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    std::sort(numbers.begin(), numbers.end(),
              [this](std::uint32_t a, std::uint32_t b) { return rows_[a].id < rows_[b].id; });
  }
  const auto found = std::lower_bound(numbers.begin(), numbers.end(), id,
                                      [this](std::uint32_t a, const AssetId& b) { return rows_[a].id < b; });
  if (found == numbers.end() || rows_[*found].id != id) return {};
  return *found;
}

Status MemoryAssets::put(const AssetRow&, std::string bytes) {
  bytes_.push_back(std::make_shared<const std::string>(std::move(bytes)));
  return Done{};
}

Result<AssetBytes> MemoryAssets::read(std::uint32_t number, const AssetRow&) const {
  return bytes_[number];
}

}  // namespace tessera
