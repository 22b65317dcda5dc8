// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/export.h>

#define ENCAGE_VERSION_MAJOR 0
#define ENCAGE_VERSION_MINOR 1
#define ENCAGE_VERSION_PATCH 0

namespace ENCAGE_EXPORT encage {

/// Version of the library linked at run time.
struct Version {
  int major = 0;
  int minor = 0;
  int patch = 0;
};

Version version() noexcept;

}  // namespace encage
