// SPDX-License-Identifier: Apache-2.0
#include "broadphase/adapters/bullet/mesh_partner.h"

#include "broadphase/adapters/bullet/convert.h"
#include "broadphase/adapters/bullet/mesh_source.h"

#include <encage/error.h>

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMeshShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace encage::bullet {
namespace {

constexpr int round_sides = 64;        // of what stands for a circle
constexpr int support_points = 2'562;  // of a convex shape of unknown form
const double pi = std::acos(-1.0);

/// A body: its mesh and everything within a radius.
struct Rounded {
  TriangleMesh mesh;
  double radius = 0;
  bool hollow = false;
};

using Points = std::vector<Eigen::Vector3d>;

TriangleMesh with_triangles(const Points& points, const std::vector<Eigen::RowVector3i>& triangles) {
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = points[v].transpose();
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = triangles[t];
  return mesh;
}

/// The point that is farthest from x.
Eigen::Vector3d farthest_from(const Eigen::Vector3d& x, const Points& points) {
  return *std::max_element(points.begin(), points.end(), [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return (p - x).squaredNorm() < (q - x).squaredNorm();
  });
}

/// The convex hull. Without volume it is still closed: both sides of a polygon, a segment or a point, the last two as
/// one degenerate triangle.
TriangleMesh hull_of(const Points& points) {
  btConvexHullComputer hull;
  hull.compute(points.front().data(), sizeof(Eigen::Vector3d), static_cast<int>(points.size()), 0, 0);
  if (hull.faces.size() == 0) {
    const Eigen::Vector3d one = farthest_from(points.front(), points), other = farthest_from(one, points);
    if (one == other) return with_triangles({one}, {{0, 0, 0}});
    return with_triangles({one, other}, {{0, 1, 1}});
  }
  Points corners;
  for (int v = 0; v < hull.vertices.size(); ++v) {
    // The computer rounds coordinates; these are the points as they are.
    corners.push_back(points[static_cast<std::size_t>(hull.original_vertex_index[v])]);
  }
  std::vector<Eigen::RowVector3i> triangles;
  for (int f = 0; f < hull.faces.size(); ++f) {
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[f]];
    const int apex = first->getSourceVertex();
    for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != apex;
         edge = edge->getNextEdgeOfFace()) {
      triangles.emplace_back(apex, edge->getSourceVertex(), edge->getTargetVertex());
    }
  }
  TriangleMesh mesh = with_triangles(corners, triangles);
  if (signed_volume(mesh) < 0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

Eigen::Vector3d on_axis(int axis, double along, double across = 0, double angle = 0) {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  x[axis] = along;
  x[(axis + 1) % 3] = across * std::cos(angle);
  x[(axis + 2) % 3] = across * std::sin(angle);
  return x;
}

void add_circle(Points& points, int axis, double along, double radius) {
  for (int i = 0; i < round_sides; ++i) points.push_back(on_axis(axis, along, radius, 2 * pi * i / round_sides));
}

Points box_corners(const Eigen::Vector3d& half) {
  Points points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z());
  }
  return points;
}

/// Points of a convex shape that are farthest in directions spread over the sphere (a spiral of equal areas).
Points farthest_points(const btConvexShape& shape, int count) {
  Points points;
  const double turn = pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    points.push_back(to_eigen(
        shape.localGetSupportingVertex(to_bullet(on_axis(2, z, std::sqrt(1 - z * z), turn * static_cast<double>(i))))));
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const double way : {1.0, -1.0}) {
      points.push_back(to_eigen(shape.localGetSupportingVertex(to_bullet(on_axis(axis, way)))));
    }
  }
  return points;
}

/// The vertices of a convex shape that is a hull and its margin; none for other shapes.
Points hull_points(const btConvexShape& shape) {
  Points points;
  switch (shape.getShapeType()) {
    case CONVEX_HULL_SHAPE_PROXYTYPE: {
      const auto& hull = static_cast<const btConvexHullShape&>(shape);
      for (int i = 0; i < hull.getNumPoints(); ++i) points.push_back(to_eigen(hull.getScaledPoint(i)));
      break;
    }
    case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE: {
      const auto& cloud = static_cast<const btConvexPointCloudShape&>(shape);
      for (int i = 0; i < cloud.getNumPoints(); ++i) points.push_back(to_eigen(cloud.getScaledPoint(i)));
      break;
    }
    default:
      if (!shape.isPolyhedral()) break;
      const auto& polyhedron = static_cast<const btPolyhedralConvexShape&>(shape);
      for (int i = 0; i < polyhedron.getNumVertices(); ++i) {
        btVector3 vertex;
        polyhedron.getVertex(i, vertex);
        points.push_back(to_eigen(vertex));
      }
  }
  return points;
}

bool has_unit_scaling(const btCollisionShape& shape) { return shape.getLocalScaling() == btVector3(1, 1, 1); }

