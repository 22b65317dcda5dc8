// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/adapters/bullet/mesh_partner.h"
#include "broadphase/adapters/bullet/mesh_points.h"

#include <encage/bullet_mesh.h>
#include <encage/manifold.h>

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btConvexConvexAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

namespace encage {
namespace {

constexpr int shape_types = MAX_BROADPHASE_COLLISION_TYPES;
using CreateFunctions = std::array<std::array<btCollisionAlgorithmCreateFunc*, shape_types>, shape_types>;

constexpr int most_manifold_points = 64;
/// Part of the smaller body's radius within which a point continues one of another feature.
constexpr double nearness = 0.03;
/// Radians.
constexpr double largest_turn = 2;

/// Reads registered functions, for which Bullet has setters only. The members are protected, so a derived class names
/// them.
struct MeshDispatcher : btCollisionDispatcher {
  static btCollisionAlgorithmCreateFunc* contact_function(const btCollisionDispatcher& dispatcher, int i, int j) {
    return (dispatcher.*(&MeshDispatcher::m_doubleDispatchContactPoints))[i][j];
  }
  static btCollisionAlgorithmCreateFunc* closest_function(const btCollisionDispatcher& dispatcher, int i, int j) {
    return (dispatcher.*(&MeshDispatcher::m_doubleDispatchClosestPoints))[i][j];
  }
};

/// Calls f(i, j) for every pair of types of which one is the mesh's and the other one known.
template <class F>
void for_mesh_types(F&& f) {
  constexpr int mesh = CUSTOM_CONCAVE_SHAPE_TYPE;
  f(mesh, mesh);
  for (int type = 0; type < shape_types; ++type) {
    if (type != STATIC_PLANE_PROXYTYPE && !bullet::is_partner_type(type)) continue;
    f(mesh, type);
    f(type, mesh);
  }
}

/// The type is anybody's, e.g. also that of Bullet's signed distance fields.
const BulletMeshShape* as_mesh(const btCollisionShape& shape) {
  if (shape.getShapeType() != CUSTOM_CONCAVE_SHAPE_TYPE) return nullptr;
  return dynamic_cast<const BulletMeshShape*>(&shape);
}

bool is_known(const btCollisionShape& shape) {
  return as_mesh(shape) != nullptr || shape.getShapeType() == STATIC_PLANE_PROXYTYPE ||
         bullet::is_partner_type(shape.getShapeType());
}

/// One of the two shapes of a pair in this step.
struct Side {
  ShapePtr shape;  ///< null for a plane, and for a mesh without triangles
  bool is_plane = false;
  HalfSpace plane;
  Motion motion;
  double radius = 0;  ///< that rounds the shape
  double reach = 0;   ///< largest distance of a point from the shape's origin

  bool same_shape(const Side& other) const { return shape == other.shape && is_plane == other.is_plane; }
  bool same_place(const Side& other) const {
    return same_shape(other) && radius == other.radius && plane.offset == other.plane.offset &&
           plane.normal == other.plane.normal && motion.scale == other.motion.scale &&
           motion.start.matrix() == other.motion.start.matrix() && motion.end.matrix() == other.motion.end.matrix();
  }
};

HalfSpace half_space(const btStaticPlaneShape& plane, const btTransform& at) {
  const Eigen::Isometry3d pose = bullet::to_isometry(at);
  const Eigen::Vector3d local = bullet::to_eigen(plane.getPlaneNormal());
  const Eigen::Vector3d normal = (pose.linear() * local).normalized();
  return {normal, normal.dot(pose * (static_cast<double>(plane.getPlaneConstant()) * local))};
}

/// How a body moves at the start of a step, the forces on it during the step included.
struct Velocity {
  Eigen::Vector3d linear, angular;

