// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/height_tile.h"

#include "broadphase/shape/shape.h"
#include "src/limits.h"
#include "src/tree/refit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace encage {
namespace {

constexpr std::int32_t half_tile = HeightGrid::tile_cells / 2;
/// Samples on each side of a tile with its surroundings.
constexpr std::int32_t window = HeightGrid::tile_cells + 3;

std::size_t in_window(std::int32_t column, std::int32_t row) {
  const std::int32_t place = (row + 1) * window + column + 1;
  return static_cast<std::size_t>(place);
}

/// Returns fl(x + y), and the error of the sum by Knuth's algorithm.
double sum_of(double x, double y, double& error) {
  const double sum = x + y, rest = sum - x;
  error = std::abs((x - (sum - rest)) + (y - rest));
  return sum;
}

/// A function of its own, because g++ 12 may drop (double)(float)x when both conversions are in one function.
[[gnu::noinline]] void round_coordinates(double spacing, std::span<float> rounded) {
  for (std::size_t i = 0; i < rounded.size(); ++i) {
    rounded[i] = static_cast<float>((static_cast<double>(i) - 1 - half_tile) * spacing);
  }
}

/// Returns the largest error of those that belong to a tile.
[[gnu::noinline]] double coordinate_error(double spacing, std::span<const float> rounded) {
  double error = 0;
  for (std::size_t i = 1; i + 1 < rounded.size(); ++i) {
    const double exact = (static_cast<double>(i) - 1 - half_tile) * spacing;
    error = std::max(error, std::abs(static_cast<double>(rounded[i]) - exact));
  }
  return error;
}

/// The arrays of a flat tile without holes: every such tile has them, but for heights and boxes.
MeshArrays flat_tile(CellDiagonal diagonal) {
  constexpr std::int32_t n = HeightGrid::tile_cells, samples = n + 1;
  const std::vector<float> heights(static_cast<std::size_t>(samples) * samples, 0.0F);
  const HeightGrid grid({.heights = heights, .columns = samples, .rows = samples}, diagonal);
  TriangleMesh mesh;
  mesh.vertices.resize(samples * samples, 3);
  mesh.triangles.resize(2 * n * n, 3);
  for (std::int32_t row = 0; row < samples; ++row) {
    for (std::int32_t column = 0; column < samples; ++column) {
      mesh.vertices.row(row * samples + column) << column, row, 0;
    }
  }
  Eigen::Index t = 0;
  for (std::int32_t row = 0; row < n; ++row) {
    for (std::int32_t column = 0; column < n; ++column) {
      grid.for_each_triangle(column, row, [&](std::int32_t, const std::array<HeightGrid::Corner, 3>& corners) {
        for (std::size_t k = 0; k < 3; ++k) {
          mesh.triangles(t, static_cast<Eigen::Index>(k)) = corners[k][1] * samples + corners[k][0];
        }
        ++t;
      });
    }
  }
  return make_mesh_arrays(mesh, "height field");
}

const MeshArrays& flat_tile_of(CellDiagonal diagonal) {
  switch (diagonal) {
    case CellDiagonal::rising: {
      static const MeshArrays tile = flat_tile(CellDiagonal::rising);
      return tile;
    }
    case CellDiagonal::falling: {
      static const MeshArrays tile = flat_tile(CellDiagonal::falling);
      return tile;
    }
    case CellDiagonal::alternating: break;
  }
  static const MeshArrays tile = flat_tile(CellDiagonal::alternating);
  return tile;
}

}  // namespace

// ---- HeightGrid ------------------------------------------------------------

HeightGrid::HeightGrid(const HeightField& field, CellDiagonal diagonal)
    : heights_(field.heights.begin(), field.heights.end()),
      columns_(field.columns),
      rows_(field.rows),
      diagonal_(diagonal),
      origin_(field.origin),
      spacing_{static_cast<double>(field.spacing_x), static_cast<double>(field.spacing_y)} {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    round_coordinates(spacing_[axis], local_[axis]);
    local_error_[axis] = coordinate_error(spacing_[axis], local_[axis]);
  }
}

