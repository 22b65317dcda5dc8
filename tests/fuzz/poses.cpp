// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/fuzz.h"

#include <encage/poses.h>

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <vector>

using namespace encage;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The reader takes a path.
  static const int file = memfd_create("poses", MFD_CLOEXEC);
  static const std::string name = "/proc/self/fd/" + std::to_string(file);
  const bool written = ftruncate(file, 0) == 0 && pwrite(file, data, size, 0) == static_cast<ssize_t>(size);
  fuzz::require(written, "cannot write the file in memory");
  std::vector<PoseStep> steps;
  if (!fuzz::reads(fuzz::memory_for(size), [&] { steps = read_poses(name); })) return 0;
  for (std::size_t s = 0; s < steps.size(); ++s) {
    fuzz::require(s == 0 || steps[s - 1].step < steps[s].step, "steps are not sorted");
    for (std::size_t b = 0; b < steps[s].bodies.size(); ++b) {
      const BodyPose& body = steps[s].bodies[b];
      fuzz::require(b == 0 || steps[s].bodies[b - 1].body < body.body, "bodies are not sorted");
      fuzz::require(body.pose.matrix().allFinite(), "a pose is not finite");
    }
  }
  return 0;
}
