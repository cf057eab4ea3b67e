#pragma once

#include <filesystem>

#include "common/base/result.h"
#include "common/scene/imported_graph.h"

namespace tessera {

/// Reads a glTF 2.0 file, .gltf or .glb (told apart by content), with the files it names in its own folder.
///
/// One osg::Group per glTF node, a MatrixTransform where the node moves; below it first the node's primitives
/// as osg::Geometry, then its child nodes. Meshes used twice share their Geometry objects, equal materials
/// their StateSet. Local coordinates, y up. The bytes are not trusted: every reference and every element is
/// checked before it is read. A scene that draws nothing is no error here.
[[nodiscard]] Result<ImportedGraph> importGltf(const std::filesystem::path& path);

}  // namespace tessera
