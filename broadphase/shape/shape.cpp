// SPDX-License-Identifier: Apache-2.0
#include "broadphase/shape/shape.h"

#include "broadphase/shape/assemble.h"
#include "src/files/number_text.h"
#include "src/limits.h"
#include "src/mesh/rounding.h"
#include "src/tree/refit.h"

#include <encage/error.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace encage {
namespace {

/// Throws Error for a mesh that cannot be used, before coordinates are rounded.
void check_mesh(const TriangleMesh& mesh) {
  const auto fail = [](const std::string& what, std::int64_t n, const std::string& why) {
    throw Error("mesh: " + what + " " + std::to_string(n) + " " + why);
  };
  const std::int64_t count = mesh.vertices.rows();
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      if (v < 0 || v >= count) fail("triangle", t, "has vertex " + std::to_string(v) + ", of " + std::to_string(count));
    }
  }
  for (std::int64_t v = 0; v < count; ++v) {
    if (!mesh.vertices.row(v).allFinite()) fail("vertex", v, "is not finite");
    if (const double most = mesh.vertices.row(v).cwiseAbs().maxCoeff(); most > largest_coordinate) {
      fail("vertex", v, "has a coordinate of " + number_text(most) + ", beyond 1e37: choose a larger unit");
    }
  }
  if (mesh.triangles.rows() == 0) throw Error("mesh: no triangles");
}

constexpr std::size_t most_points = 1024;

/// Returns the corners of tree boxes that together contain the surface. The largest boxes are opened first.
std::vector<std::array<float, 3>> box_corners(const Surface& surface) {
  struct Lane {
    float size;
    std::int32_t node;
    int lane;
    bool operator<(const Lane& other) const {
      return std::tuple(size, -node, -lane) < std::tuple(other.size, -other.node, -other.lane);
    }
  };
  const MeshTreeView& tree = surface.tree;
  std::vector<Lane> heap, closed;
  const auto push = [&](std::int32_t n) {
    for (int lane = 0; lane < MeshNode::width && tree.nodes[n].count(lane) != MeshNode::unused; ++lane) {
      float size = 0;
      for (int axis = 0; axis < 3; ++axis) {
        size = std::max(size, tree.upper(tree.nodes[n], axis, lane) - tree.lower(tree.nodes[n], axis, lane));
      }
      heap.push_back({size, n, lane});
      std::push_heap(heap.begin(), heap.end());
    }
  };
  push(0);
  while (!heap.empty() && 8 * (heap.size() + closed.size() + MeshNode::width) <= most_points) {
    std::pop_heap(heap.begin(), heap.end());
    const Lane largest = heap.back();
    heap.pop_back();
    const MeshNode& node = tree.nodes[largest.node];
    if (node.count(largest.lane) == MeshNode::inner) {
      push(node.child(largest.lane));
    } else {
      closed.push_back(largest);
    }
  }
  closed.insert(closed.end(), heap.begin(), heap.end());
  std::vector<std::array<float, 3>> corners;
  for (const Lane& at : closed) {
    const MeshNode& node = tree.nodes[at.node];
    for (int corner = 0; corner < 8; ++corner) {
      std::array<float, 3>& point = corners.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        point[axis] = (corner >> axis & 1) != 0 ? tree.upper(node, axis, at.lane) : tree.lower(node, axis, at.lane);
      }
    }
  }
  return corners;
}

}  // namespace

// ---- Assembling --------------------------------------------------------------

// Repeats the checks of the reader for hierarchies from other sources.
std::shared_ptr<SimpleShape> describe(const AssetSummary& summary, std::size_t levels, const ShapeOptions& options) {
  if (levels > std::numeric_limits<std::int16_t>::max()) throw Error("hierarchy has too many levels");
  if (!(summary.origin.array().abs() <= largest_length).all()) {
    throw Error("hierarchy: the origin is not finite or beyond 1e150");
  }
  if (!(summary.fine_error >= 0) || std::isinf(summary.fine_error)) {
    throw Error("hierarchy: fine_error is not a finite distance");
  }
  auto shape = std::make_shared<SimpleShape>();
  shape->frame.origin = summary.origin;
  shape->solid = summary.solid;
  shape->hollow = options.hollow;
  shape->fine_error = summary.fine_error;
  return shape;
}

