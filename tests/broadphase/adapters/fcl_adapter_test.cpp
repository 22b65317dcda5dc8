// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/body.h"
#include "oracles/count_allocations.h"
#include "oracles/meshes.h"
#include "oracles/sampled.h"

#include <encage/fcl.h>

#include <fcl/broadphase/broadphase_bruteforce.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/default_broadphase_callbacks.h>
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <latch>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

using Pose = Eigen::Isometry3d;
using Model = ::fcl::BVHModel<::fcl::OBBRSSd>;
using Object = ::fcl::CollisionObjectd;
using Pairs = std::vector<std::pair<int, int>>;

std::shared_ptr<Model> make_model(const Body& body, double scale = 1) {
  auto model = std::make_shared<Model>();
  std::vector<::fcl::Vector3d> vertices;
  std::vector<::fcl::Triangle> triangles;
  for (std::int64_t v = 0; v < body.mesh().vertices.rows(); ++v) {
    vertices.emplace_back(scale * (body.origin() + body.mesh().vertex(static_cast<std::int32_t>(v))));
  }
  for (std::int64_t t = 0; t < body.mesh().triangles.rows(); ++t) {
    const auto corner = [&](int k) { return static_cast<std::size_t>(body.mesh().triangles(t, k)); };
    triangles.emplace_back(corner(0), corner(1), corner(2));
  }
  model->beginModel();
  model->addSubModel(vertices, triangles);
  model->endModel();
  return model;
}

/// Objects of concave meshes at random positions, with a manager. Their user data are their numbers.
struct Scene {
  std::vector<Body> bodies;
  std::vector<std::shared_ptr<Model>> models;
  FclShapes shapes;
  std::vector<int> numbers;
  std::vector<std::unique_ptr<Object>> objects;
  ::fcl::DynamicAABBTreeCollisionManagerd manager;

  /// `room` is half the width of the cube that contains the centres.
  Scene(int seed, int count, double room, double scale = 1) {
    for (Sample& sample : sample_shapes(0)) {
      if (sample.hierarchy.solid == Solid::closed) bodies.emplace_back(std::move(sample));
    }
    bodies.emplace_back(ring());
    for (const Body& body : bodies) {
      models.push_back(make_model(body, scale));
      shapes.attach(models.back(), body.shape, scale);
    }
    shapes::Random random(seed);
    numbers.resize(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      const auto kind = static_cast<std::size_t>(random.integer(static_cast<int>(models.size())));
      objects.push_back(std::make_unique<Object>(models[kind], random_pose(random, room * scale)));
      numbers[static_cast<std::size_t>(i)] = i;
      objects.back()->setUserData(&numbers[static_cast<std::size_t>(i)]);
      objects.back()->computeAABB();
      manager.registerObject(objects.back().get());
    }
    manager.setup();
  }

  static Sample ring() {
    Sample sample;
    sample.hierarchy.fine = shapes::torus(1, 0.35, 32, 16);
    sample.hierarchy.fine.vertices = sample.hierarchy.fine.vertices.cast<float>().cast<double>().eval();
    sample.hierarchy.levels.push_back({shapes::cube(1.5), {}});
    return sample;
  }
};

int number(const Object* object) { return *static_cast<const int*>(object->getUserData()); }

bool touches(Object* a, Object* b) {
  ::fcl::CollisionResultd result;
  return ::fcl::collide(a, b, ::fcl::CollisionRequestd(), result) > 0;
}

bool collect(Object* a, Object* b, void* data) {
  if (touches(a, b)) static_cast<Pairs*>(data)->emplace_back(std::minmax(number(a), number(b)));
  return false;
}

bool all_pairs(Object* a, Object* b, void* data) {
  static_cast<Pairs*>(data)->emplace_back(std::minmax(number(a), number(b)));
  return false;
}

