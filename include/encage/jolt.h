// SPDX-License-Identifier: Apache-2.0
#pragma once

// Dynamic concave meshes for Jolt Physics, which collide with each other and with Jolt's own shapes by
// contact_manifold(). This header is all there is: link encage::jolt where you include it.
//
//   JPH::PhysicsSystem system;                        // initialised as usual
//   encage::JoltContacts contacts(system);            // takes the place of the system's test of two bodies
//   const encage::JoltMesh octopus("octopus.glb");
//   contacts.add(octopus);                            // once, for all bodies of this mesh, in any compound
//   JPH::BodyInterface& bodies = system.GetBodyInterface();
//   bodies.CreateAndAddBody(octopus.body_settings(position, rotation, layer, density), JPH::EActivation::Activate);
//   system.Update(1 / 60.f, 1, &temp_allocator, &job_system);
//
// Bodies have a JPH::MeshShape, and the contacts come from PhysicsSystem::SetSimCollideBodyVsBody(). Functions of a
// JPH::Shape subclass in CollisionDispatch would not do: Jolt tells them neither the bodies nor their velocities, which
// the memory of a pair and speculative contacts need. And Jolt's own mesh shape has all that its queries want: rays,
// points, casts of convex shapes, soft bodies, drawing, saving. A subclass would also force the program to be compiled
// without run-time type information, as Jolt is by default.

#include <encage/asset.h>
#include <encage/error.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/manifold.h>
#include <encage/mass_properties.h>
#include <encage/primitives.h>
#include <encage/shape.h>

// Jolt wants its first.
#include <Jolt/Jolt.h>
#include <Jolt/Physics/Body/Body.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Body/BodyLockInterface.h>
#include <Jolt/Physics/Collision/CollideShape.h>
#include <Jolt/Physics/Collision/CollisionDispatch.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/CompoundShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/CylinderShape.h>
#include <Jolt/Physics/Collision/Shape/DecoratedShape.h>
#include <Jolt/Physics/Collision/Shape/MeshShape.h>
#include <Jolt/Physics/Collision/Shape/OffsetCenterOfMassShape.h>
#include <Jolt/Physics/Collision/Shape/PlaneShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/TriangleShape.h>
#include <Jolt/Physics/Collision/ShapeFilter.h>
#include <Jolt/Physics/Collision/TransformedShape.h>
#include <Jolt/Physics/PhysicsStepListener.h>
#include <Jolt/Physics/PhysicsSystem.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace ENCAGE_EXPORT encage {

/// How much of a body lies below the surface of a liquid: the arguments of Body::ApplyBuoyancyImpulse().
struct JoltSubmersion {
  float total_volume = 0, submerged_volume = 0;
  JPH::Vec3 relative_centre = JPH::Vec3::sZero();  ///< of buoyancy, in world axes from the body's centre of mass
};

/// A mesh as a shape of Jolt's and of Encage's. Copies share both. The frame of Jolt's shape is that of the asset's
/// source, and the centre of mass is the body's, if the mesh encloses a volume. Coordinates are rounded to float.
class JoltMesh {
 public:
  /// `mesh` is the one that the shape was made of, in its body frame. It is only used during the call. Throws Error if
  /// the shape is null or has a convex_radius(), if the mesh is not within its box, or if Jolt refuses the mesh.
  /// O(n log n).
  JoltMesh(ShapePtr shape, const TriangleMesh& mesh);
  explicit JoltMesh(const TriangleMesh& mesh) : JoltMesh(make_shape(mesh), mesh) {}
  /// Loads an asset with its fine mesh. Throws Error, which names the file.
  explicit JoltMesh(const std::filesystem::path& asset);

  const ShapePtr& shape() const noexcept { return shape_; }
  /// For bodies and compounds; a JPH::ScaledShape around it may have one positive factor for all axes.
  const JPH::RefConst<JPH::Shape>& jolt_shape() const noexcept { return jolt_shape_; }
  /// The shape of Jolt's queries, with nothing around it.
  const JPH::MeshShape& mesh_shape() const noexcept { return *mesh_shape_; }
  /// Largest distance of a vertex from the centre of mass, or, of a surface, from the middle of its box.
  double radius() const noexcept { return radius_; }

  /// Number of a triangle of the source that a query found. Jolt's mesh has lost degenerate and double ones. The id is
  /// that of the mesh: of one in a compound, pass what Shape::GetLeafShape() leaves of it.
  std::int32_t triangle(const JPH::SubShapeID& id) const {
    return static_cast<std::int32_t>(mesh_shape_->GetTriangleUserData(id));
  }

  bool encloses_volume() const noexcept { return encloses_; }
  /// Exact mass properties of a body `scale` times as large, about the centre of mass and in the shape's axes. Throws
  /// Error if the mesh encloses no volume.
  JPH::MassProperties mass_properties(float density, float scale = 1) const;
  /// A dynamic body of this shape with its mass properties. Throws Error as above.
  JPH::BodyCreationSettings body_settings(JPH::RVec3Arg position, JPH::QuatArg rotation, JPH::ObjectLayer layer,
                                          float density) const;
  /// What of a body with this shape, not scaled, is below a surface; Jolt does not compute it for meshes. O(n). Throws
  /// Error as above.
  JoltSubmersion submersion(const JPH::Body& body, JPH::RVec3Arg surface, JPH::Vec3Arg normal) const;

 private:
  void require_volume(const char* what) const;

  ShapePtr shape_;
  std::shared_ptr<const FineLease> lease_;  // keeps the triangles in memory
  JPH::RefConst<JPH::MeshShape> mesh_shape_;
  JPH::RefConst<JPH::Shape> jolt_shape_;
  bool encloses_ = false;  // mass_ is known
  MassProperties mass_;
  double radius_ = 0;
};

struct JoltContactOptions {
  /// Parts of the radius of the smaller shape, >= 0. Surfaces get contact points while they are apart by no more than
  /// this, whatever the speed, so that contacts of resting bodies do not come and go. At least what bodies move while
  /// Jolt reuses their contacts, at most PhysicsSettings::mSpeculativeContactDistance.
  double skin = 0.006;
  /// Parts of the radius of the smaller shape, >= 0. Beyond the skin, surfaces get speculative contact points as far as
  /// the bodies may approach each other during the step, but no farther than this. Jolt passes on pairs of bodies whose
  /// boxes are within mSpeculativeContactDistance only: bodies that are faster may enter each other.
  double most_speculation = 0.5;
  int most_points = 16;    ///< of a pair of shapes, 1 to 60
  int most_per_patch = 4;  ///< of a region of contact, 1 to 4: what a manifold of Jolt's holds
};

