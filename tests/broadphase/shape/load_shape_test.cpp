// SPDX-License-Identifier: GPL-3.0-or-later
#include "broadphase/shape/shape.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"
#include "tests/src/asset/forge.h"
#include "tests/src/asset/sample.h"

#include <encage/asset.h>
#include <encage/contact.h>
#include <encage/separated.h>
#include <encage/shape_cache.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace encage::test {
namespace {

using nlohmann::json;

TriangleMesh rounded(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.cast<float>().cast<double>().eval();
  return mesh;
}

/// Of some hundred triangles: trees of several nodes.
CageHierarchy large_hierarchy() {
  CageHierarchy h = sample_hierarchy();
  h.cap_count = 0;
  h.solid = Solid::closed;
  h.fine = rounded(shapes::joined(shapes::torus(1, 0.3, 20, 10), shapes::sphere(2)));
  h.levels[0].mesh = rounded(shapes::scaled(shapes::sphere(3), 1.5));
  h.levels[1].mesh = rounded(shapes::scaled(shapes::sphere(2), 2));
  return h;
}

template <class T>
void expect_same_bytes(std::span<const T> a, std::span<const T> b) {
  ASSERT_EQ(a.size(), b.size());
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
}

void expect_same(const Surface& a, const Surface& b) {
  ASSERT_EQ(a.empty(), b.empty());
  if (a.empty()) return;
  expect_same_bytes(a.mesh.vertices, b.mesh.vertices);
  expect_same_bytes(a.mesh.triangles, b.mesh.triangles);
  expect_same_bytes(a.tree.nodes, b.tree.nodes);
  expect_same_bytes(a.tree.leaves, b.tree.leaves);
  expect_same_bytes(a.owned, b.owned);
  expect_same_bytes(a.parts, b.parts);
  EXPECT_EQ(a.closed, b.closed);
  EXPECT_EQ(a.radius, b.radius);
  EXPECT_EQ(a.lower, b.lower);
  EXPECT_EQ(a.upper, b.upper);
}

void expect_same(const Shape& shape_a, const Shape& shape_b) {
  const SimpleShape &a = shape_a.simple(), &b = shape_b.simple();
  EXPECT_EQ(a.frame.origin, b.frame.origin);
  EXPECT_EQ(a.solid, b.solid);
  EXPECT_EQ(a.fine_error, b.fine_error);
  EXPECT_EQ(a.frame.radius, b.frame.radius);
  ASSERT_EQ(a.cages.size(), b.cages.size());
  for (std::size_t k = 0; k < a.cages.size(); ++k) expect_same(a.cages[k], b.cages[k]);
  expect_same(a.fine, b.fine);
}

/// Every query once, for some motions; the answers as numbers.
std::vector<double> answers(const Shape& shape, int rounds = 20) {
  shapes::Random random(1);
  std::vector<double> all;
  for (int i = 0; i < rounds; ++i) {
    const auto about_origin = [&](Motion motion) {
      motion.start.translation() -= motion.start.linear() * shape.simple().frame.origin;
      motion.end.translation() -= motion.end.linear() * shape.simple().frame.origin;
      return motion;
    };
    const Motion a = about_origin(random_motion(random, random_pose(random, 2), 0.5, 0.5));
    const Motion b = about_origin(random_motion(random, random_pose(random, 2), 0.5, 0.5));
    const Eigen::AlignedBox3d box = world_box(shape, a);
    all.insert(all.end(), {box.min().x(), box.max().z(), arc_margin(shape, a)});
    const Verdict verdict = separated(shape, a, shape, b, 0.01);
    all.insert(all.end(), {double(verdict.separated), double(verdict.stage), double(verdict.level)});
    all.push_back(separated(shape, a, HalfSpace{.offset = -1}).separated);
    double candidates = 0;
    for_each_triangle_pair(shape, a, shape, b, 0.01, [&](TrianglePair pair) {
      candidates = candidates * 1.25 + pair.a + 3 * pair.b;
      return candidates < 1e100;
    });
    all.push_back(candidates);
    if (shape.simple().fine.empty()) continue;
    for (const auto& contact : {first_contact(shape, a, shape, b), first_contact(shape, a, HalfSpace{.offset = -1})}) {
      all.push_back(contact ? contact->time + 10 * contact->vertices[0] + 100 * contact->vertices[3] : -1);
    }
  }
  return all;
}

CageHierarchy without_fine(CageHierarchy h) {
  h.fine = {};
  h.cap_count = 0;
  h.solid = Solid::closed;
  return h;
}

TEST(LoadShape, IsTheShapeMadeOfTheHierarchy) {
  for (const CageHierarchy& hierarchy :
       {sample_hierarchy(), large_hierarchy(), without_fine(sample_hierarchy()), without_fine(large_hierarchy())}) {
    const TemporaryFile file;
    write_asset(file.path(), hierarchy);
    const ShapePtr loaded = load_shape(file.path()), made = make_shape(read_asset(file.path()));
    expect_same(*loaded, *made);
    EXPECT_EQ(answers(*loaded), answers(*made));
    // In place: nothing is built or copied.
    EXPECT_TRUE(loaded->simple().owned_arrays.empty());
    EXPECT_TRUE(loaded->simple().asset.has_value());
    EXPECT_FALSE(loaded->simple().asset->has_description());  // the index was enough
    const AssetSection* nodes = loaded->simple().asset->find_section("cage 1 boxes");
    EXPECT_EQ(static_cast<const void*>(loaded->simple().cages[0].tree.nodes.data()), nodes->bytes.data());
  }
}

TEST(LoadShape, ReadsAssetsFromBeforeItsTreesWereStored) {
  const std::string data = ENCAGE_TEST_DATA;
  const ShapePtr recent = load_shape(data + "/asset_v1_boxes.glb");
  EXPECT_TRUE(recent->simple().asset.has_value());
  EXPECT_TRUE(recent->simple().asset->has_description());  // no index
  expect_same(*recent, *make_shape(sample_hierarchy()));
  for (const char* before : {"/asset_v1.glb", "/asset_v1_trees.glb"}) {
    const ShapePtr old = load_shape(data + before);
    EXPECT_FALSE(old->simple().asset.has_value()) << before;
    expect_same(*old, *recent);
    EXPECT_EQ(answers(*old), answers(*recent)) << before;
  }
}

TEST(LoadShape, OutlivesItsFile) {
  ShapePtr shape;
  std::vector<double> expected;
  {
    const TemporaryFile file;
    write_asset(file.path(), large_hierarchy());
    shape = load_shape(file.path());
    expected = answers(*shape);
  }
  EXPECT_EQ(answers(*shape), expected);  // the file is removed, its pages stay
}

TEST(LoadShape, ACopyIsDoneWithItsFile) {
  const TemporaryFile file;
  write_asset(file.path(), large_hierarchy());
  const std::string good = read_bytes(file.path());
  const ShapePtr shape = load_shape(file.path(), {}, LoadMode::copy);
  expect_same(*shape, *load_shape(file.path()));
  const std::vector<double> expected = answers(*shape);
  write_bytes(file.path(), std::string(good.size(), 'x'));
  EXPECT_EQ(answers(*shape), expected);
  std::filesystem::resize_file(file.path(), 1);
  EXPECT_EQ(answers(*shape), expected);
  for (const std::string& bad : {good.substr(0, 10), good.substr(0, good.size() / 2), good + good, std::string()}) {
    write_bytes(file.path(), bad);
    EXPECT_EQ(error_of([&] { load_shape(file.path(), {}, LoadMode::copy); }),
              error_of([&] { load_shape(file.path()); }));
  }
}

// ---- Damage ------------------------------------------------------------------

std::vector<std::string> section_names(const std::string& asset) {
  const json document = json::parse(parse_glb(as_byte_span(asset), "f").json);
  std::vector<std::string> names;
  for (const json& section : document["extensions"]["ENCAGE_cages"]["sections"]) names.push_back(section["name"]);
  return names;
}

/// Offset and size of a section within the BIN chunk.
std::pair<std::size_t, std::size_t> place_of(const std::string& asset, const std::string& name) {
  const json document = json::parse(parse_glb(as_byte_span(asset), "f").json);
  for (const json& section : document["extensions"]["ENCAGE_cages"]["sections"]) {
    if (section["name"] != name) continue;
    const json& view = document["bufferViews"][section["bufferView"].get<std::size_t>()];
    return {view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()};
  }
  throw std::runtime_error("no section " + name);
}

TEST(LoadShape, ReadsAnIndexOfAnyLengthByCopy) {
  // 27 meshes fill the part of a file that is read first.
  for (const std::size_t levels : {2, 26, 27, 60}) {
    const TemporaryFile file;
    CageHierarchy hierarchy = sample_hierarchy();
    while (hierarchy.levels.size() < levels) hierarchy.levels.push_back(hierarchy.levels.back());
    write_asset(file.path(), hierarchy);
    for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
      EXPECT_EQ(level_count(*load_shape(file.path(), {}, mode)), levels);
      ShapeCache cache({1 << 20, mode});
      EXPECT_EQ(level_count(*cache.load(file.path())), levels);
    }
  }
}

