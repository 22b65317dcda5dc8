// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dynamic concave meshes for Bullet, which collide with each other and with Bullet's own shapes by contact_manifold().
// Link encage::bullet.
//
//   btDefaultCollisionConfiguration configuration;
//   btCollisionDispatcher dispatcher(&configuration);
//   encage::BulletMeshContacts contacts(dispatcher);          // pairs of its meshes with all shapes, from now on
//   btDbvtBroadphase broadphase;
//   btSequentialImpulseConstraintSolver solver;
//   btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//   encage::BulletMeshShape shape(encage::load_shape("octopus.glb"), {.frame = encage::BulletFrame::principal});
//   btVector3 inertia;
//   shape.calculateLocalInertia(mass, inertia);
//   btRigidBody body(mass, nullptr, &shape, inertia);
//   world.addRigidBody(&body);

#include <encage/error.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/mass_properties.h>
#include <encage/shape.h>

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <LinearMath/btTransform.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

class btCollisionDispatcher;
class btCollisionShape;
class btStridingMeshInterface;

namespace ENCAGE_EXPORT encage {

/// Which frame Bullet's body has. Bullet takes the origin for the centre of mass and the axes for principal ones.
enum class BulletFrame : std::uint8_t {
  asset,      ///< that of the asset's source
  principal,  ///< at the centre of mass, along the principal axes of inertia; the mesh must enclose a volume
};

struct BulletMeshShapeOptions {
  BulletFrame frame = BulletFrame::asset;
  /// Parts of the radius, >= 0, by which getAabb() enlarges the box, so that pairs are found before they touch. Bullet
  /// enlarges the boxes of bodies by their motion, but not those of children of a btCompoundShape: there, children that
  /// move farther than this in a step may touch others before they have contact points.
  double reach = 0.02;
};

/// A mesh of an Encage shape, or a compound of such, for bodies that may move. It shares the shape. Any number of
/// bodies may share a BulletMeshShape, and so may worlds and threads, as long as nobody changes its scaling or margin.
///
/// setMargin() rounds the body: it is the mesh and everything within the margin (world units, unlike the scaling not
/// multiplied by anything), by default 0. setLocalScaling() takes one factor for all axes and throws Error for others.
///
/// Ray tests of btCollisionWorld go through cast_ray() and for_each_hit(): no triangle is missed, and each is given by
/// its number (part 0; those of a compound are numbered through all its parts). Bullet's flags for back faces hold.
/// Contacts need a BulletMeshContacts. Sweep tests (convexSweepTest) are Bullet's, of the triangles near the way.
class BulletMeshShape final : public btConcaveShape {
 public:
  /// Throws Error if the shape is null, has no fine mesh or has a convex_radius(), if an option is out of range, or if
  /// the mass properties of a body in the principal frame cannot be computed (mass_properties()). O(n).
  explicit BulletMeshShape(ShapePtr shape, const BulletMeshShapeOptions& options = {});
  /// Loads the asset and checks, by require_source(), that it was baked from this mesh. Throws Error, which names the
  /// file. `source` is only used during the call.
  BulletMeshShape(const std::filesystem::path& file, const TriangleMesh& source,
                  const BulletMeshShapeOptions& options = {});
  BulletMeshShape(const std::filesystem::path& file, const btStridingMeshInterface& source,
                  const BulletMeshShapeOptions& options = {});
  ~BulletMeshShape() override;

  const ShapePtr& shape() const noexcept { return shape_; }
  /// Maps the frame of the asset, unscaled, to the body's: draw the asset's mesh at body * scaling * asset_to_body().
  const Eigen::Isometry3d& asset_to_body() const noexcept { return asset_to_body_; }
  double scale() const noexcept { return scale_; }
  /// Largest distance of a point of the body from its origin: world units, scaling and margin included.
  double radius() const noexcept;
  /// The motion of the shape in a body at rest at this pose. Basis vectors of btScalar are replaced by the nearest
  /// rotation.
  Motion motion(const btTransform& body) const noexcept;

  /// Mass properties in the body's frame, scaling included, margin not, for density 1. Throws Error if the mesh
  /// encloses no volume. Parts of a compound that overlap count twice there.
  MassProperties mass_properties() const;

