// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a shape is made of: its meshes in place, its parts, its extent and its memory.

#include <encage/cage.h>
#include <encage/export.h>
#include <encage/fine_lease.h>
#include <encage/shape.h>

#include <Eigen/Geometry>

#include <array>
#include <cstdint>
#include <span>

namespace ENCAGE_EXPORT encage {

/// A mesh of a shape, in place. Vertices are float32 in the *local frame*, which is the body frame moved by `origin`;
/// so meshes far from their origin stay accurate. The pair (origin, vertex) is the exact position, and what queries
/// take for it: a body of scale s at a pose has the vertex at pose * (s * (origin + vertex)). The shape must outlive
/// this.
struct ShapeMesh {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame = origin + local frame
  std::span<const std::array<float, 3>> vertices;    ///< local frame
  /// Indices of vertices, counter-clockwise seen from outside; numbered as in CageHierarchy::fine.
  std::span<const std::array<std::uint32_t, 3>> triangles;
  FineLease lease;  ///< keeps the fine mesh of a shape of a ShapeCache in memory

  /// Returns a vertex in the local frame, exactly.
  Eigen::Vector3d local_vertex(std::size_t v) const {
    return Eigen::Map<const Eigen::Vector3f>(vertices[v].data()).cast<double>();
  }
  /// Returns a vertex in the body frame: the exact position with one rounding per coordinate, and none where the origin
  /// is 0, as it is of meshes within four diagonals of 0.
  Eigen::Vector3d vertex(std::size_t v) const { return origin + local_vertex(v); }
};

/// Returns the fine mesh of a simple shape, caps included; empty spans if it has none. It is no farther than
/// fine_error() from the source. Of a primitive it is the core: the body reaches convex_radius() beyond it. Throws
/// Error for a compound (take the meshes of its parts, shape_part()), and if the mesh of a ShapeCache cannot be read,
/// which it may have to be.
ShapeMesh fine_mesh(const Shape& shape);

/// Returns a cage of a simple shape, 0 <= level < level_count(shape), 0 being the finest. Throws Error for a compound
/// and for any other level.
ShapeMesh cage_mesh(const Shape& shape, int level);

/// A part of a shape: of a compound, after nested compounds have been replaced by their parts. A point of the part is
/// at pose * (scale * x) in the frame of the whole.
struct PlacedPart {
  const Shape* shape = nullptr;  ///< simple; lives as long as the whole
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  double scale = 1;
  // First numbers of the part's fine mesh in the numbering of the whole.
  std::int32_t first_triangle = 0;
  std::int32_t first_vertex = 0;
};

/// Returns a part, 0 <= part < part_count(shape). A simple shape is its own only part. Throws Error for another number.
PlacedPart shape_part(const Shape& shape, std::int64_t part);

// Numbers of triangles and vertices of the fine mesh, of a compound summed over its parts. 0 if there is none.
std::int64_t fine_triangles(const Shape& shape) noexcept;
std::int64_t fine_vertices(const Shape& shape) noexcept;

/// Returns CageHierarchy::fine_error, in units of the body frame; of a compound the largest of its parts'.
double fine_error(const Shape& shape) noexcept;

/// Returns whether the body encloses space; of a compound, what holds for all parts.
Solid solid(const Shape& shape) noexcept;

/// Returns a box of the body frame that contains the body (before scaling), rounding and fine_error() included. It is
/// wider than the fine mesh by less than 1e-4 of its extent. For a shape of a ShapeCache it is the box of the finest
/// cage, for a compound the box of boxes of its parts.
Eigen::AlignedBox3d bounds(const Shape& shape) noexcept;

/// Bytes of memory, of the arrays that queries read.
struct ShapeMemory {
  std::int64_t owned = 0;   ///< allocated by the process
  std::int64_t mapped = 0;  ///< of mapped files, resident or not; the system shares and reclaims them
};

/// Returns how much memory a shape uses now; shapes that parts of a compound share count once. Features, which the
/// first contact_manifold() computes, and the fine mesh of a ShapeCache count while they are there. Thread safe.
ShapeMemory memory_use(const Shape& shape);

}  // namespace encage
