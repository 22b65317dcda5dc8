// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/plain_methods.h"

#include "cagegen/collapse/starts.h"
#include "cagegen/flow/signed_distance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace encage::zoo {

using Eigen::Vector3d;

DistanceGrid::DistanceGrid(const TriangleMesh& mesh, bool closed, int cells, double reach) {
  const makers::SignedDistance field(mesh);
  const Eigen::AlignedBox3d box = bounds(mesh);
  cell_ = (box.sizes().maxCoeff() + 2 * reach) / (cells - 2);
  low_ = box.min().array() - reach - cell_;
  for (int axis = 0; axis < 3; ++axis) {
    count_[axis] = static_cast<int>(std::ceil((box.sizes()[axis] + 2 * reach) / cell_)) + 3;
  }
  // Far from the surface, the value at one node of each block stands for all: distances change no faster than space.
  constexpr int block = 4;
  const double width = block * std::sqrt(3.0) * cell_;
  values_.resize(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2]);
  std::int32_t triangle = 0;  // the nearest one of the node before
  const auto signed_distance = [&](const GridNode& n) {
    const makers::Nearest nearest = field.nearest(position(n), triangle);
    triangle = nearest.triangle;
    return closed ? nearest.distance : std::abs(nearest.distance);
  };
  for (GridNode first{0, 0, 0}; first.z < count_[2]; first.z += block) {
    for (first.y = 0; first.y < count_[1]; first.y += block) {
      for (first.x = 0; first.x < count_[0]; first.x += block) {
        const double near = signed_distance(first);
        for (GridNode n = first; n.z < std::min(first.z + block, count_[2]); ++n.z) {
          for (n.y = first.y; n.y < std::min(first.y + block, count_[1]); ++n.y) {
            for (n.x = first.x; n.x < std::min(first.x + block, count_[0]); ++n.x) {
              const bool far = near > reach + width || near < -width - cell_;
              values_[index(n)] = far ? near : signed_distance(n);
            }
          }
        }
      }
    }
  }
}

TriangleMesh DistanceGrid::contour(double distance) const {
  // Each cell is cut into the six tetrahedra around its diagonal (Kuhn 1960).
  constexpr int path[6][2] = {{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}};
  struct Corner {
    std::array<std::int64_t, 2> edge;
    Vector3d place;
  };
  std::vector<Corner> corners;
  const auto corner_of = [&](const GridNode& n, int i) {
    return GridNode{n.x + (i & 1), n.y + (i >> 1 & 1), n.z + (i >> 2)};
  };
  const auto cross = [&](GridNode a, GridNode b) {
    if (index(b) < index(a)) std::swap(a, b);
    const double va = values_[index(a)] - distance;
    const double vb = values_[index(b)] - distance;
    const double t = std::clamp(va / (va - vb), 0.01, 0.99);
    return Corner{{index(a), index(b)}, (1 - t) * position(a) + t * position(b)};
  };
  const auto emit = [&](const Corner& a, const Corner& b, const Corner& c, const Vector3d& outward) {
    const bool turned = (b.place - a.place).cross(c.place - a.place).dot(outward) < 0;
    corners.insert(corners.end(), {a, turned ? c : b, turned ? b : c});
  };
  const auto cut = [&](const std::array<GridNode, 4>& node) {
    std::vector<GridNode> in;
    std::vector<GridNode> out;
    Vector3d outward = Vector3d::Zero();
    for (const GridNode& n : node) (values_[index(n)] < distance ? in : out).push_back(n);
    if (in.empty() || out.empty()) return;
    for (const GridNode& n : in) outward -= position(n) / static_cast<double>(in.size());
    for (const GridNode& n : out) outward += position(n) / static_cast<double>(out.size());
    std::vector<Corner> c;
    for (const GridNode& i : in) {
      for (const GridNode& o : out) c.push_back(cross(i, o));
    }
    emit(c[0], c[1], c[2], outward);
    if (c.size() == 4) emit(c[1], c[3], c[2], outward);
  };
  for (GridNode n{0, 0, 0}; n.z + 1 < count_[2]; ++n.z) {
    for (n.y = 0; n.y + 1 < count_[1]; ++n.y) {
      for (n.x = 0; n.x + 1 < count_[0]; ++n.x) {
        for (const auto& middle : path) {
          cut({n, corner_of(n, middle[0]), corner_of(n, middle[1]), corner_of(n, 7)});
        }
      }
    }
  }
  std::vector<std::int32_t> order(corners.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int32_t>(i);
  std::sort(order.begin(), order.end(),
            [&](std::int32_t a, std::int32_t b) { return corners[a].edge < corners[b].edge; });
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::int64_t>(corners.size()), 3);
  mesh.triangles.resize(static_cast<std::int64_t>(corners.size() / 3), 3);
  std::int32_t count = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Corner& corner = corners[order[i]];
    if (i == 0 || corner.edge != corners[order[i - 1]].edge) mesh.vertices.row(count++) = corner.place.transpose();
    mesh.triangles.data()[order[i]] = count - 1;
  }
  mesh.vertices.conservativeResize(count, 3);
  return makers::outermost_components(mesh);
}

}  // namespace encage::zoo
