// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/zoo/isolated.h"

#include <encage/error.h>

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <string>

namespace encage::zoo {
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
  const ChildResult result = run_isolated([]() -> std::string { _exit(0); });
  EXPECT_NE(result.error, "");
}

}  // namespace
}  // namespace encage::zoo
