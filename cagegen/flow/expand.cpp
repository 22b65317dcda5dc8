// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/flow/expand.h"

#include "cagegen/flow/pull.h"
#include "cagegen/flow/signed_distance.h"

#include <algorithm>
#include <vector>

namespace encage::makers {

namespace {

/// Sums of weighted moves, per vertex.
class Moves {
 public:
  explicit Moves(std::size_t count) : sum_(count, Point::Zero()), weight_(count, 0) {}

  void add(std::int32_t vertex, double weight, const Point& move) {
    sum_[vertex] += weight * move;
    weight_[vertex] += weight;
  }
  Point mean(std::size_t vertex, double longest) const {
    if (weight_[vertex] == 0) return Point::Zero();
    const Point move = sum_[vertex] / weight_[vertex];
    return move.norm() > longest ? Point(move.normalized() * longest) : move;
  }

 private:
  std::vector<Point> sum_;
  std::vector<double> weight_;
};

TriangleMesh part(const TriangleMesh& mesh, std::span<const std::int32_t> triangles) {
  TriangleMesh result;
  result.vertices = mesh.vertices;
  result.triangles.resize(static_cast<std::int64_t>(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    result.triangles.row(static_cast<std::int64_t>(i)) = mesh.triangles.row(triangles[i]);
  }
  return result;
}

}  // namespace

TriangleMesh expand(const TriangleMesh& coarse, const TriangleMesh& flowed, std::span<const std::int32_t> stuck,
                    double gap, double reach, const ContactSolverOptions& options) {
  ContactSolver solver(coarse, options);
  const SignedDistance distance(flowed, Sign::winding);
  const Obstacle cutting(part(flowed, stuck));
  Moves moves(solver.positions().size());
  for (std::size_t f = 0; f < solver.face_count(); ++f) {
    const auto& face = solver.face(f);
    const Corners corner{solver.positions()[face[0]], solver.positions()[face[1]], solver.positions()[face[2]]};
    std::int32_t start = 0;
    for (const auto& weight : quadrature_weights) {
      const Point p = weight[0] * corner[0] + weight[1] * corner[1] + weight[2] * corner[2];
      const Nearest nearest = distance.nearest(p, start);
      start = nearest.triangle;
      if (nearest.distance >= gap) continue;
      for (int k = 0; k < 3; ++k) moves.add(face[k], weight[k], (gap - nearest.distance) * nearest.direction);
    }
    const Prism prism(corner);
    if (!prism.valid || !cutting.hit(prism, gap)) continue;
    for (const std::int32_t v : face) moves.add(v, 1, reach * prism.normal);
  }
  ContactSolver::Positions wanted = solver.positions();
  for (std::size_t v = 0; v < wanted.size(); ++v) wanted[v] += moves.mean(v, reach);
  // Nothing else is in the way: F is still being moved.
  const Obstacle nothing{TriangleMesh()};
  solver.commit(solver.approach(nothing, wanted));
  return solver.mesh();
}

}  // namespace encage::makers
