// SPDX-License-Identifier: Apache-2.0
#pragma once

// Early reject for Bullet's dynamic concave meshes (btGImpactMeshShape). Link encage::bullet.
//
//   btDefaultCollisionConfiguration configuration;
//   btCollisionDispatcher dispatcher(&configuration);
//   btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
//   encage::BulletAdapter adapter(dispatcher);               // decorates the algorithms registered so far
//   btDbvtBroadphase broadphase;
//   btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//   btGImpactMeshShape mesh(&arrays);                        // the mesh that the asset was baked from
//   mesh.updateBound();
//   adapter.attach(mesh, encage::load_shape("octopus.glb"));
//   world.stepSimulation(1 / 60.f);                          // everything else stays as it is

#include <encage/error.h>
#include <encage/export.h>
#include <encage/separated.h>

#include <cstdint>
#include <memory>

class btCollisionDispatcher;
class btGImpactMeshShape;

namespace ENCAGE_EXPORT encage {

/// Which of Bullet's contacts the adapter keeps.
enum class BulletContacts : std::uint8_t {
  /// All: a world with the adapter behaves as one without, bit for bit. For GImpact's test of two triangles whatever
  /// lies behind a face is inside, at any depth, so that two triangles back to back "touch" where their bounding boxes
  /// overlap. Therefore the adapter rejects a pair only if no boxes of triangles overlap.
  all,
  /// Those within the margins; the adapter drops contacts of triangles that are farther apart. It then rejects more if
  /// triangles are large.
  within_margins,
};

struct BulletStatistics {
  std::int64_t asked = 0;     ///< pairs whose shapes are both known
  std::int64_t rejected = 0;  ///< of these, proven to have no contact
};

/// Stands in front of those collision algorithms of a dispatcher that take GImpact shapes. Where separated() proves
/// that two meshes, or a mesh and a static plane (btStaticPlaneShape), have no contact, the adapter does not ask the
/// algorithm, and releases its contact manifolds, as GImpact does itself. It hands on everything else: shapes that are
/// not attached, non-uniform local scaling, time of impact.
///
/// It asks for a separation of both collision margins and the rounding of btScalar in the poses and within Bullet
/// (docs/guarantee.md, "Bullet"). For algorithms other than GImpact's own it adds 1.5 times the contact breaking
/// threshold (gContactBreakingThreshold, the relative one or the manifold's, whichever is largest) and the query's
/// closest-point threshold. GImpact's needs neither: it begins each step without contacts and makes none without
/// overlap. See also BulletContacts.
///
/// Create the adapter after the algorithms have been registered, and destroy several adapters of one dispatcher in
/// reverse order of creation. A world may outlive its adapter; the dispatcher must. Dispatch may run on as many threads
/// as Bullet itself allows. Adapters of different worlds are independent and may share a ShapePtr. Call attach() and
/// detach() only while the dispatcher is idle.
class BulletAdapter {
 public:
  explicit BulletAdapter(btCollisionDispatcher& dispatcher, BulletContacts contacts = BulletContacts::all);
  ~BulletAdapter();  ///< gives the dispatcher back the algorithms that it had
  BulletAdapter(const BulletAdapter&) = delete;
  BulletAdapter& operator=(const BulletAdapter&) = delete;

  /// Attaches the shape to a mesh, in place of an earlier one. `mesh` is the source that `shape` was baked from, or its
  /// stored fine mesh; its vertices may be rounded to float, and it may be locally scaled by one factor. Call it again
  /// after any change of the mesh, its margin, its scaling or updateBound(); until then the adapter notices a change of
  /// margin or scaling, and rejects nothing. Call detach() before the mesh is destroyed: the adapter does not own it.
  /// O(n). Throws Error for a null shape, a compound, one with a convex_radius(), a mesh without updateBound(), a
  /// margin that is negative or not finite, vertices that are not finite, and a mesh whose box is not the asset's
  /// (another unit, frame or mesh).
  void attach(const btGImpactMeshShape& mesh, ShapePtr shape);

  /// Stops rejecting pairs of this mesh. Returns false if it was not attached.
  bool detach(const btGImpactMeshShape& mesh) noexcept;

  BulletStatistics statistics() const noexcept;  ///< since the adapter was created

 private:
  class State;
  class Algorithm;
  std::shared_ptr<State> state_;  // shared with the algorithms, which may outlive the adapter
};

}  // namespace encage
