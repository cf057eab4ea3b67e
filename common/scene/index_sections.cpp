#include "common/scene/index_sections.h"

#include <cstring>

namespace tessera {

namespace {

constexpr char kMagic[8] = {'T', 'S', 'R', 'A', 'I', 'N', 'D', 'X'};
constexpr std::uint32_t kMaxSections = 64;

struct Header {
  char magic[8] = {};
  std::uint32_t sections = 0, alignment = 0;
};

struct Entry {
  std::uint32_t id = 0, rowBytes = 0;
  std::uint64_t offset = 0, bytes = 0;
};

std::size_t aligned(std::size_t offset) {
  return (offset + kSectionAlignment - 1) / kSectionAlignment * kSectionAlignment;
}

}  // namespace

std::string SectionWriter::finish() const {
  std::vector<Entry> entries;
  std::size_t end = sizeof(Header) + sections_.size() * sizeof(Entry);
  for (const Section& section : sections_) {
    entries.push_back({section.id, section.rowBytes, aligned(end), section.bytes.size()});
    end = aligned(end) + section.bytes.size();
  }
  std::string out(end, '\0');
  Header header;
  std::memcpy(header.magic, kMagic, sizeof kMagic);
  header.sections = static_cast<std::uint32_t>(sections_.size());
  header.alignment = kSectionAlignment;
  std::memcpy(out.data(), &header, sizeof header);
  std::memcpy(out.data() + sizeof header, entries.data(), entries.size() * sizeof(Entry));
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    if (!sections_[i].bytes.empty())
      std::memcpy(out.data() + entries[i].offset, sections_[i].bytes.data(), sections_[i].bytes.size());
  }
  return out;
}

Result<SectionReader> SectionReader::open(std::span<std::byte> bytes, std::shared_ptr<const void> keeper) {
  const auto wrong = [] { return runtimeError("scene index", "is not one that this program wrote"); };
  Header header;
  if (bytes.size() < sizeof header) return wrong();
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0 || header.sections > kMaxSections ||
      header.alignment != kSectionAlignment ||
      bytes.size() < sizeof header + header.sections * sizeof(Entry)) {
    return wrong();
  }
  SectionReader reader;
  reader.keeper_ = std::move(keeper);
  for (std::uint32_t i = 0; i < header.sections; ++i) {
    Entry entry;
    std::memcpy(&entry, bytes.data() + sizeof header + i * sizeof entry, sizeof entry);
    const bool fits = entry.offset <= bytes.size() && entry.bytes <= bytes.size() - entry.offset;
    if (!fits || entry.offset % kSectionAlignment != 0 || entry.rowBytes == 0 ||
        entry.bytes % entry.rowBytes != 0) {
      return wrong();
    }
    reader.sections_.push_back({entry.id, entry.rowBytes, bytes.subspan(entry.offset, entry.bytes)});
  }
  return reader;
}

Result<std::span<std::byte>> SectionReader::find(std::uint32_t id, std::size_t rowBytes) const {
  for (const Section& section : sections_) {
    if (section.id != id) continue;
    if (section.rowBytes != rowBytes)
      return runtimeError("scene index", "was written by a program with other rows");
    return section.bytes;
  }
  return std::span<std::byte>();
}

}  // namespace tessera
