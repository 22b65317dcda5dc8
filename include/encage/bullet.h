// SPDX-License-Identifier: Apache-2.0
#pragma once

// Early reject for Bullet's dynamic concave meshes (btGImpactMeshShape). Link encage::bullet.
//
//   btDefaultCollisionConfiguration configuration;
//   btCollisionDispatcher dispatcher(&configuration);
//   btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
//   encage::BulletAdapter adapter(dispatcher);               // decorates what has been registered
//   btDbvtBroadphase broadphase;
//   btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//   btGImpactMeshShape mesh(&arrays);                        // the mesh that the asset was baked of
//   mesh.updateBound();
//   adapter.attach(mesh, encage::load_shape("octopus.glb"));
//   world.stepSimulation(1 / 60.f);                          // and all the rest, as ever

#include <encage/error.h>
#include <encage/export.h>
#include <encage/separated.h>

#include <cstdint>
#include <memory>

class btCollisionDispatcher;
class btGImpactMeshShape;

namespace ENCAGE_EXPORT encage {

/// Which contacts the adapter leaves as they are.
enum class BulletContacts : std::uint8_t {
  /// All: a world with the adapter behaves as one without, bit for bit. GImpact's test of two triangles takes what lies
  /// behind a face for inside, at any depth, so that two triangles back to back "touch" where their bounding boxes
  /// overlap. So a pair is rejected only if no boxes of triangles overlap.
  all,
  /// Those within the margins; contacts of triangles farther apart are dropped. Rejects more if triangles are large.
  within_margins,
};

struct BulletStatistics {
  std::int64_t asked = 0;     ///< pairs dispatched of which both shapes are known
  std::int64_t rejected = 0;  ///< of these, proven to have no contact
};

/// Stands in front of the collision algorithms of a dispatcher that take GImpact shapes. Where separated() proves that
/// two meshes, or a mesh and a static plane (btStaticPlaneShape), have no contact, the algorithm in charge is not
/// asked and what contact manifolds it held are released, as GImpact does itself. Everything else is handed on:
/// shapes that are not attached, non-uniform local scaling, time of impact. Not rejected is a pair nearer
/// than both collision margins and the rounding of btScalar in the poses and within Bullet (docs/guarantee.md,
/// "Bullet"), and, for algorithms other than GImpact's own, 1.5 times the contact breaking threshold
/// (gContactBreakingThreshold, the relative one or the manifold's, whichever is largest) and the query's
/// closest-point threshold. GImpact's needs neither: it begins each step without contacts and makes none
/// without overlap. See also BulletContacts.
///
/// Create it after the algorithms have been registered. Several adapters of one dispatcher have to be destroyed in
/// reverse order of creation; a world may outlive its adapter, the dispatcher must.
/// Threads: dispatch may run on as many as Bullet itself allows. Adapters of different worlds are independent and may
/// share ShapePtr; attach() and detach() are for when the dispatcher is idle.
class BulletAdapter {
 public:
  explicit BulletAdapter(btCollisionDispatcher& dispatcher, BulletContacts contacts = BulletContacts::all);
  ~BulletAdapter();  ///< gives the dispatcher back the algorithms that it had
  BulletAdapter(const BulletAdapter&) = delete;
  BulletAdapter& operator=(const BulletAdapter&) = delete;

  /// `mesh` is the source that `shape` was baked of, or its stored fine mesh, with vertices rounded to float at most,
  /// locally scaled by one factor or not at all. Replaces an earlier attachment. To be called again after any change
  /// of the mesh, its margin, its scaling or updateBound() (until then a change of margin or scaling is noticed, and
  /// nothing rejected); detach() before the mesh is destroyed. The mesh is not owned, the shape is shared. O(n).
  /// Throws Error for a null shape, a compound, a mesh without updateBound(), a margin that is negative or not finite,
  /// vertices that are not finite, and a mesh whose box is not the asset's: another unit, frame or mesh.
  void attach(const btGImpactMeshShape& mesh, ShapePtr shape);

  /// Nothing of this mesh is rejected any more; false if it was not attached.
  bool detach(const btGImpactMeshShape& mesh) noexcept;

  BulletStatistics statistics() const noexcept;  ///< since the adapter was created

 private:
  class State;
  class Algorithm;
  std::shared_ptr<State> state_;  // shared with the algorithms, which may outlive the adapter
};

}  // namespace encage
