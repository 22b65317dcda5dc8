// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/adapters/bullet/mesh_source.h"
#include "broadphase/shape/shape.h"
#include "src/tree/visit.h"

#include <encage/bullet_mesh.h>
#include <encage/primitives.h>
#include <encage/queries.h>

#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

namespace encage {
namespace {

/// A fine mesh in the frame of its shape: x -> pose * (scale * (origin + x)) for x in the local frame.
struct PlacedSurface {
  const SimpleShape* shape;
  Eigen::Isometry3d pose;
  double scale;
  std::int32_t first_triangle;

  Eigen::Vector3d vertex(std::int32_t v) const {
    return pose * (scale * (shape->frame.origin + shape->fine.vertex(v)));
  }
};

/// Calls f for the mesh, or those of all parts in order.
template <class F>
void for_each_surface(const Shape& shape, F&& f) {
  if (!shape.is_compound()) {
    f(PlacedSurface{&shape.simple(), Eigen::Isometry3d::Identity(), 1, 0});
    return;
  }
  for (const ShapePart& part : shape.compound().parts) {
    f(PlacedSurface{part.shape.get(), part.pose, part.scale, part.first_triangle});
  }
}

std::vector<FineLease> lease_all(const Shape& shape) {
  std::vector<FineLease> leases;
  for_each_surface(shape, [&](const PlacedSurface& surface) {
    if (!surface.shape->has_fine()) {
      throw Error("Bullet mesh: " +
                  (shape.is_compound() ? "part " + std::to_string(leases.size()) + " of the compound"
                                       : std::string("the shape")) +
                  " has no fine mesh");
    }
    leases.emplace_back(*surface.shape);
  });
  return leases;
}

/// The triangles of the whole shape, without the vertices that belong to none.
TriangleMesh copy_fine(const Shape& shape) {
  TriangleMesh mesh;
  for_each_surface(shape, [&](const PlacedSurface& surface) {
    const MeshView& fine = surface.shape->fine.mesh;
    const Eigen::Index first = mesh.vertices.rows(), begin = mesh.triangles.rows();
    mesh.vertices.conservativeResize(first + static_cast<Eigen::Index>(fine.vertices.size()), 3);
    mesh.triangles.conservativeResize(begin + static_cast<Eigen::Index>(fine.triangles.size()), 3);
    for (std::size_t v = 0; v < fine.vertices.size(); ++v) {
      mesh.vertices.row(first + static_cast<Eigen::Index>(v)) =
          surface.vertex(static_cast<std::int32_t>(v)).transpose();
    }
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        mesh.triangles(begin + static_cast<Eigen::Index>(t), k) =
            static_cast<std::int32_t>(first) +
            static_cast<std::int32_t>(fine.triangles[t][static_cast<std::size_t>(k)]);
      }
    }
  });
  return mesh;
}

/// Mass properties in another frame: x -> to * x.
MassProperties moved(const MassProperties& mass, const Eigen::Isometry3d& to) {
  MassProperties result = mass;
  result.centre = to * mass.centre;
  result.inertia = to.linear() * mass.inertia * to.linear().transpose();
  result.axes = to.linear() * mass.axes;
  return result;
}

btScalar rounded_down(double x) {
  const auto rounded = static_cast<btScalar>(x);
  return static_cast<double>(rounded) > x ? std::nextafter(rounded, -std::numeric_limits<btScalar>::infinity())
                                          : rounded;
}
btScalar rounded_up(double x) { return -rounded_down(-x); }

btVector3 rounded_down(const Eigen::Vector3d& v) {
  return {rounded_down(v.x()), rounded_down(v.y()), rounded_down(v.z())};
}
btVector3 rounded_up(const Eigen::Vector3d& v) { return {rounded_up(v.x()), rounded_up(v.y()), rounded_up(v.z())}; }

/// An axis-aligned box in the local frame of a surface.
class Region {
 public:
  Region(const Eigen::AffineCompact3d& to_local, const Eigen::AlignedBox3d& box)
      : centre_(to_local * box.center()), half_(to_local.linear().cwiseAbs() * (0.5 * box.sizes())) {}

  /// False only if the region is farther than the slack from the box.
  bool meets(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double slack) const {
    const Eigen::Vector3d apart = centre_ - 0.5 * (low + high);
    const Eigen::Vector3d half = (0.5 * (high - low)).array() + slack;
    return (apart.cwiseAbs().array() <= (half + half_).array()).all();
  }

