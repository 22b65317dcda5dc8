// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/index.h"

#include "src/asset/view.h"
#include "src/asset/writer.h"
#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace encage {
namespace {

std::string indexed_sample() { return encode_asset(sample_hierarchy(), "Encage 0.1.0", "f.glb"); }

AssetIndex index_of(const std::string& asset) { return decode_index(*find_index(as_byte_span(asset)), "f.glb"); }

/// Returns the asset with another index, which ends where the old one does and is not longer.
std::string with_index(std::string asset, const AssetIndex& index) {
  const std::string bytes = encode_index(index);
  const auto place = find_index(as_byte_span(asset));
  EXPECT_LE(bytes.size(), place->size());
  const auto end = static_cast<std::size_t>(place->data() - as_byte_span(asset).data()) + place->size();
  const std::size_t offset = end - bytes.size();
  return asset.replace(offset, bytes.size(), bytes);
}

/// Returns the message of the refusal when arrays are read by the index; empty if nothing is refused.
std::string refusal(const std::string& asset) {
  const AlignedBytes aligned(asset);
  try {
    const AssetView view(aligned.span(), "f.glb", Verify::cages, AssetParts::arrays);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

TEST(AssetIndexes, SayWhatTheJsonSays) {
  for (const bool with_fine : {true, false}) {
    CageHierarchy hierarchy = sample_hierarchy();
    if (!with_fine) hierarchy.fine = {};
    const AlignedBytes bytes(encode_asset(hierarchy, "Encage 0.1.0", "f.glb"));
    const AssetView json(bytes.span(), "f.glb", Verify::all);
    const AssetView view(bytes.span(), "f.glb", Verify::cages, AssetParts::arrays);
    EXPECT_TRUE(json.has_description());
    ASSERT_FALSE(view.has_description());
    EXPECT_EQ(view.summary().origin, json.description().origin);
    EXPECT_EQ(view.summary().solid, json.description().solid);
    EXPECT_EQ(view.summary().fine_error, json.description().fine_error);
    ASSERT_EQ(view.level_count(), json.level_count());
    EXPECT_EQ(view.fine_bytes(), json.fine_bytes());
    EXPECT_EQ(view.fine_triangle_count(), json.fine_triangle_count());
    EXPECT_EQ(view.fine_arrays() ? 1 : 0, with_fine ? 1 : 0);
    ASSERT_EQ(view.sections().size() + 1, json.sections().size());  // all but the index itself
    for (std::size_t i = 0; i < view.sections().size(); ++i) {
      const AssetSection &a = view.sections()[i], &b = json.sections()[i];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.kind, b.kind);
      EXPECT_EQ(a.element_size, b.element_size);
      EXPECT_EQ(a.bytes.data(), b.bytes.data());
      EXPECT_EQ(a.bytes.size(), b.bytes.size());
      EXPECT_EQ(a.hash, b.hash);
    }
    for (std::size_t k = 0; k < view.level_count(); ++k) {
      EXPECT_EQ(view.cage(k).triangles.data(), json.cage(k).triangles.data());
      EXPECT_EQ(view.cage_arrays(k)->parts.data(), json.cage_arrays(k)->parts.data());
    }
  }
}

TEST(AssetIndexes, WithoutOneTheJsonIsRead) {
  const AlignedBytes bytes(forge(indexed_sample(), {}));
  const AssetView view(bytes.span(), "f.glb", Verify::cages, AssetParts::arrays);
  EXPECT_TRUE(view.has_description());
  EXPECT_EQ(view.level_count(), 2U);
}

TEST(AssetIndexes, DamageIsNoticedInEveryByte) {
  const std::string good = indexed_sample();
  ASSERT_EQ(refusal(good), "");
  const std::size_t size = find_index(as_byte_span(good))->size(), end = good.size() - seal_size;
  for (std::size_t i = end - size; i < end; ++i) {
    std::string bytes = good;
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
    // Where the bytes are no longer taken for an index, the JSON reports it.
    EXPECT_EQ(refusal(bytes), "f.glb: section \"index\": its hash does not match: the file is damaged") << i - end;
  }
  std::string cage = good;
  cage[section_offset(good, "cage 2 leaves")] ^= 1;
  EXPECT_EQ(refusal(cage), "f.glb: section \"cage 2 leaves\": its hash does not match: the file is damaged");
}

TEST(AssetIndexes, NonsenseIsRefused) {
  const std::string good = indexed_sample();
  const auto edited = [&](auto&& edit) {
    AssetIndex index = index_of(good);
    edit(index);
    return refusal(with_index(good, index));
  };
  EXPECT_EQ(edited([](AssetIndex&) {}), "");
  const std::string index = "f.glb: section \"index\": ", error = index + "fine_error is not a finite distance";
  EXPECT_EQ(edited([](AssetIndex& i) { i.fine_error = -1; }), error);
  EXPECT_EQ(edited([](AssetIndex& i) { i.fine_error = std::numeric_limits<double>::infinity(); }), error);
  EXPECT_EQ(edited([](AssetIndex& i) { i.origin[2] = std::numeric_limits<double>::quiet_NaN(); }),
            index + "the origin is not finite");
  EXPECT_EQ(edited([](AssetIndex& i) { i.solid = static_cast<Solid>(3); }), index + "solid is 3, not 0, 1 or 2");
  EXPECT_EQ(edited([](AssetIndex& i) { i.meshes.clear(); }), index + "it has no meshes");  // found by fuzzing
  const std::string place = "f.glb: section \"index\": \"cage 1 boxes\" cannot be where it says";
  const auto moved = [&](auto&& edit) { return edited([&](AssetIndex& i) { edit(i.meshes[1][2]); }); };
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before = 0xFFFFFFC0; }), place);  // before the start of the file
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before += 64; }), place);         // overlaps the previous array
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before -= 32; }), place);         // not aligned
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size = 0; }), place);
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size += 1; }), place);  // no multiple of the element size
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size = a.before / 192 * 192 + 192; }), place);  // overlaps the index
  EXPECT_EQ(edited([](AssetIndex& i) { i.meshes[2][0].before = i.meshes[0][0].before; }),
            "f.glb: section \"index\": \"cage 2 vertices\" cannot be where it says");  // not in order
}