/// Gives a physics system the contacts of every pair of bodies of which one has a JoltMesh: with another one, a convex
/// shape, a plane, a mesh or a height field, in compounds and decorated shapes as well. All other pairs go to the
/// function that was in place before.
///
/// Convex shapes, meshes that were not added, and height fields become Encage shapes when they first meet a mesh, once
/// for all pairs: O(n log n). Spheres, boxes, capsules, convex hulls and triangles stay exact; cylinders become prisms
/// of 64 sides, other convex shapes hulls of some 200 support points. Meshes and height fields are their surfaces
/// alone: two-sided, with nothing inside. Planes are half-spaces.
///
/// A region of contact whose normals agree is one manifold with up to four points, and has the same sub-shape ids in
/// all steps, so that Jolt finds the impulses of the step before. On the side of a mesh these ids are numbers of
/// regions: pass them to no function of the shape (GetSurfaceNormal()); GetMaterial() is fine. Bodies with
/// Body::GetUseManifoldReduction(), both of a pair, get their points merged by Jolt's rules: at most four of those of
/// all regions that face one way. JoltMesh::body_settings() turns that off.
///
/// Contacts are made for the simulation. Jolt's other queries treat a mesh as they always do, and cannot test two of
/// them: use separated(), distance() or contact_manifold(). There is no time of impact for meshes: leave their motion
/// quality at Discrete, and raise mSpeculativeContactDistance for fast bodies.
///
/// Create it before the system steps, and destroy it while it does not, after other objects that have replaced the
/// function since. The system must outlive it. add(), remove() and forget() must not be called during a step. Steps may
/// use any number of threads. The outcome does not depend on them, nor on what happened in other pairs.
class JoltContacts final : private JPH::PhysicsStepListener {
 public:
  /// Throws Error if an option is out of range.
  explicit JoltContacts(JPH::PhysicsSystem& system, const JoltContactOptions& options = {});
  ~JoltContacts() override;
  JoltContacts(const JoltContacts&) = delete;
  JoltContacts& operator=(const JoltContacts&) = delete;

  void add(const JoltMesh& mesh);
  /// Pairs of this mesh go to Jolt again, which cannot handle all of them.
  void remove(const JoltMesh& mesh) noexcept;
  /// Drops what was converted from one of Jolt's shapes; for a height field whose heights have changed.
  void forget(const JPH::Shape& shape);

  /// Why pairs have no contacts: shapes that cannot be converted or are scaled in a way that is not supported. Each
  /// reason once, since the last call.
  std::vector<std::string> take_errors();

 private:
  struct Partner;
  struct Side;
  struct Group;
  struct Pair;
  struct PairKey {
    std::uint32_t body_1, body_2, part_1, part_2;
    friend bool operator==(const PairKey&, const PairKey&) = default;
  };
  struct PairHash {
    std::size_t operator()(const PairKey& key) const noexcept {
      std::uint64_t hash = 0;
      for (const std::uint32_t part : {key.body_1, key.body_2, key.part_1, key.part_2}) {
        hash = (hash ^ part) * 0x9e3779b97f4a7c15;
        hash ^= hash >> 29;
      }
      return static_cast<std::size_t>(hash);
    }
  };
  struct Shard {
    std::mutex mutex;
    std::unordered_map<PairKey, std::unique_ptr<Pair>, PairHash> pairs;
  };
  struct Step;
  using PartnerKey = std::tuple<const JPH::Shape*, float, float, float>;

  static constexpr std::size_t shard_count = 64;                    // a power of two
  static constexpr std::uint64_t clean_every = 64, keep_for = 600;  // steps
  static constexpr int most_groups = 60, group_bits = 6, slot_bits = 2;
  static constexpr int most_manifold_points = 4;  // Jolt's

  void OnStep(const JPH::PhysicsStepListenerContext& context) override;
  bool has_mesh(const JPH::Shape& shape) const;
  void collide(const JPH::Body& body_1, const JPH::Body& body_2, JPH::Mat44Arg at_1, JPH::Mat44Arg at_2,
               JPH::CollideShapeSettings& settings, JPH::CollideShapeCollector& collector,
               const JPH::ShapeFilter& filter);
  void collide_leaves(const Step& step, const JPH::TransformedShape& leaf_1, const JPH::TransformedShape& leaf_2);
  Side side(Pair& pair, std::size_t index, const JPH::TransformedShape& leaf);
  std::shared_ptr<const Partner> partner(const JPH::Shape& shape, JPH::Vec3Arg scale);
  Pair& pair(const PairKey& key);
  void query(Pair& pair, const std::array<Side, 2>& sides, double margin) const;
  void group(Pair& pair, const Step& step, double nearness) const;
  void report(const Pair& pair, const Step& step, const std::array<Side, 2>& sides, const JPH::TransformedShape& leaf_1,
              const JPH::TransformedShape& leaf_2) const;
  void note(const std::string& error);

  JPH::PhysicsSystem& system_;
  JoltContactOptions options_;
  JPH::PhysicsSystem::SimCollideBodyVsBody former_;
  std::unordered_map<const JPH::Shape*, JoltMesh> meshes_;  // by their JPH::MeshShape
  std::array<Shard, shard_count> shards_;
  std::mutex partner_mutex_;
  std::map<PartnerKey, std::shared_ptr<const Partner>> partners_;
  std::uint64_t forgotten_ = 0;  // how often shapes were
  std::mutex error_mutex_;
  std::vector<std::string> errors_, known_errors_;
  float dt_ = 0;  // of the step, in which it does not change
  std::uint64_t step_ = 0;
};

