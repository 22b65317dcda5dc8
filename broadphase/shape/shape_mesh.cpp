// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/compound.h"
#include "broadphase/shape/world_box.h"
#include "src/limits.h"
#include "src/mesh/moments.h"

#include <encage/error.h>
#include <encage/primitives.h>
#include <encage/shape_mesh.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace encage {
namespace {

const SimpleShape& simple(const Shape& shape, const char* what) {
  if (!shape.is_compound()) return shape.simple();
  throw Error(std::string(what) + ": the shape is a compound of " + std::to_string(part_count(shape)) +
              " parts, which has no mesh of its own: take those of its parts, shape_part()");
}

ShapeMesh in_place(const SimpleShape& shape, const Surface& surface, FineLease lease) {
  return {shape.frame.origin, surface.mesh.vertices, surface.mesh.triangles, std::move(lease)};
}

/// Sums or compares over the simple shapes of a body and their scales in it.
template <class Visit>
void for_each_simple(const Shape& shape, Visit&& visit) {
  if (!shape.is_compound()) return visit(shape.simple(), 1.0);
  for (const ShapePart& part : shape.compound().parts) visit(*part.shape, part.scale);
}

void add_memory(const SimpleShape& shape, ShapeMemory& sum) {
  sum.owned += static_cast<std::int64_t>(sizeof(SimpleShape) + shape.cages.size() * sizeof(Surface)) +
               shape.outline.bytes() + shape.feature_bytes();
  for (const MeshArrays& arrays : shape.owned_arrays) sum.owned += arrays.bytes();
  if (shape.on_demand) sum.owned += static_cast<std::int64_t>(sizeof(OnDemandMesh)) + shape.on_demand->owned_bytes();
  if (!shape.asset) return;
  if (shape.asset->mode() == LoadMode::map) {
    sum.mapped += shape.asset->image_bytes();
  } else {
    sum.owned += shape.asset->image_bytes() - (shape.on_demand ? shape.asset->fine_bytes() : 0);
  }
}

// ---- Mass properties ---------------------------------------------------------

Eigen::Vector3d corner_of(const Surface& surface, std::int64_t triangle, int k) {
  return surface.vertex(static_cast<std::int32_t>(surface.mesh.triangles[triangle][k]));
}

/// Adds a part's moments, about `apex` of its local frame, to those of the whole about `about`: x -> R (s x) + t.
void add_moments(const Moments& part, const MovingPart& placed, const Eigen::Vector3d& apex,
                 const Eigen::Vector3d& about, Moments& whole) {
  const double s = placed.motion.scale, cube = s * s * s;
  const Eigen::Matrix3d& turn = placed.motion.start.linear();
  const Eigen::Vector3d offset = placed.motion.start * (s * (placed.shape->frame.origin + apex)) - about;
  const double volume = cube * part.volume;
  const Eigen::Vector3d first = cube * s * (turn * part.first);
  whole.volume += volume;
  whole.first += first + volume * offset;
  whole.second += cube * s * s * (turn * part.second * turn.transpose()) + first * offset.transpose() +
                  offset * first.transpose() + volume * offset * offset.transpose();
}

}  // namespace

// ---- Meshes and parts --------------------------------------------------------

ShapeMesh fine_mesh(const Shape& shape) {
  const SimpleShape& of = simple(shape, "fine mesh");
  FineLease lease(of);  // `fine` is valid from here on
  return in_place(of, of.fine, std::move(lease));
}

ShapeMesh cage_mesh(const Shape& shape, int level) {
  const SimpleShape& of = simple(shape, "cage");
  if (level < 0 || level >= level_count(of)) {
    throw Error("cage: the level " + std::to_string(level) + " is out of range, there are " +
                std::to_string(level_count(of)) + " levels");
  }
  return in_place(of, of.cages[static_cast<std::size_t>(level)], {});
}

PlacedPart shape_part(const Shape& shape, std::int64_t part) {
  if (part < 0 || part >= part_count(shape)) {
    throw Error("shape: part " + std::to_string(part) + " is out of range, there are " +
                std::to_string(part_count(shape)));
  }
  PlacedPart placed;
  placed.shape = &shape;
  if (!shape.is_compound()) return placed;
  const ShapePart& of = shape.compound().parts[static_cast<std::size_t>(part)];
  return {of.shape.get(), of.pose, of.scale, of.first_triangle, of.first_vertex};
}

std::int64_t fine_triangles(const Shape& shape) noexcept {
  std::int64_t sum = 0;
  for_each_simple(shape, [&](const SimpleShape& of, double) { sum += static_cast<std::int64_t>(of.fine_triangles); });
  return sum;
}

