// SPDX-License-Identifier: GPL-3.0-or-later

// Writes the sample asset for tools outside the test programs.
#include "tests/src/asset/sample.h"

#include <encage/asset.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s OUT.glb\n", argv[0]);
    return 2;
  }
  encage::write_asset(argv[1], encage::sample_hierarchy());
  return 0;
}
