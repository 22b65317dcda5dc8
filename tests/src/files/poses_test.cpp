// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/poses.h>

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace encage {
namespace {

const std::string header = "step,body,x,y,z,qx,qy,qz,qw\n";

class Poses : public testing::Test {
 protected:
  Poses() : folder_(std::filesystem::temp_directory_path() / ("encage_poses_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Poses() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path path(const std::string& name = "poses.csv") const { return folder_ / name; }

  std::vector<PoseStep> read(const std::string& text) const {
    std::ofstream(path(), std::ios::binary) << text;
    return read_poses(path());
  }

  /// Returns the message without the file's name.
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.rfind(path().string() + ":", 0), 0u) << message;
      return message.substr(path().string().size() + 1);
    }
    return "accepted";
  }

 private:
  std::filesystem::path folder_;
};

TEST_F(Poses, ReadsStepsAndBodies) {
  const auto steps = read(header + "3,0,1,2,3,0,0,0,1\n3,7,-1e-3,0,0,0,0,0.6,0.8\r\n5,7,0,0,0,1,0,0,0");
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].step, 3);
  EXPECT_EQ(steps[1].step, 5);
  ASSERT_EQ(steps[0].bodies.size(), 2u);
  EXPECT_EQ(steps[0].bodies[1].body, 7);
  EXPECT_EQ(steps[0].bodies[0].pose.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(steps[0].bodies[0].pose.linear().isIdentity(0));
  // (0, 0, 0.6, 0.8) turns x towards y with cos = 0.28.
  EXPECT_NEAR(steps[0].bodies[1].pose.linear()(0, 0), 0.28, 1e-15);
  EXPECT_NEAR(steps[0].bodies[1].pose.linear()(1, 0), 0.96, 1e-15);
  EXPECT_EQ(steps[1].bodies[0].pose.linear().diagonal(), Eigen::Vector3d(1, -1, -1));
}

TEST_F(Poses, BeginWithAByteOrderMarkOrWithout) {
  const std::string mark = "\xEF\xBB\xBF", row = "0,0,1,2,3,0,0,0,1\n";
  EXPECT_EQ(read(mark + header + row)[0].bodies[0].pose.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read(mark + header.substr(0, header.size() - 1) + "\r\n" + row).size(), 1u);
  const std::string bad_header = "1: the header is not 'step,body,x,y,z,qx,qy,qz,qw'";
  EXPECT_EQ(refusal(mark + mark + header + row), bad_header);
  EXPECT_EQ(refusal(mark.substr(0, 2) + header + row), bad_header);
  EXPECT_EQ(refusal(header + mark + row), "2: column step is not a number in range: '" + mark + "0'");
  EXPECT_EQ(refusal(mark), bad_header);
}

TEST_F(Poses, ReachAsFarAsQueriesAccept) {
  EXPECT_EQ(read(header + "0,0,1e150,-1e150,0,0,0,0,1\n")[0].bodies[0].pose.translation().x(), 1e150);
}

TEST_F(Poses, NormalisesWhatIsNearlyUnit) {
  const auto steps = read(header + "0,0,0,0,0,0,0,0,1.0000009\n");
  EXPECT_TRUE(steps[0].bodies[0].pose.linear().isIdentity(1e-15));
  EXPECT_EQ(refusal(header + "0,0,0,0,0,0,0,0,1.000002\n"), "2: the quaternion's length is 1.000002, not 1");
}

TEST_F(Poses, NamesLineAndReason) {
  EXPECT_EQ(refusal(""), " empty file");
  EXPECT_EQ(refusal(header), " no poses");
  EXPECT_EQ(refusal("step,body\n"), "1: the header is not 'step,body,x,y,z,qx,qy,qz,qw'");
  EXPECT_EQ(refusal(header + "0,0,0,0,0,0,0,0,1\n0,1,0,0,0,0,0,0\n"), "3: column qw is missing");
  EXPECT_EQ(refusal(header + "0,0,0,0,0,0,0,0,1,5\n"), "2: more than 9 columns");
  EXPECT_EQ(refusal(header + "0,0,0,0,0,0,0,0,1,\n"), "2: more than 9 columns");
  EXPECT_EQ(refusal(header + "\n"), "2: column step is not a number in range: ''");
  EXPECT_EQ(refusal(header + "0,x,0,0,0,0,0,0,1\n"), "2: column body is not a number in range: 'x'");
  EXPECT_EQ(refusal(header + "0,0,1 ,0,0,0,0,0,1\n"), "2: column x is not a number in range: '1 '");
  EXPECT_EQ(refusal(header + "0,0,0,1e999,0,0,0,0,1\n"), "2: column y is not a number in range: '1e999'");
  EXPECT_EQ(refusal(header + "0,0,0,0,inf,0,0,0,1\n"), "2: z is not finite");
  EXPECT_EQ(refusal(header + "0,0,0,0,0,nan,0,0,1\n"), "2: qx is not finite");
  EXPECT_EQ(refusal(header + "0,0,0,1e300,0,0,0,0,1\n"), "2: y is 1e+300, beyond 1e150");
  EXPECT_EQ(refusal(header + "0,0,0,0,-1.1e150,0,0,0,1\n"), "2: z is -1.1e+150, beyond 1e150");
  EXPECT_EQ(refusal(header + "0,0,0,0,0,0,0,0,0\n"), "2: the quaternion's length is 0, not 1");
  EXPECT_EQ(refusal(header + "0,4294967296,0,0,0,0,0,0,1\n"), "2: column body is not a number in range: '4294967296'");
  EXPECT_EQ(refusal(header + "-1,0,0,0,0,0,0,0,1\n"), "2: step is negative");
  EXPECT_EQ(refusal(header + "0,-2,0,0,0,0,0,0,1\n"), "2: body is negative");
  EXPECT_EQ(refusal(header + "1,0,0,0,0,0,0,0,1\n0,0,0,0,0,0,0,0,1\n"), "3: steps do not increase");
  EXPECT_EQ(refusal(header + "1,4,0,0,0,0,0,0,1\n1,4,0,0,0,0,0,0,1\n"), "3: bodies do not increase within the step");
}

TEST_F(Poses, MissingFilesAndFolders) {
  EXPECT_THROW(read_poses(path("missing.csv")), Error);
  EXPECT_THROW(read_poses(path().parent_path()), Error);
}

TEST_F(Poses, WritesWhatItReads) {
  const auto steps = read(header + "3,0,0.1,2e-17,1e22,0.5,-0.5,0.5,0.5\n4,1,0,0,0,0,0,0.28,0.96\n");
  write_poses(path("again.csv"), steps);
  const auto again = read_poses(path("again.csv"));
  ASSERT_EQ(again.size(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(again[i].step, steps[i].step);
    EXPECT_EQ(again[i].bodies[0].body, steps[i].bodies[0].body);
    EXPECT_EQ(again[i].bodies[0].pose.translation(), steps[i].bodies[0].pose.translation());
    EXPECT_TRUE(again[i].bodies[0].pose.linear().isApprox(steps[i].bodies[0].pose.linear(), 1e-15));
  }
}

TEST_F(Poses, AFailedWriteLeavesNothing) {
  const auto steps = read(header + "0,0,0,0,0,0,0,0,1\n");
  EXPECT_THROW(write_poses(path("no/such/folder.csv"), steps), Error);
  EXPECT_FALSE(std::filesystem::exists(path("no")));
}

}  // namespace
}  // namespace encage
