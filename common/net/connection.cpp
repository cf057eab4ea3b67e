#include "common/net/connection.h"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>

#include "proto/crc32c.h"

namespace tessera::net {

namespace {

constexpr std::size_t kStretchBytes = 1 << 20;
/// So much is received at a time: it is then still in the cache when its checksum is computed.
constexpr std::size_t kReadBytes = 1 << 18;
/// Whoever waits for the rest of a large payload is woken when so much has come, not for every packet.
constexpr std::size_t kWakeBytes = 1 << 17;
constexpr std::size_t kReceiveBytes = 1 << 14, kSmallStretchBytes = 1 << 12;
constexpr std::size_t kUsualStretches = 8;  // that wait at a time for a peer that keeps up

std::string nameOf(const tcp::socket& socket) {
  error_code ec;
  const tcp::endpoint endpoint = socket.remote_endpoint(ec);
  if (ec) return "peer";
  const std::string address = endpoint.address().to_string(ec);
  return (endpoint.address().is_v6() ? "[" + address + "]" : address) + ":" + std::to_string(endpoint.port());
}

}  // namespace

Connection::Connection(tcp::socket socket)
    : socket_(std::move(socket)),
      peer_(nameOf(socket_)),
      reading_(socket_.get_executor()),
      writing_(socket_.get_executor()),
      wakeWriter_(socket_.get_executor()),
      received_(kReceiveBytes) {
  error_code ignored;
  socket_.set_option(tcp::no_delay(true), ignored);
  socket_.non_blocking(true, ignored);
  taken_.reserve(kUsualStretches);
  queue_.reserve(kUsualStretches);
  spare_.reserve(kUsualStretches);
  // One is written while the next fills: whether that ever happens, and when, is a matter of timing.
  for (int i = 0; i < 3; ++i)
    spare_.emplace_back().reserve(kSmallStretchBytes);
}

void Connection::guard(Watch& watch, Milliseconds deadline) {
  if (!socket_.is_open()) return;  // whatever is tried fails at once
  watch.due = Clock::now() + deadline;
  if (watch.due < watch.firesAt) setTimer(watch);
}

void Connection::setTimer(Watch& watch) {
  watch.firesAt = watch.due;
  watch.timer.expires_at(watch.due);
  watch.timer.async_wait([weak = weak_from_this(), &watch, mine = watch.due](const error_code& ec) {
    const auto self = weak.lock();
    if (ec || !self || watch.firesAt != mine) return;
    watch.firesAt = Clock::time_point::max();
    if (watch.due == Clock::time_point::max()) return;
    if (Clock::now() < watch.due) return self->setTimer(watch);
    self->timedOut_ = true;
    self->closeNow();
  });
}

awaitable<error_code> Connection::readPayload(std::span<std::byte> bytes, Milliseconds deadline,
                                              std::uint32_t& crc32c) {
  error_code ec, ignored;
  std::size_t wakesAt = 1;
  const auto wakeAt = [&](std::size_t count) {
    if (count == wakesAt) return;
    wakesAt = count;
    socket_.set_option(asio::socket_base::receive_low_watermark(static_cast<int>(count)), ignored);
  };
  while (!bytes.empty()) {
    // What is there is taken at once; a composed operation would do so in small pieces.
    const std::size_t got =
        socket_.read_some(asio::buffer(bytes.data(), std::min(bytes.size(), kReadBytes)), ec);
    if (ec == asio::error::would_block || ec == asio::error::try_again) {
      if (reading_.due == Clock::time_point::max()) guard(reading_, deadline);
      ec = {};
      wakeAt(std::min(bytes.size(), kWakeBytes));
      co_await socket_.async_wait(tcp::socket::wait_read, asio::redirect_error(asio::use_awaitable, ec));
    }
    if (ec) break;
    crc32c = proto::crc32c(bytes.first(got), crc32c);
    bytes = bytes.subspan(got);
  }
  reading_.due = Clock::time_point::max();
  wakeAt(1);
  co_return ec;
}

awaitable<error_code> Connection::receive(std::size_t count, Milliseconds deadline) {
  std::copy(received_.begin() + static_cast<std::ptrdiff_t>(receivedBegin_),
            received_.begin() + static_cast<std::ptrdiff_t>(receivedEnd_), received_.begin());
  receivedEnd_ -= receivedBegin_;
  receivedBegin_ = 0;
  error_code ec;
  guard(reading_, deadline);
  while (!ec && receivedEnd_ < count) {
    receivedEnd_ += co_await socket_.async_read_some(
        asio::buffer(received_.data() + receivedEnd_, received_.size() - receivedEnd_),
        asio::redirect_error(asio::use_awaitable, ec));
  }
  reading_.due = Clock::time_point::max();
  co_return ec;
}

awaitable<Result<Message>> Connection::read(proto::Expect expect, Milliseconds deadline) {
  Message message;
  if (Status status = co_await readInto(message, expect, deadline); !status) co_return status.error();
  co_return message;
}

awaitable<Status> Connection::readInto(Message& message, proto::Expect expect, Milliseconds deadline) {
  const auto self = shared_from_this();
  if (receivedEnd_ - receivedBegin_ < proto::kHeaderBytes) {
    if (const error_code ec = co_await receive(proto::kHeaderBytes, deadline))
      co_return failure(ec, "waiting for a message");
  }
  auto header =
      proto::parseHeader(std::span(received_).subspan(receivedBegin_).first<proto::kHeaderBytes>(), expect);
  if (!header) co_return Error{ErrorKind::Runtime, peer_, header.error().what, header.error().mend};
  receivedBegin_ += proto::kHeaderBytes;

  message.type = header->type;
  const auto here = std::span(received_).subspan(
      receivedBegin_, std::min<std::size_t>(receivedEnd_ - receivedBegin_, header->payloadBytes));
  message.payload.resize(here.size());
  std::copy(here.begin(), here.end(), message.payload.begin());
  receivedBegin_ += here.size();
  std::uint32_t crc32c = proto::crc32c(message.payload);
  while (message.payload.size() < header->payloadBytes) {
    const std::size_t had = message.payload.size();
    message.payload.resize(std::min<std::size_t>(header->payloadBytes, had + kStretchBytes));
    const auto stretch = std::span(message.payload).subspan(had);
    if (const error_code ec = co_await readPayload(stretch, deadline, crc32c))
      co_return failure(ec, "in the middle of a message");
    // However fast the bytes come, others have their turn.
    if (message.payload.size() < header->payloadBytes)
      co_await asio::post(socket_.get_executor(), asio::use_awaitable);
  }
  if (Status status = proto::checkPayload(*header, message.payload.size(), crc32c); !status)
    co_return Error{ErrorKind::Runtime, peer_, status.error().what, status.error().mend};
  co_return Done{};
}

void Connection::startWriter(Milliseconds deadline) {
  asio::co_spawn(socket_.get_executor(), writeQueued(shared_from_this(), deadline), asio::detached);
}

// `self` keeps the connection alive while it writes.
awaitable<void> Connection::writeQueued([[maybe_unused]] std::shared_ptr<Connection> self,
                                        Milliseconds deadline) {
  while (socket_.is_open()) {
    const Taken taken = takeQueued();
    if (taken == Taken::NothingEver) break;
    if (taken == Taken::Nothing) {
      error_code ignored;
      wakeWriter_.expires_at(Clock::time_point::max());
      co_await wakeWriter_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
      continue;
    }
    for (const Stretch& stretch : taken_) {
      const SharedBytes whole = stretch.make ? stretch.make() : stretch.shared;
      const std::span<const std::byte> bytes = whole ? *whole : stretch.bytes;
      if (co_await write(bytes, deadline)) {
        closeNow();
        co_return;
      }
    }
  }
  closeNow();
}

awaitable<error_code> Connection::write(std::span<const std::byte> bytes, Milliseconds deadline) {
  error_code ec;
  std::size_t sinceStart = 0;  // of the stretch that the deadline is for
  while (!bytes.empty()) {
    // What fits into the socket's buffer is written at once; a composed operation would do so in small
    // pieces.
    const std::size_t sent = socket_.write_some(
        asio::buffer(bytes.data(), std::min(kStretchBytes - sinceStart, bytes.size())), ec);
    if (ec == asio::error::would_block || ec == asio::error::try_again) {
      if (writing_.due == Clock::time_point::max()) guard(writing_, deadline);
      ec = {};
      co_await socket_.async_wait(tcp::socket::wait_write, asio::redirect_error(asio::use_awaitable, ec));
    }
    if (ec) break;
    bytes = bytes.subspan(sent);
    sinceStart += sent;
    if (sinceStart < kStretchBytes) continue;
    sinceStart = 0;
    writing_.due = Clock::time_point::max();
    if (!bytes.empty()) co_await asio::post(socket_.get_executor(), asio::use_awaitable);
  }
  writing_.due = Clock::time_point::max();
  co_return ec;
}

Connection::Taken Connection::takeQueued() {
  const std::lock_guard lock(mutex_);
  for (Stretch& written : taken_) {
    const bool isWorthKeeping = written.bytes.capacity() > 0 && written.bytes.capacity() <= kStretchBytes;
    if (!isWorthKeeping || spare_.size() == kUsualStretches) continue;
    written.bytes.clear();
    spare_.push_back(std::move(written.bytes));
  }
  taken_.clear();
  std::swap(queue_, taken_);
  queuedMessages_ = 0;
  if (!taken_.empty()) return Taken::Something;
  writerSleeps_ = !closing_;
  return closing_ ? Taken::NothingEver : Taken::Nothing;
}

void Connection::wakeWriter() {
  {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(writerSleeps_, false)) return;
  }
  // The writer looks at the queue before it waits and is woken on its own thread, so no wake-up is lost.
  asio::dispatch(socket_.get_executor(), [self = shared_from_this()] { self->wakeWriter_.cancel(); });
}

