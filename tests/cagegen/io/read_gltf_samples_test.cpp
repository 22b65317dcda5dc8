// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/gltf_asset.h"
#include "tests/cagegen/io/reading.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#ifdef ENCAGE_WITH_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif

#include <cmath>
#include <cstring>

// The features of the Khronos glTF sample assets, by the names of the assets: each test makes the smallest file that
// has the feature.

namespace encage {
namespace {

using namespace test;
using Json = nlohmann::json;

constexpr double half = 0.70710678118654752440;  // of a quarter turn: its sine and cosine

Eigen::RowVector3d row(double x, double y, double z) { return {x, y, z}; }

/// That the file is read, has no notes, and has these vertices.
void expect_vertices(const GltfAsset& asset, const std::vector<Eigen::RowVector3d>& vertices, double tolerance = 0) {
  const PolygonMesh mesh = read("a.glb", asset.binary());
  ASSERT_EQ(mesh.vertices.rows(), static_cast<Eigen::Index>(vertices.size()));
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    EXPECT_LE((mesh.vertices.row(static_cast<Eigen::Index>(v)) - vertices[v]).norm(), tolerance)
        << v << ": " << mesh.vertices.row(static_cast<Eigen::Index>(v)) << " instead of " << vertices[v];
  }
}

// ---- Plain meshes ------------------------------------------------------------

TEST(GltfSamples, BoxInterleaved) {
  GltfAsset asset = GltfAsset::triangle();
  // Normals and positions take turns.
  const int view = asset.add_view(
      raw<float>({0, 0, 1, 5, 0, 0, 0, 0, 1, 6, 0, 0, 0, 0, 1, 5, 1, 0, /* unused */ 0, 0, 1}), {{"byteStride", 24}});
  asset.attributes()["POSITION"] = asset.add_accessor(
      {{"bufferView", view}, {"byteOffset", 12}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  expect_vertices(asset, {row(5, 0, 0), row(6, 0, 0), row(5, 1, 0)});
  asset.json["accessors"][1]["count"] = 4;
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "mesh 0, primitive 0.attributes.POSITION: accessor 1 reaches beyond buffer view 1");
  asset.json["accessors"][1]["count"] = 3;
  asset.json["bufferViews"][1]["byteStride"] = 8;
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "mesh 0, primitive 0.attributes.POSITION: accessor 1 reaches beyond buffer view 1");
}

TEST(GltfSamples, TriangleIndicesOfEverySize) {
  const auto corners = [](GltfAsset asset, int accessor) {
    asset.primitive()["indices"] = accessor;
    return read("a.glb", asset.binary()).corners;
  };
  GltfAsset asset = GltfAsset::triangle();
  const int bytes = asset.add<std::uint8_t>("SCALAR", {2, 0, 1});
  const int shorts = asset.add<std::uint16_t>("SCALAR", {2, 0, 1});
  const int words = asset.add<std::uint32_t>("SCALAR", {2, 0, 1});
  for (const int accessor : {bytes, shorts, words}) EXPECT_EQ(corners(asset, accessor), indices({2, 0, 1}));
}

TEST(GltfSamples, SimpleMeshes) {
  GltfAsset asset = GltfAsset::triangle();
  asset.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 1}}});
  asset.json["scenes"][0]["nodes"] = {0, 1};
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0), row(0, 0, 1), row(1, 0, 1), row(0, 1, 1)});
}

TEST(GltfSamples, MeshPrimitiveModes) {
  GltfAsset asset = GltfAsset::mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  asset.json["meshes"][0]["primitives"] = Json::array();
  for (int mode = 0; mode < 7; ++mode) {
    asset.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
  }
  asset.json["meshes"][0]["primitives"].erase(4);  // four vertices are no triangles
  // Used twice, skipped once.
  asset.json["nodes"].push_back({{"mesh", 0}});
  asset.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(read("a.glb", asset.binary()).corners,
            indices({0, 1, 2, 1, 3, 2, 0, 1, 2, 0, 2, 3, 4, 5, 6, 5, 7, 6, 4, 5, 6, 4, 6, 7}));
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "skipped: 1 primitive of points, 3 primitives of lines");
}

TEST(GltfSamples, PrimitivesWithoutPositions) {
  GltfAsset asset = GltfAsset::triangle();
  asset.json["meshes"][0]["primitives"].push_back({{"attributes", {{"NORMAL", 0}}}});
  asset.json["meshes"][0]["primitives"].push_back({{"attributes", Json::object()}, {"indices", 9}});
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1);
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "skipped: 2 primitives without positions");
  asset.attributes().erase("POSITION");
  EXPECT_EQ(refusal("a.glb", asset.binary()), "no triangles in the scene (skipped: 3 primitives without positions)");
}

TEST(GltfSamples, MultipleScenes) {
  GltfAsset asset = GltfAsset::triangle();
  asset.json["nodes"].push_back({{"mesh", 0}, {"translation", {3, 0, 0}}});
  asset.json["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  asset.json["scene"] = 1;
  expect_vertices(asset, {row(3, 0, 0), row(4, 0, 0), row(3, 1, 0)});
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "skipped: 1 other scene");
  asset.json.erase("scene");
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  asset.json.erase("scenes");
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 2);
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "");
  asset.json["scenes"] = {{{"nodes", {0}}}};
  asset.json["scene"] = 1;
  EXPECT_EQ(refusal("a.glb", asset.binary()), "JSON.scene: there is no scene 1");
}

TEST(GltfSamples, NegativeScaleTest) {
  GltfAsset asset = GltfAsset::triangle();
  asset.node(0)["scale"] = {-1, 1, 1};
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 2, 1}));
  asset.node(0)["scale"] = {-1, -1, 1};
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2}));
}

TEST(GltfSamples, UnicodeAndSpacesInNames) {
  const Folder folder;
  GltfAsset asset = GltfAsset::triangle();
  folder.write("Unicode❤♻ Test.bin", asset.data);
  for (const char* uri : {"Unicode❤♻ Test.bin", "Unicode%E2%9D%A4%E2%99%BB%20Test.bin"}) {
    asset.json["buffers"] = {{{"uri", uri}}};
    EXPECT_EQ(read_polygon_mesh(folder.write("Unicode❤♻.gltf", asset.text())).polygon_count(), 1);
  }
}

