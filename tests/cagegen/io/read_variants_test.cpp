// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/io/reading.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

// What programs write that is not quite their format: read as what it means and noted, or refused by name; never read
// as something else.

namespace encage {
namespace {

using namespace test;

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// ASCII as UTF-16 or UTF-32 without a byte order mark.
std::string widened(std::string_view text, std::size_t size, bool big_endian) {
  std::string wide(text.size() * size, '\0');
  for (std::size_t i = 0; i < text.size(); ++i) wide[i * size + (big_endian ? size - 1 : 0)] = text[i];
  return wide;
}

/// A closed box (corner x + 2 y + 4 z), each format in text.
const std::vector<std::array<int, 3>> box_faces = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};

std::string corner(int v) {
  return std::to_string(v & 1) + ' ' + std::to_string(v >> 1 & 1) + ' ' + std::to_string(v >> 2);
}

std::string box_vertices(const std::string& prefix) {
  std::string text;
  for (int v = 0; v < 8; ++v) text += prefix + corner(v) + '\n';
  return text;
}

std::string box_polygons(const std::string& prefix, int base) {
  std::string text;
  for (const auto& face : box_faces) {
    text += prefix;
    for (const int v : face) text += ' ' + std::to_string(v + base);
    text += '\n';
  }
  return text;
}

const std::string ply_vertices = "element vertex 8\nproperty float x\nproperty float y\nproperty float z\n";
const std::string ply_faces = "element face 12\nproperty list uchar int vertex_indices\n";
const std::string ply_strips = "element tristrips 1\nproperty list int int vertex_indices\n";

std::string box_of(const std::string& format) {
  if (format == "obj") return box_vertices("v ") + box_polygons("f", 1);
  if (format == "off") return "OFF\n8 12 0\n" + box_vertices("") + box_polygons("3", 0);
  if (format == "ply") {
    return "ply\nformat ascii 1.0\ncomment a box\n" + ply_vertices + ply_faces + "end_header\n" + box_vertices("") +
           box_polygons("3", 0);
  }
  std::string text = "solid box\n";
  for (const auto& face : box_faces) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const int v : face) text += "  vertex " + corner(v) + '\n';
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid box\n";
}

/// Box, closed and outward, of 8 vertices.
void expect_box(const PolygonMesh& polygons, const std::string& what) {
  const TriangleMesh mesh = triangulate(polygons);
  EXPECT_EQ(mesh.vertices.rows(), 8) << what;
  EXPECT_EQ(mesh.triangles.rows(), 12) << what;
  EXPECT_TRUE(is_closed(mesh)) << what;
  EXPECT_EQ(signed_volume(mesh), 1) << what;
}

// ---- Text of every format ---------------------------------------------------

TEST(ReadVariants, LinesEndInLfCrLfOrCr) {
  for (const std::string format : {"obj", "off", "ply", "stl"}) {
    for (const std::string_view end : {"\n", "\r\n", "\r"}) {
      const std::string text = replaced(box_of(format), "\n", end);
      expect_box(read("a." + format, text), format);
      EXPECT_EQ(notes_of("a." + format, text), "");
      // A comment ends where its line does.
      if (format == "obj" || format == "off") {
        expect_box(read("a." + format, "# made by hand" + std::string(end) + text), format);
      }
    }
  }
}

TEST(ReadVariants, OneFileMayMixThem) {
  const std::string obj = replaced(box_vertices("v "), "\n", "\r") + replaced(box_polygons("f", 1), "\n", "\r\n");
  expect_box(read("a.obj", obj), "mixed");
}

TEST(ReadVariants, ABackslashJoinsLinesWhateverTheirEnd) {
  for (const std::string_view end : {"\n", "\r\n", "\r"}) {
    const std::string text = replaced(replaced(box_of("obj"), "f ", "f \\\n "), "\n", end);
    expect_box(read("a.obj", text), "joined");
  }
}

TEST(ReadVariants, LineNumbersCountEveryKindOfEnd) {
  EXPECT_EQ(refusal("a.obj", "v 0 0 0\rv 1 0 0\rv 0 0 x\r"), "vertex 2: line 3: 'x' is not a number");
  EXPECT_EQ(refusal("a.obj", "v 0 0 0\r\nv 1 0 0\r\nv 0 0 x\r\n"), "vertex 2: line 3: 'x' is not a number");
}