  Velocity(const btCollisionObject& object, double dt) {
    const btRigidBody* const body = btRigidBody::upcast(&object);
    if (body == nullptr) {
      linear = bullet::to_eigen(object.getInterpolationLinearVelocity());
      angular = bullet::to_eigen(object.getInterpolationAngularVelocity());
      return;
    }
    const auto inverse_mass = static_cast<double>(body->getInvMass());
    linear = bullet::to_eigen(body->getLinearVelocity()) + dt * inverse_mass * bullet::to_eigen(body->getTotalForce());
    angular = bullet::to_eigen(body->getAngularVelocity());
  }
};

/// Bounds how far surfaces of the two may approach each other during the step, where they are near each other.
double approach(const btCollisionObjectWrapper& a, const Side& side_a, const btCollisionObjectWrapper& b,
                const Side& side_b, double dt) {
  if (!(dt > 0)) return 0;
  const Velocity v_a(*a.getCollisionObject(), dt), v_b(*b.getCollisionObject(), dt);
  const auto turning = [](const Velocity& v, const btCollisionObjectWrapper& own, const Side& side,
                          const btCollisionObjectWrapper& other, const Side& other_side) {
    const btVector3& centre = own.getCollisionObject()->getWorldTransform().getOrigin();
    const auto distance = [&](const btCollisionObjectWrapper& w) {
      return static_cast<double>((w.getWorldTransform().getOrigin() - centre).length());
    };
    double lever = std::numeric_limits<double>::infinity();
    if (!side.is_plane) lever = distance(own) + side.reach;
    if (!other_side.is_plane) lever = std::min(lever, distance(other) + other_side.reach);
    const double speed = v.angular.norm();
    return speed > 0 ? speed * lever : 0;
  };
  return dt *
         ((v_a.linear - v_b.linear).norm() + turning(v_a, a, side_a, b, side_b) + turning(v_b, b, side_b, a, side_a));
}

/// Returns the pose to which the velocity leads a shape within `dt`. Bodies turn about their origins.
Eigen::Isometry3d moved(const Eigen::Isometry3d& start, const btCollisionObject& object, double dt) {
  const Velocity v(object, dt);
  const double angle = v.angular.norm() * dt;
  const Eigen::Vector3d centre = bullet::to_eigen(object.getWorldTransform().getOrigin());
  Eigen::Isometry3d end = start;
  if (angle > 0) {
    // Queries accept less than half a turn.
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(std::min(angle, largest_turn), v.angular.normalized()).toRotationMatrix();
    end.linear() = turn * start.linear();
    end.translation() = centre + turn * (start.translation() - centre);
  }
  end.translation() += dt * v.linear;
  return end;
}

/// The memory of one pair of shapes.
struct MeshPair {
  ManifoldCache cache;
  bullet::PairManifolds manifolds;
  std::vector<ManifoldPoint> points;  ///< room for all
  std::size_t count = 0;              ///< of points of the last query
  std::array<Side, 2> last;           ///< what that query was about
  double margin = -1;                 ///< of that query; negative if there was none
  /// Shapes that were converted, and how.
  std::array<std::shared_ptr<const bullet::Partner>, 2> partners;
  std::array<const btCollisionShape*, 2> partner_of{};
  std::uint64_t forgotten = 0;

  void begin(btDispatcher& dispatcher, int most_points) {
    manifolds.begin(dispatcher, most_points);
    points.resize(static_cast<std::size_t>(most_points));
  }

  void end() {
    manifolds.release();
    forget_query();
    last = {};
    partners = {};
    partner_of = {};
  }

  void forget_query() {
    cache.clear();
    count = 0;
    margin = -1;
  }
};

void check_range(const char* name, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw Error("Bullet mesh contacts: " + std::string(name) + " is " + std::to_string(value) + ", it has to be " +
              std::to_string(least) + " to " + std::to_string(most));
}

}  // namespace

/// Holds what the algorithms of all pairs share.
class ENCAGE_HIDDEN BulletMeshContacts::State : public std::enable_shared_from_this<State> {
 public:
  State(btCollisionDispatcher& dispatcher, const BulletMeshOptions& options)
      : options_(options),
        dispatcher_(dispatcher),
        contact_(*this, &State::former_contact_),
        closest_(*this, &State::former_closest_) {
    for_mesh_types([&](int i, int j) {
      former_contact_[i][j] = MeshDispatcher::contact_function(dispatcher_, i, j);
      former_closest_[i][j] = MeshDispatcher::closest_function(dispatcher_, i, j);
      dispatcher_.registerCollisionCreateFunc(i, j, &contact_);
      dispatcher_.registerClosestPointsCreateFunc(i, j, &closest_);
    });
  }

  /// Forwards every later call to the former functions.
  void uninstall() {
    for_mesh_types([&](int i, int j) {
      if (MeshDispatcher::contact_function(dispatcher_, i, j) == &contact_) {
        dispatcher_.registerCollisionCreateFunc(i, j, former_contact_[i][j]);
      }
      if (MeshDispatcher::closest_function(dispatcher_, i, j) == &closest_) {
        dispatcher_.registerClosestPointsCreateFunc(i, j, former_closest_[i][j]);
      }
    });
  }

  bool forget(const btCollisionShape& shape) noexcept {
    forgotten_.fetch_add(1);
    return partners_.forget(shape);
  }

  void process(MeshPair& pair, btPersistentManifold* shared, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, const btDispatcherInfo& info, btManifoldResult& result);