Rounded round_convex(const btConvexShape& shape) {
  const auto margin = static_cast<double>(shape.getMargin());
  switch (shape.getShapeType()) {
    case SPHERE_SHAPE_PROXYTYPE: {
      const auto& sphere = static_cast<const btSphereShape&>(shape);
      return {hull_of({Eigen::Vector3d::Zero()}), static_cast<double>(sphere.getRadius())};
    }
    case CAPSULE_SHAPE_PROXYTYPE: {
      const auto& capsule = static_cast<const btCapsuleShape&>(shape);
      const auto half = static_cast<double>(capsule.getHalfHeight());
      return {hull_of({on_axis(capsule.getUpAxis(), -half), on_axis(capsule.getUpAxis(), half)}),
              static_cast<double>(capsule.getRadius())};
    }
    case MULTI_SPHERE_SHAPE_PROXYTYPE: {
      const auto& spheres = static_cast<const btMultiSphereShape&>(shape);
      Points centres;
      for (int i = 0; i < spheres.getSphereCount(); ++i) {
        if (spheres.getSphereRadius(i) != spheres.getSphereRadius(0)) break;
        centres.push_back(to_eigen(spheres.getSpherePosition(i)));
      }
      const bool exact = static_cast<int>(centres.size()) == spheres.getSphereCount() && has_unit_scaling(shape);
      if (exact) return {hull_of(centres), static_cast<double>(spheres.getSphereRadius(0))};
      return {hull_of(farthest_points(shape, support_points))};
    }
    case BOX_SHAPE_PROXYTYPE: {
      const auto& box = static_cast<const btBoxShape&>(shape);
      return {hull_of(box_corners(to_eigen(box.getHalfExtentsWithMargin())))};
    }
    case CYLINDER_SHAPE_PROXYTYPE: {
      const auto& cylinder = static_cast<const btCylinderShape&>(shape);
      const int axis = cylinder.getUpAxis();
      const auto half = static_cast<double>(cylinder.getHalfExtentsWithMargin()[axis]);
      Points points;
      for (const double end : {-half, half}) add_circle(points, axis, end, static_cast<double>(cylinder.getRadius()));
      return {hull_of(points)};
    }
    case CONE_SHAPE_PROXYTYPE: {
      const auto& cone = static_cast<const btConeShape&>(shape);
      const auto half = 0.5 * static_cast<double>(cone.getHeight());
      Points points = {on_axis(cone.getConeUpIndex(), half)};
      add_circle(points, cone.getConeUpIndex(), -half, static_cast<double>(cone.getRadius()));
      return {hull_of(points), margin};
    }
    default: {
      const Points points = hull_points(shape);
      if (!points.empty()) return {hull_of(points), margin};
      return {hull_of(farthest_points(shape, support_points))};
    }
  }
}

/// Turns the triangles of a height field, which Bullet lists clockwise, so that they face up.
void turn_up(TriangleMesh& mesh, int up) {
  double area = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0);
    area += (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a)[up];
  }
  if (area < 0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
}

std::uint64_t hash_of(const Points& points) {
  // Points of hulls are few, and nobody forges them.
  const std::string_view bytes(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Eigen::Vector3d));
  return std::hash<std::string_view>()(bytes);
}

/// Tells a shape from another one that has the same traits, and perhaps the address of one that was destroyed.
std::uint64_t content_of(const btCollisionShape& shape) {
  if (shape.isConvex()) {
    const auto& convex = static_cast<const btConvexShape&>(shape);
    const Points points = hull_points(convex);
    return hash_of(points.empty() ? farthest_points(convex, 64) : points);
  }
  const int type = shape.getShapeType();
  if (type != TRIANGLE_MESH_SHAPE_PROXYTYPE && type != MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE) return 0;
  const auto* const source = static_cast<const btTriangleMeshShape&>(shape).getMeshInterface();
  return std::hash<const void*>()(source);
}

}  // namespace

PartnerTraits traits_of(const btCollisionShape& shape) {
  PartnerTraits traits;
  traits.type = shape.getShapeType();
  traits.scaling = shape.getLocalScaling();
  traits.margin = shape.getMargin();
  shape.getAabb(btTransform::getIdentity(), traits.low, traits.high);
  return traits;
}

bool is_partner_type(int type) noexcept {
  return btBroadphaseProxy::isConvex(type) || type == TRIANGLE_MESH_SHAPE_PROXYTYPE ||
         type == SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE || type == MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE ||
         type == TERRAIN_SHAPE_PROXYTYPE;
}

Partner make_partner(const btCollisionShape& shape) {
  Rounded rounded;
  if (shape.isConvex()) {
    rounded = round_convex(static_cast<const btConvexShape&>(shape));
  } else {
    rounded = {collect_triangles(static_cast<const btConcaveShape&>(shape)), static_cast<double>(shape.getMargin()),
               true};
    if (shape.getShapeType() == TERRAIN_SHAPE_PROXYTYPE) {
      turn_up(rounded.mesh, static_cast<const btHeightfieldTerrainShape&>(shape).getUpAxis());
    }
  }
  Partner partner;
  partner.traits = traits_of(shape);
  partner.content = content_of(shape);
  partner.radius = rounded.radius;
  if (rounded.mesh.triangles.rows() == 0) return partner;
  try {
    partner.shape = make_shape(rounded.mesh, {.hollow = rounded.hollow});
  } catch (const Error& error) {
    throw Error(std::string("Bullet ") + shape.getName() + ": " + error.what());
  }
  partner.reach = rounded.mesh.vertices.rowwise().norm().maxCoeff() + partner.radius;
  return partner;
}

std::shared_ptr<const Partner> Partners::get(const btCollisionShape& shape) {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<const Partner>& partner = all_[&shape];
  if (!partner || !(partner->traits == traits_of(shape)) || partner->content != content_of(shape)) {
    partner = std::make_shared<const Partner>(make_partner(shape));
  }
  return partner;
}

bool Partners::forget(const btCollisionShape& shape) noexcept {
  const std::scoped_lock lock(mutex_);
  return all_.erase(&shape) > 0;
}

}  // namespace encage::bullet
