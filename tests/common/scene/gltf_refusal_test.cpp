#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "common/scene/gltf/import_gltf.h"
#include "tests/common/scene/gltf_builder.h"

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// ---- files

TEST(GltfFiles, readExternalBuffersOfTheirFolder) {
  const GltfBuilder file = triangleFile();
  const TempFolder folder;
  fs::create_directory(folder.path() / "sub dir");
  folder.write("sub dir/a+b.bin", file.bin + "more than declared");
  const auto graph = importGltf(folder.write("scene.gltf", file.jsonWithBuffer("sub%20dir/a+b.bin")));
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(figuresOf(*graph).triangles, 1U);
}

TEST(GltfFiles, refuseBuffersThatAreElsewhere) {
  const GltfBuilder file = triangleFile();
  const TempFolder folder;
  fs::create_directory(folder.path() / "in");
  const fs::path outside = folder.write("outside.bin", file.bin);
  folder.write("in/short.bin", file.bin.substr(1));
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"gone.bin", "gone.bin"},
      {"../outside.bin", "leads out"},
      {"%2e%2e/outside.bin", "leads out"},
      {"x/../../outside.bin", "leads out"},
      {outside.string(), "is an absolute path"},
      {"file://" + outside.string(), "is not a file of its folder"},
      {"http://example.org/a.bin", "is not a file of its folder"},
      {"https://example.org/a.bin", "is not a file of its folder"},
      {"short.bin", "has 35 bytes of the 36"},
      {".", "folder"},
  };
  for (const auto& [uri, part] : cases) {
    const std::string text = errorOf(importGltf(folder.write("in/scene.gltf", file.jsonWithBuffer(uri))));
    EXPECT_NE(text.find(part), std::string::npos) << uri << ": " << text;
    EXPECT_NE(text.find("scene.gltf"), std::string::npos) << text;
  }
}

TEST(GltfFiles, refuseWhatIsNoGltf) {
  const TempFolder folder;
  std::string deep;
  for (int i = 0; i < 1000000; ++i)
    deep += "[";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "is not glTF"},
      {"hello", "is not glTF"},
      {"[]", "names no glTF version"},
      {"{\"asset\":{\"version\":\"1.0\"}}", "is glTF 1.0"},
      {"{\"asset\":{\"version\":\"2.0\",\"minVersion\":\"2.1\"}}", "is glTF 2.1"},
      {"{\"asset\":{\"version\":\"2.0\"},\"nodes\":{}}", "nodes must be an array"},
      {"{\"asset\":{\"version\":\"2.0\"},\"extras\":" + deep, "deeper than"},
      {"glTF", "cut off"},
      {std::string("glTF\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 20), "GLB version 1"},
  };
  for (const auto& [bytes, part] : cases) {
    const std::string text = errorOf(importGltf(folder.write("scene.gltf", bytes)));
    EXPECT_NE(text.find(part), std::string::npos) << text.substr(0, 300);
  }
  EXPECT_NE(errorOf(importGltf(folder.path() / "nowhere.glb")).find("nowhere.glb"), std::string::npos);
}

TEST(GltfFiles, everyTruncationIsAnError) {
  GltfBuilder file = texturedFile();
  const std::string bytes = file.glb();
  const TempFolder folder;
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_FALSE(importGltf(folder.write("scene.glb", bytes.substr(0, length)))) << length;
    // The same, with a header that owns up to the shorter length: an error or a scene, never a crash.
    std::string lying = bytes.substr(0, length);
    if (length < 12) continue;
    const auto narrow = static_cast<std::uint32_t>(length);
    std::memcpy(lying.data() + 8, &narrow, sizeof narrow);
    ASSERT_FALSE(importGltf(folder.write("scene.glb", lying))) << length;
  }
  EXPECT_TRUE(importGltf(folder.write("scene.glb", bytes)));
}

TEST(GltfFiles, changedBytesNeverCrash) {
  GltfBuilder file = texturedFile();
  file.json["meshes"][0]["primitives"][0]["indices"] =
      file.accessor(std::vector<std::uint8_t>{0, 1, 2}, "SCALAR", kUByte);
  const std::string bytes = file.glb();
  const TempFolder folder;
  std::uint32_t seed = 1;
  const auto next = [&seed] { return seed = seed * 1664525U + 1013904223U, seed >> 8; };
  for (int round = 0; round < 1000; ++round) {
    std::string changed = bytes;
    for (std::uint32_t i = 0; i <= next() % 3; ++i) {
      changed[next() % changed.size()] = static_cast<char>("0123456789-.\"[]{},:e\0\xff"[next() % 22]);
    }
    const auto graph = importGltf(folder.write("scene.glb", changed));
    if (!graph) continue;
    EXPECT_LE(figuresOf(*graph).leaves, 2U);
  }
}

// ---- refusals

struct Refusal {
  std::string part;  // of the error's text
  std::function<void(GltfBuilder&)> spoil;
};