TEST(ReadVariants, AByteOrderMarkIsSkippedAndNoted) {
  for (const std::string format : {"obj", "off", "ply", "stl"}) {
    const std::string text = std::string(byte_order_mark) + box_of(format);
    expect_box(read("a." + format, text), format);
    EXPECT_NE(notes_of("a." + format, text).find("a byte order mark"), std::string::npos) << format;
  }
  // In the middle of a file too: two files were put one behind the other.
  const std::string two = box_vertices("v ") + std::string(byte_order_mark) + "v 2 2 2\n" + box_polygons("f", 1);
  EXPECT_EQ(read("a.obj", two).vertices.rows(), 9);
}

TEST(ReadVariants, Utf16AndUtf32AreNamedWithTheRemedy) {
  for (const std::string format : {"obj", "off", "ply", "stl"}) {
    for (const bool big_endian : {false, true}) {
      for (const std::size_t size : {2U, 4U}) {
        const std::string name = size == 2 ? "UTF-16" : "UTF-32", order = big_endian ? "BE" : "LE";
        const std::string wide = widened(box_of(format), size, big_endian);
        EXPECT_EQ(refusal("a." + format, wide),
                  "the text is " + name + order + "; convert it: iconv -f " + name + order + " -t UTF-8 FILE > NEW");
        std::string mark = size == 2 ? std::string("\xFF\xFE") : std::string("\xFF\xFE\0\0", 4);
        if (big_endian) std::reverse(mark.begin(), mark.end());
        EXPECT_EQ(refusal("a." + format, mark + wide),
                  "the text is " + name + "; convert it: iconv -f " + name + " -t UTF-8 FILE > NEW");
      }
    }
  }
}

// ---- OBJ -------------------------------------------------------------------

TEST(ReadObjVariants, WhatIsNoSurfaceIsSkippedWithACount) {
  const std::string text = box_vertices("v ") + "p 1 2\np 3\nl 1 2 3\nf 1 2\nf 3\nf 4 5\ncurv 0 1 1 2\n" +
                           box_polygons("f", 1) + "vn 0 0 1\nusemtl red\n";
  expect_box(read("a.obj", text), "skipping");
  EXPECT_EQ(notes_of("a.obj", text),
            "skipped: 2 point elements, 1 line element, 3 faces of fewer than three corners, "
            "1 free-form curve or surface");
  EXPECT_EQ(refusal("a.obj", box_vertices("v ") + "f 1 2\n"), "no faces (8 vertices)");
}

TEST(ReadObjVariants, AnOlderNameOfFacesIsKnown) {
  expect_box(read("a.obj", box_vertices("v ") + box_polygons("fo", 1)), "fo");
}

TEST(ReadObjVariants, LinesOfUnknownMeaningAreNoted) {
  EXPECT_EQ(notes_of("a.obj", box_vertices("v ") + "layer 3\nwidget\n" + box_polygons("f", 1)),
            "skipped: 2 lines of unknown meaning (the first, 'layer', at line 9)");
}

TEST(ReadObjVariants, LinesThatMayBeHalfAVertexAreRefused) {
  for (const std::string line : {"0.5 1 2", "-1 0 0", ".5 1 2", "\x01v 0 0 0"}) {
    const std::string message = refusal("a.obj", box_vertices("v ") + line + "\n" + box_polygons("f", 1));
    EXPECT_TRUE(message.starts_with("line 9: cannot understand '")) << message;
  }
  EXPECT_EQ(refusal("a.obj", "call other.obj\n"),
            "line 1: 'call' includes another file, which is not followed; put its text here instead");
}

TEST(ReadObjVariants, TextMayEndInDosAndPaddingCharacters) {
  expect_box(read("a.obj", box_of("obj") + "\x1A"), "SUB");
  expect_box(read("a.obj", box_of("obj") + std::string(7, '\0')), "NUL");
}

// ---- OFF -------------------------------------------------------------------

TEST(ReadOffVariants, FacesThatTheHeaderDoesNotPromiseAreNoted) {
  expect_box(read("a.off", box_of("off") + "3 0 1 2\n"), "too many faces");
  EXPECT_EQ(notes_of("a.off", box_of("off") + "3 0 1 2\n"),
            "skipped: the file goes on, at line 23, after the 12 faces that its header promises");
  EXPECT_EQ(notes_of("a.off", box_of("off") + "\n# the end\n\n"), "");
}

// ---- PLY -------------------------------------------------------------------

