// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/shape.h"
#include "src/asset/view.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

// How a simple shape is put together: describe(), then its surfaces, then set_outline().
namespace encage {

/// Fills in everything but the surfaces. Throws Error.
std::shared_ptr<SimpleShape> describe(const AssetSummary& summary, std::size_t levels, const ShapeOptions& options);

/// Takes the arrays over; the shape owns what the view refers to.
MeshArraysView keep(SimpleShape& shape, MeshArrays arrays);

/// Sets the fine mesh.
void set_fine(SimpleShape& shape, const MeshArraysView& arrays);

/// Adds the next coarser cage. Throws Error if it is not closed.
void add_cage(SimpleShape& shape, const MeshArraysView& arrays);

/// Chooses the points for world boxes, after all surfaces.
void set_outline(SimpleShape& shape);

/// Returns everything of a mesh that does not depend on where its vertices are, and the tree as it is.
MeshArrays copy_all_but_vertices(const MeshArraysView& of);

/// Returns the part that each vertex belongs to; -1 where no triangle has it.
std::vector<std::int32_t> find_part_of_vertex(const MeshView& of);

/// Finds the extreme vertices of all parts anew.
void find_extremes(const std::vector<std::int32_t>& part_of_vertex, MeshArrays& arrays);

/// A linear map of a body frame.
struct Stretch {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  double shortest = 1, longest = 1;  ///< bounds of the lengths of images of vectors of length 1
  bool mirrors = false;
  /// Bounds how far the image of a point is from where it should be, relative to the norm of the point.
  double off = 0;
};

/// Returns the image of a shape. Cages stay as far as their clearance covers what moves them from the exact image; the
/// proof is in docs/guarantee.md, "Stretched bodies". Throws Error, its message starting with `name`, for a mesh on
/// demand, for coordinates beyond 1e37 or an origin beyond 1e150, and if no surface is left.
std::shared_ptr<SimpleShape> stretched(const SimpleShape& source, const Stretch& stretch, const std::string& name);

/// The same of a compound, by the factors along the axes of its frame. Its parts get shapes of their own.
ShapePtr stretched_compound(const CompoundShape& source, const Eigen::Vector3d& factors);

}  // namespace encage
