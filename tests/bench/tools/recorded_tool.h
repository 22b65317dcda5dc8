// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <encage/asset.h>
#include <encage/bake.h>

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace encage::test {

/// A subcommand of encage-bench that measures queries over recorded poses, run in a scratch folder that holds
/// `ring.glb`, a torus with a cage, and `poses.csv`.
class RecordedTool : public testing::Test {
 protected:
  RecordedTool(std::string subcommand, const std::string& poses) : subcommand_(std::move(subcommand)) {
    BakeOptions options;
    options.coarse = {coarse_rings()[0]};
    write_asset(folder.path() / "ring.glb", bake(torus(24, 12), options));
    write_poses("poses.csv", poses);
  }

  void write_poses(const std::string& name, const std::string& poses) const {
    folder.write(name, "step,body,x,y,z,qx,qy,qz,qw\n" + poses);
  }

  RunResult run_tool(const std::vector<std::string>& arguments, const std::string& poses = "poses.csv") const {
    std::vector<std::string> command = {ENCAGE_BENCH_BINARY, subcommand_, "--asset", "ring.glb", "--poses", poses};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run(command, folder.path());
  }

  /// Bad input: status 2 and a message that names the culprit.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& named,
                      const std::string& poses = "poses.csv") const {
    const RunResult result = run_tool(arguments, poses);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
  }

  ScratchFolder folder;

 private:
  std::string subcommand_;
};

}  // namespace encage::test
