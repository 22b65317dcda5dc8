// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/gltf_asset.h"
#include "tests/cagegen/io/reading.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

namespace encage {
namespace {

using namespace test;
using Json = nlohmann::json;

/// One float triangle list of six vertices in a buffer of its own, with ushort indices behind.
std::string gltf(const std::string& scene, const std::string& primitive, const std::string& accessors = "") {
  const std::string data =
      raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 0, 0, 2, 1, 0}) + raw<std::uint16_t>({0, 1, 2, 3, 2, 1});
  return R"({"asset":{"version":"2.0"},"scene":0,)" + scene + R"(,"meshes":[{"primitives":[)" + primitive +
         R"(]}],"buffers":[{"byteLength":84,"uri":"data:application/octet-stream;base64,)" + base64(data) +
         R"("}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":72},{"buffer":0,"byteOffset":72,"byteLength":12}],)"
         R"("accessors":[)" +
         (accessors.empty()
              ? R"({"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"},{"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"})"
              : accessors) +
         "]}";
}

const std::string one_node = R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}])";
const std::string indexed = R"({"attributes":{"POSITION":0},"indices":1})";

TEST(ReadGltf, ReadsIndexedTriangles) {
  const PolygonMesh mesh = read("a.gltf", gltf(one_node, indexed));
  EXPECT_EQ(mesh.vertices.rows(), 6);
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 3, 2, 1}));
}

TEST(ReadGltf, ReadsStripsFansAndPlainLists) {
  EXPECT_EQ(read("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":0}})")).corners, indices({0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(read("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":0},"mode":5})")).corners,
            indices({0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4}));
  EXPECT_EQ(read("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":0},"mode":6})")).corners,
            indices({0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5}));
  EXPECT_EQ(refusal("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":0},"mode":1})")),
            "no triangles in the scene (skipped: 1 primitive of lines)");
}

TEST(ReadGltf, SharesVerticesOfPrimitives) {
  const PolygonMesh mesh = read("a.gltf", gltf(one_node, indexed + "," + indexed));
  EXPECT_EQ(mesh.vertices.rows(), 6);
  EXPECT_EQ(mesh.polygon_count(), 4);
}

TEST(ReadGltf, AppliesNodeTransforms) {
  // Half a turn about z is (0,0,1,0); the child is scaled first, then moved by its parent.
  const PolygonMesh mesh = read("a.gltf", gltf(R"("scenes":[{"nodes":[1,2]}],"nodes":[{"mesh":0,"scale":[2,3,4]},)"
                                               R"({"children":[0],"translation":[10,20,30],"rotation":[0,0,1,0]},)"
                                               R"({"mesh":0,"matrix":[0,1,0,0, 1,0,0,0, 0,0,1,0, 5,6,7,1]}])",
                                               indexed));
  ASSERT_EQ(mesh.vertices.rows(), 12);
  EXPECT_EQ(mesh.vertices.row(3), Eigen::RowVector3d(10 - 2, 20 - 3, 30));
  EXPECT_EQ(mesh.vertices.row(6 + 4), Eigen::RowVector3d(5, 6 + 2, 7));
  // The second matrix mirrors: the winding turns.
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 3, 2, 1, 6, 8, 7, 9, 7, 8}));
}

TEST(ReadGltf, ReadsBinaryContainer) {
  const std::string data = raw<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
  std::string json = R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
                     R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":36}],)"
                     R"("bufferViews":[{"buffer":0,"byteLength":36}],)"
                     R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto size = [](const std::string& s) { return static_cast<std::uint32_t>(s.size()); };
  const std::string bytes = "glTF" + raw<std::uint32_t>({2, 28 + size(json) + size(data), size(json)}) + "JSON" + json +
                            raw<std::uint32_t>({size(data)}) + std::string("BIN\0", 4) + data;
  EXPECT_EQ(read("a.glb", bytes).corners, indices({0, 1, 2}));
  for (std::size_t cut = 1; cut < bytes.size(); cut += 7) {
    EXPECT_NE(refusal("a.glb", bytes.substr(0, bytes.size() - cut)), "") << cut;
  }
}