/// Returns the indexed_sample with these bytes as its index, and every hash correct. Its section appears in `sections`,
/// those of the JSON, as it should, before `edit` may change that.
std::string with_index_bytes(const std::string& index, const std::function<void(nlohmann::json& sections)>& edit = {}) {
  const std::string good = indexed_sample();
  const std::string bytes = forge(
      good,
      [&](nlohmann::json& document) {
        auto& sections = document["extensions"][asset_extension]["sections"];
        sections.push_back({{"bufferView", sections.size()},
                            {"element_size", index_element_size},
                            {"hash", to_string(hash_bytes(as_byte_span(index)))},
                            {"kind", "cage"},
                            {"name", index_name}});
        if (edit) edit(sections);
      },
      [&](std::string& bin) { bin.replace(bin.size() - index.size(), index.size(), index); });
  return bytes;
}

std::string refusal_of_all(const std::string& asset) {
  const AlignedBytes aligned(asset);
  return error_of([&] { AssetView(aligned.span(), "f.glb", Verify::all); });
}

TEST(AssetIndexes, AreComparedWithTheJsonWhereAllIsVerified) {
  const AssetIndex good = index_of(indexed_sample());
  const AlignedBytes unchanged(with_index_bytes(encode_index(good)));
  EXPECT_EQ(AssetView(unchanged.span(), "f.glb", Verify::all).level_count(), 2U);

  AssetIndex index = good;
  index.origin[1] += 1;
  const std::string bytes = with_index_bytes(encode_index(index));
  ASSERT_EQ(bytes.size(), indexed_sample().size());
  EXPECT_EQ(refusal_of_all(bytes), "f.glb: section \"index\": its last 64 bytes do not say what the JSON says");
  const AlignedBytes aligned(bytes);
  EXPECT_EQ(AssetView(aligned.span(), "f.glb", Verify::cages, AssetParts::arrays).summary().origin[1], 1);

  index = good;
  index.meshes[1][3] = index.meshes[2][3];
  EXPECT_EQ(refusal_of_all(with_index_bytes(encode_index(index))),
            "f.glb: section \"index\": of \"cage 1 leaves\" it does not say what the JSON says");
}

// Loading uses the bytes before the seal, whatever the JSON says about an index.
TEST(AssetIndexes, AreWhereTheJsonSays) {
  AssetIndex index = index_of(indexed_sample());
  index.origin[1] += 1;
  const std::string bytes = encode_index(index);
  // The size of the file is known only after it has been made.
  const auto fitted = [&](auto&& edit) {
    index.file_size = static_cast<std::uint32_t>(with_index_bytes(bytes, edit).size());
    return with_index_bytes(encode_index(index), edit);
  };
  EXPECT_EQ(refusal_of_all(fitted([](nlohmann::json& sections) { sections.erase(sections.size() - 1); })),
            "f.glb: section \"index\": before the seal, but not among the sections");
  const std::string elsewhere = "f.glb: section \"index\": it is not what is before the seal";
  EXPECT_EQ(refusal_of_all(fitted([](nlohmann::json& sections) {
              sections.erase(sections.size() - 1);
              sections.back()["name"] = index_name;
            })),
            elsewhere);
  EXPECT_EQ(refusal_of_all(with_index_bytes(std::string(bytes.size(), '\0'))), elsewhere);
}

// In the JSON, accessors define a mesh; in the index, the names of sections do.
TEST(AssetIndexes, MeshesAreCalledWhatTheyAre) {
  const auto swap = [](nlohmann::json& sections) {
    std::vector<nlohmann::json*> vertices;
    for (auto& section : sections) {
      if (section["name"] == "cage 1 vertices" || section["name"] == "cage 2 vertices") vertices.push_back(&section);
    }
    std::swap((*vertices.at(0))["name"], (*vertices.at(1))["name"]);
  };
  EXPECT_EQ(refusal_of_all(with_index_bytes(encode_index(index_of(indexed_sample())), swap)),
            "f.glb: section \"index\": section \"cage 1 vertices\" is not what the mesh has");
}

TEST(AssetIndexes, OfAnotherVersionOfTheFormatAreNotTaken) {
  std::string asset = indexed_sample();
  char& version = asset[asset.size() - seal_size - 64 + 14];
  ASSERT_EQ(version, asset_version);
  ++version;
  EXPECT_FALSE(find_index(as_byte_span(asset)));
}

TEST(AssetIndexes, AreNotSeenInOtherFiles) {
  const std::string good = indexed_sample();
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, seal_size, seal_size + 63, seal_size + 64}) {
    EXPECT_FALSE(find_index(as_byte_span(good.substr(good.size() - size)))) << size;
  }
  EXPECT_TRUE(find_index(as_byte_span(good)));
  EXPECT_FALSE(find_index(as_byte_span(good + good)));
}

}  // namespace
}  // namespace encage
