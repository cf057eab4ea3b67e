#include "server/master/input_queue.h"

#include <algorithm>

namespace tessera {

namespace {

using proto::InputKind;

double steps(double sum) {
  return std::clamp(sum, -proto::kMaxScrollSteps, proto::kMaxScrollSteps);
}

}  // namespace

InputQueue::InputQueue() {
  waiting_.reserve(kCapacity);
}

void InputQueue::add(std::uint32_t tile, const proto::Input& input) {
  const std::lock_guard lock(mutex_);
  if (mergeIntoLast(tile, input)) return;
  if (waiting_.size() == kCapacity) makeRoom();
  if (waiting_.size() < kCapacity) waiting_.push_back({tile, input});
}

bool InputQueue::mergeIntoLast(std::uint32_t tile, const proto::Input& input) {
  const auto last = std::find_if(waiting_.rbegin(), waiting_.rend(),
                                 [tile](const TileInput& waiting) { return waiting.tile == tile; });
  if (last == waiting_.rend() || last->input.kind != input.kind) return false;
  proto::Input& before = last->input;
  switch (input.kind) {
    case InputKind::Quit:
      return true;
    case InputKind::Move:
      before = input;
      return true;
    case InputKind::Scroll:
      before.x = steps(before.x + input.x);
      before.y = steps(before.y + input.y);
      return true;
    case InputKind::Gamepad:
      // A button that was pressed and let go in between must be seen.
      if (before.code != input.code || before.buttons != input.buttons) return false;
      before = input;
      return true;
    case InputKind::Key:
    case InputKind::Button:
      return false;
  }
  return false;
}

void InputQueue::makeRoom() {
  auto victim = std::find_if(waiting_.begin(), waiting_.end(),
                             [](const TileInput& one) { return one.input.kind == InputKind::Move; });
  if (victim == waiting_.end()) {
    victim = std::find_if(waiting_.begin(), waiting_.end(),
                          [](const TileInput& one) { return one.input.kind != InputKind::Quit; });
  }
  if (victim != waiting_.end()) waiting_.erase(victim);
}

void InputQueue::drainInto(std::vector<TileInput>& inputs) {
  inputs.clear();
  const std::lock_guard lock(mutex_);
  inputs.insert(inputs.end(), waiting_.begin(), waiting_.end());
  waiting_.clear();
}

}  // namespace tessera