bool Connection::mayQueue() {
  if (closing_) return false;
  if (++queuedMessages_ <= kMaxQueuedMessages) return true;
  closing_ = true;
  queue_.clear();
  return false;
}

void Connection::queue(LazyBytes message) {
  const std::lock_guard lock(mutex_);
  if (mayQueue()) queue_.push_back({.make = std::move(message)});
}

void Connection::queue(SharedBytes message) {
  const std::lock_guard lock(mutex_);
  if (mayQueue()) queue_.push_back({.shared = std::move(message)});
}

void Connection::queue(std::span<const std::byte> message) {
  const std::lock_guard lock(mutex_);
  if (!mayQueue()) return;
  const bool fits = !queue_.empty() && !queue_.back().make && !queue_.back().shared &&
                    queue_.back().bytes.size() + message.size() <= queue_.back().bytes.capacity();
  if (!fits) {
    Stretch& stretch = queue_.emplace_back();
    if (!spare_.empty()) {
      stretch.bytes = std::move(spare_.back());
      spare_.pop_back();
    }
    // Generous and in few sizes: buffers change their places, and all shall soon be large enough.
    stretch.bytes.reserve(std::max(kSmallStretchBytes, std::bit_ceil(message.size())));
  }
  proto::Bytes& bytes = queue_.back().bytes;
  bytes.insert(bytes.end(), message.begin(), message.end());
}

