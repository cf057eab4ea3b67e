#pragma once

#include <cstdint>

#include "common/scene/synthetic/shapes.h"

// The stone shapes' part of shapes.h; only shapes.cpp includes this.
namespace tessera::synthetic {

[[nodiscard]] std::uint64_t count(const ArchBay& bay, const Detail& detail);
[[nodiscard]] std::uint64_t count(const Jali& jali, const Detail& detail);
[[nodiscard]] std::uint64_t count(const Stairs& stairs, const Detail& detail);
void emit(const ArchBay& bay, const Detail& detail, MeshWriter& out);
void emit(const Jali& jali, const Detail& detail, MeshWriter& out);
void emit(const Stairs& stairs, const Detail& detail, MeshWriter& out);

}  // namespace tessera::synthetic