void add_cage(SimpleShape& shape, const MeshArraysView& arrays) {
  shape.cages.emplace_back(arrays);
  shape.frame.radius = std::max(shape.frame.radius, shape.cages.back().radius);
  if (!shape.cages.back().closed) throw Error(cage_name(shape.cages.size() - 1) + ": not closed");
}

// The outline is the fine mesh, or else the finest cage, if it has few vertices: near the body, and quick to project.
// Otherwise boxes around the finest surface serve.
void set_outline(SimpleShape& shape) {
  const auto set = [&](std::span<const std::array<float, 3>> points) {
    double squared = 0;
    for (const auto& p : points) {
      squared = std::max(squared, Eigen::Map<const Eigen::Vector3f>(p.data()).cast<double>().squaredNorm());
    }
    const double radius = std::sqrt(squared) * (1 + 8 * eps);
    if (!(radius < 1e30)) return;
    shape.outline = Outline(points);
    shape.outline_radius = radius;
  };
  const auto fits = [&](const Surface& surface) {
    if (surface.empty() || surface.mesh.vertices.size() > most_points) return false;
    set(surface.mesh.vertices);
    return true;
  };
  if (!shape.on_demand && fits(shape.fine)) return;
  if (std::none_of(shape.cages.begin(), shape.cages.end(), fits)) set(box_corners(shape.outer()));
}

void set_fine(SimpleShape& shape, const MeshArraysView& arrays) {
  shape.fine = Surface(arrays);
  shape.fine_triangles = arrays.mesh.triangles.size();
  shape.fine_vertices = arrays.mesh.vertices.size();
  shape.frame.radius = std::max(shape.frame.radius, shape.fine.radius);
}

MeshArraysView keep(SimpleShape& shape, MeshArrays arrays) {
  return shape.owned_arrays.emplace_back(std::move(arrays)).view();
}

SimpleShape::SimpleShape()
    : Shape(false), number([] {
        static std::atomic<std::uint64_t> last{0};
        return last.fetch_add(1, std::memory_order_relaxed) + 1;
      }()) {}

Surface::Surface(const MeshArraysView& arrays) : MeshArraysView(arrays), surroundings(arrays.mesh) {
  double squared = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    squared = std::max(squared, vertex(static_cast<std::int32_t>(v)).squaredNorm());
  }
  radius = std::sqrt(squared) * (1 + 8 * eps);
  closed = std::all_of(parts.begin(), parts.end(), [](const MeshPart& part) { return part.closed == 1; });
  const MeshNode& root = tree.nodes[0];
  for (int axis = 0; axis < 3; ++axis) {
    lower[axis] = tree.lower(root, axis, 0);
    upper[axis] = tree.upper(root, axis, 0);
    for (int lane = 1; lane < MeshNode::width && root.count(lane) != MeshNode::unused; ++lane) {
      lower[axis] = std::min(lower[axis], tree.lower(root, axis, lane));
      upper[axis] = std::max(upper[axis], tree.upper(root, axis, lane));
    }
  }
}