  // Pairs come and go; those that end leave their memory to others.
  std::unique_ptr<MeshPair> take_pair() {
    const std::scoped_lock lock(mutex_);
    if (idle_.empty()) return std::make_unique<MeshPair>();
    std::unique_ptr<MeshPair> pair = std::move(idle_.back());
    idle_.pop_back();
    return pair;
  }
  void give_pair(std::unique_ptr<MeshPair> pair) {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(std::move(pair));
  }

  const BulletMeshOptions& options() const { return options_; }

 private:
  /// The dispatcher calls this for a new pair.
  class Create final : public btCollisionAlgorithmCreateFunc {
   public:
    Create(State& state, CreateFunctions State::*former) : state_(state), former_(former) {}
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* a,
                                                   const btCollisionObjectWrapper* b) override;

   private:
    State& state_;
    CreateFunctions State::*former_;
  };

  Side side(MeshPair& pair, std::size_t index, const btCollisionObjectWrapper& wrapper);
  void query(MeshPair& pair, const std::array<Side, 2>& sides, double margin) const;

  BulletMeshOptions options_;
  btCollisionDispatcher& dispatcher_;
  CreateFunctions former_contact_{}, former_closest_{};
  Create contact_, closest_;
  bullet::Partners partners_;
  std::atomic<std::uint64_t> forgotten_ = 0;  // how often shapes were
  std::mutex mutex_;
  std::vector<std::unique_ptr<MeshPair>> idle_;
};

/// The algorithm of one pair.
class ENCAGE_HIDDEN BulletMeshContacts::Algorithm final : public btCollisionAlgorithm {
 public:
  Algorithm(std::shared_ptr<State> state, const btCollisionAlgorithmConstructionInfo& info)
      : btCollisionAlgorithm(info), state_(std::move(state)), pair_(state_->take_pair()), shared_(info.m_manifold) {
    pair_->begin(*m_dispatcher, state_->options().most_points);
  }
  ~Algorithm() override {
    pair_->end();
    state_->give_pair(std::move(pair_));
  }

  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    state_->process(*pair_, shared_, *a, *b, info, *result);
  }

  btScalar calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                 btManifoldResult*) override {
    return 1;
  }

  void getAllContactManifolds(btManifoldArray& manifolds) override {
    if (shared_ != nullptr) manifolds.push_back(shared_);
    for (btPersistentManifold* const manifold : pair_->manifolds.all()) manifolds.push_back(manifold);
  }

 private:
  std::shared_ptr<State> state_;
  std::unique_ptr<MeshPair> pair_;
  btPersistentManifold* shared_;  // somebody else's, for the points of several algorithms; usually null
};

btCollisionAlgorithm* BulletMeshContacts::State::Create::CreateCollisionAlgorithm(
    btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b) {
  // Bullet's pools have elements of one size; its own algorithms fit, so this one must be no larger.
  static_assert(sizeof(Algorithm) <= sizeof(btConvexConvexAlgorithm));
  const btCollisionShape &shape_a = *a->getCollisionShape(), &shape_b = *b->getCollisionShape();
  if ((as_mesh(shape_a) == nullptr && as_mesh(shape_b) == nullptr) || !is_known(shape_a) || !is_known(shape_b)) {
    btCollisionAlgorithmCreateFunc* const former = (state_.*former_)[shape_a.getShapeType()][shape_b.getShapeType()];
    return former->CreateCollisionAlgorithm(info, a, b);
  }
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Algorithm)))
      Algorithm(state_.shared_from_this(), info);
}

Side BulletMeshContacts::State::side(MeshPair& pair, std::size_t index, const btCollisionObjectWrapper& wrapper) {
  const btCollisionShape& shape = *wrapper.getCollisionShape();
  Side side;
  if (const BulletMeshShape* const mesh = as_mesh(shape)) {
    side.shape = mesh->shape();
    side.motion = mesh->motion(wrapper.getWorldTransform());
    side.radius = static_cast<double>(mesh->getMargin());
    side.reach = mesh->radius();
    return side;
  }
  if (shape.getShapeType() == STATIC_PLANE_PROXYTYPE) {
    side.is_plane = true;
    side.plane = half_space(static_cast<const btStaticPlaneShape&>(shape), wrapper.getWorldTransform());
    side.reach = std::numeric_limits<double>::infinity();
    return side;
  }
  std::shared_ptr<const bullet::Partner>& partner = pair.partners[index];
  if (!partner || pair.partner_of[index] != &shape || !(partner->traits == bullet::traits_of(shape))) {
    partner = partners_.get(shape);
    pair.partner_of[index] = &shape;
  }
  side.shape = partner->shape;
  side.motion = Motion::resting(bullet::to_isometry(wrapper.getWorldTransform()));
  side.radius = partner->radius;
  side.reach = partner->reach;
  return side;
}

