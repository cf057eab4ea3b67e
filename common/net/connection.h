#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/net/asio.h"
#include "proto/codec.h"
#include "proto/frame.h"

namespace tessera::net {

/// A message as it came: type and payload, checked against size limits and checksums, not yet decoded.
struct Message {
  proto::MessageType type = proto::MessageType::Hello;
  std::vector<std::byte> payload;
};

/// Makes a message when its turn to be sent has come, so that a queue of large ones costs no memory.
using LazyBytes = std::function<std::shared_ptr<const proto::Bytes>()>;

/// One peer over TCP.
///
/// Threads: all members must be called on the executor of the socket (one thread, or one strand), but for
/// send() and close(), which any thread may call. Lives in a shared_ptr; the running operations hold it.
///
/// Deadlines: each is on progress. A read or write fails when a stretch of at most 1 MiB takes longer than
/// its deadline, so a slow peer may take long for much, but nobody can hold us with nothing. After any
/// failure the connection is closed.
///
/// Memory: a payload is given room as it arrives, never by what its header announces.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  explicit Connection(tcp::socket socket);

  /// "ADDRESS:PORT" of the peer.
  [[nodiscard]] const std::string& peer() const { return peer_; }

  /// The next message. Errors name the peer and the reason: closed by it, deadline, or a
  /// proto::ProtocolError.
  [[nodiscard]] awaitable<Result<Message>> read(proto::Expect expect, Milliseconds deadline);

  /// Starts sending what is queued. `deadline` is for the writes. Call once.
  void startWriter(Milliseconds deadline);

  /// Queues a message behind all that send() has queued before, from whichever thread. Thread-safe. A peer
  /// with kMaxQueuedMessages unsent messages is given up.
  void send(LazyBytes message);
  void send(proto::Bytes message);

  /// Closes after what is queued has been sent. Thread-safe.
  void closeAfterSending();
  /// Closes now; operations under way fail. Thread-safe.
  void close();

  static constexpr std::size_t kMaxQueuedMessages = 1 << 16;

 private:
  awaitable<error_code> readExactly(std::span<std::byte> bytes, Milliseconds deadline);
  awaitable<void> writeQueued(std::shared_ptr<Connection> self, Milliseconds deadline);
  /// Closes the socket unless `operation` has moved on when the deadline comes.
  void guard(asio::steady_timer& timer, std::uint64_t& operation, Milliseconds deadline);
  /// The next message to write; null when there is none, with `last` telling whether none will come.
  LazyBytes takeQueued(bool& last);
  void wakeWriter();
  void closeNow();
  [[nodiscard]] Error failure(const error_code& ec, const char* doing) const;

  tcp::socket socket_;
  std::string peer_;
  asio::steady_timer readTimer_, writeTimer_, wakeWriter_;
  std::uint64_t readOperation_ = 0, writeOperation_ = 0;
  bool timedOut_ = false;

  // The queue has a lock of its own: posts from several threads to an io context keep no common order.
  std::mutex mutex_;
  std::deque<LazyBytes> queue_;
  bool closing_ = false;
};

/// Splits "HOST:PORT" or "[V6]:PORT".
struct HostPort {
  std::string host, port;
};
[[nodiscard]] Result<HostPort> parseHostPort(const std::string& text);

/// Connects within the deadline.
[[nodiscard]] awaitable<Result<std::shared_ptr<Connection>>> connect(const HostPort& to,
                                                                     Milliseconds deadline);

/// Opens a listening socket. A port in use is one clear error.
[[nodiscard]] Result<tcp::acceptor> listen(asio::io_context& io, const HostPort& at);

}  // namespace tessera::net
