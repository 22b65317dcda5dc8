// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/assemble.h"
#include "src/files/number_text.h"
#include "src/limits.h"
#include "src/tree/refit.h"

#include <encage/error.h>
#include <encage/shape.h>

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace encage {
namespace {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

bool is_diagonal(const Matrix& m) { return m == Matrix(m.diagonal().asDiagonal()); }

/// A function of its own, because g++ 12 may drop (double)(float)x when both conversions are in one function.
[[gnu::noinline]] void map_into(const Surface& surface, const Matrix& linear, const std::string& place,
                                std::vector<std::array<float, 3>>& mapped) {
  mapped.resize(surface.mesh.vertices.size());
  for (std::size_t v = 0; v < mapped.size(); ++v) {
    const Vector image = linear * surface.vertex(static_cast<std::int32_t>(v));
    if (const double most = image.cwiseAbs().maxCoeff(); !(most <= largest_coordinate)) {
      throw Error(place + ": vertex " + std::to_string(v) + " has a coordinate of " + number_text(most) +
                  ", beyond 1e37: choose smaller factors or a larger unit");
    }
    for (int k = 0; k < 3; ++k) mapped[v][k] = static_cast<float>(image[k]);
  }
}

/// How far vertices are rounded.
struct Rounding {
  double after = 0;   ///< in the frame of the images
  double before = 0;  ///< in the frame of the source: the same by the inverse of the map
};

[[gnu::noinline]] Rounding rounding_of(const Surface& surface, const Stretch& stretch,
                                       const std::vector<std::array<float, 3>>& mapped) {
  const bool diagonal = is_diagonal(stretch.linear);
  const Vector factors = stretch.linear.diagonal();
  Rounding most;
  for (std::size_t v = 0; v < mapped.size(); ++v) {
    const Vector image = stretch.linear * surface.vertex(static_cast<std::int32_t>(v));
    const Vector moved = Eigen::Map<const Eigen::Vector3f>(mapped[v].data()).cast<double>() - image;
    most.after = std::max(most.after, moved.stableNorm());
    // Rounding is relative to each coordinate, and so it is before factors along the axes, however much these differ.
    if (diagonal) most.before = std::max(most.before, moved.cwiseQuotient(factors).stableNorm());
  }
  if (!diagonal) most.before = most.after / stretch.shortest;
  return {most.after * (1 + 1e-12), most.before * (1 + 1e-12)};  // the norms themselves are rounded
}

/// Turns triangles: corners 1 and 2 change places, hence edges 0 and 2.
void turn_triangles(MeshArrays& arrays) {
  for (auto& t : arrays.triangles) std::swap(t[1], t[2]);
  for (LeafTriangle& leaf : arrays.tree.leaves) std::swap(leaf.vertices[1], leaf.vertices[2]);
  for (OwnedFeatures& owned : arrays.owned) {
    const unsigned bits = owned;
    owned = static_cast<OwnedFeatures>((bits & 0b010001) | (bits & 0b000010) << 1 | (bits & 0b000100) >> 1 |
                                       (bits & 0b001000) << 2 | (bits & 0b100000) >> 2);
  }
}

/// Normals of slabs map by the inverse of the transpose.
void map_normals(const Matrix& linear, std::vector<MeshNode>& nodes) {
  const Matrix map = linear.inverse().transpose();
  for (MeshNode& node : nodes) {
    for (int lane = 0; lane < MeshNode::width && node.count(lane) != MeshNode::unused; ++lane) {
      const Vector n = map * Vector(node.normal[0][lane], node.normal[1][lane], node.normal[2][lane]);
      const double length = n.stableNorm();
      if (!(length > 0 && std::isfinite(length))) continue;
      for (int k = 0; k < 3; ++k) {
        node.normal[k][lane] = static_cast<std::int8_t>(std::floor(MeshNode::normal_size * (n[k] / length) + 0.5));
      }
    }
  }
}

/// Extremes along an axis stay what they are, or change places.
void keep_extremes(const Matrix& linear, std::vector<MeshPart>& parts) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!(linear(axis, axis) < 0)) continue;
    for (MeshPart& part : parts) std::swap(part.extremes[2 * axis], part.extremes[2 * axis + 1]);
  }
}