TEST(LoadShape, NamesFileAndSectionOfADamagedByte) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string good = read_bytes(file.path());
  const std::size_t bin = parse_glb(as_byte_span(good), "f").head.size();
  const std::vector<std::string> names = section_names(good);
  EXPECT_EQ(names.size(), 19U);
  for (const std::string& name : names) {
    const auto [offset, size] = place_of(good, name);
    for (const std::size_t at : {std::size_t{0}, size / 2, size - 1}) {
      std::string bad = good;
      bad[bin + offset + at] ^= 4;
      write_bytes(file.path(), bad);
      for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
        EXPECT_EQ(error_of([&] { load_shape(file.path(), {}, mode); }),
                  file.path().string() + ": section \"" + name + "\": its hash does not match: the file is damaged");
      }
    }
  }
}

TEST(LoadShape, NamesAMissingSection) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string good = read_bytes(file.path());
  const auto without = [&](const std::string& name) {
    write_bytes(file.path(), forge(good, [&](json& d) {
                  json& sections = d["extensions"]["ENCAGE_cages"]["sections"];
                  for (std::size_t i = 0; i < sections.size(); ++i) {
                    if (sections[i]["name"] == name) sections.erase(i);
                  }
                }));
    return error_of([&] { load_shape(file.path()); }).substr(file.path().string().size());
  };
  for (const char* mesh : {"source", "cage 1", "cage 2"}) {
    for (const char* array : {" leaves", " owned", " parts"}) {
      EXPECT_EQ(without(std::string(mesh) + array), ": no section \"" + std::string(mesh) + array + "\"");
    }
  }
  EXPECT_EQ(without("cage 1 boxes"), ": cage 1: no stored tree");
  EXPECT_EQ(without("cage 2 boxes"), ": cage 2: no stored tree");
}