TEST(GltfRefusals, nameWhatIsWrong) {
  const auto set = [](const char* pointer, const json& value) {
    return [pointer, value](GltfBuilder& file) { file.json[json::json_pointer(pointer)] = value; };
  };
  const auto big = std::uint64_t{1} << 63;
  const auto sparse = [](const json& part) {
    return [part](GltfBuilder& file) {
      json whole = {{"count", 1},
                    {"indices", {{"bufferView", 0}, {"componentType", kUByte}}},
                    {"values", {{"bufferView", 0}}}};
      whole.merge_patch(part);
      file.json["accessors"][0]["sparse"] = whole;
    };
  };
  const std::vector<Refusal> refusals = {
      {"accessor 0 has more elements", set("/accessors/0/count", big)},
      {"accessor 0 reaches past the end of buffer view 0", set("/accessors/0/count", 4)},
      {"accessor 0 reaches past the end", set("/accessors/0/byteOffset", big)},
      {"accessor 0 reaches past the end", set("/accessors/0/byteOffset", 1)},
      {"accessors[0].byteOffset must be an integer", set("/accessors/0/byteOffset", -4)},
      {"accessors[0].count must be an integer", set("/accessors/0/count", 2.5)},
      {"accessors[0].bufferView must be an integer", set("/accessors/0/bufferView", 4294967296ULL)},
      {"buffer view 7 does not exist", set("/accessors/0/bufferView", 7)},
      {"accessor 0 has a type", set("/accessors/0/componentType", kUInt)},
      {"accessor 0 has a type", set("/accessors/0/type", "VEC2")},
      {"accessor 0 has a type", set("/accessors/0/type", "MAT3")},
      {"accessor 0 has a type", set("/accessors/0/componentType", 5130)},
      {"Unsupported `type`", set("/accessors/0/type", "VEC9")},
      {"longer than its byteStride", set("/bufferViews/0/byteStride", 8)},
      {"byteStride", set("/bufferViews/0/byteStride", 13)},
      {"accessor 0 reaches past the end", set("/bufferViews/0/byteStride", 252)},
      {"buffer view 0 reaches past the end of buffer 0", set("/bufferViews/0/byteLength", 37)},
      {"buffer view 0 reaches past the end of buffer 0", set("/bufferViews/0/byteOffset", big)},
      {"buffer 3, which does not exist", set("/bufferViews/0/buffer", 3)},
      {"too many elements for having no data",
       [](GltfBuilder& file) {
         file.json["accessors"][0].erase("bufferView");
         file.json["accessors"][0]["count"] = 1U << 30;
       }},
      {"replaces more elements", sparse({{"count", 4}})},
      {"accessors[0].sparse.count must be", sparse({{"count", -1}})},
      {"sparse indices: buffer view 9 does not exist", sparse({{"indices", {{"bufferView", 9}}}})},
      {"sparse values: buffer view 9 does not exist", sparse({{"values", {{"bufferView", 9}}}})},
      {"sparse part that reaches past", sparse({{"values", {{"byteOffset", 25}}}})},
      {"sparse part that reaches past", sparse({{"indices", {{"byteOffset", 36}}}})},
      {"sparse indices of a type", sparse({{"indices", {{"componentType", kFloat}}}})},
      {"sparse index", sparse({{"indices", {{"byteOffset", 14}}}})},
      {"mesh 0 primitive 0: POSITION: accessor 9", [](GltfBuilder& file) {
         file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = 0;
         file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 9;
       }},
      {"mesh 0 primitive 0: JOINTS_0: accessor 9 does not exist",
       set("/meshes/0/primitives/0/attributes/JOINTS_0", 9)},
      {"must be an integer", set("/meshes/0/primitives/0/attributes/POSITION", -1)},
      {"TANGENT has 2 elements for 3 vertices",
       [](GltfBuilder& file) {
         file.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
             file.accessor(std::vector<float>{1, 0, 0, 1, 1, 0, 0, 1}, "VEC4", kFloat);
       }},
      {"index 3 is out of range, there are 3 vertices",
       [](GltfBuilder& file) {
         file.json["meshes"][0]["primitives"][0]["indices"] =
             file.accessor(std::vector<std::uint8_t>{0, 1, 3}, "SCALAR", kUByte);
       }},
      {"index 65535 is out of range",
       [](GltfBuilder& file) {
         file.json["meshes"][0]["primitives"][0]["indices"] =
             file.accessor(std::vector<std::uint16_t>{0, 1, 65535}, "SCALAR", kUShort);
       }},
      {"primitive indices accessor", set("/meshes/0/primitives/0/indices", 5)},
      {"indices: accessor 0 has a type", set("/meshes/0/primitives/0/indices", 0)},
      {"mode 7 does not exist", set("/meshes/0/primitives/0/mode", 7)},
      {"material 4 does not exist", set("/meshes/0/primitives/0/material", 4)},
      {"attributes must be an object", set("/meshes/0/primitives/0/attributes", 4)},
      {"node 0: mesh 9 does not exist", set("/nodes/0/mesh", 9)},
      {"nodes[0].mesh must be an integer", set("/nodes/0/mesh", "0")},
      {"node 0 has child 9", set("/nodes/0/children", {9})},
      {"nodes[0].children[0] must be an integer", set("/nodes/0/children", {-1})},
      {"node 0 is its own ancestor", set("/nodes/0/children", {0})},
      {"node 1 has two parents, nodes 0 and 2",
       set("/nodes", {{{"children", {1}}}, json::object(), {{"children", {1}}}})},
      {"node 1 has two parents, nodes 0 and 0", set("/nodes", {{{"children", {1, 1}}}, json::object()})},
      {"node 1 is its own ancestor",
       set("/nodes", {json::object(), {{"children", {2}}}, {{"children", {1}}}})},
      {"scene 0 lists node 5, which does not exist", set("/scenes/0/nodes", {5})},
      {"scene 0 lists node 0 twice", set("/scenes/0/nodes", {0, 0})},
      {"scene 0 lists node 1, which is a child of node 0",
       [](GltfBuilder& file) {
         file.json["nodes"][0]["children"] = {1};
         file.add("nodes", json::object());
         file.json["scenes"][0]["nodes"] = {0, 1};
       }},
      {"scene 3 does not exist", set("/scene", 3)},
      {"zero quaternion", set("/nodes/0/rotation", {0, 0, 0, 0})},
      {"wrong length", set("/nodes/0/rotation", {0, 0, 1})},
      {"wrong length", set("/nodes/0/scale", {1})},
      {"nodes[0].scale must be an array", set("/nodes/0/scale", 2)},
      {"not 16 numbers", set("/nodes/0/matrix", {1, 0, 0})},
      {"node 0 has a matrix that does more", set("/nodes/0/matrix", {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
      {"node 0 has a rotation without direction", set("/nodes/0/rotation", {1e308, 1e308, 1e308, 1e308})},
      {"baseColorFactor", [](GltfBuilder& file) {
         file.add("materials", {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1}}}}});
         file.json["meshes"][0]["primitives"][0]["material"] = 0;
       }},
      {"uses texture 0, which does not exist",
       [](GltfBuilder& file) {
         file.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
         file.json["meshes"][0]["primitives"][0]["material"] = 0;
       }},
      {"COLOR_0", [](GltfBuilder& file) {
         const float nan = std::nanf("");
         file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
             file.accessor(std::vector<float>{0, 0, 0, 0, nan, 0, 0, 0, 0}, "VEC3", kFloat);
       }},
      {"mesh 0 primitive 0: POSITION of vertex 2 is not a finite number",
       [](GltfBuilder& file) {
         const float infinity = std::numeric_limits<float>::infinity();
         file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] =
             file.accessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, infinity, 0}, "VEC3", kFloat);
       }},
  };
  for (const Refusal& refusal : refusals) {
    GltfBuilder file = triangleFile();
    refusal.spoil(file);
    const std::string text = errorOf(file.import());
    EXPECT_NE(text.find(refusal.part), std::string::npos) << refusal.part << "\n  got: " << text;
    EXPECT_NE(text.find("scene.glb: "), std::string::npos) << text;
  }
}

