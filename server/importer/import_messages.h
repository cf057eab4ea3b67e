#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "common/base/result.h"
#include "server/importer/import_process.h"

namespace tessera {

// What the two processes of an import say to each other; see runImportWorker.

[[nodiscard]] std::string orderText(const ImportOrder& order);
/// None: it is no order.
[[nodiscard]] std::optional<ImportOrder> orderFrom(const std::string& text);

[[nodiscard]] nlohmann::json errorJson(const Error& error);
/// None: it is no error.
[[nodiscard]] std::optional<Error> errorFrom(const nlohmann::json& answer);

}  // namespace tessera
