// SPDX-License-Identifier: GPL-3.0-or-later
// Lists the C++ blocks of the documents that this program was compiled and linked with, one "DOCUMENT:LINE" a line.
#include "tests/docs/snippet.h"

#include <cstdio>
#include <string>
#include <vector>

namespace encage::docs {
namespace {

std::vector<std::string>& snippets() {
  static std::vector<std::string> all;
  return all;
}

}  // namespace

Snippet::Snippet(const char* document, int line) { snippets().push_back(document + (':' + std::to_string(line))); }

}  // namespace encage::docs

int main() {
  for (const std::string& snippet : encage::docs::snippets()) std::puts(snippet.c_str());
}
