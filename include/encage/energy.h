// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What a cage minimises while it encloses its mesh: E(F, C^, C) of Nested Cages, section 3.2. Offline side.

#include <encage/export.h>
#include <encage/mesh.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ENCAGE_EXPORT encage {

/// The input of an energy, in the local frame. The caller keeps it alive during the call.
struct EnergyState {
  const TriangleMesh& fine;    ///< F at its home position: what the cage encloses in the end
  const TriangleMesh& rest;    ///< the coarse mesh as decimated, C^; the cage has its triangles
  const Vertices& step_start;  ///< the cage at the beginning of the time step
  const Vertices& cage;        ///< the positions at which the energy is evaluated
};

/// Base class for energies of your own. value() and gradient() must agree and depend on their arguments alone, or the
/// same input gives other bytes. One thread at a time calls them.
class CageEnergy {
 public:
  virtual ~CageEnergy() = default;

  /// The name that the asset's options record.
  virtual std::string name() const = 0;
  /// The energy, in any unit.
  virtual double value(const EnergyState& state) const = 0;
  /// The derivative of value() by the cage's positions, one row per vertex.
  virtual Vertices gradient(const EnergyState& state) const = 0;
  /// The direction of descent, one row a vertex; contacts then filter it. By default the negative gradient, divided by
  /// each vertex's area (a third of that of its triangles in C^).
  virtual Vertices descent(const EnergyState& state) const;
  /// How many times the descent a first step goes; shorter ones follow where that does not lower the energy. No value,
  /// the default: as many as move the cage by a few percent of its edges.
  virtual std::optional<double> first_step() const { return std::nullopt; }
  /// The power of a length that the value grows with: a scene of twice the size has 2^degree() times the value.
  /// weighted_sum() makes the weights independent of the unit of length by it. By default 3, as of a volume.
  virtual int degree() const { return 3; }
};

using EnergyPtr = std::shared_ptr<const CageEnergy>;

/// Squared displacement from C^, weighted by area: eq. 11. Name "start".
EnergyPtr start_energy();
/// Squared displacement from the beginning of the time step, weighted by area: eq. 12. Name "step".
EnergyPtr step_energy();
/// Enclosed volume: eq. 13. Name "volume". Always the same object; as final energy it is followed by the tightening of
/// single vertices.
EnergyPtr volume_energy();

/// How far the cage's surface is from C^ turned and bent: as rigid as possible (Sorkine & Alexa 2007, "As-rigid-as-
/// possible surface modeling"), eq. 14, with the uniform weights of the equation. A square of a length. Keeps shape and
/// spacing of the coarse triangles, at the price of a looser fit. Name "sarap".
EnergyPtr surface_arap_energy();

struct WeightedEnergy {
  double weight = 1;  ///< > 0, finite
  EnergyPtr energy;
};

/// The sum of energies, in units of a volume: each is multiplied by its weight and by the power of the diagonal of C^
/// that its degree() leaves of 3. So the same weights serve a model in metres and in millimetres. The name is that of
/// the terms, as in "volume+0.1*sarap". A single energy of weight 1 is returned as it is. Throws Error for no terms, a
/// null energy, and a weight that is not positive and finite, with the energy's name.
EnergyPtr weighted_sum(std::vector<WeightedEnergy> terms);

/// The energy of this name, or a weighted_sum() of names: "volume+0.1*sarap". Throws Error, which lists the names, if
/// there is none, and for a weight that is not a positive number.
EnergyPtr find_energy(std::string_view name);

}  // namespace encage