// ---- Extensions that change nothing -----------------------------------------

TEST(GltfSamples, ExtensionsThatMoveNoVertexMayBeRequired) {
  for (const char* extension :
       {"KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif", "MSFT_texture_dds",
        "KHR_materials_unlit", "KHR_materials_variants", "KHR_materials_pbrSpecularGlossiness", "KHR_lights_punctual",
        "EXT_lights_image_based", "KHR_animation_pointer", "KHR_xmp_json_ld", "EXT_mesh_features",
        "EXT_structural_metadata", "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
        "KHR_meshopt_compression", "KHR_node_visibility"}) {
    GltfAsset asset = GltfAsset::triangle();
    asset.require(extension);
    EXPECT_EQ(notes_of("a.glb", asset.binary()), "") << extension;
    EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1) << extension;
  }
}

TEST(GltfSamples, CubeVisibility) {
  GltfAsset asset = GltfAsset::triangle();
  asset.json["nodes"].push_back({{"children", {2}}, {"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  asset.json["nodes"].push_back({{"mesh", 0}, {"extensions", {{"KHR_node_visibility", {{"visible", true}}}}}});
  asset.json["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 1);
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "skipped: 1 hidden node");
}

// ---- Sparse accessors ----------------------------------------------------------

TEST(GltfSamples, SimpleSparseAccessor) {
  GltfAsset asset = GltfAsset::triangle();
  const int at = asset.add_view(raw<std::uint16_t>({2, 0}));
  const int values = asset.add_view(raw<float>({7, 7, 7, 8, 8, 8}));
  Json sparse = {
      {"count", 2}, {"indices", {{"bufferView", at}, {"componentType", 5123}}}, {"values", {{"bufferView", values}}}};
  asset.json["accessors"][0]["sparse"] = sparse;
  expect_vertices(asset, {row(8, 8, 8), row(1, 0, 0), row(7, 7, 7)});
  // Without a buffer view, all others are zero.
  asset.json["accessors"][0].erase("bufferView");
  expect_vertices(asset, {row(8, 8, 8), row(0, 0, 0), row(7, 7, 7)});
  sparse["indices"]["byteOffset"] = 2;
  sparse["values"]["byteOffset"] = 12;
  sparse["count"] = 1;
  asset.json["accessors"][0]["sparse"] = sparse;
  expect_vertices(asset, {row(8, 8, 8), row(0, 0, 0), row(0, 0, 0)});

  const auto refused = [&](const Json& bad) {
    asset.json["accessors"][0]["sparse"] = bad;
    return refusal("a.glb", asset.binary());
  };
  sparse["count"] = 2;
  EXPECT_EQ(refused(sparse), "mesh 0, primitive 0.attributes.POSITION: accessor 0 reaches beyond buffer view 1");
  sparse["indices"].erase("byteOffset");
  EXPECT_EQ(refused(sparse), "mesh 0, primitive 0.attributes.POSITION: accessor 0 reaches beyond buffer view 2");
  sparse["values"].erase("byteOffset");
  sparse["indices"]["componentType"] = 5122;
  EXPECT_EQ(refused(sparse),
            "mesh 0, primitive 0.attributes.POSITION: accessor 0 has sparse indices that are no unsigned integers");
  sparse["indices"]["componentType"] = 5121;  // the bytes 2, 0
  EXPECT_EQ(refused(sparse), "");
  asset.json["accessors"][0]["count"] = 2;
  EXPECT_EQ(refused(sparse),
            "mesh 0, primitive 0.attributes.POSITION: accessor 0 has the sparse index 2, but only 2 elements");
}

TEST(GltfSamples, SparseIndices) {
  GltfAsset asset = GltfAsset::mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {0, 1, 2, 0, 0, 0});
  asset.json["accessors"][1]["sparse"] = {
      {"count", 3},
      {"indices", {{"bufferView", asset.add_view(raw<std::uint8_t>({3, 4, 5}))}, {"componentType", 5121}}},
      {"values", {{"bufferView", asset.add_view(raw<std::uint16_t>({3, 2, 1}))}}}};
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2, 3, 2, 1}));
}

// ---- Quantized -------------------------------------------------------------------

TEST(GltfSamples, DuckQuantized) {
  GltfAsset asset = GltfAsset::triangle();
  asset.require("KHR_mesh_quantization");
  const auto with = [&](int accessor) {
    asset.attributes()["POSITION"] = accessor;
    return asset;
  };
  const Json normalized = {{"normalized", true}};
  expect_vertices(with(asset.add<std::int8_t>("VEC3", {0, 127, -128, -127, 1, 0, 0, 0, 64}, normalized)),
                  {row(0, 1, -1), row(-1, 1 / 127., 0), row(0, 0, 64 / 127.)});
  expect_vertices(with(asset.add<std::uint8_t>("VEC3", {0, 255, 128, 1, 0, 0, 0, 1, 0}, normalized)),
                  {row(0, 1, 128 / 255.), row(1 / 255., 0, 0), row(0, 1 / 255., 0)});
  expect_vertices(with(asset.add<std::int16_t>("VEC3", {0, 32767, -32768, 1, 0, 0, 0, -1, 0}, normalized)),
                  {row(0, 1, -1), row(1 / 32767., 0, 0), row(0, -1 / 32767., 0)});
  expect_vertices(with(asset.add<std::uint16_t>("VEC3", {0, 65535, 1, 2, 0, 0, 0, 3, 0}, normalized)),
                  {row(0, 1, 1 / 65535.), row(2 / 65535., 0, 0), row(0, 3 / 65535., 0)});
  expect_vertices(with(asset.add<std::int8_t>("VEC3", {0, 127, -128, 1, 0, 0, 0, 1, 0})),
                  {row(0, 127, -128), row(1, 0, 0), row(0, 1, 0)});
  expect_vertices(with(asset.add<std::uint16_t>("VEC3", {0, 65535, 7, 1, 0, 0, 0, 1, 0})),
                  {row(0, 65535, 7), row(1, 0, 0), row(0, 1, 0)});
  // Elements are padded to four bytes.
  const int view = asset.add_view(raw<std::int16_t>({9, 8, 7, 0, 1, 0, 0, 0, 0, 1, 0, 0}), {{"byteStride", 8}});
  expect_vertices(
      with(asset.add_accessor({{"bufferView", view}, {"componentType", 5122}, {"count", 3}, {"type", "VEC3"}})),
      {row(9, 8, 7), row(1, 0, 0), row(0, 1, 0)});
  EXPECT_EQ(refusal("a.glb", with(asset.add<std::uint32_t>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})).binary()),
            "mesh 0, primitive 0.attributes.POSITION: accessor 8 has unsigned integers, which are not allowed here");
}

