#include "common/scene/gltf/import_gltf.h"

#include <algorithm>
#include <array>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include "common/scene/gltf/geometry.h"
#include "common/scene/gltf/load_document.h"
#include "common/scene/gltf/node_tree.h"
#include "common/scene/gltf/warnings.h"

namespace tessera {

namespace {

using gltf::Document;
using gltf::Warnings;

struct GeometryExtension {
  std::string_view name;
  std::string_view effect;
};

/// Extensions that a file may use without requiring them, and that change what is to be seen.
constexpr std::array kGeometryExtensions = {
    GeometryExtension{"EXT_mesh_gpu_instancing", "one copy of each instanced mesh is drawn"},
    GeometryExtension{"KHR_draco_mesh_compression", "the uncompressed copy in the file is drawn"},
    GeometryExtension{"EXT_meshopt_compression", "the uncompressed copy in the file is drawn"},
    GeometryExtension{"KHR_meshopt_compression", "the uncompressed copy in the file is drawn"},
    GeometryExtension{"MSFT_lod", "the finest level of detail is drawn"},
};

void warnOfWhatIsNotShown(const Document& document, Warnings& warnings) {
  for (const GeometryExtension& extension : kGeometryExtensions) {
    const auto& used = document.extensionsUsed;
    if (std::find(used.begin(), used.end(), extension.name) == used.end()) continue;
    warnings.add(extension.name, "the extension " + std::string(extension.name) + " is not supported; " +
                                     std::string(extension.effect));
  }
}

Result<ImportedGraph> import(const std::filesystem::path& path) {
  Result<Document> document = gltf::loadDocument(path);
  if (!document) return document.error();
  Warnings warnings;
  warnOfWhatIsNotShown(*document, warnings);
  gltf::Geometries geometries(*document, warnings);
  ImportedGraph graph;
  const Status status = gltf::buildNodes(*document, geometries, warnings, graph);
  if (!status) return status.error();
  graph.warnings = warnings.sentences();
  graph.files = std::move(document->files);
  return graph;
}

}  // namespace

Result<ImportedGraph> importGltf(const std::filesystem::path& path) {
  Error error;
  try {
    Result<ImportedGraph> graph = import(path);
    if (graph) return graph;
    error = graph.error();
  } catch (const std::bad_alloc&) {
    error = runtimeError({}, "needs more memory than it may have",
                         "give it more with --import-memory, or split it");
  }
  error.where = path.string();
  return error;
}

}  // namespace tessera
