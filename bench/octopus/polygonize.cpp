// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/octopus/polygonize.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace encage::octopus {
namespace {

// Lattice nodes have integer coordinates of equal parity, in half cells. Even nodes are the corners of the cells, odd
// ones their centres.
using Node = std::array<std::int32_t, 3>;

constexpr int block_side = 8;  // half cells; a power of two
constexpr int block_shift = 3;
constexpr int most_attempts = 12;  // four are plenty for a smooth surface

class Lattice {
 public:
  Lattice(const ImplicitSurface& surface, double half_width, double cell)
      : surface_(surface), unit_(cell / 2), origin_(-half_width) {
    // One block of margin on each side, so that no neighbour of a node near the surface is outside.
    int blocks = 2 + static_cast<int>(std::ceil(2 * half_width / (unit_ * block_side)));
    origin_ -= unit_ * block_side;
    side_ = 1;
    while (side_ < blocks) side_ *= 2;
    block_of_.assign(static_cast<std::size_t>(side_) * side_ * side_, -1);
    find_blocks({0, 0, 0}, side_, surface.all_parts());
    for (const std::int32_t b : std::vector<std::int32_t>(near_)) mark_around(b);
  }

  double unit() const { return unit_; }
  std::int32_t nodes_per_side() const { return side_ * block_side; }
  Eigen::Vector3d position(const Node& n) const {
    return Eigen::Vector3d(n[0], n[1], n[2]) * unit_ + Eigen::Vector3d::Constant(origin_);
  }

  /// Evaluated once per node. Infinite where no surface is near.
  double value(const Node& n) {
    const std::int32_t b = block_of(n);
    if (b < 0) return std::numeric_limits<double>::infinity();
    double& v = blocks_[b].values[inside_block(n)];
    if (std::isnan(v)) v = surface_.value(position(n), blocks_[b].parts);
    return v;
  }

  Sample sample(const Eigen::Vector3d& p) const {
    Node n;
    for (int k = 0; k < 3; ++k) n[k] = static_cast<std::int32_t>(std::floor((p[k] - origin_) / unit_));
    const std::int32_t b = block_of(n);
    return surface_.sample(p, b < 0 ? surface_.all_parts() : blocks_[b].parts);
  }

  /// Calls visit(node) for every even node that may have a tetrahedron across the surface.
  template <class Visit>
  void for_each_node_near(Visit visit) {
    for (const Block& block : blocks_) {
      if (!block.marked) continue;
      const Node first = block.first;
      for (int z = 0; z < block_side; z += 2) {
        for (int y = 0; y < block_side; y += 2) {
          for (int x = 0; x < block_side; x += 2) {
            const Node n{first[0] + x, first[1] + y, first[2] + z};
            // All nodes of its tetrahedra are within two units, and the function is 1-Lipschitz.
            if (std::abs(value(n)) <= 2.01 * unit_) visit(n);
          }
        }
      }
    }
  }

 private:
  struct Block {
    Node first;
    ImplicitSurface::Parts parts;
    std::vector<double> values;
    bool marked = false;
  };

  std::size_t slot(const Node& block) const {
    return (static_cast<std::size_t>(block[2]) * side_ + block[1]) * side_ + block[0];
  }
  std::int32_t block_of(const Node& n) const {
    Node b;
    for (int k = 0; k < 3; ++k) {
      b[k] = n[k] >> block_shift;
      if (b[k] < 0 || b[k] >= side_) return -1;
    }
    return block_of_[slot(b)];
  }
  static std::size_t inside_block(const Node& n) {
    constexpr int mask = block_side - 1;
    return static_cast<std::size_t>(((n[2] & mask) * block_side + (n[1] & mask)) * block_side + (n[0] & mask));
  }

