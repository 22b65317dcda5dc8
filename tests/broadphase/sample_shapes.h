// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Small shapes, concave, with cavities, of several parts, open; with cages made by hand.

#include <encage/broadphase.h>

#include <string>
#include <vector>

namespace encage::test {

struct Sample {
  std::string name;
  TriangleMesh source;  ///< local frame, in double; hierarchy.fine is its rendition
  CageHierarchy hierarchy;
};

/// Shapes of diagonal 1 to 5 about the origin. `jitter` moves the source's vertices
/// away from their fine vertices, by as much as hierarchy.fine_error says.
std::vector<Sample> sample_shapes(double jitter);

/// Of the same kind with 1,000 to 2,048 triangles.
std::vector<Sample> large_sample_shapes(double jitter);

/// The same sample in another unit: 2^exponent, so that float32 stays exact.
Sample scaled(const Sample& sample, int exponent);

/// Without its cages, or without its fine mesh.
Sample without_cages(Sample sample);
Sample without_fine(Sample sample);

TriangleMesh box_mesh(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper);
/// `count` corners of a simple polygon (counter-clockwise) with `triangles` of them, extruded along z.
TriangleMesh prism(const std::vector<Eigen::Vector2d>& polygon, const std::vector<Eigen::Vector3i>& triangles,
                   double bottom, double top);
TriangleMesh torus(double major, double minor, int around, int across);
TriangleMesh inverted(TriangleMesh mesh);
TriangleMesh merged(const TriangleMesh& a, const TriangleMesh& b);

}  // namespace encage::test
