// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/cap.h"
#include "cagegen/sanitize/degenerate.h"
#include "cagegen/sanitize/edge_table.h"
#include "cagegen/sanitize/orient.h"
#include "cagegen/sanitize/solid_volume.h"
#include "cagegen/sanitize/weld.h"
#include "src/files/hash.h"
#include "src/limits.h"

#include <encage/bake.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace encage {
namespace {

using io::EdgeTable;
using io::Side;

/// Volume below this share of (area x diagonal) is rounding: a sheet, not a solid.
constexpr double flat = 1e-9;
/// Thickness of the triangles that replace degenerate ones, in diagonals.
constexpr double sliver_thickness = 1e-6;

void validate(const TriangleMesh& mesh) {
  if (mesh.triangles.rows() == 0) throw Error("the mesh has no triangles");
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    if (!mesh.vertices.row(v).allFinite()) {
      throw Error("vertex " + std::to_string(v) + ": coordinate is not finite");
    }
  }
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (mesh.triangles.row(t).minCoeff() >= 0 && mesh.triangles.row(t).maxCoeff() < mesh.vertices.rows()) continue;
    throw Error("face " + std::to_string(t) + ": vertex index is out of range (" +
                std::to_string(mesh.vertices.rows()) + " vertices)");
  }
}

void weld_vertices(TriangleMesh& mesh, SanitizeReport& report) {
  report.isolated_vertices = io::drop_unused_vertices(mesh);
  const std::vector<std::int32_t> same =
      io::weld({mesh.vertices.data(), static_cast<std::size_t>(mesh.vertices.size())});
  for (std::int32_t& v : mesh.triangles.reshaped()) v = same[v];
  report.welded_vertices = io::drop_unused_vertices(mesh);
}

/// Sets the local frame. Throws for extents that float32 cannot hold.
void localise(TriangleMesh& mesh, SourceMesh& source) {
  const Eigen::AlignedBox3d box = bounds(mesh);
  const double extent = box.sizes().maxCoeff();
  if (extent == 0) throw Error("the mesh is a single point");
  if (!(extent <= largest_coordinate)) throw Error("the mesh is too large for float32: its extent is above 1e37");
  if (extent < smallest_extent) throw Error("the mesh is too small for float32: its extent is below 1e-30");
  source.diagonal = box.diagonal().norm();
  source.origin = local_origin(box);
  mesh.vertices.rowwise() -= source.origin.transpose();
}

/// Triangles on the same three vertices.
struct Duplicates {
  std::vector<char> again;     ///< per triangle: an earlier one has its vertices
  std::vector<char> opposite;  ///< per triangle: the first of those with the other orientation
  std::int64_t count = 0;      ///< of `again`
  bool has_opposite = false;
};

Duplicates find_duplicates(const TriangleMesh& mesh) {
  struct Entry {
    std::int32_t middle, high, triangle;
    bool same_vertices(const Entry& other) const { return middle == other.middle && high == other.high; }
    bool operator<(const Entry& other) const {
      if (middle != other.middle) return middle < other.middle;
      return high != other.high ? high < other.high : triangle < other.triangle;
    }
  };
  const Triangles& triangles = mesh.triangles;
  // Bucketed by the lowest vertex.
  std::vector<std::int64_t> first(static_cast<std::size_t>(mesh.vertices.rows()) + 1, 0);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) ++first[triangles.row(t).minCoeff() + 1];
  for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
  std::vector<Entry> entries(static_cast<std::size_t>(triangles.rows()));
  std::vector<std::int64_t> next(first.begin(), first.end() - 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    std::array<std::int32_t, 3> v = {triangles(t, 0), triangles(t, 1), triangles(t, 2)};
    std::sort(v.begin(), v.end());
    entries[next[v[0]]++] = {v[1], v[2], static_cast<std::int32_t>(t)};
  }

  Duplicates result;
  result.again.assign(entries.size(), 0);
  result.opposite.assign(entries.size(), 0);
  const auto is_even = [&](std::int32_t t) {  // permutation of the sorted vertices
    return (triangles(t, 0) < triangles(t, 1)) ==
           ((triangles(t, 1) < triangles(t, 2)) == (triangles(t, 0) < triangles(t, 2)));
  };
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    std::sort(entries.begin() + first[v], entries.begin() + first[v + 1]);
    std::int64_t kept = first[v];
    bool opposite_found = false;
    for (std::int64_t i = first[v] + 1; i < first[v + 1]; ++i) {
      if (!entries[i].same_vertices(entries[kept])) {
        kept = i;
        opposite_found = false;
        continue;
      }
      const std::int32_t t = entries[i].triangle;
      result.again[t] = 1;
      ++result.count;
      if (opposite_found || io::repeats_a_vertex(triangles, t) || is_even(t) == is_even(entries[kept].triangle))
        continue;
      result.opposite[t] = 1;
      result.has_opposite = opposite_found = true;
    }
  }
  return result;
}

/// The triangles that are not dropped.
Triangles select(const Triangles& triangles, const std::vector<char>& drop) {
  Triangles kept(triangles.rows() - std::count(drop.begin(), drop.end(), char{1}), 3);
  Eigen::Index row = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    if (!drop[t]) kept.row(row++) = triangles.row(t);
  }
  return kept;
}

/// A surface, and whether it encloses a solid.
struct EnclosingSurface {
  TriangleMesh mesh;
  std::int64_t cap_count = 0;
  std::int64_t loops = 0;
  std::int64_t turned_components = 0;
  Solid solid = Solid::surface_only;
  double volume = 0;
};

