// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/cagegen/tool/meshes.h"
#include "tests/cagegen/tool/run.h"

#include <encage/bake.h>

#include <gtest/gtest.h>

#include <filesystem>
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

  /// Bakes `model.obj` to `model.glb` with two levels, from the rings that write_rings() writes.
  void bake_model() {
    write_rings();
    const RunResult result = encage({"bake", "model.obj", "--coarse", "fine.off,coarse.off"});
    ASSERT_EQ(result.status, 0) << result.err;
    for (const char* ring : {"fine.off", "coarse.off"}) std::filesystem::remove(folder.path() / ring);
  }

  /// `fine.off` and `coarse.off`: coarse meshes for what is about the torus. Where any cages do, they are the quickest.
  void write_rings(double x = 0) {
    std::vector<TriangleMesh> rings = coarse_rings();
    for (TriangleMesh& ring : rings) ring.vertices.col(0).array() += x;
    write_mesh(folder.path() / "fine.off", rings[0]);
    write_mesh(folder.path() / "coarse.off", rings[1]);
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