// A spacing is a float and a number of spacings is below 2^29: their product is exact.
double HeightGrid::place(int axis, std::int32_t first, double& error) const {
  return sum_of(origin_[axis], (static_cast<double>(first) + half_tile) * spacing_[static_cast<std::size_t>(axis)],
                error);
}

// ---- HeightTile ------------------------------------------------------------

HeightTile::HeightTile(std::shared_ptr<const HeightGrid> grid, std::int32_t column, std::int32_t row)
    : grid_(std::move(grid)),
      column_(column),
      row_(row),
      columns_(std::min(HeightGrid::tile_cells, grid_->cell_columns() - column)),
      rows_(std::min(HeightGrid::tile_cells, grid_->cell_rows() - row)) {
  std::vector<bool> used(static_cast<std::size_t>(columns_ + 1) * static_cast<std::size_t>(rows_ + 1), false);
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (std::int32_t r = row_; r < row_ + rows_; ++r) {
    for (std::int32_t c = column_; c < column_ + columns_; ++c) {
      grid_->for_each_triangle(c, r, [&](std::int32_t, const std::array<HeightGrid::Corner, 3>& corners) {
        ++triangles_;
        for (const HeightGrid::Corner& at : corners) {
          used[static_cast<std::size_t>((at[1] - row_) * (columns_ + 1) + at[0] - column_)] = true;
          low = std::min(low, grid_->height(at[0], at[1]));
          high = std::max(high, grid_->height(at[0], at[1]));
        }
      });
    }
  }
  if (triangles_ == 0) return;
  vertices_ = static_cast<std::int32_t>(std::count(used.begin(), used.end(), true));
  holes_ = triangles_ < 2 * columns_ * rows_;
  // Differences of floats x / 2 <= y <= 2 x are exact (Sterbenz).
  const float least = std::min(std::abs(low), std::abs(high)), largest = std::max(std::abs(low), std::abs(high));
  if ((low > 0) == (high > 0) && largest <= 2 * least) middle_ = low + (high - low) / 2;
  least_ = low - middle_;
  largest_ = high - middle_;
  Eigen::Vector3d error;
  for (int axis = 0; axis < 2; ++axis) {
    origin_[axis] = grid_->place(axis, axis == 0 ? column_ : row_, error[axis]);
    error[axis] += grid_->local_error(axis);
  }
  origin_[2] = sum_of(grid_->origin_z(), static_cast<double>(middle_), error[2]);
  error_ = error.norm() * (1 + 8 * eps);
}

std::string HeightTile::name() const {
  return "height field: tile of the cell (" + std::to_string(column_) + ", " + std::to_string(row_) + ")";
}

/// Bounds what load() finds, so that a budget can be checked before.
std::int64_t HeightTile::bytes() const {
  const std::int64_t around = 4 * static_cast<std::int64_t>(HeightGrid::tile_cells + 1);
  const std::int64_t own = 2 * static_cast<std::int64_t>(columns_) * rows_, all = own + 2 * around;
  const std::int64_t vertices = static_cast<std::int64_t>(columns_ + 1) * (rows_ + 1) + around + 4;
  const std::int64_t nodes = own / 8 + 1;
  const auto size_of = [](auto element) { return static_cast<std::int64_t>(sizeof(element)); };
  return nodes * size_of(MeshNode{}) + own * (size_of(LeafTriangle{}) + size_of(OwnedFeatures{})) +
         all * (3 * size_of(std::uint32_t{}) + 3 * size_of(std::int32_t{}) + 3 * size_of(float{})) +
         vertices * (6 * size_of(float{}) + size_of(std::uint8_t{})) + size_of(MeshPart{}) + size_of(Mesh{});
}

float HeightTile::local_height(std::int32_t column, std::int32_t row) const {
  return grid_->height(column, row) - middle_;
}

