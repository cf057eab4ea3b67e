#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <functional>
#include <new>

#include "common/net/asio.h"

namespace tessera::net {

/// Has one function run on an io context's thread, as often as somebody asks, without allocating: the post
/// lies in memory of its own. Asking again before the function runs changes nothing. Must outlive the io
/// context.
class OnePost {
 public:
  explicit OnePost(std::function<void()> run) : run_(std::move(run)) {}
  OnePost(const OnePost&) = delete;
  OnePost& operator=(const OnePost&) = delete;

  /// Thread-safe. What the caller did before is seen by the function.
  void post(asio::io_context& io) {
    if (!posted_.exchange(true)) asio::post(io, Handler{this});
  }

 private:
  static constexpr std::size_t kRoomBytes = 256;

  /// Gives out the one piece of memory, for the one handler that there is at a time.
  template <class T>
  struct Allocator {
    using value_type = T;
    OnePost* owner;
    explicit Allocator(OnePost* of) noexcept : owner(of) {}
    template <class U>
    Allocator(const Allocator<U>& other) noexcept : owner(other.owner) {}
    T* allocate(std::size_t count) {
      if (count * sizeof(T) > kRoomBytes) return static_cast<T*>(::operator new(count * sizeof(T)));
      return reinterpret_cast<T*>(owner->room_.data());
    }
    void deallocate(T* memory, std::size_t) noexcept {
      if (reinterpret_cast<std::byte*>(memory) != owner->room_.data()) ::operator delete(memory);
    }
    template <class U>
    bool operator==(const Allocator<U>& other) const noexcept {
      return owner == other.owner;
    }
  };

  struct Handler {
    using allocator_type = Allocator<std::byte>;
    OnePost* owner;
    [[nodiscard]] allocator_type get_allocator() const noexcept { return allocator_type(owner); }
    void operator()() const {
      owner->posted_ = false;  // Asio has given the memory back before it calls
      owner->run_();
    }
  };

  std::function<void()> run_;
  std::atomic<bool> posted_{false};
  alignas(std::max_align_t) std::array<std::byte, kRoomBytes> room_{};
};

}  // namespace tessera::net
