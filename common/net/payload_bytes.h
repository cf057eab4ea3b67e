#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace tessera::net {

/// Leaves elements that a vector is resized to as they are: they are received into, and zeros would be
/// written for nothing.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetAllocator<U>;
  };
  template <class U>
  void construct(U* at) {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Arguments>
  void construct(U* at, Arguments&&... arguments) {
    ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
  }
};

using PayloadBytes = std::vector<std::byte, UnsetAllocator<std::byte>>;

}  // namespace tessera::net
