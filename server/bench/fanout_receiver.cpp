#include "server/bench/fanout_receiver.h"

#include <algorithm>
#include <memory>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include "common/assets/asset_id.h"
#include "common/net/connection.h"

namespace tessera::bench {

namespace {

using net::awaitable;

constexpr net::Milliseconds kDeadline{30'000};

/// A socket that is connected to a port of this machine; -1 after a failure.
int connectTo(std::uint16_t port) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const timeval deadline = {.tv_sec = kDeadline.count() / 1000, .tv_usec = 0};
  if (fd < 0 || setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &deadline, sizeof deadline) != 0) return -1;
  return connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? fd : -1;
}

bool receiveBare(int fd, std::uint64_t bytes, std::size_t bufferBytes) {
  std::vector<std::byte> buffer(bufferBytes);
  std::size_t at = 0;
  while (bytes > 0) {
    if (at == buffer.size()) at = 0;
    const std::size_t room = std::min(buffer.size() - at, kBareStretchBytes);
    const ssize_t got = read(fd, buffer.data() + at, std::min<std::uint64_t>(room, bytes));
    if (got <= 0) return false;
    bytes -= static_cast<std::uint64_t>(got);
    at += static_cast<std::size_t>(got);
  }
  const char done = 1;
  return write(fd, &done, 1) == 1;
}

bool areWhatTheyAreCalled(const net::Message& message) {
  const auto decoded = proto::decodeAssets(message.payload);
  return decoded &&
         std::all_of(decoded->assets.begin(), decoded->assets.end(),
                     [](const proto::Asset& asset) { return assetIdOf(asset.bytes).bytes == asset.id; });
}

awaitable<void> receiveMessages(std::shared_ptr<net::Connection> from, std::uint64_t messages, bool checks,
                                bool& good) {
  net::Message message;
  for (std::uint64_t i = 0; i < messages; ++i) {
    const Status status = co_await from->readInto(message, proto::Expect::FromMaster, kDeadline);
    if (!status || (checks && !areWhatTheyAreCalled(message))) co_return from->close();
  }
  good = true;
  from->send(proto::encode(proto::Pong{1}));
  from->closeAfterSending();
}

}  // namespace

bool receiveFanout(FanoutReceiver receiver, std::uint16_t port, std::uint64_t bytes, std::uint64_t messages) {
  const int fd = connectTo(port);
  if (fd < 0) return false;
  if (receiver == FanoutReceiver::Bare) return receiveBare(fd, bytes, kBareStretchBytes);
  if (receiver == FanoutReceiver::BareWhole) return receiveBare(fd, bytes, bytes / messages);
  net::asio::io_context io;
  net::tcp::socket socket(io);
  net::error_code ec;
  socket.assign(net::tcp::v4(), fd, ec);
  if (ec) return false;
  const auto connection = std::make_shared<net::Connection>(std::move(socket));
  connection->startWriter(kDeadline);
  bool good = false;
  net::asio::co_spawn(io,
                      receiveMessages(connection, messages, receiver == FanoutReceiver::CheckedAssets, good),
                      net::asio::detached);
  io.run();
  return good;
}

}  // namespace tessera::bench
