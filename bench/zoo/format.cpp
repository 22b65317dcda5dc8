// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/format.h"

#include "bench/common/statistics.h"

namespace encage::zoo {

std::optional<double> median(const std::vector<double>& values) {
  return values.empty() ? std::nullopt : std::optional(bench::median(values));
}

std::optional<double> volume_ratio(const nlohmann::ordered_json& level) {
  if (level.is_null() || level.at("volume_ratio").is_null()) return std::nullopt;
  return level.at("volume_ratio").get<double>();
}

const char* yes(bool value) { return value ? "yes" : "no"; }

std::string reason(const Model& model) {
  const std::string prefix = model.file.string() + ": ";
  return model.error.starts_with(prefix) ? model.error.substr(prefix.size()) : model.error;
}

}  // namespace encage::zoo
