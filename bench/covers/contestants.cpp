// SPDX-License-Identifier: GPL-3.0-or-later
#include "bench/covers/contestants.h"

#include "bench/covers/ball_cover.h"
#include "bench/covers/box_cover.h"

namespace encage::covers {
namespace {

std::size_t bytes_of(const Surface& surface) {
  return surface.mesh.vertices.size_bytes() + surface.mesh.triangles.size_bytes() + surface.tree.nodes.size_bytes() +
         surface.tree.leaves.size_bytes();
}

/// Triangles behind their tree: a cage, or the fine mesh.
class Triangles final : public Contestant {
 public:
  Triangles(std::string name, const Surface& surface, double slack)
      : Contestant(std::move(name), bytes_of(surface)), surface_(surface), slack_(slack) {}

  bool apart(const PairCase& pair) const override {
    return surfaces_apart(surface_, surface_, pair.motion, pair.distance + slack_);
  }

 private:
  const Surface& surface_;
  double slack_;
};

class Balls final : public Contestant {
 public:
  Balls(const BallCover& cover, double slack)
      : Contestant(std::to_string(cover.balls()) + " balls", cover.bytes()), cover_(cover), slack_(slack) {}

  bool apart(const PairCase& pair) const override {
    return covers_apart(cover_, cover_, pair.motion, pair.distance + slack_);
  }

 private:
  BallCover cover_;
  double slack_;
};

class Boxes final : public Contestant {
 public:
  Boxes(const Surface& surface, const BoxCover& cover, double slack)
      : Contestant(std::to_string(cover.boxes()) + " boxes", cover.bytes()),
        surface_(surface),
        cover_(cover),
        slack_(slack) {}

  bool apart(const PairCase& pair) const override {
    return covers_apart(cover_, surface_, cover_, surface_, pair.motion, pair.distance + slack_);
  }

 private:
  const Surface& surface_;
  BoxCover cover_;
  double slack_;
};

/// Two, one after the other.
class Both final : public Contestant {
 public:
  Both(const Contestant& first, const Contestant& second)
      : Contestant(first.name() + ", then " + second.name(), first.bytes() + second.bytes()),
        first_(first),
        second_(second) {}

  bool apart(const PairCase& pair) const override { return first_.apart(pair) || second_.apart(pair); }

 private:
  const Contestant& first_;
  const Contestant& second_;
};

}  // namespace

Contestants make_contestants(const Shape& shape, const CoverSizes& sizes) {
  // Covers of the stored fine mesh answer for the true one.
  const double slack = 2 * (1 + 1e-8) * shape.fine_error;
  Contestants all, combined;
  all.push_back(std::make_unique<Triangles>("fine mesh", shape.fine, slack));
  const auto add = [&](std::unique_ptr<Contestant> one) { return all.emplace_back(std::move(one)).get(); };
  const auto combine = [&](const Contestant* first, const Contestant* second) {
    combined.push_back(std::make_unique<Both>(*first, *second));
  };
  std::vector<const Contestant*> cages, balls, boxes;
  for (const Surface& cage : shape.cages) {
    const std::string name = "cage of " + std::to_string(cage.mesh.triangles.size());
    cages.push_back(add(std::make_unique<Triangles>(name, cage, 0)));
  }
  for (const std::int64_t size : sizes.balls) {
    balls.push_back(add(std::make_unique<Balls>(BallCover(shape.fine, size), slack)));
  }
  for (const std::int64_t size : sizes.boxes) {
    boxes.push_back(add(std::make_unique<Boxes>(shape.fine, BoxCover(shape.fine, size), slack)));
  }
  const Contestant* fine = all.front().get();
  for (const Contestant* ball : balls) {
    if (!cages.empty()) combine(ball, cages.front());
  }
  for (const Contestant* box : boxes) combine(box, fine);
  for (const Contestant* ball : balls) combine(ball, fine);
  for (auto& one : combined) all.push_back(std::move(one));
  return all;
}

}  // namespace encage::covers
