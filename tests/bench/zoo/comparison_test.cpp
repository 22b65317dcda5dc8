// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace encage::zoo {
namespace {

using Json = nlohmann::ordered_json;

Model baked(const std::string& file, double cpu, const std::vector<std::pair<int, double>>& levels) {
  Json list = Json::array();
  for (const auto& [faces, ratio] : levels) {
    list.push_back({{"faces", faces}, {"volume_ratio", ratio}, {"start", "regular"}, {"certified", true}});
  }
  Model model;
  model.file = file;
  model.outcome = Model::Outcome::baked;
  model.figures = {
      {"source", {{"faces", 4000}, {"solid", "closed"}}}, {"levels", list}, {"cpu_seconds", cpu}, {"clean", true}};
  return model;
}

/// A baseline's level at each of `faces`.
struct Plain {
  int faces;
  double ratio;
  bool certified;
  int hits;
};

Model plain(const std::string& file, const std::vector<std::optional<Plain>>& levels) {
  Model model = baked(file, 5, {});
  for (const auto& level : levels) {
    if (!level) {
      model.figures["levels"].push_back(nullptr);
      continue;
    }
    model.figures["levels"].push_back({{"faces", level->faces},
                                       {"volume_ratio", level->faces > 0 ? Json(level->ratio) : Json(nullptr)},
                                       {"certified", level->certified},
                                       {"hits", level->hits},
                                       {"self_hits", 0},
                                       {"error", nullptr}});
  }
  return model;
}

Model without_cages(const std::string& file, Model::Outcome outcome, const std::string& error) {
  Model model;
  model.file = file;
  model.outcome = outcome;
  model.error = error;
  return model;
}

const std::vector<std::int64_t> compared_faces = {500, 100};

const std::vector<Contender> methods = {
    {"flow",
     false,
     {baked("a.off", 1, {{500, 1.02}, {100, 1.125}}), without_cages("b.off", Model::Outcome::failed, "b.off: stalls"),
      without_cages("c.ply", Model::Outcome::no_mesh, "c.ply: holds no faces")}},
    {"collapse",
     false,
     {baked("a.off", 2, {{500, 1.03}, {100, 1.25}}), baked("b.off", 3, {{500, 1.5}, {100, 1.75}}),
      without_cages("c.ply", Model::Outcome::no_mesh, "c.ply: holds no faces")}}};

/// The methods, and a baseline that fails at the second level of a.off and has no first one.
std::vector<Contender> with_baseline(const std::optional<Plain>& fine, const std::optional<Plain>& coarse) {
  std::vector<Contender> contenders = methods;
  const Model skipped = without_cages("b.off", Model::Outcome::skipped, "");
  contenders.push_back({"hull", true, {plain("a.off", {fine, coarse}), skipped, skipped}});
  return contenders;
}

/// The rows of the tables under a heading; those before the first one are under "".
std::vector<std::string> rows(const std::string& text, const std::string& heading) {
  std::vector<std::string> found;
  std::string current;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("## ")) current = line.substr(3);
    if (line.starts_with("|") && current == heading) found.push_back(line);
  }
  return found;
}

TEST(Comparison, LinesShowExcessOrReason) {
  const std::string line = comparison_line("flow", methods[0].models[0], compared_faces);
  for (const char* part : {"a.off", "flow", "1.00", "0.0200", "0.1250", "yes"}) {
    EXPECT_NE(line.find(part), std::string::npos) << part << " is not in " << line;
  }
  EXPECT_NE(comparison_line("flow", methods[0].models[1], compared_faces).find(" stalls\n"), std::string::npos);
  EXPECT_EQ(comparison_line("hull", without_cages("b.off", Model::Outcome::skipped, ""), compared_faces), "");
}

TEST(Comparison, TextSummarizesEachContender) {
  const std::string text = comparison_text(methods, compared_faces);
  EXPECT_NE(text.find("flow\ncertified: 1 of 2 meshes"), std::string::npos) << text;
  EXPECT_NE(text.find("collapse\ncertified: 2 of 2 meshes"), std::string::npos) << text;
}

