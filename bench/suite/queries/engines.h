// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>
#include <encage/queries.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace encage::queries {

/// An engine's answer to one ray.
struct FirstHit {
  bool hit = false;
  double t = 0;
};

/// An engine that casts one ray after the other at a mesh.
struct RayEngine {
  std::string name;
  std::function<void(const std::vector<Ray>& rays, std::vector<FirstHit>& hits)> cast;
};

/// Embree's tree of high quality, one ray at a time; `robust` avoids optimisations that lose hits on edges.
RayEngine embree_rays(const TriangleMesh& mesh, bool robust);

/// An engine that measures distances of points from a mesh.
struct PointEngine {
  std::string name;
  std::function<void(const std::vector<Eigen::Vector3d>& points, std::vector<double>& distances)> measure;
};

/// CGAL's AABB tree in double, with its hints.
PointEngine cgal_points(const TriangleMesh& mesh);

}  // namespace encage::queries
