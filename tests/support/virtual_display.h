#pragma once

#include <memory>
#include <string>

#include "common/image/picture.h"
#include "tests/support/process.h"

namespace tessera::test {

/// An X server of its own without a screen (Xvfb), one monitor, no window manager. Ends when this goes away.
class VirtualDisplay {
 public:
  VirtualDisplay(int widthPx, int heightPx);

  /// Why there is none, for GTEST_SKIP; empty: it runs.
  [[nodiscard]] const std::string& missing() const { return missing_; }
  /// For DISPLAY: ":7".
  [[nodiscard]] const std::string& name() const { return name_; }
  /// What its screen shows now; empty where it cannot be read.
  [[nodiscard]] Picture screen() const;

  // A person at it. False: this machine has no library (libXtst) to play one.
  [[nodiscard]] bool pressKey(unsigned long keysym) const;
  [[nodiscard]] bool movePointer(int xPx, int yPx) const;
  /// Buttons of X: 1 to 3 from the left, 4 and 5 turn the wheel up and down.
  [[nodiscard]] bool clickButton(unsigned button) const;

 private:
  TemporaryFolder folder_;
  std::unique_ptr<Process> server_;
  std::string name_, missing_;
};

inline constexpr unsigned long kEscapeKeysym = 0xff1b;

}  // namespace tessera::test
