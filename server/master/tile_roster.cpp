#include "server/master/tile_roster.h"

#include <algorithm>

#include "common/base/host.h"

namespace tessera {

namespace {
// A tile that says more at once loses nothing: it will say so again.
constexpr std::size_t kMostLacked = 1 << 16;
}  // namespace

TileRoster::TileRoster(const Wall& wall) : slots_(wall.tiles.size()) {
  for (const Tile& tile : wall.tiles)
    names_.push_back(tile.name);
}

void TileRoster::keepLast(std::size_t frames) {
  const std::lock_guard lock(mutex_);
  for (Slot& slot : slots_) {
    slot.counts.drawUs.keepLast(frames);
    slot.shownTimes.keepLast(frames);
  }
}

std::variant<TileRoster::Binding, TileRoster::Refusal> TileRoster::bind(
    const proto::Hello& hello, std::shared_ptr<net::Connection> peer, std::shared_ptr<const TileFacts> facts,
    const std::function<void(const Binding&)>& welcome) {
  const std::lock_guard lock(mutex_);
  if (closed_) return Refusal::ShuttingDown;
  const auto name = std::find(names_.begin(), names_.end(), hello.tileName);
  if (name == names_.end()) return Refusal::UnknownTile;
  const auto tile = static_cast<std::uint32_t>(name - names_.begin());
  Slot& slot = slots_[tile];
  if (slot.connection) return Refusal::TileTaken;
  slot.session = nextSession_++;
  slot.connection = std::move(peer);
  slot.facts = std::move(facts);
  slot.lacked.clear();
  slot.sent = slot.acknowledged = slot.lastShown = 0;
  slot.sharesClock = !hello.clockId.empty() && hello.clockId == hostClockId();
  slot.counts.reconnects += slot.wasBound ? 1 : 0;
  slot.wasBound = true;
  const Binding binding{tile, slot.session};
  welcome(binding);
  changed_.notify_all();
  return binding;
}

TileRoster::Slot* TileRoster::current(const Binding& binding) {
  Slot& slot = slots_[binding.tile];
  return slot.session == binding.session && slot.connection ? &slot : nullptr;
}

bool TileRoster::ready(const Binding& binding, const proto::Ready& ready) {
  const std::lock_guard lock(mutex_);
  Slot* slot = current(binding);
  if (!slot) return true;
  if (ready.frame != slot->sent || ready.frame <= slot->acknowledged) return false;
  if (isDrawing(*slot, newestFrame_)) oneLess();
  slot->acknowledged = ready.frame;
  slot->counts.drawUs.add(ready.drawUs);
  if (ready.missingLeaves > 0) {
    ++slot->counts.framesIncomplete;
    slot->counts.missingLeaves += ready.missingLeaves;
    slot->counts.missingPx += ready.missingPx;
    if (ready.frame > lastIncomplete_) ++framesIncomplete_;
    lastIncomplete_ = std::max(lastIncomplete_, ready.frame);
  }
  return true;
}

bool TileRoster::shown(const Binding& binding, const proto::Shown& shown) {
  const std::lock_guard lock(mutex_);
  Slot* slot = current(binding);
  if (!slot) return true;
  if (shown.frame > slot->acknowledged || shown.frame <= slot->lastShown) return false;
  slot->lastShown = shown.frame;
  slot->lastShownNs = shown.shownNs;
  ++slot->counts.framesShown;
  if (slot->sharesClock) slot->shownTimes.add({shown.frame, shown.shownNs});
  changed_.notify_all();
  return true;
}

void TileRoster::lacks(const Binding& binding, std::span<const std::uint32_t> assets) {
  const std::lock_guard lock(mutex_);
  Slot* slot = current(binding);
  if (!slot || slot->lacked.size() + assets.size() > kMostLacked) return;
  slot->lacked.insert(slot->lacked.end(), assets.begin(), assets.end());
  slot->counts.disksLacked += assets.size();
}

std::uint64_t TileRoster::framesIncomplete() const {
  const std::lock_guard lock(mutex_);
  return framesIncomplete_;
}

bool TileRoster::mayShow(const Binding& binding, std::uint64_t frame) {
  const std::lock_guard lock(mutex_);
  const Slot* slot = current(binding);
  return slot && frame <= slot->acknowledged && frame > slot->lastShown;
}

void TileRoster::leaving(const Binding& binding, const proto::Bye& bye) {
  const std::lock_guard lock(mutex_);
  if (Slot* slot = current(binding)) slot->counts.peakResidentBytes = bye.peakResidentBytes;
}

void TileRoster::gone(const Binding& binding) {
  const std::lock_guard lock(mutex_);
  if (Slot* slot = current(binding)) {
    if (isDrawing(*slot, newestFrame_)) oneLess();
    slot->connection.reset();
  }
  changed_.notify_all();
}

void TileRoster::oneLess() {
  if (--drawing_ == 0) noneDraws_.notify_all();
}

TileRoster::Peer TileRoster::peer(std::uint32_t tile) const {
  const std::lock_guard lock(mutex_);
  const Slot& slot = slots_[tile];
  return {slot.session, slot.connection, slot.acknowledged, slot.sent, slot.facts, {}};
}

void TileRoster::startFrame(std::uint64_t frame, std::vector<Peer>& peers) {
  const std::lock_guard lock(mutex_);
  newestFrame_ = frame;
  drawing_ = 0;
  peers.resize(slots_.size());
  for (std::size_t tile = 0; tile < slots_.size(); ++tile) {
    Slot& slot = slots_[tile];
    if (!slot.connection || slot.acknowledged != slot.sent) {
      ++slot.counts.framesMissed;
      peers[tile] = {};
      continue;
    }
    slot.sent = frame;
    ++drawing_;
    Peer& one = peers[tile];
    one.session = slot.session;
    one.connection = slot.connection;
    one.acknowledged = slot.acknowledged;
    one.sent = slot.sent;
    one.facts = slot.facts;
    std::swap(one.lacked, slot.lacked);
    slot.lacked.clear();
  }
}

void TileRoster::frameMissed(std::uint32_t tile) {
  const std::lock_guard lock(mutex_);
  ++slots_[tile].counts.framesMissed;
}

template <class Predicate>
bool TileRoster::waitUntil(std::unique_lock<std::mutex>& lock, Deadline deadline, Predicate predicate) {
  return changed_.wait_until(lock, deadline, predicate);
}

Result<bool> TileRoster::waitAllBound(Deadline deadline, const std::function<Status()>& whileWaiting) {
  std::unique_lock lock(mutex_);
  const auto allBound = [this] {
    return stopping_ ||
           std::all_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.connection != nullptr; });
  };
  while (!allBound()) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= deadline) return false;
    if (waitUntil(lock, std::min(deadline, now + std::chrono::milliseconds(20)), allBound)) break;
    lock.unlock();
    if (Status status = whileWaiting(); !status) return status.error();
    lock.lock();
  }
  return !stopping_;
}

