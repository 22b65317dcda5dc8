// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/common/process.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <string>
#include <vector>

namespace encage::bench {
namespace {

TEST(RunIsolated, ReturnsTheOutput) {
  // Larger than a pipe's buffer.
  const std::string large(1 << 20, 'x');
  const ChildResult result = run_isolated([&] { return large; });
  EXPECT_EQ(result.error, "");
  EXPECT_EQ(result.output, large);
}

TEST(RunIsolated, AnExceptionIsAnError) {
  const ChildResult result = run_isolated([]() -> std::string { throw Error("bunny.off: no faces"); });
  EXPECT_EQ(result.error, "bunny.off: no faces");
  EXPECT_EQ(result.output, "");
}

TEST(RunIsolated, ACrashIsAnError) {
  const ChildResult killed = run_isolated([]() -> std::string {
    std::raise(SIGKILL);
    return "unreached";
  });
  EXPECT_EQ(killed.error, "crashed: Killed");
  EXPECT_EQ(killed.output, "");
}

TEST(RunIsolated, AnEarlyExitIsAnError) {
  const ChildResult result = run_isolated([]() -> std::string { std::_Exit(0); });
  EXPECT_NE(result.error, "");
}

TEST(ThreadCpuSeconds, GrowsWithWork) {
  const double start = thread_cpu_seconds();
  volatile double x = 1;
  while (thread_cpu_seconds() < start + 1e-3) x = x * 1.0000001;
  EXPECT_GE(thread_cpu_seconds(), start + 1e-3);
}

TEST(ResidentMemory, HoldsWhatHasBeenWritten) {
  constexpr std::size_t bytes = 32 << 20;
  const ResidentMemory before = resident_memory();
  std::vector<char> written(bytes, 1);
  const ResidentMemory after = resident_memory();
  EXPECT_EQ(std::count(written.begin(), written.end(), 1), std::ptrdiff_t{bytes});
  EXPECT_GE(after.anonymous - before.anonymous, std::int64_t{bytes} / 2);
  EXPECT_GE(after.total, after.anonymous);
}

TEST(TemporaryFile, IsThisProcessesOwn) {
  const std::filesystem::path file = temporary_file("bench.glb");
  EXPECT_EQ(file.extension(), ".glb");
  EXPECT_NE(run_isolated([] { return temporary_file("bench.glb").string(); }).output, file.string());
}

TEST(DropFromCache, LeavesMissingFilesAlone) { EXPECT_NO_THROW(drop_from_cache({"no/such/file.glb"})); }

}  // namespace
}  // namespace encage::bench