Pairs sorted(Pairs pairs) {
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

TEST(FclAdapter, FindsTheSameCollidingPairs) {
  std::size_t touching = 0;
  std::int64_t rejected = 0;
  for (const double scale : {1.0, 0.3}) {
    for (int seed = 0; seed < 4; ++seed) {
      Scene scene(seed, 60, 4, scale);
      Pairs expected, got, by_shape;
      scene.manager.collide(&expected, collect);
      FclCollision collision(scene.shapes, collect, &got);
      scene.manager.collide(&collision, FclCollision::callback);
      EXPECT_EQ(sorted(got), sorted(expected)) << seed;
      touching += expected.size();
      rejected += collision.statistics().rejected;
      // The cages alone decide.
      FclCollision cages(scene.shapes, collect, &by_shape, {.cages = CageUse::always, .fine = false});
      scene.manager.collide(&cages, FclCollision::callback);
      EXPECT_EQ(sorted(by_shape), sorted(expected));
      EXPECT_LE(cages.statistics().rejected, collision.statistics().rejected);
      EXPECT_GT(cages.statistics().rejected, 0);
    }
  }
  EXPECT_GT(touching, 20U);
  EXPECT_GT(rejected, 200);
}

TEST(FclAdapter, FindsTheSameMinimumDistance) {
  std::int64_t rejected = 0, asked = 0, by_cages = 0;
  int apart = 0;
  for (const double scale : {1.0, 40.0}) {
    for (int seed = 0; seed < 8; ++seed) {
      Scene scene(seed, 12, 9, scale);
      ::fcl::DefaultDistanceData<double> expected, got, cages_got;
      scene.manager.distance(&expected, ::fcl::DefaultDistanceFunction<double>);
      FclDistance distance(scene.shapes, ::fcl::DefaultDistanceFunction<double>, &got);
      scene.manager.distance(&distance, FclDistance::callback);
      FclDistance cages(scene.shapes, ::fcl::DefaultDistanceFunction<double>, &cages_got, {.fine = false});
      scene.manager.distance(&cages, FclDistance::callback);
      if (expected.result.min_distance <= 0) {
        EXPECT_LE(got.result.min_distance, 0);
        EXPECT_LE(cages_got.result.min_distance, 0);
        continue;
      }
      ++apart;
      EXPECT_NEAR(got.result.min_distance, expected.result.min_distance, 1e-12 * scale);
      EXPECT_NEAR(cages_got.result.min_distance, expected.result.min_distance, 1e-12 * scale);
      asked += distance.statistics().asked;
      rejected += distance.statistics().rejected;
      by_cages += cages.statistics().rejected;
    }
  }
  EXPECT_GT(apart, 4);
  EXPECT_GT(rejected, asked / 2);
  EXPECT_GT(by_cages, 0);
}

TEST(FclAdapter, ARejectedPairDoesNotEndTheSearch) {
  Scene scene(1, 3, 1);
  const std::array<Eigen::Vector3d, 3> places = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(50, 0, 0),
                                                 Eigen::Vector3d(0.01, 0, 0)};
  ::fcl::NaiveCollisionManagerd naive;  // calls back for all pairs whose boxes overlap, in order
  for (std::size_t i = 0; i < 3; ++i) {
    scene.objects[i]->setTranslation(places[i]);
    scene.objects[i]->computeAABB();
    naive.registerObject(scene.objects[i].get());
  }
  int calls = 0;
  FclCollision collision(
      scene.shapes, [](Object*, Object*, void* data) { return ++*static_cast<int*>(data) == 7; }, &calls);
  EXPECT_FALSE(FclCollision::callback(scene.objects[0].get(), scene.objects[1].get(), &collision));
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(collision.statistics().rejected, 1);
  EXPECT_FALSE(FclCollision::callback(scene.objects[0].get(), scene.objects[2].get(), &collision));
  EXPECT_EQ(calls, 1);
  calls = 6;  // the user callback's result reaches the manager
  EXPECT_TRUE(FclCollision::callback(scene.objects[0].get(), scene.objects[2].get(), &collision));
  EXPECT_EQ(collision.statistics().asked, 3);

  ::fcl::DefaultDistanceData<double> nearest;
  FclDistance distance(scene.shapes, ::fcl::DefaultDistanceFunction<double>, &nearest);
  naive.distance(&distance, FclDistance::callback);
  EXPECT_LE(nearest.result.min_distance, 0);
}

