// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <stdexcept>
#include <string>

namespace ENCAGE_EXPORT encage {

/// Bad input: the message names the file (where there is one), the element and
/// the reason. Thrown while reading, baking and loading; never by a query.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

/// The caller's context asked to stop. Nothing has been written.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace encage
