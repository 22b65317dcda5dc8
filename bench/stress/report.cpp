// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/stress/report.h"

#include "bench/common/report.h"

#include <algorithm>
#include <optional>
#include <sstream>

namespace encage::stress {

namespace {

using bench::format;
using Json = nlohmann::ordered_json;

std::string percent(std::optional<double> value) { return value ? format("%.3f %%", 100 * *value) : "–"; }

/// The text in lines of at most 120 characters.
std::string wrapped(const std::string& text) {
  constexpr std::size_t width = 120;
  std::istringstream words(text);
  std::string result, line;
  for (std::string word; words >> word;) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      result += line + "\n";
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return result + line;
}

/// Returns the largest ratio of a layer's excess to that of a single cage; no value if no layer has both.
std::optional<double> worst_ratio(const Outcome& outcome) {
  std::optional<double> worst;
  for (const Layer& layer : outcome.layers) {
    if (!layer.single_excess || !(*layer.single_excess > 0)) continue;
    worst = std::max(worst.value_or(0), layer.excess / *layer.single_excess);
  }
  return worst;
}

template <class Value>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

std::string to_markdown(const Job& job, const Outcome& outcome) {
  std::ostringstream out;
  out << "## " << job.title << "\n\n";
  bench::MarkdownTable table(out,
                             {"layer", "faces", "volume ratio", "excess", "single cage", "clearance", "genus",
                              "least angle", "5 % angle", "valence", "folds", "s", "method"},
                             5, 9);
  for (std::size_t i = 0; i < outcome.layers.size(); ++i) {
    const Layer& layer = outcome.layers[i];
    table.row({std::to_string(i + 1), std::to_string(layer.faces),
               layer.volume_ratio ? format("%.4f", *layer.volume_ratio) : "–", percent(layer.excess),
               job.beside_single ? percent(layer.single_excess) : "", format("%.1e", layer.clearance),
               std::to_string(layer.genus), format("%.2f", layer.quality.smallest_angle),
               format("%.1f", layer.quality.low_angle), std::to_string(layer.quality.highest_valence),
               std::to_string(layer.quality.folds), format("%.2f", layer.seconds), layer.method});
  }
  out << "\n" << outcome.input_faces << " faces; " << format("%.1f", outcome.cpu_seconds) << " CPU seconds.";
  if (const std::optional<double> worst = worst_ratio(outcome)) {
    out << " Largest excess beside a single cage's: " << format("%.2f", *worst) << " times.";
  }
  out << "\n";
  if (!outcome.failure.empty()) out << "\n" << wrapped("Not made: " + outcome.failure) << "\n";
  return out.str();
}

Json to_json(const Job& job, const Outcome& outcome) {
  Json layers = Json::array();
  for (const Layer& layer : outcome.layers) {
    layers.push_back({{"faces", layer.faces},
                      {"method", layer.method},
                      {"volume_ratio", or_null(layer.volume_ratio)},
                      {"excess", layer.excess},
                      {"single_excess", or_null(layer.single_excess)},
                      {"clearance", layer.clearance},
                      {"genus", layer.genus},
                      {"smallest_angle", layer.quality.smallest_angle},
                      {"low_angle", layer.quality.low_angle},
                      {"highest_valence", layer.quality.highest_valence},
                      {"folds", layer.quality.folds},
                      {"seconds", layer.seconds}});
  }
  return {{"name", job.name},
          {"title", job.title},
          {"model", job.model.empty() ? Json(nullptr) : Json(job.model)},
          {"input_faces", outcome.input_faces},
          {"failure", outcome.failure.empty() ? Json(nullptr) : Json(outcome.failure)},
          {"cpu_seconds", outcome.cpu_seconds},
          {"layers", std::move(layers)}};
}

}  // namespace encage::stress