// ---- Instances ---------------------------------------------------------------------

TEST(GltfSamples, SimpleInstancing) {
  GltfAsset asset = GltfAsset::triangle();
  Json attributes = {{"TRANSLATION", asset.add<float>("VEC3", {0, 0, 0, 10, 0, 0})},
                     {"ROTATION", asset.add<float>("VEC4", {0, 0, 0, 1, 0, 0, 1, 1})},  // the second needs its norm
                     {"SCALE", asset.add<float>("VEC3", {1, 1, 1, 2, -2, 2})},
                     {"_ID", asset.add<float>("SCALAR", {5, 6})}};
  const auto set = [&](const Json& now) { asset.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = now; };
  set(attributes);
  asset.node(0)["translation"] = {0, 0, 1};
  // Children are no instances.
  asset.node(0)["children"] = {1};
  asset.json["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 1}}});
  // The second one is scaled, turned a quarter and moved.
  const std::vector<Eigen::RowVector3d> expected = {row(0, 0, 1),  row(1, 0, 1),  row(0, 1, 1),
                                                    row(10, 0, 1), row(10, 2, 1), row(12, 0, 1),
                                                    row(0, 0, 2),  row(1, 0, 2),  row(0, 1, 2)};
  for (const bool required : {false, true}) {  // the data are there, even where a reader may ignore them
    if (required) asset.require("EXT_mesh_gpu_instancing");
    expect_vertices(asset, expected, 1e-15);
    EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2, 3, 5, 4, 6, 7, 8}));  // a scale mirrors
    EXPECT_EQ(notes_of("a.glb", asset.binary()), "");
  }
  set({{"_ID", attributes["_ID"]}});
  EXPECT_EQ(read("a.glb", asset.binary()).polygon_count(), 3);

  set({{"TRANSLATION", attributes["TRANSLATION"]}, {"SCALE", asset.add<float>("VEC3", {1, 1, 1})}});
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "node 0.extensions.EXT_mesh_gpu_instancing.attributes.TRANSLATION: has 2 elements, another attribute 1");
  set({{"ROTATION", asset.add<float>("VEC4", {0, 0, 0, 0})}});
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "node 0.extensions.EXT_mesh_gpu_instancing.attributes.ROTATION: instance 0 has no unit quaternion");
  set(Json::object());
  EXPECT_EQ(
      refusal("a.glb", asset.binary()),
      "node 0.extensions.EXT_mesh_gpu_instancing.attributes: has no attribute, so the number of instances is unknown");
}

TEST(GltfSamples, InstancesWithQuantizedRotations) {
  GltfAsset asset = GltfAsset::triangle();
  asset.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", asset.add<std::int16_t>("VEC4", {0, 0, 23170, 23170}, {{"normalized", true}})}};
  expect_vertices(asset, {row(0, 0, 0), row(0, 1, 0), row(-1, 0, 0)}, 1e-15);
  asset.json["accessors"][1].erase("normalized");
  EXPECT_EQ(
      refusal("a.glb", asset.binary()),
      "node 0.extensions.EXT_mesh_gpu_instancing.attributes.ROTATION: accessor 1 has signed shorts, which are not "
      "allowed here");
}

// ---- Morph targets -------------------------------------------------------------------

TEST(GltfSamples, SimpleMorph) {
  GltfAsset asset = GltfAsset::triangle();
  asset.primitive()["targets"] = {
      {{"POSITION", asset.add<float>("VEC3", {0, 0, 4, 0, 0, 4, 0, 0, 4})}},
      {{"NORMAL", 0}},
      {{"POSITION", asset.add<std::int8_t>("VEC3", {127, 0, 0, 0, 0, 0, 0, 0, 0}, {{"normalized", true}})}}};
  const std::string note = "only the default pose is read: 1 mesh with morph targets";
  // Without weights, the mesh itself.
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  EXPECT_EQ(notes_of("a.glb", asset.binary()), note);
  asset.json["meshes"][0]["weights"] = {0.5, 1, -2};
  expect_vertices(asset, {row(-2, 0, 2), row(1, 0, 2), row(0, 1, 2)});
  // Those of the node come first; a second node without has those of the mesh.
  asset.node(0)["weights"] = {1, 0, 0};
  asset.json["nodes"].push_back({{"mesh", 0}});
  asset.json["scenes"][0]["nodes"] = {0, 1};
  expect_vertices(asset, {row(0, 0, 4), row(1, 0, 4), row(0, 1, 4), row(-2, 0, 2), row(1, 0, 2), row(0, 1, 2)});
  EXPECT_EQ(notes_of("a.glb", asset.binary()), note);

  asset.node(0)["weights"] = {1, 0};
  EXPECT_EQ(refusal("a.glb", asset.binary()), "mesh 0, primitive 0: has 3 morph targets, but there are 2 weights");
  asset.node(0)["weights"] = {1, 0, 0};
  asset.primitive()["targets"][0]["POSITION"] = asset.add<float>("VEC3", {0, 0, 4, 0, 0, 4});
  EXPECT_EQ(refusal("a.glb", asset.binary()), "mesh 0, primitive 0.targets[0].POSITION: has 2 elements for 3 vertices");
}

