// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/program.h"

#include <encage/error.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace encage::tool {
namespace {

struct Outcome {
  int status;
  std::string out, err;
  bool operator==(const Outcome&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Outcome& o) {
  return out << o.status << ", stdout \"" << o.out << "\", stderr \"" << o.err << '"';
}

/// A program with one option, --count.
Outcome outcome(std::vector<std::string> arguments, const std::function<int(int count)>& run) {
  CLI::App app("Counts.", "counter");
  int count = 0;
  app.add_option("--count", count);
  arguments.insert(arguments.begin(), "./counter");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  const int status = run_program(app, static_cast<int>(argv.size()), argv.data(), [&] { return run(count); });
  const std::string out = testing::internal::GetCapturedStdout();
  return {status, out, testing::internal::GetCapturedStderr()};
}

TEST(RunProgram, ReturnsWhatRunReturns) {
  const auto print = [](int count) {
    std::cout << "counted " << count;
    return count > 5 ? answer_is_no : success;
  };
  EXPECT_EQ(outcome({"--count", "5"}, print), (Outcome{success, "counted 5", ""}));
  EXPECT_EQ(outcome({"--count", "6"}, print), (Outcome{answer_is_no, "counted 6", ""}));
}

TEST(RunProgram, RunsOnlyWhatIsUnderstood) {
  const auto never = [](int) -> int {
    ADD_FAILURE();
    return success;
  };
  const Outcome help = outcome({"--help"}, never), wrong = outcome({"--count", "many"}, never);
  EXPECT_EQ(help.status, success);
  EXPECT_NE(help.out.find("--count"), std::string::npos) << help;
  EXPECT_EQ(help.err, "");
  EXPECT_EQ(wrong.status, bad_input);
  EXPECT_EQ(wrong.out, "");
  EXPECT_NE(wrong.err.find("many"), std::string::npos) << wrong;
}

TEST(RunProgram, TellsWhyItFailed) {
  const auto failing = [](const auto& exception) { return outcome({}, [&](int) -> int { throw exception; }); };
  EXPECT_EQ(failing(Error("a.off: no faces")), (Outcome{bad_input, "", "counter: a.off: no faces\n"}));
  EXPECT_EQ(failing(Cancelled()), (Outcome{cancelled, "", "counter: cancelled, nothing was written\n"}));
  EXPECT_EQ(failing(std::bad_alloc()), (Outcome{bad_input, "", "counter: out of memory\n"}));
  EXPECT_EQ(failing(std::logic_error("no such level")),
            (Outcome{bad_input, "", "counter: internal error: no such level\n"}));
  // The machine's refusals are no bugs.
  const Outcome refused = failing(
      std::filesystem::filesystem_error("cannot read", "/folder", std::make_error_code(std::errc::permission_denied)));
  EXPECT_EQ(refused.status, bad_input);
  EXPECT_EQ(refused.err.find("counter: filesystem error: cannot read"), 0) << refused;
}

}  // namespace
}  // namespace encage::tool
