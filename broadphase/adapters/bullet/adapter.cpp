// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/pair_proof.h"

#include <encage/bullet.h>
#include <encage/primitives.h>

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <new>
#include <unordered_map>
#include <utility>

namespace encage {
namespace {

constexpr int types = MAX_BROADPHASE_COLLISION_TYPES;
using CreateTable = std::array<std::array<btCollisionAlgorithmCreateFunc*, types>, types>;

/// Reads the registered function, for which Bullet has a setter only. The member is protected, so a derived class names
/// it.
struct Registered : btCollisionDispatcher {
  static btCollisionAlgorithmCreateFunc* at(const btCollisionDispatcher& dispatcher, int type0, int type1) {
    return (dispatcher.*(&Registered::m_doubleDispatchContactPoints))[type0][type1];
  }
};

/// Calls f(type0, type1) for every pair of types with a GImpact shape.
template <class F>
void for_gimpact_types(F&& f) {
  for (int type = 0; type < types; ++type) {
    f(GIMPACT_SHAPE_PROXYTYPE, type);
    if (type != GIMPACT_SHAPE_PROXYTYPE) f(type, GIMPACT_SHAPE_PROXYTYPE);
  }
}

/// Returns the distance beyond the margins within which an algorithm may make or keep contacts. A point is dropped when
/// it is farther apart than the threshold along the normal or across it, hence at sqrt 2 times the threshold at the
/// latest. GImpact keeps no points, and makes none without overlap: 0.
double contact_distance(const btCollisionShape& a, const btCollisionShape& b, const btManifoldArray& manifolds,
                        const btManifoldResult& result) {
  const btScalar all = gContactBreakingThreshold;
  btScalar threshold = std::max(all, std::min(a.getContactBreakingThreshold(all), b.getContactBreakingThreshold(all)));
  for (int m = 0; m < manifolds.size(); ++m) {
    threshold = std::max(threshold, manifolds[m]->getContactBreakingThreshold());
  }
  return 1.5 * static_cast<double>(threshold) + static_cast<double>(result.m_closestPointDistanceThreshold);
}

}  // namespace

/// The dispatcher calls this for a new pair; the algorithms of all pairs share it.
class ENCAGE_HIDDEN BulletAdapter::State final : public btCollisionAlgorithmCreateFunc,
                                                 public std::enable_shared_from_this<State> {
 public:
  State(btCollisionDispatcher& dispatcher, BulletContacts contacts) : dispatcher_(dispatcher), contacts_(contacts) {
    for_gimpact_types([&](int i, int j) {
      inner_[i][j] = Registered::at(dispatcher_, i, j);
      dispatcher_.registerCollisionCreateFunc(i, j, this);
    });
  }

  /// Forwards every later call to Bullet's own functions.
  void uninstall() {
    for_gimpact_types([&](int i, int j) {
      if (Registered::at(dispatcher_, i, j) == this) dispatcher_.registerCollisionCreateFunc(i, j, inner_[i][j]);
    });
    meshes.clear();
  }

  btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                 const btCollisionObjectWrapper* a,
                                                 const btCollisionObjectWrapper* b) override;

  btCollisionAlgorithm* create_inner(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper& a,
                                     const btCollisionObjectWrapper& b) const {
    return inner_[a.getCollisionShape()->getShapeType()][b.getCollisionShape()->getShapeType()]
        ->CreateCollisionAlgorithm(info, &a, &b);
  }

  /// True only if Bullet has no contact between the two shapes.
  bool rejects(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, const btManifoldArray& manifolds,
               const btManifoldResult& result, bool gimpact) noexcept {
    const bullet::AttachedMesh* const mesh_a = find(*a.getCollisionShape());
    const bullet::AttachedMesh* const mesh_b = find(*b.getCollisionShape());
    const btStaticPlaneShape* const plane_a = plane(*a.getCollisionShape());
    const btStaticPlaneShape* const plane_b = plane(*b.getCollisionShape());
    if (!(mesh_a && (mesh_b || plane_b)) && !(mesh_b && plane_a)) return false;
    const double extra =
        gimpact ? 0 : contact_distance(*a.getCollisionShape(), *b.getCollisionShape(), manifolds, result);
    bool apart = false;
    if (mesh_a && mesh_b) {
      apart = bullet::proven_apart(*mesh_a, a.getWorldTransform(), *mesh_b, b.getWorldTransform(),
                                   {.extra = extra, .false_contacts = contacts_ == BulletContacts::all});
    } else if (mesh_a) {
      apart = bullet::proven_apart(*mesh_a, a.getWorldTransform(), *plane_b, b.getWorldTransform(), extra);
    } else {
      apart = bullet::proven_apart(*mesh_b, b.getWorldTransform(), *plane_a, a.getWorldTransform(), extra);
    }
    asked_.fetch_add(1, std::memory_order_relaxed);
    if (apart) rejected_.fetch_add(1, std::memory_order_relaxed);
    return apart;
  }

