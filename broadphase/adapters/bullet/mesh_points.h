// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/manifold.h>

#include <BulletCollision/NarrowPhaseCollision/btManifoldPoint.h>

#include <cstdint>
#include <span>
#include <vector>

class btDispatcher;
class btManifoldResult;
class btPersistentManifold;
struct btCollisionObjectWrapper;

namespace encage::bullet {

/// The manifolds of one pair of shapes. They hold exactly the points of the last step: none is added, merged or dropped
/// by Bullet's rules, and what the solver has stored in a point passes to the point that takes its place.
class PairManifolds {
 public:
  /// Prepares for a pair without manifolds; they come as points do.
  void begin(btDispatcher& dispatcher, int most_points);
  void release();  ///< gives all manifolds back

  /// Replaces the points. `nearness` is the distance, in world units, within which a point of another feature continues
  /// an old one. Does not allocate except for manifolds. The order of the two wrappers is the same in all calls.
  void fill(std::span<const ManifoldPoint> points, const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b,
            double nearness);

  /// Passes the points to a result that has its own mind about them. `shared` is a manifold of somebody else for them;
  /// if null, a manifold of this pair is emptied and used.
  void forward(std::span<const ManifoldPoint> points, const btCollisionObjectWrapper& a,
               const btCollisionObjectWrapper& b, btPersistentManifold* shared, btManifoldResult& result);

  std::span<btPersistentManifold* const> all() const { return manifolds_; }

 private:
  /// What is known of a point in a manifold; the bits of its local points tell it from others.
  struct Record {
    std::uint64_t feature;
    btVector3 local_a, local_b;
    int life_time;
  };
  struct Old {
    btManifoldPoint point;
    std::uint64_t feature;
    bool known, taken;
  };

  btPersistentManifold& manifold(std::size_t index, const btCollisionObjectWrapper& a,
                                 const btCollisionObjectWrapper& b);
  void gather();
  Old* same_feature(std::uint64_t feature);
  Old* nearest(const btManifoldPoint& point, double nearness);
  std::size_t place_for(std::span<const ManifoldPoint> points, std::size_t first) const;

  btDispatcher* dispatcher_ = nullptr;
  btScalar threshold_ = 0;  // that the dispatcher gave the manifolds
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<Record> records_;
  std::vector<Old> old_;
  std::vector<btManifoldPoint> new_;
  std::vector<Old*> match_;
  std::vector<int> count_;  // of points in each manifold
  std::vector<int> in_;     // manifold of each new point
};

}  // namespace encage::bullet
