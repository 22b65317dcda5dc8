// SPDX-License-Identifier: GPL-3.0-or-later
// Queries of a world against the same queries of each body alone.
#include "oracles/count_allocations.h"
#include "oracles/sampled.h"
#include "tests/broadphase/shape/stored_samples.h"
#include "tests/broadphase/world/thread_pool.h"
#include "tests/broadphase/world/twin.h"

#include <encage/shape_cache.h>
#include <encage/world_queries.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace encage::test {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::string name(const WorldObject& object) {
  if (object.body != BodyId::none) return "body " + std::to_string(index(object.body));
  return object.exists() ? "half-space " + std::to_string(index(object.half_space)) : "nothing";
}

bool comes_before(const WorldObject& a, const WorldObject& b) {
  const auto key = [](const WorldObject& o) {
    return o.body != BodyId::none ? std::pair(0, index(o.body)) : std::pair(1, index(o.half_space));
  };
  return key(a) < key(b);
}

/// A world that changes, with the filters of its half-spaces.
class AskedWorld {
 public:
  AskedWorld(unsigned seed, int count, bool with_cache = true) : world({.pose_tolerance = 1e-4}), random_(seed) {
    std::vector<ShapePtr> simple;
    for (const Sample& s : sample_shapes(1e-3)) {
      simple.push_back(make_shape(s.hierarchy));
      simple.push_back(make_shape(without_cages(s).hierarchy));
      simple.push_back(make_shape(without_fine(s).hierarchy));
      simple.push_back(make_shape(s.hierarchy, {.hollow = true}));
    }
    if (with_cache) {
      for (const auto& file : stored().files) simple.push_back(cache.load(file));
    }
    for (const ShapePtr& shape : simple) shapes.push_back(world.add_shape(shape));
    for (int i = 0; i < 8; ++i) {
      std::vector<CompoundPart> parts;
      for (int k = 0; k < 2 + 20 * (i % 3); ++k) {
        parts.push_back({simple[pick(simple.size())], random_pose(random_, 2), random_(0.2, 0.6)});
      }
      shapes.push_back(world.add_shape(make_compound(parts)));
    }
    for (int i = 0; i < count; ++i) add_body();
    for (int i = 0; i < 3; ++i) add_half_space();
  }

  void add_body() {
    BodyOptions o;
    const int kind = random_.integer(6);
    o.kind = kind == 0 ? BodyKind::static_ : kind == 1 ? BodyKind::kinematic : BodyKind::dynamic;
    if (random_.integer(3) == 0) o.scale = random_(0.3, 1.5);
    if (random_.integer(40) == 0) o.scale = std::pow(10, random_(-8, 1));
    if (random_.integer(4) == 0) o.filter = {1u << random_.integer(3), static_cast<std::uint32_t>(random_.integer(8))};
    if (random_.integer(5) == 0) o.margin = random_(0, 0.5);
    o.sensor = random_.integer(5) == 0;
    bodies.push_back(world.add_body(shapes[pick(shapes.size())], pose(), o));
  }
  void add_half_space() {
    const Filter filter{1u << random_.integer(3), random_.integer(2) == 0 ? ~0u : 5u};
    const Vector n = (Vector::UnitZ() + random_.point(0.4)).normalized();
    const HalfSpaceId id = world.add_half_space({n, random_(-14, -4)}, filter);
    filters[id] = filter;
  }

