// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <string>
#include <vector>

namespace encage::handmade {

/// A thin or slotted shape, about 1 large, and the cage that a person would draw around it.
struct Subject {
  std::string name;
  std::string built;  ///< "one surface", or "overlapping boxes" as programs export them
  TriangleMesh mesh;
  TriangleMesh cage;  ///< empty for leaf cards: a person would have no better idea
};

/// Ten solids, then a tree of leaf cards, which encloses nothing.
std::vector<Subject> subjects();

}  // namespace encage::handmade