TEST(ReadPlyVariants, CommentsStandAnywhereInTheHeader) {
  std::string text = "ply\ncomment first\nobj_info num_cols 512\n\nformat ascii 1.0\n" + ply_vertices +
                     "comment 'element face 99' is no element\n" + ply_faces + "obj_info 1 2\nend_header\n" +
                     box_vertices("") + box_polygons("3", 0);
  expect_box(read("a.ply", text), "comments");
  // So does the format, once.
  EXPECT_EQ(refusal("a.ply", "ply\nend_header\n"), "header line 2: 'format' is missing");
  EXPECT_EQ(refusal("a.ply", "ply\nformat ascii 1.0\nformat ascii 1.0\n"), "header line 3: a second 'format'");
  EXPECT_EQ(refusal("a.ply", "ply\nformat\n"), "header line 2: 'format' without a name");
}

/// Binary data begins right behind the header's last line end, whatever that is and the data's first byte.
TEST(ReadPlyVariants, BinaryDataBeginsBehindTheHeader) {
  for (const std::string_view end : {"\n", "\r\n", "\r"}) {
    for (const unsigned char first_byte : {'\n', '\r', ' ', '\0'}) {
      const std::string header =
          "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty uchar tag\n"
          "property float x\nproperty float y\nproperty float z\nelement face 1\n"
          "property list uchar uchar vertex_index\nend_header\n";
      std::string bytes = replaced(header, "\n", end);
      for (int v = 0; v < 3; ++v) {
        bytes += static_cast<char>(first_byte) + raw<float>({static_cast<float>(v), static_cast<float>(v * v), 0});
      }
      bytes += raw<std::uint8_t>({3, 0, 1, 2});
      const PolygonMesh mesh = read("a.ply", bytes);
      EXPECT_EQ(mesh.vertices(2, 1), 4);
      EXPECT_EQ(mesh.corners, indices({0, 1, 2}));
    }
  }
}

TEST(ReadPlyVariants, ReadsTriangleStrips) {
  // Around the box, then its ends; -1 begins another strip, and ends the last one or not.
  const std::string strips = "0 1 2 3 6 7 4 5 0 1 -1 0 2 4 6 -1 1 5 3 7";
  for (const std::string& data : {"20 " + strips, "21 " + strips + " -1", "23 -1 -1 " + strips + " -1"}) {
    const std::string text =
        "ply\nformat ascii 1.0\n" + ply_vertices + ply_strips + "end_header\n" + box_vertices("") + data + "\n";
    const TriangleMesh mesh = triangulate(read("a.ply", text));
    EXPECT_EQ(mesh.triangles.rows(), 12);
    EXPECT_TRUE(is_closed(mesh)) << data;
    EXPECT_EQ(signed_volume(mesh), -1) << data;  // these strips wind inward
    EXPECT_EQ(Eigen::RowVector3i(mesh.triangles.row(1)), Eigen::RowVector3i(2, 1, 3));
  }
}

TEST(ReadPlyVariants, ReadsBinaryStripsBesideFaces) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\n" + ply_vertices +
                      "element face 2\nproperty list uchar int vertex_indices\n"
                      "element tristrips 2\nproperty uchar tag\nproperty list int int vertex_indices\nend_header\n";
  for (int v = 0; v < 8; ++v) {
    bytes += raw<float>({static_cast<float>(v & 1), static_cast<float>(v >> 1 & 1), static_cast<float>(v >> 2)});
  }
  bytes += "\3" + raw<std::int32_t>({0, 1, 2}) + "\3" + raw<std::int32_t>({2, 1, 3});
  bytes += "\7" + raw<std::int32_t>({8, 2, 3, 6, 7, 4, 5, 0, 1});
  bytes += "\7" + raw<std::int32_t>({10, 0, 2, 4, 6, -1, 1, 5, 3, 7, -1});
  const TriangleMesh mesh = triangulate(read("a.ply", bytes));
  EXPECT_EQ(mesh.triangles.rows(), 12);
  EXPECT_TRUE(is_closed(mesh));
}

TEST(ReadPlyVariants, RepeatedCornersOfStripsAreNoTriangles) {
  const auto corners_of = [](const std::string& strip) {
    return read("a.ply", "ply\nformat ascii 1.0\n" + ply_vertices + ply_strips + "end_header\n" + box_vertices("") +
                             strip + "\n")
        .corners;
  };
  // Two triangles apart, joined by 2 2 4 4; the second is number 5, hence turned.
  EXPECT_EQ(corners_of("8 0 1 2 2 4 4 5 6"), indices({0, 1, 2, 5, 4, 6}));
  EXPECT_EQ(corners_of("7 0 1 2 2 4 5 6"), indices({0, 1, 2, 4, 2, 5, 4, 5, 6}));
}