  void change() {
    const std::size_t at = pick(bodies.size());
    const BodyId body = bodies[at];
    const bool rests = world.options(body).kind == BodyKind::static_;
    switch (random_.integer(16)) {
      case 0:
        world.remove_body(body);
        bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(at));
        add_body();
        break;
      case 1: world.set_awake(body, random_.integer(2) == 0); break;
      case 2: world.set_shape(body, shapes[pick(shapes.size())]); break;
      case 3: world.set_deformation(body, random_(0, 0.5)); break;
      case 4: world.set_scale(body, random_(0.3, 1.5)); break;
      case 5: {
        const HalfSpaceId first = world.half_spaces().front();
        world.remove_half_space(first);
        add_half_space();
        break;
      }
      case 6:
      case 7: world.set_pose(body, pose()); break;
      case 8: world.set_shape(shapes[pick(shapes.size())], world.shape(shapes[pick(shapes.size())])); break;
      case 9: {
        const WorldSnapshot before = world.snapshot();
        world.set_pose(body, pose());
        if (random_.integer(2) == 0) world.update_boxes();
        world.restore(before);
        break;
      }
      default: {
        Motion motion = Motion::resting(world.motion(body).end);
        if (!rests) motion = random_motion(random_, motion.start, 1, 4);
        world.set_motion(body, motion);
      }
    }
  }

  /// A point near a body's place, or on one of its vertices.
  Vector place() {
    const BodyId body = bodies[pick(bodies.size())];
    const Vector at = world.motion(body).start.translation();
    return random_.integer(4) == 0 ? at : Vector(at + random_.point(1.5));
  }
  Ray ray() {
    Ray r;
    r.origin = random_.integer(3) == 0 ? place() : random_.point(25);
    r.direction = random_.integer(4) == 0 ? Vector::Unit(random_.integer(3)) * (random_.integer(2) == 0 ? 1 : -1)
                                          : Vector(place() - r.origin);
    if (r.direction.isZero(0)) r.direction = Vector::UnitX();
    if (random_.integer(4) == 0) r.t_max = random_(0, 2);
    if (random_.integer(6) == 0) r.t_min = random_.integer(3) == 0 ? -endless : random_(-1, 1);
    if (random_.integer(4) == 0) r.direction *= random_(0.001, 10);
    return r;
  }
  Pose pose() {
    Pose p = random_pose(random_, 10);
    if (random_.integer(4) == 0) {  // faces that touch
      p.linear().setIdentity();
      for (int k = 0; k < 3; ++k) p.translation()[k] = random_.integer(7) - 3;
    }
    if (random_.integer(4) == 0) p.linear() = p.linear().cast<float>().cast<double>().eval();
    return p;
  }
  WorldQueryOptions options() {
    WorldQueryOptions o;
    if (random_.integer(3) == 0) {
      o.filter = Filter{1u << random_.integer(3), static_cast<std::uint32_t>(1 + random_.integer(7))};
    }
    o.sensors = random_.integer(4) != 0;
    o.half_spaces = random_.integer(4) != 0;
    if (random_.integer(4) == 0) {
      o.accept = [](const WorldObject& object) {
        return object.body == BodyId::none ? index(object.half_space) != 1 : index(object.body) % 3 != 0;
      };
    }
    return o;
  }
  std::size_t pick(std::size_t count) { return static_cast<std::size_t>(random_.integer(static_cast<int>(count))); }
  shapes::Random& random() { return random_; }

  /// Calls visit(object, shape, motion) for the bodies that options admit, in their order.
  template <class Visit>
  void each_body(const WorldQueryOptions& o, Visit&& visit) const {
    for (const BodyId id : world.bodies()) {
      const BodyOptions& options = world.options(id);
      if (admits(o, {.body = id}, options.filter) && (o.sensors || !options.sensor)) {
        visit(WorldObject{.body = id}, *world.shape(id), world.motion(id));
      }
    }
  }
  template <class Visit>
  void each_half_space(const WorldQueryOptions& o, Visit&& visit) const {
    for (const HalfSpaceId id : world.half_spaces()) {
      if (o.half_spaces && admits(o, {.half_space = id}, filters.at(id))) {
        visit(WorldObject{.half_space = id}, world.half_space(id));
      }
    }
  }

  ShapeCache cache{{.budget_bytes = std::int64_t{1} << 24}};
  World world;
  std::vector<ShapeId> shapes;
  std::vector<BodyId> bodies;
  std::map<HalfSpaceId, Filter> filters;

 private:
  static const StoredSamples& stored() {
    static const StoredSamples samples;
    return samples;
  }
  static bool admits(const WorldQueryOptions& o, const WorldObject& object, const Filter& filter) {
    if (o.filter && !((o.filter->category & filter.mask) && (filter.category & o.filter->mask))) return false;
    return !o.accept || o.accept(object);
  }

  shapes::Random random_;
};

/// Where a line meets a plane that it is not nearly parallel to, and 0 else.
Real plane_parameter(const HalfSpace& plane, const Ray& ray) {
  const Point n = plane.normal.cast<Real>();
  const Real slope = n.dot(ray.direction.cast<Real>());
  return (plane.offset - n.dot(ray.origin.cast<Real>())) / slope;
}

/// All that a ray meets, from the queries of single bodies.
std::vector<WorldRayHit> hits_by_brute_force(const AskedWorld& asked, const Ray& ray, const RayOptions& how,
                                             const WorldQueryOptions& options) {
  std::vector<WorldRayHit> all;
  asked.each_body(options, [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    const RayAnswer answer = for_each_hit(shape, motion, ray, how, [&](const RayHit& hit) {
      all.push_back({RayAnswer::hit, object, hit});
      return true;
    });
    if (answer != RayAnswer::unknown) return;
    all.push_back({RayAnswer::unknown, object, {}});
    all.back().hit.t = cast_ray(shape, motion, ray, how).hit.t;
  });
  asked.each_half_space(options, [&](const WorldObject& object, const HalfSpace& plane) {
    const bool back = plane.normal.dot(ray.direction) > 0;
    const auto t = static_cast<double>(plane_parameter(plane, ray));
    if ((back && how.back_faces == BackFaces::ignore) || t < ray.t_min || t > ray.t_max) return;
    all.push_back({RayAnswer::hit, object, {}});
    all.back().hit.t = t;
    all.back().hit.back_face = back;
  });
  return all;
}