namespace jolt {

inline Eigen::Vector3d to_eigen(JPH::Vec3Arg v) { return {v.GetX(), v.GetY(), v.GetZ()}; }
inline JPH::Vec3 to_jolt(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}
/// Quaternions of float are rotations only after rounding to the nearest one.
inline Eigen::Isometry3d to_eigen(JPH::Vec3Arg position, JPH::QuatArg rotation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(rotation.GetW(), rotation.GetX(), rotation.GetY(), rotation.GetZ())
                      .normalized()
                      .toRotationMatrix();
  pose.translation() = to_eigen(position);
  return pose;
}

/// Largest distance of a point of the shape from its centre of mass, or a little more.
inline double reach_of(const JPH::Shape& shape, JPH::Vec3Arg scale = JPH::Vec3::sOne()) {
  const JPH::AABox box = shape.GetLocalBounds();
  return to_eigen(scale * JPH::Vec3::sMax(box.mMin.Abs(), box.mMax.Abs())).norm();
}

/// Calls f with the corners of every triangle that Jolt has of a shape, counter-clockwise seen from outside.
template <class F>
void for_each_triangle(const JPH::Shape& shape, JPH::Vec3Arg position, JPH::QuatArg rotation, JPH::Vec3Arg scale,
                       const F& f) {
  constexpr int batch = 4 * JPH::Shape::cGetTrianglesMinTrianglesRequested;
  std::array<JPH::Float3, 3 * batch> corners;
  JPH::Shape::GetTrianglesContext context;
  shape.GetTrianglesStart(context, JPH::AABox::sBiggest(), position, rotation, scale);
  for (;;) {
    const int count = shape.GetTrianglesNext(context, batch, corners.data());
    if (count == 0) return;
    for (int i = 0; i < count; ++i) {
      std::array<Eigen::Vector3d, 3> triangle;
      for (int k = 0; k < 3; ++k) {
        const JPH::Float3& p = corners[static_cast<std::size_t>(3 * i + k)];
        triangle[static_cast<std::size_t>(k)] = {p.x, p.y, p.z};
      }
      f(triangle);
    }
  }
}

/// A body: its mesh and everything within a radius.
struct Rounded {
  TriangleMesh mesh;
  double radius = 0;
  bool hollow = false;
};

inline TriangleMesh with_triangles(const std::vector<Eigen::Vector3d>& points,
                                   const std::vector<Eigen::RowVector3i>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
  if (signed_volume(mesh) < 0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

inline TriangleMesh box_mesh(const Eigen::Vector3d& half) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z());
  }
  return with_triangles(corners, {{0, 2, 1},
                                  {1, 2, 3},
                                  {4, 5, 6},
                                  {5, 7, 6},
                                  {0, 1, 4},
                                  {1, 5, 4},
                                  {2, 6, 3},
                                  {3, 6, 7},
                                  {0, 4, 2},
                                  {2, 4, 6},
                                  {1, 3, 5},
                                  {3, 7, 5}});
}

/// The faces of a hull of Jolt's, whose points are relative to its centre of mass.
inline TriangleMesh hull_mesh(const JPH::ConvexHullShape& hull, const Eigen::Vector3d& scale,
                              const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  std::vector<Eigen::Vector3d> points;
  for (JPH::uint v = 0; v < hull.GetNumPoints(); ++v) {
    points.push_back(offset + scale.cwiseProduct(to_eigen(hull.GetPoint(v))));
  }
  std::vector<Eigen::RowVector3i> triangles;
  for (JPH::uint f = 0; f < hull.GetNumFaces(); ++f) {
    std::array<JPH::uint, JPH::ConvexHullShape::cMaxPointsInHull> face;
    const JPH::uint count = hull.GetFaceVertices(f, static_cast<JPH::uint>(face.size()), face.data());
    for (JPH::uint k = 2; k < count; ++k) {
      triangles.emplace_back(static_cast<int>(face[0]), static_cast<int>(face[k - 1]), static_cast<int>(face[k]));
    }
  }
  return with_triangles(points, triangles);
}

/// The convex hull of few points.
inline TriangleMesh hull_of(const JPH::Array<JPH::Vec3>& points) {
  JPH::ConvexHullShapeSettings settings(points, 0.0F);
  settings.SetEmbedded();
  settings.mHullTolerance = 0;  // Jolt's own, for rounding, remains
  const JPH::Shape::ShapeResult result = settings.Create();
  if (result.HasError()) throw Error(result.GetError().c_str());
  const auto& hull = static_cast<const JPH::ConvexHullShape&>(*result.Get());
  return hull_mesh(hull, Eigen::Vector3d::Ones(), to_eigen(hull.GetCenterOfMass()));
}

/// Points of a convex shape that are farthest in directions spread over the sphere (a spiral of equal areas).
inline JPH::Array<JPH::Vec3> support_points(const JPH::ConvexShape& shape, JPH::Vec3Arg scale) {
  constexpr int count = 200;  // hulls of Jolt's have up to 256
  JPH::ConvexShape::SupportBuffer buffer;
  const JPH::ConvexShape::Support* const support =
      shape.GetSupportFunction(JPH::ConvexShape::ESupportMode::IncludeConvexRadius, buffer, scale);
  JPH::Array<JPH::Vec3> points;
  const double turn = std::acos(-1.0) * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
    points.push_back(support->GetSupport(to_jolt({r * std::cos(turn * i), r * std::sin(turn * i), z})));
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double way : {1.0, -1.0})
      points.push_back(support->GetSupport(to_jolt(way * Eigen::Vector3d::Unit(axis))));
  }
  return points;
}

/// The triangles of a mesh or a height field, vertices with equal coordinates being one.
inline TriangleMesh welded_triangles(const JPH::Shape& shape, JPH::Vec3Arg scale) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::RowVector3i> triangles;
  std::map<std::array<double, 3>, int> known;
  for_each_triangle(shape, JPH::Vec3::sZero(), JPH::Quat::sIdentity(), scale, [&](const auto& triangle) {
    Eigen::RowVector3i corners;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = triangle[static_cast<std::size_t>(k)];
      const auto [at, is_new] = known.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(points.size()));
      if (is_new) points.push_back(p);
      corners[k] = at->second;
    }
    triangles.push_back(corners);
  });
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
  return mesh;
}

