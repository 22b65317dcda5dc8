// SPDX-License-Identifier: GPL-3.0-or-later
#include <encage/version.h>

#include <gtest/gtest.h>

#include <string>

namespace encage {
namespace {

TEST(Version, IsThatOfTheHeaderAndOfTheProject) {
  const Version linked = version();
  EXPECT_EQ(linked.major, ENCAGE_VERSION_MAJOR);
  EXPECT_EQ(linked.minor, ENCAGE_VERSION_MINOR);
  EXPECT_EQ(linked.patch, ENCAGE_VERSION_PATCH);
  EXPECT_EQ(std::to_string(linked.major) + "." + std::to_string(linked.minor) + "." + std::to_string(linked.patch),
            ENCAGE_PROJECT_VERSION);
}

}  // namespace
}  // namespace encage
