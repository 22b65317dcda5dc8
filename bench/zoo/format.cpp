// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/format.h"

#include <algorithm>

namespace encage::zoo {

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
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

std::string escaped(std::string cell) {
  for (std::size_t i = 0; (i = cell.find('|', i)) != std::string::npos; i += 2) cell.insert(i, 1, '\\');
  std::replace(cell.begin(), cell.end(), '\n', ' ');
  return cell;
}

}  // namespace encage::zoo