void expect_same(const WorldRayHit& found, const WorldRayHit& expected) {
  ASSERT_EQ(found.answer, expected.answer) << name(found.object) << ", not " << name(expected.object);
  ASSERT_EQ(found.object, expected.object) << name(found.object) << ", not " << name(expected.object);
  ASSERT_EQ(found.hit.triangle, expected.hit.triangle);
  ASSERT_EQ(found.hit.back_face, expected.hit.back_face);
  if (found.object.half_space != HalfSpaceId::none) {
    ASSERT_NEAR(found.hit.t, expected.hit.t, 1e-10 * (1 + std::abs(expected.hit.t)));
  } else {
    ASSERT_EQ(found.hit.t, expected.hit.t);
    ASSERT_EQ(found.hit.normal, expected.hit.normal);
  }
}

void compare_rays(AskedWorld& asked, int& hits, int& unknown) {
  const Ray ray = asked.ray();
  const RayOptions how{asked.random().integer(3) == 0 ? BackFaces::ignore : BackFaces::hit};
  const WorldQueryOptions options = asked.options();

  // The first one: an unknown one wins over a hit with the same t.
  WorldRayHit first;
  const auto take = [&](const WorldRayHit& hit) {
    const auto key = [](const WorldRayHit& h) { return std::pair(h.hit.t, h.answer == RayAnswer::unknown ? 0 : 1); };
    if (hit.answer != RayAnswer::miss && (first.answer == RayAnswer::miss || key(hit) < key(first))) first = hit;
  };
  asked.each_body(options, [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    const RayResult result = cast_ray(shape, motion, ray, how);
    take({result.answer, object, result.hit});
  });
  std::vector<WorldRayHit> expected = hits_by_brute_force(asked, ray, how, options);
  for (const WorldRayHit& hit : expected) {
    if (hit.object.half_space != HalfSpaceId::none) take(hit);
  }
  expect_same(cast_ray(asked.world, ray, how, options), first);
  hits += first.answer == RayAnswer::hit;
  unknown += first.answer == RayAnswer::unknown;

  std::vector<WorldRayHit> visited;
  const RayAnswer answer = for_each_hit(asked.world, ray, how, options, [&](const WorldRayHit& hit) {
    visited.push_back(hit);
    return true;
  });
  ASSERT_EQ(visited.size(), expected.size());
  for (std::size_t i = 0; i < visited.size(); ++i) expect_same(visited[i], expected[i]);
  const bool any_unknown = std::any_of(expected.begin(), expected.end(),
                                       [](const WorldRayHit& hit) { return hit.answer == RayAnswer::unknown; });
  EXPECT_EQ(answer, any_unknown ? RayAnswer::unknown : expected.empty() ? RayAnswer::miss : RayAnswer::hit);

  // All, sorted, and as many as there is room for.
  std::stable_sort(visited.begin(), visited.end(), [](const WorldRayHit& a, const WorldRayHit& b) {
    if (a.hit.t != b.hit.t) return a.hit.t < b.hit.t;
    return a.object == b.object ? a.hit.triangle < b.hit.triangle : comes_before(a.object, b.object);
  });
  std::vector<WorldRayHit> sorted(asked.pick(visited.size() + 2));
  const RayHits all = all_hits(asked.world, ray, sorted, how, options);
  EXPECT_EQ(all.answer, answer);
  ASSERT_EQ(all.count, static_cast<std::int64_t>(visited.size()));
  for (std::size_t i = 0; i < std::min(sorted.size(), visited.size()); ++i) {
    expect_same(sorted[i], visited[i]);
    EXPECT_EQ(sorted[i].hit.t, visited[i].hit.t);
  }
}