std::array<float, 3> HeightTile::local_vertex(std::int32_t column, std::int32_t row) const {
  return {grid_->local(0, column - column_), grid_->local(1, row - row_), local_height(column, row)};
}

/// A tile of full size without holes has the tree of a flat one, fitted to its heights: that takes a small part of the
/// time of building one.
MeshArrays HeightTile::whole_tile() const {
  MeshArrays arrays = flat_tile_of(grid_->diagonal());
  std::size_t v = 0;
  for (std::int32_t row = row_; row <= row_ + rows_; ++row) {
    for (std::int32_t column = column_; column <= column_ + columns_; ++column) {
      arrays.vertices[v++] = local_vertex(column, row);
    }
  }
  MeshPart& part = arrays.parts.front();
  for (std::size_t i = 0; i < arrays.vertices.size(); ++i) {
    const float z = arrays.vertices[i][2];
    if (z < arrays.vertices[static_cast<std::size_t>(part.extremes[4])][2]) {
      part.extremes[4] = static_cast<std::int32_t>(i);
    }
    if (z > arrays.vertices[static_cast<std::size_t>(part.extremes[5])][2]) {
      part.extremes[5] = static_cast<std::int32_t>(i);
    }
  }
  refit_tree(arrays.tree, {arrays.vertices, arrays.triangles});
  return arrays;
}

/// Numbers the samples that triangles have as corners.
MeshArrays HeightTile::any_tile(std::vector<std::int32_t>& vertex_of) const {
  TriangleMesh mesh;
  mesh.vertices.resize(vertices_, 3);
  mesh.triangles.resize(triangles_, 3);
  Eigen::Index t = 0;
  std::int32_t next = 0;
  for (std::int32_t row = row_; row < row_ + rows_; ++row) {
    for (std::int32_t column = column_; column < column_ + columns_; ++column) {
      grid_->for_each_triangle(column, row, [&](std::int32_t, const std::array<HeightGrid::Corner, 3>& corners) {
        for (std::size_t k = 0; k < 3; ++k) {
          std::int32_t& v = vertex_of[in_window(corners[k][0] - column_, corners[k][1] - row_)];
          if (v < 0) {
            const std::array<float, 3> at = local_vertex(corners[k][0], corners[k][1]);
            v = next++;
            for (std::size_t axis = 0; axis < 3; ++axis) {
              mesh.vertices(v, static_cast<Eigen::Index>(axis)) = static_cast<double>(at[axis]);
            }
          }
          mesh.triangles(t, static_cast<Eigen::Index>(k)) = v;
        }
        ++t;
      });
    }
  }
  return make_mesh_arrays(mesh, name());
}

