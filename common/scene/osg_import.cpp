#include "common/scene/osg_import.h"

#include <osg/MatrixTransform>
#include <osgDB/FileNameUtils>
#include <osgDB/ReadFile>
#include <osgDB/Registry>

namespace tessera {

Result<ImportedGraph> importOsg(const std::filesystem::path& path, bool isZUp) {
  std::error_code ec;
  if (!std::filesystem::exists(path, ec)) return inputError(path.string(), "no such file", "check the path");
  if (!std::filesystem::is_regular_file(path, ec)) return inputError(path.string(), "is not a file");
  if (std::filesystem::file_size(path, ec) == 0) return inputError(path.string(), "is empty");
  const std::string extension = osgDB::getLowerCaseFileExtension(path.string());
  if (!osgDB::Registry::instance()->getReaderWriterForExtension(extension)) {
    return inputError(path.string(), "no reader for files of the kind \"." + extension + "\"",
                      "convert it to .glb, .gltf or .osgb");
  }
  osg::ref_ptr<osgDB::Options> options = new osgDB::Options;
  // Textures are looked for beside the file and in the folder that OpenSceneGraph's own data uses.
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  options->getDatabasePathList() = {folder.string(), (folder / "Images").string(),
                                    (folder / "images").string(), (folder / "textures").string()};
  options->setObjectCacheHint(osgDB::Options::CACHE_NONE);
  osgDB::ReaderWriter::ReadResult read = osgDB::Registry::instance()->readNode(path.string(), options, false);
  osg::ref_ptr<osg::Node> node = read.getNode();
  if (!node) {
    const std::string why = read.message();
    return inputError(path.string(), "cannot be read as ." + extension + (why.empty() ? "" : ": " + why),
                      "is it complete and of that kind?");
  }
  ImportedGraph graph;
  osg::ref_ptr<osg::MatrixTransform> turn = new osg::MatrixTransform;
  // Exactly (x, y, z) -> (x, z, -y); osg::Matrix::rotate would leave cosines of 1e-17.
  if (isZUp) turn->setMatrix(osg::Matrixd(1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1));
  turn->setName("root");
  turn->addChild(node);
  graph.root = turn;
  if (isZUp)
    graph.warnings.emplace_back(
        "taken as z up, as OpenSceneGraph's formats are, and turned to y up; --up y leaves it");
  return graph;
}

}  // namespace tessera
