// SPDX-License-Identifier: Apache-2.0
#include "src/tree/mesh_arrays.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace encage {
namespace {

using Float3 = std::array<float, 3>;
using Index3 = std::array<std::uint32_t, 3>;

/// A function of its own, because g++ 12 may drop (double)(float)x when both conversions are in one function.
[[gnu::noinline]] void check_exact(const Vertices& vertices, const std::vector<Float3>& rounded,
                                   const std::string& place) {
  for (std::size_t v = 0; v < rounded.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double x = vertices(v, k);
      if (static_cast<double>(rounded[v][k]) == x || !std::isfinite(x)) continue;
      char text[32];
      std::snprintf(text, sizeof text, "%.17g", x);
      throw Error(place + ": vertex " + std::to_string(v) + ": " + text + " is not exact in float32");
    }
  }
}

[[gnu::noinline]] std::vector<Float3> to_float(const Vertices& vertices) {
  std::vector<Float3> rounded(static_cast<std::size_t>(vertices.rows()));
  for (std::size_t v = 0; v < rounded.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) rounded[v][k] = static_cast<float>(vertices(v, k));
  }
  return rounded;
}

std::vector<Index3> to_unsigned(const Triangles& triangles) {
  std::vector<Index3> indices(static_cast<std::size_t>(triangles.rows()));
  for (std::size_t t = 0; t < indices.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) indices[t][k] = static_cast<std::uint32_t>(triangles(t, k));
  }
  return indices;
}

struct Edge {
  std::uint32_t low, high;
  std::uint32_t triangle;
  std::uint32_t k;
};

/// Returns all edges of all triangles. Equal edges are adjacent, sorted by increasing triangle.
std::vector<Edge> sorted_edges(const std::vector<Index3>& triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = triangles[t][k], w = triangles[t][(k + 1) % 3];
      edges.push_back({std::min(v, w), std::max(v, w), t, k});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    return std::tie(x.low, x.high, x.triangle, x.k) < std::tie(y.low, y.high, y.triangle, y.k);
  });
  return edges;
}

void own_features(MeshArrays& arrays, const std::vector<Edge>& edges) {
  arrays.owned.assign(arrays.triangles.size(), 0);
  std::vector<bool> taken(arrays.vertices.size(), false);
  for (std::size_t t = 0; t < arrays.triangles.size(); ++t) {
    for (unsigned k = 0; k < 3; ++k) {
      const std::uint32_t v = arrays.triangles[t][k];
      if (taken[v]) continue;
      taken[v] = true;
      arrays.owned[t] |= static_cast<OwnedFeatures>(1U << k);
    }
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const bool repeated = i > 0 && edges[i].low == edges[i - 1].low && edges[i].high == edges[i - 1].high;
    if (!repeated) arrays.owned[edges[i].triangle] |= static_cast<OwnedFeatures>(8U << edges[i].k);
  }
}

bool has_repeated_vertex(const Index3& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

void find_parts(MeshArrays& arrays, const std::vector<Edge>& edges, const TriangleMesh& mesh) {
  std::vector<std::int32_t> label;
  arrays.parts.resize(static_cast<std::size_t>(triangle_components(mesh, label)), {-1, {}, 1});
  for (std::size_t t = 0; t < arrays.triangles.size(); ++t) {
    MeshPart& part = arrays.parts[label[t]];
    for (const std::uint32_t v : arrays.triangles[t]) {
      const auto index = static_cast<std::int32_t>(v);
      if (part.vertex < 0) {
        part.vertex = index;
        part.extremes.fill(index);
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float x = arrays.vertices[v][axis];
        std::int32_t& least = part.extremes[2 * axis];
        std::int32_t& largest = part.extremes[2 * axis + 1];
        if (x < arrays.vertices[least][axis]) least = index;
        if (x > arrays.vertices[largest][axis]) largest = index;
      }
    }
  }
  for (std::size_t i = 0; i < edges.size();) {
    const Edge& first = edges[i];
    int sum = 0;
    for (; i < edges.size() && edges[i].low == first.low && edges[i].high == first.high; ++i) {
      const Index3& t = arrays.triangles[edges[i].triangle];
      if (!has_repeated_vertex(t)) sum += t[edges[i].k] == first.low ? 1 : -1;
    }
    if (sum != 0) arrays.parts[label[first.triangle]].closed = 0;
  }
}

}  // namespace

MeshArrays make_mesh_arrays(const TriangleMesh& mesh, const std::string& place) {
  MeshArrays arrays;
  arrays.vertices = to_float(mesh.vertices);
  arrays.triangles = to_unsigned(mesh.triangles);
  check_exact(mesh.vertices, arrays.vertices, place);
  check_mesh({arrays.vertices, arrays.triangles}, place);
  try {
    arrays.tree = build_mesh_tree(mesh);
  } catch (const Error& error) {
    throw Error(place + ": " + error.what());
  }
  const std::vector<Edge> edges = sorted_edges(arrays.triangles);
  own_features(arrays, edges);
  find_parts(arrays, edges, mesh);
  return arrays;
}

void check_arrays(const MeshArraysView& arrays, const std::string& place) {
  check_tree(arrays.tree, arrays.mesh, place);
  if (arrays.owned.size() != arrays.mesh.triangles.size()) throw Error(place + ": not one owner entry a triangle");
  if (arrays.parts.empty()) throw Error(place + ": no parts");
  const auto vertex_count = static_cast<std::int64_t>(arrays.mesh.vertices.size());
  for (std::size_t i = 0; i < arrays.parts.size(); ++i) {
    const auto valid = [&](std::int32_t v) { return v >= 0 && v < vertex_count; };
    const MeshPart& part = arrays.parts[i];
    if (!valid(part.vertex) || !std::all_of(part.extremes.begin(), part.extremes.end(), valid)) {
      throw Error(place + ": part " + std::to_string(i) + " refers to a vertex out of range");
    }
  }
}

}  // namespace encage
