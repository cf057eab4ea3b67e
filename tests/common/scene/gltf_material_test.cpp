#include <cmath>

#include <gtest/gtest.h>
#include <osg/AlphaFunc>
#include <osg/BlendFunc>
#include <osg/CullFace>
#include <osg/LightModel>
#include <osg/Texture2D>

#include "common/scene/gltf/import_gltf.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

using nlohmann::json;

// ---- materials and textures

const osg::Texture2D* textureOf(const osg::Geometry& g) {
  return dynamic_cast<const osg::Texture2D*>(
      g.getStateSet()->getTextureAttribute(0, osg::StateAttribute::TEXTURE));
}

osg::Vec2f texCoordOf(const osg::Geometry& g, std::size_t vertex) {
  return dynamic_cast<const osg::Vec2Array&>(*g.getTexCoordArray(0))[vertex];
}

TEST(GltfTextures, keepCoordinatesAndTopRowFirst) {
  const auto graph = texturedFile().import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_TRUE(graph->warnings.empty());
  const osg::Geometry& g = *leafAt(*graph);
  EXPECT_EQ(texCoordOf(g, 2), osg::Vec2f(0, 0.5F));
  const osg::Texture2D* texture = textureOf(g);
  ASSERT_NE(texture, nullptr);
  const osg::Image* image = texture->getImage();
  EXPECT_EQ(image->getName(), "squares");
  EXPECT_EQ(image->getPixelFormat(), static_cast<GLenum>(GL_RGBA));
  // OpenGL finds row 0 at t = 0, glTF the top row at v = 0.
  EXPECT_EQ(std::vector<unsigned char>(image->data(0, 0), image->data(0, 0) + 4),
            (std::vector<unsigned char>{255, 0, 0, 255}));
  EXPECT_EQ(std::vector<unsigned char>(image->data(0, 1), image->data(0, 1) + 4),
            (std::vector<unsigned char>{0, 0, 255, 255}));
  EXPECT_EQ(texture->getWrap(osg::Texture::WRAP_S), osg::Texture::REPEAT);
  EXPECT_EQ(texture->getFilter(osg::Texture::MIN_FILTER), osg::Texture::LINEAR_MIPMAP_LINEAR);
  EXPECT_EQ(texture->getFilter(osg::Texture::MAG_FILTER), osg::Texture::LINEAR);
}

TEST(GltfTextures, followTheirSampler) {
  GltfBuilder file = texturedFile();
  file.json["textures"][0]["sampler"] = 0;
  file.add("samplers", {{"wrapS", 33071}, {"wrapT", 33648}, {"minFilter", 9728}, {"magFilter", 9728}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Texture2D* texture = textureOf(*leafAt(*graph));
  EXPECT_EQ(texture->getWrap(osg::Texture::WRAP_S), osg::Texture::CLAMP_TO_EDGE);
  EXPECT_EQ(texture->getWrap(osg::Texture::WRAP_T), osg::Texture::MIRROR);
  EXPECT_EQ(texture->getFilter(osg::Texture::MIN_FILTER), osg::Texture::NEAREST);
  EXPECT_EQ(texture->getFilter(osg::Texture::MAG_FILTER), osg::Texture::NEAREST);
}

TEST(GltfTextures, applyTextureTransforms) {
  GltfBuilder file = texturedFile();
  file.json["extensionsUsed"] = {"KHR_texture_transform"};
  file.json["extensionsRequired"] = {"KHR_texture_transform"};
  json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_1"] =
      file.accessor(std::vector<std::uint8_t>{0, 0, 255, 0, 0, 255}, "VEC2", kUByte, true);
  json& info = file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  // The example of the extension: the lower left quadrant, turned clockwise by 90 degrees.
  info["extensions"]["KHR_texture_transform"] = {
      {"offset", {0, 1}}, {"rotation", std::acos(0.0)}, {"scale", {0.5, 0.5}}, {"texCoord", 1}};
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::Geometry& g = *leafAt(*graph);
  EXPECT_NEAR((texCoordOf(g, 0) - osg::Vec2f(0, 1)).length(), 0, 1e-6);
  EXPECT_NEAR((texCoordOf(g, 1) - osg::Vec2f(0, 0.5F)).length(), 0, 1e-6);
  EXPECT_NEAR((texCoordOf(g, 2) - osg::Vec2f(0.5F, 1)).length(), 0, 1e-6);
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"]
           ["offset"] = {1, 2, 3};
  EXPECT_NE(errorOf(file.import()).find("material 0 has a malformed KHR_texture_transform"),
            std::string::npos);
}

TEST(GltfTextures, fallBackToTheBaseColour) {
  const std::vector<std::pair<json, std::string>> cases = {
      {{{"uri", "missing.png"}}, "missing.png"},
      {{{"uri", "../outside.png"}}, "leads out"},
      {{{"uri", "https://example.org/a.png"}}, "is not a file"},
      {{{"uri", "data:image/png;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"}}, "neither PNG nor JPEG"},
      {{{"uri", std::string(kPictureUri).substr(0, 90)}}, "cannot be decoded"},
      {{{"bufferView", 0}, {"mimeType", "image/png"}}, "neither PNG nor JPEG"},
  };
  for (const auto& [image, part] : cases) {
    GltfBuilder file = texturedFile();
    file.json["images"][0] = image;
    const auto graph = file.import();
    ASSERT_TRUE(graph) << errorOf(graph);
    EXPECT_TRUE(warns(*graph, part)) << (graph->warnings.empty() ? part : graph->warnings[0]);
    EXPECT_EQ(textureOf(*leafAt(*graph)), nullptr);
    EXPECT_EQ(overallColor(*leafAt(*graph)), osg::Vec4ub(255, 255, 255, 255));
  }
}

TEST(GltfTextures, readImagesFromFilesAndBufferViews) {
  // The bytes of the picture, by way of an importer that has them.
  const std::string base64 = std::string(kPictureUri).substr(22);
  std::string picture;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : base64) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    if (c == '=') break;
    bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
    have += 6;
    if (have >= 8) picture.push_back(static_cast<char>(bits >> (have -= 8) & 0xFF));
  }
  GltfBuilder file = texturedFile();
  file.json["images"][0] = {{"bufferView", file.view(std::vector<char>(picture.begin(), picture.end()))},
                            {"mimeType", "image/png"}};
  auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  ASSERT_NE(textureOf(*leafAt(*graph)), nullptr) << graph->warnings.at(0);

  const TempFolder folder;
  folder.write("a picture+.png", picture);
  file.json["images"][0] = {{"uri", "a%20picture+.png"}};
  graph = importGltf(folder.write("scene.glb", file.glb()));
  ASSERT_TRUE(graph) << errorOf(graph);
  ASSERT_NE(textureOf(*leafAt(*graph)), nullptr) << graph->warnings.at(0);
  EXPECT_EQ(textureOf(*leafAt(*graph))->getImage()->data()[0], 255);
}

