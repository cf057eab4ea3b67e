#include "client/input_collector.h"

#include <algorithm>
#include <cmath>

namespace tessera {

namespace {

using proto::Input;
using proto::InputKind;

constexpr std::size_t kMostWaiting = 256;

double fraction(double value) {
  return std::isfinite(value) ? std::clamp(value, 0.0, 1.0) : 0.0;
}

double steps(double value) {
  return std::isfinite(value) ? std::clamp(value, -proto::kMaxScrollSteps, proto::kMaxScrollSteps) : 0.0;
}

std::uint32_t bits(int value, std::uint32_t count) {
  return static_cast<std::uint32_t>(value) & ((1U << count) - 1);
}

bool isCode(int code) {
  return code >= 0 && code <= proto::kMaxInputCode;  // GLFW's number for a key it does not know is -1
}

}  // namespace

void InputCollector::add(const Input& input) {
  if (waiting_.size() < kMostWaiting || input.kind == InputKind::Quit) waiting_.push_back(input);
}

Input* InputCollector::lastOf(InputKind kind) {
  return !waiting_.empty() && waiting_.back().kind == kind ? &waiting_.back() : nullptr;
}

void InputCollector::quit() {
  const auto isQuit = [](const Input& input) { return input.kind == InputKind::Quit; };
  if (std::none_of(waiting_.begin(), waiting_.end(), isQuit)) add({.kind = InputKind::Quit});
}

void InputCollector::key(int code, bool pressed, int modifiers) {
  if (!isCode(code)) return;
  add({.kind = InputKind::Key,
       .code = code,
       .pressed = pressed,
       .modifiers = bits(modifiers, proto::kInputModifierBits)});
}

void InputCollector::button(int code, bool pressed, int modifiers, double x, double y) {
  if (!isCode(code)) return;
  add({.kind = InputKind::Button,
       .code = code,
       .pressed = pressed,
       .modifiers = bits(modifiers, proto::kInputModifierBits),
       .x = fraction(x),
       .y = fraction(y)});
}

void InputCollector::moveTo(double x, double y) {
  x = fraction(x), y = fraction(y);
  if (x == x_ && y == y_) return;
  x_ = x, y_ = y;
  if (Input* last = lastOf(InputKind::Move)) {
    last->x = x, last->y = y;
  } else {
    add({.kind = InputKind::Move, .x = x, .y = y});
  }
}

void InputCollector::scroll(double stepsRight, double stepsUp) {
  if (Input* last = lastOf(InputKind::Scroll)) {
    last->x = steps(last->x + steps(stepsRight)), last->y = steps(last->y + steps(stepsUp));
  } else {
    add({.kind = InputKind::Scroll, .x = steps(stepsRight), .y = steps(stepsUp)});
  }
}

void InputCollector::gamepad(std::size_t number, const std::array<float, 6>& axes, std::uint32_t buttons) {
  if (number >= kGamepads) return;
  Gamepad now{.axes = axes, .buttons = buttons & ((1U << proto::kGamepadButtonBits) - 1)};
  for (float& axis : now.axes)
    axis = std::isfinite(axis) ? std::clamp(axis, -1.0F, 1.0F) : 0.0F;
  Gamepad& told = gamepads_[number];
  if (now.axes == told.axes && now.buttons == told.buttons) return;
  told = now;
  add({.kind = InputKind::Gamepad,
       .code = static_cast<std::int32_t>(number),
       .axes = now.axes,
       .buttons = now.buttons});
}

void InputCollector::noGamepad(std::size_t number) {
  gamepad(number, kAtRest, 0);
}

void InputCollector::takeInto(std::vector<Input>& inputs) {
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(std::min(kMostAtOnce, waiting_.size()));
  inputs.insert(inputs.end(), waiting_.begin(), end);
  waiting_.erase(waiting_.begin(), end);
}

}  // namespace tessera
