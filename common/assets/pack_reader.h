#pragma once

#include <string>

#include "common/assets/asset_id.h"
#include "common/assets/stored_asset.h"
#include "common/base/result.h"

namespace tessera {

/// Reads one asset from an open pack with all that it says checked: sizes before memory is taken, the record
/// against the place, the bytes against the id. `name` is the file's, for errors. May be called by many
/// threads on one descriptor. `problem` is set on an error.
[[nodiscard]] Result<std::string> readRecord(int fd, const std::string& name, const AssetId& id,
                                             const StoredAsset& place, ReadProblem& problem);

}  // namespace tessera
