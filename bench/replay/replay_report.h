// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/replay/continuous.h"
#include "bench/replay/replay.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <ostream>

namespace encage::replay {

/// `engines.<name>`, `with_<front>.<name>`, `perfect.<name>`, `disagreements`, …
nlohmann::ordered_json to_json(const Replay& replay, const std::optional<Continuous>& continuous);

/// Tables in Markdown.
void print(std::ostream& out, const Replay& replay, const std::optional<Continuous>& continuous);

/// One line for each, each begun with `prefix`.
void print(std::ostream& out, const std::string& prefix, const std::vector<Disagreement>& disagreements);

}  // namespace encage::replay
