// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/contact/minimize.h"

#include <encage/error.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace encage::makers {

namespace {

constexpr double negligible = 2e-5;        // share of the energy below which the gain of a step does not count
constexpr double usual_first_step = 0.03;  // share of the mean edge length
// Without momentum, steps along the obstacle zigzag and gain half as much.
constexpr double momentum_factor = 0.8;

Vertices to_matrix(const ContactSolver::Positions& positions) {
  Vertices matrix(static_cast<std::int64_t>(positions.size()), 3);
  for (std::size_t v = 0; v < positions.size(); ++v)
    matrix.row(static_cast<std::int64_t>(v)) = positions[v].transpose();
  return matrix;
}

/// About the edge length that the cage's triangles would have if they were equal and equilateral.
double edge_length(const ContactSolver& solver) {
  double area = 0;
  for (std::size_t f = 0; f < solver.face_count(); ++f) {
    const auto& face = solver.face(f);
    const Point& a = solver.positions()[face[0]];
    area += (solver.positions()[face[1]] - a).cross(solver.positions()[face[2]] - a).norm() / 2;
  }
  return std::sqrt(area / static_cast<double>(solver.face_count()));
}

/// Weights of the vertices with which `direction` is the steepest descent: contacts then stop the cage where the energy
/// has a minimum, and not where vertices push equally hard. All are 1 in the mean.
std::vector<double> metric(const Vertices& gradient, const Vertices& direction) {
  constexpr double least = 1e-3;  // of the mean
  std::vector<double> weights(static_cast<std::size_t>(gradient.rows()), 0);
  double sum = 0;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    const double length = direction.row(static_cast<std::int64_t>(v)).norm();
    if (length > 0) weights[v] = gradient.row(static_cast<std::int64_t>(v)).norm() / length;
    sum += weights[v];
  }
  const double mean = sum > 0 ? sum / static_cast<double>(weights.size()) : 1;
  for (double& w : weights) w = std::max(w / mean, least);
  return weights;
}

}  // namespace

Vertices checked_descent(const CageEnergy& energy, const EnergyState& state) {
  Vertices direction = energy.descent(state);
  const std::string what = "energy '" + energy.name() + "': ";
  if (direction.rows() != state.cage.rows()) {
    throw Error(what + "a descent of " + std::to_string(direction.rows()) + " rows for " +
                std::to_string(state.cage.rows()) + " vertices");
  }
  if (!direction.allFinite()) throw Error(what + "the descent is not finite");
  return direction;
}

void minimize(ContactSolver& solver, const Obstacle& obstacle, const MinimizeRequest& request) {
  const std::int64_t last_work = solver.work() + request.face_tests;
  Vertices cage = to_matrix(solver.positions());
  const Vertices step_start = cage;
  const auto state = [&](const Vertices& positions) -> EnergyState {
    return {*request.fine, *request.rest, step_start, positions};
  };
  double value = request.energy->value(state(cage));
  const double first_value = value;
  double recent = 0;  // gain of the last steps, the latest counting most
  double step = -1;
  ContactSolver::Positions last;  // the cage before the last step; empty: no momentum
  for (int iteration = 0; iteration < request.iterations && solver.work() < last_work; ++iteration) {
    solver.options().check();
    if (request.progress) request.progress(static_cast<double>(iteration) / request.iterations);
    const Vertices direction = checked_descent(*request.energy, state(cage));
    const double longest = direction.rowwise().norm().maxCoeff();
    if (!(longest > 0)) break;
    // A step of about the mean gap would be best. That gap is costly to find, and since steps adapt, a share of the
    // edge length does as well.
    if (step < 0) step = request.energy->first_step().value_or(usual_first_step * edge_length(solver) / longest);
    if (step * longest < solver.options().clearance * 0.3) break;
    const Vertices gradient = request.energy->gradient(state(cage));
    const double slope = -(gradient.array() * direction.array()).sum();
    ContactSolver::Positions wanted = solver.positions();
    for (std::size_t v = 0; v < wanted.size(); ++v) {
      wanted[v] += step * direction.row(static_cast<std::int64_t>(v)).transpose();
      if (!last.empty()) wanted[v] += momentum_factor * (solver.positions()[v] - last[v]);
    }
    ContactSolver::Positions next = solver.approach(obstacle, wanted, metric(gradient, direction));
    const Vertices next_cage = to_matrix(next);
    const double before = value;
    const double after = request.energy->value(state(next_cage));
    if (after < before && solver.encloses_all(obstacle, next)) {
      last = solver.positions();
      solver.commit(std::move(next));
      cage = next_cage;
      value = after;
    } else {
      last.clear();
    }
    if (before - value < 0.02 * step * slope) step *= 0.6;
    recent = 0.5 * (recent + before - value);
    const double enough = std::max(request.enough * (first_value - value), negligible * std::abs(value));
    if (recent < enough && iteration > 3) break;
  }
}

TriangleMesh shrink(const Obstacle& obstacle, const TriangleMesh& cage, const ContactSolverOptions& options,
                    int iterations) {
  ContactSolver solver(cage, options);
  const EnergyPtr volume = volume_energy();
  MinimizeRequest request;
  request.fine = &cage;
  request.rest = &cage;
  request.energy = volume.get();
  request.iterations = iterations;
  minimize(solver, obstacle, request);
  return solver.mesh();
}

}  // namespace encage::makers