TEST(LoadShape, NamesASectionOfAnotherElementSize) {
  const TemporaryFile file;
  write_asset(file.path(), sample_hierarchy());
  const std::string good = read_bytes(file.path());
  for (const char* name : {"source boxes", "cage 1 leaves", "cage 2 parts"}) {
    write_bytes(file.path(), forge(good, [&](json& d) {
                  for (json& section : d["extensions"]["ENCAGE_cages"]["sections"]) {
                    if (section["name"] == name) section["element_size"] = 4;
                  }
                }));
    EXPECT_EQ(error_of([&] {
                load_shape(file.path());
              }).rfind(file.path().string() + ": section \"" + name + "\": its elements have 4 bytes, not ", 0),
              0U);
  }
}

TEST(LoadShape, DamageThatHashesCannotShowIsRefusedOrHarmless) {
  const TemporaryFile file;
  write_asset(file.path(), large_hierarchy());
  const std::string good = read_bytes(file.path());
  const std::vector<std::string> names = section_names(good);
  const std::uint32_t values[] = {0,          1,          2,          3,          7,          8,
                                  0xffffffff, 0x80000000, 0x7fffffff, 0x7f800000, 0xff800000, 0x7fc00000,
                                  0x3f800000, 0xbf800000, 0x00000001, 0x7f7fffff};
  const char* longer = std::getenv("ENCAGE_DAMAGE_ROUNDS");  // by hand
  const int rounds = longer ? std::atoi(longer) : 80;
  std::mt19937 random(1);
  int refused = 0, accepted = 0;
  for (int round = 0; round < rounds; ++round) {
    SCOPED_TRACE(round);
    const std::string& name = names[random() % names.size()];
    const auto [offset, size] = place_of(good, name);
    write_bytes(file.path(), forge(good, {}, [&, offset = offset, size = size](std::string& bin) {
                  for (auto changes = 1 + random() % 3; changes > 0; --changes) {
                    const std::size_t word = 4 * (random() % std::max<std::size_t>(size / 4, 1));
                    const std::uint32_t value =
                        random() % 3 == 0 ? static_cast<std::uint32_t>(random()) : values[random() % std::size(values)];
                    const std::size_t length = std::min<std::size_t>(4, size - word);
                    std::memcpy(bin.data() + offset + word, &value, length);
                  }
                }));
    try {
      const ShapePtr shape = load_shape(file.path());
      ++accepted;
      EXPECT_GT(answers(*shape, 2).size(), 10U);
    } catch (const Error& error) {
      ++refused;
      const std::string message = error.what();
      const std::string mesh = name.substr(0, name.rfind(' '));
      EXPECT_EQ(message.rfind(file.path().string() + ": " + mesh + ": ", 0), 0U) << message;
    }
  }
  EXPECT_GT(refused, rounds / 3);
  EXPECT_GT(accepted, rounds / 12);
}

TEST(LoadShape, RefusesWhatIsNoAsset) {
  EXPECT_EQ(error_of([] { load_shape("/nowhere/a.glb"); }), "/nowhere/a.glb: cannot open: No such file or directory");
  const TemporaryFile file;
  CageHierarchy open = sample_hierarchy();
  open.levels[1].mesh.triangles.conservativeResize(3, 3);
  write_asset(file.path(), open);
  EXPECT_EQ(error_of([&] { load_shape(file.path()); }), file.path().string() + ": cage 2: not closed");
}

}  // namespace
}  // namespace encage::test
