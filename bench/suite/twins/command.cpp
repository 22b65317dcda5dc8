// SPDX-License-Identifier: GPL-3.0-or-later
// encage-bench twins: random and adversarial pairs through every test that may reject one, held against brute force.

#include "bench/common/report.h"
#include "bench/common/watch.h"
#include "bench/suite/commands.h"
#include "cagegen/cli/output_file.h"
#include "oracles/twins/run.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace encage::twins {
namespace {

constexpr const char* examples = R"(Examples:
  encage-bench twins --threads 2 --json twins.json
      three million pairs of all kinds
  encage-bench twins --kinds moving --seed 7 --first 1234 --pairs 1
      one pair again

Exit status: 0 if no pair was rejected wrongly, 1 if some were, 2 for bad input or usage.)";

struct TwinsArguments {
  std::uint64_t seed = 1;
  std::int64_t pairs = 3'000'000, first = 0;
  std::vector<std::string> kinds;
  int threads = 1;
  std::filesystem::path json;
};

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const KindEntry& kind : all_kinds()) names.push_back(kind.name);
  return names;
}

void define(bench::CommandOptions& options, TwinsArguments& a) {
  constexpr std::int64_t most = 1'000'000'000'000;
  std::string names;
  for (const std::string& name : kind_names()) names += (names.empty() ? "" : ",") + name;
  options.add("--seed", a.seed, "Seed: the same pairs for the same one").shows_default().type("N");
  options.add("--pairs", a.pairs, "Pairs, divided among the kinds").between(1, most).shows_default().type("N");
  options.add("--first", a.first, "Number of the first pair of each kind").between(0, most).type("N");
  options.add("--kinds", a.kinds, "Kinds, separated by commas; all if not given").one_of(kind_names()).type(names);
  options.add("--threads", a.threads, "Threads; the figures do not depend on them")
      .between(1, 1024)
      .shows_default()
      .type("N");
  options.json(a.json);
}

std::vector<const KindEntry*> chosen(const TwinsArguments& a) {
  std::vector<const KindEntry*> kinds;
  for (const KindEntry& kind : all_kinds()) {
    if (a.kinds.empty() || std::find(a.kinds.begin(), a.kinds.end(), kind.name) != a.kinds.end()) {
      kinds.push_back(&kind);
    }
  }
  return kinds;
}

double rate(const Tally& t) {
  return t.far == 0 ? 0 : static_cast<double>(t.far - t.far_kept) / static_cast<double>(t.far);
}

nlohmann::ordered_json to_json(const Tally& t) {
  return {{"pairs", t.pairs},
          {"rejected", t.rejected},
          {"missed", t.missed},
          {"close", t.close},
          {"sampled", t.sampled},
          {"touching", t.touching},
          {"within_margin", t.within_margin},
          {"far", t.far},
          {"far_kept", t.far_kept}};
}

Tally total(const Report& report) {
  Tally all;
  for (const Tally& tally : report.tallies) all.add(tally);
  return all;
}

nlohmann::ordered_json to_json(const TwinsArguments& a, const std::vector<Work>& works, const Report& report) {
  nlohmann::ordered_json json = {{"seed", a.seed}, {"first", a.first}};
  json.update(to_json(total(report)));
  for (std::size_t i = 0; i < works.size(); ++i) {
    auto& kind = json["kinds"][works[i].name] = to_json(report.tallies[i]);
    kind["cpu_seconds"] = report.seconds[i];
  }
  json["misses"] = nlohmann::ordered_json::array();
  for (const Miss& miss : report.misses) {
    json["misses"].push_back({{"kind", miss.kind}, {"number", miss.number}, {"what", miss.what}});
  }
  return json;
}

void print_row(const std::string& name, const Tally& t, double seconds) {
  std::cout << bench::format("%-17s %9lld %9lld %7lld   %9lld %9lld %9lld %9lld %8.2f%% %9.0f\n", name.c_str(),
                             static_cast<long long>(t.pairs), static_cast<long long>(t.rejected),
                             static_cast<long long>(t.missed), static_cast<long long>(t.sampled),
                             static_cast<long long>(t.touching), static_cast<long long>(t.within_margin),
                             static_cast<long long>(t.far), 100 * rate(t), seconds);
}

void print(const std::vector<Work>& works, const Report& report) {
  std::cout << "                                               of the sampled ones:\n"
               "kind                  pairs  rejected  missed     sampled  touching in margin       far  rejected"
               "     CPU s\n";
  double seconds = 0;
  for (std::size_t i = 0; i < works.size(); ++i) {
    print_row(works[i].name, report.tallies[i], report.seconds[i]);
    seconds += report.seconds[i];
  }
  print_row("all", total(report), seconds);
}

// On stderr: they are why the status is not 0.
void print_misses(const TwinsArguments& a, const Report& report) {
  for (const Miss& miss : report.misses) {
    std::cerr << "encage-bench twins: missed: --seed " << a.seed << " --kinds " << miss.kind << " --first "
              << miss.number << " --pairs 1: " << miss.what << '\n';
  }
}

bool run_tool(TwinsArguments& a) {
  bench::check_outputs({a.json}, {});
  const std::vector<const KindEntry*> kinds = chosen(a);
  std::vector<int> shares;
  for (const KindEntry* kind : kinds) shares.push_back(kind->share);
  const std::vector<std::int64_t> counts = divide(a.pairs, shares);
  std::vector<std::unique_ptr<PairKind>> made;
  std::vector<Work> works;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    if (counts[i] == 0) continue;
    works.push_back({kinds[i]->name, made.emplace_back(kinds[i]->make()).get(), a.first, counts[i]});
  }
  bench::Watch watch;
  const Report report = run(works, a.seed, a.threads, watch.reporter("asking"));
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, works, report));
  print(works, report);
  print_misses(a, report);
  return report.misses.empty();
}

}  // namespace

bench::Command command() {
  return bench::make_command<TwinsArguments>(
      "twins", "Random and adversarial pairs through every test that may reject one, held against brute force.",
      examples, define, run_tool);
}

}  // namespace encage::twins