ShapePtr make_shape(const CageHierarchy& hierarchy, const ShapeOptions& options) {
  if (hierarchy.levels.empty() && hierarchy.fine.triangles.rows() == 0) {
    throw Error("hierarchy has neither cages nor a fine mesh");
  }
  const AssetSummary summary = {hierarchy.origin, hierarchy.solid, hierarchy.fine_error};
  const auto shape = describe(summary, hierarchy.levels.size(), options);
  if (hierarchy.fine.triangles.rows() > 0) {
    set_fine(*shape, keep(*shape, make_mesh_arrays(hierarchy.fine, "fine mesh")));
  }
  std::vector<double> clearances;
  for (std::size_t k = 0; k < hierarchy.levels.size(); ++k) {
    add_cage(*shape, keep(*shape, make_mesh_arrays(hierarchy.levels[k].mesh, cage_name(k))));
    clearances.push_back(hierarchy.levels[k].certificate.clearance);
  }
  shape->set_clearances(std::move(clearances));
  set_outline(*shape);
  return shape;
}

ShapePtr make_shape(const TriangleMesh& mesh, const ShapeOptions& options) {
  check_mesh(mesh);
  CageHierarchy hierarchy;
  hierarchy.fine = mesh;
  hierarchy.solid = is_closed(mesh) ? Solid::closed : Solid::surface_only;
  const Eigen::AlignedBox3d box = bounds(mesh);
  if (!box.isEmpty()) hierarchy.origin = local_origin(box);
  hierarchy.fine.vertices.rowwise() -= hierarchy.origin.transpose();
  hierarchy.fine_error = round_vertices(hierarchy.fine);
  return make_shape(hierarchy, options);
}

std::shared_ptr<SimpleShape> make_primitive(const TriangleMesh& core, double error, double convex_radius, bool flat) {
  check_mesh(core);
  TriangleMesh fine = core;
  const Eigen::AlignedBox3d box = bounds(fine);
  const Eigen::Vector3d origin = local_origin(box);
  fine.vertices.rowwise() -= origin.transpose();
  const double rounded = round_vertices(fine);
  auto shape = describe({origin, Solid::closed, (error + rounded) * (1 + 4 * eps)}, 0, {.hollow = flat});
  shape->primitive = true;
  shape->convex_radius = convex_radius;
  // Bounds in the tree have the core's extent as their unit. That of a point is 0, beside which all others are too
  // large to compare. The radius gives a better one, by two more vertices while the tree is built.
  const Eigen::Index count = fine.vertices.rows();
  if (convex_radius > 0) {
    fine.vertices.conservativeResize(count + 2, Eigen::NoChange);
    for (int side = 0; side < 2; ++side) {
      const Eigen::Vector3d corner = box.center() - origin + Eigen::Vector3d::Constant((2 * side - 1) * convex_radius);
      fine.vertices.row(count + side) = round_to_float(corner).transpose();
    }
  }
  MeshArrays arrays = make_mesh_arrays(fine, "primitive");
  arrays.vertices.resize(static_cast<std::size_t>(count));
  set_fine(*shape, keep(*shape, std::move(arrays)));
  set_outline(*shape);
  return shape;
}

// ---- Refitting ---------------------------------------------------------------

namespace {

/// A function of its own, because g++ 12 may drop (double)(float)x when both conversions are in one function.
[[gnu::noinline]] void round_into(const Vertices& vertices, const Eigen::Vector3d& origin,
                                  std::vector<std::array<float, 3>>& rounded) {
  rounded.resize(static_cast<std::size_t>(vertices.rows()));
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    for (int k = 0; k < 3; ++k) rounded[v][k] = static_cast<float>(vertices(v, k) - origin[k]);
  }
}

/// Returns the largest distance by which vertices were moved.
[[gnu::noinline]] double rounding_error(const Vertices& vertices, const Eigen::Vector3d& origin,
                                        const std::vector<std::array<float, 3>>& rounded) {
  double squared = 0;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    const Eigen::Vector3d local = vertices.row(v).transpose() - origin;
    const auto stored = Eigen::Map<const Eigen::Vector3f>(rounded[v].data()).cast<double>();
    squared = std::max(squared, (stored - local).squaredNorm());
  }
  return std::sqrt(squared) * (1 + 1e-12);  // the norm itself is rounded
}