TEST(ReadPlyVariants, RefusesMalformedStrips) {
  const auto with_strip = [](const std::string& strips, const std::string& data) {
    return refusal("a.ply",
                   "ply\nformat ascii 1.0\n" + ply_vertices + strips + "end_header\n" + box_vertices("") + data + "\n");
  };
  EXPECT_EQ(with_strip(ply_strips, "3 0 1 8"), "triangle strip 0: vertex index 8 is out of range (8 vertices)");
  EXPECT_EQ(with_strip(ply_strips, "3 0 1 -2"), "triangle strip 0: vertex index -2 is out of range (8 vertices)");
  EXPECT_EQ(with_strip(ply_strips, "-3"), "triangle strip 0: a list of -3 values");
  EXPECT_EQ(with_strip(ply_strips, "4 0 1 2"), "triangle strip 0: the file ends early: the header promises more");
  EXPECT_EQ(with_strip(ply_strips, "2 0 1"), "no faces (8 vertices)");
  EXPECT_EQ(with_strip("element tristrips 1\nproperty int x\n", "1"),
            "the triangle strips have no list 'vertex_indices'");
}

TEST(ReadPlyVariants, DataThatTheHeaderDoesNotPromiseIsRefused) {
  const std::string text = box_of("ply");
  EXPECT_EQ(refusal("a.ply", text + "3 0 1 2\n"), "line 21 of the data is more than the header promises");
  EXPECT_EQ(refusal("a.ply", text + "7"), "line 21 of the data is more than the header promises");
  expect_box(read("a.ply", text + "\n\n"), "blank lines");
  // Values that would shift all others.
  EXPECT_EQ(refusal("a.ply", replaced(text, "\n1 0 0\n", "\n1 0 0 0 0 1\n")),
            "vertex 1: line 2 of the data goes on with '0', which the header does not promise");
  EXPECT_EQ(refusal("a.ply", replaced(text, "\n1 0 0\n", "\n1 0\n")),
            "vertex 1: line 3 of the data goes on with '1', which the header does not promise");
  EXPECT_EQ(refusal("a.ply", replaced(text, "3 0 2 1\n", "3 0 2 1 255 0 0\n")),
            "face 0: line 9 of the data goes on with '255', which the header does not promise");
  EXPECT_EQ(refusal("a.ply", "ply\nformat ascii 1.0\n" + ply_vertices + ply_vertices),
            "header line 7: a second element 'vertex'");
}

TEST(ReadPlyVariants, BinaryDataThatTheHeaderDoesNotPromiseIsRefused) {
  std::string bytes =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\n"
      "property char z\nelement face 1\nproperty list uchar char vertex_indices\nend_header\n";
  bytes += raw<std::int8_t>({0, 0, 0, 1, 0, 0, 0, 1, 0, 3, 0, 1, 2});
  EXPECT_EQ(read("a.ply", bytes).corners, indices({0, 1, 2}));
  EXPECT_EQ(read("a.ply", bytes + "\r\n").corners, indices({0, 1, 2}));
  EXPECT_EQ(refusal("a.ply", bytes + std::string(2, '\0')), "the data is 2 bytes longer than the header promises");
}

TEST(ReadPlyVariants, OtherElementsWithCornersAreNoted) {
  const std::string text = "ply\nformat ascii 1.0\n" + ply_vertices + ply_faces +
                           "element polyline 2\nproperty list uchar int vertex_indices\nelement edge 1\n"
                           "property int vertex1\nproperty int vertex2\nend_header\n" +
                           box_vertices("") + box_polygons("3", 0) + "3 0 1 2\n2 0 1\n0 1\n";
  expect_box(read("a.ply", text), "polylines");
  EXPECT_EQ(notes_of("a.ply", text), "skipped: 2 of element 'polyline', which are no faces");
}

// ---- STL -------------------------------------------------------------------

