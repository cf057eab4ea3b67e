#include "common/scene/osg_import.h"

#include <exception>
#include <new>
#include <set>
#include <string>
#include <utility>

#include <osg/MatrixTransform>
#include <osgDB/FileNameUtils>
#include <osgDB/FileUtils>
#include <osgDB/ReadFile>
#include <osgDB/Registry>

namespace tessera {

namespace {

/// Notes which files a reader looks for beside the one that it was given, and hands out none but those in the
/// scene's folder or below it: a scene must not be able to show, or to ask the network for, anything else.
class FilesOfScene : public osgDB::FindFileCallback, public osgDB::ReadFileCallback {
 public:
  FilesOfScene(std::filesystem::path scene, std::filesystem::path folder,
               std::set<std::filesystem::path>& files)
      : scene_(std::move(scene)), folder_(std::move(folder)), files_(files) {}

  std::string findDataFile(const std::string& name, const osgDB::Options* options,
                           osgDB::CaseSensitivity sensitivity) override {
    if (osgDB::containsServerAddress(name)) return {};
    std::string found = osgDB::Registry::instance()->findDataFileImplementation(name, options, sensitivity);
    // The scene itself may be a link that the user made.
    if (!found.empty() && found != scene_ && !isInFolder(found)) return {};
    files_.insert(found.empty() ? folder_ / name : std::filesystem::path(found));
    return found;
  }

  osgDB::ReaderWriter::ReadResult readImage(const std::string& name, const osgDB::Options* options) override {
    if (osgDB::containsServerAddress(name)) return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
    return osgDB::ReadFileCallback::readImage(name, options);
  }
  osgDB::ReaderWriter::ReadResult readNode(const std::string& name, const osgDB::Options* options) override {
    if (osgDB::containsServerAddress(name)) return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
    return osgDB::ReadFileCallback::readNode(name, options);
  }
  osgDB::ReaderWriter::ReadResult readObject(const std::string& name,
                                             const osgDB::Options* options) override {
    if (osgDB::containsServerAddress(name)) return osgDB::ReaderWriter::ReadResult::FILE_NOT_FOUND;
    return osgDB::ReadFileCallback::readObject(name, options);
  }

 private:
  [[nodiscard]] bool isInFolder(const std::filesystem::path& path) const {
    std::error_code ec;
    const auto real = std::filesystem::weakly_canonical(path, ec);
    const auto folder = std::filesystem::weakly_canonical(folder_, ec);
    const auto relative = real.lexically_relative(folder);
    return !ec && !relative.empty() && *relative.begin() != "..";
  }

  const std::filesystem::path scene_, folder_;
  std::set<std::filesystem::path>& files_;
};

/// Registers the callbacks for as long as it lives: plugins that find files by themselves ask the registry.
class RegisteredFiles {
 public:
  explicit RegisteredFiles(osg::ref_ptr<FilesOfScene> files) {
    osgDB::Registry::instance()->setFindFileCallback(files);
    osgDB::Registry::instance()->setReadFileCallback(files);
  }
  ~RegisteredFiles() {
    osgDB::Registry::instance()->setFindFileCallback(nullptr);
    osgDB::Registry::instance()->setReadFileCallback(nullptr);
  }
  RegisteredFiles(const RegisteredFiles&) = delete;
  RegisteredFiles& operator=(const RegisteredFiles&) = delete;
};

}  // namespace

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
  ImportedGraph graph;
  const RegisteredFiles registered(new FilesOfScene(path, folder, graph.files));
  osg::ref_ptr<osg::Node> node;
  std::string why;
  try {
    osgDB::ReaderWriter::ReadResult read =
        osgDB::Registry::instance()->readNode(path.string(), options, false);
    node = read.getNode();
    why = read.message();
  } catch (const std::bad_alloc&) {
    return runtimeError(path.string(), "needs more memory than there is", "is it complete and of that kind?");
  } catch (const std::exception& e) {  // Readers take sizes from the file: vector and string throw.
    why = e.what();
  }
  if (!node) {
    return inputError(path.string(), "cannot be read as ." + extension + (why.empty() ? "" : ": " + why),
                      "is it complete and of that kind?");
  }
  graph.files.erase(path);
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