void check_moved(const SimpleShape& shape, const Vertices& vertices) {
  if (vertices.rows() != static_cast<Eigen::Index>(shape.fine_vertices)) {
    throw Error("refit: " + std::to_string(vertices.rows()) + " vertices for a mesh of " +
                std::to_string(shape.fine_vertices));
  }
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    // False for NaN, too.
    if (vertices.row(v).cwiseAbs().maxCoeff() <= largest_coordinate && vertices.row(v).allFinite()) continue;
    throw Error("refit: vertex " + std::to_string(v) +
                (vertices.row(v).allFinite() ? " is too large for float32" : " is not finite"));
  }
}

}  // namespace

MeshArrays copy_all_but_vertices(const MeshArraysView& of) {
  MeshArrays arrays;
  arrays.triangles.assign(of.mesh.triangles.begin(), of.mesh.triangles.end());
  arrays.owned.assign(of.owned.begin(), of.owned.end());
  arrays.parts.assign(of.parts.begin(), of.parts.end());
  arrays.tree.nodes.assign(of.tree.nodes.begin(), of.tree.nodes.end());
  arrays.tree.leaves.assign(of.tree.leaves.begin(), of.tree.leaves.end());
  return arrays;
}

void find_extremes(const std::vector<std::int32_t>& part_of_vertex, MeshArrays& arrays) {
  for (MeshPart& part : arrays.parts) part.extremes.fill(part.vertex);
  for (std::size_t v = 0; v < part_of_vertex.size(); ++v) {
    if (part_of_vertex[v] < 0) continue;
    MeshPart& part = arrays.parts[part_of_vertex[v]];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = arrays.vertices[v][axis];
      std::int32_t &least = part.extremes[2 * axis], &largest = part.extremes[2 * axis + 1];
      if (x < arrays.vertices[least][axis]) least = static_cast<std::int32_t>(v);
      if (x > arrays.vertices[largest][axis]) largest = static_cast<std::int32_t>(v);
    }
  }
}

std::vector<std::int32_t> find_part_of_vertex(const MeshView& of) {
  TriangleMesh mesh;
  mesh.vertices.setZero(static_cast<Eigen::Index>(of.vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(of.triangles.size()), 3);
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = static_cast<std::int32_t>(of.triangles[t][k]);
  }
  std::vector<std::int32_t> label;
  triangle_components(mesh, label);
  std::vector<std::int32_t> parts(of.vertices.size(), -1);
  for (std::size_t t = 0; t < of.triangles.size(); ++t) {
    for (const std::uint32_t v : of.triangles[t]) parts[v] = label[t];
  }
  return parts;
}

const std::shared_ptr<const std::vector<std::int32_t>>& SimpleShape::part_of_vertex() const {
  std::call_once(parts_known_, [this] {
    if (!known_parts) {
      known_parts = std::make_shared<const std::vector<std::int32_t>>(find_part_of_vertex(fine.mesh));
    }
  });
  return known_parts;
}

std::vector<double> SimpleShape::clearances() const {
  return clearances_.empty() && asset ? asset->clearances() : clearances_;
}

ShapePtr refit_shape(const Shape& shape, const Vertices& vertices) {
  if (shape.is_compound()) throw Error("refit: a compound; refit its parts and make it anew");
  const SimpleShape& source = shape.simple();
  if (source.primitive) throw Error("refit: a primitive, which has no vertices of its own; make it anew");
  if (source.on_demand) {
    throw Error(
        "refit: the mesh of a ShapeCache or a height field; load_shape() and make_shape() keep theirs in memory");
  }
  if (source.fine.empty()) throw Error("refit: the shape has no fine mesh");
  check_moved(source, vertices);
  const auto& part_of_vertex = source.part_of_vertex();
  Eigen::AlignedBox3d box;
  for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
    if ((*part_of_vertex)[v] >= 0) box.extend(vertices.row(v).transpose());
  }
  const Eigen::Vector3d origin = local_origin(box);
  MeshArrays arrays = copy_all_but_vertices(source.fine);
  round_into(vertices, origin, arrays.vertices);
  find_extremes(*part_of_vertex, arrays);
  refit_tree(arrays.tree, {arrays.vertices, arrays.triangles});
  const double error = rounding_error(vertices, origin, arrays.vertices);
  const auto result = describe({origin, source.solid, error}, 0, {.hollow = source.hollow});
  result->known_parts = part_of_vertex;
  if (source.feature_bytes() > 0) result->known_twin = source.features().twin;
  set_fine(*result, keep(*result, std::move(arrays)));
  set_outline(*result);
  return result;
}