/// Finds the points of the pair, from the first side to the second one.
void BulletMeshContacts::State::query(MeshPair& pair, const std::array<Side, 2>& sides, double margin) const {
  for (std::size_t i = 0; i < 2; ++i) {
    if (!sides[i].same_shape(pair.last[i])) pair.forget_query();
  }
  pair.last = sides;
  pair.margin = margin;
  pair.count = 0;
  const auto usable = [](const Side& side) { return side.is_plane || (side.shape && is_usable(side.motion)); };
  if (!usable(sides[0]) || !usable(sides[1])) return;
  ManifoldOptions options{.margin = margin,
                          .radius_a = sides[0].radius,
                          .radius_b = sides[1].radius,
                          .most_points = options_.most_points,
                          .most_per_patch = options_.most_per_patch};
  const Side &a = sides[0], &b = sides[1];
  int count = 0;
  if (b.is_plane) {
    count = contact_manifold(*a.shape, a.motion, b.plane, options, pair.cache, pair.points);
  } else if (a.is_plane) {
    std::swap(options.radius_a, options.radius_b);
    count = contact_manifold(*b.shape, b.motion, a.plane, options, pair.cache, pair.points);
    for (ManifoldPoint& point : std::span(pair.points).first(static_cast<std::size_t>(count))) {
      std::swap(point.point_a, point.point_b);
      point.normal = -point.normal;
    }
  } else {
    count = contact_manifold(*a.shape, a.motion, *b.shape, b.motion, options, pair.cache, pair.points);
  }
  pair.count = static_cast<std::size_t>(count);
}

void BulletMeshContacts::State::process(MeshPair& pair, btPersistentManifold* shared, const btCollisionObjectWrapper& a,
                                        const btCollisionObjectWrapper& b, const btDispatcherInfo& info,
                                        btManifoldResult& result) {
  if (const std::uint64_t forgotten = forgotten_.load(); pair.forgotten != forgotten) {
    pair.partners = {};
    pair.forgotten = forgotten;
  }
  std::array<Side, 2> sides = {side(pair, 0, a), side(pair, 1, b)};
  const double smaller = std::min(sides[0].reach, sides[1].reach);
  const auto points = [&] { return std::span<const ManifoldPoint>(pair.points).first(pair.count); };

  // A contact test, or somebody who collects the points of several pairs.
  if (shared != nullptr || typeid(result) != typeid(btManifoldResult)) {
    const btCollisionShape &shape_a = *a.getCollisionShape(), &shape_b = *b.getCollisionShape();
    const btScalar threshold = std::min(shape_a.getContactBreakingThreshold(gContactBreakingThreshold),
                                        shape_b.getContactBreakingThreshold(gContactBreakingThreshold));
    query(pair, sides, static_cast<double>(threshold + result.m_closestPointDistanceThreshold));
    pair.manifolds.forward(points(), a, b, shared, result);
    pair.margin = -1;
    return;
  }
  const auto dt = static_cast<double>(info.m_timeStep);
  const double way = approach(a, sides[0], b, sides[1], dt), most = options_.most_speculation * smaller;
  const double ahead = way > most ? dt * most / way : dt;
  if (way > 0) {
    sides[0].motion.end = moved(sides[0].motion.start, *a.getCollisionObject(), ahead);
    sides[1].motion.end = moved(sides[1].motion.start, *b.getCollisionObject(), ahead);
  }
  const double margin = std::max(options_.skin * smaller, static_cast<double>(result.m_closestPointDistanceThreshold));
  const bool changed = !sides[0].same_place(pair.last[0]) || !sides[1].same_place(pair.last[1]);
  if (changed || margin > pair.margin) query(pair, sides, margin);
  pair.manifolds.fill(points(), a, b, nearness * smaller);
}

BulletMeshContacts::BulletMeshContacts(btCollisionDispatcher& dispatcher, const BulletMeshOptions& options) {
  check_range("skin", options.skin, 0, 1);
  check_range("most_speculation", options.most_speculation, 0, 1000);
  check_range("most_points", options.most_points, 1, most_manifold_points);
  check_range("most_per_patch", options.most_per_patch, 1, most_manifold_points);
  state_ = std::make_shared<State>(dispatcher, options);
}

BulletMeshContacts::~BulletMeshContacts() { state_->uninstall(); }

bool BulletMeshContacts::forget(const btCollisionShape& shape) noexcept { return state_->forget(shape); }

}  // namespace encage