void compare_nearest(AskedWorld& asked, int& found_ones) {
  const Vector point = asked.random().integer(2) == 0 ? asked.place() : asked.random().point(20);
  const WorldQueryOptions options = asked.options();
  ClosestPointOptions how;
  if (asked.random().integer(2) == 0) how.limit = asked.random()(0.01, 5);
  WorldObject object;
  ClosestPoint best;
  double lower = how.limit, known = how.limit;
  const auto note = [&](const WorldObject& o, const ClosestPoint& found) {
    lower = std::min(lower, found.lower);
    if (found.upper < best.upper) {
      best = found;
      object = o;
    }
  };
  asked.each_body(options, [&](const WorldObject& o, const Shape& shape, const Motion& motion) {
    note(o, closest_point(shape, motion, point, how));
    if (how.limit < endless) known = std::min(known, closest_point(shape, motion, point).lower);
  });
  double plane = endless;  // the nearest one's distance
  asked.each_half_space(options, [&](const WorldObject& o, const HalfSpace& half_space) {
    const Point n = half_space.normal.cast<Real>();
    const Real height = (n.dot(point.cast<Real>()) - half_space.offset) / n.norm();
    ClosestPoint on;
    on.lower = static_cast<double>(std::abs(height));
    if (std::abs(height) < how.limit) {
      on.upper = on.lower;
      on.point = (point.cast<Real>() - height / n.norm() * n).cast<double>();
    }
    plane = std::min(plane, on.lower);
    known = std::min(known, on.lower);
    note(o, on);
  });
  best.lower = std::min(lower, best.upper);
  const WorldClosestPoint found = closest_point(asked.world, point, how, options);
  ASSERT_EQ(found.object, object) << name(found.object) << ", not " << name(object);
  ASSERT_EQ(found.closest.triangle, best.triangle);
  const double rounding = 1e-13 * (point.norm() + 20);
  if (object.half_space != HalfSpaceId::none) {
    EXPECT_NEAR(found.closest.upper, best.upper, 2 * rounding);
    EXPECT_LE((found.closest.point - best.point).norm(), rounding);
  } else {
    ASSERT_EQ(found.closest.upper, best.upper);
    ASSERT_EQ(found.closest.point, best.point);
    ASSERT_EQ(found.closest.feature, best.feature);
  }
  if (how.limit < endless) {
    // What is beyond the limit may bound the distance better than a body that says so.
    ASSERT_GE(found.closest.lower, best.lower - 2 * rounding);
    ASSERT_LE(found.closest.lower, std::min(known, best.upper));
  } else if (plane < endless && plane <= best.lower + 2 * rounding) {
    EXPECT_NEAR(found.closest.lower, best.lower, 2 * rounding);
  } else {
    ASSERT_EQ(found.closest.lower, best.lower);
  }
  found_ones += found.found();
}

Eigen::AlignedBox3d start_box(const Shape& shape, const Motion& motion) {
  return world_box(shape, Motion::resting(motion.start, motion.scale));
}

void compare_holders(AskedWorld& asked, int& holders) {
  const Vector point = asked.place();
  const WorldQueryOptions options = asked.options();
  std::vector<std::pair<std::string, PointSide>> expected, found;
  asked.each_body(options, [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    const PointSide side = contains(shape, motion, point);
    // World boxes are tighter than the boxes in which interiors are unknown.
    if (side != PointSide::outside && start_box(shape, motion).contains(point)) {
      expected.emplace_back(name(object), side);
    }
  });
  asked.each_half_space(options, [&](const WorldObject& object, const HalfSpace& plane) {
    const double height = plane.normal.dot(point) - plane.offset;
    if (height < -1e-9) expected.emplace_back(name(object), PointSide::inside);
  });
  const PointSide answer = for_each_object_at(asked.world, point, options, [&](const WorldObject& o, PointSide side) {
    found.emplace_back(name(o), side);
    return true;
  });
  ASSERT_EQ(found, expected);
  const auto any = [&](PointSide side) {
    return std::any_of(found.begin(), found.end(), [&](const auto& f) { return f.second == side; });
  };
  EXPECT_EQ(answer, any(PointSide::inside)    ? PointSide::inside
                    : any(PointSide::unknown) ? PointSide::unknown
                                              : PointSide::outside);
  holders += static_cast<int>(found.size());
}

/// A volume, the query of one body, and how far it reaches along a direction from below.
struct AskedVolume {
  Volume volume;
  std::vector<Vector> points;
  double radius = 0;

  bool overlaps_body(const Shape& shape, const Motion& motion) const {
    switch (volume.index()) {
      case 0: return overlaps(shape, motion, std::get<Sphere>(volume));
      case 1: return overlaps(shape, motion, std::get<Capsule>(volume));
      case 2: return overlaps(shape, motion, std::get<OrientedBox>(volume));
      case 3: return overlaps(shape, motion, std::get<HalfSpace>(volume));
      default: return overlaps(shape, motion, points, radius);
    }
  }
  bool reaches(const Eigen::AlignedBox3d& box) const {
    if (const auto* plane = std::get_if<HalfSpace>(&volume)) {
      const Vector lowest = (plane->normal.array() > 0).select(box.min(), box.max());
      return plane->normal.dot(lowest) <= plane->offset;
    }
    Eigen::AlignedBox3d own;
    for (const Vector& p : points) own.extend(Vector(p.array() - radius)).extend(Vector(p.array() + radius));
    return own.intersects(box);
  }
  bool overlaps_plane(const HalfSpace& plane) const {
    if (volume.index() == 3) return true;  // none of the planes here are parallel
    double least = endless;
    for (const Vector& p : points) least = std::min(least, plane.normal.dot(p) - plane.offset - radius);
    return least <= 0;
  }
};

