// SPDX-License-Identifier: Apache-2.0
#pragma once

// Terrain from a grid of heights.

#include <encage/export.h>
#include <encage/shape.h>

#include <Eigen/Core>

#include <cstdint>
#include <span>

namespace ENCAGE_EXPORT encage {

/// Heights over a grid in the xy plane of the body frame. The sample in column i and row j is the vertex at
/// origin + (i * spacing_x, j * spacing_y, heights[j * columns + i]).
struct HeightField {
  /// Row by row. A sample that is NaN is a hole: no triangle has it as a corner. The numbers are copied.
  std::span<const float> heights;
  std::int32_t columns = 0;                          ///< number of samples along x, >= 2
  std::int32_t rows = 0;                             ///< number of samples along y, >= 2
  float spacing_x = 1;                               ///< > 0
  float spacing_y = 1;                               ///< > 0
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< body frame
};

/// The diagonal that halves a cell. The cell in column i and row j is between the samples (i, j) and (i + 1, j + 1).
enum class CellDiagonal : std::uint8_t {
  rising,       ///< from the sample (i, j) to (i + 1, j + 1)
  falling,      ///< from the sample (i + 1, j) to (i, j + 1)
  alternating,  ///< rising where i + j is even, otherwise falling
};

struct HeightFieldOptions {
  CellDiagonal diagonal = CellDiagonal::rising;
  /// Bytes, > 0. Limits the memory of the meshes of tiles. They are made when a query comes near; where room is needed,
  /// the least recently used ones that no query is reading are dropped.
  std::int64_t budget_bytes = std::int64_t{64} << 20;
};

/// Makes the surface of a height field, of two triangles a cell with normals upwards (+z). The body is hollow: it is
/// its surface alone, which is touched from both sides. It is a compound of tiles of 32 x 32 cells, which have a box in
/// place of a cage, and whose meshes exist only while queries need them: beside the heights it takes less than 4 bytes
/// a sample, and a mesh takes some 150 bytes a cell. Linear time.
///
/// Answers are those of make_shape() with the same triangles and `hollow`, and do not depend on what is in memory. A
/// query that needs a tile whose mesh does not exist takes a lock and allocates memory. Where that fails, queries
/// answer as for a mesh that a ShapeCache cannot read. The memory of meshes is within the budget as in a ShapeCache.
/// Vertices are exact where 16 spacings are exact in float32; fine_error() accounts for the rest. Triangles are
/// numbered tile by tile; cell_of() tells their cells.
///
/// Throws Error, which names argument, value and reason: fewer than 2 samples a side; another number of heights than
/// columns * rows; heights that are infinite or beyond 1e37; a spacing that is not positive and finite; a field that
/// reaches beyond 1e37, has no triangle or more than 2^31 - 1; a budget without room for two tiles.
ShapePtr make_height_field(const HeightField& field, const HeightFieldOptions& options = {});

/// One of the two triangles of a cell.
struct HeightCell {
  std::int32_t column = -1;
  std::int32_t row = -1;
  /// 0: the triangle with the edge from the sample (column, row) to (column + 1, row). 1: the other one.
  std::int32_t half = -1;
  /// 2 * (row * (columns - 1) + column) + half: number of the triangle, holes counted, row by row.
  std::int64_t number = -1;
};

/// Returns the cell of a triangle of a height field, or of a compound that contains height fields; all -1 if the
/// triangle belongs to none. Constant time for tiles without holes. Thread safe.
HeightCell cell_of(const Shape& shape, std::int32_t triangle) noexcept;

}  // namespace encage
