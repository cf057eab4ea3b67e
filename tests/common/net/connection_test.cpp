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

  Status readInto(Connection& connection, Message& message, Milliseconds deadline) {
    std::optional<Status> result;
    std::atomic<bool> done{false};
    const auto reading = [&]() -> awaitable<void> {
      result.emplace(co_await connection.readInto(message, proto::Expect::Anything, deadline));
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

TEST_F(ConnectionPair, WhatIsQueuedWaitsForAFlushAndKeepsItsOrder) {
  here_->startWriter(Milliseconds(1000));
  std::this_thread::sleep_for(Milliseconds(50));  // the writer has found nothing and sleeps
  const proto::Bytes first = proto::encode(proto::Ping{1}), second = proto::encode(proto::Ping{2});
  here_->queue(std::span<const std::byte>(first));
  here_->queue([] { return std::make_shared<const proto::Bytes>(proto::encode(proto::Ping{100})); });
  here_->queue(std::span<const std::byte>(second));
  const auto start = Clock::now();
  asio::steady_timer timer(io_, Milliseconds(100));
  timer.async_wait([this](const error_code&) { here_->flush(); });
  for (const std::uint64_t expected : {1, 100, 2}) {
    const auto message = read(*there_, Milliseconds(2000));
    ASSERT_TRUE(message) << message.error().text();
    EXPECT_EQ(proto::decodePing(message->payload)->nonce, expected);
  }
  EXPECT_GE(Clock::now() - start, Milliseconds(90));
}

TEST_F(ConnectionPair, CarriesMessagesOfAllSizes) {
  here_->startWriter(Milliseconds(5000));
  std::vector<std::byte> bytes(3'000'000);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<std::byte>(i * 7 + i / 251);
  const std::size_t sizes[] = {0, 1, 3000, 4000, 5000, 16'000, 16'384, 40'000, 2'000'000, 10, 3'000'000, 5};
  for (const std::size_t size : sizes) {
    proto::Frame frame;
    frame.frame = size + 1;
    frame.toggles = std::span(bytes).first(size);
    here_->send(proto::encode(frame));
  }
  for (const std::size_t size : sizes) {
    const auto message = read(*there_, Milliseconds(5000));
    ASSERT_TRUE(message) << message.error().text();
    const auto frame = proto::decodeFrame(message->payload);
    ASSERT_TRUE(frame) << frame.error().text();
    ASSERT_EQ(frame->toggles.size(), size);
    EXPECT_TRUE(std::equal(frame->toggles.begin(), frame->toggles.end(), bytes.begin()));
  }
}

TEST_F(ConnectionPair, OneMessageIsSharedByManyQueuesAndRoomIsUsedAgain) {
  std::vector<std::byte> content(1'500'000);
  for (std::size_t i = 0; i < content.size(); ++i)
    content[i] = static_cast<std::byte>(i * 5 + i / 509);
  const proto::Asset asset = {.bytes = content};
  const auto large = std::make_shared<const proto::Bytes>(proto::encode(proto::Assets{{asset, asset}}));
  const auto small = std::make_shared<const proto::Bytes>(proto::encode(proto::Ping{3}));
  here_->startWriter(Milliseconds(5000));
  there_->startWriter(Milliseconds(5000));
  for (Connection* connection : {here_.get(), there_.get()}) {
    connection->queue(large);
    connection->queue(small);
    connection->send(large);
  }
  Message message;
  for (Connection* connection : {there_.get(), here_.get()}) {
    const std::byte* room = nullptr;
    for (const bool isLarge : {true, false, true}) {
      const Status status = readInto(*connection, message, Milliseconds(5000));
      ASSERT_TRUE(status.ok()) << status.error().text();
      if (!isLarge) {
        EXPECT_EQ(proto::decodePing(message.payload)->nonce, 3U);
        continue;
      }
      const auto assets = proto::decodeAssets(message.payload);
      ASSERT_TRUE(assets.ok()) << assets.error().text();
      ASSERT_EQ(assets->assets.size(), 2U);
      EXPECT_TRUE(std::equal(content.begin(), content.end(), assets->assets[1].bytes.begin()));
      if (room) {
        EXPECT_EQ(message.payload.data(), room);
      }
      room = message.payload.data();
    }
  }
  // What is written is let go, a moment after it has arrived.
  const auto end = Clock::now() + Milliseconds(5000);
  while (large.use_count() > 1 && Clock::now() < end)
    std::this_thread::sleep_for(Milliseconds(1));
  EXPECT_EQ(large.use_count(), 1);
}

TEST_F(ConnectionPair, ADamagedLargePayloadIsRefused) {
  std::vector<std::byte> content(2'000'000, std::byte{1});
  for (const std::size_t place : {std::size_t{60}, content.size() / 2, content.size()}) {
    SCOPED_TRACE(place);
    proto::Bytes bytes = proto::encode(proto::Assets{{{.bytes = content}}});
    bytes[place] ^= std::byte{4};
    here_->send(std::make_shared<const proto::Bytes>(std::move(bytes)));
    if (place == 60) here_->startWriter(Milliseconds(5000));
    const auto message = read(*there_, Milliseconds(5000));
    ASSERT_FALSE(message);
    EXPECT_NE(message.error().text().find("checksum"), std::string::npos) << message.error().text();
  }
}

TEST_F(ConnectionPair, APeerThatReadsNothingIsGivenUpAtTheDeadline) {
  here_->startWriter(Milliseconds(300));
  const auto large = std::make_shared<const proto::Bytes>(64 << 20);
  here_->send([large] { return large; });
  const auto start = Clock::now();
  const auto message = read(*here_, Milliseconds(10'000));
  EXPECT_FALSE(message);
  EXPECT_LT(Clock::now() - start, Milliseconds(5000));
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
