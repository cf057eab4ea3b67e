#pragma once

#include <cstddef>
#include <vector>

namespace tessera {

/// Values in the order in which they came: all of them or, where that would grow without end, the last few.
template <class T>
struct Recorded {
  std::vector<T> values;  ///< once full with a limit: rotated
  std::size_t limit = 0;  ///< 0: none
  std::size_t oldest = 0;

  /// The last `most` (> 0) from now on, in memory that is taken at once.
  void keepLast(std::size_t most) {
    limit = most;
    values.reserve(most);
  }
  void add(const T& value) {
    if (limit == 0 || values.size() < limit) {
      values.push_back(value);
      return;
    }
    values[oldest] = value;
    oldest = (oldest + 1) % limit;
  }
};

}  // namespace tessera
