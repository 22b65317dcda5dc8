// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/writer.h"

#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <encage/asset.h>
#include <encage/version.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace encage {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string encode(const CageHierarchy& hierarchy) { return encode_asset(hierarchy, "Encage 0.1.0", "f.glb"); }

/// Returns the message for a sample damaged by `edit`.
template <class Edit>
std::string refused_write(Edit&& edit) {
  CageHierarchy hierarchy = sample_hierarchy();
  edit(hierarchy);
  return error_of([&] { encode(hierarchy); });
}

TEST(AssetWriter, writes_the_bytes_of_the_golden_file) {
  EXPECT_EQ(encode(sample_hierarchy()), read_bytes(ENCAGE_TEST_DATA "/asset_v1_index.glb"));
}

TEST(AssetWriter, names_itself_as_generator) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string bytes = read_bytes(file.path());
  const auto document = nlohmann::json::parse(parse_glb(as_byte_span(bytes), "f").json);
  const Version v = version();
  EXPECT_EQ(document["asset"]["generator"],
            "Encage " + std::to_string(v.major) + "." + std::to_string(v.minor) + "." + std::to_string(v.patch));
}

TEST(AssetWriter, is_a_scene_any_viewer_shows) {
  const std::string bytes = encode(sample_hierarchy());
  const auto document = nlohmann::json::parse(parse_glb(as_byte_span(bytes), "f").json);
  EXPECT_EQ(document["asset"]["version"], "2.0");
  EXPECT_EQ(document["extensionsUsed"], nlohmann::json::array({"ENCAGE_cages"}));
  EXPECT_EQ(document["scenes"][0]["nodes"], (nlohmann::json{0, 1, 2}));
  const char* names[] = {"source", "cage 1", "cage 2"};
  const int triangles[] = {12, 8, 4};
  for (int i = 0; i < 3; ++i) {
    const auto& node = document["nodes"][i];
    EXPECT_EQ(node["name"], names[i]);
    EXPECT_EQ(node["mesh"], i);
    EXPECT_EQ(node["translation"], (nlohmann::json{1000.5, 0.0, -0.1}));
    const auto& primitive = document["meshes"][i]["primitives"][0];
    EXPECT_EQ(primitive["mode"], 4);
    EXPECT_EQ(document["accessors"][primitive["indices"].get<int>()]["count"], 3 * triangles[i]);
  }
  const auto& tetrahedron =
      document["accessors"][document["meshes"][2]["primitives"][0]["attributes"]["POSITION"].get<int>()];
  EXPECT_EQ(tetrahedron["min"], (nlohmann::json{-3.0, -3.0, -3.0}));
  EXPECT_EQ(tetrahedron["max"], (nlohmann::json{3.0, 3.0, 3.0}));
  EXPECT_EQ(tetrahedron["count"], 4);
}

TEST(AssetWriter, leaves_out_what_a_hierarchy_does_not_have) {
  CageHierarchy hierarchy = sample_hierarchy();
  hierarchy.fine = {};
  hierarchy.options.clear();
  hierarchy.levels[0].certificate.volume_ratio.reset();
  const std::string bytes = encode(hierarchy);
  const auto document = nlohmann::json::parse(parse_glb(as_byte_span(bytes), "f").json);
  const auto& extension = document["extensions"]["ENCAGE_cages"];
  EXPECT_FALSE(extension.contains("fine_mesh"));
  EXPECT_FALSE(extension.contains("options"));
  for (const char* key : {"volume_ratio", "max_distance", "mean_distance"}) {
    EXPECT_FALSE(extension["levels"][0].contains(key)) << key;
  }
  EXPECT_EQ(document["meshes"].size(), 2U);
}