AskedVolume random_volume(AskedWorld& asked) {
  shapes::Random& random = asked.random();
  const Vector at = asked.place();
  AskedVolume v;
  v.radius = random.integer(4) == 0 ? 0 : random(0, 2);
  switch (random.integer(5)) {
    case 0:
      v.points = {at};
      v.volume = Sphere{at, v.radius};
      break;
    case 1:
      v.points = {at, at + random.point(5)};
      v.volume = Capsule{v.points[0], v.points[1], v.radius};
      break;
    case 2: {
      OrientedBox box{random_pose(random, 1), Vector(random(0, 3), random(0, 3), random(0, 3))};
      box.pose.translation() = at;
      for (int i = 0; i < 8; ++i) {
        v.points.push_back(box.pose * Vector((i & 1 ? 1 : -1) * box.half[0], (i & 2 ? 1 : -1) * box.half[1],
                                             (i & 4 ? 1 : -1) * box.half[2]));
      }
      v.radius = 0;
      v.volume = box;
      break;
    }
    case 3: {
      const Vector n = random_direction(random);
      v.volume = HalfSpace{n, n.dot(at) - random(0, 8)};
      break;
    }
    default:
      for (int i = random.integer(12); i >= 0; --i) v.points.push_back(at + random.point(2));
      break;
  }
  return v;
}

void compare_volumes(AskedWorld& asked, int& overlapping) {
  AskedVolume v = random_volume(asked);
  if (!v.points.empty() && v.volume.index() == 0 && std::get<Sphere>(v.volume).centre != v.points[0]) {
    v.volume = Hull{v.points, v.radius};
  }
  const WorldQueryOptions options = asked.options();
  std::vector<std::string> expected, found;
  asked.each_body(options, [&](const WorldObject& object, const Shape& shape, const Motion& motion) {
    if (v.overlaps_body(shape, motion) && v.reaches(start_box(shape, motion))) expected.push_back(name(object));
  });
  asked.each_half_space(options, [&](const WorldObject& object, const HalfSpace& plane) {
    if (v.overlaps_plane(plane)) expected.push_back(name(object));
  });
  EXPECT_TRUE(for_each_overlap(asked.world, v.volume, options, [&](const WorldObject& object) {
    found.push_back(name(object));
    return true;
  }));
  ASSERT_EQ(found, expected) << "volume of kind " << v.volume.index();
  ASSERT_EQ(overlaps(asked.world, v.volume, options), !expected.empty());
  overlapping += static_cast<int>(found.size());
}

// The tree is in all states: before the first search, with few and with many changes since, brought up to date.
TEST(WorldQueries, AnswerAsEachBodyAlone) {
  int hits = 0, unknown = 0, nearest = 0, holders = 0, overlapping = 0;
  const char* more = std::getenv("ENCAGE_WORLD_QUERY_SEEDS");
  const unsigned seeds = more != nullptr ? static_cast<unsigned>(std::atoi(more)) : 3;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    AskedWorld asked(seed, seed % 3 == 0 ? 700 : 150);
    for (int step = 0; step < 12; ++step) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", step " + std::to_string(step));
      for (int i = 0; i < 12; ++i) {
        compare_rays(asked, hits, unknown);
        compare_nearest(asked, nearest);
        compare_holders(asked, holders);
        compare_volumes(asked, overlapping);
        if (testing::Test::HasFatalFailure()) return;
        if (step % 2 == 1) asked.change();
        if (step % 6 == 3) asked.world.update_boxes();
      }
      for (int i = 0; i < (step % 4 == 0 ? 60 : 3); ++i) asked.change();
      if (step % 3 == 0) asked.world.find_candidates({}, [](const CandidatePair&) {});
      if (step % 3 == 1) asked.world.update_boxes();
    }
  }
  EXPECT_GT(hits, 60);
  EXPECT_GT(unknown, 30);
  EXPECT_GT(nearest, 200);
  EXPECT_GT(holders, 200);
  EXPECT_GT(overlapping, 1'000);
}

TEST(WorldQueries, MoreBodiesInOnePlaceThanOneBatchHolds) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 1'000; ++i) world.add_body(box, shift(0.0001 * (i * 7 % 1'000)));
  for (int round = 0; round < 2; ++round) {
    std::uint32_t next = 0;
    for_each_overlap(world, Sphere{{0, 0, 0}, 0.5}, {}, [&](const WorldObject& object) {
      EXPECT_EQ(index(object.body), next++);
      return true;
    });
    EXPECT_EQ(next, 1'000u);
    // The first of equal hits, wherever the tree has it.
    const WorldRayHit hit = cast_ray(world, {{0.05, 0.25, -5}, {0, 0, 1}});
    EXPECT_EQ(index(hit.object.body), 0u);
    world.update_boxes();
  }
}

