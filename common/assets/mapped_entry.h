#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/assets/store_folder.h"

namespace tessera {

/// The bytes of a named entry, in memory of this process alone: writing to them changes no file, and nothing
/// done to the entry's file can change or shorten them. Begins at a memory page, so any type may lie there.
class MappedEntry {
 public:
  MappedEntry(MappedEntry&& other) noexcept;
  MappedEntry& operator=(MappedEntry&& other) noexcept;
  ~MappedEntry();

  [[nodiscard]] std::span<std::byte> bytes() const { return {static_cast<std::byte*>(base_), size_}; }

 private:
  friend struct EntryCopier;
  MappedEntry() = default;

  void* base_ = nullptr;
  std::size_t size_ = 0;
  FileHandle file_;  ///< locked, so that the entry is not evicted while it is in use
};

/// True for 1 to 128 letters, digits, '.', '_' and '-', the first not a '.'.
[[nodiscard]] bool isEntryName(const std::string& name);

/// What is written in front of an entry's bytes.
[[nodiscard]] std::vector<std::byte> makeEntryHeader(const std::string& name,
                                                     std::span<const std::byte> bytes);

enum class EntryProblem {
  Damaged,  ///< not what was written, or written by another version
  Failed,   ///< the machine refused
};

/// Copies an open, locked entry file into memory that nobody else can touch: an unlinked file mapped
/// privately, so that the machine may page it out, else plain memory. Verifies name, version and checksum on
/// the way, of the very bytes that are handed out. A mapping of the entry's own file would kill the process
/// (SIGBUS) should somebody shorten that file. `problem` is set on an error.
[[nodiscard]] Result<MappedEntry> copyEntry(const StoreFolder& folder, const std::string& name,
                                            FileHandle file, EntryProblem& problem);

}  // namespace tessera
