// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/report.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace encage::zoo {
namespace {

using Json = nlohmann::ordered_json;

Model baked(const std::string& file, bool clean, double cpu, const std::vector<std::pair<int, double>>& levels) {
  Json list = Json::array();
  for (const auto& [faces, ratio] : levels) {
    list.push_back({{"faces", faces}, {"volume_ratio", ratio}, {"start", "wrap|20"}, {"certified", true}});
  }
  Model model;
  model.file = file;
  model.outcome = Model::Outcome::baked;
  model.figures = {
      {"source", {{"faces", 4000}, {"solid", "closed"}}}, {"levels", list}, {"cpu_seconds", cpu}, {"clean", clean}};
  return model;
}

Model refused(const std::string& file, Model::Outcome outcome, const std::string& error) {
  Model model;
  model.file = file;
  model.outcome = outcome;
  model.error = error;
  return model;
}

const std::vector<std::int64_t> reported_faces = {2000, 500, 100};

const std::vector<Model> models = {
    baked("a.off", true, 1, {{2000, 1.01}, {500, 1.02}, {100, 1.1}}),
    baked("b.off", true, 4, {{498, 1.04}, {100, 1.2}}),
    baked("c.off", true, 2, {{12, 1.0}}),
    baked("d.off", false, 9, {{2000, 3.0}, {500, 4.0}, {100, 5.0}}),
    refused("e.off", Model::Outcome::failed, "e.off: too | thin"),
    refused("f.ply", Model::Outcome::no_mesh, "f.ply: holds no faces"),
};

TEST(LevelFor, MatchesTheLevelsThatWereNotSkipped) {
  EXPECT_EQ(level_for(models[0], reported_faces, 1).at("faces"), 500);
  EXPECT_TRUE(level_for(models[1], reported_faces, 0).is_null());
  EXPECT_EQ(level_for(models[1], reported_faces, 1).at("faces"), 498);
  EXPECT_EQ(level_for(models[1], reported_faces, 2).at("faces"), 100);
  EXPECT_TRUE(level_for(models[2], reported_faces, 1).is_null());
  EXPECT_EQ(level_for(models[2], reported_faces, 2).at("faces"), 12);
  EXPECT_TRUE(level_for(models[4], reported_faces, 0).is_null());
}

TEST(Summarize, CountsAndMedians) {
  const Summary summary = summarize(models, reported_faces);
  EXPECT_EQ(summary.meshes, 5);
  EXPECT_EQ(summary.certified, 4);
  EXPECT_EQ(summary.no_meshes, 1);
  EXPECT_DOUBLE_EQ(summary.median_cpu_seconds.value(), 3);
  // Clean ones only, and those that have the level.
  ASSERT_EQ(summary.levels.size(), 3U);
  EXPECT_EQ(summary.levels[0].models, 1);
  EXPECT_NEAR(summary.levels[1].median_excess_volume.value(), 0.03, 1e-12);
  EXPECT_EQ(summary.levels[2].models, 3);
  EXPECT_NEAR(summary.levels[2].median_excess_volume.value(), 0.1, 1e-12);
}

TEST(Summarize, AnUncertifiedLevelCounts) {
  std::vector<Model> doubtful = {models[0]};
  doubtful[0].figures["levels"][2]["certified"] = false;
  EXPECT_EQ(summarize(doubtful, reported_faces).certified, 0);
}

TEST(Summarize, AnUncertifiedLevelHasNoExcess) {
  std::vector<Model> doubtful = {models[0], models[1]};
  doubtful[0].figures["levels"][1]["certified"] = false;
  const Summary summary = summarize(doubtful, reported_faces);
  EXPECT_EQ(summary.levels[1].models, 1);
  EXPECT_NEAR(summary.levels[1].median_excess_volume.value(), 0.04, 1e-12);
}

TEST(Summarize, WhatWasSkippedIsNotCounted) {
  std::vector<Model> some = {models[0], refused("g.off", Model::Outcome::skipped, "")};
  EXPECT_EQ(summarize(some, reported_faces).meshes, 1);
  some[0].figures["levels"][0] = nullptr;
  const Summary summary = summarize(some, reported_faces);
  EXPECT_EQ(summary.certified, 1);
  EXPECT_EQ(summary.levels[0].models, 0);
}

TEST(Summarize, NothingHasNoMedian) {
  EXPECT_FALSE(summarize({}, reported_faces).median_cpu_seconds.has_value());
  EXPECT_FALSE(summarize({}, reported_faces).levels[0].median_excess_volume.has_value());
}

TEST(ToJson, HasFiguresAndErrorPerModel) {
  const Json json = to_json(models, summarize(models, reported_faces));
  ASSERT_EQ(json.at("models").size(), models.size());
  EXPECT_TRUE(json["models"][0].at("error").is_null());
  EXPECT_EQ(json["models"][0].at("levels").size(), 3U);
  EXPECT_EQ(json["models"][4].at("error"), "e.off: too | thin");
  EXPECT_EQ(json["models"][5].at("holds_mesh"), false);
  EXPECT_EQ(json.at("summary").at("certified"), 4);
}

TEST(ToMarkdown, EveryRowHasTheColumnsOfItsHead) {
  const std::string text = to_markdown(models, summarize(models, reported_faces), reported_faces, "encage-zoo dir");
  std::vector<int> columns;
  for (std::size_t from = 0, to = 0; (to = text.find('\n', from)) != std::string::npos; from = to + 1) {
    if (text[from] != '|') continue;
    int bars = 0;
    for (std::size_t i = from; i < to; ++i) bars += text[i] == '|' && text[i - 1] != '\\' ? 1 : 0;
    columns.push_back(bars);
  }
  // Head, rule and four models of 15 columns; head, rule and two refusals of two.
  EXPECT_EQ(columns, (std::vector<int>{16, 16, 16, 16, 16, 16, 3, 3, 3, 3})) << text;
}

TEST(TableLine, NamesFileFiguresOrReason) {
  EXPECT_NE(table_line(models[0], reported_faces).find("1.020"), std::string::npos);
  const std::string line = table_line(models[5], reported_faces);
  EXPECT_NE(line.find("f.ply"), std::string::npos);
  EXPECT_NE(line.find(" holds no faces\n"), std::string::npos);
}

}  // namespace
}  // namespace encage::zoo