TEST(GltfTextures, withoutCoordinatesAreLeftOut) {
  GltfBuilder file = texturedFile();
  file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_TRUE(warns(*graph, "has no TEXCOORD_1"));
  EXPECT_EQ(textureOf(*leafAt(*graph)), nullptr);
}

TEST(GltfMaterials, setAlphaModesAndSides) {
  using Attribute = osg::StateAttribute;
  GltfBuilder file = triangleFile();
  file.json["meshes"][0]["primitives"][0]["material"] = 0;
  file.add("materials", {{"alphaMode", "MASK"}, {"alphaCutoff", 0.25}});
  auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::StateSet* states = leafAt(*graph)->getStateSet();
  const auto* alpha = dynamic_cast<const osg::AlphaFunc*>(states->getAttribute(Attribute::ALPHAFUNC));
  ASSERT_NE(alpha, nullptr);
  EXPECT_EQ(alpha->getFunction(), osg::AlphaFunc::GEQUAL);
  EXPECT_EQ(alpha->getReferenceValue(), 0.25F);
  EXPECT_EQ(states->getMode(GL_ALPHA_TEST), Attribute::ON);
  EXPECT_EQ(states->getMode(GL_CULL_FACE), Attribute::ON);
  EXPECT_EQ(states->getAttribute(Attribute::LIGHTMODEL), nullptr);

  file.json["materials"][0] = {{"alphaMode", "BLEND"}, {"doubleSided", true}};
  graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  states = leafAt(*graph)->getStateSet();
  EXPECT_EQ(states->getMode(GL_BLEND), Attribute::ON);
  EXPECT_EQ(states->getRenderingHint(), osg::StateSet::TRANSPARENT_BIN);
  EXPECT_EQ(states->getAttribute(Attribute::CULLFACE), nullptr);
  EXPECT_NE(states->getMode(GL_CULL_FACE), Attribute::ON);
  const auto* light = dynamic_cast<const osg::LightModel*>(states->getAttribute(Attribute::LIGHTMODEL));
  ASSERT_NE(light, nullptr);
  EXPECT_TRUE(light->getTwoSided());
}

TEST(GltfMaterials, shareStateSetsAndKnowTheirExtensions) {
  GltfBuilder file = triangleFile();
  file.json["extensionsRequired"] = {"KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness"};
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"material", 0}});
  file.addPrimitive({{"attributes", {{"POSITION", 0}}}, {"material", 0}});
  file.add("materials", {{"extensions",
                          {{"KHR_materials_unlit", json::object()},
                           {"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0, 1, 0, 1}}}}}}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  const osg::StateSet* states = leafAt(*graph, 1)->getStateSet();
  EXPECT_EQ(states, leafAt(*graph, 2)->getStateSet());
  EXPECT_NE(states, leafAt(*graph, 0)->getStateSet());
  EXPECT_EQ(states->getMode(GL_LIGHTING), osg::StateAttribute::OFF);
  EXPECT_EQ(overallColor(*leafAt(*graph, 1)), osg::Vec4ub(0, 255, 0, 255));
}

}  // namespace
}  // namespace tessera::test
