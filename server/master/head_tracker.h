#pragma once

#include <memory>
#include <optional>

#include "common/base/result.h"
#include "common/geometry/vec.h"

namespace tessera {

/// Hears where a tracked observer's head is, over OSC (Open Sound Control) on a UDP port: messages
/// /tessera/head with three floats or doubles, metres in the room. What is not finite or farther than a
/// kilometre is ignored. A thread of its own listens.
class HeadTracker {
 public:
  /// Port 0: any; see port().
  [[nodiscard]] static Result<std::unique_ptr<HeadTracker>> listen(int port);
  virtual ~HeadTracker() = default;

  /// The last place heard of; nothing before the first.
  [[nodiscard]] virtual std::optional<Vec3> headM() const = 0;
  [[nodiscard]] virtual int port() const = 0;
};

}  // namespace tessera
