// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/writer.h"
#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <encage/asset.h>

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace encage {
namespace {

void expect_same(const TriangleMesh& a, const TriangleMesh& b) {
  ASSERT_EQ(a.vertices.rows(), b.vertices.rows());
  ASSERT_EQ(a.triangles.rows(), b.triangles.rows());
  EXPECT_TRUE(a.vertices == b.vertices);
  EXPECT_TRUE(a.triangles == b.triangles);
}

void expect_same(const CageHierarchy& a, const CageHierarchy& b) {
  EXPECT_TRUE(a.origin == b.origin);
  EXPECT_EQ(a.solid, b.solid);
  EXPECT_EQ(a.source_hash, b.source_hash);
  EXPECT_EQ(a.source_volume, b.source_volume);
  EXPECT_EQ(a.diagonal, b.diagonal);
  EXPECT_EQ(a.cap_count, b.cap_count);
  EXPECT_EQ(a.fine_error, b.fine_error);
  EXPECT_EQ(a.options, b.options);
  EXPECT_EQ(a.truncated, b.truncated);
  expect_same(a.fine, b.fine);
  ASSERT_EQ(a.levels.size(), b.levels.size());
  for (std::size_t i = 0; i < a.levels.size(); ++i) {
    expect_same(a.levels[i].mesh, b.levels[i].mesh);
    const Certificate &p = a.levels[i].certificate, &q = b.levels[i].certificate;
    EXPECT_EQ(p.clearance, q.clearance);
    EXPECT_EQ(p.volume, q.volume);
    EXPECT_EQ(p.volume_ratio, q.volume_ratio);
    EXPECT_EQ(p.max_distance, q.max_distance);
    EXPECT_EQ(p.mean_distance, q.mean_distance);
    EXPECT_EQ(p.components, q.components);
    EXPECT_EQ(p.cavities, q.cavities);
    EXPECT_EQ(p.genus, q.genus);
    EXPECT_EQ(p.no_new_handles, q.no_new_handles);
    EXPECT_EQ(p.method, q.method);
    EXPECT_EQ(p.start, q.start);
  }
}

CageHierarchy round_trip(const CageHierarchy& hierarchy) {
  const TemporaryFile file;
  write_asset(file.path(), hierarchy);
  return read_asset(file.path(), Verify::all);
}

TEST(AssetReader, golden_file_of_version_1_stays_readable) {
  // The first file is of a version that stored no trees.
  for (const char* file : {"/asset_v1.glb", "/asset_v1_trees.glb", "/asset_v1_boxes.glb", "/asset_v1_index.glb"}) {
    expect_same(read_asset(std::string(ENCAGE_TEST_DATA) + file, Verify::all), sample_hierarchy());
  }
}

TEST(AssetReader, golden_file_holds_true_claims) {
  const CageHierarchy h = read_asset(ENCAGE_TEST_DATA "/asset_v1.glb");
  EXPECT_TRUE(is_closed(h.fine));
  EXPECT_DOUBLE_EQ(signed_volume(h.fine), h.source_volume);
  for (const CageLevel& level : h.levels) {
    EXPECT_TRUE(is_closed(level.mesh));
    EXPECT_DOUBLE_EQ(signed_volume(level.mesh), level.certificate.volume);
  }
}

TEST(AssetReader, returns_what_was_written) {
  CageHierarchy hierarchy = sample_hierarchy();
  hierarchy.truncated = true;
  hierarchy.levels[0].certificate.max_distance = 1.1;
  hierarchy.levels[0].certificate.mean_distance = 0.7;
  hierarchy.solid = Solid::surface_only;
  hierarchy.origin = {0.1, 1e300, -4.9e-324};  // doubles that float32 cannot represent
  hierarchy.diagonal = 1.0 / 3;
  hierarchy.levels[0].mesh.vertices(0, 0) = 1.401298464324817e-45;  // the smallest float32
  hierarchy.levels[0].mesh.vertices(0, 1) = 3.4028234663852886e38;  // the largest
  hierarchy.levels[1].certificate.components = 7;
  hierarchy.levels[1].certificate.cavities = 3;
  hierarchy.levels[1].certificate.genus = 1409;
  hierarchy.levels[1].certificate.no_new_handles = false;
  hierarchy.levels[1].certificate.method = Method::flow;
  hierarchy.levels[1].certificate.start = "\"\\ \xc3\xa9";
  expect_same(round_trip(hierarchy), hierarchy);
  hierarchy.fine = {};
  hierarchy.options.clear();
  hierarchy.solid = Solid::closed;
  expect_same(round_trip(hierarchy), hierarchy);
}

TEST(AssetReader, options_come_back_compact_and_sorted) {
  CageHierarchy hierarchy = sample_hierarchy();
  hierarchy.options = " {\"b\": 1e-5,\n \"a\": [1, 2]} ";
  EXPECT_EQ(round_trip(hierarchy).options, R"({"a":[1,2],"b":1e-05})");
}

/// Flips bits of one byte of a file on disk as long as the object lives.
class FlippedByte {
 public:
  FlippedByte(std::fstream& file, std::size_t offset, char original, int mask)
      : file_(file), offset_(offset), original_(original) {
    put(static_cast<char>(original ^ mask));
  }
  ~FlippedByte() { put(original_); }

 private:
  void put(char byte) {
    file_.seekp(static_cast<std::streamoff>(offset_));
    file_.put(byte).flush();
  }
  std::fstream& file_;
  std::size_t offset_;
  char original_;
};

TEST(AssetReader, verify_all_notices_any_flipped_byte) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string good = read_bytes(file.path());
  std::fstream stream(file.path(), std::ios::binary | std::ios::in | std::ios::out);
  for (std::size_t i = 0; i < good.size(); ++i) {
    // 0x20 turns "a" into "A" and a space into NUL; the shifted mask visits all bits.
    for (const int mask : {0xff, 0x20, 1 << i % 8}) {
      const FlippedByte flipped(stream, i, good[i], mask);
      ASSERT_EQ(error_of([&] { read_asset(file.path(), Verify::all); }).find(file.path().string() + ": "), 0U)
          << "byte " << i << " mask " << mask;
    }
  }
  EXPECT_NO_THROW(read_asset(file.path(), Verify::all));
}

TEST(AssetReader, verify_cages_notices_damage_to_json_and_cages_only) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string good = read_bytes(file.path());
  const std::size_t bin_start = parse_glb(as_byte_span(good), "f").head.size();
  // Bytes in which a flipped lowest bit leaves a valid mesh, each with a flag: the damage must be detected.
  std::vector<std::pair<std::size_t, bool>> offsets;
  for (std::size_t i = 0; i < bin_start; ++i) offsets.emplace_back(i, true);
  for (std::size_t i = 0; i < 96; i += 4) offsets.emplace_back(bin_start + i, false);  // the source's vertices
  offsets.emplace_back(bin_start + 96, false);                                         // padding
  const std::size_t cage = section_offset(good, "cage 1 vertices");
  for (std::size_t i = 0; i < 72; i += 4) offsets.emplace_back(cage + i, true);
  for (std::size_t i = 0; i < seal_size; ++i) {
    offsets.emplace_back(good.size() - seal_size + i, i < seal_hash_size);
  }
  std::fstream stream(file.path(), std::ios::binary | std::ios::in | std::ios::out);
  for (const auto& [offset, must_notice] : offsets) {
    const FlippedByte flipped(stream, offset, good[offset], 1);
    bool noticed = false;
    try {
      read_asset(file.path(), Verify::cages);
    } catch (const Error&) {
      noticed = true;
    }
    EXPECT_EQ(noticed, must_notice) << offset;
  }
}

TEST(AssetReader, names_file_section_and_reason) {
  const TemporaryFile file;
  const std::string good = encode_asset(sample_hierarchy(), "Encage 0.1.0", "f");
  std::string bad = good;
  bad[section_offset(good, "cage 1 vertices") + 2] ^= 1;
  write_bytes(file.path(), bad);
  EXPECT_EQ(error_of([&] { read_asset(file.path()); }),
            file.path().string() + ": section \"cage 1 vertices\": its hash does not match: the file is damaged");
  EXPECT_EQ(error_of([&] { read_asset("/nowhere/a.glb"); }), "/nowhere/a.glb: cannot open: No such file or directory");
}

}  // namespace
}  // namespace encage
