// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/gltf_asset.h"
#include "tests/cagegen/io/reading.h"

#include <encage/bake.h>

#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdint>
#include <fstream>
#include <optional>
#include <string>

// What reading takes: 64 MiB, and ten times the file (docs/formats.md). The files are those of which each byte takes
// the most memory, large enough that the 64 MiB would not hide it.

namespace encage {
namespace {

using namespace test;
using Json = nlohmann::json;

constexpr std::int64_t mebi = 1 << 20;

/// Bytes. A value of /proc/self/status.
std::int64_t status_of(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::stoll(line.substr(name.size() + 1)) * 1024;
  }
  return 0;
}

/// Bytes that reading took at the most, whether the file was refused or not. No value where that cannot be measured.
std::optional<std::int64_t> memory_of(const std::string& format, const std::string& bytes) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return std::nullopt;  // sanitizers keep what was freed
#endif
  malloc_trim(0);
  std::ofstream reset("/proc/self/clear_refs");
  if (!(reset << 5 << std::flush)) return std::nullopt;
  const std::int64_t before = status_of("VmRSS");
  try {
    decode_polygon_mesh(bytes, format, "a." + format);
  } catch (const Error&) {
    // Refusals have to be as modest.
  }
  return status_of("VmHWM") - before;
}

void expect_bounded(const std::string& format, const std::string& bytes, std::int64_t per_byte = 10) {
  const auto memory = memory_of(format, bytes);
  if (!memory) GTEST_SKIP() << "memory cannot be measured";
  const auto size = static_cast<std::int64_t>(bytes.size());
  EXPECT_LE(*memory, 64 * mebi + per_byte * size)
      << bytes.substr(0, 40) << ": " << (*memory - 64 * mebi) / size << " bytes for each of " << size;
}

