#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/column.h"
#include "common/base/result.h"

namespace tessera {

/// Numbered sections of plain rows in one run of bytes: what a scene's index is made of. Each section starts
/// at a multiple of 64 bytes, so that rows can be used where they lie. Written and read by builds with the
/// same layout of rows alone; others see that they differ.
inline constexpr std::size_t kSectionAlignment = 64;

class SectionWriter {
 public:
  /// The rows must live until finish().
  template <class T>
  void add(std::uint32_t id, const Column<T>& rows) {
    add(id, sizeof(T), std::as_bytes(rows.rows()));
  }
  void add(std::uint32_t id, std::string_view text) { add(id, 1, std::as_bytes(std::span(text))); }
  [[nodiscard]] std::string finish() const;

 private:
  struct Section {
    std::uint32_t id = 0, rowBytes = 0;
    std::span<const std::byte> bytes;
  };
  void add(std::uint32_t id, std::size_t rowBytes, std::span<const std::byte> bytes) {
    sections_.push_back({id, static_cast<std::uint32_t>(rowBytes), bytes});
  }
  std::vector<Section> sections_;
};

/// Reads what a SectionWriter wrote. Checks where sections lie; their content is the writer's word (the store
/// checks the whole against its checksum).
class SectionReader {
 public:
  /// `bytes` start at a multiple of kSectionAlignment in memory and live as long as `keeper`.
  [[nodiscard]] static Result<SectionReader> open(std::span<std::byte> bytes,
                                                  std::shared_ptr<const void> keeper);
  /// Empty where there is no such section. An error where its rows are of another size.
  template <class T>
  [[nodiscard]] Result<Column<T>> column(std::uint32_t id) const {
    const auto bytes = find(id, sizeof(T));
    if (!bytes) return bytes.error();
    return Column<T>(std::span(reinterpret_cast<T*>(bytes->data()), bytes->size() / sizeof(T)), keeper_);
  }

 private:
  struct Section {
    std::uint32_t id = 0, rowBytes = 0;
    std::span<std::byte> bytes;
  };
  [[nodiscard]] Result<std::span<std::byte>> find(std::uint32_t id, std::size_t rowBytes) const;
  std::vector<Section> sections_;
  std::shared_ptr<const void> keeper_;
};

}  // namespace tessera
