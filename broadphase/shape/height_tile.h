// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "broadphase/shape/on_demand.h"
#include "src/tree/mesh_arrays.h"

#include <encage/height_field.h>

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace encage {

/// The heights of a field, which its tiles share. Samples and cells are numbered by column and row.
class HeightGrid {
 public:
  /// Cells on each side of a tile. It is even, so that alternating diagonals are the same in all tiles.
  static constexpr std::int32_t tile_cells = 32;

  /// Copies the heights; the field has been checked.
  HeightGrid(const HeightField& field, CellDiagonal diagonal);

  std::int32_t cell_columns() const { return columns_ - 1; }
  std::int32_t cell_rows() const { return rows_ - 1; }
  CellDiagonal diagonal() const { return diagonal_; }
  float height(std::int32_t column, std::int32_t row) const {
    return heights_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                    static_cast<std::size_t>(column)];
  }
  bool is_hole(std::int32_t column, std::int32_t row) const { return std::isnan(height(column, row)); }
  bool has_cell(std::int32_t column, std::int32_t row) const {
    return column >= 0 && column < cell_columns() && row >= 0 && row < cell_rows();
  }

  /// Calls visit(half, corners) for the triangles of a cell that have no hole as a corner. A corner is (column, row).
  using Corner = std::array<std::int32_t, 2>;
  template <class Visit>
  void for_each_triangle(std::int32_t column, std::int32_t row, Visit&& visit) const {
    for (std::int32_t half = 0; half < 2; ++half) {
      const std::array<Corner, 3> corners = corners_of(column, row, half);
      bool whole = true;
      for (const Corner& c : corners) whole = whole && !is_hole(c[0], c[1]);
      if (whole) visit(half, corners);
    }
  }
  std::array<Corner, 3> corners_of(std::int32_t column, std::int32_t row, std::int32_t half) const {
    const bool rising =
        diagonal_ == CellDiagonal::rising || (diagonal_ == CellDiagonal::alternating && ((column + row) & 1) == 0);
    const Corner a = {column, row}, b = {column + 1, row}, c = {column + 1, row + 1}, d = {column, row + 1};
    if (rising) return half == 0 ? std::array{a, b, c} : std::array{a, c, d};
    return half == 0 ? std::array{a, b, d} : std::array{b, c, d};
  }

  /// Local coordinates of the samples -1 to tile_cells + 1 of any tile: the same in all tiles, so that tiles share
  /// their border exactly. The local origin is tile_cells / 2 spacings beyond the tile's first sample.
  float local(int axis, std::int32_t sample) const {
    const std::int32_t index = sample + 1;
    return local_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(index)];
  }
  /// Returns the place of a tile's local origin; `first` is the tile's first sample along the axis, `error` gets the
  /// rounding of the sum.
  double place(int axis, std::int32_t first, double& error) const;
  double origin_z() const { return origin_.z(); }
  /// Largest distance along the axis of a local coordinate from its exact place.
  double local_error(int axis) const { return local_error_[static_cast<std::size_t>(axis)]; }
  std::int64_t bytes() const { return static_cast<std::int64_t>(sizeof(*this) + heights_.size() * sizeof(float)); }

 private:
  std::vector<float> heights_;
  std::int32_t columns_, rows_;
  CellDiagonal diagonal_;
  Eigen::Vector3d origin_;
  std::array<double, 2> spacing_;
  std::array<std::array<float, tile_cells + 3>, 2> local_;
  std::array<double, 2> local_error_;
};

/// Makes the mesh of a tile from the heights.
class ENCAGE_HIDDEN HeightTile final : public FineSource {
 public:
  /// A tile by its first cell. What the shape has to know of it is here before it is loaded.
  HeightTile(std::shared_ptr<const HeightGrid> grid, std::int32_t column, std::int32_t row);

  bool empty() const { return triangles_ == 0; }
  std::size_t triangles() const { return static_cast<std::size_t>(triangles_); }
  std::size_t vertices() const { return static_cast<std::size_t>(vertices_); }
  float least() const { return least_; }  ///< local height
  float largest() const { return largest_; }
  std::int32_t columns() const { return columns_; }  ///< number of cells along x
  std::int32_t rows() const { return rows_; }
  const Eigen::Vector3d& origin() const { return origin_; }
  double error() const { return error_; }  ///< largest distance of a vertex from where the field has it
  HeightCell cell(std::int32_t triangle) const noexcept;
  /// Bytes of the heights that count as this tile's.
  void set_share(std::int64_t bytes) { share_ = bytes; }

  std::string name() const override;
  std::int64_t bytes() const override;
  std::int64_t load(SimpleShape& shape) override;
  void drop(SimpleShape& shape) noexcept override;
  bool is_mapped() const noexcept override { return false; }
  std::int64_t own_bytes() const noexcept override { return static_cast<std::int64_t>(sizeof(*this)) + share_; }

 private:
  struct Mesh {
    MeshArrays arrays;  ///< triangles and vertices of the surroundings follow the tile's own
    std::vector<std::uint8_t> foreign;
  };
  bool is_whole() const { return !holes_ && columns_ == HeightGrid::tile_cells && rows_ == HeightGrid::tile_cells; }
  float local_height(std::int32_t column, std::int32_t row) const;
  std::array<float, 3> local_vertex(std::int32_t column, std::int32_t row) const;
  MeshArrays whole_tile() const;
  MeshArrays any_tile(std::vector<std::int32_t>& vertex_of) const;
  void add_surroundings(std::vector<std::int32_t>& vertex_of, Mesh& mesh) const;

  std::shared_ptr<const HeightGrid> grid_;
  std::int32_t column_, row_;  // of the first cell
  std::int32_t columns_, rows_;
  std::int32_t triangles_ = 0, vertices_ = 0;
  bool holes_ = false;
  float middle_ = 0;  // height of the local origin
  float least_ = 0, largest_ = 0;
  Eigen::Vector3d origin_;
  double error_ = 0;
  std::int64_t share_ = 0;
  std::unique_ptr<const Mesh> mesh_;  // set while loaded
};

}  // namespace encage