TEST(WorldQueries, VisitorsEndThem) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 10; ++i) world.add_body(box, shift(3 * i));
  world.add_half_space({Vector::UnitX(), -2});
  int calls = 0;
  const Ray ray{{-5, 0.25, 0.5}, {1, 0, 0}};
  EXPECT_EQ(for_each_hit(world, ray, {}, {}, [&](const WorldRayHit&) { return ++calls < 3; }), RayAnswer::hit);
  EXPECT_EQ(calls, 3);
  calls = 0;
  EXPECT_EQ(for_each_object_at(world, {0, 0, 0}, {}, [&](const WorldObject&, PointSide) { return ++calls < 1; }),
            PointSide::inside);
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(for_each_overlap(world, Sphere{{0, 0, 0}, 10}, {}, [&](const WorldObject&) { return ++calls < 3; }));
  EXPECT_EQ(calls, 3);
  const WorldQueryOptions throwing{.accept = [](const WorldObject&) -> bool { throw std::runtime_error("no"); }};
  EXPECT_THROW(cast_ray(world, ray, {}, throwing), std::runtime_error);
  EXPECT_EQ(cast_ray(world, ray).hit.t, 3);
  EXPECT_EQ(cast_ray(world, ray).object.half_space, world.half_spaces().front());
}

// ---- Half-spaces ---------------------------------------------------------

