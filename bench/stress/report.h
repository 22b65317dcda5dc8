// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/stress/run.h"

#include <nlohmann/json.hpp>

#include <string>

namespace encage::stress {

/// A heading and a table of the layers, as Markdown that reads well on a terminal, too.
std::string to_markdown(const Job& job, const Outcome& outcome);

/// `name`, `title`, `model`, `input_faces`, `failure` (null if none), `cpu_seconds`, `layers[]`.
nlohmann::ordered_json to_json(const Job& job, const Outcome& outcome);

}  // namespace encage::stress
