// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/cli/program.h"

#include <encage/error.h>

#include <exception>
#include <iostream>
#include <new>
#include <system_error>

namespace encage::tool {

namespace {

constexpr const char* cannot_print = "standard output: cannot write (is the device full, or closed?)";

}  // namespace

int run_program(CLI::App& app, int argc, char** argv, const std::function<int()>& run) {
  const auto complain = [&app](const auto&... what) { ((std::cerr << app.get_name() << ": ") << ... << what) << '\n'; };
  try {
    app.parse(argc, argv);
    const int status = run();
    if (!std::cout.flush()) throw Error(cannot_print);
    return status;
  } catch (const CLI::ParseError& error) {
    // exit() prints the help that was asked for, or the mistake.
    if (app.exit(error) != 0) return bad_input;
    if (std::cout.flush()) return success;
    complain(cannot_print);
  } catch (const Cancelled&) {
    complain("cancelled, nothing was written");
    return cancelled;
  } catch (const Error& error) {
    complain(error.what());
  } catch (const std::bad_alloc&) {
    complain("out of memory");
  } catch (const std::system_error& error) {
    complain(error.what());  // a folder that cannot be read, no more threads
  } catch (const std::exception& error) {
    complain("internal error: ", error.what());
  }
  return bad_input;
}

}  // namespace encage::tool
