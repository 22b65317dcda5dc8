// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The pair tests of tests/oracles/twins, run as unit tests.

#include "oracles/twins/run.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

namespace encage::test {

/// Reads a number from the environment, for longer manual runs.
inline int number_from(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  return text ? std::atoi(text) : usual;
}

/// Tests one of `shards` parts of `usual` pairs of a kind, and fails for every missed one. The figures become
/// properties of the test.
inline twins::Tally ask_pairs(const std::string& name, std::unique_ptr<twins::PairKind> kind, int usual, int shards,
                              int shard) {
  const int pairs = number_from("ENCAGE_TWIN_PAIRS", usual) / shards;
  const auto seed = static_cast<std::uint64_t>(number_from("ENCAGE_TWIN_SEED", 1));
  const twins::Report report = twins::run({{name, kind.get(), std::int64_t{shard} * pairs, pairs}}, seed, 1);
  for (const twins::Miss& miss : report.misses) {
    ADD_FAILURE() << "encage-bench twins --seed " << seed << " --kinds " << name << " --first " << miss.number
                  << " --pairs 1: " << miss.what;
  }
  const twins::Tally& tally = report.tallies.front();
  testing::Test::RecordProperty("rejected", static_cast<int>(tally.rejected));
  testing::Test::RecordProperty("close", static_cast<int>(tally.close));
  testing::Test::RecordProperty("sampled", static_cast<int>(tally.sampled));
  testing::Test::RecordProperty("contacts", static_cast<int>(tally.touching + tally.within_margin));
  testing::Test::RecordProperty("far", static_cast<int>(tally.far));
  testing::Test::RecordProperty("far_kept", static_cast<int>(tally.far_kept));
  return tally;
}

}  // namespace encage::test
