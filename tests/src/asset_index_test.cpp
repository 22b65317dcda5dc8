// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset_index.h"

#include <gtest/gtest.h>

#include <limits>

#include "src/asset_view.h"
#include "src/asset_writer.h"
#include "tests/src/asset_forge.h"
#include "tests/src/asset_sample.h"

namespace encage {
namespace {

std::string sample() { return encode_asset(sample_hierarchy(), "Encage 0.1.0", "f.glb"); }

AssetIndex index_of(const std::string& asset) { return decode_index(*find_index(as_byte_span(asset)), "f.glb"); }

/// The asset with another index of the same size.
std::string with_index(std::string asset, const AssetIndex& index) {
  const std::string bytes = encode_index(index);
  const auto place = find_index(as_byte_span(asset));
  EXPECT_EQ(place->size(), bytes.size());
  const auto offset = static_cast<std::size_t>(place->data() - as_byte_span(asset).data());
  return asset.replace(offset, bytes.size(), bytes);
}

/// The message that reading arrays by the index ends with; empty if nothing is refused.
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
    ASSERT_EQ(view.sections().size() + 1, json.sections().size());  // all but itself
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
  const AlignedBytes bytes(forge(sample(), {}));
  const AssetView view(bytes.span(), "f.glb", Verify::cages, AssetParts::arrays);
  EXPECT_TRUE(view.has_description());
  EXPECT_EQ(view.level_count(), 2U);
}

TEST(AssetIndexes, DamageIsNoticedInEveryByte) {
  const std::string good = sample();
  ASSERT_EQ(refusal(good), "");
  const std::size_t size = find_index(as_byte_span(good))->size(), end = good.size() - seal_size;
  for (std::size_t i = end - size; i < end; ++i) {
    std::string bytes = good;
    bytes[i] = static_cast<char>(bytes[i] ^ 1);
    // Where it is not taken for an index any more, the JSON tells.
    EXPECT_EQ(refusal(bytes), "f.glb: section \"index\": its hash does not match: the file is damaged") << i - end;
  }
  std::string cage = good;
  cage[section_offset(good, "cage 2 leaves")] ^= 1;
  EXPECT_EQ(refusal(cage), "f.glb: section \"cage 2 leaves\": its hash does not match: the file is damaged");
}

TEST(AssetIndexes, NonsenseIsRefused) {
  const std::string good = sample();
  const auto edited = [&](auto&& edit) {
    AssetIndex index = index_of(good);
    edit(index);
    return refusal(with_index(good, index));
  };
  EXPECT_EQ(edited([](AssetIndex&) {}), "");
  const std::string numbers = "f.glb: section \"index\": its numbers mean nothing";
  EXPECT_EQ(edited([](AssetIndex& i) { i.fine_error = -1; }), numbers);
  EXPECT_EQ(edited([](AssetIndex& i) { i.fine_error = std::numeric_limits<double>::infinity(); }), numbers);
  EXPECT_EQ(edited([](AssetIndex& i) { i.origin[2] = std::numeric_limits<double>::quiet_NaN(); }), numbers);
  EXPECT_EQ(edited([](AssetIndex& i) { i.solid = static_cast<Solid>(3); }), numbers);
  const std::string place = "f.glb: section \"index\": \"cage 1 boxes\" cannot be where it says";
  const auto moved = [&](auto&& edit) { return edited([&](AssetIndex& i) { edit(i.meshes[1][2]); }); };
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before = 0xFFFFFFC0; }), place);  // before the file
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before += 64; }), place);         // over the one before
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.before -= 32; }), place);         // not aligned
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size = 0; }), place);
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size += 1; }), place);                          // no whole elements
  EXPECT_EQ(moved([](AssetIndex::Array& a) { a.size = a.before / 192 * 192 + 192; }), place);  // over the index
  EXPECT_EQ(edited([](AssetIndex& i) { i.meshes[2][0].before = i.meshes[0][0].before; }),
            "f.glb: section \"index\": \"cage 2 vertices\" cannot be where it says");  // not in order
}

TEST(AssetIndexes, AreComparedWithTheJsonWhereAllIsVerified) {
  AssetIndex index = index_of(sample());
  index.origin[1] += 1;
  // Every hash is right.
  const std::string bytes = forge(
      sample(),
      [&](nlohmann::json& document) {
        auto& sections = document["extensions"][asset_extension]["sections"];
        const std::string hash = to_string(hash_bytes(as_byte_span(encode_index(index))));
        sections.push_back({{"bufferView", sections.size()},
                            {"element_size", index_element_size},
                            {"hash", hash},
                            {"kind", "cage"},
                            {"name", index_name}});
      },
      [&](std::string& bin) {
        const std::string other = encode_index(index);
        bin.replace(bin.size() - other.size(), other.size(), other);
      });
  ASSERT_EQ(bytes.size(), sample().size());
  const AlignedBytes aligned(bytes);
  EXPECT_EQ(error_of([&] { AssetView(aligned.span(), "f.glb", Verify::all); }),
            "f.glb: section \"index\": does not say what the JSON says");
  EXPECT_EQ(AssetView(aligned.span(), "f.glb", Verify::cages, AssetParts::arrays).summary().origin[1], 1);
}

TEST(AssetIndexes, AreNotSeenInOtherFiles) {
  const std::string good = sample();
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, seal_size, seal_size + 63, seal_size + 64}) {
    EXPECT_FALSE(find_index(as_byte_span(good.substr(good.size() - size)))) << size;
  }
  EXPECT_TRUE(find_index(as_byte_span(good)));
  EXPECT_FALSE(find_index(as_byte_span(good + good)));
}

}  // namespace
}  // namespace encage