 private:
  Eigen::Vector3d centre_, half_;
};

/// Reports what a ray meets, as btTriangleRaycastCallback::processTriangle() does, to callbacks that shorten the ray
/// and to others. The ray is in the frame in which the motion places the shape.
void report_hits(const Shape& shape, const Motion& motion, btTriangleRaycastCallback& callback) {
  const Ray ray{.origin = bullet::to_eigen(callback.m_from),
                .direction = bullet::to_eigen(callback.m_to) - bullet::to_eigen(callback.m_from),
                .t_max = static_cast<double>(callback.m_hitFraction)};
  const bool front_only = (callback.m_flags & btTriangleRaycastCallback::kF_FilterBackfaces) != 0;
  const RayOptions options{front_only ? BackFaces::ignore : BackFaces::hit};
  const auto report = [&](const RayHit& hit) {
    const auto t = static_cast<btScalar>(hit.t);
    if (!(t < callback.m_hitFraction) || hit.normal.isZero(0)) return;  // degenerate triangles have neighbours
    const bool keep = (callback.m_flags & btTriangleRaycastCallback::kF_KeepUnflippedNormal) != 0;
    const Eigen::Vector3d normal = hit.back_face && !keep ? Eigen::Vector3d(-hit.normal) : hit.normal;
    callback.m_hitFraction = callback.reportHit(bullet::to_bullet(normal), t, 0, hit.triangle);
  };
  const RayResult first = cast_ray(shape, motion, ray, options);
  if (first.answer != RayAnswer::hit) return;
  report(first.hit);
  if (static_cast<double>(callback.m_hitFraction) <= first.hit.t) return;
  for_each_hit(shape, motion, ray, options, [&](const RayHit& hit) {
    if (hit.triangle != first.hit.triangle) report(hit);
    return true;
  });
}

/// Bullet's triangles are rounded to btScalar: a ray that just misses a box may hit the rounded triangle.
double rounding_slack(const Surface& surface, const Eigen::AffineCompact3d& to_local) {
  return 16 * bullet::unit_roundoff * (surface.radius + to_local.translation().norm());
}

}  // namespace

BulletMeshShape::BulletMeshShape(ShapePtr shape, const BulletMeshShapeOptions& options) : shape_(std::move(shape)) {
  m_shapeType = CUSTOM_CONCAVE_SHAPE_TYPE;
  m_collisionMargin = 0;
  if (!shape_) throw Error("Bullet mesh: the shape is null");
  if (!(options.reach >= 0 && std::isfinite(options.reach))) {
    throw Error("Bullet mesh: reach " + std::to_string(options.reach) + " has to be finite and >= 0");
  }
  if (const double radius = convex_radius(*shape_); radius > 0) {
    throw Error("Bullet mesh: the shape has a convex radius of " + std::to_string(radius) +
                ", which its mesh has not: use a shape of Bullet's, e.g. btCapsuleShape");
  }
  leases_ = lease_all(*shape_);
  const TriangleMesh mesh = copy_fine(*shape_);
  try {
    mass_ = encage::mass_properties(mesh);
    encloses_ = true;
  } catch (const Error&) {
    if (options.frame == BulletFrame::principal) throw;
  }
  if (options.frame == BulletFrame::principal) {
    asset_to_body_.linear() = mass_.axes.transpose();
    asset_to_body_.translation() = -(mass_.axes.transpose() * mass_.centre);
  }
  mass_ = moved(mass_, asset_to_body_);
  for (const std::int32_t v : mesh.triangles.reshaped()) {
    const Eigen::Vector3d x = asset_to_body_ * mesh.vertex(v);
    box_.extend(x);
    reach_ = std::max(reach_, x.norm());
  }
  box_growth_ = options.reach * reach_;
}

BulletMeshShape::BulletMeshShape(const std::filesystem::path& file, const TriangleMesh& source,
                                 const BulletMeshShapeOptions& options)
    : BulletMeshShape((require_source(file, source), load_shape(file)), options) {}

BulletMeshShape::BulletMeshShape(const std::filesystem::path& file, const btStridingMeshInterface& source,
                                 const BulletMeshShapeOptions& options)
    : BulletMeshShape(file, bullet::copy_source(source), options) {}

BulletMeshShape::~BulletMeshShape() = default;

double BulletMeshShape::radius() const noexcept { return scale_ * reach_ + static_cast<double>(m_collisionMargin); }

