// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/asset/view.h"

#include "src/asset/writer.h"
#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace encage {
namespace {

using nlohmann::json;

std::string viewed_sample() { return encode_asset(sample_hierarchy(), "Encage 0.1.0", "f.glb"); }

/// Opens an asset in memory and reads all of it.
void use(const std::string& bytes, Verify verify) {
  const AlignedBytes aligned(bytes);
  copy_hierarchy(AssetView(aligned.span(), "f.glb", verify));
}

/// Returns the message for a viewed_sample whose JSON was edited and hashed anew.
template <class Edit>
std::string refusal(Edit&& edit) {
  return error_of([&] { use(forge(viewed_sample(), edit), Verify::all); });
}

json& extension(json& document) { return document["extensions"]["ENCAGE_cages"]; }

TEST(AssetView, shows_aligned_arrays_in_place) {
  const AlignedBytes bytes(viewed_sample());
  const AssetView view(bytes.span(), "f.glb", Verify::all);
  // Three meshes have vertices, triangles, boxes, leaves, owned and parts each; the index comes last.
  ASSERT_EQ(view.sections().size(), 19U);
  for (const AssetSection& section : view.sections()) {
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(section.bytes.data()) % 64, 0U);
    EXPECT_EQ((section.bytes.data() - bytes.span().data()) % 64, 0);
    EXPECT_EQ(section.bytes.size() % section.element_size, 0U);
    EXPECT_EQ(view.find_section(section.name), &section);
    EXPECT_EQ(hash_bytes(section.bytes), section.hash);
  }
  EXPECT_EQ(view.find_section("nothing"), nullptr);
  const AssetSection* vertices = view.find_section("cage 2 vertices");
  ASSERT_NE(vertices, nullptr);
  EXPECT_EQ(vertices->kind, SectionKind::cage);
  EXPECT_EQ(static_cast<const void*>(view.cage(1).vertices.data()), vertices->bytes.data());
  EXPECT_EQ(view.cage(1).vertices[3], (std::array<float, 3>{-3, -3, 3}));
  EXPECT_EQ(view.find_section("source triangles")->kind, SectionKind::fine);
  EXPECT_EQ(view.fine()->triangles.size(), 12U);
  EXPECT_EQ(view.description().levels.size(), 2U);
  EXPECT_EQ(view.description().levels[1].mesh.triangles.rows(), 0);
}

TEST(AssetView, stays_valid_when_moved) {
  const TemporaryFile file;
  write_bytes(file.path(), viewed_sample());
  AssetView view(file.path(), Verify::all);
  const AssetView moved(std::move(view));
  EXPECT_EQ(moved.cage(1).triangles[3], (std::array<std::uint32_t, 3>{1, 3, 2}));
}

TEST(AssetView, forged_without_a_change_is_accepted) {  // otherwise the refusals below would prove nothing
  EXPECT_NO_THROW(use(forge(
                          viewed_sample(), [](json&) {}, [](std::string&) {}),
                      Verify::all));
}

TEST(AssetView, unknown_sections_and_fields_are_ignored) {
  const std::string bytes = forge(
      viewed_sample(),
      [](json& d) {
        extension(d)["later"] = 1;
        const std::size_t view = d["bufferViews"].size();
        const json last = d["bufferViews"].back();
        d["bufferViews"].push_back(last);
        d["bufferViews"][view]["byteOffset"] = last["byteOffset"].get<int>() + 64;
        d["bufferViews"][view]["byteLength"] = 64;
        const std::string hash = to_string(hash_bytes(as_byte_span(std::string(64, '\0'))));
        extension(d)["sections"].push_back(
            {{"bufferView", view}, {"element_size", 32}, {"hash", hash}, {"kind", "fine"}, {"name", "source tree"}});
      },
      [](std::string& bin) { bin.append(64, '\0'); });
  const AlignedBytes aligned(bytes);
  const AssetView view(aligned.span(), "f.glb", Verify::all);
  ASSERT_NE(view.find_section("source tree"), nullptr);
  EXPECT_EQ(view.find_section("source tree")->bytes.size(), 64U);
}

TEST(AssetView, refuses_foreign_files_and_unknown_versions) {
  EXPECT_EQ(refusal([](json& d) { d.erase("extensions"); }),
            "f.glb: JSON: no extension ENCAGE_cages: not an Encage asset");
  EXPECT_EQ(refusal([](json& d) { extension(d)["version"] = 2; }),
            "f.glb: JSON.extensions.ENCAGE_cages: format version 2 is unknown, this program reads version 1");
  EXPECT_EQ(refusal([](json& d) { extension(d)["version"] = "1"; }),
            "f.glb: JSON.extensions.ENCAGE_cages.version: not an integer");
  EXPECT_EQ(refusal([](json& d) { extension(d).erase("version"); }),
            "f.glb: JSON.extensions.ENCAGE_cages: has no \"version\"");
}