// ---- Loading -----------------------------------------------------------------

namespace {

/// Calls load(); its Error names the file.
template <class Load>
auto load_named(const std::filesystem::path& file, Load&& load) {
  try {
    return load();
  } catch (const Error& error) {
    const std::string message = error.what();
    throw Error(message.starts_with(file.string()) ? message : file.string() + ": " + message);
  }
}

MeshArraysView stored_cage(const AssetView& view, std::size_t k) {
  const auto arrays = view.cage_arrays(k);
  if (!arrays) throw Error(cage_name(k) + ": no stored tree");
  return *arrays;
}

}  // namespace

ShapePtr load_shape(const std::filesystem::path& file, const ShapeOptions& options, LoadMode mode) {
  AssetView view(file, Verify::cages, mode, AssetParts::arrays);
  view.fetch_fine();
  view.verify_fine();
  view.fetch_clearances();
  view.close_file();
  const auto fine = view.fine();
  if (!fine && view.level_count() == 0) throw Error(file.string() + ": neither cages nor a fine mesh");
  return load_named(file, [&]() -> ShapePtr {
    const auto shape = describe(view.summary(), view.level_count(), options);
    // Assets of versions that stored no trees have none.
    const auto finest = fine ? view.fine_arrays() : view.cage_arrays(0);
    if (!finest) return make_shape(copy_hierarchy(view), options);
    if (fine) set_fine(*shape, *finest);
    for (std::size_t k = 0; k < view.level_count(); ++k) add_cage(*shape, stored_cage(view, k));
    set_outline(*shape);
    shape->asset.emplace(std::move(view));
    return shape;
  });
}

ShapePtr load_cages(const std::filesystem::path& file, const ShapeOptions& options, LoadMode mode,
                    std::shared_ptr<MeshBudget> budget) {
  AssetView view(file, Verify::cages, mode, AssetParts::arrays);
  if (view.fine_triangle_count() == 0) view.fetch_clearances();
  view.close_file();
  const std::size_t levels = view.level_count();
  if (levels == 0) throw Error(file.string() + ": no cages");
  return load_named(file, [&]() -> ShapePtr {
    const auto shape = describe(view.summary(), view.level_count(), options);
    const bool stored = view.cage_arrays(0).has_value();
    for (std::size_t k = 0; k < levels; ++k) {
      add_cage(*shape,
               stored ? stored_cage(view, k) : keep(*shape, make_mesh_arrays(copy_mesh(view.cage(k)), cage_name(k))));
    }
    // Cages enclose the source, which is no farther than fine_error from the fine mesh.
    shape->frame.radius = (shape->frame.radius + shape->fine_error) * (1 + 16 * eps);
    const bool has_fine = view.fine_triangle_count() > 0;
    shape->fine_triangles = view.fine_triangle_count();
    shape->fine_vertices = view.fine_vertex_count();
    view.discard_fine();  // frees pages that the system has read ahead
    shape->asset.emplace(std::move(view));
    if (has_fine) {
      shape->on_demand = std::make_unique<OnDemandMesh>(*shape, asset_source(*shape, file.string()), std::move(budget));
    }
    set_outline(*shape);
    return shape;
  });
}

}  // namespace encage