TEST(WorldQueries, RaysMissNoPlane) {
  shapes::Random random(7);
  int hits = 0, misses = 0;
  for (int i = 0; i < 20'000; ++i) {
    World world;
    const Vector n = random.integer(4) == 0 ? Vector(Vector::Unit(random.integer(3))) : random_direction(random);
    const HalfSpace plane{n, random.integer(4) == 0 ? 0 : std::pow(10, random(-6, 6)) * random(-1, 1)};
    world.add_half_space(plane);
    Ray ray;
    ray.origin = random.point(std::pow(10, random(-3, 6)));
    if (random.integer(3) == 0) ray.origin -= (n.dot(ray.origin) - plane.offset) * n;  // on the plane, nearly
    ray.direction = random.integer(5) == 0 ? Vector(Vector::Unit(random.integer(3))) : random_direction(random);
    if (random.integer(3) == 0) ray.direction -= n.dot(ray.direction) * (1 - random(-1e-15, 1e-15)) * n;  // along it
    if (ray.direction.isZero(0)) continue;
    if (random.integer(2) == 0) ray.t_max = std::pow(10, random(-3, 9));
    const WorldRayHit hit = cast_ray(world, ray);
    const Point normal = n.cast<Real>(), direction = ray.direction.cast<Real>();
    const Real slope = normal.dot(direction), height = normal.dot(ray.origin.cast<Real>()) - plane.offset;
    const Real t = slope != 0 ? -height / slope : std::numeric_limits<Real>::infinity();
    // The rounding of long double, and what the query promises.
    const Real scale = ray.origin.norm() + std::abs(plane.offset), fine = 1e-17L * scale;
    const Real rounding = 1e-13L * scale + 1e-14L * std::min<Real>(std::abs(t), 1e30L);
    if (std::abs(slope) > 1e-17L && t >= 0 && t <= ray.t_max) {
      ASSERT_EQ(hit.answer, RayAnswer::hit) << i << ": slope " << slope << ", t " << t;
    }
    if (slope == 0 && std::abs(height) <= fine) {
      ASSERT_EQ(hit.answer, RayAnswer::hit) << i;
    }
    if (hit.answer == RayAnswer::hit) {
      // Somewhere within its rounding the ray is on the plane.
      const Real there = height + slope * hit.hit.t;
      EXPECT_LE(std::abs(there), rounding + 1e-14L * std::abs(Real(hit.hit.t))) << i;
      EXPECT_GE(hit.hit.t, ray.t_min);
      EXPECT_LE(hit.hit.t, ray.t_max);
      EXPECT_EQ(hit.hit.triangle, -1);
      EXPECT_TRUE(hit.object.half_space != HalfSpaceId::none);
      ++hits;
    } else {
      ++misses;
    }
  }
  EXPECT_GT(hits, 5'000);
  EXPECT_GT(misses, 5'000);
}

TEST(WorldQueries, HalfSpacesAreSolid) {
  World world;
  const HalfSpaceId ground = world.add_half_space({Vector::UnitZ(), 1});
  const auto side = [&](const Vector& p) {
    return for_each_object_at(world, p, {}, [](const WorldObject&, PointSide) { return true; });
  };
  EXPECT_EQ(side({3, 4, 0.5}), PointSide::inside);
  EXPECT_EQ(side({3, 4, 1.5}), PointSide::outside);
  EXPECT_EQ(side({3, 4, 1}), PointSide::unknown);
  const WorldClosestPoint below = closest_point(world, {3, 4, -1});
  EXPECT_EQ(below.object.half_space, ground);
  EXPECT_TRUE(below.found());
  EXPECT_LE(below.closest.lower, 2);
  EXPECT_GE(below.closest.upper, 2);
  EXPECT_NEAR(below.closest.upper, 2, 1e-12);
  EXPECT_EQ(below.closest.point, Vector(3, 4, 1));
  EXPECT_FALSE(closest_point(world, {3, 4, -1}, {.limit = 1.5}).found());
  EXPECT_GE(closest_point(world, {3, 4, -1}, {.limit = 1.5}).closest.lower, 1.5 - 1e-12);
  EXPECT_TRUE(overlaps(world, Sphere{{0, 0, 3}, 2}));
  EXPECT_FALSE(overlaps(world, Sphere{{0, 0, 3}, 1.999}));
  EXPECT_TRUE(overlaps(world, Capsule{{0, 0, 3}, {0, 0, 1.5}, 0.5}));
  EXPECT_FALSE(overlaps(world, Capsule{{0, 0, 3}, {0, 0, 1.5}, 0.4}));
  EXPECT_TRUE(overlaps(world, OrientedBox{shift(0, 0, -50), {1, 1, 1}}));
  EXPECT_FALSE(overlaps(world, OrientedBox{shift(0, 0, 5), {1, 1, 1}}));
  EXPECT_TRUE(overlaps(world, HalfSpace{-Vector::UnitZ(), -1}));
  EXPECT_FALSE(overlaps(world, HalfSpace{-Vector::UnitZ(), -1.5}));
  EXPECT_TRUE(overlaps(world, HalfSpace{Vector::UnitX(), -1e9}));
  EXPECT_FALSE(overlaps(world, Hull{}));
  EXPECT_FALSE(overlaps(world, Sphere{{0, 0, 0}, 2}, {.half_spaces = false}));
  EXPECT_EQ(cast_ray(world, {{0, 0, 5}, {1, 0, 0}}).answer, RayAnswer::miss) << "along it";
  EXPECT_EQ(cast_ray(world, {{0, 0, 1}, {1, 0, 0}}).answer, RayAnswer::hit) << "in it";
  const Ray up{{0, 0, -5}, {0, 0, 2}};
  EXPECT_EQ(cast_ray(world, up).hit.t, 3);
  EXPECT_TRUE(cast_ray(world, up).hit.back_face);
  EXPECT_EQ(cast_ray(world, up, {BackFaces::ignore}).answer, RayAnswer::miss);
}

// ---- Bad input -----------------------------------------------------------

TEST(WorldQueries, BadInputProvesNothing) {
  World world;
  const ShapeId box = world.add_shape(sample_shape("box"));
  for (int i = 0; i < 20; ++i) world.add_body(box, shift(100 * i));
  world.add_half_space({Vector::UnitZ(), -50});
  for (int round = 0; round < 2; ++round) {
    for (const Ray& ray : {Ray{{0, 0, nan}, {0, 0, 1}}, Ray{{0, 0, 0}, {0, 0, 0}}, Ray{{0, 0, 0}, {0, endless, 0}},
                           Ray{{0, 0, 1e151}, {0, 0, 1}}, Ray{{0, 0, 0}, {0, 0, 1}, 0.5, nan}}) {
      const WorldRayHit hit = cast_ray(world, ray);
      EXPECT_EQ(hit.answer, RayAnswer::unknown);
      EXPECT_FALSE(hit.object.exists());
      EXPECT_EQ(hit.hit.t, ray.t_min);
      EXPECT_EQ(for_each_hit(world, ray, {}, {}, [](const WorldRayHit&) { return true; }), RayAnswer::unknown);
    }
    EXPECT_EQ(cast_ray(world, {{0, 0, 0}, {0, 0, 1}, 2, 1}).answer, RayAnswer::miss);
    const auto count = [&](const Volume& volume) {
      int all = 0;
      for_each_overlap(world, volume, {}, [&](const WorldObject&) { return ++all > 0; });
      return all;
    };
    const std::vector<Vector> bad_point = {{0, 0, 0}, {nan, 0, 0}};
    EXPECT_EQ(count(Sphere{{0, 0, nan}, 1}), 21);
    EXPECT_EQ(count(Sphere{{0, 0, 0}, -1}), 21);
    EXPECT_EQ(count(Capsule{{0, 0, 0}, {0, 0, 1e151}, 1}), 21);
    EXPECT_EQ(count(OrientedBox{shift(nan), {1, 1, 1}}), 21);
    EXPECT_EQ(count(OrientedBox{shift(0), {1, -1, 1}}), 21);
    EXPECT_EQ(count(HalfSpace{{0, 0, nan}, 1}), 21);
    EXPECT_EQ(count(Hull{bad_point, 0}), 21);
    EXPECT_EQ(count(Hull{{}, -1}), 0);
    for (const Vector& p : {Vector(nan, 0, 0), Vector(0, 1e151, 0)}) {
      EXPECT_FALSE(closest_point(world, p).found());
      EXPECT_EQ(closest_point(world, p).closest.lower, 0);
      int all = 0;
      EXPECT_EQ(for_each_object_at(world, p, {}, [&](const WorldObject&, PointSide) { return ++all > 0; }),
                PointSide::unknown);
      EXPECT_EQ(all, 21);
    }
    EXPECT_FALSE(closest_point(world, {0, 0, 0}, {.limit = 0}).found());
    EXPECT_EQ(closest_point(world, {0, 0, 0}, {.limit = nan}).closest.lower, 0);
    world.update_boxes();
  }
  World empty;
  EXPECT_EQ(cast_ray(empty, {}).answer, RayAnswer::miss);
  EXPECT_EQ(closest_point(empty, {0, 0, 0}).closest.lower, endless);
  EXPECT_FALSE(overlaps(empty, Sphere{}));
}

TEST(WorldQueries, CoordinatesOfAnySize) {
  for (const double size : {1e-30, 1e-9, 1.0, 1e9, 1e30, 1e49}) {
    SCOPED_TRACE(size);
    World world;
    const ShapeId box = world.add_shape(sample_shape("box"));  // corners at +-1
    for (int i = 0; i < 20; ++i) world.add_body(box, shift(4 * size * i), {.scale = size});
    for (int round = 0; round < 2; ++round) {
      const WorldRayHit hit = cast_ray(world, {{-5 * size, 0.25 * size, 0.5 * size}, {1, 0, 0}});
      ASSERT_EQ(hit.answer, RayAnswer::hit);
      EXPECT_EQ(index(hit.object.body), 0u);
      EXPECT_NEAR(hit.hit.t / size, 4, 1e-12);
      const WorldRayHit last = cast_ray(world, {{1e6 * size, 0.25 * size, 0.5 * size}, {-size, 0, 0}});
      ASSERT_EQ(last.answer, RayAnswer::hit);
      EXPECT_EQ(index(last.object.body), 19u);
      const WorldClosestPoint nearest = closest_point(world, {41.5 * size, 0, 0});
      EXPECT_EQ(index(nearest.object.body), 10u);
      EXPECT_NEAR(nearest.closest.upper / size, 0.5, 1e-11);
      std::vector<std::uint32_t> found;
      for_each_overlap(world, Sphere{{20 * size, 0, 0}, 4 * size}, {}, [&](const WorldObject& object) {
        found.push_back(index(object.body));
        return true;
      });
      EXPECT_EQ(found, (std::vector<std::uint32_t>{4, 5, 6}));
      world.update_boxes();
    }
  }
}

// ---- Memory and threads --------------------------------------------------

TEST(WorldQueries, AllocateNothing) {
  AskedWorld asked(11, 300, false);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 20; ++i) {
      const Ray ray = asked.ray();
      const Vector point = asked.place();
      std::array<WorldRayHit, 8> hits;
      const long before = allocations;
      std::int64_t count = cast_ray(asked.world, ray).answer == RayAnswer::hit;
      count += all_hits(asked.world, ray, hits).count;
      count += closest_point(asked.world, point).found();
      for_each_object_at(asked.world, point, {}, [&](const WorldObject&, PointSide) { return ++count > 0; });
      for_each_overlap(asked.world, Sphere{point, 3}, {}, [&](const WorldObject&) { return ++count > 0; });
      count += overlaps(asked.world, HalfSpace{Vector::UnitX(), -5});
      EXPECT_EQ(allocations, before) << count;
    }
    asked.world.update_boxes();
    asked.change();
  }
}

