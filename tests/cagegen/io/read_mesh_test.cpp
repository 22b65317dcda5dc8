// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/reading.h"
#include "tests/cagegen/io/shapes.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace encage {
namespace {

using namespace test;

// ---- OFF -------------------------------------------------------------------

TEST(ReadOff, KeepsPolygonsAndSkipsColours) {
  const PolygonMesh mesh = read("a.off",
                                "# made by hand\r\nCOFF # colours\r\n5 2 0\r\n\r\n0 0 0 255 0 0 255\r\n"
                                "1 0 0\r\n1 1 0\r\n0 1 0\r\n0.5 0.5 1e-3\r\n4 0 1 2 3 0.5 0.5 0.5\r\n3 0 1 4\r\n");
  EXPECT_EQ(mesh.vertices.rows(), 5);
  EXPECT_EQ(mesh.vertices(4, 2), 1e-3);
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 3, 0, 1, 4}));
  EXPECT_EQ(mesh.first, (std::vector<std::int64_t>{0, 4, 7}));
}

TEST(ReadOff, AllowsHeaderVariants) {
  EXPECT_EQ(read("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").polygon_count(), 1);
  EXPECT_EQ(read("a.OFF", "3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").polygon_count(), 1);
  EXPECT_EQ(read("a.off", "STCNOFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").polygon_count(), 1);
  EXPECT_EQ(read("a.off", "4OFF 3 1 0\n0 0 0 1\n1 0 0 2\n0 1 0 1\n3 0 1 2").vertices(1, 0), 0.5);
}

TEST(ReadOff, RefusesMalformedFiles) {
  EXPECT_EQ(refusal("a.off", "PLY\n"), "line 1: not an OFF file");
  EXPECT_EQ(refusal("a.off", "OFF\nx 1 0\n"), "line 2: expected the number of vertices");
  EXPECT_EQ(refusal("a.off", "OFF\n3 -1 0\n"), "line 2: expected the number of faces");
  EXPECT_EQ(refusal("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"), "no faces (3 vertices)");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n"), "vertex 2: line 5: the file ends early");
  EXPECT_EQ(refusal("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), "face 1: line 7: the file ends early");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n"),
            "vertex 1: line 4: 'zero' is not a number");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"),
            "vertex 1: line 4: coordinate 'nan' is not finite");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 1e999 0\n0 1 0\n3 0 1 2\n"),
            "vertex 1: line 4: coordinate '1e999' is not finite");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "face 0: line 6: vertex index 3 is out of range (3 vertices)");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "face 0: line 6: vertex index -1 is out of range (3 vertices)");
  EXPECT_EQ(refusal("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
            "face 0: line 6: has 2 corners, needs at least 3");
  EXPECT_EQ(refusal("a.off", "OFF BINARY\n"), "line 1: binary OFF is not supported");
}

TEST(ReadOff, DoesNotTrustCountsWithMemory) {
  EXPECT_EQ(refusal("a.off", "OFF\n9000000000000000 9000000000000000 0\n0 0 0\n"),
            "vertex 1: line 4: the file ends early");
  EXPECT_EQ(refusal("a.off", "OFF\n1 1 0\n0 0 0\n9000000000000000 0 0\n"), "face 0: line 5: the file ends early");
}

// ---- OBJ -------------------------------------------------------------------

TEST(ReadObj, UnderstandsTheUsualLines) {
  const PolygonMesh mesh = read("a.obj",
                                "mtllib a.mtl\no thing\nv 0 0 0 0.1 0.2 0.3\nv +1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n"
                                "vt 0 0\ng side\nusemtl red\nf 1/1/1\t2/1/1 3//1 4\nl 1 2\np 3\nv 0 0 -1e-400\n"
                                "f -1 -2 \\\n -3\n");
  EXPECT_EQ(mesh.vertices.rows(), 5);
  EXPECT_EQ(mesh.vertices(1, 0), 1);
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 3, 4, 3, 2}));
  EXPECT_EQ(mesh.polygon_count(), 2);
}

TEST(ReadObj, AllowsFacesBeforeVertices) {
  EXPECT_EQ(read("a.obj", "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").corners, indices({0, 1, 2}));
}