  // Bullet's interface:
  void getAabb(const btTransform& body, btVector3& low, btVector3& high) const override;
  void setLocalScaling(const btVector3& scaling) override;
  const btVector3& getLocalScaling() const override { return scaling_; }
  /// The diagonal of the inertia tensor about the centre of mass, exact for a body in its principal frame; for one that
  /// encloses no volume, that of its bounding box.
  void calculateLocalInertia(btScalar mass, btVector3& inertia) const override;
  const char* getName() const override { return "EncageMesh"; }
  /// Passes all triangles that are in leaves of the tree near the box to the callback. A btTriangleRaycastCallback gets
  /// no triangles but reports of what its ray meets.
  void processAllTriangles(btTriangleCallback* callback, const btVector3& low, const btVector3& high) const override;

 private:
  ShapePtr shape_;
  std::vector<FineLease> leases_;  // keep the triangles in memory
  Eigen::Isometry3d asset_to_body_ = Eigen::Isometry3d::Identity();
  Eigen::AlignedBox3d box_;  // of the fine mesh in the body's frame, unscaled
  double reach_ = 0;         // largest distance of a vertex from the body's origin, unscaled
  bool encloses_ = false;    // mass_ is known
  MassProperties mass_;      // in the body's frame, unscaled
  double box_growth_ = 0;    // a length, unscaled
  double scale_ = 1;
  btVector3 scaling_{1, 1, 1};  // as Bullet wants it
};

struct BulletMeshOptions {
  /// Parts of the radius of the smaller body, >= 0. Surfaces get contact points while they are apart by no more than
  /// this, whatever the speed, so that contacts of resting bodies do not come and go.
  double skin = 0.003;
  /// Parts of the radius of the smaller body, >= 0. Beyond the skin, surfaces get speculative contact points as far as
  /// the bodies may approach each other during the step, but no farther than this: bodies that are faster may enter
  /// each other. Wide reach costs time.
  double most_speculation = 0.5;
  int most_points = 16;    ///< of a pair of shapes, 1 to 64; a btPersistentManifold holds four of them
  int most_per_patch = 4;  ///< of a region of contact, > 0
};

/// Gives a dispatcher collision algorithms for every pair of a BulletMeshShape with another one, a static plane, a
/// convex shape, a triangle mesh or a height field, in compounds (btCompoundShape) as well.
///
/// Convex shapes, triangle meshes and height fields become Encage shapes when they first meet a mesh, once for all
/// pairs: O(n log n). Spheres, capsules, boxes, hulls and simplexes stay exact; cylinders and cones become prisms and
/// pyramids of 64 sides, other convex shapes hulls of 2,568 support points. Cones, hulls and simplexes are rounded by
/// their margins, as Bullet's own algorithms do it, and so are triangle meshes and height fields. The latter two are
/// their surfaces alone: two-sided, with nothing inside. A change of margin or scaling is noticed; call forget() when
/// anything else of a shape changes, e.g. vertices, and best before it is destroyed, for the contacts keep the
/// converted shape. A step throws Error for a shape that cannot be converted (a vertex that is not finite).
///
/// Each pair has several manifolds, which hold exactly the points of contact_manifold(); impulses pass from step to
/// step by the features that touch. gContactAddedCallback and the combination of materials work as with Bullet's
/// algorithms; part and index are those of the child in a compound, not of triangles. Contact tests (contactTest,
/// contactPairTest) get their points as from Bullet's algorithms. Time of impact is not computed: use the speculative
/// reach. A body whose basis is no rotation has no contacts.
///
/// Create it after other algorithms have been registered and before a BulletMeshShape joins the world, for Bullet's own
/// algorithms take it for a shape of another class; destroy it when none is left, or after the world, and several
/// objects that register with one dispatcher in reverse order of creation. The dispatcher must outlive it. Pairs that
/// exist when it is destroyed keep their algorithms. Dispatch may run on as many threads as Bullet itself allows; call
/// forget() only while the dispatcher is idle.
class BulletMeshContacts {
 public:
  /// Throws Error if an option is out of range.
  explicit BulletMeshContacts(btCollisionDispatcher& dispatcher, const BulletMeshOptions& options = {});
  ~BulletMeshContacts();  ///< gives the dispatcher back the algorithms that it had
  BulletMeshContacts(const BulletMeshContacts&) = delete;
  BulletMeshContacts& operator=(const BulletMeshContacts&) = delete;

  /// Drops what was converted from the shape; the next step converts it anew. Returns false if there was nothing.
  bool forget(const btCollisionShape& shape) noexcept;

 private:
  class State;
  class Algorithm;
  std::shared_ptr<State> state_;  // shared with the algorithms, which may outlive this
};

}  // namespace encage