void Connection::flush() {
  {
    const std::lock_guard lock(mutex_);
    if (queuedMessages_ == 0 || !std::exchange(writerSleeps_, false)) return;
  }
  wakeWriter_.cancel();
}

void Connection::send(LazyBytes message) {
  queue(std::move(message));
  wakeWriter();
}

void Connection::send(SharedBytes message) {
  queue(std::move(message));
  wakeWriter();
}

void Connection::send(proto::Bytes message) {
  if (message.size() <= kSmallStretchBytes) return send(std::span<const std::byte>(message));
  {
    const std::lock_guard lock(mutex_);
    if (mayQueue()) queue_.push_back({.bytes = std::move(message)});
  }
  wakeWriter();
}

void Connection::send(std::span<const std::byte> message) {
  queue(message);
  wakeWriter();
}

void Connection::closeAfterSending() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wakeWriter();
}

void Connection::close() {
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->closeNow(); });
}

void Connection::closeNow() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;  // what is sent from now on has nowhere to go
    queue_.clear();
  }
  // A timer that is set would keep the io context running.
  reading_.timer.cancel();
  writing_.timer.cancel();
  error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
  wakeWriter_.cancel();
}

Error Connection::failure(const error_code& ec, const char* doing) const {
  if (timedOut_) return runtimeError(peer_, std::string("no answer within the deadline, ") + doing);
  if (ec == asio::error::eof || ec == asio::error::connection_reset) {
    return runtimeError(peer_, std::string("the connection was closed by the other side, ") + doing);
  }
  if (ec == asio::error::operation_aborted || ec == asio::error::bad_descriptor) {
    return runtimeError(peer_, "the connection was closed");
  }
  return runtimeError(peer_, ec.message() + ", " + doing);
}