/// A leaf shape of Jolt's, about its centre of mass. Throws Error if it is of a kind that is not supported.
inline Rounded round_shape(const JPH::Shape& shape, JPH::Vec3Arg scale) {
  constexpr int round_sides = 64;
  const Eigen::Vector3d factors = to_eigen(scale);
  switch (shape.GetSubType()) {
    case JPH::EShapeSubType::Sphere:
      return {with_triangles({Eigen::Vector3d::Zero()}, {{0, 0, 0}}),
              std::abs(factors.x()) * static_cast<double>(static_cast<const JPH::SphereShape&>(shape).GetRadius())};
    case JPH::EShapeSubType::Capsule: {
      const auto& capsule = static_cast<const JPH::CapsuleShape&>(shape);
      const double size = std::abs(factors.x());
      const Eigen::Vector3d end(0, size * static_cast<double>(capsule.GetHalfHeightOfCylinder()), 0);
      return {with_triangles({end, -end}, {{0, 1, 1}}), size * static_cast<double>(capsule.GetRadius())};
    }
    case JPH::EShapeSubType::Box:
      return {box_mesh(to_eigen(static_cast<const JPH::BoxShape&>(shape).GetHalfExtent() * scale.Abs()))};
    case JPH::EShapeSubType::ConvexHull: return {hull_mesh(static_cast<const JPH::ConvexHullShape&>(shape), factors)};
    case JPH::EShapeSubType::Triangle: {
      const auto& triangle = static_cast<const JPH::TriangleShape&>(shape);
      std::vector<Eigen::Vector3d> points;
      for (const JPH::Vec3& p : {triangle.GetVertex1(), triangle.GetVertex2(), triangle.GetVertex3()}) {
        points.push_back(to_eigen(scale * p));
      }
      return {with_triangles(points, {{0, 1, 2}, {0, 2, 1}}),
              std::abs(factors.x()) * static_cast<double>(triangle.GetConvexRadius())};
    }
    case JPH::EShapeSubType::Cylinder: {
      const auto& cylinder = static_cast<const JPH::CylinderShape&>(shape);
      JPH::Array<JPH::Vec3> points;
      for (int i = 0; i < 2 * round_sides; ++i) {
        const double angle = 2 * std::acos(-1.0) * (i / 2) / round_sides;
        const auto r = static_cast<double>(cylinder.GetRadius()), h = static_cast<double>(cylinder.GetHalfHeight());
        points.push_back(scale * to_jolt({r * std::cos(angle), i % 2 == 0 ? h : -h, r * std::sin(angle)}));
      }
      return {hull_of(points)};
    }
    case JPH::EShapeSubType::Mesh:
    case JPH::EShapeSubType::HeightField: return {welded_triangles(shape, scale), 0, true};
    case JPH::EShapeSubType::Empty: return {};
    default:
      if (shape.GetType() == JPH::EShapeType::Convex) {
        return {hull_of(support_points(static_cast<const JPH::ConvexShape&>(shape), scale))};
      }
      throw Error("shapes of this kind have no contacts with meshes");
  }
}

inline std::string name_of(const JPH::Shape& shape) {
  return std::string("Jolt ") + JPH::sSubShapeTypeNames[static_cast<std::size_t>(shape.GetSubType())];
}

/// Volume below the plane { n.x = d } and its first moment, of the tetrahedra that triangles of a closed mesh span with
/// a point of the plane.
struct VolumeBelow {
  Eigen::Vector3d normal;
  double offset;
  double volume = 0;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();

  void add(const std::array<Eigen::Vector3d, 3>& triangle) {
    std::array<Eigen::Vector3d, 4> polygon;
    std::size_t corners = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d &p = triangle[k], &q = triangle[(k + 1) % 3];
      const double height_p = normal.dot(p) - offset, height_q = normal.dot(q) - offset;
      if (height_p <= 0) polygon[corners++] = p;
      if ((height_p < 0 && height_q > 0) || (height_p > 0 && height_q < 0)) {
        polygon[corners++] = p + height_p / (height_p - height_q) * (q - p);
      }
    }
    const Eigen::Vector3d apex = offset * normal;
    for (std::size_t k = 2; k < corners; ++k) {
      const double part = (polygon[0] - apex).dot((polygon[k - 1] - apex).cross(polygon[k] - apex)) / 6;
      volume += part;
      moment += part / 4 * (apex + polygon[0] + polygon[k - 1] + polygon[k]);
    }
  }
};

class Leaves final : public JPH::TransformedShapeCollector {
 public:
  void AddHit(const JPH::TransformedShape& leaf) override { all.push_back(leaf); }
  std::vector<JPH::TransformedShape> all;
};

}  // namespace jolt

inline JoltMesh::JoltMesh(ShapePtr shape, const TriangleMesh& mesh) : shape_(std::move(shape)) {
  if (!shape_) throw Error("Jolt mesh: the shape is null");
  if (const double radius = convex_radius(*shape_); radius > 0) {
    throw Error("Jolt mesh: the shape has a convex radius of " + std::to_string(radius) +
                ", which its mesh has not: use a shape of Jolt's, e.g. JPH::CapsuleShape");
  }
  lease_ = std::make_shared<const FineLease>(*shape_);
  const Eigen::AlignedBox3d box = bounds(mesh), shape_box = world_box(*shape_, Motion{});
  const double rounding = 1e-6 * box.sizes().maxCoeff();
  if (box.isEmpty() || (box.min().array() < shape_box.min().array() - rounding).any() ||
      (box.max().array() > shape_box.max().array() + rounding).any()) {
    throw Error("Jolt mesh: the mesh is not within the box of the shape, and so is not its own");
  }
  JPH::VertexList vertices;
  JPH::IndexedTriangleList triangles;
  vertices.reserve(static_cast<std::size_t>(mesh.vertices.rows()));
  triangles.reserve(static_cast<std::size_t>(mesh.triangles.rows()));
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Eigen::RowVector3f p = mesh.vertices.row(v).cast<float>();
    vertices.push_back({p.x(), p.y(), p.z()});
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto corner = [&](int k) { return static_cast<JPH::uint32>(mesh.triangles(t, k)); };
    triangles.push_back({corner(0), corner(1), corner(2), 0, static_cast<JPH::uint32>(t)});
  }
  JPH::MeshShapeSettings settings(std::move(vertices), std::move(triangles));
  settings.SetEmbedded();
  settings.mPerTriangleUserData = true;
  const JPH::Shape::ShapeResult result = settings.Create();
  if (result.HasError()) throw Error(std::string("Jolt mesh: ") + result.GetError().c_str());
  mesh_shape_ = static_cast<const JPH::MeshShape*>(result.Get().GetPtr());
  jolt_shape_ = mesh_shape_.GetPtr();
  radius_ = 0.5 * box.sizes().norm();
  try {
    mass_ = encage::mass_properties(mesh);
    encloses_ = true;
    radius_ = mass_.radius;
  } catch (const Error&) {  // a surface: its body must not be dynamic unless the user knows its mass
    return;
  }
  jolt_shape_ = new JPH::OffsetCenterOfMassShape(mesh_shape_, jolt::to_jolt(mass_.centre));
}

inline JoltMesh::JoltMesh(const std::filesystem::path& asset)
    : JoltMesh(load_shape(asset), [&] {
        CageHierarchy hierarchy = read_asset(asset);
        if (hierarchy.fine.triangles.rows() == 0) throw Error(asset.string() + ": holds no fine mesh");
        hierarchy.fine.vertices.rowwise() += hierarchy.origin.transpose();
        return std::move(hierarchy.fine);
      }()) {}

inline void JoltMesh::require_volume(const char* what) const {
  if (!encloses_) throw Error(std::string("Jolt mesh: ") + what + ": the mesh encloses no volume");
}

