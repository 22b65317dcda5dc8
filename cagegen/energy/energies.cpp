// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/energy/vertex_areas.h"

#include <encage/energy.h>

#include <array>
#include <cstdint>
#include <string>

namespace encage {

namespace {

/// sum over vertices of area |C - origin|^2, eq. 11 and 12.
class Displacement : public CageEnergy {
 public:
  double value(const EnergyState& state) const override {
    const Eigen::VectorXd area = vertex_areas(state.rest);
    return area.dot((state.cage - origin(state)).rowwise().squaredNorm());
  }

  Vertices gradient(const EnergyState& state) const override {
    return 2 * (vertex_areas(state.rest).asDiagonal() * (state.cage - origin(state)));
  }

  int degree() const override { return 4; }

  /// Newton's step: half the gradient over the area leads to the origin.
  std::optional<double> first_step() const override { return 0.5; }

 private:
  virtual const Vertices& origin(const EnergyState& state) const = 0;
};

class StartEnergy final : public Displacement {
  std::string name() const override { return "start"; }
  const Vertices& origin(const EnergyState& state) const override { return state.rest.vertices; }
};

class StepEnergy final : public Displacement {
  std::string name() const override { return "step"; }
  const Vertices& origin(const EnergyState& state) const override { return state.step_start; }
};

/// Enclosed volume, eq. 13.
class VolumeEnergy final : public CageEnergy {
 public:
  std::string name() const override { return "volume"; }
  int degree() const override { return 3; }

  double value(const EnergyState& state) const override {
    // Relative to a vertex: the sum stays small far from the origin.
    const Eigen::Vector3d reference = state.cage.row(0).transpose();
    double sum = 0;
    for (std::int64_t t = 0; t < state.rest.triangles.rows(); ++t) {
      const auto corner = [&](int k) -> Eigen::Vector3d {
        return state.cage.row(state.rest.triangles(t, k)).transpose() - reference;
      };
      sum += corner(0).dot(corner(1).cross(corner(2)));
    }
    return sum / 6;
  }

  /// A third of the area normals around each vertex.
  Vertices gradient(const EnergyState& state) const override {
    Vertices result = Vertices::Zero(state.cage.rows(), 3);
    for (std::int64_t t = 0; t < state.rest.triangles.rows(); ++t) {
      const auto corner = [&](int k) -> Eigen::Vector3d {
        return state.cage.row(state.rest.triangles(t, k)).transpose();
      };
      const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)) / 6;
      for (int k = 0; k < 3; ++k) result.row(state.rest.triangles(t, k)) += normal.transpose();
    }
    return result;
  }

  /// All vertices at one speed: divided by the area, those of sharp tips would lag behind.
  Vertices descent(const EnergyState& state) const override {
    Vertices result = -gradient(state);
    for (std::int64_t v = 0; v < result.rows(); ++v) {
      const double length = result.row(v).norm();
      if (length > 0) result.row(v) /= length;
    }
    return result;
  }
};

}  // namespace

Vertices CageEnergy::descent(const EnergyState& state) const {
  Vertices result = -gradient(state);
  const Eigen::VectorXd area = vertex_areas(state.rest);
  for (std::int64_t v = 0; v < result.rows(); ++v) {
    if (area[v] > 0) result.row(v) /= area[v];
  }
  return result;
}

EnergyPtr start_energy() {
  static const EnergyPtr energy = std::make_shared<StartEnergy>();
  return energy;
}

EnergyPtr step_energy() {
  static const EnergyPtr energy = std::make_shared<StepEnergy>();
  return energy;
}

EnergyPtr volume_energy() {
  static const EnergyPtr energy = std::make_shared<VolumeEnergy>();
  return energy;
}

}  // namespace encage