  // Octree descent; leaves whose surroundings may hold the surface become blocks.
  void find_blocks(const Node& corner, int width, const ImplicitSurface::Parts& parts) {
    const double half = width * block_side * unit_ / 2;
    const double radius = half * 1.7320508075688774;
    const double block_diagonal = block_side * unit_ * 1.7320508075688774;
    const Node middle{corner[0] * block_side, corner[1] * block_side, corner[2] * block_side};
    const Eigen::Vector3d centre = position(middle) + Eigen::Vector3d::Constant(half);
    const double value = surface_.value(centre, parts);
    // The surface may be inside, or in one of the blocks around.
    if (std::abs(value) > radius + block_diagonal) return;
    ImplicitSurface::Parts own = surface_.relevant(parts, centre, radius + block_diagonal);
    if (width == 1) {
      block_of_[slot(corner)] = static_cast<std::int32_t>(blocks_.size());
      if (std::abs(value) <= radius) near_.push_back(static_cast<std::int32_t>(blocks_.size()));
      Block block{middle, surface_.relevant(own, centre, radius), {}, false};
      block.values.assign(block_side * block_side * block_side, std::numeric_limits<double>::quiet_NaN());
      blocks_.push_back(std::move(block));
      return;
    }
    const int h = width / 2;
    for (int i = 0; i < 8; ++i) {
      find_blocks({corner[0] + (i & 1) * h, corner[1] + (i >> 1 & 1) * h, corner[2] + (i >> 2) * h}, h, own);
    }
  }

  void mark_around(std::int32_t b) {
    const Node first = blocks_[b].first;
    for (int i = 0; i < 27; ++i) {
      const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
      const std::int32_t other =
          block_of({first[0] + dx * block_side, first[1] + dy * block_side, first[2] + dz * block_side});
      if (other >= 0) blocks_[other].marked = true;
    }
  }

  const ImplicitSurface& surface_;
  double unit_;
  double origin_;
  int side_ = 1;  // blocks
  std::vector<std::int32_t> block_of_;
  std::vector<Block> blocks_;
  std::vector<std::int32_t> near_;
};

struct CellCorner {
  std::int64_t key;  // of the lattice edge
  Eigen::Vector3d position;
};

// Calls emit(Tetrahedron, values) for the tetrahedra across the surface. Each has two even nodes, joined along an axis,
// and two odd ones beside that edge.
template <class Emit>
void for_each_tetrahedron(Lattice& lattice, Emit emit) {
  lattice.for_each_node_near([&](const Node& n) {
    for (int axis = 0; axis < 3; ++axis) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      Node other = n;
      other[axis] += 2;
      Node ring[4];
      for (int i = 0; i < 4; ++i) {
        ring[i] = n;
        ring[i][axis] += 1;
        ring[i][u] += i == 0 || i == 3 ? 1 : -1;
        ring[i][v] += i < 2 ? 1 : -1;
      }
      for (int i = 0; i < 4; ++i) {
        const std::array<Node, 4> nodes{n, other, ring[i], ring[(i + 1) % 4]};
        std::array<double, 4> values;
        int inside = 0;
        for (int k = 0; k < 4; ++k) {
          values[k] = lattice.value(nodes[k]);
          inside += values[k] < 0;
        }
        if (inside > 0 && inside < 4) emit(nodes, values);
      }
    }
  });
}

// Where the surface crosses a lattice edge. Kept off the nodes, where triangles would degenerate.
CellCorner cross_edge(const Lattice& lattice, Node a, Node b, double value_a, double value_b) {
  if (b < a) {
    std::swap(a, b);
    std::swap(value_a, value_b);
  }
  const double t = std::clamp(value_a / (value_a - value_b), 0.15, 0.85);
  const std::int64_t side = 2 * static_cast<std::int64_t>(lattice.nodes_per_side());
  // The sum of the ends is different for every edge.
  const std::int64_t key = ((a[2] + b[2]) * side + a[1] + b[1]) * side + a[0] + b[0];
  return {key, (1 - t) * lattice.position(a) + t * lattice.position(b)};
}

class Collector {
 public:
  explicit Collector(const Lattice& lattice) : lattice_(lattice) {}

  void add(const std::array<Node, 4>& nodes, const std::array<double, 4>& values) {
    std::array<int, 4> in{}, out{};
    int in_count = 0, out_count = 0;
    Eigen::Vector3d outward = Eigen::Vector3d::Zero();
    for (int k = 0; k < 4; ++k) (values[k] < 0 ? in[in_count++] : out[out_count++]) = k;
    for (int i = 0; i < in_count; ++i) outward -= lattice_.position(nodes[in[i]]) / in_count;
    for (int i = 0; i < out_count; ++i) outward += lattice_.position(nodes[out[i]]) / out_count;
    const auto cross = [&](int i, int j) {
      return cross_edge(lattice_, nodes[in[i]], nodes[out[j]], values[in[i]], values[out[j]]);
    };
    if (in_count == 1) return add_triangle(cross(0, 0), cross(0, 1), cross(0, 2), outward);
    if (out_count == 1) return add_triangle(cross(0, 0), cross(1, 0), cross(2, 0), outward);
    const CellCorner a = cross(0, 0), b = cross(0, 1), c = cross(1, 1), d = cross(1, 0);
    if ((a.position - c.position).squaredNorm() <= (b.position - d.position).squaredNorm()) {
      add_triangle(a, b, c, outward);
      add_triangle(a, c, d, outward);
    } else {
      add_triangle(a, b, d, outward);
      add_triangle(b, c, d, outward);
    }
  }

