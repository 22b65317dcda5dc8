// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/mesh_points.h"

#include "broadphase/adapters/bullet/convert.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <algorithm>
#include <cassert>
#include <cstddef>

namespace encage::bullet {
namespace {

constexpr int room = MANIFOLD_CACHE_SIZE;  // points in a manifold
constexpr btScalar same_way = 0.9F;        // cosine of normals of points that may continue each other

bool same_bits(const btVector3& a, const btVector3& b) { return a.x() == b.x() && a.y() == b.y() && a.z() == b.z(); }

/// What the two bodies' materials say about a contact, as btManifoldResult combines it.
void combine_materials(btManifoldPoint& point, const btCollisionObject& a, const btCollisionObject& b) {
  point.m_combinedFriction = gCalculateCombinedFrictionCallback(&a, &b);
  point.m_combinedRestitution = gCalculateCombinedRestitutionCallback(&a, &b);
  point.m_combinedRollingFriction = gCalculateCombinedRollingFrictionCallback(&a, &b);
  point.m_combinedSpinningFriction = gCalculateCombinedSpinningFrictionCallback(&a, &b);
  const int flags = a.getCollisionFlags() | b.getCollisionFlags();
  if (flags & btCollisionObject::CF_HAS_CONTACT_STIFFNESS_DAMPING) {
    point.m_combinedContactDamping1 = gCalculateCombinedContactDampingCallback(&a, &b);
    point.m_combinedContactStiffness1 = gCalculateCombinedContactStiffnessCallback(&a, &b);
    point.m_contactPointFlags |= BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
  }
  if (flags & btCollisionObject::CF_HAS_FRICTION_ANCHOR) point.m_contactPointFlags |= BT_CONTACT_FLAG_FRICTION_ANCHOR;
}

btManifoldPoint to_manifold_point(const ManifoldPoint& from, const btCollisionObjectWrapper& a,
                                  const btCollisionObjectWrapper& b) {
  const btCollisionObject &body_a = *a.getCollisionObject(), &body_b = *b.getCollisionObject();
  const btVector3 on_a = to_bullet(from.point_a), on_b = to_bullet(from.point_b), normal = to_bullet(from.normal);
  btManifoldPoint point(body_a.getWorldTransform().invXform(on_a), body_b.getWorldTransform().invXform(on_b), normal,
                        static_cast<btScalar>(from.separation));
  point.m_positionWorldOnA = on_a;
  point.m_positionWorldOnB = on_b;
  point.m_partId0 = a.m_partId;
  point.m_index0 = a.m_index;
  point.m_partId1 = b.m_partId;
  point.m_index1 = b.m_index;
  combine_materials(point, body_a, body_b);
  btPlaneSpace1(normal, point.m_lateralFrictionDir1, point.m_lateralFrictionDir2);
  return point;
}

/// True if the friction of the last step held the point in place, so that its anchor stays where it is.
bool anchored(const btManifoldPoint& fresh, const btManifoldPoint& old) {
  if (!(fresh.m_contactPointFlags & old.m_contactPointFlags & BT_CONTACT_FLAG_FRICTION_ANCHOR)) return false;
  const btScalar most = old.m_combinedFriction * old.m_appliedImpulse;
  return old.m_appliedImpulseLateral1 * old.m_appliedImpulseLateral1 +
             old.m_appliedImpulseLateral2 * old.m_appliedImpulseLateral2 <=
         most * most;
}

void continue_point(btManifoldPoint& fresh, const btManifoldPoint& old, const btCollisionObject& a,
                    const btCollisionObject& b) {
  fresh.m_appliedImpulse = old.m_appliedImpulse;
  fresh.m_prevRHS = old.m_prevRHS;
  fresh.m_appliedImpulseLateral1 = old.m_appliedImpulseLateral1;
  fresh.m_appliedImpulseLateral2 = old.m_appliedImpulseLateral2;
  fresh.m_userPersistentData = old.m_userPersistentData;
  if (!anchored(fresh, old)) return;
  fresh.m_localPointA = old.m_localPointA;
  fresh.m_localPointB = old.m_localPointB;
  fresh.m_positionWorldOnA = a.getWorldTransform() * old.m_localPointA;
  fresh.m_positionWorldOnB = b.getWorldTransform() * old.m_localPointB;
}

bool wants_callback(const btCollisionObject& a, const btCollisionObject& b) {
  return gContactAddedCallback != nullptr &&
         ((a.getCollisionFlags() | b.getCollisionFlags()) & btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
}

}  // namespace

void PairManifolds::begin(btDispatcher& dispatcher, int most_points) {
  assert(manifolds_.empty());
  dispatcher_ = &dispatcher;
  records_.clear();
  const auto most = static_cast<std::size_t>(most_points), most_manifolds = (most + room - 1) / room;
  manifolds_.reserve(most_manifolds);
  records_.reserve(most_manifolds * room);
  old_.reserve(most_manifolds * room);
  new_.reserve(most);
  match_.reserve(most);
  in_.reserve(most);
  count_.assign(most_manifolds, 0);
}

void PairManifolds::release() {
  for (btPersistentManifold* const manifold : manifolds_) dispatcher_->releaseManifold(manifold);
  manifolds_.clear();
}

btPersistentManifold& PairManifolds::manifold(std::size_t index, const btCollisionObjectWrapper& a,
                                              const btCollisionObjectWrapper& b) {
  while (manifolds_.size() <= index) {
    manifolds_.push_back(dispatcher_->getNewManifold(a.getCollisionObject(), b.getCollisionObject()));
    threshold_ = manifolds_.back()->getContactBreakingThreshold();
  }
  assert(manifolds_[index]->getBody0() == a.getCollisionObject());
  return *manifolds_[index];
}

/// Collects the points with all that the solver and others have done to them since fill().
void PairManifolds::gather() {
  old_.clear();
  for (const btPersistentManifold* const manifold : manifolds_) {
    for (int i = 0; i < manifold->getNumContacts(); ++i) {
      Old old{manifold->getContactPoint(i), 0, false, false};
      old.point.m_lifeTime = 0;
      for (const Record& record : records_) {
        if (!same_bits(record.local_a, old.point.m_localPointA) ||
            !same_bits(record.local_b, old.point.m_localPointB)) {
          continue;
        }
        old.feature = record.feature;
        old.known = true;
        old.point.m_lifeTime = record.life_time;
        break;
      }
      old_.push_back(old);
    }
  }
}

PairManifolds::Old* PairManifolds::same_feature(std::uint64_t feature) {
  for (Old& old : old_) {
    if (old.known && !old.taken && old.feature == feature) return &old;
  }
  return nullptr;
}

PairManifolds::Old* PairManifolds::nearest(const btManifoldPoint& point, double nearness) {
  Old* best = nullptr;
  auto least = static_cast<btScalar>(nearness * nearness);
  for (Old& old : old_) {
    if (old.taken || old.point.m_normalWorldOnB.dot(point.m_normalWorldOnB) < same_way) continue;
    // A point that slides over one of the bodies stays where it is on the other.
    const btScalar squared = std::min((old.point.m_localPointA - point.m_localPointA).length2(),
                                      (old.point.m_localPointB - point.m_localPointB).length2());
    if (squared > least) continue;
    least = squared;
    best = &old;
  }
  return best;
}

/// Returns a manifold with room for as many as possible of the patch's points, which begin at `first`.
std::size_t PairManifolds::place_for(std::span<const ManifoldPoint> points, std::size_t first) const {
  int size = 0;
  for (std::size_t i = first; i < points.size(); ++i) size += in_[i] < 0 && points[i].patch == points[first].patch;
  const int wanted = std::min(size, room);
  std::size_t any = 0;
  for (std::size_t m = count_.size(); m-- > 0;) {
    if (count_[m] < room) any = m;
  }
  for (std::size_t m = any; m < count_.size(); ++m) {
    if (count_[m] + wanted <= room) return m;
  }
  return any;
}

void PairManifolds::fill(std::span<const ManifoldPoint> points, const btCollisionObjectWrapper& a,
                         const btCollisionObjectWrapper& b, double nearness) {
  if (points.empty() && records_.empty()) return;
  const btCollisionObject &body_a = *a.getCollisionObject(), &body_b = *b.getCollisionObject();
  gather();
  new_.clear();
  match_.clear();
  for (const ManifoldPoint& point : points) {
    new_.push_back(to_manifold_point(point, a, b));
    Old* const old = same_feature(point.feature);
    // A feature that is touched from another side is another contact.
    const bool same = old != nullptr && old->point.m_normalWorldOnB.dot(new_.back().m_normalWorldOnB) > 0;
    if (same) old->taken = true;
    match_.push_back(same ? old : nullptr);
  }
  records_.clear();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (match_[i] == nullptr) {
      match_[i] = nearest(new_[i], nearness);
      if (match_[i] != nullptr) match_[i]->taken = true;
    }
    if (match_[i] != nullptr) continue_point(new_[i], match_[i]->point, body_a, body_b);
    new_[i].m_lifeTime = match_[i] != nullptr ? match_[i]->point.m_lifeTime + 1 : 0;
    records_.push_back({points[i].feature, new_[i].m_localPointA, new_[i].m_localPointB, new_[i].m_lifeTime});
  }

