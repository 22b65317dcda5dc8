// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/count_allocations.h"
#include "tests/broadphase/shape/stored_samples.h"
#include "tests/broadphase/world/thread_pool.h"
#include "tests/src/asset/sample.h"

#include <encage/contact.h>
#include <encage/shape_cache.h>
#include <encage/world.h>

#include <cstdlib>
#include <optional>
#include <thread>

namespace encage::test {
namespace {

constexpr std::int64_t plenty = std::int64_t{1} << 40;

const ShapeCacheOptions both_modes[] = {{plenty, LoadMode::map}, {plenty, LoadMode::copy}};

std::int64_t size_of_fine(const std::filesystem::path& file) { return AssetView(file, Verify::cages).fine_bytes(); }

/// Every query about two bodies, as numbers.
std::vector<double> answers(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b) {
  std::vector<double> all;
  for (const double margin : {0.0, 0.05}) {
    const Verdict verdict = separated(a, motion_a, b, motion_b, margin);
    all.insert(all.end(), {double(verdict.separated), double(verdict.stage), double(verdict.level)});
    for_each_triangle_pair(a, motion_a, b, motion_b, margin, [&](TrianglePair pair) {
      all.insert(all.end(), {double(pair.a), double(pair.b)});
      return all.size() < 200;
    });
  }
  const auto add = [&](const std::optional<Contact>& contact) {
    all.push_back(contact ? contact->time + 10 * contact->vertices[0] + 100 * contact->vertices[3] : -1);
  };
  add(first_contact(a, motion_a, b, motion_b));
  const HalfSpace plane{.offset = -1};
  add(first_contact(a, motion_a, plane));
  const Verdict verdict = separated(a, motion_a, plane, 0.1);
  all.insert(all.end(), {double(verdict.separated), double(verdict.stage), double(verdict.level)});
  return all;
}

/// A question about two of the shapes.
struct Question {
  std::size_t a, b;
  Motion motion_a, motion_b;
};

std::vector<Question> questions(std::size_t shapes, int count) {
  shapes::Random random(3);
  std::vector<Question> all;
  for (int i = 0; i < count; ++i) {
    const auto a = static_cast<std::size_t>(random.integer(static_cast<int>(shapes)));
    const auto b = static_cast<std::size_t>(random.integer(static_cast<int>(shapes)));
    all.push_back({a, b, random_motion(random, random_pose(random, 1.5), 0.5, 0.5),
                   random_motion(random, random_pose(random, 1.5), 0.5, 0.5)});
  }
  return all;
}

std::vector<double> answers(const std::vector<ShapePtr>& shapes, const Question& q) {
  return answers(*shapes[q.a], q.motion_a, *shapes[q.b], q.motion_b);
}

std::vector<ShapePtr> load_all(ShapeCache& cache, const std::vector<std::filesystem::path>& files) {
  std::vector<ShapePtr> shapes;
  for (const auto& file : files) shapes.push_back(cache.load(file));
  return shapes;
}

// ---- Answers ---------------------------------------------------------------

TEST(ShapeCaches, AnswersDoNotDependOnWhatIsInMemory) {
  const StoredSamples stored;
  for (const ShapeCacheOptions& plentiful : both_modes) {
    ShapeCache all(plentiful), few({stored.room_for_a_pair(), plentiful.mode});
    const std::vector<ShapePtr> resident = load_all(all, stored.files), on_demand = load_all(few, stored.files);
    std::vector<FineLease> leases;
    for (const ShapePtr& shape : resident) leases.emplace_back(*shape);
    int i = 0;
    for (const Question& q : questions(stored.files.size(), 300)) {
      ASSERT_EQ(answers(on_demand, q), answers(resident, q));
      EXPECT_LE(few.statistics().resident_bytes, stored.room_for_a_pair());
      if (++i % 20 == 0) few.clear();
    }
    EXPECT_LE(few.statistics().peak_bytes, stored.room_for_a_pair());
    EXPECT_GT(few.statistics().evictions, 100);
    EXPECT_EQ(all.statistics().faults, static_cast<std::int64_t>(resident.size()));
    EXPECT_EQ(all.statistics().evictions, 0);
  }
}

TEST(ShapeCaches, PartsOfCompoundsComeAndGo) {
  const StoredSamples stored;
  // Each with two parts, next to each other.
  const auto compounds = [](const std::vector<ShapePtr>& shapes) {
    std::vector<ShapePtr> all;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      Eigen::Isometry3d beside = Eigen::Isometry3d::Identity();
      beside.translation().x() = 1.5;
      const CompoundPart parts[] = {{shapes[i]}, {shapes[(i + 1) % shapes.size()], beside, 0.5}};
      all.push_back(make_compound(parts));
    }
    return all;
  };
  for (const ShapeCacheOptions& plentiful : both_modes) {
    ShapeCache cache({stored.room_for_a_pair(), plentiful.mode}), all(plentiful);
    const std::vector<ShapePtr> parts = load_all(all, stored.files);
    std::vector<FineLease> leases;
    for (const ShapePtr& part : parts) leases.emplace_back(*part);
    const std::vector<ShapePtr> on_demand = compounds(load_all(cache, stored.files)), resident = compounds(parts);
    int touching = 0;
    for (const Question& q : questions(resident.size(), 150)) {
      const std::vector<double> expected = answers(resident, q);
      ASSERT_EQ(answers(on_demand, q), expected);
      EXPECT_LE(cache.statistics().resident_bytes, stored.room_for_a_pair());
      touching += expected[0] == 0 ? 1 : 0;
    }
    EXPECT_GT(touching, 20);
    EXPECT_LT(touching, 130);
    EXPECT_GT(cache.statistics().evictions, 100);
  }
}

TEST(ShapeCaches, ShapesAnswerLikeThoseOfPlainLoads) {
  const StoredSamples stored;
  ShapeCache cache({stored.room_for_a_pair()});
  const std::vector<ShapePtr> on_demand = load_all(cache, stored.files);
  std::vector<ShapePtr> plain;
  for (const auto& file : stored.files) plain.push_back(load_shape(file));
  int separate = 0, touching = 0;
  for (const Question& q : questions(stored.files.size(), 400)) {
    const Shape &a = *plain[q.a], &b = *plain[q.b], &da = *on_demand[q.a], &db = *on_demand[q.b];
    EXPECT_TRUE(world_box(da, q.motion_a).contains(world_box(a, q.motion_a)));
    EXPECT_GE(arc_margin(da, q.motion_a), arc_margin(a, q.motion_a));
    const bool apart = separated(a, q.motion_a, b, q.motion_b, PairOptions{.cages = CageUse::always}).separated;
    ++(apart ? separate : touching);
    const bool solid = a.simple().solid != Solid::surface_only && b.simple().solid != Solid::surface_only;
    const Verdict verdict = separated(da, q.motion_a, db, q.motion_b);
    // The interior of a surface is bounded by its cage, not by its own box.
    EXPECT_TRUE(solid ? verdict.separated == apart : apart || !verdict.separated);
    const auto triangles = [&](const Shape& x, const Shape& y) {
      std::vector<std::pair<int, int>> found;
      for_each_triangle_pair(x, q.motion_a, y, q.motion_b, 0, [&](TrianglePair pair) {
        found.emplace_back(pair.a, pair.b);
        return true;
      });
      return found;
    };
    EXPECT_EQ(triangles(da, db), triangles(a, b));
    const auto contact = first_contact(da, q.motion_a, db, q.motion_b),
               expected = first_contact(a, q.motion_a, b, q.motion_b);
    ASSERT_EQ(contact.has_value(), expected.has_value());
    if (!contact) continue;
    EXPECT_EQ(contact->time, expected->time);
    EXPECT_EQ(contact->vertices, expected->vertices);
  }
  EXPECT_GT(separate, 50);
  EXPECT_GT(touching, 50);
}

TEST(ShapeCaches, WhatCagesProveNeedsNoFineMesh) {
  const StoredSamples stored;
  ShapeCache cache({stored.room_for_a_pair()});
  const std::vector<ShapePtr> shapes = load_all(cache, stored.files);
  World world;
  shapes::Random random(5);
  for (int i = 0; i < 60; ++i) {
    const ShapeId shape = world.add_shape(shapes[static_cast<std::size_t>(i) % shapes.size()]);
    const Motion motion = random_motion(random, random_pose(random, 60), 0.5, 0.5);
    world.set_motion(world.add_body(shape, motion.start), motion);
  }
  world.add_half_space({.offset = -100});
  std::int64_t before = 0;
  world.find_candidates({}, [&](const CandidatePair&) { FAIL() << "one is near"; });
  EXPECT_EQ(cache.statistics().faults, 0);

  // A pair that its cages prove separated although its boxes are not.
  for (const Question& q : questions(shapes.size(), 400)) {
    const Shape &a = *shapes[q.a], &b = *shapes[q.b];
    world_box(a, q.motion_a), arc_margin(a, q.motion_a);
    before = cache.statistics().faults;
    const Verdict verdict = separated(a, q.motion_a, b, q.motion_b);
    const bool needed = !verdict.separated || verdict.stage == Stage::fine;
    if (a.simple().solid == Solid::surface_only || b.simple().solid == Solid::surface_only || needed) continue;
    EXPECT_EQ(cache.statistics().faults, before);
  }
  EXPECT_GT(cache.statistics().faults, 0);
}

TEST(ShapeCaches, ReadAssetsFromBeforeTreesWereStored) {
  const std::string data = ENCAGE_TEST_DATA;
  ShapeCache cache({20'000});
  const ShapePtr recent = cache.load(data + "/asset_v1_boxes.glb");
  for (const char* before : {"/asset_v1.glb", "/asset_v1_trees.glb"}) {
    const ShapePtr old = cache.load(data + before);
    for (const Question& q : questions(1, 20)) {
      Motion a = q.motion_a, b = q.motion_b;
      for (Motion* m : {&a, &b})
        m->start.translation() -= m->start.linear() * old->simple().frame.origin,
            m->end.translation() -= m->end.linear() * old->simple().frame.origin;
      EXPECT_EQ(answers(*old, a, *old, b), answers(*recent, a, *recent, b));
      cache.clear();
      EXPECT_TRUE(old->simple().fine.empty());
      EXPECT_EQ(cache.statistics().resident_bytes, 0);
    }
  }
}

// ---- Budget ----------------------------------------------------------------

/// Equal copies of one asset, hence of one size.
class EqualFiles {
 public:
  explicit EqualFiles(int count) {
    for (int i = 0; i < count; ++i) {
      files.push_back(folder.path() / (std::to_string(i) + ".glb"));
      write_asset(files.back(), sample_hierarchy());
    }
    size = size_of_fine(files[0]);
  }
  TemporaryFolder folder;
  std::vector<std::filesystem::path> files;
  std::int64_t size = 0;
};

TEST(ShapeCaches, TheLeastRecentlyUsedMeshGoesFirst) {
  const EqualFiles equal(4);
  for (const LoadMode mode : {LoadMode::map, LoadMode::copy}) {
    ShapeCache cache({3 * equal.size + 1, mode});
    const std::vector<ShapePtr> shapes = load_all(cache, equal.files);
    const auto misses = [&](std::size_t i) {
      const std::int64_t before = cache.statistics().faults;
      FineLease lease(*shapes[i]);
      return cache.statistics().faults - before;
    };
    for (const std::size_t i : {0u, 1u, 2u}) EXPECT_EQ(misses(i), 1);
    EXPECT_EQ(cache.statistics().resident_meshes, 3);
    EXPECT_EQ(cache.statistics().evictions, 0);
    EXPECT_EQ(misses(0), 0);  // used again: 1 is the oldest
    EXPECT_EQ(misses(3), 1);
    EXPECT_EQ(cache.statistics().evictions, 1);
    for (const std::size_t i : {0u, 2u, 3u}) EXPECT_EQ(misses(i), 0);
    EXPECT_EQ(misses(1), 1);  // in place of 0
    EXPECT_EQ(misses(0), 1);  // of 2
    for (const std::size_t i : {3u, 1u, 0u}) EXPECT_EQ(misses(i), 0);
    const FineLease held(*shapes[3]);  // the oldest but held
    EXPECT_EQ(misses(1) + misses(0), 0);
    EXPECT_EQ(misses(2), 1);  // in place of 1
    EXPECT_EQ(misses(3) + misses(0) + misses(2), 0);
    EXPECT_EQ(misses(1), 1);
  }
}

TEST(ShapeCaches, HeldMeshesMayExceedTheBudgetWhileTheyAreHeld) {
  const EqualFiles equal(5);
  ShapeCache cache({2 * equal.size, LoadMode::copy});
  const std::vector<ShapePtr> shapes = load_all(cache, equal.files);
  std::vector<FineLease> leases;
  for (const ShapePtr& shape : shapes) leases.emplace_back(*shape);
  EXPECT_EQ(cache.statistics().resident_bytes, 5 * equal.size);
  cache.clear();
  EXPECT_EQ(cache.statistics().resident_meshes, 5);
  for (int left = 4; left >= 0; --left) {
    leases.pop_back();
    EXPECT_EQ(cache.statistics().resident_meshes, std::max(left, 2));
    EXPECT_EQ(cache.statistics().resident_bytes, std::max(left, 2) * equal.size);
  }
  EXPECT_EQ(cache.statistics().peak_bytes, 5 * equal.size);
  cache.clear();
  EXPECT_EQ(cache.statistics().resident_bytes, 0);
  EXPECT_EQ(cache.statistics().evictions, 5);
}

TEST(ShapeCaches, NameWhatABudgetIsTooSmallFor) {
  EXPECT_EQ(error_of([] { ShapeCache cache({0}); }), "shape cache: the budget of 0 bytes is not positive");
  EXPECT_EQ(error_of([] { ShapeCache cache({-5}); }), "shape cache: the budget of -5 bytes is not positive");
  const EqualFiles equal(2);
  const std::string first = equal.files[0].string(), second = equal.files[1].string(),
                    size = std::to_string(equal.size);
  ShapeCache one_less({equal.size - 1});
  EXPECT_EQ(
      error_of([&] { one_less.load(first); }),
      first + ": the fine mesh needs " + size + " bytes, the budget is " + std::to_string(equal.size - 1) + " bytes");
  ShapeCache one({equal.size});
  ShapePtr shape = one.load(first);
  EXPECT_EQ(error_of([&] { one.load(second); }),
            second + ": the fine mesh needs " + size + " bytes, the largest other one " + size +
                " bytes, a pair of them more than the budget of " + size + " bytes");
  shape.reset();
  EXPECT_NE(one.load(second), nullptr);
  // A mesh without a stored tree turns out to be larger than its file said.
  const std::string old = std::string(ENCAGE_TEST_DATA) + "/asset_v1.glb";
  ShapeCache small({size_of_fine(old)});
  const ShapePtr built = small.load(old);
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  EXPECT_FALSE(separated(*built, rest, *built, rest).separated);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(error_of([&] { FineLease lease(*built); }).rfind(old + ": the fine mesh needs ", 0), 0u);
    EXPECT_EQ(small.statistics().resident_bytes, 0);
  }
  // So it does where there is room for it, but not for a pair.
  const std::int64_t built_size = [&] {
    ShapeCache cache({plenty});
    const ShapePtr alone = cache.load(old);
    const FineLease lease(*alone);
    return cache.statistics().resident_bytes;
  }();
  ASSERT_GT(built_size, size_of_fine(old));
  ShapeCache pair({2 * built_size - 1});
  const ShapePtr a = pair.load(old), b = pair.load(old);
  EXPECT_NO_THROW(FineLease{*a});
  EXPECT_EQ(error_of([&] { FineLease lease(*b); }),
            old + ": the fine mesh needs " + std::to_string(built_size) +
                " bytes with its tree, the largest other one " + std::to_string(built_size) +
                " bytes, a pair of them more than the budget of " + std::to_string(2 * built_size - 1) + " bytes");
  EXPECT_FALSE(separated(*b, rest, *b, rest).separated);
  EXPECT_LE(pair.statistics().peak_bytes, built_size);
}

// ---- Failures --------------------------------------------------------------

/// What the queries of a shape say whose fine mesh cannot be had.
void expect_failure(const ShapePtr& shape, const std::string& message) {
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  const Verdict verdict = separated(*shape, rest, *shape, rest);
  EXPECT_FALSE(verdict.separated);
  EXPECT_EQ(verdict.stage, Stage::fine);
  const HalfSpace plane{.offset = 1000};
  EXPECT_FALSE(separated(*shape, rest, plane).separated);
  const auto nothing = [](TrianglePair) { return true; };
  EXPECT_EQ(error_of([&] { for_each_triangle_pair(*shape, rest, *shape, rest, 0, nothing); }), message);
  EXPECT_EQ(error_of([&] { first_contact(*shape, rest, *shape, rest); }), message);
  EXPECT_EQ(error_of([&] { first_contact(*shape, rest, plane); }), message);
  EXPECT_EQ(error_of([&] { PairContact contact(*shape, rest, *shape, rest); }), message);
  EXPECT_EQ(error_of([&] { FineLease lease(*shape); }), message);
  EXPECT_FALSE(FineLease().take(*shape));

  ThreadPool pool(2);
  World world;
  const ShapeId id = world.add_shape(shape);
  for (int i = 0; i < 3; ++i) world.add_body(id, rest.start);
  for (const Executor& executor : {Executor{}, pool.executor()}) {
    int visits = 0;
    const auto count = [&](const CandidatePair&) { ++visits; };
    EXPECT_EQ(error_of([&] { world.find_candidates({.triangles = true, .executor = executor}, count); }), message);
    EXPECT_EQ(visits, 0);
    EXPECT_EQ(world.find_candidates({.executor = executor}, count).candidates, 3);
    EXPECT_EQ(visits, 3);
  }
}

std::string damaged(const std::string& good, const std::string& section) {
  std::string bad = good;
  bad[section_offset(good, section) + 5] ^= 4;
  return bad;
}

TEST(ShapeCaches, NameFileAndSectionOfADamagedFineMeshWhenItIsNeeded) {
  const EqualFiles equal(1);
  const std::string good = read_bytes(equal.files[0]);
  for (const ShapeCacheOptions& options : both_modes) {
    for (const char* name : {"source vertices", "source boxes", "source parts"}) {
      write_bytes(equal.files[0], damaged(good, name));
      ShapeCache cache(options);
      expect_failure(cache.load(equal.files[0]), equal.files[0].string() + ": section \"" + name +
                                                     "\": its hash does not match: the file is damaged");
      EXPECT_EQ(cache.statistics().resident_bytes, 0);
    }
    write_bytes(equal.files[0], damaged(good, "cage 1 vertices"));
    ShapeCache cache(options);
    EXPECT_EQ(error_of([&] { cache.load(equal.files[0]); }),
              equal.files[0].string() + ": section \"cage 1 vertices\": its hash does not match: the file is damaged");
    // No hash notices this.
    write_bytes(equal.files[0], forge(good, {}, [&](std::string& bin) {
                  const std::size_t head = parse_glb(as_byte_span(good), "f").head.size();
                  const std::int32_t triangle = 77;
                  std::memcpy(bin.data() + section_offset(good, "source leaves") - head + 12, &triangle,
                              sizeof triangle);
                }));
    expect_failure(cache.load(equal.files[0]),
                   equal.files[0].string() + ": source: leaf triangle 0 is not one of the mesh");
    write_bytes(equal.files[0], forge(good, {}, [&](std::string& bin) {
                  const std::size_t head = parse_glb(as_byte_span(good), "f").head.size();
                  const float far = 1e4F;
                  std::memcpy(bin.data() + section_offset(good, "source vertices") - head, &far, sizeof far);
                }));
    expect_failure(cache.load(equal.files[0]), equal.files[0].string() + ": source: reaches beyond the cages");
    // Nor this, whose tree has to be built: then it is another size that is given back.
    write_bytes(equal.files[0], forge(
                                    good,
                                    [](nlohmann::json& d) {
                                      auto& sections = d["extensions"]["ENCAGE_cages"]["sections"];
                                      for (std::size_t i = 0; i < sections.size(); ++i) {
                                        if (sections[i]["name"] == "source boxes") sections.erase(i);
                                      }
                                    },
                                    [&](std::string& bin) {
                                      const std::size_t head = parse_glb(as_byte_span(good), "f").head.size();
                                      const float far = 1e4F;
                                      std::memcpy(bin.data() + section_offset(good, "source vertices") - head, &far,
                                                  sizeof far);
                                    }));
    {
      const ShapePtr kept = cache.load(std::string(ENCAGE_TEST_DATA) + "/asset_v1_boxes.glb");
      expect_failure(cache.load(equal.files[0]), equal.files[0].string() + ": source: reaches beyond the cages");
      EXPECT_NO_THROW(FineLease{*kept});
    }
    EXPECT_EQ(cache.statistics().resident_bytes, 0);
    write_bytes(equal.files[0], good);
  }
}

TEST(ShapeCaches, MappedShapesOutliveTheirFilesNames) {
  const EqualFiles equal(1);
  ShapeCache cache({plenty});
  const ShapePtr shape = cache.load(equal.files[0]), twin = load_shape(equal.files[0]);
  std::filesystem::remove(equal.files[0]);
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  EXPECT_EQ(first_contact(*shape, rest, *shape, rest)->vertices, first_contact(*twin, rest, *twin, rest)->vertices);
}

TEST(ShapeCaches, CopiesNoticeWhatBecomesOfTheirFiles) {
  const EqualFiles equal(1);
  const std::filesystem::path& file = equal.files[0];
  const std::string good = read_bytes(file);
  ShapeCache cache({plenty, LoadMode::copy});
  const ShapePtr shape = cache.load(file);
  FineLease lease(*shape);
  std::filesystem::remove(file);
  EXPECT_NO_THROW(FineLease second(*shape));
  lease = FineLease();
  EXPECT_NO_THROW(FineLease second(*shape));  // still in memory
  cache.clear();
  expect_failure(shape, file.string() + ": cannot open: No such file or directory");
  write_bytes(file, good.substr(0, 3000));
  expect_failure(shape, file.string() + ": cannot read: the file ends after 3000 of its " +
                            std::to_string(good.size()) + " bytes");
  write_bytes(file, damaged(good, "source owned"));
  expect_failure(shape, file.string() + ": section \"source owned\": its hash does not match: the file is damaged");
  write_bytes(file, good);
  EXPECT_NO_THROW(FineLease second(*shape));
  // What is in memory stays as it is.
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  const auto before = answers(*shape, rest, *shape, rest);
  write_bytes(file, std::string(good.size(), 'x'));
  EXPECT_EQ(answers(*shape, rest, *shape, rest), before);
}

TEST(ShapeCaches, RefuseWhatHasNoCages) {
  EXPECT_EQ(error_of([] { ShapeCache({plenty}).load("/nowhere/a.glb"); }),
            "/nowhere/a.glb: cannot open: No such file or directory");
  const TemporaryFile file;
  CageHierarchy cages = sample_hierarchy();
  cages.fine = {};
  write_asset(file.path(), cages);
  ShapeCache cache({1});  // nothing is on demand
  const ShapePtr shape = cache.load(file.path()), plain = load_shape(file.path());
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  EXPECT_EQ(separated(*shape, rest, *shape, rest).stage, separated(*plain, rest, *plain, rest).stage);
}

// ---- Life, threads, allocations ----------------------------------------------

TEST(ShapeCaches, ShapesOutliveTheCacheAndLeaveIt) {
  const EqualFiles equal(3);
  ShapePtr survivor;
  {
    ShapeCache cache({2 * equal.size});
    survivor = cache.load(equal.files[0]);
    ShapePtr other = cache.load(equal.files[1]);
    for (const ShapePtr& shape : {survivor, other}) EXPECT_NO_THROW(FineLease lease(*shape));
    EXPECT_EQ(cache.statistics().resident_meshes, 2);
    other.reset();
    EXPECT_EQ(cache.statistics().resident_meshes, 1);
    EXPECT_EQ(cache.statistics().resident_bytes, equal.size);
    cache.clear();
  }
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(first_contact(*survivor, rest, *survivor, rest).has_value());
}

TEST(ShapeCaches, AnswersAreTheSameForManyThreads) {
  const StoredSamples stored;
  const std::vector<Question> asked = questions(stored.files.size(), 120);
  for (const ShapeCacheOptions& options : both_modes) {
    ShapeCache cache({stored.room_for_a_pair(), options.mode});
    const std::vector<ShapePtr> shapes = load_all(cache, stored.files);
    std::vector<std::vector<double>> expected;
    for (const Question& q : asked) expected.push_back(answers(shapes, q));
    const auto work = [&](std::size_t first) {
      for (std::size_t i = 0; i < asked.size(); ++i) {
        const std::size_t n = (first + i) % asked.size();
        EXPECT_EQ(answers(shapes, asked[n]), expected[n]);
      }
    };
    {
      std::vector<std::jthread> threads;
      for (std::size_t t = 0; t < 4; ++t) threads.emplace_back(work, 31 * t);
      for (int i = 0; i < 200; ++i) {
        cache.clear();
        EXPECT_GE(cache.statistics().resident_bytes, 0);
        std::this_thread::yield();
      }
    }
    EXPECT_LE(cache.statistics().resident_bytes, stored.room_for_a_pair());
    EXPECT_LE(cache.statistics().peak_bytes, 4 * stored.room_for_a_pair());
    cache.clear();
    EXPECT_EQ(cache.statistics().resident_bytes, 0);
  }
}

TEST(ShapeCaches, CallbacksMayAsk) {
  const EqualFiles equal(4);
  ShapeCache cache({2 * equal.size, LoadMode::copy});
  const std::vector<ShapePtr> shapes = load_all(cache, equal.files);
  const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
  int outer = 0;
  for_each_triangle_pair(*shapes[0], rest, *shapes[1], rest, 0, [&](TrianglePair) {
    EXPECT_TRUE(first_contact(*shapes[2], rest, *shapes[3], rest).has_value());
    return ++outer < 10;
  });
  EXPECT_EQ(outer, 10);
  EXPECT_EQ(cache.statistics().peak_bytes, 4 * equal.size);
  EXPECT_LE(cache.statistics().resident_bytes, 2 * equal.size);
}

TEST(ShapeCaches, ResidentMeshesAreAskedWithoutAllocations) {
  const EqualFiles equal(2);
  for (const ShapeCacheOptions& options : both_modes) {
    ShapeCache cache(options);
    const std::vector<ShapePtr> shapes = load_all(cache, equal.files);
    const Motion rest = Motion::resting(Eigen::Isometry3d::Identity());
    int found = 0;
    const auto ask = [&] {
      found += separated(*shapes[0], rest, *shapes[1], rest).separated ? 0 : 1;
      for_each_triangle_pair(*shapes[0], rest, *shapes[1], rest, 0, [&](TrianglePair) { return ++found > 0; });
      found += first_contact(*shapes[0], rest, *shapes[1], rest).has_value() ? 1 : 0;
      found += separated(*shapes[0], rest, HalfSpace{.offset = 1000}).separated ? 0 : 1;
    };
    ask();
    const long before = allocations;
    ask();
    EXPECT_EQ(allocations, before);
    EXPECT_GT(found, 8);
  }
}

}  // namespace
}  // namespace encage::test
