// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <memory>

#include "bench/replay/engine.h"

namespace encage::replay {

/// FCL with oriented boxes and rectangle swept spheres (OBBRSS), the best of its
/// volumes for meshes at rest; its tree built once, its dynamic box tree as broad phase, its collide() for
/// one contact. Surfaces only: a body inside another one does not touch it.
class FclEngine : public Engine {
 public:
  /// `mesh` in the body frame.
  explicit FclEngine(const TriangleMesh& mesh);
  ~FclEngine() override;

  std::string name() const override { return "fcl"; }
  std::vector<BodyPair> touching(const PoseStep& step, const CageGate* gate) override;

 private:
  struct Bodies;
  std::unique_ptr<Bodies> bodies_;
};

}  // namespace encage::replay
