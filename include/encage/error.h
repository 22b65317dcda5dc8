// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#include <stdexcept>
#include <string>

namespace ENCAGE_EXPORT encage {

/// Bad input. The message names the file (where there is one), the element, the reason and, where there is one, the
/// remedy. Reading, baking, loading and changes of a World throw it. Of the queries only those throw it that need a
/// fine mesh which a ShapeCache cannot read, and each says so.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

/// The caller's context asked to stop. No file has been written.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace encage
