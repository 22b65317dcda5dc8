// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/gimpact_mesh.h"

#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/shape/shape.h"

#include <encage/error.h>
#include <encage/fine_lease.h>

#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

namespace encage::bullet {
namespace {

/// Locks a part: its vertices and triangles may be read while this object lives.
class Locked {
 public:
  explicit Locked(const btGImpactMeshShapePart& part) : part_(part) { part_.lockChildShapes(); }
  ~Locked() { part_.unlockChildShapes(); }
  Locked(const Locked&) = delete;
  Locked& operator=(const Locked&) = delete;

 private:
  const btGImpactMeshShapePart& part_;
};

/// Upper bound of the largest distance of a point of the box from the triangle. That distance is convex, hence largest
/// in a corner, and no more than the distance to any one point of the triangle.
double reach_of(const Eigen::AlignedBox3d& box, const std::array<Eigen::Vector3d, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const std::array<Eigen::Vector3d, 7> points = {a, b, c, (a + b) / 2, (b + c) / 2, (c + a) / 2, (a + b + c) / 3};
  double reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d x = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : points) nearest = std::min(nearest, (x - p).norm());
    reach = std::max(reach, nearest);
  }
  return reach;
}

double distance_from_centroid(const Eigen::Vector3d& x, const std::array<Eigen::Vector3d, 3>& triangle) {
  return (x - (triangle[0] + triangle[1] + triangle[2]) / 3).norm();
}

/// Returns how far the box of a triangle reaches beyond the fine mesh's triangle of the same number.
double growth_of(const Eigen::AlignedBox3d& box, int triangle, const GImpactMesh& measured, const SimpleShape& shape) {
  const auto number = static_cast<std::size_t>(triangle);
  if (number >= shape.fine.mesh.triangles.size()) return std::numeric_limits<double>::infinity();
  Eigen::AlignedBox3d fine;
  for (const std::uint32_t v : shape.fine.mesh.triangles[number]) {
    fine.extend(measured.scale * (shape.frame.origin + shape.fine.vertex(static_cast<std::int32_t>(v))));
  }
  return std::max((fine.min() - box.min()).maxCoeff(), (box.max() - fine.max()).maxCoeff());
}

void measure_boxes(const btGImpactMeshShapePart& part, const SimpleShape& shape, GImpactMesh& measured) {
  const btGImpactBoxSet& tree = *part.getBoxSet();
  for (int node = 0; node < tree.getNodeCount(); ++node) {
    if (!tree.isLeafNode(node)) continue;
    btAABB bound;
    tree.getNodeBound(node, bound);
    btPrimitiveTriangle t;
    part.getPrimitiveTriangle(tree.getNodeData(node), t);
    const std::array<Eigen::Vector3d, 3> triangle = {to_eigen(t.m_vertices[0]), to_eigen(t.m_vertices[1]),
                                                     to_eigen(t.m_vertices[2])};
    const Eigen::AlignedBox3d box(to_eigen(bound.m_min), to_eigen(bound.m_max));
    measured.reach = std::max(measured.reach, reach_of(box, triangle));
    const double growth = part.getPart() == 0 ? growth_of(box, tree.getNodeData(node), measured, shape)
                                              : std::numeric_limits<double>::infinity();
    measured.growth = std::max(measured.growth, growth);
    // The axis-aligned box around a turned box has a diagonal up to sqrt 3 times as long.
    measured.spread = std::max(
        measured.spread, distance_from_centroid(box.center(), triangle) + std::sqrt(3.0) / 2 * box.diagonal().norm());
  }
}

/// Returns the bounds of the vertices that triangles use, and marks these vertices in `used`.
Eigen::AlignedBox3d measure_vertices(const btGImpactMeshShapePart& part, GImpactMesh& measured) {
  Eigen::AlignedBox3d box;
  std::vector<char> used(static_cast<std::size_t>(part.getVertexCount()));
  const auto* manager = static_cast<const btGImpactMeshShapePart::TrimeshPrimitiveManager*>(part.getPrimitiveManager());
  for (int t = 0; t < part.getNumChildShapes(); ++t) {
    std::array<unsigned, 3> corners{};
    manager->get_indices(t, corners[0], corners[1], corners[2]);
    for (const unsigned v : corners) {
      btVector3 vertex(0, 0, 0);
      part.getVertex(static_cast<int>(v), vertex);
      if (!to_eigen(vertex).allFinite()) {
        throw Error("Bullet mesh: vertex " + std::to_string(v) + " of part " + std::to_string(part.getPart()) +
                    " is not finite");
      }
      box.extend(to_eigen(vertex));
      measured.radius = std::max(measured.radius, to_eigen(vertex).norm());
      used[v] = 1;
    }
  }
  measured.loose_vertices |= std::find(used.begin(), used.end(), 0) != used.end();
  return box;
}

