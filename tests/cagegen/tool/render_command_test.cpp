// SPDX-License-Identifier: GPL-3.0-or-later
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/cagegen/tool/command_fixture.h"

namespace encage::test {
namespace {

class RenderCommand : public CommandTest {
 protected:
  // Width and height from the header of a PNG; 0 x 0 if it is none.
  std::pair<int, int> png_size(const std::string& file) {
    std::ifstream in(folder.path() / file, std::ios::binary);
    unsigned char head[24] = {};
    in.read(reinterpret_cast<char*>(head), sizeof head);
    if (!in || std::string(head + 1, head + 4) != "PNG") return {0, 0};
    const auto number = [&](int at) { return head[at] << 24 | head[at + 1] << 16 | head[at + 2] << 8 | head[at + 3]; };
    return {number(16), number(20)};
  }
};

TEST_F(RenderCommand, DrawsAMeshFile) {
  const RunResult result = encage({"render", "model.obj", "-o", "a.png", "--size", "80x60"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(png_size("a.png"), std::pair(80, 60));
  EXPECT_EQ(encage({"render", "model.obj", "-o", "b.png"}).status, 0);
  EXPECT_EQ(png_size("b.png"), std::pair(1200, 900));
}

TEST_F(RenderCommand, TakesCameraCutAndUp) {
  const std::vector<std::string> start{"render", "model.obj", "-o", "a.png", "--size", "80x60"};
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--cut", "z"},
                                               {"--cut", "x=0.25"},
                                               {"--camera", "-120,10,2", "--focus", "0,0,0"},
                                               {"--up", "y"},
                                               {"--cut", "x=-0.1", "--camera", "30,20"}}) {
    std::vector<std::string> arguments = start;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const RunResult result = encage(arguments);
    EXPECT_EQ(result.status, 0) << more[0] << ' ' << more[1] << ": " << result.err;
  }
}

TEST_F(RenderCommand, BadRequestsAreRefused) {
  expect_refused({"render", "model.obj"}, "--output");
  expect_refused({"render", "missing.obj", "-o", "a.png"}, "missing.obj");
  expect_refused({"render", "model.obj", "-o", "nowhere/a.png"}, "nowhere");
  expect_refused({"render", "model.obj", "-o", "model.obj"}, "model.obj");
  expect_refused({"render", "model.obj", "-o", "a.png", "--levels", "1"}, "no level 1");
  expect_refused({"render", "model.obj", "-o", "a.png", "--levels", "some"}, "'some'");
  expect_refused({"render", "model.obj", "-o", "a.png", "--size", "10x"}, "'10x'");
  expect_refused({"render", "model.obj", "-o", "a.png", "--size", "1x1"}, "1x1");
  expect_refused({"render", "model.obj", "-o", "a.png", "--cut", "x=1000"}, "outside");
  expect_refused({"render", "model.obj", "-o", "a.png", "--cut", "q"}, "'q'");
  expect_refused({"render", "model.obj", "-o", "a.png", "--camera", "sideways"}, "'sideways'");
  expect_refused({"render", "model.obj", "-o", "a.png", "--focus", "0,0,0"}, "--focus");
}

TEST_F(RenderCommand, DrawsLevelsOfAnAsset) {
  bake_model();
  for (const char* level : {"all", "0", "1", "2"}) {
    const RunResult result = encage({"render", "model.glb", "-o", "a.png", "--levels", level, "--size", "80x60"});
    EXPECT_EQ(result.status, 0) << level << ": " << result.err;
  }
  EXPECT_EQ(encage({"render", "model.glb", "-o", "a.png", "--cut", "z", "--size", "80x60"}).status, 0);
  EXPECT_EQ(png_size("a.png"), std::pair(80, 60));
  expect_refused({"render", "model.glb", "-o", "b.png", "--levels", "3"}, "no level 3");
  // A damaged asset is not quietly read as an ordinary glTF file.
  std::fstream file(folder.path() / "model.glb", std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(-40, std::ios::end);
  file.put('!');
  file.close();
  expect_refused({"render", "model.glb", "-o", "b.png"}, "model.glb");
}

}  // namespace
}  // namespace encage::test