/// The message of a refusal. Not by a file, which would be a seed of fuzzing: these are slow to read.
std::string message_of(const std::string& glb) {
  try {
    decode_polygon_mesh(glb, "glb", "a.glb");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

std::string repeated(const std::string& text, std::size_t count) {
  std::string result;
  result.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

constexpr std::size_t many = 5 << 20;

TEST(ReadMemory, OfText) {
  const std::string n = std::to_string(many), ply = "ply\nformat ascii 1.0\n",
                    point = "property float x\nproperty float y\nproperty float z\n";
  expect_bounded("obj", repeated("v 0 0 0\n", many) + "f 1 1 1\n");
  expect_bounded("obj", "v 0 0 0\n" + repeated("f 1 1 1\n", many));
  expect_bounded("obj", "v 0 0 0\nf" + repeated(" 1", 2 * many) + "\n");
  expect_bounded("off", "OFF " + n + " 1\n" + repeated("0 0 0\n", many) + "3 0 0 0\n");
  expect_bounded("off", "OFF 1 " + n + "\n0 0 0\n" + repeated("3 0 0 0\n", many));
  expect_bounded("ply", ply + "element vertex " + n + "\n" + point + "end_header\n" + repeated("0 0 0\n", many));
  expect_bounded("ply", ply + "element face " + n + "\nproperty list int int vertex_indices\nend_header\n" +
                            repeated("3 0 0 0\n", many));
  expect_bounded("stl", "solid\n" + repeated("facet\nouter loop\nvertex 0 0 0 vertex 0 0 1 vertex 0 1 0\n"
                                             "endloop endfacet\n",
                                             many / 8));
}

TEST(ReadMemory, OfBinaryFiles) {
  const std::string n = std::to_string(many), ply = "ply\nformat binary_little_endian 1.0\n";
  const auto faces = [&](const std::string& count, const std::string& type) {
    return ply + "element face " + count + "\nproperty list " + type + " vertex_indices\nend_header\n";
  };
  expect_bounded("ply", faces(n, "uchar int") + repeated(std::string("\3\0\0\0\0\0\0\0\0\0\0\0\0", 13), many));
  expect_bounded("ply", faces(n, "uchar char") + repeated(std::string("\3\0\0\0", 4), many));
  expect_bounded("ply", faces("1", "int char") + raw<std::int32_t>({4 * many}) + std::string(4 * many, '\0'));
  expect_bounded("stl", std::string(80, '\0') + raw<std::uint32_t>({many / 4}) + std::string(many / 4 * 50, '\0'));
  // The one exception: coordinates of one byte each, which become eight, twice for a moment.
  expect_bounded("ply",
                 ply + "element vertex " + n + "\nproperty char x\nproperty char y\nproperty char z\nend_header\n" +
                     std::string(3 * many, '\0'),
                 16);
}

/// An accessor of zeros but for one element, which takes no bytes of the file.
Json zeros(const char* type, int component, std::int64_t count) {
  return {{"type", type},
          {"componentType", component},
          {"count", count},
          {"sparse",
           {{"count", 1}, {"indices", {{"bufferView", 0}, {"componentType", 5125}}}, {"values", {{"bufferView", 0}}}}}};
}

// Found by fuzzing and by reading for it: small files that unfold.
TEST(ReadMemory, OfGltfThatUnfolds) {
  constexpr std::int64_t most = 1 << 18;
  GltfAsset asset;
  asset.add_view(std::string(64, '\0'));
  asset.json["accessors"] = {zeros("VEC3", 5126, most), zeros("SCALAR", 5125, most)};
  asset.json["nodes"] = {{{"mesh", 0}}};
  asset.json["scenes"] = {{{"nodes", {0}}}};
  const Json primitive = {{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", 5}};
  asset.json["meshes"] = {{{"primitives", {primitive}}}};
  expect_bounded("glb", asset.binary());

  // Forty meshes, each of them nowhere.
  GltfAsset nowhere = asset;
  const int none = nowhere.add_accessor({{"type", "VEC3"}, {"componentType", 5126}, {"count", 0}, {"bufferView", 0}});
  nowhere.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = none;
  for (int n = 1; n < 40; ++n) {
    nowhere.json["nodes"].push_back(nowhere.node(0));
    nowhere.json["nodes"].back()["mesh"] = n;
    nowhere.json["meshes"].push_back(nowhere.json["meshes"][0]);
    nowhere.json["scenes"][0]["nodes"].push_back(n);
  }
  expect_bounded("glb", nowhere.binary());
  EXPECT_EQ(message_of(nowhere.binary()), "a.glb: no triangles in the scene");

  // Joints, weights and displacements of vertices that are not there.
  GltfAsset skinned = asset;
  skinned.json["accessors"].push_back(zeros("VEC4", 5121, most));
  skinned.json["accessors"].push_back(zeros("VEC4", 5126, most));
  skinned.primitive()["attributes"].update({{"JOINTS_0", 2}, {"WEIGHTS_0", 3}});
  skinned.primitive()["targets"] = {{{"POSITION", 0}}};
  skinned.json["meshes"][0]["weights"] = {1.0};
  skinned.json["skins"] = {{{"joints", {0}}}};
  skinned.node(0)["skin"] = 0;
  expect_bounded("glb", skinned.binary());
}

// Nothing unfolds by them but the list of instances, at each of any number of nodes.
TEST(ReadMemory, OfInstancesWithoutTriangles) {
  GltfAsset empty = GltfAsset::mesh(std::vector<float>(9, 0));
  empty.primitive()["mode"] = 0;
  Json translations = empty.json["accessors"][0];
  translations.erase("bufferView");
  translations["count"] = 1 << 17;
  empty.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      empty.add_accessor(translations);
  EXPECT_EQ(message_of(empty.binary()), "a.glb: no triangles in the scene (skipped: 1 primitive of points)");
  for (int n = 1; n < 4; ++n) {
    empty.json["nodes"].push_back(empty.node(0));
    empty.json["scenes"][0]["nodes"].push_back(n);
  }
  EXPECT_EQ(message_of(empty.binary()),
            "a.glb: node 2.extensions.EXT_mesh_gpu_instancing.attributes: a file of this size cannot mean 131072 more "
            "instances");
  empty.json["accessors"].back()["count"] = INT64_MAX;
  empty.node(0)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"_ID", 1}};
  EXPECT_EQ(message_of(empty.binary()),
            "a.glb: node 0.extensions.EXT_mesh_gpu_instancing.attributes: a file of this size cannot mean "
            "9223372036854775807 instances");
}

// Views that name the same compressed data: version 1 of the attribute codec, where 256 elements of zeros take 3 bytes.
TEST(ReadMemory, OfCompressedDataThatUnfold) {
  constexpr int count = 256 * 400, views = 60;
  const std::string data = '\xA1' + std::string(3 * 400, '\xAA') + std::string(24, '\0');
  GltfAsset asset;
  asset.add_view(data);
  asset.json["buffers"] = {Json::object(), {{"byteLength", count * 12}}};
  const Json how = {
      {"buffer", 0}, {"byteLength", data.size()}, {"byteStride", 12}, {"count", count}, {"mode", "ATTRIBUTES"}};
  asset.require("KHR_meshopt_compression");
  for (int v = 0; v < views; ++v) {
    asset.json["bufferViews"].push_back(
        {{"buffer", 1}, {"byteLength", count * 12}, {"extensions", {{"KHR_meshopt_compression", how}}}});
    asset.json["accessors"].push_back({{"type", "VEC3"}, {"componentType", 5126}, {"count", 3}, {"bufferView", v + 1}});
    asset.json["meshes"].push_back({{"primitives", {{{"attributes", {{"POSITION", v}}}}}}});
    asset.json["nodes"].push_back({{"mesh", v}});
    asset.json["scenes"][0]["nodes"].push_back(v);
  }
  expect_bounded("glb", asset.binary());
  EXPECT_NE(message_of(asset.binary()).find("the compressed data unfold to more than a file of this size can mean"),
            std::string::npos);
}

}  // namespace
}  // namespace encage