  std::int64_t triangle_count() const { return static_cast<std::int64_t>(corners_.size() / 3); }

  TriangleMesh mesh() const {
    std::vector<CellCorner> unique = corners_;
    const auto before = [](const CellCorner& a, const CellCorner& b) { return a.key < b.key; };
    std::sort(unique.begin(), unique.end(), before);
    unique.erase(std::unique(unique.begin(), unique.end(), [](auto& a, auto& b) { return a.key == b.key; }),
                 unique.end());
    TriangleMesh mesh;
    mesh.vertices.resize(static_cast<std::int64_t>(unique.size()), 3);
    for (std::size_t i = 0; i < unique.size(); ++i) mesh.vertices.row(i) = unique[i].position.transpose();
    mesh.triangles.resize(static_cast<std::int64_t>(corners_.size() / 3), 3);
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const auto place = std::lower_bound(unique.begin(), unique.end(), corners_[i], before);
      mesh.triangles.data()[i] = static_cast<std::int32_t>(place - unique.begin());
    }
    return mesh;
  }

 private:
  void add_triangle(const CellCorner& a, const CellCorner& b, const CellCorner& c, const Eigen::Vector3d& outward) {
    const bool ok = (b.position - a.position).cross(c.position - a.position).dot(outward) > 0;
    corners_.push_back(a);
    corners_.push_back(ok ? b : c);
    corners_.push_back(ok ? c : b);
  }

  const Lattice& lattice_;
  std::vector<CellCorner> corners_;
};

void project(const Lattice& lattice, Vertices& vertices) {
  for (std::int64_t v = 0; v < vertices.rows(); ++v) {
    const Sample s = lattice.sample(vertices.row(v).transpose());
    const double square = s.gradient.squaredNorm();
    if (square < 1e-4) continue;  // a crease, where gradients cancel
    Eigen::Vector3d step = -s.value / square * s.gradient;
    const double length = step.norm(), longest = lattice.unit();
    if (length > longest) step *= longest / length;
    vertices.row(v) += step.transpose();
  }
}

void relax(const Lattice& lattice, TriangleMesh& mesh) {
  Vertices sum = Vertices::Zero(mesh.vertices.rows(), 3);
  std::vector<int> count(static_cast<std::size_t>(mesh.vertices.rows()));
  for (std::int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = mesh.triangles(t, k);
      sum.row(v) +=
          mesh.vertices.row(mesh.triangles(t, (k + 1) % 3)) + mesh.vertices.row(mesh.triangles(t, (k + 2) % 3));
      count[v] += 2;
    }
  }
  for (std::int64_t v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) += 0.6 * (sum.row(v) / count[v] - mesh.vertices.row(v));
  }
  project(lattice, mesh.vertices);
}

}  // namespace

TriangleMesh polygonize(const ImplicitSurface& surface, const Grid& grid, std::int64_t faces, double tolerance) {
  double cell = grid.first_cell;
  for (int attempt = 0;; ++attempt) {
    Lattice lattice(surface, grid.half_width, cell);
    Collector collector(lattice);
    for_each_tetrahedron(lattice, [&](const auto& nodes, const auto& values) { collector.add(nodes, values); });
    // The count goes with the inverse square of the cell.
    const double ratio = static_cast<double>(collector.triangle_count()) / static_cast<double>(faces);
    if (std::abs(ratio - 1) > tolerance && attempt < most_attempts) {
      cell *= std::sqrt(std::clamp(ratio, 0.01, 100.0));
      continue;
    }
    TriangleMesh mesh = collector.mesh();
    project(lattice, mesh.vertices);
    for (int i = 0; i < grid.relaxations; ++i) relax(lattice, mesh);
    return mesh;
  }
}

}  // namespace encage::octopus
