// SPDX-License-Identifier: GPL-3.0-or-later
#include "src/files/atomic_file.h"

#include "tests/src/asset/forge.h"

#include <encage/error.h>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace encage {
namespace {

namespace fs = std::filesystem;

/// A folder for this test alone, removed at the end.
class Folder {
 public:
  Folder() { fs::create_directories(file_.path()); }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(file_.path(), ignored);
    fs::create_directories(file_.path(), ignored);  // `file_` removes it
  }
  fs::path operator/(const std::string& name) const { return file_.path() / name; }
  std::size_t size() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(file_.path()), fs::directory_iterator()));
  }

 private:
  TemporaryFile file_;
};

mode_t current_umask() {
  const mode_t mask = umask(0);
  umask(mask);
  return mask;
}

TEST(AtomicFile, replaces_a_file_and_leaves_nothing_else) {
  const Folder folder;
  write_atomically(folder / "a", "first");
  write_atomically(folder / "a", "second");
  EXPECT_EQ(read_bytes(folder / "a"), "second");
  EXPECT_EQ(folder.size(), 1u);
  EXPECT_THROW(write_atomically(folder / "missing" / "a", "x"), Error);
  fs::create_directory(folder / "full");
  write_bytes(folder / "full" / "b", "x");
  EXPECT_EQ(error_of([&] { write_atomically(folder / "full", "x"); }),
            (folder / "full").string() + ": cannot replace: Is a directory");
  EXPECT_EQ(folder.size(), 2u);
}

TEST(AtomicFile, has_the_permissions_of_an_ordinary_file) {
  const Folder folder;
  const mode_t before = umask(027);
  write_atomically(folder / "a", "x");
  umask(before);
  struct stat status {};
  ASSERT_EQ(stat((folder / "a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, mode_t{0640});
}

TEST(AtomicFile, shows_the_temporary_before_it_replaces_anything) {
  const Folder folder;
  write_atomically(folder / "a", "old");
  write_atomically(folder / "a", "new", [&](const fs::path& temporary) {
    EXPECT_EQ(read_bytes(temporary), "new");
    EXPECT_EQ(read_bytes(folder / "a"), "old");
  });
  EXPECT_EQ(read_bytes(folder / "a"), "new");
  EXPECT_THROW(write_atomically(folder / "a", "bad", [](const fs::path&) { throw std::runtime_error("no"); }),
               std::runtime_error);
  EXPECT_EQ(read_bytes(folder / "a"), "new");
  EXPECT_EQ(folder.size(), 1u);
}

TEST(AtomicFile, keeps_links_and_replaces_what_they_lead_to) {
  const Folder folder;
  fs::create_directory(folder / "there");
  write_bytes(folder / "there" / "target", "old");
  fs::create_symlink("there/target", folder / "relative");
  fs::create_symlink(folder / "there" / "target", folder / "absolute");
  fs::create_symlink("relative", folder / "second");
  fs::create_symlink("there/new", folder / "dangling");
  for (const char* name : {"relative", "absolute", "second", "dangling"}) {
    EXPECT_FALSE(is_written_through(folder / name));
    write_atomically(folder / name, name);
    EXPECT_TRUE(fs::is_symlink(folder / name)) << name;
    EXPECT_EQ(read_bytes(folder / name), name);
  }
  EXPECT_EQ(read_bytes(folder / "there" / "target"), "second");
  EXPECT_EQ(read_bytes(folder / "there" / "new"), "dangling");
  EXPECT_EQ(folder.size(), 5u) << "a temporary was left behind";

  fs::create_symlink("circle", folder / "circle");
  EXPECT_EQ(error_of([&] { write_atomically(folder / "circle", "x"); }),
            (folder / "circle").string() + ": cannot write: Too many levels of symbolic links");
  fs::create_symlink("missing/file", folder / "nowhere");
  EXPECT_EQ(error_of([&] { write_atomically(folder / "nowhere", "x"); }),
            (folder / "nowhere").string() + ": cannot write: No such file or directory");
}

TEST(AtomicFile, a_failure_leaves_what_a_link_leads_to) {
  const Folder folder;
  write_bytes(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  EXPECT_THROW(write_atomically(folder / "link", "bad", [](const fs::path&) { throw std::runtime_error("no"); }),
               std::runtime_error);
  EXPECT_EQ(read_bytes(folder / "target"), "old");
  EXPECT_EQ(folder.size(), 2u);
}

TEST(AtomicFile, writes_into_pipes) {
  const Folder folder;
  const fs::path pipe = folder / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("pipe", folder / "link");
  for (const char* name : {"pipe", "link"}) {
    EXPECT_TRUE(is_written_through(folder / name));
    std::string read;
    std::jthread reader([&] { read = read_bytes(pipe); });
    write_atomically(folder / name, std::string(100000, 'x'), [](const fs::path&) { FAIL() << "no temporary"; });
    reader.join();
    EXPECT_EQ(read, std::string(100000, 'x'));
    EXPECT_TRUE(fs::is_fifo(pipe));
  }
  EXPECT_EQ(folder.size(), 2u);
}

TEST(AtomicFile, writes_to_devices) {
  const Folder folder;
  // As root, a wrong program would replace the device of the whole system: the test makes one of its own.
  fs::path device = folder / "null";
  if (mknod(device.c_str(), S_IFCHR | 0600, makedev(1, 3)) != 0) device = "/dev/null";
  EXPECT_TRUE(is_written_through(device));
  write_atomically(device, "x");
  EXPECT_TRUE(fs::is_character_file(device));
  const fs::path full = folder / "full";
  if (mknod(full.c_str(), S_IFCHR | 0600, makedev(1, 7)) == 0) {
    EXPECT_EQ(error_of([&] { write_atomically(full, "x"); }),
              full.string() + ": cannot write: No space left on device");
    EXPECT_TRUE(fs::is_character_file(full));
  }
}

/// A name of a descriptor means what it has open, where that is now, whatever its name.
TEST(AtomicFile, goes_on_where_a_descriptor_is) {
  const Folder folder;
  const int descriptor = open((folder / "log").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  ASSERT_GE(descriptor, 0);
  ASSERT_EQ(write(descriptor, "one ", 4), 4);
  const std::string number = std::to_string(descriptor);
  write_atomically("/dev/fd/" + number, "two ");
  fs::create_symlink("/proc/self/fd/" + number, folder / "link");
  write_atomically(folder / "link", "three ");
  ASSERT_EQ(write(descriptor, "four", 4), 4);
  close(descriptor);
  EXPECT_EQ(read_bytes(folder / "log"), "one two three four");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(folder.size(), 2u);
}

TEST(AtomicFile, threads_leave_the_umask_alone) {
  const Folder folder;
  const mode_t before = umask(022);
  std::atomic<int> world_writable{0};
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 200; ++i) {
        write_atomically(folder / std::to_string(t), std::to_string(i));
        struct stat status {};
        if (stat((folder / std::to_string(t)).c_str(), &status) != 0 || (status.st_mode & 022) != 0) ++world_writable;
      }
    });
  }
  threads.clear();
  EXPECT_EQ(current_umask(), mode_t{022});
  umask(before);
  EXPECT_EQ(world_writable, 0);
  EXPECT_EQ(folder.size(), 4u);
}

}  // namespace
}  // namespace encage