TEST(Comparison, JsonHasEveryModelOfEveryContender) {
  const Json json = comparison_json(with_baseline(std::nullopt, Plain{100, 1.5, true, 0}), compared_faces);
  ASSERT_EQ(json.at("models").size(), 7U);
  EXPECT_EQ(json["models"][0].at("method"), "flow");
  EXPECT_EQ(json["models"][1].at("error"), "b.off: stalls");
  EXPECT_EQ(json["models"][4].at("method"), "collapse");
  EXPECT_EQ(json["models"][4].at("levels").size(), 2U);
  EXPECT_EQ(json["models"][6].at("method"), "hull");
  EXPECT_EQ(json.at("summaries").at("flow").at("certified"), 1);
  EXPECT_DOUBLE_EQ(json["summaries"]["collapse"].at("median_cpu_seconds"), 2.5);
  EXPECT_EQ(json["summaries"]["hull"].at("meshes"), 1);
}

TEST(Comparison, MarkdownHasOneRowAMesh) {
  const std::string text = comparison_markdown(methods, compared_faces, "encage-zoo dir");
  const std::vector<std::string> summary = rows(text, "");
  ASSERT_EQ(summary.size(), 4U) << text;
  EXPECT_EQ(summary[2], "| flow | 1 of 2 | 1.00 | 0.0200 (1) | 0.1250 (1) |");
  const std::vector<std::string> table = rows(text, "Mesh by mesh");
  ASSERT_EQ(table.size(), 4U) << text;
  for (const std::string& row : table) EXPECT_EQ(std::count(row.begin(), row.end(), '|'), 9) << row;
  EXPECT_EQ(table[2], "| a.off | 4000 | closed | yes | 0.0200 / 0.1250 | 0.0300 / 0.2500 | 1.00 / 2.00 | all |");
  EXPECT_EQ(table[3], "| b.off | 4000 | closed | yes | failed | 0.5000 / 0.7500 | – / 3.00 | collapse |");
  const std::vector<std::string> without = rows(text, "Without cages");
  ASSERT_EQ(without.size(), 4U) << text;
  EXPECT_EQ(without[2], "| b.off | flow | stalls |");
  EXPECT_EQ(without[3], "| c.ply | all | holds no faces |");
  EXPECT_TRUE(rows(text, "Beside plain methods").empty());
}

TEST(Comparison, MarkdownSetsABaselineBesideTheFirstMethod) {
  const std::string held =
      comparison_markdown(with_baseline(std::nullopt, Plain{100, 1.5, true, 0}), compared_faces, "");
  std::vector<std::string> summary = rows(held, "Beside plain methods");
  ASSERT_EQ(summary.size(), 4U) << held;
  EXPECT_EQ(summary[2], "| hull | 500 | 0 | 0 | 0 | 0 | 0 | – | – |");
  EXPECT_EQ(summary[3], "| hull | 100 | 1 | 1 | 1 | 0 | 0 | 0.5000 | 0.1250 |");
  std::vector<std::string> table = rows(held, "Plain methods, mesh by mesh");
  ASSERT_EQ(table.size(), 3U) << held;
  EXPECT_EQ(table[2], "| a.off | 0.0200 / 0.1250 | – / 0.5000 |");
  // Its rows are of no method's table.
  EXPECT_EQ(rows(held, "Mesh by mesh"), rows(comparison_markdown(methods, compared_faces, ""), "Mesh by mesh"));

  // Cages that are none count, but their volume does not.
  const std::string broken =
      comparison_markdown(with_baseline(Plain{500, 1.25, false, 3}, Plain{0, 0, false, 0}), compared_faces, "");
  summary = rows(broken, "Beside plain methods");
  EXPECT_EQ(summary.at(2), "| hull | 500 | 1 | 1 | 0 | 1 | 0 | – | – |");
  EXPECT_EQ(summary.at(3), "| hull | 100 | 1 | 0 | 0 | 0 | 0 | – | – |");
  table = rows(broken, "Plain methods, mesh by mesh");
  EXPECT_EQ(table.at(2), "| a.off | 0.0200 / 0.1250 | 0.2500 (3+0) / none |");
}

}  // namespace
}  // namespace encage::zoo