TEST(WorldQueries, OfManyThreadsAtATimeGiveTheSameBits) {
  AskedWorld asked(12, 200);
  for (int i = 0; i < 50; ++i) asked.change();
  std::vector<Ray> rays;
  for (int i = 0; i < 100; ++i) rays.push_back(asked.ray());
  std::vector<WorldRayHit> expected;
  for (const Ray& ray : rays) expected.push_back(cast_ray(asked.world, ray));
  std::array<std::vector<WorldRayHit>, 4> found;
  std::vector<std::thread> threads;
  for (auto& results : found) {
    threads.emplace_back([&asked, &rays, &results] {
      results.resize(rays.size());
      cast_rays(asked.world, rays, results);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& results : found) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
      expect_same(results[i], expected[i]);
      EXPECT_EQ(results[i].hit.t, expected[i].hit.t);
    }
  }
}

TEST(WorldQueries, UpdateOfBoxesChangesNoSearch) {
  ThreadPool pool(3);
  AskedWorld plain(13, 150, false), updated(13, 150, false);
  for (int step = 0; step < 8; ++step) {
    for (int i = 0; i < 30; ++i) {
      plain.change();
      updated.change();
      if (i % 7 == 0) updated.world.update_boxes(step % 2 == 0 ? Executor{} : pool.executor());
    }
    EXPECT_EQ(events(plain.world), events(updated.world)) << step;
  }
  EXPECT_EQ(error_of([&] { updated.world.update_boxes({.threads = 0}); }),
            "update of boxes: the number of threads 0 is not positive");
  updated.world.find_candidates({}, [&](const CandidatePair&) {
    EXPECT_EQ(error_of([&] { updated.world.update_boxes(); }),
              "the world cannot be changed while it visits candidates");
    // Queries may be asked meanwhile.
    EXPECT_NO_THROW(cast_ray(updated.world, {}));
  });
}

}  // namespace
}  // namespace encage::test
