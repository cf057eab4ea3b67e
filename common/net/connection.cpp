#include "common/net/connection.h"

#include <algorithm>
#include <span>

namespace tessera::net {

namespace {

constexpr std::size_t kStretchBytes = 1 << 20;

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
      readTimer_(socket_.get_executor()),
      writeTimer_(socket_.get_executor()),
      wakeWriter_(socket_.get_executor()) {
  error_code ignored;
  socket_.set_option(tcp::no_delay(true), ignored);
}

void Connection::guard(asio::steady_timer& timer, std::uint64_t& operation, Milliseconds deadline) {
  const std::uint64_t mine = ++operation;
  timer.expires_after(deadline);
  // The count tells a timer that fired just as its operation ended from one that is due.
  timer.async_wait([weak = weak_from_this(), &operation, mine](const error_code& ec) {
    const auto self = weak.lock();
    if (ec || !self || operation != mine) return;
    self->timedOut_ = true;
    self->closeNow();
  });
}

awaitable<error_code> Connection::readExactly(std::span<std::byte> bytes, Milliseconds deadline) {
  error_code ec;
  guard(readTimer_, readOperation_, deadline);
  co_await asio::async_read(socket_, asio::buffer(bytes.data(), bytes.size()),
                            asio::redirect_error(asio::use_awaitable, ec));
  ++readOperation_;
  readTimer_.cancel();
  co_return ec;
}

awaitable<Result<Message>> Connection::read(proto::Expect expect, Milliseconds deadline) {
  const auto self = shared_from_this();
  std::array<std::byte, proto::kHeaderBytes> headerBytes;
  if (const error_code ec = co_await readExactly(headerBytes, deadline))
    co_return failure(ec, "waiting for a message");
  auto header = proto::parseHeader(headerBytes, expect);
  if (!header) co_return Error{ErrorKind::Runtime, peer_, header.error().what, header.error().mend};

  Message message;
  message.type = header->type;
  while (message.payload.size() < header->payloadBytes) {
    const std::size_t had = message.payload.size();
    message.payload.resize(std::min<std::size_t>(header->payloadBytes, had + kStretchBytes));
    const auto stretch = std::span(message.payload).subspan(had);
    if (const error_code ec = co_await readExactly(stretch, deadline))
      co_return failure(ec, "in the middle of a message");
  }
  if (Status status = proto::checkPayload(*header, message.payload); !status) {
    co_return Error{ErrorKind::Runtime, peer_, status.error().what, status.error().mend};
  }
  co_return message;
}

void Connection::startWriter(Milliseconds deadline) {
  asio::co_spawn(socket_.get_executor(), writeQueued(shared_from_this(), deadline), asio::detached);
}

// `self` keeps the connection alive while it writes.
awaitable<void> Connection::writeQueued([[maybe_unused]] std::shared_ptr<Connection> self,
                                        Milliseconds deadline) {
  while (socket_.is_open()) {
    bool last = false;
    const LazyBytes next = takeQueued(last);
    if (last) break;
    if (!next) {
      error_code ignored;
      wakeWriter_.expires_at(Clock::time_point::max());
      co_await wakeWriter_.async_wait(asio::redirect_error(asio::use_awaitable, ignored));
      continue;
    }
    const std::shared_ptr<const proto::Bytes> bytes = next();
    for (std::size_t sent = 0; bytes && sent < bytes->size();) {
      error_code ec;
      const std::size_t count = std::min(kStretchBytes, bytes->size() - sent);
      guard(writeTimer_, writeOperation_, deadline);
      co_await asio::async_write(socket_, asio::buffer(bytes->data() + sent, count),
                                 asio::redirect_error(asio::use_awaitable, ec));
      ++writeOperation_;
      writeTimer_.cancel();
      if (ec) {
        closeNow();
        co_return;
      }
      sent += count;
    }
  }
  closeNow();
}

LazyBytes Connection::takeQueued(bool& last) {
  const std::lock_guard lock(mutex_);
  last = queue_.empty() && closing_;
  if (queue_.empty()) return {};
  LazyBytes next = std::move(queue_.front());
  queue_.pop_front();
  return next;
}

void Connection::wakeWriter() {
  // The writer looks at the queue before it waits and is woken on its own thread, so no wake-up is lost.
  asio::post(socket_.get_executor(), [self = shared_from_this()] { self->wakeWriter_.cancel(); });
}

void Connection::send(LazyBytes message) {
  {
    const std::lock_guard lock(mutex_);
    if (closing_) return;
    if (queue_.size() < kMaxQueuedMessages) {
      queue_.push_back(std::move(message));
    } else {
      closing_ = true;
      queue_.clear();
    }
  }
  wakeWriter();
}

void Connection::send(proto::Bytes message) {
  send([bytes = std::make_shared<const proto::Bytes>(std::move(message))] { return bytes; });
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
