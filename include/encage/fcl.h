// SPDX-License-Identifier: Apache-2.0
#pragma once

// Early reject for FCL's broad-phase managers. Link encage::fcl.
//
//   auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();  // of the mesh that the asset was baked from
//   encage::FclShapes shapes;
//   shapes.attach(model, encage::load_shape("octopus.glb"));       // once, for all objects of this geometry
//   fcl::CollisionObjectd first(model), second(model);             // registered with a manager, and moved
//
//   fcl::DefaultCollisionData<double> contacts;
//   encage::FclCollision collision(shapes, fcl::DefaultCollisionFunction<double>, &contacts);
//   manager.collide(&collision, encage::FclCollision::callback);
//   fcl::DefaultDistanceData<double> nearest;
//   encage::FclDistance distance(shapes, fcl::DefaultDistanceFunction<double>, &nearest);
//   manager.distance(&distance, encage::FclDistance::callback);

#include <encage/distance.h>
#include <encage/error.h>
#include <encage/export.h>
#include <encage/separated.h>

#include <fcl/broadphase/broadphase_collision_manager.h>
#include <fcl/narrowphase/collision_object.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>

namespace ENCAGE_EXPORT encage {

/// Which geometries of FCL are bodies of which shapes. Geometries must be in double: poses in float are farther from
/// rigid than Encage takes. User data of objects and geometries stay yours. Any number of threads may query at a time,
/// as long as none attaches or detaches.
class FclShapes {
 public:
  /// Makes all objects of `geometry` bodies of the shape at `scale` times its size, in place of what was attached. The
  /// geometry's coordinates must be the body frame's times the scale, and must not change: detach before you change a
  /// BVHModel. Keeps both alive. Calls computeLocalAABB(), as CollisionObject does. Throws Error, without effect, for a
  /// null geometry or shape, a scale not between 1e-50 and 1e50, and a geometry that is not within the bounding box of
  /// the shape, and so is not of its mesh.
  void attach(const std::shared_ptr<::fcl::CollisionGeometryd>& geometry, ShapePtr shape, double scale = 1);
  void detach(const ::fcl::CollisionGeometryd* geometry) noexcept;

  /// A body of a shape, where FCL has the object.
  struct Body {
    const Shape* shape = nullptr;
    Motion motion;
  };
  /// No value if the object's geometry is not attached.
  std::optional<Body> body(const ::fcl::CollisionObjectd& object) const;

 private:
  struct Entry {
    std::shared_ptr<const ::fcl::CollisionGeometryd> geometry;  // no other can get its address
    ShapePtr shape;
    double scale = 1;
  };
  std::unordered_map<const ::fcl::CollisionGeometryd*, Entry> entries_;
};

struct FclStatistics {
  std::int64_t asked = 0;     ///< pairs whose shapes are both known
  std::int64_t rejected = 0;  ///< of these, kept from the user's callback
};

/// Stands in front of a callback for BroadPhaseCollisionManager::collide(). A pair that is proven apart does not reach
/// the callback, and the search goes on; all other pairs do. FCL would find no contact in a rejected pair: its meshes
/// are surfaces, and their contacts have no margin. Use one object for each query that runs at the same time. It
/// allocates nothing.
class FclCollision {
 public:
  /// `shapes` and what `data` points to must outlive this. Pairs at most `options.margin` apart reach the callback: for
  /// callbacks that want more than contacts.
  FclCollision(const FclShapes& shapes, ::fcl::CollisionCallBack<double> user, void* data,
               const PairOptions& options = {});

  /// Pass this to the manager, with the address of an FclCollision as data. What the user's callback throws passes
  /// through.
  static bool callback(::fcl::CollisionObjectd* a, ::fcl::CollisionObjectd* b, void* collision);

  const FclStatistics& statistics() const { return statistics_; }

 private:
  const FclShapes* shapes_;
  ::fcl::CollisionCallBack<double> user_;
  void* data_;
  PairOptions options_;
  FclStatistics statistics_;
};

struct FclDistanceOptions {
  /// How cages are asked, first and from coarse to fine. `enough` is ignored: it is the least distance so far.
  CageDistanceOptions cages{.finest_cage = 0};
  /// Whether distance() asks the fine meshes where cages prove too little.
  bool fine = true;
};

/// Stands in front of a callback for BroadPhaseCollisionManager::distance(). A pair that is proven no nearer than the
/// least distance so far (the callback's last argument) does not reach the callback, and the search goes on. So it is
/// for callbacks that look for the least distance, which stays the same up to FCL's own rounding, and not for callbacks
/// that want to see every pair. Otherwise as FclCollision.
///
/// Signed distances (DistanceRequest::enable_signed_distance) are FCL's own: pairs that touch or penetrate reach the
/// callback, whatever the least distance so far, and so do all pairs once it is not positive. encage::signed_distance()
/// gives those of points, for the shape and motion of FclShapes::body().
class FclDistance {
 public:
  FclDistance(const FclShapes& shapes, ::fcl::DistanceCallBack<double> user, void* data,
              const FclDistanceOptions& options = {});

  static bool callback(::fcl::CollisionObjectd* a, ::fcl::CollisionObjectd* b, void* distance, double& least);

  const FclStatistics& statistics() const { return statistics_; }

 private:
  bool no_nearer(const FclShapes::Body& a, const FclShapes::Body& b, double least) const;

  const FclShapes* shapes_;
  ::fcl::DistanceCallBack<double> user_;
  void* data_;
  FclDistanceOptions options_;
  FclStatistics statistics_;
};

}  // namespace encage