TEST(ReadGltf, RefusesMalformedFiles) {
  const std::string positions = R"({"bufferView":0,"componentType":5126,"count":6,"type":"VEC3"})";
  const auto with_indices = [&](const std::string& accessor) {
    return refusal("a.gltf", gltf(one_node, indexed, positions + "," + accessor));
  };
  EXPECT_NE(refusal("a.gltf", "{\"asset\":"), "");
  EXPECT_NE(refusal("a.glb", "glTF"), "");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5123,"count":7,"type":"SCALAR"})"),
            "mesh 0, primitive 0.indices: accessor 1 reaches beyond buffer view 1");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5123,"count":5,"type":"SCALAR"})"),
            "mesh 0, primitive 0: 5 indices are no whole number of triangles");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5125,"count":3,"type":"SCALAR"})"),
            "mesh 0, primitive 0: index 65536 is out of range (6 vertices)");
  EXPECT_EQ(with_indices(R"({"bufferView":7,"componentType":5123,"count":3,"type":"SCALAR"})"),
            "accessor 1.bufferView: there is no buffer view 7");
  EXPECT_EQ(with_indices(R"({"componentType":5123,"count":3,"type":"SCALAR"})"),
            "mesh 0, primitive 0.indices: accessor 1 has no data: neither a buffer view nor sparse values");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5122,"count":3,"type":"SCALAR"})"),
            "mesh 0, primitive 0.indices: accessor 1 has signed shorts instead of plain unsigned ones");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5130,"count":3,"type":"SCALAR"})"),
            "mesh 0, primitive 0.indices: accessor 1 has the unknown component type 5130");
  EXPECT_EQ(with_indices(R"({"bufferView":1,"componentType":5123,"count":-3,"type":"SCALAR"})"),
            "accessor 1.count: -3 is out of range");
  EXPECT_EQ(with_indices(
                R"({"bufferView":1,"byteOffset":18446744073709551615,"componentType":5123,"count":3,"type":"SCALAR"})"),
            "accessor 1.byteOffset: 18446744073709551615 is out of range");
  EXPECT_EQ(refusal("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":1}})")),
            "mesh 0, primitive 0.attributes.POSITION: accessor 1 is SCALAR, not VEC3");
  EXPECT_EQ(refusal("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":9}})")),
            "mesh 0, primitive 0.attributes.POSITION: there is no accessor 9");
  EXPECT_EQ(refusal("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":"0"}})")),
            "mesh 0, primitive 0.attributes.POSITION: not an integer");
  EXPECT_EQ(refusal("a.gltf", gltf(one_node, R"({"attributes":{"POSITION":0},"mode":7})")),
            "mesh 0, primitive 0.mode: 7 is out of range");
  EXPECT_EQ(refusal("a.gltf", gltf(R"("scenes":[{"nodes":[3]}],"nodes":[{"mesh":0}])", indexed)),
            "scene 0.nodes[0]: there is no node 3");
  EXPECT_EQ(refusal("a.gltf", gltf(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":2}])", indexed)),
            "node 0.mesh: there is no mesh 2");
  EXPECT_EQ(refusal("a.gltf", gltf(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"translation":[1,2]}])", indexed)),
            "node 0.translation: has 2 numbers, needs 3");
  EXPECT_EQ(refusal("a.gltf", gltf(R"("scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"rotation":[0,0,0,0]}])", indexed)),
            "node 0: rotation is not a unit quaternion");
  EXPECT_EQ(refusal("a.gltf", gltf(R"("scenes":[{"nodes":[0]}],"nodes":[{"children":[1]},{"children":[0]}])", indexed)),
            "node 0: has more than one parent");
}

TEST(ReadGltf, RefusesNumbersThatAreNotFinite) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(refusal("a.glb", GltfAsset::mesh({0, 0, 0, 1, 0, bad, 0, 1, 0}).binary()),
              "mesh 0, primitive 0: vertex 1 is not finite");
  }
  GltfAsset asset = GltfAsset::triangle();
  asset.node(0)["scale"] = {1e300, 1e300, 1e300};
  asset.json["nodes"].push_back({{"children", {0}}, {"scale", {1e300, 1, 1}}});
  asset.json["scenes"][0]["nodes"] = {1};
  EXPECT_EQ(refusal("a.glb", asset.binary()), "vertex 0: coordinate is not finite");
}

// What a file requires is settled before anything else is read: the files below hold nothing that could be.
TEST(ReadGltf, RefusesRequiredExtensionsThatItDoesNotKnow) {
  Json json = {{"asset", {{"version", "2.0"}}}, {"meshes", 7}, {"extensionsRequired", {"ACME_compression"}}};
  EXPECT_EQ(refusal("a.gltf", json.dump()),
            "the file requires the extension ACME_compression, which Encage does not know; save it without");
  json["extensionsRequired"] = {"KHR_materials_unlit", "ACME_b", "KHR_mesh_primitive_restart"};
  EXPECT_EQ(refusal("a.gltf", json.dump()),
            "the file requires the extensions ACME_b, KHR_mesh_primitive_restart, which Encage does not know; save it "
            "without");
  json["extensionsRequired"] = {3};
  EXPECT_EQ(refusal("a.gltf", json.dump()), "JSON.extensionsRequired[0]: not a string");
  // Optional ones may be ignored: the file says so.
  GltfAsset asset = GltfAsset::triangle();
  asset.json["extensionsUsed"] = {"ACME_compression"};
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1);
}