TEST(ReadObj, RefusesMalformedFiles) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_EQ(refusal("a.obj", "hello world\n"), "no faces (0 vertices)");
  EXPECT_EQ(refusal("a.obj", vertices), "no faces (3 vertices)");
  EXPECT_EQ(refusal("a.obj", "v 0 0\nv 1 0 0\n"), "vertex 0: line 1: too few coordinates");
  EXPECT_EQ(refusal("a.obj", "v 0 0 inf\n"), "vertex 0: line 1: coordinate 'inf' is not finite");
  EXPECT_EQ(refusal("a.obj", "v 0 0 1.0.0\n"), "vertex 0: line 1: '1.0.0' is not a number");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 4\n"), "face 0: line 4: vertex index 4 is out of range (3 vertices)");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 0\n"),
            "face 0: line 4: vertex index 0 is out of range (3 vertices so far)");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 -4\n"),
            "face 0: line 4: vertex index -4 is out of range (3 vertices so far)");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 3\nf\n"), "face 1: line 5: has no corners");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 x\n"), "face 0: line 4: 'x' is not an integer");
  EXPECT_EQ(refusal("a.obj", vertices + "f 1 2 /3\n"), "face 0: line 4: corner without a vertex index");
}

// ---- PLY -------------------------------------------------------------------

constexpr const char* ply_header =
    "element vertex 4\ncomment colours come first\nproperty uchar red\nproperty float x\nproperty float y\n"
    "property float z\nproperty list uchar int tags\nelement edge 1\nproperty int a\nelement face 1\n"
    "property short flags\nproperty list uchar ushort vertex_index\nend_header\n";

TEST(ReadPly, ReadsText) {
  const PolygonMesh mesh =
      read("a.ply", std::string("ply\r\nformat ascii 1.0\r\n") + ply_header +
                        "255 0 0 0 0\n255 1 0 0 2 7 7\n255 1 1 0 0\n255 0 1 0.1 0\n5\n-1 4 0 1 2 3\n");
  EXPECT_EQ(mesh.vertices(3, 2), 0.1);  // as the text says, not as a float holds it
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 3}));
}

TEST(ReadPly, ReadsBothByteOrders) {
  std::string little, big;
  const auto add = [&](const std::string& value) {
    little += value;
    big.append(value.rbegin(), value.rend());
  };
  for (const float x : {0.f, 1.f, 2.f, 3.f}) {
    add("\x7f");
    for (const float c : {x, x * x, 0.1f}) add(raw({c}));
    add(std::string(1, '\0'));
  }
  add(raw({std::int32_t{5}}));
  add(raw({std::int16_t{-2}}));
  add("\x03");
  for (const int i : {3, 2, 0}) add(raw({static_cast<std::uint16_t>(i)}));
  for (const auto& [format, body] : {std::pair("binary_little_endian", little), std::pair("binary_big_endian", big)}) {
    const std::string bytes = std::string("ply\nformat ") + format + " 1.0\n" + ply_header + body;
    const PolygonMesh mesh = read("a.ply", bytes);
    EXPECT_EQ(mesh.corners, indices({3, 2, 0})) << format;
    EXPECT_EQ(mesh.vertices(3, 1), 9) << format;
    EXPECT_EQ(mesh.vertices(3, 2), static_cast<double>(0.1f)) << format;
    // Wherever it is cut, it is refused.
    for (std::size_t size = bytes.size() - 1; size > 0; size -= std::min<std::size_t>(size, 3)) {
      EXPECT_NE(refusal("a.ply", bytes.substr(0, size)), "") << format << ' ' << size;
    }
  }
}

TEST(ReadPly, RefusesMalformedFiles) {
  const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string head = "ply\nformat ascii 1.0\n", points = "0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(refusal("a.ply", "plz\n"), "header line 1: not a PLY file");
  EXPECT_EQ(refusal("a.ply", "ply\nformat utf8 1.0\n"), "header line 2: unknown format 'utf8'");
  EXPECT_EQ(refusal("a.ply", head + vertices), "header line 7: the header ends early");
  EXPECT_EQ(refusal("a.ply", head + "element vertex 1\nproperty int128 x\n"), "header line 4: unknown type 'int128'");
  EXPECT_EQ(refusal("a.ply", head + "element vertex many\n"), "header line 3: bad number of 'vertex'");
  EXPECT_EQ(refusal("a.ply", head + "element vertex 1\nproperty float x\nend_header\n1\n"),
            "the vertices have no property 'y'");
  EXPECT_EQ(refusal("a.ply", head + vertices + "end_header\n" + points), "no faces (3 vertices)");
  EXPECT_EQ(refusal("a.ply", head + vertices + "element face 1\nproperty int x\nend_header\n" + points + "1\n"),
            "the faces have no list 'vertex_indices'");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + "0 0 0\n1 0"),
            "vertex 1: the file ends early: the header promises more");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + points + "3 0 1"),
            "face 0: the file ends early: the header promises more");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + points + "3 0 1 3"),
            "face 0: vertex index 3 is out of range (3 vertices)");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + points + "3 0 1 -1"),
            "face 0: vertex index -1 is out of range (3 vertices)");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + points + "2 0 1"), "face 0: has 2 corners, needs at least 3");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + points + "3 0 1 1.5"), "face 0: expected an integer");
  EXPECT_EQ(refusal("a.ply", head + vertices + faces + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2"),
            "vertex 1: coordinate is not finite");
}