MeshArrays map_surface(const Surface& surface, const Stretch& stretch, const std::string& place, Rounding& rounding) {
  MeshArrays arrays = copy_all_but_vertices(surface);
  map_into(surface, stretch.linear, place, arrays.vertices);
  rounding = rounding_of(surface, stretch, arrays.vertices);
  if (is_diagonal(stretch.linear)) {
    keep_extremes(stretch.linear, arrays.parts);
  } else {
    find_extremes(find_part_of_vertex(surface.mesh), arrays);
  }
  if (stretch.mirrors) turn_triangles(arrays);
  map_normals(stretch.linear, arrays.tree.nodes);
  refit_tree(arrays.tree, {arrays.vertices, arrays.triangles});
  return arrays;
}

}  // namespace

std::shared_ptr<SimpleShape> stretched(const SimpleShape& source, const Stretch& stretch, const std::string& name) {
  if (source.primitive) throw Error(name + "a primitive; make it anew with other sizes");
  if (source.on_demand) throw Error(name + "the mesh of a ShapeCache; load_shape() keeps it in memory");
  const Vector origin = stretch.linear * source.frame.origin;
  if (!(origin.cwiseAbs().maxCoeff() <= largest_length)) {
    throw Error(name + "the local origin moves beyond 1e150: choose smaller factors or a larger unit");
  }
  // Origin and vertices take 3 products and 2 sums of terms that add up to the norms.
  const double reach = source.frame.reach() + source.fine_error;
  const double off = (8 * eps * stretch.linear.norm() + stretch.off) * reach;
  const double off_before =
      is_diagonal(stretch.linear) ? (8 * eps + stretch.off / stretch.shortest) * reach : off / stretch.shortest;
  Rounding rounded;
  MeshArrays fine;
  if (!source.fine.empty()) fine = map_surface(source.fine, stretch, name + "the fine mesh", rounded);
  const double error = (stretch.longest * source.fine_error + off + rounded.after) * (1 + 1e-12);
  auto result = describe({origin, source.solid, error}, 0, {.hollow = source.hollow});
  if (!source.fine.empty()) {
    result->known_parts = source.part_of_vertex();
    if (source.feature_bytes() > 0 && !stretch.mirrors) result->known_twin = source.features().twin;
    set_fine(*result, keep(*result, std::move(fine)));
  }
  // A cage is kept if it is farther from the surface before, in the frame of the source, than both are from their exact
  // places. The distance to a surface before the one before is at least the sum of the clearances between.
  const std::vector<double> clearances = source.cages.empty() ? std::vector<double>() : source.clearances();
  assert(clearances.size() == source.cages.size());
  std::vector<double> kept;
  double between = 0, moved_before = 0;
  for (std::size_t k = 0; k < source.cages.size(); ++k) {
    if (clearances[k] > 0) between += clearances[k];
    MeshArrays cage = map_surface(source.cages[k], stretch, name + cage_name(k), rounded);
    const double moved = rounded.before + off_before;
    const double clearance = between * (1 - 1e-12) - (moved + moved_before) * (1 + 1e-12);
    if (!(clearance > 0)) continue;
    add_cage(*result, keep(*result, std::move(cage)));
    kept.push_back(stretch.shortest * clearance * (1 - 1e-12));
    moved_before = moved;
    between = 0;
  }
  result->set_clearances(std::move(kept));
  if (result->fine.empty() && result->cages.empty()) {
    throw Error(name +
                "no cage has a certificate whose clearance exceeds the rounding to float32, and there is no fine mesh: "
                "bake the scaled mesh");
  }
  set_outline(*result);
  return result;
}

ShapePtr scale_shape(const Shape& shape, const Eigen::Vector3d& scale) {
  for (int axis = 0; axis < 3; ++axis) {
    // False for NaN, too.
    const double size = std::abs(scale[axis]);
    if (size >= smallest_scale && size <= largest_scale) continue;
    throw Error(std::string("scale: the factor along ") + "xyz"[axis] + " is " + number_text(scale[axis]) +
                "; its size must be between 1e-50 and 1e50");
  }
  if (shape.is_compound()) return stretched_compound(shape.compound(), scale);
  const Vector sizes = scale.cwiseAbs();
  return stretched(shape.simple(),
                   {.linear = scale.asDiagonal(),
                    .shortest = sizes.minCoeff(),
                    .longest = sizes.maxCoeff(),
                    .mirrors = scale.prod() < 0},
                   "scale: ");
}

}  // namespace encage