TEST(ReadGltf, NamesOtherVersions) {
  const std::string remedy = " is not supported; convert it to glTF 2.0, for example with gltf-pipeline";
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{"version":"1.0"},"meshes":{"box":{}},"nodes":{"root":{}}})"),
            "glTF 1.0" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{"version":"1.1"},"meshes":{}})"), "glTF 1.1" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{"version":0.8},"meshes":{}})"), "glTF 0.8" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{},"meshes":{"box":{}}})"), "glTF 1.0" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"meshes":{"box":{}}})"), "glTF 1.0" + remedy);
  EXPECT_EQ(refusal("a.glb", "glTF" + raw<std::uint32_t>({1, 24, 4, 0}) + "{}  "), "binary glTF 1.0" + remedy);
  EXPECT_EQ(refusal("a.glb", "glTF" + raw<std::uint32_t>({3, 24, 4, 0}) + "{}  "),
            "GLB header: glTF version 3 is not 2");
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{"version":"3.0"}})"), "glTF 3.0" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"asset":{"version":"2.1","minVersion":"2.1"}})"), "glTF 2.1" + remedy);
  EXPECT_EQ(refusal("a.gltf", R"({"meshes":[]})"), "not a glTF file: asset.version is missing");
  EXPECT_EQ(refusal("a.gltf", "[]"), "JSON: not an object");
  GltfAsset asset = GltfAsset::triangle();
  asset.json["asset"]["version"] = "2.3";  // a later minor version is compatible
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1);
}

TEST(ReadGltf, FindsTheDataOfBuffers) {
  const Folder folder;
  GltfAsset asset = GltfAsset::triangle();
  const auto refused = [&](const std::string& uri) -> std::string {
    asset.json["buffers"] = {{{"uri", uri}}};
    try {
      read_polygon_mesh(folder.write("a.gltf", asset.text()));
    } catch (const Error& error) {
      return std::string(error.what()).substr((folder / "a.gltf").string().size() + 2);
    }
    return "";
  };
  folder.write("my data%.bin", asset.data);
  EXPECT_EQ(refused("my%20data%25.bin"), "");
  EXPECT_EQ(refused("my data%.bin"), "");
  folder.write("long.bin", asset.data + "more");
  EXPECT_EQ(refused("long.bin"), "");
  EXPECT_EQ(refused("data:,raw"), "buffer 0: the data URI is not base64");
  EXPECT_EQ(refused("data:application/gltf-buffer;base64," + base64(asset.data)), "");
  EXPECT_EQ(refused("data:;base64,AAA*"), "buffer 0: the data URI has a character that is not base64");
  EXPECT_EQ(refused("data:;base64,AAAA"), "buffer 0: has 3 bytes, byteLength promises 36");
  EXPECT_EQ(refused("missing.bin"),
            "buffer 0: " + (folder / "missing.bin").string() + ": cannot open: No such file or directory");
  EXPECT_EQ(refused("/dev/zero"), "buffer 0: /dev/zero: not a regular file");
  EXPECT_EQ(
      refused("https://example.org/a.bin"),
      "buffer 0: its data are at 'https://example.org/a.bin', not in a file; put them beside this file and name them "
      "by a path");
  folder.write("short.bin", asset.data.substr(1));
  EXPECT_EQ(refused("short.bin"), "buffer 0: has 35 bytes, byteLength promises 36");
  // The data chunk of a binary file is that of the first buffer only.
  asset.json.erase("buffers");
  asset.json["bufferViews"][0]["buffer"] = 1;
  asset.json["buffers"] = {Json::object(), {{"byteLength", 36}}};
  EXPECT_EQ(refusal("a.glb", asset.binary()), "buffer 1: has no data: neither a URI nor a chunk of a binary file");
}

TEST(ReadGltf, DoesNotOpenWhatIsNoGeometry) {
  GltfAsset asset = GltfAsset::triangle();
  asset.json["images"] = {{{"uri", "missing.png"}}, {{"bufferView", 99}}};
  asset.json["buffers"] = {Json::object(), {{"byteLength", 5}, {"uri", "missing.bin"}}};
  asset.json["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 5}});
  asset.json["materials"] = {{{"pbrMetallicRoughness", "none"}}};
  asset.attributes()["NORMAL"] = 77;
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1);
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "");
}