TEST(GltfRefusals, nameBadTextureReferences) {
  for (const char* section : {"textures", "samplers"}) {
    GltfBuilder file = texturedFile();
    file.json["textures"][0][section == std::string("samplers") ? "sampler" : "source"] = 6;
    EXPECT_NE(errorOf(file.import()).find(" 6, which does not exist"), std::string::npos) << section;
  }
  GltfBuilder file = texturedFile();
  file.json["images"][0] = {{"bufferView", 44}};
  EXPECT_NE(errorOf(file.import()).find("44"), std::string::npos);
}

TEST(GltfRefusals, nameExtensionsThatAreRequired) {
  for (const char* name : {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
                           "KHR_texture_basisu", "VENDOR_secret"}) {
    GltfBuilder file = triangleFile();
    file.json["extensionsUsed"] = {name};
    const auto optional = file.import();
    EXPECT_TRUE(optional) << errorOf(optional);
    file.json["extensionsRequired"] = {"KHR_mesh_quantization", name};
    EXPECT_NE(errorOf(file.import()).find(std::string("requires the extension ") + name), std::string::npos);
  }
}

TEST(GltfImport, warnsOfWhatIsNotShown) {
  GltfBuilder file = triangleFile();
  file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing", "KHR_materials_clearcoat"};
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
  file.add("skins", {{"joints", {0}}});
  const auto graph = file.import();
  ASSERT_TRUE(graph) << errorOf(graph);
  EXPECT_EQ(graph->warnings.size(), 1U);
  EXPECT_TRUE(warns(*graph, "EXT_mesh_gpu_instancing"));
}

}  // namespace
}  // namespace tessera::test
