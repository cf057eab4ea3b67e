#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/base/result.h"
#include "common/net/connection.h"
#include "common/wall/wall.h"
#include "proto/messages.h"
#include "server/master/recorded.h"
#include "server/master/stream_options.h"

namespace tessera {

/// What the master counts of one tile over a run.
struct TileCounts {
  std::uint64_t framesShown = 0, framesMissed = 0, reconnects = 0;
  std::uint64_t peakResidentBytes = 0;  ///< as the tile said when it left; 0: it did not
  Recorded<std::uint32_t> drawUs;       ///< of each acknowledged frame
  std::uint64_t framesIncomplete = 0, missingLeaves = 0, missingPx = 0;  ///< proto::Ready, summed over frames
  std::uint64_t disksLacked = 0;  ///< assets that its disk did not have after all
};

/// When a tile presented a frame, on its own monotonic clock.
struct ShownTime {
  std::uint64_t frame = 0;
  std::int64_t ns = 0;
};

/// The tiles of a wall and who is bound to each: where the network thread tells what happened and the frame
/// loop waits for it. Thread-safe.
class TileRoster {
 public:
  explicit TileRoster(const Wall& wall);

  /// What is measured of each frame is kept of the last so many alone.
  void keepLast(std::size_t frames);

  /// One connection bound to one tile. Sessions are numbered from 1 and never reused.
  struct Binding {
    std::uint32_t tile = 0;
    std::uint64_t session = 0;
  };

  // The network thread's side. What comes from a session that is bound no more is ignored.
  enum class Refusal { UnknownTile, TileTaken, ShuttingDown };
  /// `welcome` is called before the frame loop can see the tile, so that what it queues comes first.
  [[nodiscard]] std::variant<Binding, Refusal> bind(const proto::Hello& hello,
                                                    std::shared_ptr<net::Connection> peer,
                                                    std::shared_ptr<const TileFacts> facts,
                                                    const std::function<void(const Binding&)>& welcome);
  /// False: the tile acknowledges a frame that it was not sent, or twice.
  [[nodiscard]] bool ready(const Binding& binding, const proto::Ready& ready);
  [[nodiscard]] bool shown(const Binding& binding, const proto::Shown& shown);
  /// Numbers of assets that the tile lacks after all.
  void lacks(const Binding& binding, std::span<const std::uint32_t> assets);
  /// Whether shown() would take this frame now.
  [[nodiscard]] bool mayShow(const Binding& binding, std::uint64_t frame);
  void leaving(const Binding& binding, const proto::Bye& bye);
  void gone(const Binding& binding);

  // The frame loop's side.

  /// Who is bound to a tile now; a null connection where nobody is.
  struct Peer {
    std::uint64_t session = 0;
    std::shared_ptr<net::Connection> connection;
    std::uint64_t acknowledged = 0;  ///< last frame that it said Ready to
    std::uint64_t sent = 0;          ///< last frame that is on its way or there
    std::shared_ptr<const TileFacts> facts = {};
    std::vector<std::uint32_t> lacked = {};  ///< told since the last startFrame()
  };
  [[nodiscard]] Peer peer(std::uint32_t tile) const;
  /// Whom the caller is to send a frame now, by tile: a null connection where nobody is or has not yet said
  /// Ready to the frame before, and misses this one. `peers` is refilled.
  void startFrame(std::uint64_t frame, std::vector<Peer>& peers);
  void frameMissed(std::uint32_t tile);

  using Deadline = std::chrono::steady_clock::time_point;
  /// Waits until every tile is bound. `whileWaiting` is called every 20 ms without the lock; an error from it
  /// ends the wait. False: the deadline or a stop came first.
  [[nodiscard]] Result<bool> waitAllBound(Deadline deadline, const std::function<Status()>& whileWaiting);
  /// Waits until no tile has `frame` under way. Returns the tiles that still have; they have missed it.
  [[nodiscard]] std::vector<std::uint32_t> waitReady(std::uint64_t frame, Deadline deadline);
  /// Waits until every bound tile has shown `frame` or is behind.
  void waitShown(std::uint64_t frame, Deadline deadline);
  /// Refuses new tiles and waits until all bound ones have left.
  void waitEmpty(Deadline deadline);

  /// Wakes the writers of all connections that have something queued; the network thread calls it.
  void flushAll();

  /// Ends all waits early but waitEmpty and waitShown.
  void stop();
  [[nodiscard]] bool stopping() const;

  /// Between the first and the last tile that showed `frame`, of those on this machine's clock.
  [[nodiscard]] std::uint32_t skewUs(std::uint64_t frame) const;
  [[nodiscard]] std::vector<std::string> unboundNames() const;
  [[nodiscard]] const std::string& nameOf(std::uint32_t tile) const { return names_[tile]; }
  [[nodiscard]] std::uint32_t tileCount() const { return static_cast<std::uint32_t>(names_.size()); }

  /// Frames that at least one tile could not draw whole.
  [[nodiscard]] std::uint64_t framesIncomplete() const;
  /// For the report, after the run.
  [[nodiscard]] TileCounts counts(std::uint32_t tile) const;
  /// Times shown by frame; only of tiles whose clock is this machine's, for others cannot be compared.
  [[nodiscard]] std::vector<ShownTime> shownTimes(std::uint32_t tile) const;

 private:
  struct Slot {
    std::uint64_t session = 0;
    std::shared_ptr<net::Connection> connection;
    std::shared_ptr<const TileFacts> facts;
    std::vector<std::uint32_t> lacked;
    std::uint64_t sent = 0, acknowledged = 0, lastShown = 0;
    std::int64_t lastShownNs = 0;
    bool sharesClock = false, wasBound = false;
    TileCounts counts;
    Recorded<ShownTime> shownTimes;
  };
  Slot* current(const Binding& binding);
  [[nodiscard]] bool isDrawing(const Slot& slot, std::uint64_t frame) const {
    return slot.connection && slot.sent == frame && slot.acknowledged < frame;
  }
  /// Of the newest frame one tile less is drawing. With the lock held.
  void oneLess();
  template <class Predicate>
  bool waitUntil(std::unique_lock<std::mutex>& lock, Deadline deadline, Predicate predicate);

  std::vector<std::string> names_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  // The frame loop waits for the last Ready of a frame; to be woken by each, or by what the tiles say of the
  // frame before, would cost it more than its own work.
  std::condition_variable noneDraws_;
  std::uint64_t newestFrame_ = 0;
  std::uint32_t drawing_ = 0;  ///< tiles for which isDrawing(newestFrame_)
  std::vector<Slot> slots_;
  std::uint64_t nextSession_ = 1;
  std::uint64_t framesIncomplete_ = 0, lastIncomplete_ = 0;
  bool stopping_ = false, closed_ = false;
};

}  // namespace tessera
