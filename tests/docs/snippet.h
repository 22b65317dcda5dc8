// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace encage::docs {

/// Tells the program that a block of a document has been compiled.
struct Snippet {
  Snippet(const char* document, int line);
};

}  // namespace encage::docs