Motion BulletMeshShape::motion(const btTransform& body) const noexcept {
  Eigen::Isometry3d scaled = asset_to_body_;
  scaled.translation() *= scale_;
  return Motion::resting(bullet::to_isometry(body) * scaled, scale_);
}

MassProperties BulletMeshShape::mass_properties() const {
  if (!encloses_) throw Error("Bullet mesh: mass properties: the mesh encloses no volume");
  MassProperties scaled = mass_;
  const double squared = scale_ * scale_;
  scaled.mass *= squared * scale_;
  scaled.centre *= scale_;
  scaled.inertia *= squared * squared * scale_;
  scaled.moments *= squared * squared * scale_;
  scaled.radius *= scale_;
  return scaled;
}

void BulletMeshShape::getAabb(const btTransform& body, btVector3& low, btVector3& high) const {
  const Motion at = motion(body);
  const double margin = static_cast<double>(m_collisionMargin) + scale_ * box_growth_;
  if (is_usable(at)) {
    const Eigen::AlignedBox3d box = world_box(*shape_, at);
    low = rounded_down(box.min().array() - margin);
    high = rounded_up(box.max().array() + margin);
  } else {
    // Bullet shall see where the body is, whatever became of its basis.
    btTransformAabb(bullet::to_bullet(scale_ * box_.min()), bullet::to_bullet(scale_ * box_.max()),
                    static_cast<btScalar>(margin), body, low, high);
  }
}

void BulletMeshShape::setLocalScaling(const btVector3& scaling) {
  const Eigen::Vector3d factors = bullet::to_eigen(scaling);
  if (!(factors.x() == factors.y() && factors.y() == factors.z() && factors.x() > 0 && factors.allFinite())) {
    std::ostringstream message;
    message << "Bullet mesh: local scaling (" << factors.transpose() << ") has to be one positive factor for all axes";
    throw Error(message.str());
  }
  scaling_ = scaling;
  scale_ = factors.x();
}

void BulletMeshShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const {
  Eigen::Vector3d per_mass;
  if (encloses_) {
    per_mass = mass_.inertia.diagonal() / mass_.mass;
  } else {
    const Eigen::Vector3d squares = box_.sizes().cwiseAbs2() / 12;
    per_mass = squares.sum() - squares.array();
  }
  inertia = bullet::to_bullet(static_cast<double>(mass) * scale_ * scale_ * per_mass);
}

void BulletMeshShape::processAllTriangles(btTriangleCallback* callback, const btVector3& low,
                                          const btVector3& high) const {
  if (auto* const ray = dynamic_cast<btTriangleRaycastCallback*>(callback)) {
    report_hits(*shape_, motion(btTransform::getIdentity()), *ray);
    return;
  }
  const Eigen::AlignedBox3d box(bullet::to_eigen(low), bullet::to_eigen(high));
  const Eigen::Affine3d asset_to_body = Eigen::Scaling(scale_) * Eigen::Affine3d(asset_to_body_);
  for_each_surface(*shape_, [&](const PlacedSurface& placed) {
    const Surface& surface = placed.shape->fine;
    const Eigen::Affine3d to_body =
        asset_to_body * placed.pose * Eigen::Scaling(placed.scale) * Eigen::Translation3d(placed.shape->frame.origin);
    const Eigen::AffineCompact3d to_local(to_body.inverse());
    const double slack = rounding_slack(surface, to_local);
    const Region wanted(to_local, box);
    visit_nodes(surface.tree, [&](const MeshNode& node, auto descend) {
      for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
        Eigen::Vector3d lower, upper;
        for (int k = 0; k < 3; ++k) {
          lower[k] = surface.tree.lower(node, k, lane);
          upper[k] = surface.tree.upper(node, k, lane);
        }
        if (!wanted.meets(lower, upper, slack)) continue;
        if (node.count(lane) == MeshNode::inner) {
          descend(node.child(lane));
          continue;
        }
        const auto count = static_cast<std::size_t>(node.count(lane));
        for (const LeafTriangle& leaf :
             surface.tree.leaves.subspan(static_cast<std::size_t>(node.child(lane)), count)) {
          std::array<btVector3, 3> triangle;
          for (std::size_t k = 0; k < 3; ++k) {
            triangle[k] = bullet::to_bullet(to_body * surface.vertex(leaf.vertices[k]));
          }
          callback->processTriangle(triangle.data(), 0, placed.first_triangle + leaf.triangle);
        }
      }
      return true;
    });
  });
}

}  // namespace encage
