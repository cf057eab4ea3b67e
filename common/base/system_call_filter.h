#pragma once

#include <vector>

#include <linux/filter.h>

namespace tessera {

/// A seccomp filter for the calling process on this processor: it refuses (EPERM) what a program that only
/// reads and writes files, takes memory and starts threads has no use for. Empty on a processor that it was
/// not written for.
[[nodiscard]] std::vector<sock_filter> systemCallFilter();

}  // namespace tessera