TEST(FclAdapter, DistancesNoLessThanTheLeastSoFarAreNotAskedFor) {
  Scene scene(2, 2, 1);
  scene.objects[0]->setTranslation({0, 0, 0});
  scene.objects[1]->setTranslation({10, 0, 0});
  const DistanceResult truth =
      distance(*scene.shapes.body(*scene.objects[0])->shape, scene.shapes.body(*scene.objects[0])->motion,
               *scene.shapes.body(*scene.objects[1])->shape, scene.shapes.body(*scene.objects[1])->motion);
  ASSERT_GT(truth.lower, 1);
  int calls = 0;
  FclDistance query(
      scene.shapes, [](Object*, Object*, void* data, double&) { return ++*static_cast<int*>(data) < 0; }, &calls);
  const auto asks = [&](double least) {
    const int before = calls;
    EXPECT_FALSE(FclDistance::callback(scene.objects[0].get(), scene.objects[1].get(), &query, least));
    return calls > before;
  };
  EXPECT_FALSE(asks(truth.lower / 2));
  EXPECT_FALSE(asks(truth.lower));
  EXPECT_TRUE(asks(truth.upper * (1 + 1e-9)));
  EXPECT_TRUE(asks(std::numeric_limits<double>::max()));
  EXPECT_TRUE(asks(0));
  EXPECT_TRUE(asks(-1));
}

// Pairs that penetrate have no distance that is no less than a positive one, and all pairs reach the callback once the
// least one so far is not positive.
TEST(FclAdapter, SignedDistancesAreThoseOfFcl) {
  int deep = 0, apart = 0;
  std::int64_t rejected = 0;
  for (int seed = 20; seed < 32; ++seed) {
    Scene scene(seed, 14, seed % 2 == 0 ? 4 : 8);
    ::fcl::DefaultDistanceData<double> expected, got;
    expected.request.enable_signed_distance = got.request.enable_signed_distance = true;
    scene.manager.distance(&expected, ::fcl::DefaultDistanceFunction<double>);
    FclDistance distance(scene.shapes, ::fcl::DefaultDistanceFunction<double>, &got);
    scene.manager.distance(&distance, FclDistance::callback);
    if (expected.result.min_distance <= 0) {
      ++deep;
      EXPECT_EQ(got.result.min_distance, expected.result.min_distance) << seed;
    } else {
      ++apart;
      EXPECT_NEAR(got.result.min_distance, expected.result.min_distance, 1e-12) << seed;
    }
    rejected += distance.statistics().rejected;

    // Every pair that is nearer than a given distance, however deep.
    for (const double least : {1e-9, 0.3, 0.0, -0.1}) {
      Pairs reached;
      FclDistance all(
          scene.shapes,
          [](Object* a, Object* b, void* data, double&) {
            static_cast<Pairs*>(data)->emplace_back(number(a), number(b));
            return false;
          },
          &reached);
      std::size_t asked = 0;
      for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        for (std::size_t j = i + 1; j < scene.objects.size(); ++j) {
          Object *a = scene.objects[i].get(), *b = scene.objects[j].get();
          double bound = least;
          FclDistance::callback(a, b, &all, bound);
          ++asked;
          ::fcl::DistanceResultd result;
          ::fcl::DistanceRequestd request;
          request.enable_signed_distance = true;
          if (least > 0 && ::fcl::distance(a, b, request, result) < least) {
            EXPECT_TRUE(!reached.empty() && reached.back() == std::pair(number(a), number(b)))
                << "distance " << result.min_distance << ", least " << least;
          }
        }
      }
      if (least <= 0) {
        EXPECT_EQ(reached.size(), asked);
      } else {
        EXPECT_LT(reached.size(), asked);
      }
    }
  }
  EXPECT_GT(deep, 3);
  EXPECT_GT(apart, 1);
  EXPECT_GT(rejected, 0);
}

TEST(FclAdapter, MarginsKeepPairsThatAreNear) {
  Scene scene(3, 40, 5);
  Pairs contacts, near;
  FclCollision plain(scene.shapes, all_pairs, &contacts), wide(scene.shapes, all_pairs, &near, {.margin = 0.5});
  scene.manager.collide(&plain, FclCollision::callback);
  scene.manager.collide(&wide, FclCollision::callback);
  EXPECT_GT(near.size(), contacts.size());
}