inline JPH::MassProperties JoltMesh::mass_properties(float density, float scale) const {
  require_volume("mass properties");
  const auto size = static_cast<double>(scale), volume = size * size * size;
  JPH::MassProperties result;
  result.mMass = density * static_cast<float>(volume * mass_.mass);
  const Eigen::Matrix3d inertia = static_cast<double>(density) * volume * size * size * mass_.inertia;
  result.mInertia = JPH::Mat44(JPH::Vec4(jolt::to_jolt(inertia.col(0)), 0), JPH::Vec4(jolt::to_jolt(inertia.col(1)), 0),
                               JPH::Vec4(jolt::to_jolt(inertia.col(2)), 0), JPH::Vec4(0, 0, 0, 1));
  return result;
}

inline JPH::BodyCreationSettings JoltMesh::body_settings(JPH::RVec3Arg position, JPH::QuatArg rotation,
                                                         JPH::ObjectLayer layer, float density) const {
  JPH::BodyCreationSettings settings(jolt_shape_, position, rotation, JPH::EMotionType::Dynamic, layer);
  settings.mOverrideMassProperties = JPH::EOverrideMassProperties::MassAndInertiaProvided;
  settings.mMassPropertiesOverride = mass_properties(density);
  settings.mUseManifoldReduction = false;
  return settings;
}

inline JoltSubmersion JoltMesh::submersion(const JPH::Body& body, JPH::RVec3Arg surface, JPH::Vec3Arg normal) const {
  require_volume("submersion");
  // In world axes from the body's centre of mass, where coordinates are small.
  const Eigen::Vector3d up = jolt::to_eigen(normal).normalized();
  const JPH::Vec3 point(surface - body.GetCenterOfMassPosition());
  jolt::VolumeBelow below{up, up.dot(jolt::to_eigen(point))};
  const JPH::Vec3 origin = -(body.GetRotation() * jolt_shape_->GetCenterOfMass());
  jolt::for_each_triangle(*mesh_shape_, origin, body.GetRotation(), JPH::Vec3::sOne(),
                          [&](const auto& triangle) { below.add(triangle); });
  JoltSubmersion result;
  result.total_volume = static_cast<float>(mass_.mass);
  result.submerged_volume = static_cast<float>(std::clamp(below.volume, 0.0, mass_.mass));
  if (below.volume > 0) result.relative_centre = jolt::to_jolt(below.moment / below.volume);
  return result;
}

/// One of Jolt's own shapes as contact_manifold() takes it, about its centre of mass, scaling included.
struct JoltContacts::Partner {
  JPH::RefConst<JPH::Shape> source;  ///< no other can get its address
  ShapePtr shape;                    ///< null if there is nothing to touch
  double radius = 0;                 ///< that rounds the shape
};

/// One of the two shapes of a pair in this step, seen from the first body's centre of mass.
struct JoltContacts::Side {
  ShapePtr shape;  ///< null for a plane, and where there is nothing to touch
  bool is_mesh = false, is_plane = false;
  HalfSpace plane;
  Motion motion;
  double rounding = 0;  ///< radius that rounds the shape
  double radius = 0;    ///< of the whole shape, about its centre
};

/// Points of one region of contact whose normals agree: one manifold.
struct JoltContacts::Group {
  int id = -1;
  int count = 0;
  std::array<int, most_manifold_points> points{};
  std::array<std::uint64_t, most_manifold_points> features{};
  Eigen::Vector3d first_normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< sum over the points
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the points, in the first body's frame
  int patch = 0;
};

/// The memory of one pair of shapes.
struct JoltContacts::Pair {
  ManifoldCache cache;
  std::vector<ManifoldPoint> points;  ///< room for all
  std::size_t count = 0;
  std::vector<Group> groups, before;
  std::array<const Shape*, 2> last{};  ///< shapes of the last query
  std::array<std::shared_ptr<const Partner>, 2> partners;
  std::array<JPH::Vec3, 2> partner_scales;
  std::uint64_t forgotten = 0;
  std::uint64_t used = 0;  ///< last step
};

/// Two bodies in this step.
struct JoltContacts::Step {
  const JPH::Body& body_1;
  const JPH::Body& body_2;
  JPH::Mat44 at_1, at_2;
  JPH::CollideShapeSettings& settings;
  JPH::CollideShapeCollector& collector;
  const JPH::ShapeFilter& filter;
  double dt;   ///< 0 if they only count as touching when they do
  double way;  ///< bounds how far surfaces approach each other
};

inline JoltContacts::JoltContacts(JPH::PhysicsSystem& system, const JoltContactOptions& options)
    : system_(system), options_(options), former_(system.GetSimCollideBodyVsBody()) {
  const auto check = [](const char* name, double value, double least, double most) {
    if (value >= least && value <= most) return;
    throw Error("Jolt contacts: " + std::string(name) + " is " + std::to_string(value) + ", it has to be " +
                std::to_string(least) + " to " + std::to_string(most));
  };
  check("skin", options.skin, 0, 1);
  check("most_speculation", options.most_speculation, 0, 1000);
  check("most_points", options.most_points, 1, most_groups);
  check("most_per_patch", options.most_per_patch, 1, most_manifold_points);
  system_.SetSimCollideBodyVsBody(
      [this](const JPH::Body& body_1, const JPH::Body& body_2, JPH::Mat44Arg at_1, JPH::Mat44Arg at_2,
             JPH::CollideShapeSettings& settings, JPH::CollideShapeCollector& collector,
             const JPH::ShapeFilter& filter) { collide(body_1, body_2, at_1, at_2, settings, collector, filter); });
  system_.AddStepListener(this);
}

inline JoltContacts::~JoltContacts() {
  system_.RemoveStepListener(this);
  system_.SetSimCollideBodyVsBody(former_);
}

inline void JoltContacts::add(const JoltMesh& mesh) { meshes_.insert_or_assign(&mesh.mesh_shape(), mesh); }

inline void JoltContacts::remove(const JoltMesh& mesh) noexcept { meshes_.erase(&mesh.mesh_shape()); }

inline void JoltContacts::forget(const JPH::Shape& shape) {
  ++forgotten_;
  std::erase_if(partners_, [&](const auto& entry) { return std::get<0>(entry.first) == &shape; });
}

inline std::vector<std::string> JoltContacts::take_errors() {
  const std::scoped_lock lock(error_mutex_);
  return std::exchange(errors_, {});
}

inline void JoltContacts::note(const std::string& error) {
  const std::scoped_lock lock(error_mutex_);
  if (std::find(known_errors_.begin(), known_errors_.end(), error) != known_errors_.end()) return;
  known_errors_.push_back(error);
  errors_.push_back(error);
}

