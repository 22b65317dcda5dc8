// SPDX-License-Identifier: Apache-2.0
#include <encage/version.h>

namespace encage {

Version version() noexcept { return {ENCAGE_VERSION_MAJOR, ENCAGE_VERSION_MINOR, ENCAGE_VERSION_PATCH}; }

}  // namespace encage