TEST(AssetView, refuses_every_missing_field_but_the_optional_ones) {
  json document = json::parse(parse_glb(as_byte_span(viewed_sample()), "f").json);
  const std::vector<std::string> optional = {"fine_mesh", "options", "volume_ratio", "no_new_handles"};
  const auto check = [&](const json& object, const json::json_pointer& place) {
    for (const auto& item : object.items()) {
      const std::string key = item.key();
      const std::string bytes = forge(viewed_sample(), [&](json& d) { d[place].erase(key); });
      if (std::find(optional.begin(), optional.end(), key) != optional.end()) {
        EXPECT_NO_THROW(use(bytes, Verify::all)) << key;
      } else {
        EXPECT_EQ(error_of([&] { use(bytes, Verify::all); }).find("f.glb: JSON"), 0U) << key;
      }
    }
  };
  const json::json_pointer root("/extensions/ENCAGE_cages");
  check(document[root], root);
  check(document[root]["levels"][1], root / "levels" / 1);
  check(document[root]["sections"][3], root / "sections" / 3);
}

TEST(AssetView, refuses_arrays_out_of_place) {
  const std::string view = "f.glb: JSON.bufferViews[1]: ";
  const auto edit = [](const char* key, json value) { return [=](json& d) { d["bufferViews"][1][key] = value; }; };
  EXPECT_EQ(refusal(edit("byteOffset", 132)), view + "byteOffset is not 64-byte aligned");
  EXPECT_EQ(refusal(edit("byteOffset", 64)), view + "overlaps the section before");
  const std::string bytes = viewed_sample();
  const std::size_t end = parse_glb(as_byte_span(bytes), "f").bin.size() - seal_size;
  EXPECT_EQ(refusal(edit("byteOffset", end)), view + "reaches beyond the BIN chunk");
  EXPECT_EQ(refusal(edit("byteLength", 145)), view + "byteLength is no multiple of the section's element_size");
  EXPECT_EQ(refusal(edit("byteLength", 0)), "f.glb: JSON.bufferViews[1].byteLength: 0 is out of range");
  EXPECT_EQ(refusal(edit("byteLength", INT64_MAX)),
            "f.glb: JSON.bufferViews[1].byteLength: 9223372036854775807 is out of range");
  EXPECT_EQ(refusal(edit("byteOffset", -64)), "f.glb: JSON.bufferViews[1].byteOffset: -64 is out of range");
  EXPECT_EQ(refusal(edit("buffer", 1)), view + "not in the BIN chunk");
  EXPECT_EQ(refusal([](json& d) { extension(d)["sections"][1]["bufferView"] = 19; }),
            "f.glb: JSON.bufferViews: has no element 19, only 19");
  EXPECT_EQ(refusal([](json& d) { extension(d)["sections"][1]["name"] = "source vertices"; }),
            "f.glb: JSON.extensions.ENCAGE_cages.sections[1]: a second section \"source vertices\"");
  EXPECT_EQ(refusal([](json& d) { extension(d)["sections"][1]["kind"] = "soup"; }),
            "f.glb: JSON.extensions.ENCAGE_cages.sections[1].kind: \"soup\" is unknown");
}

TEST(AssetView, refuses_meshes_that_are_not_as_written) {
  const auto accessor = [](const char* key, json value) { return [=](json& d) { d["accessors"][2][key] = value; }; };
  EXPECT_EQ(refusal(accessor("componentType", 5125)), "f.glb: JSON.accessors[2]: unexpected componentType");
  EXPECT_EQ(refusal(accessor("type", "VEC2")), "f.glb: JSON.accessors[2]: unexpected type");
  EXPECT_EQ(refusal(accessor("byteOffset", 12)), "f.glb: JSON.accessors[2]: byteOffset and sparse are not allowed");
  EXPECT_EQ(refusal(accessor("count", 7)), "f.glb: JSON.accessors[2]: count does not match the section's size");
  EXPECT_EQ(refusal(accessor("bufferView", 18)), "f.glb: JSON.accessors[2].bufferView: is in no section");
  EXPECT_EQ(refusal(accessor("bufferView", 0)),
            "f.glb: JSON.extensions.ENCAGE_cages.sections[0]: kind is not \"cage\"");
  EXPECT_EQ(refusal([](json& d) { extension(d)["sections"][6]["element_size"] = 4; }),
            "f.glb: JSON.extensions.ENCAGE_cages.sections[6]: element_size is not 12");
  EXPECT_EQ(refusal([](json& d) { d["meshes"][1]["primitives"][0]["mode"] = 5; }),
            "f.glb: JSON.meshes[1].primitives[0]: its mode is not 4, triangles");
  EXPECT_EQ(refusal([](json& d) { d["meshes"][1]["primitives"] = json::array(); }),
            "f.glb: JSON.meshes[1].primitives: has not 1 element");
  EXPECT_EQ(refusal([](json& d) { extension(d)["levels"][0]["mesh"] = 2; }),
            "f.glb: JSON.extensions.ENCAGE_cages.levels[1].mesh: the meshes do not go from fine to coarse");
  EXPECT_EQ(refusal([](json& d) { extension(d)["levels"][1]["mesh"] = INT64_MAX; }),
            "f.glb: JSON.meshes: has no element 9223372036854775807, only 3");
}

