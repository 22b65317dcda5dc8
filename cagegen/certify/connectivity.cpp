// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/certify/connectivity.h"

#include <algorithm>
#include <optional>

namespace encage::proof {
namespace {

// Half-edge 3t + k runs from corner k of triangle t to the next corner.
std::int32_t next(std::int32_t half_edge) { return half_edge % 3 == 2 ? half_edge - 2 : half_edge + 1; }

struct HalfEdge {
  std::int32_t far;  ///< the larger of its two vertices
  std::int32_t id;
};

class Builder {
 public:
  explicit Builder(const TriangleMesh& mesh)
      : mesh_(mesh), vertex_(mesh.triangles.data()), half_edges_(static_cast<std::int32_t>(mesh.triangles.size())) {}

  Connectivity run() {
    result_.component_count = triangle_components(mesh_, result_.component);
    find_repeated_vertices();
    sort_half_edges();
    match_half_edges();
    result_.closed = result_.open_edge.empty();
    if (result_.defect.empty()) check_fans();
    return std::move(result_);
  }

 private:
  std::int32_t from(std::int32_t half_edge) const { return vertex_[half_edge]; }
  std::int32_t to(std::int32_t half_edge) const { return vertex_[next(half_edge)]; }

  void set_defect(const std::string& text) {
    if (result_.defect.empty()) result_.defect = text;
  }

  static std::string edge(std::int32_t a, std::int32_t b) {
    return "edge " + std::to_string(a) + "-" + std::to_string(b);
  }

  void find_repeated_vertices() {
    for (std::int32_t h = 0; h < half_edges_; ++h) {
      if (from(h) != to(h)) continue;
      return set_defect("triangle " + std::to_string(h / 3) + " uses vertex " + std::to_string(from(h)) + " twice");
    }
  }

  /// Counting sort by the smaller vertex, then small sorts by the larger one.
  void sort_half_edges() {
    first_.assign(static_cast<std::size_t>(mesh_.vertices.rows()) + 1, 0);
    for (std::int32_t h = 0; h < half_edges_; ++h) ++first_[std::min(from(h), to(h)) + 1];
    for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
    sorted_.resize(static_cast<std::size_t>(half_edges_));
    std::vector<std::int32_t> next_slot(first_.begin(), first_.end() - 1);
    for (std::int32_t h = 0; h < half_edges_; ++h) {
      sorted_[next_slot[std::min(from(h), to(h))]++] = {std::max(from(h), to(h)), h};
    }
    for (std::size_t v = 0; v + 1 < first_.size(); ++v) {
      std::sort(sorted_.begin() + first_[v], sorted_.begin() + first_[v + 1],
                [](const HalfEdge& a, const HalfEdge& b) { return a.far < b.far || (a.far == b.far && a.id < b.id); });
    }
  }

  void match_half_edges() {
    opposite_.assign(static_cast<std::size_t>(half_edges_), -1);
    for (std::int32_t v = 0; v < mesh_.vertices.rows(); ++v) {
      for (std::int32_t i = first_[v]; i < first_[v + 1];) {
        std::int32_t end = i;
        while (end < first_[v + 1] && sorted_[end].far == sorted_[i].far) ++end;
        if (sorted_[i].far != v) match_edge(v, i, end);
        i = end;
      }
    }
  }

  /// The half-edges sorted_[begin, end) all join vertex `near` and the same other one.
  void match_edge(std::int32_t near, std::int32_t begin, std::int32_t end) {
    const std::int32_t far = sorted_[begin].far;
    ++edge_count_;
    std::int32_t balance = 0;
    for (std::int32_t i = begin; i < end; ++i) {
      // A triangle with a repeated vertex is a segment run to and fro, or half of it; like is_closed(), do not count
      // it.
      if (!repeats_vertex(sorted_[i].id / 3)) balance += from(sorted_[i].id) == near ? 1 : -1;
    }
    if (balance != 0 && result_.open_edge.empty()) result_.open_edge = edge(near, far);
    if (end - begin == 1) {
      return set_defect(edge(near, far) + " of triangle " + std::to_string(sorted_[begin].id / 3) +
                        " has no other triangle");
    }
    if (end - begin > 2) return set_defect(edge(near, far) + " borders " + std::to_string(end - begin) + " triangles");
    const std::int32_t a = sorted_[begin].id;
    const std::int32_t b = sorted_[begin + 1].id;
    if (from(a) == from(b)) {
      return set_defect("triangles " + std::to_string(a / 3) + " and " + std::to_string(b / 3) + " run along " +
                        edge(near, far) + " in the same direction");
    }
    opposite_[a] = b;
    opposite_[b] = a;
  }

  bool repeats_vertex(std::int32_t triangle) const {
    const std::int32_t* v = vertex_ + 3 * triangle;
    return v[0] == v[1] || v[1] == v[2] || v[2] == v[0];
  }

  /// The triangles of each vertex must form one fan; then Euler's formula holds.
  void check_fans() {
    std::vector<std::int32_t> degree(static_cast<std::size_t>(mesh_.vertices.rows()), 0);
    std::vector<std::int32_t> leaving(degree.size(), -1);
    for (std::int32_t h = half_edges_; h-- > 0;) {
      ++degree[from(h)];
      leaving[from(h)] = h;
    }
    std::int64_t used = 0;
    for (std::int32_t v = 0; v < mesh_.vertices.rows(); ++v) {
      if (degree[v] == 0) continue;
      ++used;
      std::int32_t length = 0;
      std::int32_t h = leaving[v];
      do {
        h = next(opposite_[h]);
        ++length;
      } while (h != leaving[v]);
      if (length != degree[v]) {
        return set_defect("vertex " + std::to_string(v) + " joins several fans of triangles");
      }
    }
    const std::int64_t euler = used - edge_count_ + mesh_.triangles.rows();
    result_.genus = static_cast<int>(result_.component_count - euler / 2);
  }

  const TriangleMesh& mesh_;
  const std::int32_t* vertex_;
  std::int32_t half_edges_;
  std::vector<std::int32_t> first_;
  std::vector<HalfEdge> sorted_;
  std::vector<std::int32_t> opposite_;
  std::int64_t edge_count_ = 0;
  Connectivity result_;
};

}  // namespace

Connectivity connectivity(const TriangleMesh& mesh) { return Builder(mesh).run(); }

}  // namespace encage::proof
