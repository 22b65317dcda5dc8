// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/mapped_file.h"

#include <encage/error.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <utility>

#include "tests/src/asset_forge.h"

namespace encage {
namespace {

using ::testing::TempDir;

std::string text(const MappedFile& map) {
  return {reinterpret_cast<const char*>(map.bytes().data()), map.bytes().size()};
}

TEST(MappedFile, shows_the_bytes_and_survives_moves) {
  const TemporaryFile file;
  write_bytes(file.path(), "some bytes");
  MappedFile map(file.path());
  EXPECT_EQ(text(map), "some bytes");
  MappedFile second(std::move(map));
  EXPECT_EQ(text(second), "some bytes");
  write_bytes(file.path(), "others");
  second = MappedFile(file.path());
  EXPECT_EQ(text(second), "others");
}

TEST(MappedFile, empty_file_has_no_bytes) {
  const TemporaryFile file;
  write_bytes(file.path(), "");
  EXPECT_TRUE(MappedFile(file.path()).bytes().empty());
}

TEST(MappedFile, refuses_what_is_no_regular_file) {
  const TemporaryFile file;
  EXPECT_EQ(error_of([&] { MappedFile map(file.path()); }),
            file.path().string() + ": cannot open: No such file or directory");
  EXPECT_EQ(error_of([&] { MappedFile map(TempDir()); }), TempDir() + ": not a regular file");
  ASSERT_EQ(mkfifo(file.path().c_str(), 0600), 0);
  EXPECT_EQ(error_of([&] { MappedFile map(file.path()); }), file.path().string() + ": not a regular file");
}

}  // namespace
}  // namespace encage