TEST(FclAdapter, WhatIsNotAttachedReachesTheCallback) {
  Scene scene(4, 2, 1);
  const auto box = std::make_shared<::fcl::Boxd>(1, 1, 1);
  Object other(box);
  other.setTranslation({100, 0, 0});
  int mark = 5;
  other.setUserData(&mark);
  Pairs pairs;
  FclCollision collision(scene.shapes, all_pairs, &pairs);
  Object* first = scene.objects[0].get();
  FclCollision::callback(first, &other, &collision);
  EXPECT_EQ(pairs, (Pairs{{0, 5}}));
  EXPECT_EQ(collision.statistics().asked, 0);
  EXPECT_FALSE(scene.shapes.body(other));
  EXPECT_EQ(number(first), 0) << "user data stay the user's";
  scene.objects[1]->setTranslation({100, 0, 0});
  FclCollision::callback(first, scene.objects[1].get(), &collision);
  EXPECT_EQ(pairs.size(), 1U);
  scene.shapes.detach(first->collisionGeometry().get());
  FclCollision::callback(first, scene.objects[1].get(), &collision);
  EXPECT_EQ(pairs.size(), 2U);
}

TEST(FclAdapter, PosesThatAreNotRigidReachTheCallback) {
  Scene scene(5, 2, 1);
  Pose far = Pose::Identity();
  far.translation().x() = 30;
  far.linear() *= 1 + 1e-6;
  scene.objects[0]->setTransform(Pose::Identity());
  scene.objects[1]->setTransform(far);
  Pairs pairs;
  FclCollision collision(scene.shapes, all_pairs, &pairs);
  FclCollision::callback(scene.objects[0].get(), scene.objects[1].get(), &collision);
  EXPECT_EQ(pairs.size(), 1U);
}

TEST(FclAdapter, RefusesWhatCannotBeTheBody) {
  Scene scene(6, 2, 1);
  FclShapes& shapes = scene.shapes;
  const auto before = shapes.body(*scene.objects[0]);
  ASSERT_TRUE(before);
  const auto geometry = scene.models[0];
  const ShapePtr shape = scene.bodies[0].shape;
  const auto message = [&](const auto& attach) -> std::string {
    try {
      attach();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([&] { shapes.attach(nullptr, shape); }), "FCL adapter: no geometry");
  EXPECT_EQ(message([&] { shapes.attach(geometry, nullptr); }), "FCL adapter: no shape");
  EXPECT_NE(message([&] { shapes.attach(geometry, shape, 0); }).find("the scale is 0.0"), std::string::npos);
  // One mesh has the wrong unit, one model is empty.
  EXPECT_NE(message([&] { shapes.attach(geometry, shape, 0.5); }).find("bounding box"), std::string::npos);
  EXPECT_NE(message([&] { shapes.attach(std::make_shared<Model>(), shape); }).find("bounding box"), std::string::npos);
  EXPECT_EQ(shapes.body(*scene.objects[0])->shape, before->shape);
  EXPECT_NO_THROW(shapes.attach(geometry, shape));
}

TEST(FclAdapter, WhatTheUsersCallbackThrowsPasses) {
  Scene scene(7, 12, 1);
  FclCollision collision(
      scene.shapes, [](Object*, Object*, void*) -> bool { throw std::runtime_error("enough"); }, nullptr);
  EXPECT_THROW(scene.manager.collide(&collision, FclCollision::callback), std::runtime_error);
}

TEST(FclAdapter, IsReEntrantAndDoesNotAllocate) {
  Scene scene(8, 40, 4);
  const auto walk = [&](Pairs& kept) {
    FclCollision collision(scene.shapes, all_pairs, &kept);
    FclDistance distance(
        scene.shapes,
        [](Object* a, Object* b, void* data, double&) {
          static_cast<Pairs*>(data)->emplace_back(number(b), number(a));
          return false;
        },
        &kept);
    for (const auto& a : scene.objects) {
      for (const auto& b : scene.objects) {
        if (number(a.get()) >= number(b.get())) continue;
        FclCollision::callback(a.get(), b.get(), &collision);
        double least = 0.25;
        FclDistance::callback(a.get(), b.get(), &distance, least);
      }
    }
  };
  Pairs expected;
  expected.reserve(4000);
  const long before = allocations;
  walk(expected);
  EXPECT_EQ(allocations, before);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_LT(expected.size(), 1000U);
  std::array<Pairs, 4> got;
  {
    std::latch start(4);
    std::vector<std::jthread> threads;
    for (Pairs& kept : got) {
      threads.emplace_back([&] {
        start.arrive_and_wait();
        walk(kept);
      });
    }
  }
  for (const Pairs& kept : got) EXPECT_EQ(kept, expected);
}

}  // namespace
}  // namespace encage::test