inline void JoltContacts::OnStep(const JPH::PhysicsStepListenerContext& context) {
  dt_ = context.mDeltaTime;
  if (++step_ % clean_every != 0) return;
  const JPH::BodyLockInterface& bodies = system_.GetBodyLockInterfaceNoLock();
  const auto is_gone = [&](std::uint32_t id) { return bodies.TryGetBody(JPH::BodyID(id)) == nullptr; };
  for (Shard& shard : shards_) {
    std::erase_if(shard.pairs, [&](const auto& entry) {
      return entry.second->used + keep_for < step_ || is_gone(entry.first.body_1) || is_gone(entry.first.body_2);
    });
  }
  std::erase_if(partners_, [](const auto& entry) {
    return entry.second.use_count() == 1 && entry.second->source->GetRefCount() == 1;
  });
}

inline bool JoltContacts::has_mesh(const JPH::Shape& shape) const {
  switch (shape.GetType()) {
    case JPH::EShapeType::Mesh: return meshes_.contains(&shape);
    case JPH::EShapeType::Decorated: return has_mesh(*static_cast<const JPH::DecoratedShape&>(shape).GetInnerShape());
    case JPH::EShapeType::Compound: {
      const auto& parts = static_cast<const JPH::CompoundShape&>(shape).GetSubShapes();
      return std::any_of(parts.begin(), parts.end(), [this](const auto& part) { return has_mesh(*part.mShape); });
    }
    default: return false;
  }
}

inline void JoltContacts::collide(const JPH::Body& body_1, const JPH::Body& body_2, JPH::Mat44Arg at_1,
                                  JPH::Mat44Arg at_2, JPH::CollideShapeSettings& settings,
                                  JPH::CollideShapeCollector& collector, const JPH::ShapeFilter& filter) {
  const JPH::Shape &shape_1 = *body_1.GetShape(), &shape_2 = *body_2.GetShape();
  if (!has_mesh(shape_1) && !has_mesh(shape_2)) {
    former_(body_1, body_2, at_1, at_2, settings, collector, filter);
    return;
  }
  if (!filter.ShouldCollide(&shape_1, JPH::SubShapeID(), &shape_2, JPH::SubShapeID())) return;
  const auto velocity = [](const JPH::Body& body) {
    return body.IsStatic() ? JPH::Vec3::sZero() : body.GetLinearVelocity();
  };
  const auto speed = [](const JPH::Body& body) {
    return body.IsStatic() ? 0.0 : static_cast<double>(body.GetAngularVelocity().Length());
  };
  Step step{body_1, body_2, at_1, at_2, settings, collector, filter, 0, 0};
  if (!body_1.IsSensor() && !body_2.IsSensor()) {
    step.dt = static_cast<double>(dt_);
    const auto apart = static_cast<double>((at_2.GetTranslation() - at_1.GetTranslation()).Length());
    const double reach_1 = jolt::reach_of(shape_1), reach_2 = jolt::reach_of(shape_2);
    step.way = step.dt * (static_cast<double>((velocity(body_1) - velocity(body_2)).Length()) +
                          speed(body_1) * std::min(reach_1, apart + reach_2) +
                          speed(body_2) * std::min(reach_2, apart + reach_1));
  }
  // Exceptions must not pass through Jolt, which is compiled without.
  try {
    thread_local jolt::Leaves leaves_1, leaves_2;
    const auto leaves = [&](jolt::Leaves& into, const JPH::Shape& shape, JPH::Mat44Arg at, const JPH::Body& body,
                            const JPH::Shape& other, JPH::Mat44Arg at_other) {
      JPH::AABox box = other.GetWorldSpaceBounds(at_other, JPH::Vec3::sOne());
      box.ExpandBy(JPH::Vec3::sReplicate(settings.mMaxSeparationDistance + static_cast<float>(step.way)));
      into.all.clear();
      shape.CollectTransformedShapes(box, at.GetTranslation(), body.GetRotation(), JPH::Vec3::sOne(),
                                     JPH::SubShapeIDCreator(), into, filter);
    };
    leaves(leaves_1, shape_1, at_1, body_1, shape_2, at_2);
    leaves(leaves_2, shape_2, at_2, body_2, shape_1, at_1);
    for (const JPH::TransformedShape& leaf_1 : leaves_1.all) {
      for (const JPH::TransformedShape& leaf_2 : leaves_2.all) {
        if (!collector.ShouldEarlyOut()) collide_leaves(step, leaf_1, leaf_2);
      }
    }
    leaves_1.all.clear();
    leaves_2.all.clear();
  } catch (const std::exception& error) {
    note(error.what());
  }
}

inline void JoltContacts::collide_leaves(const Step& step, const JPH::TransformedShape& leaf_1,
                                         const JPH::TransformedShape& leaf_2) {
  const JPH::SubShapeID id_1 = leaf_1.mSubShapeIDCreator.GetID(), id_2 = leaf_2.mSubShapeIDCreator.GetID();
  if (!meshes_.contains(leaf_1.mShape) && !meshes_.contains(leaf_2.mShape)) {
    JPH::CollisionDispatch::sCollideShapeVsShape(leaf_1.mShape, leaf_2.mShape, leaf_1.GetShapeScale(),
                                                 leaf_2.GetShapeScale(), leaf_1.GetCenterOfMassTransform().ToMat44(),
                                                 leaf_2.GetCenterOfMassTransform().ToMat44(), leaf_1.mSubShapeIDCreator,
                                                 leaf_2.mSubShapeIDCreator, step.settings, step.collector, step.filter);
    return;
  }
  if (!step.filter.ShouldCollide(leaf_1.mShape, id_1, leaf_2.mShape, id_2)) return;

  Pair& memory = pair({step.body_1.GetID().GetIndexAndSequenceNumber(), step.body_2.GetID().GetIndexAndSequenceNumber(),
                       id_1.GetValue(), id_2.GetValue()});
  memory.used = step_;
  if (memory.forgotten != forgotten_) {
    memory.partners = {};
    memory.forgotten = forgotten_;
  }
  std::array<Side, 2> sides = {side(memory, 0, leaf_1), side(memory, 1, leaf_2)};
  const double smaller = std::min(sides[0].radius, sides[1].radius);
  double margin = 0;
  if (step.dt > 0) {
    const double most = options_.most_speculation * smaller;
    const double ahead = step.way > most ? step.dt * most / step.way : step.dt;
    const auto move = [&](Motion& motion, const JPH::Body& body, JPH::Vec3Arg centre_of_mass) {
      if (body.IsStatic()) return;
      constexpr double largest_turn = 2;  // queries accept less than half a turn
      const Eigen::Vector3d turn = ahead * jolt::to_eigen(body.GetAngularVelocity()),
                            centre = jolt::to_eigen(centre_of_mass);
      if (const double angle = turn.norm(); angle > 0) {
        const Eigen::Matrix3d rotation =
            Eigen::AngleAxisd(std::min(angle, largest_turn), turn / angle).toRotationMatrix();
        motion.end.linear() = rotation * motion.start.linear();
        motion.end.translation() = centre + rotation * (motion.start.translation() - centre);
      }
      motion.end.translation() += ahead * jolt::to_eigen(body.GetLinearVelocity());
    };
    if (step.way > 0) {
      move(sides[0].motion, step.body_1, step.at_1.GetTranslation());
      move(sides[1].motion, step.body_2, step.at_2.GetTranslation());
    }
    // Jolt reuses contacts of bodies that have hardly moved, and the lack of contacts as well.
    const JPH::PhysicsSettings& settings = system_.GetPhysicsSettings();
    const double reused = settings.mUseBodyPairContactCache
                              ? 2 * std::sqrt(static_cast<double>(settings.mBodyPairCacheMaxDeltaPositionSq))
                              : 0;
    margin =
        std::min(std::max(options_.skin * smaller, reused), static_cast<double>(step.settings.mMaxSeparationDistance));
  }
  query(memory, sides, margin);
  group(memory, step, 0.03 * smaller);
  report(memory, step, sides, leaf_1, leaf_2);
}

