#include "tests/support/virtual_display.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

#include <dlfcn.h>

namespace tessera::test {

namespace {

namespace fs = std::filesystem;

std::string findProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (fs::exists(fs::path(folder) / name)) return fs::path(folder) / name;
  }
  return {};
}

/// A number of the header of an XWD file.
std::uint32_t bigEndian(const std::string& bytes, std::size_t index) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i)
    number = number << 8U | static_cast<unsigned char>(bytes[4 * index + i]);
  return number;
}

/// The functions of Xlib and XTest that a person needs; looked up when used, so that the tests build without.
class XTest {
 public:
  explicit XTest(const std::string& displayName)
      : x11_(::dlopen("libX11.so.6", RTLD_NOW)), xtst_(::dlopen("libXtst.so.6", RTLD_NOW)) {
    if (!x11_ || !xtst_) return;
    const auto open = function<void*(const char*)>(x11_, "XOpenDisplay");
    display_ = open ? open(displayName.c_str()) : nullptr;
  }
  ~XTest() {
    if (display_) (void)function<int(void*)>(x11_, "XCloseDisplay")(display_);
  }
  XTest(const XTest&) = delete;
  XTest& operator=(const XTest&) = delete;
  [[nodiscard]] bool works() const { return display_ != nullptr; }

  void key(unsigned long keysym) const {
    const auto code =
        function<unsigned char(void*, unsigned long)>(x11_, "XKeysymToKeycode")(display_, keysym);
    const auto press = function<int(void*, unsigned, int, unsigned long)>(xtst_, "XTestFakeKeyEvent");
    press(display_, code, 1, 0);
    press(display_, code, 0, 0);
    finish();
  }
  void click(unsigned button) const {
    const auto press = function<int(void*, unsigned, int, unsigned long)>(xtst_, "XTestFakeButtonEvent");
    press(display_, button, 1, 0);
    press(display_, button, 0, 0);
    finish();
  }
  void move(int xPx, int yPx) const {
    function<int(void*, int, int, int, unsigned long)>(xtst_, "XTestFakeMotionEvent")(display_, -1, xPx, yPx,
                                                                                      0);
    finish();
  }

 private:
  template <class Signature>
  static Signature* function(void* library, const char* name) {
    return reinterpret_cast<Signature*>(::dlsym(library, name));
  }
  void finish() const { function<int(void*, int)>(x11_, "XSync")(display_, 0); }

  void* x11_;
  void* xtst_;
  void* display_ = nullptr;
};

}  // namespace

VirtualDisplay::VirtualDisplay(int widthPx, int heightPx) {
  const std::string program = findProgram("Xvfb");
  if (program.empty()) {
    missing_ = "Xvfb is not installed";
    return;
  }
  const std::string screen = std::to_string(widthPx) + "x" + std::to_string(heightPx) + "x24";
  server_ = std::make_unique<Process>(std::vector<std::string>{
      program, "-displayfd", "1", "-screen", "0", screen, "-fbdir", folder_.path(), "-nolisten", "tcp"});
  if (!server_->waitForOut("\n", std::chrono::seconds(20))) {
    missing_ = "Xvfb does not start: " + server_->err();
    return;
  }
  name_ = ":" + server_->out();
  name_.erase(name_.find('\n'));
}

Picture VirtualDisplay::screen() const {
  std::ifstream in(folder_ / "Xvfb_screen0", std::ios::binary);
  std::ostringstream all;
  all << in.rdbuf();
  const std::string bytes = all.str();
  if (bytes.size() < 100) return {};
  const std::size_t header = bigEndian(bytes, 0), lineBytes = bigEndian(bytes, 12),
                    colours = bigEndian(bytes, 19);
  Picture picture(static_cast<int>(bigEndian(bytes, 4)), static_cast<int>(bigEndian(bytes, 5)));
  const std::size_t start = header + 12 * colours;
  const bool isBgrx = bigEndian(bytes, 11) == 32 && bigEndian(bytes, 7) == 0;
  if (!isBgrx || bytes.size() < start + lineBytes * static_cast<std::size_t>(picture.heightPx)) return {};
  std::uint8_t* to = picture.rgb.data();
  for (int y = 0; y < picture.heightPx; ++y) {
    const char* from = bytes.data() + start + static_cast<std::size_t>(y) * lineBytes;
    for (int x = 0; x < picture.widthPx; ++x, from += 4) {
      for (int channel = 2; channel >= 0; --channel)
        *to++ = static_cast<std::uint8_t>(from[channel]);
    }
  }
  return picture;
}

bool VirtualDisplay::pressKey(unsigned long keysym) const {
  const XTest person(name_);
  if (person.works()) person.key(keysym);
  return person.works();
}

bool VirtualDisplay::clickButton(unsigned button) const {
  const XTest person(name_);
  if (person.works()) person.click(button);
  return person.works();
}

bool VirtualDisplay::movePointer(int xPx, int yPx) const {
  const XTest person(name_);
  if (person.works()) person.move(xPx, yPx);
  return person.works();
}

}  // namespace tessera::test