TEST(GltfSamples, AnimatedMorphCube) {
  GltfAsset asset = GltfAsset::triangle();
  // Sparse displacements, most of them zero; one with a weight, one without.
  const int at = asset.add_view(raw<std::uint8_t>({1}));
  const int by = asset.add_view(raw<float>({0, 0, 3}));
  const int sparse = asset.add_accessor(
      {{"componentType", 5126},
       {"count", 3},
       {"type", "VEC3"},
       {"sparse",
        {{"count", 1}, {"indices", {{"bufferView", at}, {"componentType", 5121}}}, {"values", {{"bufferView", by}}}}}});
  const int zero = asset.add_accessor({{"componentType", 5126}, {"count", 3}, {"type", "VEC3"}});
  asset.primitive()["targets"] = {{{"POSITION", sparse}}, {{"POSITION", zero}}};
  asset.json["meshes"][0]["weights"] = {1, 1};
  asset.json["animations"] = {{{"channels", Json::array()}, {"samplers", Json::array()}}};
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 3), row(0, 1, 0)});
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "only the default pose is read: 1 mesh with morph targets, 1 animation");
}

TEST(GltfSamples, MorphPrimitivesTest) {
  GltfAsset asset = GltfAsset::triangle();
  const int up = asset.add<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const int down = asset.add<float>("VEC3", {0, 0, -1, 0, 0, -1, 0, 0, -1});
  asset.primitive()["targets"] = {{{"POSITION", up}}};
  // It has the same positions, but goes elsewhere.
  asset.json["meshes"][0]["primitives"].push_back(
      {{"attributes", {{"POSITION", 0}}}, {"targets", {{{"POSITION", down}}}}});
  EXPECT_EQ(read("a.glb", asset.binary()).vertices.rows(), 3);
  asset.json["meshes"][0]["weights"] = {1};
  expect_vertices(asset, {row(0, 0, 1), row(1, 0, 1), row(0, 1, 1), row(0, 0, -1), row(1, 0, -1), row(0, 1, -1)});
}

// ---- Skins ----------------------------------------------------------------------------

std::vector<float> matrix(const std::vector<float>& translation, float scale = 1) {
  return {scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, translation[0], translation[1], translation[2], 1};
}

/// A triangle: the first two vertices follow joint 0, half of the third joint 1. The nodes are: 0 the mesh, 1 joint 0,
/// 2 joint 1 below it, 3 their parent.
GltfAsset skinned(const std::vector<std::vector<float>>& inverse_bind_matrices) {
  GltfAsset asset = GltfAsset::triangle();
  asset.attributes()["JOINTS_0"] = asset.add<std::uint8_t>("VEC4", {0, 99, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0});
  asset.attributes()["WEIGHTS_0"] =
      asset.add<std::uint8_t>("VEC4", {255, 0, 0, 0, 255, 0, 0, 0, 128, 127, 0, 0}, {{"normalized", true}});
  asset.node(0)["skin"] = 0;
  asset.node(0)["translation"] = {100, 0, 0};  // joints place a mesh, not its node
  asset.json["nodes"].push_back({{"translation", {0, 0, 1}}, {"children", {2}}});
  asset.json["nodes"].push_back({{"translation", {0, 1, 0}}});
  asset.json["nodes"].push_back({{"children", {1}}});
  asset.json["scenes"][0]["nodes"] = {0, 3};
  asset.json["skins"] = {{{"joints", {1, 2}}}};
  if (!inverse_bind_matrices.empty()) {
    std::vector<float> all;
    for (const auto& one : inverse_bind_matrices) all.insert(all.end(), one.begin(), one.end());
    asset.json["skins"][0]["inverseBindMatrices"] = asset.add("MAT4", all);
  }
  return asset;
}

TEST(GltfSamples, SimpleSkin) {
  const std::string note = "only the default pose is read: 1 mesh with a skin";
  // The joints stand where they were bound.
  GltfAsset asset = skinned({matrix({0, 0, -1}), matrix({0, -1, -1})});
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  EXPECT_EQ(notes_of("a.glb", asset.binary()), note);
  // They still do if they say so in rounded numbers: the coordinates are those of the file, bit by bit.
  asset.node(1)["translation"] = {1e-7, 0, 1.0000001};
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  // Another pose: the whole moves up, the second joint to the right.
  asset.node(1)["translation"] = {0, 0, 1};
  asset.node(3)["translation"] = {0, 0, 8};
  asset.node(2)["translation"] = {4, 1, 0};
  expect_vertices(asset, {row(0, 0, 8), row(1, 0, 8), row(4 * 127 / 255., 1, 8)}, 1e-14);
  EXPECT_EQ(notes_of("a.glb", asset.binary()), note);
  // A rotation of the parent turns all about the origin.
  asset = skinned({matrix({0, 0, -1}), matrix({0, -1, -1})});
  asset.node(3)["rotation"] = {0, 0, half, half};
  expect_vertices(asset, {row(0, 0, 0), row(0, 1, 0), row(-1, 0, 0)}, 1e-14);
  // Without matrices, the mesh is bound where the joints have their origins.
  asset = skinned({});
  expect_vertices(asset, {row(0, 0, 1), row(1, 0, 1), row(0, 1 + 127 / 255., 1)}, 1e-14);
}

// Armatures in centimetres: the vertices are small numbers, the scene is large.
TEST(GltfSamples, RiggedFigureScaledByItsArmature) {
  GltfAsset asset = skinned({matrix({0, 0, -1}), matrix({0, -1, -1})});
  asset.node(3)["scale"] = {100, 100, 100};
  expect_vertices(asset, {row(0, 0, 0), row(100, 0, 0), row(0, 100, 0)}, 1e-12);
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2}));
  asset.node(3)["scale"] = {-100, 100, 100};
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 2, 1}));
}

