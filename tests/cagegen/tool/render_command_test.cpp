// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/cagegen/tool/command_fixture.h"

#include <string>

namespace encage::test {
namespace {

class RenderCommand : public CommandTest {};

TEST_F(RenderCommand, DrawsMeshesAssetsAndSections) {
  bake_model();
  const std::vector<std::vector<std::string>> requests = {{"render", "model.obj", "-o", "mesh.png"},
                                                          {"render", "model.glb", "-o", "asset.png"},
                                                          {"render", "model.glb", "-o", "level.png", "--levels", "2"},
                                                          {"render", "model.glb", "-o", "cut.png", "--cut", "z=0"}};
  std::vector<std::string> pictures;
  for (std::vector<std::string> request : requests) {
    request.insert(request.end(), {"--size", "64x48"});
    const RunResult result = encage(request);
    EXPECT_EQ(result.status, 0) << result.err;
    pictures.push_back(folder.read(request[3]));
    EXPECT_TRUE(pictures.back().starts_with("\x89PNG")) << request[3];
  }
  for (std::size_t i = 1; i < pictures.size(); ++i) EXPECT_NE(pictures[i], pictures[i - 1]);
}

TEST_F(RenderCommand, BadRequestsAreRefused) {
  bake_model();
  expect_refused({"render", "missing.glb", "-o", "a.png"}, "encage: missing.glb");
  expect_refused({"render", "model.glb"}, "--output is required");
  expect_refused({"render", "model.glb", "-o", "nowhere/a.png", "--size", "64x48"}, "encage: nowhere/a.png");
  expect_refused({"render", "model.glb", "-o", "model.glb"}, "overwrite");
  expect_refused({"render", "model.glb", "-o", "a.png", "--levels", "7"}, "7");
  expect_refused({"render", "model.glb", "-o", "a.png", "--cut", "w"}, "w");
  expect_refused({"render", "model.glb", "-o", "a.png", "--cut", "z=99"}, "cut");
  expect_refused({"render", "model.glb", "-o", "a.png", "--size", "0x9"}, "0x9");
}

}  // namespace
}  // namespace encage::test