Result<HostPort> parseHostPort(const std::string& text) {
  const auto wrong = [&] {
    return inputError(text, "is not an address of the form HOST:PORT",
                      "for example 192.168.1.10:7400 or [::1]:7400");
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || colon == 0) return wrong();
  HostPort parsed{text.substr(0, colon), text.substr(colon + 1)};
  if (parsed.host.front() == '[' && parsed.host.back() == ']')
    parsed.host = parsed.host.substr(1, parsed.host.size() - 2);
  const bool digits =
      !parsed.port.empty() && std::all_of(parsed.port.begin(), parsed.port.end(),
                                          [](unsigned char c) { return c >= '0' && c <= '9'; });
  if (!digits || parsed.port.size() > 5 || std::stoi(parsed.port) > 65535 || parsed.host.empty())
    return wrong();
  return parsed;
}

awaitable<Result<std::shared_ptr<Connection>>> connect(const HostPort& to, Milliseconds deadline) {
  const auto executor = co_await asio::this_coro::executor;
  const std::string name = to.host + ":" + to.port;
  tcp::resolver resolver(executor);
  auto socket = std::make_shared<tcp::socket>(executor);
  asio::steady_timer timer(executor, deadline);
  const auto late = std::make_shared<bool>(false);
  timer.async_wait(
      [&resolver, weak = std::weak_ptr(socket), weakLate = std::weak_ptr(late)](const error_code& ec) {
        const auto isLate = weakLate.lock();
        if (ec || !isLate) return;
        *isLate = true;
        resolver.cancel();
        error_code ignored;
        if (const auto open = weak.lock()) open->close(ignored);
      });
  error_code ec;
  const auto endpoints =
      co_await resolver.async_resolve(to.host, to.port, asio::redirect_error(asio::use_awaitable, ec));
  if (!ec) co_await asio::async_connect(*socket, endpoints, asio::redirect_error(asio::use_awaitable, ec));
  timer.cancel();
  if (*late) co_return runtimeError(name, "no answer within " + std::to_string(deadline.count()) + " ms");
  if (ec) co_return runtimeError(name, "cannot connect: " + ec.message(), "is the master running there?");
  co_return std::make_shared<Connection>(std::move(*socket));
}

Result<tcp::acceptor> listen(asio::io_context& io, const HostPort& at) {
  const std::string name = at.host + ":" + at.port;
  error_code ec;
  tcp::resolver resolver(io);
  const auto found = resolver.resolve(at.host, at.port, tcp::resolver::passive, ec);
  if (ec || found.empty()) return inputError(name, "is no address to listen on: " + ec.message());
  tcp::acceptor acceptor(io);
  const tcp::endpoint endpoint = found.begin()->endpoint();
  acceptor.open(endpoint.protocol(), ec);
  if (!ec) acceptor.set_option(tcp::acceptor::reuse_address(true), ec);
  if (!ec) acceptor.bind(endpoint, ec);
  if (!ec) acceptor.listen(asio::socket_base::max_listen_connections, ec);
  if (ec == asio::error::address_in_use) {
    return inputError(name, "the port is in use",
                      "choose another with --listen, or stop the program that holds it");
  }
  if (ec) return inputError(name, "cannot listen: " + ec.message());
  return acceptor;
}

}  // namespace tessera::net
