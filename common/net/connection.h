#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/net/asio.h"
#include "common/net/payload_bytes.h"
#include "proto/codec.h"
#include "proto/frame.h"

namespace tessera::net {

/// A message as it came: type and payload, checked against size limits and checksums, not yet decoded.
struct Message {
  proto::MessageType type = proto::MessageType::Hello;
  PayloadBytes payload;
};

/// A message made once, however many connections send it: they all write the same bytes.
using SharedBytes = std::shared_ptr<const proto::Bytes>;

/// Makes a message when its turn to be sent has come, so that a queue of large ones costs no memory.
using LazyBytes = std::function<SharedBytes()>;

/// One peer over TCP.
///
/// Threads: all members must be called on the executor of the socket (one thread, or one strand), but for
/// send(), queue() and the two ways to close, which any thread may call. Lives in a shared_ptr; the running
/// operations hold it.
///
/// Deadlines: each is on progress. A read or write fails when a stretch of at most 1 MiB takes longer than
/// its deadline, so a slow peer may take long for much, but nobody can hold us with nothing. After any
/// failure the connection is closed.
///
/// Memory: a payload is given room as it arrives, never by what its header announces. Small messages are
/// copied into buffers that are used again once written, and several that wait are written together.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  explicit Connection(tcp::socket socket);

  /// "ADDRESS:PORT" of the peer.
  [[nodiscard]] const std::string& peer() const { return peer_; }

  /// The next message. Errors name the peer and the reason: closed by it, deadline, or a
  /// proto::ProtocolError.
  [[nodiscard]] awaitable<Result<Message>> read(proto::Expect expect, Milliseconds deadline);
  /// The same into `message`, whose payload's room is used again: for whoever receives much.
  [[nodiscard]] awaitable<Status> readInto(Message& message, proto::Expect expect, Milliseconds deadline);

  /// Starts sending what is queued. `deadline` is for the writes. Call once.
  void startWriter(Milliseconds deadline);

  /// Queues a message behind all that were queued before, from whichever thread. Thread-safe. A peer with
  /// kMaxQueuedMessages waiting messages is given up.
  void send(LazyBytes message);
  void send(SharedBytes message);
  void send(proto::Bytes message);
  void send(std::span<const std::byte> message);

  /// The same without waking the writer, who may find it at once or sleep on until flush() or the next
  /// send(): whoever has messages for many connections wakes all by one post. Does not allocate once warm.
  void queue(LazyBytes message);
  void queue(SharedBytes message);
  void queue(std::span<const std::byte> message);
  /// Wakes the writer where something is queued. Not thread-safe.
  void flush();

  /// Closes after what is queued has been sent. Thread-safe.
  void closeAfterSending();
  /// Closes now; operations under way fail. Thread-safe.
  void close();

  static constexpr std::size_t kMaxQueuedMessages = 1 << 16;

 private:
  /// Closes the socket when an operation is late. Its timer is not set anew for each operation but looks,
  /// when it fires, for what is due by then.
  struct Watch {
    explicit Watch(const asio::any_io_executor& executor) : timer(executor) {}
    asio::steady_timer timer;
    Clock::time_point due = Clock::time_point::max();      ///< of the operation under way; max: none is
    Clock::time_point firesAt = Clock::time_point::max();  ///< max: the timer is not set
  };
  /// A stretch of queued messages: bytes of several, one that is shared, or one that is made when its turn
  /// has come.
  struct Stretch {
    proto::Bytes bytes = {};
    SharedBytes shared = {};
    LazyBytes make = {};
  };

  /// Receives into `bytes` until they are full, and adds them to the checksum while they are in the cache.
  awaitable<error_code> readPayload(std::span<std::byte> bytes, Milliseconds deadline, std::uint32_t& crc32c);
  /// Receives until at least `count` (at most kReceiveBytes) bytes wait in `received_`.
  awaitable<error_code> receive(std::size_t count, Milliseconds deadline);
  awaitable<void> writeQueued(std::shared_ptr<Connection> self, Milliseconds deadline);
  awaitable<error_code> write(std::span<const std::byte> bytes, Milliseconds deadline);
  void guard(Watch& watch, Milliseconds deadline);
  void setTimer(Watch& watch);
  /// False: the peer is given up. With the lock held.
  bool mayQueue();
  /// Moves what is queued to `taken_`, whose buffers, written by now, are used again.
  enum class Taken { Something, Nothing, NothingEver };
  Taken takeQueued();
  void wakeWriter();
  void closeNow();
  [[nodiscard]] Error failure(const error_code& ec, const char* doing) const;

  tcp::socket socket_;
  std::string peer_;
  Watch reading_, writing_;
  asio::steady_timer wakeWriter_;
  bool timedOut_ = false;
  std::vector<std::byte> received_;  ///< what came together, of which a part is read
  std::size_t receivedBegin_ = 0, receivedEnd_ = 0;
  std::vector<Stretch> taken_;  ///< being written

  // The queue has a lock of its own: posts from several threads to an io context keep no common order.
  std::mutex mutex_;
  std::vector<Stretch> queue_;
  std::vector<proto::Bytes> spare_;  ///< empty buffers that have room
  std::size_t queuedMessages_ = 0;
  bool closing_ = false;
  bool writerSleeps_ = false;
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
