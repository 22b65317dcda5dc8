// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/assemble.h"
#include "broadphase/shape/compound.h"
#include "broadphase/shape/height_tile.h"
#include "src/files/number_text.h"
#include "src/limits.h"

#include <encage/error.h>
#include <encage/height_field.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace encage {
namespace {

[[noreturn]] void refuse_field(const std::string& reason) { throw Error("height field: " + reason); }

void check_spacing(float spacing, std::int32_t samples, double origin, const char* name, const char* axis) {
  const auto value = static_cast<double>(spacing);
  if (!(value > 0) || std::isinf(value)) {
    refuse_field(std::string(name) + " is " + number_text(value) + ", not positive and finite");
  }
  if (const double end = std::abs(origin) + value * samples; !(end <= largest_coordinate)) {
    refuse_field(std::string("it reaches ") + number_text(end) + " along " + axis +
                 ", beyond 1e37: choose a larger unit");
  }
}

void check_field(const HeightField& field) {
  const auto check_side = [](std::int32_t samples, const char* name) {
    if (samples >= 2) return;
    refuse_field(std::string(name) + " is " + std::to_string(samples) + ", a cell needs 2");
  };
  check_side(field.columns, "columns");
  check_side(field.rows, "rows");
  const std::int64_t count = static_cast<std::int64_t>(field.columns) * field.rows;
  if (static_cast<std::int64_t>(field.heights.size()) != count) {
    refuse_field("heights has " + std::to_string(field.heights.size()) + " numbers, columns * rows is " +
                 std::to_string(count));
  }
  const std::int64_t triangles = 2 * static_cast<std::int64_t>(field.columns - 1) * (field.rows - 1);
  if (triangles > std::numeric_limits<std::int32_t>::max()) {
    refuse_field(std::to_string(field.columns) + " x " + std::to_string(field.rows) + " samples have " +
                 std::to_string(triangles) + " triangles, more than 2^31 - 1: make several fields of them");
  }
  if (!field.origin.allFinite()) refuse_field("origin is not finite");
  check_spacing(field.spacing_x, field.columns, field.origin.x(), "spacing_x", "x");
  check_spacing(field.spacing_y, field.rows, field.origin.y(), "spacing_y", "y");
  if (const double far = std::abs(field.origin.z()); far > largest_coordinate) {
    refuse_field("origin.z is " + number_text(field.origin.z()) + ", beyond 1e37: choose a larger unit");
  }
  for (std::size_t i = 0; i < field.heights.size(); ++i) {
    const auto height = static_cast<double>(field.heights[i]);
    if (!(std::abs(height) > largest_coordinate)) continue;
    const auto columns = static_cast<std::size_t>(field.columns);
    refuse_field("the height in column " + std::to_string(i % columns) + " and row " + std::to_string(i / columns) +
                 " is " + number_text(height) +
                 (std::isinf(height) ? ", not finite: holes are NaN" : ", beyond 1e37: choose a larger unit"));
  }
}

/// A box around the tile and the errors of its vertices, a little wider than needed, so that a flat tile has a box,
/// too.
TriangleMesh box_around(const HeightGrid& grid, const HeightTile& tile) {
  const std::array<float, 3> low = {grid.local(0, 0), grid.local(1, 0), tile.least()};
  const std::array<float, 3> high = {grid.local(0, tile.columns()), grid.local(1, tile.rows()), tile.largest()};
  double extent = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent = std::max(extent, static_cast<double>(high[axis]) - static_cast<double>(low[axis]));
  }
  const double wider = tile.error() * (1 + 8 * eps) + 0x1p-20 * extent;
  constexpr float most = std::numeric_limits<float>::max();
  TriangleMesh box;
  box.vertices.resize(8, 3);
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    const float below = std::nextafter(static_cast<float>(static_cast<double>(low[at]) - wider), -most);
    const float above = std::nextafter(static_cast<float>(static_cast<double>(high[at]) + wider), most);
    for (int v = 0; v < 8; ++v) box.vertices(v, axis) = static_cast<double>((v >> axis & 1) != 0 ? above : below);
  }
  box.triangles.resize(12, 3);
  box.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3,
      7, 5;
  return box;
}

std::shared_ptr<SimpleShape> tile_shape(const HeightGrid& grid, std::unique_ptr<HeightTile> tile,
                                        const std::shared_ptr<MeshBudget>& budget) {
  auto shape = std::make_shared<SimpleShape>();
  shape->frame.origin = tile->origin();
  shape->solid = Solid::surface_only;
  shape->hollow = true;
  shape->fine_error = tile->error();
  shape->drops_features = true;
  shape->owned_arrays.push_back(make_mesh_arrays(box_around(grid, *tile), "height field: box"));
  shape->cages.emplace_back(shape->owned_arrays.front().view());
  shape->frame.radius = shape->cages.front().radius;
  shape->fine_triangles = tile->triangles();
  shape->fine_vertices = tile->vertices();
  shape->on_demand = std::make_unique<OnDemandMesh>(*shape, std::move(tile), budget);
  set_outline(*shape);
  return shape;
}

}  // namespace

ShapePtr make_height_field(const HeightField& field, const HeightFieldOptions& options) {
  check_field(field);
  const auto grid = std::make_shared<const HeightGrid>(field, options.diagonal);
  std::vector<std::unique_ptr<HeightTile>> tiles;
  std::int64_t largest = 0;
  for (std::int32_t row = 0; row < grid->cell_rows(); row += HeightGrid::tile_cells) {
    for (std::int32_t column = 0; column < grid->cell_columns(); column += HeightGrid::tile_cells) {
      auto tile = std::make_unique<HeightTile>(grid, column, row);
      if (tile->empty()) continue;
      largest = std::max(largest, tile->bytes());
      tiles.push_back(std::move(tile));
    }
  }
  if (tiles.empty()) refuse_field("every triangle has a hole (NaN) as a corner");
  if (options.budget_bytes < 2 * largest) {
    refuse_field("budget_bytes is " + std::to_string(options.budget_bytes) + ", two tiles need " +
                 std::to_string(2 * largest));
  }
  const auto budget = std::make_shared<MeshBudget>(options.budget_bytes);
  const auto count = static_cast<std::int64_t>(tiles.size());
  std::vector<CompoundPart> parts;
  parts.reserve(tiles.size());
  for (std::int64_t i = 0; i < count; ++i) {
    std::unique_ptr<HeightTile>& tile = tiles[static_cast<std::size_t>(i)];
    tile->set_share(grid->bytes() * (i + 1) / count - grid->bytes() * i / count);
    parts.push_back({tile_shape(*grid, std::move(tile), budget)});
  }
  return make_compound(parts);
}

HeightCell cell_of(const Shape& shape, std::int32_t triangle) noexcept {
  const SimpleShape* of = nullptr;
  if (shape.is_compound()) {
    const CompoundShape& compound = shape.compound();
    if (triangle < 0) return {};
    const ShapePart& part = compound.parts[part_of_triangle(compound, triangle)];
    of = part.shape.get();
    triangle -= part.first_triangle;
  } else {
    of = &shape.simple();
  }
  const auto* const tile = of->on_demand ? dynamic_cast<const HeightTile*>(&of->on_demand->source()) : nullptr;
  return tile != nullptr ? tile->cell(triangle) : HeightCell{};
}

}  // namespace encage
