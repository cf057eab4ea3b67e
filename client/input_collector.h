#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/messages.h"

namespace tessera {

/// What a person did at a window since it was asked last, in order: moves in a row are one, steps of the
/// wheel in a row are added up, a gamepad is told of when its state has changed. Keys, buttons and axes are
/// those of GLFW; whatever the protocol does not allow is made to fit or left out. Holds a bounded number;
/// what comes beyond it is lost.
class InputCollector {
 public:
  /// So many at once, 60 times a second, stay below what a master takes from a tile.
  static constexpr std::size_t kMostAtOnce = 12;

  void quit();
  void key(int code, bool pressed, int modifiers);
  /// Places are those in the tile's picture, 0 to 1 from its upper left.
  void button(int code, bool pressed, int modifiers, double x, double y);
  void moveTo(double x, double y);
  void scroll(double stepsRight, double stepsUp);
  /// The state of one gamepad, however often it is told.
  void gamepad(std::size_t number, const std::array<float, 6>& axes, std::uint32_t buttons);
  /// That it is not there: all it held is let go.
  void noGamepad(std::size_t number);

  /// Moves the first of what waits, at most kMostAtOnce, to the end of `inputs`.
  void takeInto(std::vector<proto::Input>& inputs);

  static constexpr std::size_t kGamepads = 16;

 private:
  void add(const proto::Input& input);
  [[nodiscard]] proto::Input* lastOf(proto::InputKind kind);

  std::vector<proto::Input> waiting_;
  double x_ = -1, y_ = -1;  ///< last told
  struct Gamepad {
    std::array<float, 6> axes = kAtRest;
    std::uint32_t buttons = 0;
  };
  static constexpr std::array<float, 6> kAtRest = {0, 0, 0, 0, -1, -1};
  std::array<Gamepad, kGamepads> gamepads_;
};

}  // namespace tessera
