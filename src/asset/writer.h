// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <encage/cage.h>

#include <string>

namespace encage {

/// Returns the bytes of an asset (docs/asset.md). `generator` names the program that writes it; `file` starts the
/// messages of errors. Throws Error.
std::string encode_asset(const CageHierarchy& hierarchy, const std::string& generator, const std::string& file);

/// Returns the bytes that write_asset() writes; the generator is this version of Encage.
std::string encode_asset(const CageHierarchy& hierarchy, const std::string& file);

}  // namespace encage