TEST(GltfSamples, SkinsWithTwoSetsOfJoints) {
  GltfAsset asset = skinned({});
  asset.node(2)["translation"] = {0, 0, 10};
  asset.attributes()["WEIGHTS_0"] = asset.add<float>("VEC4", {.5, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0});
  asset.attributes()["JOINTS_1"] = asset.add<std::uint16_t>("VEC4", {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  asset.attributes()["WEIGHTS_1"] = asset.add<float>("VEC4", {.25, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  // Weights are divided by their sum; a vertex without any stays.
  expect_vertices(asset, {row(0, 0, (.5 * 1 + .25 * 11) / .75), row(1, 0, 1), row(0, 1, 0)}, 1e-14);
}

TEST(GltfSamples, RecursiveSkeletons) {
  // Two meshes share the joints, and the one is morphed first.
  GltfAsset asset = skinned({});
  asset.json["meshes"].push_back(asset.json["meshes"][0]);
  asset.json["meshes"][1]["primitives"][0]["targets"] = {
      {{"POSITION", asset.add<float>("VEC3", {0, 5, 0, 0, 0, 0, 0, 0, 0})}}};
  asset.json["nodes"].push_back({{"mesh", 1}, {"skin", 0}, {"weights", {1}}});
  asset.json["scenes"][0]["nodes"] = {0, 3, 4};
  const double y = 1 + 127 / 255.;
  expect_vertices(asset, {row(0, 0, 1), row(1, 0, 1), row(0, y, 1), row(0, 5, 1), row(1, 0, 1), row(0, y, 1)}, 1e-14);
  EXPECT_EQ(notes_of("a.glb", asset.binary()),
            "only the default pose is read: 1 mesh with morph targets, 2 meshes with skins");
}

TEST(GltfSamples, SkinsThatAreBroken) {
  const auto refused = [](const std::function<void(GltfAsset&)>& change) {
    GltfAsset asset = skinned({matrix({0, 0, -1}), matrix({0, -1, -1})});
    change(asset);
    return refusal("a.glb", asset.binary());
  };
  EXPECT_EQ(refused([](GltfAsset& a) { a.json["skins"][0]["joints"] = {1}; }),
            "mesh 0, primitive 0: vertex 2 follows a joint that its skin of 1 joints does not have");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.json["skins"][0]["joints"] = {1, 9};
            }),
            "skin 0.joints[1]: there is no node 9");
  EXPECT_EQ(refused([](GltfAsset& a) { a.node(0)["skin"] = 1; }), "node 0.skin: there is no skin 1");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.json["skins"][0]["inverseBindMatrices"] = a.add("MAT4", matrix({0, 0, 0}));
            }),
            "skin 0.inverseBindMatrices: has 1 matrices for 2 joints");
  EXPECT_EQ(refused([](GltfAsset& a) {
              std::vector<float> projective = matrix({0, 0, 0}), plain = projective;
              projective[3] = 1;
              projective.insert(projective.end(), plain.begin(), plain.end());
              a.json["skins"][0]["inverseBindMatrices"] = a.add("MAT4", projective);
            }),
            "skin 0.inverseBindMatrices: matrix 0 is not affine");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.attributes()["WEIGHTS_0"] = a.add<float>("VEC4", {1, 0, 0, 0});
            }),
            "mesh 0, primitive 0: JOINTS_0 and WEIGHTS_0 have not as many elements as there are vertices");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.json["nodes"].push_back({{"children", {5}}});
              a.json["nodes"].push_back({{"children", {4}}});
              a.json["skins"][0]["joints"] = {4, 5};
            }),
            "node 4: is below itself");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.json["nodes"].push_back({{"children", {2}}});
            }),
            "node 2: has more than one parent");
  EXPECT_EQ(refused([](GltfAsset& a) {
              a.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
                  {"TRANSLATION", a.add<float>("VEC3", {0, 0, 0})}};
            }),
            "node 0: EXT_mesh_gpu_instancing does not say where instances of a skinned mesh are");
}

// ---- meshopt --------------------------------------------------------------------------

/// A grid of n x n vertices on a bumpy sheet.
std::vector<float> grid_points(int n) {
  std::vector<float> points;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      points.insert(points.end(),
                    {static_cast<float>(i), static_cast<float>(j), static_cast<float>((i * 7 + j * 3) % 5)});
    }
  }
  return points;
}

std::vector<std::uint16_t> grid_triangles(int n) {
  std::vector<std::uint16_t> triangles;
  for (int j = 0; j + 1 < n; ++j) {
    for (int i = 0; i + 1 < n; ++i) {
      const int a = j * n + i;
      for (const int v : {a, a + 1, a + n + 1, a, a + n + 1, a + n}) triangles.push_back(static_cast<std::uint16_t>(v));
    }
  }
  return triangles;
}

std::string encode_vertices(const std::string& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::string result(meshopt_encodeVertexBufferBound(count, stride), '\0');
  result.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(result.data()), result.size(), bytes.data(),
                                           count, stride));
  return result;
}

std::string encode_triangles(const std::vector<std::uint16_t>& triangles, std::size_t vertices) {
  std::string result(meshopt_encodeIndexBufferBound(triangles.size(), vertices), '\0');
  result.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(result.data()), result.size(),
                                          triangles.data(), triangles.size()));
  return result;
}

std::string encode_sequence(const std::vector<std::uint16_t>& sequence, std::size_t vertices) {
  std::string result(meshopt_encodeIndexSequenceBound(sequence.size(), vertices), '\0');
  result.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(result.data()), result.size(),
                                            sequence.data(), sequence.size()));
  return result;
}

/// Puts compressed data in the place of a view; the plain data are in a buffer that is not there.
void compress(GltfAsset& asset, const char* extension, int view, const std::string& compressed, const std::string& mode,
              std::size_t stride, std::size_t count, const std::string& filter = "") {
  const int carrier = asset.add_view(compressed);
  Json& here = asset.json["bufferViews"][static_cast<std::size_t>(view)];
  Json how = {{"buffer", 0},
              {"byteOffset", asset.json["bufferViews"][static_cast<std::size_t>(carrier)]["byteOffset"]},
              {"byteLength", compressed.size()},
              {"byteStride", stride},
              {"count", count},
              {"mode", mode}};
  if (!filter.empty()) how["filter"] = filter;
  here = {{"buffer", 1}, {"byteOffset", 0}, {"byteLength", stride * count}, {"extensions", {{extension, how}}}};
  asset.json["buffers"] = {Json::object(),
                           {{"byteLength", stride * count}, {"extensions", {{extension, {{"fallback", true}}}}}}};
}

GltfAsset compressed_grid(const char* extension) {
  constexpr int n = 20;
  const std::vector<float> points = grid_points(n);
  const std::vector<std::uint16_t> triangles = grid_triangles(n);
  GltfAsset asset = GltfAsset::mesh({0, 0, 0}, {0});
  asset.require(extension);
  compress(asset, extension, 0, encode_vertices(bytes_of_values(points), 12), "ATTRIBUTES", 12, n * n);
  compress(asset, extension, 1, encode_triangles(triangles, n * n), "TRIANGLES", 2, triangles.size());
  asset.json["accessors"][0]["count"] = n * n;
  asset.json["accessors"][1]["count"] = triangles.size();
  return asset;
}