inline JoltContacts::Pair& JoltContacts::pair(const PairKey& key) {
  // A pair is in one thread's hands at a time, and pairs that others add do not move it.
  Shard& shard = shards_[PairHash()(key) % shard_count];
  const std::scoped_lock lock(shard.mutex);
  std::unique_ptr<Pair>& entry = shard.pairs[key];
  if (!entry) {
    entry = std::make_unique<Pair>();
    entry->points.resize(static_cast<std::size_t>(options_.most_points));
    entry->groups.reserve(entry->points.size());
    entry->before.reserve(entry->points.size());
  }
  return *entry;
}

inline std::shared_ptr<const JoltContacts::Partner> JoltContacts::partner(const JPH::Shape& shape, JPH::Vec3Arg scale) {
  const std::scoped_lock lock(partner_mutex_);
  std::shared_ptr<const Partner>& entry = partners_[{&shape, scale.GetX(), scale.GetY(), scale.GetZ()}];
  if (entry) return entry;
  auto made = std::make_shared<Partner>();
  made->source = &shape;
  try {
    const jolt::Rounded rounded = jolt::round_shape(shape, scale);
    if (rounded.mesh.triangles.rows() > 0) made->shape = make_shape(rounded.mesh, {.hollow = rounded.hollow});
    made->radius = rounded.radius;
  } catch (const std::exception& error) {
    note(jolt::name_of(shape) + ": " + error.what());
  }
  entry = std::move(made);
  return entry;
}

inline JoltContacts::Side JoltContacts::side(Pair& pair, std::size_t index, const JPH::TransformedShape& leaf) {
  const JPH::Shape& shape = *leaf.mShape;
  const JPH::Vec3 scale = leaf.GetShapeScale();
  const Eigen::Isometry3d pose = jolt::to_eigen(JPH::Vec3(leaf.mShapePositionCOM), leaf.mShapeRotation);
  Side side;
  if (const auto mesh = meshes_.find(&shape); mesh != meshes_.end()) {
    const auto size = static_cast<double>(scale.GetX());
    if (!(scale == JPH::Vec3::sReplicate(scale.GetX())) || !(size > 0)) {
      throw Error("Jolt mesh: its scale has to be one positive factor for all axes");
    }
    side.shape = mesh->second.shape();
    side.is_mesh = true;
    side.motion = Motion::resting(pose, size);
    side.radius = size * mesh->second.radius();
    return side;
  }
  if (shape.GetSubType() == JPH::EShapeSubType::Plane) {
    JPH::Plane plane = static_cast<const JPH::PlaneShape&>(shape).GetPlane().Scaled(scale);
    side.is_plane = true;
    const Eigen::Vector3d normal = jolt::to_eigen(plane.GetNormal());
    side.plane.normal = (pose.linear() * normal).normalized();
    side.plane.offset =
        side.plane.normal.dot(pose.translation()) - static_cast<double>(plane.GetConstant()) / normal.norm();
    side.radius = std::numeric_limits<double>::infinity();
    return side;
  }
  std::shared_ptr<const Partner>& known = pair.partners[index];
  if (!known || known->source != &shape || pair.partner_scales[index] != scale) {
    known = partner(shape, scale);
    pair.partner_scales[index] = scale;
  }
  side.shape = known->shape;
  side.motion = Motion::resting(pose);
  side.rounding = known->radius;
  side.radius = jolt::reach_of(shape, scale);
  return side;
}

