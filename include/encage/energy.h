// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What a cage minimises while it encloses its mesh: E(F, C^, C) of Nested Cages, section 3.2. Offline side.

#include <encage/export.h>
#include <encage/mesh.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

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
};

using EnergyPtr = std::shared_ptr<const CageEnergy>;

/// Squared displacement from C^, weighted by area: eq. 11. Name "start".
EnergyPtr start_energy();
/// Squared displacement from the beginning of the time step, weighted by area: eq. 12. Name "step".
EnergyPtr step_energy();
/// Enclosed volume: eq. 13. Name "volume". Always the same object; as final energy it is followed by the tightening of
/// single vertices.
EnergyPtr volume_energy();

/// The energy of this name. Throws Error, which lists the names, if there is none.
EnergyPtr find_energy(std::string_view name);

}  // namespace encage
