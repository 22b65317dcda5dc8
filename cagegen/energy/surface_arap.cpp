// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/energy/edges.h"

#include <encage/energy.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>

#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace encage {

namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

/// What depends on the triangles alone.
struct Connectivity {
  Triangles triangles;
  std::int64_t vertex_count = 0;
  std::vector<Edge> edges;
  /// The Hessian of the energy with the rotations held, which does not see a translation of a component, plus a little.
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> hessian;

  Connectivity(const Triangles& t, std::int64_t n) : triangles(t), vertex_count(n), edges(edges_of(t)) {
    constexpr double little = 1e-6;
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(4 * edges.size() + static_cast<std::size_t>(n));
    for (std::int32_t v = 0; v < n; ++v) entries.emplace_back(v, v, little);
    for (const auto& [a, b] : edges) {
      entries.emplace_back(a, a, 4);
      entries.emplace_back(b, b, 4);
      entries.emplace_back(a, b, -4);
      entries.emplace_back(b, a, -4);
    }
    Eigen::SparseMatrix<double> matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    hessian.compute(matrix);
  }
};

/// As rigid as possible: every vertex's edges are those of C^, turned as a whole, eq. 14 with its uniform weights.
class SurfaceArapEnergy final : public CageEnergy {
 public:
  std::string name() const override { return "sarap"; }
  int degree() const override { return 2; }

  double value(const EnergyState& state) const override {
    const auto shared = connectivity(state);
    const Rotations rotation = rotations(state, shared->edges);
    double sum = 0;
    for (const auto& [a, b] : shared->edges) {
      const Eigen::Vector3d rest = edge(state.rest.vertices, a, b), now = edge(state.cage, a, b);
      sum += (now - rotation[a] * rest).squaredNorm() + (now - rotation[b] * rest).squaredNorm();
    }
    return sum;
  }

  /// The rotations are optimal, so that the derivative is that with the rotations held.
  Vertices gradient(const EnergyState& state) const override { return gradient(state, connectivity(state)->edges); }

  /// The global step of Sorkine & Alexa: to the minimum with the rotations held.
  Vertices descent(const EnergyState& state) const override {
    const auto shared = connectivity(state);
    return -shared->hessian.solve(Eigen::MatrixXd(gradient(state, shared->edges)));
  }
  std::optional<double> first_step() const override { return 1; }

 private:
  static Eigen::Vector3d edge(const Vertices& vertices, std::int32_t a, std::int32_t b) {
    return (vertices.row(a) - vertices.row(b)).transpose();
  }

  /// The local step: the best rotation of each vertex's edges.
  static Rotations rotations(const EnergyState& state, const std::vector<Edge>& edges) {
    Rotations result(static_cast<std::size_t>(state.cage.rows()), Eigen::Matrix3d::Zero());
    for (const auto& [a, b] : edges) {
      const Eigen::Matrix3d product = edge(state.cage, a, b) * edge(state.rest.vertices, a, b).transpose();
      result[a] += product;
      result[b] += product;
    }
    for (Eigen::Matrix3d& r : result) {
      const Eigen::JacobiSVD<Eigen::Matrix3d> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
      Eigen::Matrix3d left = svd.matrixU();
      if ((left * svd.matrixV().transpose()).determinant() < 0) left.col(2) = -left.col(2);
      r = left * svd.matrixV().transpose();
    }
    return result;
  }

  static Vertices gradient(const EnergyState& state, const std::vector<Edge>& edges) {
    const Rotations rotation = rotations(state, edges);
    Vertices result = Vertices::Zero(state.cage.rows(), 3);
    for (const auto& [a, b] : edges) {
      const Eigen::Vector3d rest = edge(state.rest.vertices, a, b), now = edge(state.cage, a, b);
      const Eigen::RowVector3d pull = (4 * now - 2 * (rotation[a] * rest + rotation[b] * rest)).transpose();
      result.row(a) += pull;
      result.row(b) -= pull;
    }
    return result;
  }

  /// Kept from call to call: a minimisation asks for the same triangles again and again.
  std::shared_ptr<const Connectivity> connectivity(const EnergyState& state) const {
    const std::lock_guard lock(mutex_);
    const Triangles& triangles = state.rest.triangles;
    if (!last_ || last_->vertex_count != state.cage.rows() || last_->triangles.rows() != triangles.rows() ||
        last_->triangles != triangles) {
      last_ = std::make_shared<Connectivity>(triangles, state.cage.rows());
    }
    return last_;
  }

  mutable std::mutex mutex_;
  mutable std::shared_ptr<const Connectivity> last_;
};

}  // namespace

EnergyPtr surface_arap_energy() {
  static const EnergyPtr energy = std::make_shared<SurfaceArapEnergy>();
  return energy;
}

}  // namespace encage
