// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/replay/exact_touch.h"

#include "cagegen/certify/box_tree.h"
#include "cagegen/certify/exact.h"
#include "oracles/exact_pair.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <utility>

namespace encage::replay {
namespace {

using proof::BoxTree;
using proof::Corners;

struct CentredBox {
  Eigen::Vector3d middle, half;
};

CentredBox box_of(const BoxTree::Node& node) {
  const Eigen::Map<const Eigen::Vector3d> low(node.low), high(node.high);
  return {0.5 * (low + high), 0.5 * (high - low)};
}

/// Beside one of the box's own faces by more than `slack`; `map` leads from the frame of `other` to that of `box`.
bool beside(const CentredBox& box, const CentredBox& other, const Eigen::Affine3d& map, double slack) {
  const Eigen::Array3d gap = (map * other.middle - box.middle).array().abs() - box.half.array() -
                             (map.linear().cwiseAbs() * other.half).array();
  return (gap > slack).any();
}

/// All corners of t on one side of the plane of p, by more than corners off by `slack` / 1000 can explain.
bool beside_plane(const Corners& p, const Corners& t, double slack) {
  const Eigen::Vector3d e = p[1] - p[0], f = p[2] - p[0], n = e.cross(f);
  const Eigen::Vector3d d[3] = {t[0] - p[0], t[1] - p[0], t[2] - p[0]};
  const double edges = e.norm() + f.norm();
  const double reach = slack * edges * (edges + d[0].norm() + d[1].norm() + d[2].norm());
  const double height[3] = {n.dot(d[0]), n.dot(d[1]), n.dot(d[2])};
  return (height[0] > reach && height[1] > reach && height[2] > reach) ||
         (height[0] < -reach && height[1] < -reach && height[2] < -reach);
}

bool triangle_boxes_apart(const Corners& s, const Corners& t, double slack) {
  const Eigen::Array3d low_s = s[0].cwiseMin(s[1]).cwiseMin(s[2]), high_s = s[0].cwiseMax(s[1]).cwiseMax(s[2]);
  const Eigen::Array3d low_t = t[0].cwiseMin(t[1]).cwiseMin(t[2]), high_t = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
  return (low_s > high_t + slack).any() || (low_t > high_s + slack).any();
}

Corners moved(const Eigen::Affine3d& map, const Corners& t) { return {map * t[0], map * t[1], map * t[2]}; }

TriangleMesh alone(const Corners& t) {
  TriangleMesh mesh{Vertices(3, 3), Triangles(1, 3)};
  for (int k = 0; k < 3; ++k) mesh.vertices.row(k) = t[k].transpose();
  mesh.triangles << 0, 1, 2;
  return mesh;
}

test::ExactBody exact(const TriangleMesh& mesh, const Eigen::Isometry3d& pose) {
  return {Eigen::Vector3d::Zero(), mesh, pose};
}

}  // namespace

struct ExactTouch::Data {
  TriangleMesh mesh;
  bool closed;
  BoxTree tree;
  Eigen::AlignedBox3d bounds;
  double size;                                        ///< largest coordinate
  std::vector<std::vector<std::int32_t>> components;  ///< their triangles

  Data(TriangleMesh given, bool is_closed)
      : mesh(std::move(given)),
        closed(is_closed),
        tree(mesh),
        bounds(encage::bounds(mesh)),
        size(mesh.vertices.cwiseAbs().maxCoeff()) {
    std::vector<std::int32_t> label;
    components.resize(static_cast<std::size_t>(triangle_components(mesh, label)));
    for (std::size_t t = 0; t < label.size(); ++t) components[label[t]].push_back(static_cast<std::int32_t>(t));
  }
};

/// Two posed copies of the mesh. Places computed in double only leave out what is apart by far more than their errors.
struct ExactTouch::Pair {
  const Data& body;
  const Eigen::Isometry3d& a;
  const Eigen::Isometry3d& b;
  Eigen::Affine3d b_to_a, a_to_b;
  double slack;