/// Returns the scale factor, or 0 if axes or parts differ in it.
double uniform_scale(const btGImpactMeshShape& mesh) {
  const double scale = mesh.getMeshPart(0)->getLocalScaling().x();
  for (int p = 0; p < mesh.getMeshPartCount(); ++p) {
    if (to_eigen(mesh.getMeshPart(p)->getLocalScaling()) != Eigen::Vector3d::Constant(scale)) return 0;
  }
  return scale > 0 && std::isfinite(scale) ? scale : 0;
}

/// Throws if the mesh, in the unit of the asset, has another box than the asset's fine mesh, if that is stored, or does
/// not lie in the box of the finest cage. Vertices are rounded to float, the asset's box to 16 bits.
void check_box(const Eigen::AlignedBox3d& scaled, const GImpactMesh& measured, const SimpleShape& shape) {
  const Eigen::AlignedBox3d box(scaled.min() / measured.scale, scaled.max() / measured.scale);
  const Surface& outer = shape.outer();
  const Eigen::AlignedBox3d asset(outer.lower.cast<double>() + shape.frame.origin,
                                  outer.upper.cast<double>() + shape.frame.origin);
  const double tolerance =
      2 * shape.fine_error +
      1e-4 * (asset.min().cwiseAbs().maxCoeff() + asset.max().cwiseAbs().maxCoeff() + measured.radius / measured.scale);
  const Eigen::AlignedBox3d wider(asset.min().array() - tolerance, asset.max().array() + tolerance);
  const bool inside = wider.contains(box);
  const bool equal = (asset.min() - box.min()).cwiseAbs().maxCoeff() <= tolerance &&
                     (asset.max() - box.max()).cwiseAbs().maxCoeff() <= tolerance;
  if (inside && (equal || &outer != &shape.fine)) return;
  std::ostringstream message;
  message << "Bullet mesh: reaches from (" << box.min().transpose() << ") to (" << box.max().transpose()
          << "), the asset's from (" << asset.min().transpose() << ") to (" << asset.max().transpose()
          << "): another unit, frame or mesh";
  throw Error(message.str());
}

}  // namespace

GImpactMesh measure(const btGImpactMeshShape& mesh, const Shape& attached) {
  if (attached.is_compound()) throw Error("Bullet mesh: the shape to attach is a compound; attach a simple one");
  const SimpleShape& shape = attached.simple();
  const FineLease lease(shape);
  if (mesh.getMeshPartCount() == 0) throw Error("Bullet mesh: has no triangles");
  GImpactMesh measured;
  measured.arrays = mesh.getMeshInterface();
  measured.scale = uniform_scale(mesh);
  Eigen::AlignedBox3d box;
  for (int p = 0; p < mesh.getMeshPartCount(); ++p) {
    const btGImpactMeshShapePart& part = *mesh.getMeshPart(p);
    const double margin = part.getMargin();
    if (!(margin >= 0) || !std::isfinite(margin)) {
      throw Error("Bullet mesh: margin " + std::to_string(margin) + " of part " + std::to_string(p) +
                  " has to be finite and >= 0");
    }
    if (!part.hasBoxSet()) throw Error("Bullet mesh: has no tree yet: call updateBound() before attach()");
    measured.margin = std::max(measured.margin, margin);
    const Locked locked(part);
    box.extend(measure_vertices(part, measured));
    measure_boxes(part, shape, measured);
  }
  if (measured.scale > 0) check_box(box, measured, shape);
  return measured;
}

bool still_holds(const GImpactMesh& measured, const btGImpactMeshShape& mesh) noexcept {
  if (mesh.getMeshInterface() != measured.arrays || !(measured.scale > 0)) return false;
  for (int p = 0; p < mesh.getMeshPartCount(); ++p) {
    const btGImpactMeshShapePart& part = *mesh.getMeshPart(p);
    if (!(static_cast<double>(part.getMargin()) <= measured.margin)) return false;
    const btVector3& scaling = part.getLocalScaling();
    for (int k = 0; k < 3; ++k) {
      if (static_cast<double>(scaling[k]) != measured.scale) return false;
    }
  }
  return true;
}

}  // namespace encage::bullet