/// Finds the points of the pair, from the first side to the second one.
inline void JoltContacts::query(Pair& pair, const std::array<Side, 2>& sides, double margin) const {
  pair.count = 0;
  const Side &a = sides[0], &b = sides[1];
  const std::array<const Shape*, 2> shapes = {a.shape.get(), b.shape.get()};
  if (shapes != pair.last) pair.cache.clear();
  pair.last = shapes;
  const auto usable = [](const Side& side) { return side.is_plane || (side.shape && is_usable(side.motion)); };
  if (!usable(a) || !usable(b)) return;
  ManifoldOptions options{.margin = margin,
                          .radius_a = a.rounding,
                          .radius_b = b.rounding,
                          .most_points = options_.most_points,
                          .most_per_patch = options_.most_per_patch};
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

/// Makes groups of the points, each with the number of the group of the step before that it continues.
inline void JoltContacts::group(Pair& pair, const Step& step, double nearness) const {
  std::swap(pair.groups, pair.before);
  std::vector<Group>& groups = pair.groups;
  groups.clear();
  const auto same_way = static_cast<double>(system_.GetPhysicsSettings().mContactNormalCosMaxDeltaRotation);
  const Eigen::Isometry3d to_body = jolt::to_eigen(step.at_1.GetTranslation(), step.body_1.GetRotation()).inverse();
  for (std::size_t i = 0; i < pair.count; ++i) {
    const ManifoldPoint& point = pair.points[i];
    const auto fits = [&](const Group& group) {
      return group.patch == point.patch && group.count < most_manifold_points &&
             group.first_normal.dot(point.normal) >= same_way;
    };
    auto into = std::find_if(groups.begin(), groups.end(), fits);
    if (into == groups.end()) {
      into = groups.emplace(groups.end());
      into->patch = point.patch;
      into->first_normal = point.normal;
    }
    into->points[static_cast<std::size_t>(into->count)] = static_cast<int>(i);
    into->features[static_cast<std::size_t>(into->count)] = point.feature;
    ++into->count;
    into->normal += point.normal;
    into->centre += to_body * point.point_a;
  }

  std::array<bool, std::size_t{1} << group_bits> used{};
  const auto continues = [&](Group& group, const Group& before) {
    group.id = before.id;
    used[static_cast<std::size_t>(before.id)] = true;
  };
  const auto free = [&](const Group& before) { return !used[static_cast<std::size_t>(before.id)]; };
  for (Group& group : groups) {
    group.centre /= group.count;
    const Group* best = nullptr;
    int most = 0;
    for (const Group& before : pair.before) {
      if (!free(before)) continue;
      const auto begin = group.features.begin(), end = begin + group.count;
      const auto shared =
          static_cast<int>(std::count_if(before.features.begin(), before.features.begin() + before.count,
                                         [&](std::uint64_t feature) { return std::find(begin, end, feature) != end; }));
      if (shared <= most) continue;
      most = shared;
      best = &before;
    }
    if (best != nullptr) continues(group, *best);
  }
  for (Group& group : groups) {
    if (group.id >= 0) continue;
    const Group* best = nullptr;
    double least = nearness * nearness;
    for (const Group& before : pair.before) {
      const double squared = (before.centre - group.centre).squaredNorm();
      if (!free(before) || squared > least || before.first_normal.dot(group.first_normal) < 0.9) continue;
      least = squared;
      best = &before;
    }
    if (best != nullptr) continues(group, *best);
  }
  // What ends and what begins are different contacts, so they have different numbers.
  for (int pass = 0; pass < 2; ++pass) {
    if (pass == 0) {
      for (const Group& before : pair.before) used[static_cast<std::size_t>(before.id)] = true;
    }
    for (Group& group : groups) {
      if (group.id >= 0) continue;
      const auto last = used.begin() + most_groups;
      const auto unused = std::find(used.begin(), last, false);
      if (unused == last) break;
      *unused = true;
      group.id = static_cast<int>(unused - used.begin());
    }
    if (pass == 0) {
      used = {};
      for (const Group& group : groups) {
        if (group.id >= 0) used[static_cast<std::size_t>(group.id)] = true;
      }
    }
  }
  std::sort(groups.begin(), groups.end(), [](const Group& a, const Group& b) { return a.id < b.id; });
}

inline void JoltContacts::report(const Pair& pair, const Step& step, const std::array<Side, 2>& sides,
                                 const JPH::TransformedShape& leaf_1, const JPH::TransformedShape& leaf_2) const {
  const bool merges =
      system_.GetPhysicsSettings().mUseManifoldReduction && step.body_1.GetUseManifoldReductionWithBody(step.body_2);
  const auto id_of = [](const Side& side, const JPH::TransformedShape& leaf, const Group& group, int slot) {
    const JPH::SubShapeIDCreator& path = leaf.mSubShapeIDCreator;
    if (!side.is_mesh) return path.GetID();
    const JPH::uint bits =
        std::min(JPH::uint{group_bits + slot_bits}, JPH::SubShapeID::MaxBits - path.GetNumBitsWritten());
    const auto value = static_cast<JPH::uint>(slot << group_bits | group.id);
    return path.PushID(value & ((JPH::uint{1} << bits) - 1), bits).GetID();
  };
  for (const Group& group : pair.groups) {
    const std::span<const int> members = std::span(group.points).first(static_cast<std::size_t>(group.count));
    const auto point = [&](int i) -> const ManifoldPoint& { return pair.points[static_cast<std::size_t>(i)]; };
    const Eigen::Vector3d axis = -group.normal.normalized();
    // Where the point is on the first body, and as far away as the separation says, along the axis.
    const auto hit = [&](int i, int slot) {
      const ManifoldPoint& p = point(i);
      const Eigen::Vector3d middle = 0.5 * (p.point_a + p.point_b), half = 0.5 * p.separation * axis;
      return JPH::CollideShapeResult(jolt::to_jolt(middle - half), jolt::to_jolt(middle + half), jolt::to_jolt(axis),
                                     static_cast<float>(-p.separation), id_of(sides[0], leaf_1, group, slot),
                                     id_of(sides[1], leaf_2, group, slot), step.body_2.GetID());
    };
    if (merges) {
      // Hits of one normal become one manifold, with every hit's point as it is.
      for (const int i : members) {
        if (!step.collector.ShouldEarlyOut()) step.collector.AddHit(hit(i, 0));
      }
      continue;
    }
    // A hit becomes a manifold: what is left of the second face when it is clipped by the first one. Points that are
    // farther apart than Jolt looks for would be dropped, so they become manifolds of their own.
    std::array<int, most_manifold_points> near{}, far{};
    std::size_t near_count = 0, far_count = 0;
    for (const int i : members) {
      const bool is_near = point(i).separation <= static_cast<double>(step.settings.mMaxSeparationDistance);
      (is_near ? near[near_count++] : far[far_count++]) = i;
    }
    int slot = 0;
    if (near_count > 0) {
      const auto deepest = std::min_element(near.begin(), near.begin() + near_count,
                                            [&](int i, int j) { return point(i).separation < point(j).separation; });
      JPH::CollideShapeResult result = hit(*deepest, slot++);
      if (near_count > 1) {
        // The first face is a square across the axis, large enough that no point is near its edges.
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < near_count; ++k) {
          centre += 0.5 / static_cast<double>(near_count) * (point(near[k]).point_a + point(near[k]).point_b);
        }
        double size = 0;
        for (std::size_t k = 0; k < near_count; ++k) {
          const Eigen::Vector3d middle = 0.5 * (point(near[k]).point_a + point(near[k]).point_b);
          const Eigen::Vector3d across = middle - centre - axis.dot(middle - centre) * axis;
          size = std::max(size, across.norm());
          result.mShape2Face.push_back(jolt::to_jolt(centre + across + point(near[k]).separation * axis));
        }
        size = 4 * std::max(size, static_cast<double>(step.settings.mMaxSeparationDistance));
        const Eigen::Vector3d u = size * axis.unitOrthogonal(), v = axis.cross(u);
        for (const Eigen::Vector3d& corner :
             {Eigen::Vector3d(-u - v), Eigen::Vector3d(u - v), Eigen::Vector3d(u + v), Eigen::Vector3d(v - u)}) {
          result.mShape1Face.push_back(jolt::to_jolt(centre + corner));
        }
      }
      if (!step.collector.ShouldEarlyOut()) step.collector.AddHit(result);
    }
    for (std::size_t k = 0; k < far_count; ++k) {
      if (!step.collector.ShouldEarlyOut()) step.collector.AddHit(hit(far[k], slot++));
    }
  }
}

}  // namespace encage
