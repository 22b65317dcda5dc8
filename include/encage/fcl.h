// SPDX-License-Identifier: Apache-2.0
#pragma once

// Early reject for FCL's broad-phase managers. Link encage::fcl.
//
//   auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();  // of the mesh that the asset was baked of
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

/// Which geometries of FCL are bodies of which shapes. In double: poses in float are farther from rigid than Encage
/// takes. User data of objects and geometries stay the user's. Queries may share it in any number of threads as long as
/// nobody attaches or detaches.
class FclShapes {
 public:
  /// Objects of `geometry` are from now on bodies of the shape at `scale` times its size; replaces what was attached.
  /// The geometry's own coordinates have to be the body frame's, times the scale, and have to stay: detach before
  /// changing a BVHModel. Both are kept alive. Calls computeLocalAABB(), as CollisionObject does. Throws Error, without
  /// effect: no geometry, no shape, a scale not between 1e-50 and 1e50, or a geometry that is not within the bounding
  /// box of the shape, and so not of its mesh.
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
  std::int64_t asked = 0;     ///< pairs of which both shapes are known
  std::int64_t rejected = 0;  ///< of these, kept from the user's callback
};

/// Stands in front of a callback for BroadPhaseCollisionManager::collide(): a pair that is proven apart does not reach
/// it, and the search goes on; all others do, as ever. What FCL would compute of such a pair is no contact: its meshes
/// are surfaces, their contacts have no margin. One object for each query that runs at the same time; it allocates
/// nothing.
class FclCollision {
 public:
  /// `shapes` and what `data` points to must outlive this. options.margin: for callbacks that want more than contacts,
  /// pairs at most so far apart are kept.
  FclCollision(const FclShapes& shapes, ::fcl::CollisionCallBack<double> user, void* data,
               const PairOptions& options = {});

  /// For the manager, with the address of an FclCollision as its data. What the user's callback throws passes through.
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
  /// Cages are asked first, from coarse to fine; `enough` is the least distance so far.
  CageDistanceOptions cages{.finest_cage = 0};
  /// Whether the fine meshes are asked where cages prove too little, by distance().
  bool fine = true;
};

/// Stands in front of a callback for BroadPhaseCollisionManager::distance(): a pair that is proven no nearer than the
/// least distance so far (the callback's last argument) does not reach it, and the search goes on. So it is for
/// callbacks that look for the least distance, up to FCL's own rounding the same one, and not for such that want to
/// see every pair. Otherwise as FclCollision.
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