  Pair(const Data& data, const Eigen::Isometry3d& pose_a, const Eigen::Isometry3d& pose_b)
      : body(data), a(pose_a), b(pose_b) {
    b_to_a = Eigen::Affine3d(a).inverse() * Eigen::Affine3d(b);
    a_to_b = Eigen::Affine3d(b).inverse() * Eigen::Affine3d(a);
    slack = 1e-12 * (body.size + a.translation().norm() + b.translation().norm());
  }

  bool apart(std::int32_t i, std::int32_t j) const {
    const CentredBox box_a = box_of(body.tree.nodes[i]), box_b = box_of(body.tree.nodes[j]);
    return beside(box_a, box_b, b_to_a, slack) || beside(box_b, box_a, a_to_b, slack);
  }

  bool triangles_touch(std::int32_t i, std::int32_t j) const {
    const Corners s = proof::corners(body.mesh, i), other = proof::corners(body.mesh, j), t = moved(b_to_a, other);
    if (triangle_boxes_apart(s, t, slack) || beside_plane(s, t, slack) || beside_plane(t, s, slack)) return false;
    return test::surfaces_meet(exact(alone(s), a), exact(alone(other), b), 0);
  }

  bool leaves_touch(const BoxTree::Node& m, const BoxTree::Node& n) const {
    for (std::int32_t i = m.first; i < m.first + m.count; ++i) {
      for (std::int32_t j = n.first; j < n.first + n.count; ++j) {
        if (triangles_touch(body.tree.order[i], body.tree.order[j])) return true;
      }
    }
    return false;
  }

  bool surfaces_touch() const {
    const std::vector<BoxTree::Node>& nodes = body.tree.nodes;
    std::vector<std::pair<std::int32_t, std::int32_t>> stack = {{0, 0}};
    while (!stack.empty()) {
      const auto [i, j] = stack.back();
      stack.pop_back();
      if (apart(i, j)) continue;
      const bool leaf_i = nodes[i].count != 0, leaf_j = nodes[j].count != 0;
      if (leaf_i && leaf_j) {
        if (leaves_touch(nodes[i], nodes[j])) return true;
      } else if (leaf_j || (!leaf_i && box_of(nodes[i]).half.squaredNorm() > box_of(nodes[j]).half.squaredNorm())) {
        for (const int child : {0, 1}) stack.emplace_back(nodes[i].first + child, j);
      } else {
        for (const int child : {0, 1}) stack.emplace_back(i, nodes[j].first + child);
      }
    }
    return false;
  }

  /// A component of the guest lies in the host's box: only then can it lie in the solid.
  bool may_hold(const Eigen::Affine3d& guest_to_host) const {
    const Eigen::AlignedBox3d box(body.bounds.min().array() - slack, body.bounds.max().array() + slack);
    return std::any_of(body.components.begin(), body.components.end(), [&](const std::vector<std::int32_t>& part) {
      return std::all_of(part.begin(), part.end(), [&](std::int32_t t) {
        const Corners c = moved(guest_to_host, proof::corners(body.mesh, t));
        return box.contains(c[0]) && box.contains(c[1]) && box.contains(c[2]);
      });
    });
  }

  bool solids_overlap() const {
    if (!body.closed) return false;
    return (may_hold(b_to_a) && test::holds_component(exact(body.mesh, a), exact(body.mesh, b))) ||
           (may_hold(a_to_b) && test::holds_component(exact(body.mesh, b), exact(body.mesh, a)));
  }
};

ExactTouch::ExactTouch(TriangleMesh mesh, bool closed) : data_(std::make_unique<Data>(std::move(mesh), closed)) {}
ExactTouch::~ExactTouch() = default;

bool ExactTouch::touch(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) const {
  const Pair pair(*data_, a, b);
  return !pair.apart(0, 0) && (pair.surfaces_touch() || pair.solids_overlap());
}

std::vector<BodyPair> ExactTouch::touching(const PoseStep& step) const {
  std::vector<BodyPair> pairs;
  for (std::size_t i = 0; i < step.bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < step.bodies.size(); ++j) {
      const BodyPose &a = step.bodies[i], &b = step.bodies[j];
      if (touch(a.pose, b.pose)) pairs.push_back({a.body, b.body});
    }
  }
  return pairs;
}

}  // namespace encage::replay
