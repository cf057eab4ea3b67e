#pragma once

// Boost 1.74's coroutine headers use std::exchange without including it.
#include <utility>

#include <boost/asio.hpp>

namespace tessera::net {

namespace asio = boost::asio;
using asio::awaitable;
using asio::ip::tcp;
using boost::system::error_code;
using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::milliseconds;

}  // namespace tessera::net