  std::fill(count_.begin(), count_.end(), 0);
  in_.assign(points.size(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    while (in_[i] < 0) {
      const std::size_t m = place_for(points, i);
      for (std::size_t j = i; j < points.size() && count_[m] < room; ++j) {
        if (in_[j] >= 0 || points[j].patch != points[i].patch) continue;
        in_[j] = static_cast<int>(m);
        ++count_[m];
      }
    }
  }
  for (std::size_t m = 0; m < count_.size() && (m < manifolds_.size() || count_[m] > 0); ++m) {
    btPersistentManifold& target = manifold(m, a, b);
    // No point exceeds it, so that nobody's refreshContactPoints() drops any.
    target.setContactBreakingThreshold(BT_LARGE_FLOAT);
    const int before = target.getNumContacts();
    for (int i = 0; i < before; ++i) target.getContactPoint(i).m_userPersistentData = nullptr;
    target.setNumContacts(count_[m]);
    int slot = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (in_[i] == static_cast<int>(m)) target.getContactPoint(slot++) = new_[i];
    }
    for (Old& old : old_) {
      if (!old.taken) target.clearUserCache(old.point);  // tells whoever keeps data with the point that it is gone
      old.taken = true;
    }
    if (wants_callback(body_a, body_b)) {
      for (int i = 0; i < slot; ++i) {
        gContactAddedCallback(target.getContactPoint(i), &a, a.m_partId, a.m_index, &b, b.m_partId, b.m_index);
      }
    }
    btPersistentManifold* const changed = &target;
    if (before == 0 && slot > 0 && gContactStartedCallback != nullptr) gContactStartedCallback(changed);
    if (before > 0 && slot == 0 && gContactEndedCallback != nullptr) gContactEndedCallback(changed);
  }
}

void PairManifolds::forward(std::span<const ManifoldPoint> points, const btCollisionObjectWrapper& a,
                            const btCollisionObjectWrapper& b, btPersistentManifold* shared, btManifoldResult& result) {
  btPersistentManifold* target = shared;
  if (target == nullptr) {
    target = &manifold(0, a, b);
    for (btPersistentManifold* const own : manifolds_) own->clearManifold();
    target->setContactBreakingThreshold(threshold_);
    records_.clear();
  }
  result.setPersistentManifold(target);
  for (const ManifoldPoint& point : points) {
    result.addContactPoint(to_bullet(point.normal), to_bullet(point.point_b), static_cast<btScalar>(point.separation));
  }
  result.setPersistentManifold(nullptr);
}

}  // namespace encage::bullet
