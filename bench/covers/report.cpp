// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <ostream>

namespace encage::covers {
namespace {

/// Quotients that tables and JSON show.
struct Figures {
  double per_step, share, ns_per_pair, per_us;

  Figures(const Comparison& c, const Score& score) {
    const auto steps = static_cast<double>(c.steps), rejected = static_cast<double>(score.rejected);
    const auto rejectable = static_cast<double>(c.scores.front().rejected);
    per_step = rejected / steps;
    share = rejectable > 0 ? static_cast<double>(score.rejected_by_fine) / rejectable : 0;
    ns_per_pair = c.pairs > 0 ? 1e3 * score.us_per_step * steps / static_cast<double>(c.pairs) : 0;
    per_us = score.us_per_step > 0 ? per_step / score.us_per_step : 0;
  }
};

double mean(std::int64_t count, std::int64_t steps) { return static_cast<double>(count) / static_cast<double>(steps); }

}  // namespace

void print(std::ostream& out, const std::string& title, const Comparison& c) {
  std::array<char, 256> line;
  std::snprintf(line.data(), line.size(), "%s: %lld steps, %.2f pairs a step, of which %.2f can be rejected\n\n",
                title.c_str(), static_cast<long long>(c.steps), mean(c.pairs, c.steps),
                mean(c.scores.front().rejected, c.steps));
  out << line.data();
  out << "| representation                   |   kB | rejects a step | share | us a step | ns a pair | rejects a us |\n"
         "|---|--:|--:|--:|--:|--:|--:|\n";
  for (const Score& score : c.scores) {
    const Figures f(c, score);
    std::snprintf(line.data(), line.size(), "| %-32s | %6.0f | %6.2f | %4.0f %% | %7.1f | %7.0f | %6.3f |\n",
                  score.name.c_str(), 1e-3 * static_cast<double>(score.bytes), f.per_step, 100 * f.share,
                  score.us_per_step, f.ns_per_pair, f.per_us);
    out << line.data();
  }
  out << '\n';
}

nlohmann::ordered_json to_json(const Comparison& c) {
  nlohmann::ordered_json json = {{"steps", c.steps},
                                 {"pairs", c.pairs},
                                 {"rejectable", c.scores.front().rejected},
                                 {"doubtful", c.doubtful()},
                                 {"representations", nlohmann::ordered_json::array()}};
  for (const Score& score : c.scores) {
    const Figures f(c, score);
    json["representations"].push_back({{"name", score.name},
                                       {"bytes", score.bytes},
                                       {"rejected", score.rejected},
                                       {"share", f.share},
                                       {"us_per_step", score.us_per_step},
                                       {"ns_per_pair", f.ns_per_pair},
                                       {"rejects_per_us", f.per_us}});
  }
  return json;
}

}  // namespace encage::covers
