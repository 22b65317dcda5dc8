// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "oracles/sample_shapes.h"

#include <encage/shape.h>

#include <Eigen/Geometry>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace encage::test {

/// A sample, the run time's shape of it, and its scale in the world.
struct Body {
  Sample sample;
  ShapePtr shape;
  double scale;
  bool hollow;

  explicit Body(Sample s, double size = 1, bool is_hollow = false)
      : sample(std::move(s)),
        shape(make_shape(sample.hierarchy, {.hollow = is_hollow})),
        scale(size),
        hollow(is_hollow) {}
  double diagonal() const { return scale * sample.hierarchy.diagonal; }
  const Eigen::Vector3d& origin() const { return sample.hierarchy.origin; }
  Eigen::Vector3d centre(const Eigen::Isometry3d& pose) const { return pose * (scale * origin()); }
  bool solid() const { return sample.hierarchy.solid != Solid::surface_only && !hollow; }
  bool has_fine() const { return sample.hierarchy.fine.triangles.rows() > 0; }
  /// Returns the finest mesh that is stored: the fine mesh, otherwise the first cage.
  const TriangleMesh& mesh() const { return has_fine() ? sample.hierarchy.fine : sample.hierarchy.levels.front().mesh; }
};

/// The samples as bodies, their fine meshes off the source by up to `jitter`.
inline std::vector<Body> sample_bodies(double jitter = 0) {
  std::vector<Body> all;
  for (Sample& s : sample_shapes(jitter)) all.emplace_back(std::move(s));
  return all;
}

/// Throws if no body is made of the sample of that name.
inline const Body& find(const std::vector<Body>& bodies, const std::string& name) {
  for (const Body& body : bodies) {
    if (body.sample.name == name) return body;
  }
  throw std::runtime_error("no sample " + name);
}

/// A translation.
inline Eigen::Isometry3d shift(double x, double y = 0, double z = 0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  return pose;
}

}  // namespace encage::test