TEST(GltfSamples, BrainStemMeshopt) {
  constexpr int n = 20;
  const PolygonMesh plain = read("a.glb", GltfAsset::mesh(grid_points(n), grid_triangles(n)).binary());
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    const GltfAsset asset = compressed_grid(extension);
    for (const bool text : {false, true}) {
      const PolygonMesh mesh = text ? read("a.gltf", asset.text()) : read("a.glb", asset.binary());
      EXPECT_EQ(mesh.vertices, plain.vertices);
      // The codec turns the corners of triangles and keeps their order.
      ASSERT_EQ(mesh.polygon_count(), plain.polygon_count());
      for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
        const auto* const a = mesh.corners.data() + i;
        const auto* const b = plain.corners.data() + i;
        EXPECT_TRUE(std::equal(a, a + 3, b) || (a[0] == b[1] && a[1] == b[2] && a[2] == b[0]) ||
                    (a[0] == b[2] && a[1] == b[0] && a[2] == b[1]));
      }
    }
  }
}

TEST(GltfSamples, MeshoptIndexSequences) {
  GltfAsset asset = GltfAsset::mesh({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {0});
  asset.primitive()["mode"] = 5;
  compress(asset, "EXT_meshopt_compression", 1, encode_sequence({0, 1, 2, 3}, 4), "INDICES", 2, 4);
  asset.json["accessors"][1]["count"] = 4;
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2, 1, 3, 2}));
}

// A reader that does not know an optional extension finds the plain data: so does this one, and prefers them.
TEST(GltfSamples, MeshoptWithFallback) {
  GltfAsset asset = GltfAsset::triangle();
  const std::string other = encode_vertices(raw<float>({5, 5, 5, 6, 6, 6, 7, 7, 8}), 12);
  const int carrier = asset.add_view(other);
  asset.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"] = {
      {"buffer", 0},
      {"byteOffset", asset.json["bufferViews"][static_cast<std::size_t>(carrier)]["byteOffset"]},
      {"byteLength", other.size()},
      {"byteStride", 12},
      {"count", 3},
      {"mode", "ATTRIBUTES"}};
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  asset.require("EXT_meshopt_compression");
  expect_vertices(asset, {row(5, 5, 5), row(6, 6, 6), row(7, 7, 8)});
}

TEST(GltfSamples, MeshoptFilters) {
  constexpr std::size_t n = 3;
  // Exponents: floats of a few bits.
  const std::vector<float> points = {0, 0, 0, 1.5f, 0, 0, 0, -2.25f, 100};
  std::string filtered(n * 12, '\0');
  meshopt_encodeFilterExp(filtered.data(), n, 12, 15, points.data());
  GltfAsset asset = GltfAsset::mesh({0, 0, 0});
  compress(asset, "EXT_meshopt_compression", 0, encode_vertices(filtered, 12), "ATTRIBUTES", 12, n, "EXPONENTIAL");
  asset.json["accessors"][0]["count"] = n;
  expect_vertices(asset, {row(0, 0, 0), row(1.5, 0, 0), row(0, -2.25, 100)}, 0.01);
  // Quaternions, of instances.
  asset = GltfAsset::triangle();
  const auto s = static_cast<float>(half);
  const std::vector<float> turns = {0, 0, 0, 1, 0, 0, s, s};
  filtered.assign(2 * 8, '\0');
  meshopt_encodeFilterQuat(filtered.data(), 2, 8, 16, turns.data());
  const int rotations = asset.add<std::int16_t>("VEC4", {0, 0, 0, 0}, {{"normalized", true}});
  asset.json["accessors"][1]["count"] = 2;
  asset.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] = rotations;
  compress(asset, "EXT_meshopt_compression", 1, encode_vertices(filtered, 8), "ATTRIBUTES", 8, 2, "QUATERNION");
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0), row(0, 0, 0), row(0, 1, 0), row(-1, 0, 0)}, 1e-3);
  // Octahedra are for normals; that they are decoded shows in a position that is one.
  asset = GltfAsset::mesh({0, 0, 0});
  const std::vector<float> normals = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  filtered.assign(3 * 4, '\0');
  meshopt_encodeFilterOct(filtered.data(), 3, 4, 8, normals.data());
  asset.json["accessors"][0].update({{"count", 3}, {"componentType", 5120}, {"normalized", true}});
  compress(asset, "EXT_meshopt_compression", 0, encode_vertices(filtered, 4), "ATTRIBUTES", 4, 3, "OCTAHEDRAL");
  asset.json["bufferViews"][0]["byteStride"] = 4;
  expect_vertices(asset, {row(1, 0, 0), row(0, 1, 0), row(0, 0, 1)}, 0.02);
}

/// 300 points, by the encoder of meshoptimizer 1.2 at its highest level: every control mode of bytes, and every mode of
/// channels, one of them rotated.
constexpr std::string_view meshopt_version_1 =
    "oRrqAAAAAAAAEIAREYBAQEAREUAgICARESAgICARESAQEBARERAQEBARERAQEBARERAQEBARERAICAgREQgICAgREQgICAgREQgICAgREQgICAgR"
    "EQgICAgREQgICAgREQgICAgBAAAAEAF/AQD6BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foG"
    "Af36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foG"
    "Af36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgH9+gYB/foG"
    "Af36BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgFBEAQFgAEHCAAG2doAGKGiAGAWFQCA8AEA70EQBAWAAZiXAAZzdAAYXV4AYNzbAIBnAQBoQRAE"
    "BYAB1dYABm9wABgzNABgYmEAgPMBAPQBEAQFgAEEAwAYAgEAYAIBAIAEAQADmuoAABERCAQEBBERBAQEBBEBBAQE/foGAf36BgH9+gYB/foGAf36"
    "BgH9+gYB/foGAf36BgH9+gYB/foGAf36BgEBBgCRkgEGAF9gAQYA0M8BBgACAQAAAAAAAAAAAAAAAAAAAAAAAACAPwEiAA==";

