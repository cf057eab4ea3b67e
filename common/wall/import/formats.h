#pragma once

#include <string>
#include <string_view>

#include "common/base/result.h"
#include "common/wall/import/wall_import.h"
#include "common/wall/json_document.h"

namespace pugi {
class xml_document;
}

// One importer for each format; wall_import.cpp chooses among them. All take the file's name for messages.

namespace tessera {

[[nodiscard]] Result<ImportedWall> importEqualizer(std::string_view text, const std::string& fileName);
[[nodiscard]] Result<ImportedWall> importTide(const JsonDocument& document, const std::string& fileName);
[[nodiscard]] Result<ImportedWall> importSgct(const JsonDocument& document, const std::string& fileName);
/// Also Tide's older XML, which grew out of it. `text` is what `document` was parsed from, for line numbers.
[[nodiscard]] Result<ImportedWall> importDisplayCluster(const pugi::xml_document& document,
                                                        std::string_view text, const std::string& fileName);

/// The name of a wall out of its file's: without folder and extension.
[[nodiscard]] std::string wallNameOf(const std::string& fileName);

}  // namespace tessera
