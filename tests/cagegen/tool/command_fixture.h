// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace encage::test {

/// Runs the built `encage` in a scratch folder that holds `model.obj`.
class CommandTest : public ::testing::Test {
 protected:
  CommandTest() { folder.write("model.obj", to_obj(torus(24, 12))); }

  RunResult encage(std::vector<std::string> arguments) {
    arguments.emplace(arguments.begin(), ENCAGE_BINARY);
    return run(arguments, folder.path());
  }

  /// Bakes `model.obj` to `model.glb` with levels of 200 and 60 faces.
  void bake_model() {
    const RunResult result = encage({"bake", "model.obj", "--method", "collapse", "--faces", "200,60"});
    ASSERT_EQ(result.status, 0) << result.err;
  }

  /// Bad input: status 2, a message that names the culprit, no result, no file made.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& named) {
    const std::vector<std::string> before = folder.names();
    const RunResult result = encage(arguments);
    EXPECT_EQ(result.status, 2) << named;
    EXPECT_NE(result.err.find(named), std::string::npos) << "'" << named << "' is not in: " << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(folder.names(), before);
  }

  ScratchFolder folder;
};

}  // namespace encage::test