TEST(AssetView, refuses_claims_that_mean_nothing) {
  const auto level = [](const char* key, json value) {
    return [=](json& d) { extension(d)["levels"][0][key] = value; };
  };
  EXPECT_EQ(refusal(level("clearance", 0)), "f.glb: cage 1: clearance is not finite and above 0");
  EXPECT_EQ(refusal(level("clearance", nullptr)),
            "f.glb: JSON.extensions.ENCAGE_cages.levels[0].clearance: not a number");
  EXPECT_EQ(refusal(level("components", 1LL << 40)),
            "f.glb: JSON.extensions.ENCAGE_cages.levels[0].components: 1099511627776 is out of range");
  EXPECT_EQ(refusal(level("method", "luck")),
            "f.glb: JSON.extensions.ENCAGE_cages.levels[0].method: \"luck\" is unknown");
  EXPECT_EQ(refusal(level("volume", 73)),
            "f.glb: cage 2: its volume is smaller than that of the cage before: "
            "levels must go from fine to coarse");
  EXPECT_EQ(refusal([](json& d) { extension(d)["cap_count"] = 13; }),
            "f.glb: cap_count exceeds the triangles of the source");
  EXPECT_EQ(refusal([](json& d) {
              extension(d)["origin"] = {1, 2};
            }),
            "f.glb: JSON.extensions.ENCAGE_cages.origin: has not 3 elements");
  EXPECT_EQ(refusal([](json& d) { extension(d)["levels"] = json::array(); }), "f.glb: there is no cage");
}

TEST(AssetView, refuses_arrays_that_would_lead_astray) {
  const auto spoil = [](std::size_t offset, std::uint32_t value) {
    return error_of([&] {
      use(forge(viewed_sample(), {}, [&](std::string& bin) { std::memcpy(bin.data() + offset, &value, sizeof value); }),
          Verify::all);
    });
  };
  const json document = json::parse(parse_glb(as_byte_span(viewed_sample()), "f").json);
  const auto offset = [&](int view) { return document["bufferViews"][view]["byteOffset"].get<std::size_t>(); };
  constexpr std::uint32_t float_infinity = 0x7f800000;
  EXPECT_EQ(spoil(offset(0) + 12, float_infinity), "f.glb: source: vertex 1: not finite");
  EXPECT_EQ(spoil(offset(1) + 16, 8), "f.glb: source: triangle 1: index 8 is out of range, there are 8 vertices");
  EXPECT_EQ(spoil(offset(12) + 44, float_infinity + 1), "f.glb: cage 2: vertex 3: not finite");
  EXPECT_EQ(spoil(offset(13), 0xffffffff),
            "f.glb: cage 2: triangle 0: index 4294967295 is out of range, there are 4 vertices");
}

TEST(AssetView, truncation_is_noticed_at_every_length) {
  const std::string good = viewed_sample();
  const std::size_t bin_start = parse_glb(as_byte_span(good), "f").head.size();
  for (std::size_t n = 0; n < good.size(); ++n) {
    std::string cut = good.substr(0, n);
    EXPECT_THROW(use(cut, Verify::cages), Error) << n;
    // The same with lengths that fit, so that the later checks are reached.
    if (n < bin_start) continue;
    const auto size = static_cast<std::uint32_t>(n), bin_size = static_cast<std::uint32_t>(n - bin_start);
    std::memcpy(cut.data() + 8, &size, sizeof size);
    std::memcpy(cut.data() + bin_start - 8, &bin_size, sizeof bin_size);
    EXPECT_THROW(use(cut, Verify::cages), Error) << n;
  }
}

TEST(AssetView, garbage_is_noticed) {
  const std::string good = viewed_sample();
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    std::string bad = good;
    const std::size_t start = random() % good.size(), length = 1 + random() % 64;
    for (std::size_t i = start; i < std::min(start + length, good.size()); ++i) bad[i] = static_cast<char>(random());
    if (bad == good) continue;
    EXPECT_THROW(use(bad, Verify::all), Error) << round;
  }
}

/// Collects every value of the document, at any depth.
void collect(json& value, std::vector<json*>& all) {
  all.push_back(&value);
  if (!value.is_structured()) return;
  for (json& child : value) collect(child, all);
}

TEST(AssetView, forged_json_is_refused_or_harmless) {
  const json replacements[] = {nullptr,        true,         -1,    0,   1,  3,      64,
                               INT64_MAX,      UINT64_MAX,   1e300, 0.5, "", "cage", json::array(),
                               json::object(), json{1, 2, 3}};
  std::mt19937 random(2);
  int accepted = 0, refused = 0;
  for (int round = 0; round < 6000; ++round) {
    const std::string bytes = forge(viewed_sample(), [&](json& document) {
      std::vector<json*> all;
      collect(document, all);
      *all[random() % all.size()] = replacements[random() % std::size(replacements)];
    });
    try {
      use(bytes, Verify::all);
      ++accepted;
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(accepted, 100);  // the reader ignores names, materials and the like
}

}  // namespace
}  // namespace encage