// ---- STL -------------------------------------------------------------------

TEST(ReadStl, SharesVertices) {
  const PolygonMesh mesh = read("a.stl", binary_stl(2, {{0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, -0.f, 1, 0, 0, 1, 1, 0}}));
  EXPECT_EQ(mesh.vertices.rows(), 4);
  EXPECT_EQ(mesh.corners, indices({0, 1, 2, 2, 1, 3}));
}

TEST(ReadStl, ReadsText) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1.5e0 0\nendloop\nendfacet\n";
  EXPECT_EQ(read("a.stl", "solid a # b\n" + facet + "endsolid a\nsolid\n" + facet + "endsolid\n").corners,
            indices({0, 1, 2, 0, 1, 2}));
  EXPECT_EQ(read("a.stl", "  SOLID\n" + facet + "EndSolid\n").vertices(2, 1), 1.5);
  EXPECT_EQ(refusal("a.stl", "solid\n" + facet.substr(0, facet.find("1 0 0") + 3)),
            "face 0: line 5: the file ends early");
  EXPECT_EQ(refusal("a.stl", "solid\nendsolid\n"), "no faces (0 vertices)");
  EXPECT_EQ(refusal("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n"),
            "face 0: line 4: coordinate 'nan' is not finite");
  EXPECT_EQ(refusal("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\n"),
            "face 0: line 5: expected 'vertex'");
  EXPECT_EQ(refusal("a.stl", "solid\nhello\n"), "line 2: expected 'facet' or 'endsolid'");
}

TEST(ReadStl, RefusesMalformedBinary) {
  const std::array<float, 9> t = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(refusal("a.stl", "MZ"), "not an STL file: too short for a header");
  EXPECT_EQ(refusal("a.stl", binary_stl(3, {t, t})), "the header promises 3 triangles, the file holds 2");
  EXPECT_EQ(refusal("a.stl", binary_stl(1, {t, t})), "the header promises 1 triangles, the file holds 2");
  EXPECT_EQ(refusal("a.stl", binary_stl(0, {})), "no faces (0 vertices)");
  EXPECT_EQ(refusal("a.stl", binary_stl(2, {t, {0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 1, 0}})),
            "face 1: coordinate is not finite");
}

// ---- Any -------------------------------------------------------------------

TEST(ReadPolygonMesh, RefusesWhatItCannotOpen) {
  const Folder folder;
  EXPECT_THROW(read_polygon_mesh(folder / "missing.obj"), Error);
  std::filesystem::create_directory(folder / "folder.obj");
  EXPECT_THROW(read_polygon_mesh(folder / "folder.obj"), Error);
  EXPECT_TRUE(refusal("a.xyz", "0 0 0").starts_with("unknown format 'xyz' (known: obj ply stl off gltf glb); "));
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off", "a.gltf", "a.glb"}) {
    EXPECT_EQ(refusal(name, ""), "the file is empty");
  }
}

TEST(ReadPolygonMesh, KeepsQuadsOfALargeMesh) {
  constexpr int n = 300;
  std::string text;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) text += "v " + std::to_string(i) + ' ' + std::to_string(j) + " 0\n";
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1;
      text += "f";
      for (const int v : {a, a + 1, a + n + 2, a + n + 1}) text += ' ' + std::to_string(v);
      text += '\n';
    }
  }
  const PolygonMesh mesh = read("a.obj", text);
  ASSERT_EQ(mesh.polygon_count(), n * n);
  for (std::int64_t p = 0; p < mesh.polygon_count(); ++p) ASSERT_EQ(mesh.first[p + 1] - mesh.first[p], 4);
  EXPECT_EQ(triangulate(mesh).triangles.rows(), 2 * n * n);
}

}  // namespace
}  // namespace encage