std::int64_t fine_vertices(const Shape& shape) noexcept {
  std::int64_t sum = 0;
  for_each_simple(shape, [&](const SimpleShape& of, double) { sum += static_cast<std::int64_t>(of.fine_vertices); });
  return sum;
}

double fine_error(const Shape& shape) noexcept {
  if (!shape.is_compound()) return shape.simple().fine_error;
  double largest = 0;
  for_each_simple(shape, [&](const SimpleShape& of, double scale) {
    largest = std::max(largest, (1 + 1e-8) * scale * of.fine_error);  // poses of parts stretch
  });
  return largest;
}

double convex_radius(const Shape& shape) noexcept {
  if (!shape.is_compound()) return shape.simple().convex_radius;
  double largest = 0;
  for (const ShapePart& part : shape.compound().parts) {
    largest = std::max(largest, part.scale * part.shape->convex_radius);
  }
  return largest;
}

Solid solid(const Shape& shape) noexcept {
  Solid least = Solid::closed;
  for_each_simple(shape, [&](const SimpleShape& of, double) { least = std::max(least, of.solid); });
  return least;
}

Eigen::AlignedBox3d bounds(const Shape& shape) noexcept {
  if (shape.is_compound()) return shape.compound().nodes.front().box;
  const SimpleShape& of = shape.simple();
  const Surface& surface = of.outer();
  // One rounding of each sum, and one of the error's.
  const double slack = of.error_in_world(1) + 4 * eps * of.frame.reach();
  return {of.frame.origin + surface.lower.cast<double>() - Eigen::Vector3d::Constant(slack),
          of.frame.origin + surface.upper.cast<double>() + Eigen::Vector3d::Constant(slack)};
}

ShapeMemory memory_use(const Shape& shape) {
  ShapeMemory sum;
  if (!shape.is_compound()) {
    add_memory(shape.simple(), sum);
    return sum;
  }
  const CompoundShape& compound = shape.compound();
  sum.owned = static_cast<std::int64_t>(sizeof(CompoundShape) + compound.parts.size() * sizeof(ShapePart) +
                                        compound.nodes.size() * sizeof(PartNode));
  std::set<const SimpleShape*> counted;
  for (const ShapePart& part : compound.parts) {
    if (counted.insert(part.shape.get()).second) add_memory(*part.shape, sum);
  }
  return sum;
}

// ---- Mass properties ---------------------------------------------------------

MassProperties mass_properties(const Shape& shape) {
  const Eigen::Vector3d about = bounds(shape).center();
  Moments whole;
  std::size_t part_number = 0;
  const auto refuse = [&](const std::string& reason) {
    const std::string part = shape.is_compound() ? "part " + std::to_string(part_number) + ": " : "";
    throw Error("mass properties: " + part + reason);
  };
  for_each_part(shape, {}, [&](const MovingPart& part) {
    const SimpleShape& of = *part.shape;
    if (of.known_moments) {
      add_moments(of.known_moments->moments, part, of.known_moments->apex, about, whole);
      ++part_number;
      return true;
    }
    if (of.convex_radius > 0) refuse("a convex hull with a radius: give its moments yourself, e.g. those of the hull");
    if (!of.has_fine()) refuse("the shape has no fine mesh");
    const FineLease lease(of);
    const Surface& fine = of.fine;
    if (!fine.closed) refuse("the mesh is not closed");
    const Eigen::Vector3d apex = 0.5 * (fine.lower.cast<double>() + fine.upper.cast<double>());
    const auto corner = [&](std::int64_t t, int k) { return corner_of(fine, t, k); };
    add_moments(integrate(static_cast<std::int64_t>(of.fine_triangles), corner, apex), part, apex, about, whole);
    ++part_number;
    return true;
  });
  MassProperties body = body_of(whole, about);
  for_each_part(shape, {}, [&](const MovingPart& part) {
    const SimpleShape& of = *part.shape;
    const FineLease lease(of);
    double squared_radius = 0;
    for (std::int64_t t = 0; t < static_cast<std::int64_t>(of.fine_triangles); ++t) {
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d x = of.frame.origin + corner_of(of.fine, t, k);
        squared_radius =
            std::max(squared_radius, (part.motion.start * (part.motion.scale * x) - body.centre).squaredNorm());
      }
    }
    const double beyond = of.primitive ? of.error_in_world(part.motion.scale) : 0;
    body.radius = std::max(body.radius, std::sqrt(squared_radius) + beyond);
    return true;
  });
  return body;
}

}  // namespace encage
