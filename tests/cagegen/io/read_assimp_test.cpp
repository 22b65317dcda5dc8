// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/read_assimp.h"

#include "tests/cagegen/io/reading.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#ifdef ENCAGE_WITH_ASSIMP
#include <assimp/Exporter.hpp>
#include <assimp/scene.h>
#endif

namespace encage {
namespace {

using namespace test;

#ifdef ENCAGE_WITH_ASSIMP

/// A scene of one box whose faces share no corners and have normals of their own, as modellers write it. Its node moves
/// it by (10, 0, 0).
aiScene* box_scene() {
  const TriangleMesh box = test::box();
  auto* scene = new aiScene;
  scene->mNumMaterials = 1;
  scene->mMaterials = new aiMaterial* [1] { new aiMaterial };
  auto* mesh = new aiMesh;
  mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  mesh->mNumVertices = 36;
  mesh->mVertices = new aiVector3D[36];
  mesh->mNormals = new aiVector3D[36];
  mesh->mNumFaces = 12;
  mesh->mFaces = new aiFace[12];
  for (unsigned int t = 0; t < 12; ++t) {
    const Eigen::Vector3d a = box.corner(t, 0), b = box.corner(t, 1), c = box.corner(t, 2);
    const Eigen::Vector3f normal = (b - a).cross(c - a).normalized().cast<float>();
    aiFace& face = mesh->mFaces[t];
    face.mNumIndices = 3;
    face.mIndices = new unsigned int[3];
    for (unsigned int k = 0; k < 3; ++k) {
      const Eigen::Vector3f p = box.corner(t, static_cast<int>(k)).cast<float>();
      face.mIndices[k] = 3 * t + k;
      mesh->mVertices[3 * t + k] = aiVector3D(p.x(), p.y(), p.z());
      mesh->mNormals[3 * t + k] = aiVector3D(normal.x(), normal.y(), normal.z());
    }
  }
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { mesh };
  auto* node = new aiNode("box");
  node->mNumMeshes = 1;
  node->mMeshes = new unsigned int[1]{0};
  node->mTransformation.a4 = 10;
  scene->mRootNode = new aiNode("root");
  scene->mRootNode->addChildren(1, &node);
  return scene;
}

TEST(ReadAssimp, SplitVerticesAreWelded) {
  for (const auto& [exporter, extension] : std::vector<std::pair<std::string, std::string>>{
           {"collada", "dae"}, {"3ds", "3ds"}, {"fbxa", "fbx"}, {"3mf", "3mf"}, {"x", "x"}, {"x3d", "x3d"}}) {
    const Folder folder;
    const std::filesystem::path file = folder / ("box." + extension);
    const std::unique_ptr<aiScene> scene(box_scene());
    ASSERT_EQ(Assimp::Exporter().Export(scene.get(), exporter, file.string()), aiReturn_SUCCESS) << exporter;
    ReadNotes notes;
    const TriangleMesh mesh = read_mesh(file, &notes);
    EXPECT_EQ(mesh.vertices.rows(), 8) << extension;
    EXPECT_EQ(mesh.triangles.rows(), 12) << extension;
    EXPECT_TRUE(is_closed(mesh)) << extension;
    EXPECT_NEAR(signed_volume(mesh), 1, 1e-6) << extension;
    ASSERT_FALSE(notes.empty());
    EXPECT_EQ(notes[0], "read by Assimp: coordinates in float32, split vertices welded") << extension;
    // Assimp does not export where nodes are to these formats, or exports it wrongly.
    if (extension == "3ds" || extension == "3mf") continue;
    EXPECT_NEAR(mesh.vertices.col(0).minCoeff(), 10, 1e-5) << extension;
  }
}

/// COLLADA of two instances of one quadrangle: one moved, one mirrored.
std::string collada(const std::string& asset, const std::string& nodes) {
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>)" +
         asset +
         R"(</asset><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="12">
0 0 0 1 0 0 1 1 0 0 1 0</float_array><technique_common><accessor source="#a" count="4" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor>
</technique_common></source><vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="1"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4</vcount><p>0 1 2 3</p></polylist>
</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s">)" +
         nodes + R"(</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

const std::string instance = R"(<instance_geometry url="#g"/></node>)";

TEST(ReadAssimp, PolygonsAreKeptAndNodesPlaceThem) {
  const PolygonMesh mesh = read("a.dae", collada("", "<node id=\"a\"><translate>5 0 0</translate>" + instance +
                                                         "<node id=\"b\"><scale>-1 1 1</scale>" + instance));
  ASSERT_EQ(mesh.polygon_count(), 2);
  ASSERT_EQ(mesh.corners.size(), 8U);
  EXPECT_EQ(mesh.vertices.col(0).maxCoeff(), 6);
  EXPECT_EQ(mesh.vertices.col(0).minCoeff(), -1);
  // A mirrored instance keeps its outside: the corners turn.
  const TriangleMesh triangles = triangulate(mesh);
  for (std::int64_t t = 0; t < 4; ++t) {
    const Eigen::Vector3d a = triangles.corner(t, 0);
    EXPECT_GT((triangles.corner(t, 1) - a).cross(triangles.corner(t, 2) - a).z(), 0);
  }
}

/// Lengths are in metres, as COLLADA's unit says; axes are those of the file.
TEST(ReadAssimp, UnitsAndAxes) {
  const std::string node = "<node id=\"a\">" + instance;
  const PolygonMesh mesh = read("a.dae", collada(R"(<unit name="inch" meter="0.5"/><up_axis>Z_UP</up_axis>)", node));
  EXPECT_EQ(mesh.vertices.colwise().maxCoeff(), Eigen::RowVector3d(0.5, 0.5, 0));
}

TEST(ReadAssimp, DamagedFilesAreRefusedWithItsReason) {
  const std::string text = collada("", "<node id=\"a\">" + instance);
  EXPECT_TRUE(refusal("a.dae", text.substr(0, text.size() / 2)).starts_with("Assimp cannot read it: "));
  EXPECT_TRUE(refusal("a.3ds", "MM").starts_with("Assimp cannot read it: "));
  EXPECT_EQ(refusal("a.fbx", ""), "the file is empty");
  EXPECT_NE(refusal("a.dae", collada("", "<node id=\"a\"></node>")), "");
}

TEST(ReadAssimp, UnknownFormatsNameTheKnownOnes) {
  const std::string message = refusal("a.xyz", "0 0 0");
  EXPECT_TRUE(message.starts_with("unknown format 'xyz' (known: obj ply stl off gltf glb); Assimp reads: ")) << message;
  for (const char* format : {" dae", " 3ds", " fbx", " 3mf"}) EXPECT_NE(message.find(format), std::string::npos);
  EXPECT_FALSE(io::assimp_reads("obj"));
  EXPECT_FALSE(io::assimp_reads("ds"));
}

#else

TEST(ReadAssimp, TheMessageSaysWhatIsMissing) {
  const std::string message = refusal("a.dae", "<COLLADA/>");
  EXPECT_TRUE(
      message.starts_with("unknown format 'dae' (known: obj ply stl off gltf glb); this build of Encage lacks "
                          "Assimp"))
      << message;
  EXPECT_NE(message.find("libassimp-dev"), std::string::npos);
}

#endif

}  // namespace
}  // namespace encage