TEST(AssetWriter, refuses_vertices_that_float32_cannot_hold) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double bad : {1.1, 1e-60, 1e60, 16777217.0}) {
      char text[128];
      std::snprintf(text, sizeof text, "f.glb: cage 2: vertex 3: %.17g is not exact in float32", bad);
      EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[1].mesh.vertices(3, axis) = bad; }), text);
    }
    for (const double bad : {infinity, -infinity, nan}) {
      EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[1].mesh.vertices(3, axis) = bad; }),
                "f.glb: cage 2: vertex 3: not finite");
    }
  }
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.fine.vertices(7, 2) = 0.1; }),
            "f.glb: source: vertex 7: 0.10000000000000001 is not exact in float32");
}

TEST(AssetWriter, refuses_malformed_meshes) {
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[0].mesh.triangles(5, 2) = 6; }),
            "f.glb: cage 1: triangle 5: index 6 is out of range, there are 6 vertices");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[0].mesh.triangles(5, 2) = -1; }),
            "f.glb: cage 1: triangle 5: index 4294967295 is out of range, there are 6 vertices");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[1].mesh = {}; }), "f.glb: cage 2: no triangles");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels.clear(); }), "f.glb: there is no cage");
}

TEST(AssetWriter, refuses_numbers_that_mean_nothing) {
  for (const double bad : {0.0, -1.0, infinity, nan}) {
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[1].certificate.clearance = bad; }),
              "f.glb: cage 2: clearance is not finite and above 0");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[0].certificate.volume = bad; }),
              "f.glb: cage 1: volume is not finite and above 0");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[0].certificate.volume_ratio = bad; }),
              "f.glb: cage 1: volume_ratio is not finite and above 0");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[1].certificate.max_distance = bad; }),
              "f.glb: cage 2: max_distance is not finite and above 0");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.levels[1].certificate.mean_distance = bad; }),
              "f.glb: cage 2: mean_distance is not finite and above 0");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.diagonal = bad; }), "f.glb: diagonal is not finite and above 0");
  }
  for (const double bad : {-1.0, infinity, nan}) {
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.source_volume = bad; }),
              "f.glb: source_volume is not finite and 0 or more");
    EXPECT_EQ(refused_write([&](CageHierarchy& h) { h.fine_error = bad; }),
              "f.glb: fine_error is not finite and 0 or more");
  }
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.origin.y() = nan; }), "f.glb: origin is not finite");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[0].certificate.components = 0; }),
            "f.glb: cage 1: components is below 1");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[0].certificate.cavities = 1; }),
            "f.glb: cage 1: cavities is not in [0, components)");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.levels[0].certificate.genus = -1; }),
            "f.glb: cage 1: genus is negative");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.cap_count = -1; }), "f.glb: cap_count is negative");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.cap_count = 13; }),
            "f.glb: cap_count exceeds the triangles of the source");
  EXPECT_EQ(refused_write([](CageHierarchy& h) { std::swap(h.levels[0], h.levels[1]); }),
            "f.glb: cage 2: its volume is smaller than that of the cage before: levels must go from fine to coarse");
}

TEST(AssetWriter, refuses_text_it_cannot_store) {
  EXPECT_EQ(refused_write([](CageHierarchy& h) { h.options = "7"; }), "f.glb: options: not a JSON object");
  EXPECT_TRUE(refused_write([](CageHierarchy& h) { h.options = "{"; }).starts_with("f.glb: options: "));
  EXPECT_TRUE(
      refused_write([](CageHierarchy& h) { h.levels[0].certificate.start = "\xff"; }).starts_with("f.glb: JSON: "));
}

TEST(AssetWriter, leaves_an_existing_file_untouched_when_it_refuses) {
  const TemporaryFile file;
  write_bytes(file.path(), "precious");
  CageHierarchy hierarchy = sample_hierarchy();
  hierarchy.diagonal = 0;
  EXPECT_THROW(write_asset(file.path(), hierarchy), Error);
  EXPECT_EQ(read_bytes(file.path()), "precious");
}

}  // namespace
}  // namespace encage