std::vector<std::uint32_t> TileRoster::waitReady(std::uint64_t frame, Deadline deadline) {
  std::unique_lock lock(mutex_);
  (void)noneDraws_.wait_until(lock, deadline, [&] { return stopping_ || drawing_ == 0; });
  std::vector<std::uint32_t> late;
  for (std::uint32_t tile = 0; tile < slots_.size(); ++tile) {
    if (isDrawing(slots_[tile], frame)) late.push_back(tile);
  }
  return late;
}

void TileRoster::flushAll() {
  const std::lock_guard lock(mutex_);
  for (const Slot& slot : slots_) {
    if (slot.connection) slot.connection->flush();
  }
}

void TileRoster::waitShown(std::uint64_t frame, Deadline deadline) {
  std::unique_lock lock(mutex_);
  (void)waitUntil(lock, deadline, [&] {
    return std::none_of(slots_.begin(), slots_.end(), [frame](const Slot& s) {
      return s.connection && s.acknowledged == frame && s.lastShown < frame;
    });
  });
}

void TileRoster::waitEmpty(Deadline deadline) {
  std::unique_lock lock(mutex_);
  closed_ = true;
  (void)waitUntil(lock, deadline, [this] {
    return std::none_of(slots_.begin(), slots_.end(), [](const Slot& s) { return s.connection != nullptr; });
  });
}

void TileRoster::stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
  noneDraws_.notify_all();
}

bool TileRoster::stopping() const {
  const std::lock_guard lock(mutex_);
  return stopping_;
}

std::vector<std::string> TileRoster::unboundNames() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    if (!slots_[i].connection) names.push_back(names_[i]);
  }
  return names;
}

TileCounts TileRoster::counts(std::uint32_t tile) const {
  const std::lock_guard lock(mutex_);
  return slots_[tile].counts;
}

std::uint32_t TileRoster::skewUs(std::uint64_t frame) const {
  const std::lock_guard lock(mutex_);
  std::int64_t first = INT64_MAX, last = INT64_MIN;
  for (const Slot& slot : slots_) {
    if (!slot.connection || !slot.sharesClock || slot.lastShown != frame) continue;
    first = std::min(first, slot.lastShownNs);
    last = std::max(last, slot.lastShownNs);
  }
  if (first > last) return 0;
  // The clock's numbers are the tiles' word.
  const std::uint64_t ns = static_cast<std::uint64_t>(last) - static_cast<std::uint64_t>(first);
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(ns / 1000, UINT32_MAX));
}

std::vector<ShownTime> TileRoster::shownTimes(std::uint32_t tile) const {
  const std::lock_guard lock(mutex_);
  return slots_[tile].shownTimes.values;
}

}  // namespace tessera
