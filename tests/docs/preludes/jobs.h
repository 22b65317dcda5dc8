// SPDX-License-Identifier: GPL-3.0-or-later
struct Jobs {
  int threads() const { return 2; }
  void parallel_for(int count, const encage::TaskRef& task) {
    for (int i = 0; i < count; ++i) task(i);
  }
};
Jobs jobs;
encage::World world;
