// SPDX-License-Identifier: GPL-3.0-or-later
// Queries with exact truth from the benchmark of Wang et al. 2021, "A large-scale benchmark and an inclusion-based
// algorithm for continuous collision detection". They are not part of this repository: ENCAGE_CCD_QUERIES names their
// folder.
#include "oracles/exact_ccd.h"

#include <CGAL/Gmpq.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace encage::test {
namespace {

struct Query {
  MovingPoints points;
  bool collides = false;
};

// Returns the rational as a double, and requires that it is one.
double coordinate(const std::string& numerator, const std::string& denominator) {
  const CGAL::Gmpq exact{CGAL::Gmpz(numerator), CGAL::Gmpz(denominator)};
  const double value = CGAL::to_double(exact);
  if (CGAL::Gmpq(value) != exact) throw std::runtime_error(numerator + "/" + denominator + " is not a double");
  return value;
}

std::vector<Query> read_queries(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<Query> queries;
  std::string line;
  for (int row = 0; std::getline(in, line); row = (row + 1) % 8) {
    std::vector<std::string> columns;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) columns.push_back(cell);
    if (columns.size() != 7) throw std::runtime_error(file.string() + ": a row without seven columns");
    if (row == 0) queries.emplace_back();
    Query& query = queries.back();
    Eigen::Vector3d& point = row < 4 ? query.points.start[row] : query.points.end[row - 4];
    for (int k = 0; k < 3; ++k) point[k] = coordinate(columns[2 * k], columns[2 * k + 1]);
    query.collides = std::stoi(columns[6]) != 0;
  }
  return queries;
}

struct Counts {
  int queries = 0, collisions = 0, missed = 0, late = 0, spurious = 0, disputed = 0;
};

Counts ask(const std::filesystem::path& file, bool edges) {
  Counts counts;
  for (const Query& query : read_queries(file)) {
    const std::optional<double> said = edges ? edge_edge_time(query.points) : vertex_face_time(query.points);
    const std::optional<TimeBounds> exact =
        exact_first_contact(edges ? Features::edge_edge : Features::vertex_face, query.points);
    ++counts.queries;
    counts.collisions += query.collides;
    counts.missed += query.collides && !said;
    counts.late += said && exact && *said > exact->high;
    counts.spurious += !query.collides && said;
    counts.disputed += query.collides != exact.has_value();
  }
  return counts;
}

// If the environment names the folder, it has to exist: its absence fails the test instead of skipping it.
TEST(CcdQueries, NoneMissedFewSpurious) {
  const char* folder = std::getenv("ENCAGE_CCD_QUERIES");
  if (folder == nullptr) GTEST_SKIP() << "ENCAGE_CCD_QUERIES names no folder of queries";
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  Counts all;
  for (const std::filesystem::path& file : files) {
    const std::filesystem::path kind = file.parent_path();
    ASSERT_TRUE(kind.filename() == "edge-edge" || kind.filename() == "vertex-face") << file;
    const Counts counts = ask(file, kind.filename() == "edge-edge");
    EXPECT_EQ(counts.missed, 0) << file;
    EXPECT_EQ(counts.late, 0) << file;
    EXPECT_EQ(counts.disputed, 0) << file << ": the exact twin";
    RecordProperty((kind.parent_path().filename() / kind.filename() / file.stem()).string() + " spurious",
                   counts.spurious);
    all.queries += counts.queries;
    all.collisions += counts.collisions;
    all.spurious += counts.spurious;
  }
  RecordProperty("queries", all.queries);
  RecordProperty("spurious", all.spurious);
  EXPECT_GT(all.collisions, 100);
  EXPECT_GT(all.queries - all.collisions, 1'000);
  EXPECT_LE(all.spurious * 100, all.queries - all.collisions);
}

}  // namespace
}  // namespace encage::test
