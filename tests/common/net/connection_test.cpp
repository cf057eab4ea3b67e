#include "common/net/connection.h"

#include <atomic>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace tessera::net {
namespace {

/// Two connections to each other over loopback, served by a thread.
class ConnectionPair : public ::testing::Test {
 protected:
  ConnectionPair() {
    tcp::acceptor acceptor(io_, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
    tcp::socket a(io_), b(io_);
    a.connect(acceptor.local_endpoint());
    acceptor.accept(b);
    here_ = std::make_shared<Connection>(std::move(a));
    there_ = std::make_shared<Connection>(std::move(b));
    thread_ = std::thread([this] { io_.run(); });
  }
  ~ConnectionPair() override {
    io_.stop();
    thread_.join();
  }

  /// Reads one message, waiting for it in this thread.
  Result<Message> read(Connection& connection, Milliseconds deadline) {
    std::optional<Result<Message>> result;
    std::atomic<bool> done{false};
    const auto reading = [&]() -> awaitable<void> {
      result.emplace(co_await connection.read(proto::Expect::Anything, deadline));
      done = true;
    };
    asio::co_spawn(io_, reading, asio::detached);
    while (!done)
      std::this_thread::sleep_for(Milliseconds(1));
    return *std::move(result);
  }

  asio::io_context io_;
  asio::executor_work_guard<asio::io_context::executor_type> work_ = asio::make_work_guard(io_);
  std::shared_ptr<Connection> here_, there_;
  std::thread thread_;
};

TEST_F(ConnectionPair, CarriesMessagesInTheOrderInWhichTheyWereSentFromWhicheverThread) {
  here_->startWriter(Milliseconds(1000));
  std::uint64_t nonce = 0;
  for (int round = 0; round < 200; ++round) {
    // Once from the network's own thread, then from this one: the second must not overtake the first.
    std::atomic<bool> sent{false};
    const std::uint64_t first = ++nonce, second = ++nonce;
    asio::post(io_, [&, first] {
      here_->send(proto::encode(proto::Ping{first}));
      sent = true;
    });
    while (!sent)
      std::this_thread::yield();
    here_->send(proto::encode(proto::Ping{second}));
  }
  for (std::uint64_t expected = 1; expected <= nonce; ++expected) {
    const auto message = read(*there_, Milliseconds(2000));
    ASSERT_TRUE(message) << message.error().text();
    const auto ping = proto::decodePing(message->payload);
    ASSERT_TRUE(ping);
    ASSERT_EQ(ping->nonce, expected);
  }
}

TEST_F(ConnectionPair, ASilentPeerIsGivenUpAtTheDeadline) {
  const auto start = Clock::now();
  const auto message = read(*there_, Milliseconds(200));
  ASSERT_FALSE(message);
  EXPECT_NE(message.error().text().find("deadline"), std::string::npos) << message.error().text();
  EXPECT_GE(Clock::now() - start, Milliseconds(190));
  EXPECT_LT(Clock::now() - start, Milliseconds(5000));
}

TEST_F(ConnectionPair, APeerThatLeavesIsNoticedAtOnce) {
  here_->close();
  const auto message = read(*there_, Milliseconds(5000));
  ASSERT_FALSE(message);
  EXPECT_NE(message.error().text().find("closed by the other side"), std::string::npos)
      << message.error().text();
}

TEST_F(ConnectionPair, WhatIsQueuedIsSentBeforeClosingAndNothingAfter) {
  here_->startWriter(Milliseconds(1000));
  here_->send(proto::encode(proto::Ping{7}));
  here_->closeAfterSending();
  here_->send(proto::encode(proto::Ping{8}));
  const auto first = read(*there_, Milliseconds(2000));
  ASSERT_TRUE(first) << first.error().text();
  EXPECT_FALSE(read(*there_, Milliseconds(2000)));
}

TEST_F(ConnectionPair, MakesALazyMessageOnlyWhenItsTurnHasCome) {
  std::atomic<int> made{0};
  for (int i = 0; i < 3; ++i) {
    here_->send([&made] {
      ++made;
      return std::make_shared<const proto::Bytes>(proto::encode(proto::Ping{1}));
    });
  }
  EXPECT_EQ(made, 0) << "nothing writes yet";
  here_->startWriter(Milliseconds(1000));
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(read(*there_, Milliseconds(2000)));
  EXPECT_EQ(made, 3);
}

TEST(HostPort, IsParsedAndRefused) {
  EXPECT_EQ(parseHostPort("wall.example:7400")->host, "wall.example");
  EXPECT_EQ(parseHostPort("[::1]:80")->host, "::1");
  EXPECT_EQ(parseHostPort("10.0.0.1:0")->port, "0");
  for (const char* bad :
       {"", "host", "host:", ":80", "host:65536", "host:-1", "host:8o", "host:123456", "[]:80"}) {
    EXPECT_FALSE(parseHostPort(bad)) << bad;
  }
}

}  // namespace
}  // namespace tessera::net