double area(const TriangleMesh& mesh) {
  double sum = 0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0);
    sum += (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm();
  }
  return sum / 2;
}

struct Edges {
  bool boundary = false;   ///< some edge has a single side
  bool unmatched = false;  ///< some edge has several sides, whose directions do not cancel
};

Edges inspect(const Triangles& triangles, const EdgeTable& table) {
  Edges result;
  table.for_each_edge([&](std::span<const Side> sides) {
    int net = 0;
    for (const Side s : sides) net += io::tail(triangles, s) < io::head(triangles, s) ? 1 : -1;
    result.boundary |= sides.size() == 1;
    result.unmatched |= sides.size() > 1 && net != 0;
  });
  return result;
}

void append_caps(EnclosingSurface& surface, const EdgeTable& edges, const io::Components& components) {
  std::vector<std::array<std::int32_t, 3>> caps;
  std::int64_t work = 400'000'000;  // some 5 s
  for (const io::Loop& loop : io::boundary_loops(surface.mesh.triangles, edges, components)) {
    io::cap_loop(surface.mesh, loop, caps, work);
    ++surface.loops;
  }
  Triangles& triangles = surface.mesh.triangles;
  const Eigen::Index old = triangles.rows();
  triangles.conservativeResize(old + static_cast<Eigen::Index>(caps.size()), 3);
  for (std::size_t i = 0; i < caps.size(); ++i) {
    triangles.row(old + static_cast<Eigen::Index>(i)) << caps[i][0], caps[i][1], caps[i][2];
  }
  surface.cap_count = static_cast<std::int64_t>(caps.size());
}

std::int64_t count_turned(const io::Components& components, const std::vector<char>& turned) {
  std::vector<char> of_component(static_cast<std::size_t>(components.count), 0);
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t] && components.label[t] >= 0) of_component[components.label[t]] = 1;
  }
  return std::count(of_component.begin(), of_component.end(), char{1});
}

/// Makes the orientation consistent and outward, and closes the boundary with caps where that yields a solid.
EnclosingSurface close(TriangleMesh mesh, double diagonal) {
  EnclosingSurface surface;
  surface.mesh = std::move(mesh);
  Triangles& triangles = surface.mesh.triangles;
  const Eigen::Index vertex_count = surface.mesh.vertices.rows();
  std::vector<char> turned(static_cast<std::size_t>(triangles.rows()), 0);
  EdgeTable edges(triangles, vertex_count);
  io::Components components = io::make_consistent(triangles, edges, turned);
  if (std::count(turned.begin(), turned.end(), char{1}) > 0) edges = EdgeTable(triangles, vertex_count);
  const Edges found = inspect(triangles, edges);
  const bool closable = !found.unmatched && components.count > 0;
  if (closable && found.boundary) {
    append_caps(surface, edges, components);
    turned.resize(static_cast<std::size_t>(triangles.rows()), 0);
    edges = EdgeTable(triangles, vertex_count);
    components = io::make_consistent(triangles, edges, turned);
  }
  const std::vector<std::vector<std::int32_t>> parts = io::closed_parts(surface.mesh, edges, components);
  io::turn_outward(surface.mesh, parts, turned);
  if (closable) {
    surface.solid = found.boundary ? Solid::capped : Solid::closed;
    surface.volume = signed_volume(surface.mesh);
  }
  if (!(surface.volume > flat * area(surface.mesh) * diagonal)) {
    triangles.conservativeResize(triangles.rows() - surface.cap_count, 3);
    turned.resize(static_cast<std::size_t>(triangles.rows()));
    surface.cap_count = surface.loops = 0;
    surface.solid = Solid::surface_only;
    surface.volume = 0;
  } else {
    surface.volume = io::solid_volume(surface.mesh, parts);
  }
  surface.turned_components = count_turned(components, turned);
  return surface;
}

}  // namespace

SourceMesh sanitize(const TriangleMesh& input) {
  validate(input);
  SourceMesh source;
  source.hash = hash_mesh(input);
  TriangleMesh welded = input;
  weld_vertices(welded, source.report);
  localise(welded, source);

  const Duplicates duplicates = find_duplicates(welded);
  const auto surface_without = [&](const std::vector<char>& drop) {
    TriangleMesh mesh{welded.vertices, select(welded.triangles, drop)};
    io::mark_dangling(mesh);
    io::drop_unused_vertices(mesh);
    return close(std::move(mesh), source.diagonal);
  };
  EnclosingSurface surface = surface_without(duplicates.again);
  source.report.duplicate_triangles = duplicates.count;
  if (surface.solid != Solid::closed && duplicates.has_opposite) {
    // A sheet of zero thickness may need both of its sides to close the surface.
    std::vector<char> drop = duplicates.again;
    for (std::size_t t = 0; t < drop.size(); ++t) drop[t] = static_cast<char>(drop[t] && !duplicates.opposite[t]);
    EnclosingSurface both = surface_without(drop);
    if (both.solid == Solid::closed) {
      surface = std::move(both);
      source.report.duplicate_triangles = std::count(drop.begin(), drop.end(), char{1});
    }
  }

  source.report.flipped_components = surface.turned_components;
  source.report.capped_loops = surface.loops;
  source.solid = surface.solid;
  source.volume = surface.volume;
  source.cap_count = surface.cap_count;
  source.obstacle = std::move(surface.mesh);
  source.clean = source.obstacle;
  source.report.degenerate_triangles = io::replace_degenerate(source.clean, sliver_thickness * source.diagonal);
  io::drop_unused_vertices(source.clean);
  source.manifold = io::is_closed_manifold(source.clean.triangles, source.clean.vertices.rows());
  return source;
}

}  // namespace encage
