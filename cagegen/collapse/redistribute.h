// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cagegen/collapse/cage_editor.h"
#include "cagegen/contact/minimize.h"

#include <encage/mesh.h>

#include <cstdint>

namespace encage::makers {

struct RedistributeRequest {
  EditorOptions editing;
  ContactSolverOptions contact;
  std::int64_t faces = 0;  ///< at most, in the result
  int rounds = 1;          ///< at most
  double enough = 0;       ///< a volume, which a round should gain
  int patience = 2;        ///< rounds in a row that gain less are the last
  std::uint64_t work = 0;  ///< triangle tests after which no new round begins
};

/// Moves faces to where they save volume: splits the edges that gain most by it, then merges those that cost least, and
/// keeps what encloses less. The result is as valid as `cage` and encloses no more.
TriangleMesh redistribute_faces(const Obstacle& obstacle, const TriangleMesh& cage, const RedistributeRequest& request);

}  // namespace encage::makers