  BulletStatistics statistics() const { return {asked_.load(), rejected_.load()}; }

  std::unordered_map<const btCollisionShape*, bullet::AttachedMesh> meshes;

 private:
  const bullet::AttachedMesh* find(const btCollisionShape& shape) const {
    if (shape.getShapeType() != GIMPACT_SHAPE_PROXYTYPE) return nullptr;
    const auto found = meshes.find(&shape);
    if (found == meshes.end()) return nullptr;
    return bullet::still_holds(found->second.mesh, static_cast<const btGImpactMeshShape&>(shape)) ? &found->second
                                                                                                  : nullptr;
  }

  static const btStaticPlaneShape* plane(const btCollisionShape& shape) {
    return shape.getShapeType() == STATIC_PLANE_PROXYTYPE ? static_cast<const btStaticPlaneShape*>(&shape) : nullptr;
  }

  btCollisionDispatcher& dispatcher_;
  BulletContacts contacts_;
  CreateTable inner_{};
  std::atomic<std::int64_t> asked_ = 0, rejected_ = 0;
};

/// Stands in front of the algorithm of one pair.
class ENCAGE_HIDDEN BulletAdapter::Algorithm final : public btCollisionAlgorithm {
 public:
  Algorithm(std::shared_ptr<State> state, const btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm& inner)
      : btCollisionAlgorithm(info),
        state_(std::move(state)),
        inner_(&inner),
        gimpact_(dynamic_cast<btGImpactCollisionAlgorithm*>(&inner)) {}
  ~Algorithm() override { destroy_inner(); }

  void processCollision(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    btManifoldArray manifolds;
    inner_->getAllContactManifolds(manifolds);
    if (!state_->rejects(*a, *b, manifolds, *result, gimpact_)) {
      inner_->processCollision(a, b, info, result);
    } else if (manifolds.size() > 0) {
      release(*a, *b);
    }
  }

  btScalar calculateTimeOfImpact(btCollisionObject* a, btCollisionObject* b, const btDispatcherInfo& info,
                                 btManifoldResult* result) override {
    return inner_->calculateTimeOfImpact(a, b, info, result);
  }

  void getAllContactManifolds(btManifoldArray& manifolds) override { inner_->getAllContactManifolds(manifolds); }

 private:
  /// An algorithm releases its manifolds when it is destroyed; the next step creates a new one without manifolds.
  void release(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b) {
    destroy_inner();
    btCollisionAlgorithmConstructionInfo info(m_dispatcher, -1);
    info.m_manifold = nullptr;
    inner_ = state_->create_inner(info, a, b);
    assert(inner_);
  }

  void destroy_inner() {
    inner_->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(inner_);
  }

  std::shared_ptr<State> state_;
  btCollisionAlgorithm* inner_;
  bool gimpact_;  // inner_ is Bullet's own
};

btCollisionAlgorithm* BulletAdapter::State::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                     const btCollisionObjectWrapper* a,
                                                                     const btCollisionObjectWrapper* b) {
  // Bullet's pools have elements of one size; its own algorithms fit, so this one must be no larger.
  static_assert(sizeof(Algorithm) <= sizeof(btGImpactCollisionAlgorithm));
  btCollisionAlgorithm* const inner = create_inner(info, *a, *b);
  // The algorithm must not release a manifold that somebody else owns.
  if (!inner || info.m_manifold) return inner;
  return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Algorithm)))
      Algorithm(shared_from_this(), info, *inner);
}

BulletAdapter::BulletAdapter(btCollisionDispatcher& dispatcher, BulletContacts contacts)
    : state_(std::make_shared<State>(dispatcher, contacts)) {}

BulletAdapter::~BulletAdapter() { state_->uninstall(); }

void BulletAdapter::attach(const btGImpactMeshShape& mesh, ShapePtr shape) {
  if (!shape) throw Error("Bullet mesh: the shape to attach is null");
  if (const double radius = convex_radius(*shape); radius > 0) {
    throw Error("Bullet mesh: the shape to attach has a convex radius of " + std::to_string(radius) +
                ", which Bullet's mesh has not: attach a mesh");
  }
  const bullet::GImpactMesh measured = bullet::measure(mesh, *shape);
  state_->meshes.insert_or_assign(&mesh, bullet::AttachedMesh{std::move(shape), measured});
}

bool BulletAdapter::detach(const btGImpactMeshShape& mesh) noexcept { return state_->meshes.erase(&mesh) > 0; }

BulletStatistics BulletAdapter::statistics() const noexcept { return state_->statistics(); }

}  // namespace encage