TEST(GltfSamples, MeshoptVersion1) {
  constexpr std::size_t size = 574;
  const auto asset_of = [](const std::string& data, std::size_t length) {
    GltfAsset asset = GltfAsset::triangle();
    asset.require("KHR_meshopt_compression");
    asset.json["accessors"][0]["count"] = 300;
    asset.json["buffers"] = {
        Json::object(), {{"byteLength", 3600}}, {{"byteLength", length}, {"uri", "data:;base64," + data}}};
    asset.json["bufferViews"][0] = {
        {"buffer", 1},
        {"byteLength", 3600},
        {"extensions",
         {{"KHR_meshopt_compression",
           {{"buffer", 2}, {"byteLength", length}, {"byteStride", 12}, {"count", 300}, {"mode", "ATTRIBUTES"}}}}}};
    return asset.binary();
  };
  const std::string data(meshopt_version_1);
  const PolygonMesh mesh = read("a.glb", asset_of(data, size));
  ASSERT_EQ(mesh.vertices.rows(), 300);
  std::uint32_t noise = 1;
  for (int i = 0; i < 300; ++i) {
    noise = noise * 1664525u + 1013904223u;
    const float z = i % 50 == 7 ? static_cast<float>(noise >> 8) * 1e-6f : 1.0f;
    EXPECT_EQ(mesh.vertices.row(i), row(i / 4, (i % 4) * 0.25, z)) << i;
  }
  // Lengths rounded up to whole words, which some writers store, are understood; other bytes too many are not.
  const std::string start = data.substr(0, data.size() - 4);
  EXPECT_EQ(data.substr(start.size()), "AA==");
  EXPECT_EQ(read("a.glb", asset_of(start + "AAAA", size + 2)).vertices, mesh.vertices);
  EXPECT_NE(refusal("a.glb", asset_of(start + "AAAAAAAA", size + 5)), "");
  EXPECT_NE(refusal("a.glb", asset_of(start + "AAAB", size + 2)), "");
  // Three bytes, or groups of them, fewer.
  for (std::size_t cut = 4; cut < data.size(); cut += 4) {
    const std::string shorter = data.substr(0, data.size() - cut);
    EXPECT_EQ(refusal("a.glb", asset_of(shorter, shorter.size() / 4 * 3)),
              "buffer view 0.extensions.KHR_meshopt_compression: the compressed data are damaged")
        << cut;
  }
}

TEST(GltfSamples, MeshoptDataThatAreBroken) {
  const auto refused = [](const std::function<void(Json&, GltfAsset&)>& change) {
    GltfAsset asset = compressed_grid("EXT_meshopt_compression");
    change(asset.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"], asset);
    const std::string message = refusal("a.glb", asset.binary()),
                      place = "buffer view 0.extensions.EXT_meshopt_compression";
    return message.starts_with(place) ? message.substr(place.size()) : message;
  };
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["byteLength"] = 40; }), ": the compressed data are damaged");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["byteLength"] = 1 << 30; }), ": reaches beyond buffer 0");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["mode"] = "MAGIC"; }), ": the mode 'MAGIC' is unknown");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["byteStride"] = 6; }),
            ": byteStride 6 does not go with the mode ATTRIBUTES");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["byteStride"] = 0; }), ".byteStride: 0 is out of range");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["filter"] = "QUATERNION"; }),
            ": the filter QUATERNION is unknown, or does not go with byteStride 12");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["count"] = 1 << 18; }), ": the compressed data are damaged");
  EXPECT_EQ(refused([](Json& how, GltfAsset&) { how["count"] = 1 << 30; }),
            ": the compressed data unfold to more than a file of this size can mean");
  EXPECT_EQ(refused([](Json&, GltfAsset& asset) { asset.json["bufferViews"][0]["byteLength"] = 4801; }),
            "buffer view 0: has 4801 bytes, EXT_meshopt_compression decompresses to 4800");
  EXPECT_EQ(refused([](Json& how, GltfAsset& asset) { asset.data[how["byteOffset"].get<std::size_t>()] = '\xA1'; }),
            ": the compressed data are damaged");
  EXPECT_EQ(refused([](Json&, GltfAsset& asset) {
              Json& how = asset.json["bufferViews"][1]["extensions"]["EXT_meshopt_compression"];
              how["count"] = how["count"].get<int>() - 1;
            }),
            "buffer view 1.extensions.EXT_meshopt_compression: count 2165 is no whole number of triangles");
}

// ---- Draco -----------------------------------------------------------------------------

TEST(GltfSamples, DracoWithFallback) {
  GltfAsset asset = GltfAsset::triangle();
  Json& primitives = asset.json["meshes"][0]["primitives"];
  primitives.push_back(primitives[0]);
  for (int p = 0; p < 2; ++p) {  // the plain vertices are shared, the compressed ones not
    primitives[static_cast<std::size_t>(p)]["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", 77 + p}, {"attributes", {{"POSITION", 0}}}};
  }
  expect_vertices(asset, {row(0, 0, 0), row(1, 0, 0), row(0, 1, 0)});
  EXPECT_EQ(read("a.glb", asset.binary()).corners, indices({0, 1, 2, 0, 1, 2}));
}

#ifdef ENCAGE_WITH_DRACO

struct DracoData {
  std::string bytes;
  std::uint32_t positions, joints, weights;  ///< their numbers
};

/// The grid, each vertex bound to joint 0 or 1 by its column.
DracoData draco_grid(int n) {
  const std::vector<float> points = grid_points(n);
  const std::vector<std::uint16_t> triangles = grid_triangles(n);
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(triangles.size() / 3));
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const int joint = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_UINT8);
  const int weight = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 4, draco::DT_UINT8);
  for (std::size_t t = 0; t < triangles.size() / 3; ++t) {
    std::array<std::array<std::uint8_t, 4>, 3> joints{}, weights{};
    for (std::size_t k = 0; k < 3; ++k) {
      joints[k] = {static_cast<std::uint8_t>(triangles[3 * t + k] % 2), 0, 0, 0};
      weights[k] = {255, 0, 0, 0};
    }
    const draco::FaceIndex face(static_cast<std::uint32_t>(t));
    const auto point = [&](std::size_t k) { return points.data() + 3 * std::size_t{triangles[3 * t + k]}; };
    builder.SetAttributeValuesForFace(position, face, point(0), point(1), point(2));
    builder.SetAttributeValuesForFace(joint, face, joints[0].data(), joints[1].data(), joints[2].data());
    builder.SetAttributeValuesForFace(weight, face, weights[0].data(), weights[1].data(), weights[2].data());
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return {std::string(buffer.data(), buffer.size()), mesh->attribute(position)->unique_id(),
          mesh->attribute(joint)->unique_id(), mesh->attribute(weight)->unique_id()};
}

