// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What a cage should be like, besides enclosing: E(F, C^, C) of Nested Cages, section 3.2. Offline side.

#include <encage/export.h>
#include <encage/mesh.h>

#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace ENCAGE_EXPORT encage {

/// What an energy may look at; all in the local frame, all kept by the caller during the call.
struct EnergyState {
  const TriangleMesh& fine;    ///< F at its own place: what the cage encloses in the end
  const TriangleMesh& rest;    ///< the coarse mesh as decimated, C^; the cage has its triangles
  const Vertices& step_start;  ///< the cage at the beginning of the time step
  const Vertices& cage;        ///< where the energy is asked for
};

/// Derive from it for an energy of your own. value() and gradient() must agree; they are called from one thread at a
/// time and must not depend on anything but their arguments, or the same input gives other bytes.
class CageEnergy {
 public:
  virtual ~CageEnergy() = default;

  /// Recorded in the asset's options.
  virtual std::string name() const = 0;
  /// In any unit.
  virtual double value(const EnergyState& state) const = 0;
  /// d value / d cage, one row a vertex.
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
/// The same from where the time step began: eq. 12. Name "step".
EnergyPtr step_energy();
/// Enclosed volume: eq. 13. Name "volume". Always the same object; as final energy it is followed by the tightening of
/// single vertices.
EnergyPtr volume_energy();

/// By name; throws Error, which lists the names, for another one.
EnergyPtr find_energy(std::string_view name);

}  // namespace encage