TEST(ReadStlVariants, TextThatMeansOneThingIsReadAndNoted) {
  const std::string text = box_of("stl");
  const std::vector<std::pair<std::string, std::string>> variants = {
      {replaced(replaced(text, "endloop", "end loop"), "endfacet", "END FACET"),
       "'end loop' and the like, in two words, were read as one"},
      {replaced(text, "endsolid", "end solid"), "'end loop' and the like, in two words, were read as one"},
      {replaced(text, "facet normal 0 0 0\n", "color 1 0.5 0.5\nfacet normal 0 0 0\n"), "skipped: colours"},
      {replaced(text, " outer loop", "  color 1 0 0\n outer loop"), "skipped: colours"},
      {"; made by a program\n;\n" + text, "skipped: comment lines"},
      {"# made by a program\n" + text, ""},
      {"// made by a program\n" + replaced(text, "endfacet\n", "endfacet\n; solid again\n// vertex\n"),
       "skipped: comment lines"},
      {replaced(text, "endsolid box\n", ""), "'endsolid' is missing; see whether the file was cut off"},
      {std::string(byte_order_mark) + "; solid\n" + text, "skipped: a byte order mark, comment lines"},
  };
  for (const auto& [variant, note] : variants) {
    expect_box(read("a.stl", variant), variant.substr(0, 40));
    EXPECT_EQ(notes_of("a.stl", variant), note);
  }
}

TEST(ReadStlVariants, ASolidMayFollowOneWithoutAnEnd) {
  const std::string text = replaced(box_of("stl"), "endsolid box\n", "");
  EXPECT_EQ(read("a.stl", text + text).polygon_count(), 24);
  EXPECT_EQ(notes_of("a.stl", text + text), "'endsolid' is missing; see whether the file was cut off");
}

TEST(ReadStlVariants, TextThatIsCutOffInsideAFacetIsRefused) {
  const std::string text = box_of("stl");
  EXPECT_EQ(refusal("a.stl", text.substr(0, text.rfind("endfacet"))), "face 11: line 85: the file ends early");
  EXPECT_EQ(refusal("a.stl", replaced(text, "endloop", "end hoop")), "face 0: line 7: expected 'endloop'");
}

TEST(ReadStlVariants, TheSizeTellsTheNumberWhereTheHeaderDoesNot) {
  const std::array<float, 9> t = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  for (const std::uint32_t count : {0U, 0xFFFFFFFFU}) {
    EXPECT_EQ(read("a.stl", binary_stl(count, {t, t, t})).polygon_count(), 3);
    EXPECT_EQ(notes_of("a.stl", binary_stl(count, {t, t, t})),
              "the header gives no number of triangles; by the file's size there are 3");
  }
  EXPECT_EQ(refusal("a.stl", binary_stl(0, {t, t}) + "xyz"),
            "the header promises 0 triangles, the file holds 2 and 3 bytes more");
}

TEST(ReadStlVariants, BytesBehindTheTrianglesAreSkippedUnlessTheyMayBeTriangles) {
  const std::array<float, 9> t = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_EQ(read("a.stl", binary_stl(2, {t, t}) + "a footer").polygon_count(), 2);
  EXPECT_EQ(notes_of("a.stl", binary_stl(2, {t, t}) + "a footer"),
            "skipped: 8 bytes behind the last of the 2 triangles that the header promises");
  EXPECT_EQ(refusal("a.stl", binary_stl(2, {t, t, t})), "the header promises 2 triangles, the file holds 3");
  EXPECT_EQ(refusal("a.stl", binary_stl(3, {t, t}) + "a footer"),
            "the header promises 3 triangles, the file holds 2 and 8 bytes more");
}

// ---- Assets of Encage -------------------------------------------------------

TEST(ReadAssetVariants, AnAssetThatBecameTextIsRefused) {
  const std::string message =
      refusal("a.gltf", R"({"asset":{"version":"2.0"},"extensions":{"ENCAGE_cages":{"version":1}}})");
  EXPECT_TRUE(message.starts_with("an asset of Encage that another program wrote as text")) << message;
}

// ---- From memory -----------------------------------------------------------

TEST(DecodePolygonMesh, ReadsBytesOfANamedFormat) {
  for (const std::string format : {"obj", "OFF", "ply", "stl"}) {
    std::string lower = format;
    std::transform(lower.begin(), lower.end(), lower.begin(), [](char c) { return static_cast<char>(c | 0x20); });
    expect_box(decode_polygon_mesh(box_of(lower), format, "standard input"), format);
  }
  const auto message = [](std::string_view bytes, const std::string& format) {
    try {
      decode_polygon_mesh(bytes, format, "standard input");
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message("v 0 0 0\n", "obj"), "standard input: no faces (1 vertices)");
  EXPECT_EQ(message("", "obj"), "standard input: the file is empty");
  EXPECT_TRUE(message("x", "xyz").starts_with("standard input: unknown format 'xyz' (known: obj ply stl off"));
  EXPECT_TRUE(message("x", "").starts_with("standard input: the name has no extension that tells the format"));
}

}  // namespace
}  // namespace encage
