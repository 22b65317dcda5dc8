// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
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

Model without_cages(const std::string& file, Model::Outcome outcome, const std::string& error) {
  Model model;
  model.file = file;
  model.outcome = outcome;
  model.error = error;
  return model;
}

const std::vector<std::int64_t> faces = {500, 100};

const std::vector<Contender> contenders = {
    {"flow",
     {baked("a.off", 1, {{500, 1.02}, {100, 1.125}}), without_cages("b.off", Model::Outcome::failed, "b.off: stalls"),
      without_cages("c.ply", Model::Outcome::no_mesh, "c.ply: holds no faces")}},
    {"collapse",
     {baked("a.off", 2, {{500, 1.03}, {100, 1.25}}), baked("b.off", 3, {{500, 1.5}, {100, 1.75}}),
      without_cages("c.ply", Model::Outcome::no_mesh, "c.ply: holds no faces")}}};

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> found;
  for (std::size_t from = 0, to = 0; (to = text.find('\n', from)) != std::string::npos; from = to + 1) {
    found.push_back(text.substr(from, to - from));
  }
  return found;
}

TEST(Comparison, LinesShowExcessOrReason) {
  const std::string line = comparison_line("flow", contenders[0].models[0], faces);
  for (const char* part : {"a.off", "flow", "1.00", "0.0200", "0.1250", "yes"}) {
    EXPECT_NE(line.find(part), std::string::npos) << part << " is not in " << line;
  }
  EXPECT_NE(comparison_line("flow", contenders[0].models[1], faces).find(" stalls\n"), std::string::npos);
}

TEST(Comparison, TextSummarizesEachContender) {
  const std::string text = comparison_text(contenders, faces);
  EXPECT_NE(text.find("flow\ncertified: 1 of 2 meshes"), std::string::npos) << text;
  EXPECT_NE(text.find("collapse\ncertified: 2 of 2 meshes"), std::string::npos) << text;
}

TEST(Comparison, JsonHasEveryModelOfEveryContender) {
  const Json json = comparison_json(contenders, faces);
  ASSERT_EQ(json.at("models").size(), 6U);
  EXPECT_EQ(json["models"][0].at("method"), "flow");
  EXPECT_EQ(json["models"][1].at("error"), "b.off: stalls");
  EXPECT_EQ(json["models"][4].at("method"), "collapse");
  EXPECT_EQ(json["models"][4].at("levels").size(), 2U);
  EXPECT_EQ(json.at("summaries").at("flow").at("certified"), 1);
  EXPECT_DOUBLE_EQ(json["summaries"]["collapse"].at("median_cpu_seconds"), 2.5);
}

TEST(Comparison, MarkdownHasOneRowAMesh) {
  const std::string text = comparison_markdown(contenders, faces, "encage-zoo dir");
  std::vector<std::string> rows;
  for (const std::string& line : lines(text)) {
    if (line.starts_with("|")) rows.push_back(line);
  }
  // Head, rule and two meshes of 4 + 2 * 4 columns; head, rule and two reasons of three.
  ASSERT_EQ(rows.size(), 8U) << text;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(std::count(rows[i].begin(), rows[i].end(), '|'), i < 4 ? 13 : 4) << rows[i];
  }
  EXPECT_EQ(rows[2], "| a.off | 4000 | closed | yes | 0.0200 | 0.1250 | 1.00 | yes | 0.0300 | 0.2500 | 2.00 | yes |");
  EXPECT_EQ(rows[3], "| b.off | 4000 | closed | yes | – | – | – | no | 0.5000 | 0.7500 | 3.00 | yes |");
  EXPECT_EQ(rows[6], "| b.off | flow | stalls |");
  EXPECT_EQ(rows[7], "| c.ply | all | holds no faces |");
}

}  // namespace
}  // namespace encage::zoo
