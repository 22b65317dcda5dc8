// SPDX-License-Identifier: GPL-3.0-or-later
// encage-twins: random and adversarial pairs through every test that may reject one, held against brute force.

#include "cagegen/cli/interrupt.h"
#include "cagegen/cli/output_file.h"
#include "cagegen/cli/program.h"
#include "cagegen/cli/progress.h"
#include "oracles/twins/run.h"

#include <encage/error.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace encage::twins {
namespace {

constexpr const char* examples = R"(Examples:
  encage-twins --threads 2 --json twins.json
      three million pairs of all kinds
  encage-twins --kinds moving --seed 7 --first 1234 --pairs 1
      one pair again

Exit status: 0 if no pair was rejected wrongly, 1 if some were, 2 for bad input or usage.)";

struct Arguments {
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

void define(CLI::App& app, Arguments& a) {
  constexpr std::int64_t most = 1'000'000'000'000;
  app.footer(examples);
  app.add_option("--seed", a.seed, "Seed: the same pairs for the same one")->capture_default_str()->type_name("N");
  app.add_option("--pairs", a.pairs, "Pairs, divided among the kinds")
      ->check(CLI::Range(std::int64_t{1}, most).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--first", a.first, "Number of the first pair of each kind")
      ->check(CLI::Range(std::int64_t{0}, most).description(""))
      ->type_name("N");
  app.add_option("--kinds", a.kinds, "Kinds, separated by commas; all if not given")
      ->delimiter(',')
      ->check(CLI::IsMember(kind_names()).description(""))
      ->type_name(CLI::detail::join(kind_names(), ","));
  app.add_option("--threads", a.threads, "Threads; the figures do not depend on them")
      ->check(CLI::Range(1, 1024).description(""))
      ->capture_default_str()
      ->type_name("N");
  app.add_option("--json", a.json, "Write everything as JSON")->type_name("FILE");
}

std::vector<const KindEntry*> chosen(const Arguments& a) {
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

nlohmann::ordered_json to_json(const Arguments& a, const std::vector<Work>& works, const Report& report) {
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
  std::array<char, 160> line;
  std::snprintf(line.data(), line.size(), "%-17s %9lld %9lld %7lld   %9lld %9lld %9lld %9lld %8.2f%% %9.0f\n",
                name.c_str(), static_cast<long long>(t.pairs), static_cast<long long>(t.rejected),
                static_cast<long long>(t.missed), static_cast<long long>(t.sampled), static_cast<long long>(t.touching),
                static_cast<long long>(t.within_margin), static_cast<long long>(t.far), 100 * rate(t), seconds);
  std::cout << line.data();
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
void print_misses(const Arguments& a, const Report& report) {
  for (const Miss& miss : report.misses) {
    std::cerr << "encage-twins: missed: --seed " << a.seed << " --kinds " << miss.kind << " --first " << miss.number
              << " --pairs 1: " << miss.what << '\n';
  }
}

int run_tool(const Arguments& a) {
  const tool::InterruptScope scope;
  if (!a.json.empty()) tool::check_output(a.json, {});
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
  tool::Progress progress = tool::Progress::on_stderr();
  const Report report = run(works, a.seed, a.threads, [&](double fraction) {
    progress.update(fraction, "asking");
    tool::throw_if_interrupted();
  });
  if (!a.json.empty()) tool::write_json(a.json, to_json(a, works, report));
  print(works, report);
  print_misses(a, report);
  return report.misses.empty() ? tool::success : tool::answer_is_no;
}

}  // namespace
}  // namespace encage::twins

int main(int argc, char** argv) {
  CLI::App app("Random and adversarial pairs through every test that may reject one, held against brute force.",
               "encage-twins");
  encage::twins::Arguments a;
  encage::twins::define(app, a);
  return encage::tool::run_program(app, argc, argv, [&] { return encage::twins::run_tool(a); });
}