/// Adds the triangles around the tile. Of what tiles share, the first tile that has it owns it.
void HeightTile::add_surroundings(std::vector<std::int32_t>& vertex_of, Mesh& mesh) const {
  MeshArrays& arrays = mesh.arrays;
  const std::size_t own_vertices = arrays.vertices.size(), own_triangles = arrays.triangles.size();
  mesh.foreign.assign(own_vertices, 0);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> foreign_edges;
  const auto edge = [](std::uint32_t u, std::uint32_t v) { return std::pair(std::min(u, v), std::max(u, v)); };
  for (std::int32_t row = row_ - 1; row <= row_ + rows_; ++row) {
    for (std::int32_t column = column_ - 1; column <= column_ + columns_; ++column) {
      const bool beside = column < column_ || column >= column_ + columns_;
      const bool own = !beside && row >= row_ && row < row_ + rows_;
      if (own || !grid_->has_cell(column, row)) continue;
      const bool before = row < row_ || (row < row_ + rows_ && column < column_);
      grid_->for_each_triangle(column, row, [&](std::int32_t, const std::array<HeightGrid::Corner, 3>& corners) {
        std::array<std::uint32_t, 3> triangle;
        for (std::size_t k = 0; k < 3; ++k) {
          std::int32_t& v = vertex_of[in_window(corners[k][0] - column_, corners[k][1] - row_)];
          if (v < 0) {
            v = static_cast<std::int32_t>(arrays.vertices.size());
            arrays.vertices.push_back(local_vertex(corners[k][0], corners[k][1]));
            mesh.foreign.push_back(1);
          }
          if (before) mesh.foreign[static_cast<std::size_t>(v)] = 1;
          triangle[k] = static_cast<std::uint32_t>(v);
        }
        arrays.triangles.push_back(triangle);
        for (std::size_t k = 0; before && k < 3; ++k) {
          const std::uint32_t u = triangle[k], v = triangle[(k + 1) % 3];
          if (u < own_vertices && v < own_vertices) foreign_edges.push_back(edge(u, v));
        }
      });
    }
  }
  std::sort(foreign_edges.begin(), foreign_edges.end());
  for (std::size_t t = 0; t < own_triangles; ++t) {
    const std::array<std::uint32_t, 3>& v = arrays.triangles[t];
    unsigned owned = arrays.owned[t];
    for (unsigned k = 0; k < 3; ++k) {
      if (mesh.foreign[v[k]] == 0) continue;
      owned &= ~(1U << k);
      if (std::binary_search(foreign_edges.begin(), foreign_edges.end(), edge(v[k], v[(k + 1) % 3]))) {
        owned &= ~(8U << k);
      }
    }
    arrays.owned[t] = static_cast<OwnedFeatures>(owned);
  }
}

std::int64_t HeightTile::load(SimpleShape& shape) {
  std::vector<std::int32_t> vertex_of(static_cast<std::size_t>(window) * window, -1);
  auto mesh = std::make_unique<Mesh>();
  if (is_whole()) {
    mesh->arrays = whole_tile();
    std::int32_t next = 0;
    for (std::int32_t row = 0; row <= rows_; ++row) {
      for (std::int32_t column = 0; column <= columns_; ++column) vertex_of[in_window(column, row)] = next++;
    }
  } else {
    mesh->arrays = any_tile(vertex_of);
  }
  add_surroundings(vertex_of, *mesh);
  MeshArraysView view = mesh->arrays.view();
  const MeshView all = view.mesh;
  view.mesh = {all.vertices.first(vertices()), all.triangles.first(triangles())};
  Surface fine(view);
  fine.surroundings = all;
  fine.foreign = mesh->foreign;
  shape.fine = fine;
  mesh_ = std::move(mesh);
  const auto features = static_cast<std::int64_t>(all.triangles.size() * 6 + all.vertices.size() * 3) *
                        static_cast<std::int64_t>(sizeof(float));
  return std::max(bytes(), mesh_->arrays.bytes() + static_cast<std::int64_t>(mesh_->foreign.size()) + features);
}

void HeightTile::drop(SimpleShape& shape) noexcept {
  shape.forget_features();
  shape.fine = Surface();
  mesh_.reset();
}

HeightCell HeightTile::cell(std::int32_t triangle) const noexcept {
  const auto described = [&](std::int32_t column, std::int32_t row, std::int32_t half) {
    return HeightCell{column, row, half, 2 * (static_cast<std::int64_t>(row) * grid_->cell_columns() + column) + half};
  };
  if (triangle < 0 || triangle >= triangles_) return {};
  if (!holes_) {
    const std::int32_t cell = triangle / 2;
    return described(column_ + cell % columns_, row_ + cell / columns_, triangle % 2);
  }
  HeightCell found;
  for (std::int32_t row = row_; row < row_ + rows_; ++row) {
    for (std::int32_t column = column_; column < column_ + columns_; ++column) {
      grid_->for_each_triangle(column, row, [&](std::int32_t half, const std::array<HeightGrid::Corner, 3>&) {
        if (triangle-- == 0) found = described(column, row, half);
      });
    }
  }
  return found;
}

}  // namespace encage