TEST(ReadGltf, SkipsUnknownChunks) {
  std::string bytes = GltfAsset::triangle().binary();
  bytes += raw<std::uint32_t>({4}) + "XTRA" + "1234";
  const auto length = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(bytes.data() + 8, &length, sizeof length);
  EXPECT_EQ(read("a.glb", bytes).polygon_count(), 1);
  EXPECT_EQ(read("a.glb", bytes + "behind the end").polygon_count(), 1);
}

// Small files must not claim all memory.
TEST(ReadGltf, DoesNotTrustCountsWithMemory) {
  GltfAsset asset = GltfAsset::triangle();
  const int index = asset.add_view(raw<std::uint16_t>({1}));
  const int value = asset.add_view(raw<float>({1, 2, 3}));
  asset.attributes()["POSITION"] = asset.add_accessor({{"componentType", 5126},
                                                       {"count", 2000000000},
                                                       {"type", "VEC3"},
                                                       {"sparse",
                                                        {{"count", 1},
                                                         {"indices", {{"bufferView", index}, {"componentType", 5123}}},
                                                         {"values", {{"bufferView", value}}}}}});
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "mesh 0, primitive 0.attributes.POSITION: accessor 1 has more elements than a file of this size can mean");

  GltfAsset instances = GltfAsset::mesh(std::vector<float>(9000, 0));
  for (int n = 1; n < 4000; ++n) instances.json["nodes"].push_back({{"mesh", 0}});
  for (int n = 1; n < 4000; ++n) instances.json["scenes"][0]["nodes"].push_back(n);
  const std::string reason = ": the scene unfolds to more triangles than a file of this size can mean";
  EXPECT_NE(refusal("a.glb", instances.binary()).find(reason), std::string::npos);

  // A mesh may list the same triangles again and again.
  GltfAsset primitives = GltfAsset::triangle();
  primitives.primitive()["mode"] = 5;
  primitives.primitive()["indices"] = primitives.add("SCALAR", std::vector<std::uint8_t>(30000, 1));
  const Json primitive = primitives.primitive();
  for (int p = 1; p < 200; ++p) primitives.json["meshes"][0]["primitives"].push_back(primitive);
  EXPECT_NE(refusal("a.glb", primitives.binary()).find(reason), std::string::npos);
}

TEST(ReadGltf, ReadsNodesNestedAsDeepAsTheyAre) {
  constexpr int depth = 200000;
  std::string nodes = R"("scenes":[{"nodes":[0]}],"nodes":[)";
  for (int n = 1; n < depth; ++n) nodes += R"({"children":[)" + std::to_string(n) + R"(],"translation":[1,0,0]},)";
  const PolygonMesh mesh = read("a.gltf", gltf(nodes + R"({"mesh":0}])", indexed));
  ASSERT_EQ(mesh.vertices.rows(), 6);
  EXPECT_EQ(mesh.vertices(0, 0), depth - 1);
}

TEST(ReadGltf, VisitsChildrenInOrder) {
  const PolygonMesh mesh = read("a.gltf", gltf(R"("scenes":[{"nodes":[0,3]}],"nodes":[{"children":[1,2]},)"
                                               R"({"mesh":0,"translation":[1,0,0]},{"mesh":0,"translation":[2,0,0]},)"
                                               R"({"mesh":0,"translation":[3,0,0]}])",
                                               indexed));
  ASSERT_EQ(mesh.vertices.rows(), 18);
  for (int n = 0; n < 3; ++n) EXPECT_EQ(mesh.vertices(6 * n, 0), n + 1);
}

TEST(ReadGltf, RefusesDeepJson) {
  const std::string brackets = std::string(1000000, '[') + std::string(1000000, ']');
  for (const char* member : {"extras", "extensions"}) {
    std::string json = R"("nodes":[{"mesh":0}],")" + std::string(member) + R"(":{"a":)" + brackets + "}";
    EXPECT_EQ(refusal("a.gltf", gltf(json, indexed)), "JSON nested deeper than 64 levels");
  }
  std::string json = R"({"asset":{"version":"2.0"},"extras":)" + brackets + "}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto size = static_cast<std::uint32_t>(json.size());
  EXPECT_EQ(refusal("a.glb", "glTF" + raw<std::uint32_t>({2, 20 + size, size}) + "JSON" + json),
            "JSON nested deeper than 64 levels");
}

}  // namespace
}  // namespace encage
