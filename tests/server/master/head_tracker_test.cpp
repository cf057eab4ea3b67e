#include "server/master/head_tracker.h"

#include <chrono>
#include <limits>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <lo/lo.h>

namespace tessera {
namespace {

/// What the tracker has heard once something new came, or at the deadline.
std::optional<Vec3> heard(const HeadTracker& tracker, const std::optional<Vec3>& before) {
  for (int i = 0; i < 300; ++i) {
    const auto head = tracker.headM();
    if (head != before) return head;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return before;
}

class Osc {
 public:
  explicit Osc(int port) : address_(lo_address_new("127.0.0.1", std::to_string(port).c_str())) {}
  ~Osc() { lo_address_free(address_); }
  Osc(const Osc&) = delete;
  Osc& operator=(const Osc&) = delete;
  lo_address get() const { return address_; }

 private:
  lo_address address_;
};

TEST(HeadTracker, hearsWhereTheHeadIs) {
  const auto tracker = HeadTracker::listen(0);
  ASSERT_TRUE(tracker.ok()) << tracker.error().text();
  EXPECT_FALSE((*tracker)->headM());
  const Osc osc((*tracker)->port());
  lo_send(osc.get(), "/tessera/head", "fff", 0.25, 1.5, -0.5);
  const auto first = heard(**tracker, std::nullopt);
  ASSERT_TRUE(first);
  EXPECT_EQ(*first, Vec3(0.25, 1.5, -0.5));
  lo_send(osc.get(), "/tessera/head", "ddd", 0.1, 0.2, 0.3);
  EXPECT_EQ(*heard(**tracker, first), Vec3(0.1, 0.2, 0.3));
}

TEST(HeadTracker, ignoresWhatIsNoHead) {
  const auto tracker = HeadTracker::listen(0);
  ASSERT_TRUE(tracker.ok());
  const Osc osc((*tracker)->port());
  lo_send(osc.get(), "/tessera/head", "ff", 1.0, 2.0);
  lo_send(osc.get(), "/tessera/head", "fss", 1.0, "a", "b");
  lo_send(osc.get(), "/tessera/head", "fff", 1.0, std::numeric_limits<double>::quiet_NaN(), 2.0);
  lo_send(osc.get(), "/tessera/head", "fff", 1.0, 1e9, 2.0);
  lo_send(osc.get(), "/other", "fff", 1.0, 2.0, 3.0);
  lo_send(osc.get(), "/tessera/head", "fff", 7.0, 8.0, 9.0);
  EXPECT_EQ(*heard(**tracker, std::nullopt), Vec3(7, 8, 9));
}

TEST(HeadTracker, saysThatAPortIsTaken) {
  const auto one = HeadTracker::listen(0);
  ASSERT_TRUE(one.ok());
  const auto other = HeadTracker::listen((*one)->port());
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().text().find("OSC port"), std::string::npos) << other.error().text();
}

}  // namespace
}  // namespace tessera
