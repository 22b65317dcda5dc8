// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/engine.h"
#include "bench/replay/mesh_shape.h"

#include <memory>
#include <string>
#include <vector>

namespace encage::replay {

/// Names that make_engines() knows.
const std::vector<std::string>& engine_names();

/// The engines of a name: one, or for `embree` both ways to update its trees.
std::vector<std::unique_ptr<Engine>> make_engines(const std::string& name, const ReplayBody& body);

}  // namespace encage::replay
