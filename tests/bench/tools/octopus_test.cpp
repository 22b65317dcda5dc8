// SPDX-License-Identifier: GPL-3.0-or-later
// The program encage-octopus.

#include "tests/cagegen/tool/run.h"

#include <encage/bake.h>
#include <encage/poses.h>

#include <gtest/gtest.h>

namespace encage::test {
namespace {

TEST(OctopusTool, WritesMeshAndPoses) {
  const ScratchFolder folder;
  const RunResult result = run({ENCAGE_OCTOPUS_BINARY, "-o", "octopus.off", "--faces", "10000", "--poses", "drift.csv",
                                "--bodies", "3", "--steps", "5", "--dt", "1/240"},
                               folder.path());
  ASSERT_EQ(result.status, 0) << result.err;
  const TriangleMesh mesh = triangulate(read_polygon_mesh(folder.path() / "octopus.off"));
  EXPECT_NEAR(static_cast<double>(mesh.triangles.rows()), 10'000, 100);
  EXPECT_TRUE(is_closed(mesh));
  const std::vector<PoseStep> steps = read_poses(folder.path() / "drift.csv");
  ASSERT_EQ(steps.size(), 5U);
  EXPECT_EQ(steps[0].bodies.size(), 3U);
}

TEST(OctopusTool, AMistakeLeavesNothingBehind) {
  const ScratchFolder folder;
  for (const std::vector<std::string>& bad :
       std::vector<std::vector<std::string>>{{},
                                             {"-o", "octopus.off", "--faces", "100"},
                                             {"-o", "octopus.off", "--poses", "p.csv", "--bodies", "0"},
                                             {"--poses", "p.csv", "--dt", "1/0"}}) {
    std::vector<std::string> command = {ENCAGE_OCTOPUS_BINARY};
    command.insert(command.end(), bad.begin(), bad.end());
    const RunResult result = run(command, folder.path());
    EXPECT_EQ(result.status, 2);
    EXPECT_NE(result.err.find("encage-octopus: "), std::string::npos) << result.err;
    EXPECT_TRUE(folder.names().empty());
  }
}

}  // namespace
}  // namespace encage::test