GltfAsset draco_asset(const DracoData& draco, int n) {
  GltfAsset asset = GltfAsset::triangle();
  asset.require("KHR_draco_mesh_compression");
  asset.json["accessors"] = {{{"componentType", 5126}, {"count", n * n}, {"type", "VEC3"}},
                             {{"componentType", 5123}, {"count", 6 * (n - 1) * (n - 1)}, {"type", "SCALAR"}},
                             {{"componentType", 5121}, {"count", n * n}, {"type", "VEC4"}},
                             {{"componentType", 5121}, {"count", n * n}, {"type", "VEC4"}, {"normalized", true}}};
  asset.primitive() = {
      {"attributes", {{"POSITION", 0}, {"JOINTS_0", 2}, {"WEIGHTS_0", 3}}},
      {"indices", 1},
      {"extensions",
       {{"KHR_draco_mesh_compression",
         {{"bufferView", asset.add_view(draco.bytes)},
          {"attributes",
           {{"POSITION", draco.positions}, {"JOINTS_0", draco.joints}, {"WEIGHTS_0", draco.weights}}}}}}}};
  return asset;
}

/// The corners of all triangles in an order of their own, in steps of a hundredth.
std::vector<std::array<long, 9>> sorted_triangles(const PolygonMesh& mesh) {
  std::vector<std::array<long, 9>> triangles;
  for (std::size_t i = 0; i < mesh.corners.size(); i += 3) {
    std::array<std::array<long, 3>, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      for (int d = 0; d < 3; ++d)
        corners[k][static_cast<std::size_t>(d)] = std::lround(mesh.vertices(mesh.corners[i + k], d) * 100 / 4) * 4;
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    std::array<long, 9> flat{};
    for (std::size_t k = 0; k < 9; ++k) flat[k] = corners[k / 3][k % 3];
    triangles.push_back(flat);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

TEST(GltfSamples, BoxDraco) {
  constexpr int n = 12;
  const PolygonMesh plain = read("a.glb", GltfAsset::mesh(grid_points(n), grid_triangles(n)).binary());
  const DracoData draco = draco_grid(n);
  GltfAsset asset = draco_asset(draco, n);
  const PolygonMesh mesh = read("a.glb", asset.binary());
  EXPECT_EQ(mesh.vertices.rows(), n * n);
  EXPECT_EQ(sorted_triangles(mesh), sorted_triangles(plain));
  EXPECT_EQ(notes_of("a.glb", asset.binary()), "");
  // Also where the extension is merely used, but the plain numbers are not there.
  asset.json.erase("extensionsRequired");
  EXPECT_EQ(sorted_triangles(read("a.glb", asset.binary())), sorted_triangles(plain));
}

TEST(GltfSamples, RiggedSimpleDraco) {
  constexpr int n = 12;
  GltfAsset asset = draco_asset(draco_grid(n), n);
  asset.node(0)["skin"] = 0;
  asset.json["nodes"].push_back(Json::object());
  asset.json["nodes"].push_back({{"translation", {0, 0, 50}}});
  asset.json["skins"] = {{{"joints", {1, 2}}}};
  // Odd columns follow the second joint.
  const PolygonMesh mesh = read("a.glb", asset.binary());
  int raised = 0;
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const bool odd = std::lround(mesh.vertices(v, 0) + 12 * mesh.vertices(v, 1)) % 2 != 0;
    EXPECT_EQ(mesh.vertices(v, 2) > 40, odd) << mesh.vertices.row(v);
    raised += odd ? 1 : 0;
  }
  EXPECT_EQ(raised, n * n / 2);
}

TEST(GltfSamples, DracoDataThatAreBroken) {
  constexpr int n = 5;
  const DracoData draco = draco_grid(n);
  const GltfAsset good = draco_asset(draco, n);
  GltfAsset asset = good;
  asset.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  EXPECT_EQ(refusal("a.glb", asset.binary()), "mesh 0, primitive 0: Draco's data have no attribute 77");
  asset.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = draco.joints;
  EXPECT_EQ(refusal("a.glb", asset.binary()),
            "mesh 0, primitive 0: Draco's attribute " + std::to_string(draco.joints) + " has 4 components, not 3");
  asset.primitive()["mode"] = 6;
  EXPECT_EQ(refusal("a.glb", asset.binary()), "mesh 0, primitive 0: KHR_draco_mesh_compression has no triangle fans");
  for (std::size_t cut = 1; cut < draco.bytes.size(); cut += 5) {
    const DracoData shorter{draco.bytes.substr(0, draco.bytes.size() - cut), draco.positions, draco.joints,
                            draco.weights};
    const std::string message = refusal("a.glb", draco_asset(shorter, n).binary());
    EXPECT_EQ(message.find("mesh 0, primitive 0: Draco cannot decompress the data"), 0u) << cut << ' ' << message;
  }
}

#else

TEST(GltfSamples, DracoIsRefusedByName) {
  GltfAsset asset = GltfAsset::triangle();
  const std::string remedy =
      "KHR_draco_mesh_compression, which this build of Encage cannot read; install Draco (Debian: libdraco-dev) and "
      "build "
      "Encage again, or decompress the file, for example with gltf-pipeline";
  asset.primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                   {"attributes", {{"POSITION", 0}}}};
  asset.json["accessors"][0].erase("bufferView");
  EXPECT_EQ(refusal("a.glb", asset.binary()), "mesh 0, primitive 0: it is compressed with " + remedy);
  asset.require("KHR_draco_mesh_compression");
  EXPECT_EQ(refusal("a.glb", asset.binary()), "the file requires the extension " + remedy);
}

#endif

}  // namespace
}  // namespace encage
