// SPDX-License-Identifier: GPL-3.0-or-later
#include "oracles/exact_pair.h"
#include "oracles/exact_sweep.h"
#include "oracles/twins/scenes.h"
#include "oracles/twins/triangle_truth.h"

#include <memory>
#include <optional>
#include <vector>

namespace encage::twins {

using test::ExactBody;

namespace {

bool contained(const Scene& scene, const ExactBody& a, const ExactBody& b) {
  return (scene.a->solid() && holds_component(a, b)) || (scene.b->solid() && holds_component(b, a));
}

}  // namespace

// ---- At rest.

struct RestingTruth::Data {
  const Scene& scene;
  ExactBody a, b;
};

RestingTruth::RestingTruth(const Scene& scene)
    : data_(new Data{scene,
                     {scene.a->origin(), scene.a->sample.source, scene.motion_a.start, scene.a->scale},
                     {scene.b->origin(), scene.b->sample.source, scene.motion_b.start, scene.b->scale}}) {}
RestingTruth::~RestingTruth() = default;

bool RestingTruth::surfaces_near(double distance) const { return surfaces_meet(data_->a, data_->b, distance); }

bool RestingTruth::held() const { return contained(data_->scene, data_->a, data_->b); }

bool RestingTruth::within_margin() const { return surfaces_near(data_->scene.margin) || held(); }

Truth RestingTruth::truth() const {
  if (!within_margin()) return Truth::apart;
  if (data_->scene.margin == 0) return Truth::touching;
  return surfaces_near(0) || held() ? Truth::touching : Truth::within_margin;
}

bool RestingTruth::farther(double more) const { return !surfaces_near(data_->scene.margin + more); }

bool RestingTruth::triangles_near(std::int64_t i, std::int64_t j) const {
  return triangles_meet(data_->a, i, data_->b, j, data_->scene.margin);
}

// ---- During a step.

struct MovingTruth::Data {
  const Scene& scene;
  test::MovingMesh a, b;

  bool contained_at_start() const {
    if (!scene.a->solid() && !scene.b->solid()) return false;
    return contained(scene, {scene.a->origin(), scene.a->sample.source, scene.motion_a.start, scene.a->scale},
                     {scene.b->origin(), scene.b->sample.source, scene.motion_b.start, scene.b->scale});
  }
};

MovingTruth::MovingTruth(const Scene& scene, Meshes meshes) {
  const auto moving = [&](const test::Body& body, const Motion& motion) {
    return test::moving_mesh(body.origin(), meshes == Meshes::fine ? body.mesh() : body.sample.source, motion);
  };
  data_.reset(new Data{scene, moving(*scene.a, scene.motion_a), moving(*scene.b, scene.motion_b)});
}
MovingTruth::~MovingTruth() = default;

Truth MovingTruth::surface_truth() const {
  if (exact_contact(data_->a, data_->b)) return Truth::touching;
  const double margin = data_->scene.margin;
  return margin > 0 && reach(data_->a, data_->b, margin) ? Truth::within_margin : Truth::apart;
}

Truth MovingTruth::truth() const {
  const Truth surfaces = surface_truth();
  return surfaces != Truth::touching && data_->contained_at_start() ? Truth::touching : surfaces;
}

bool MovingTruth::surfaces_farther(double more) const {
  return !come_within(data_->a, data_->b, data_->scene.margin + more, 0x1p-9);
}

bool MovingTruth::farther(double more) const { return surfaces_farther(more) && !data_->contained_at_start(); }

bool MovingTruth::near_triangles_but(const std::vector<bool>& known) const {
  const double margin = data_->scene.margin;
  for (const auto& [i, j] : close_triangles(data_->a, data_->b, margin)) {
    if (known[static_cast<std::size_t>(i * data_->b.triangles.rows() + j)]) continue;
    const test::MovingMesh a = one_triangle(data_->a, i), b = one_triangle(data_->b, j);
    if (exact_contact(a, b) || (margin > 0 && reach(a, b, margin))) return true;
  }
  return false;
}

double MovingTruth::latest_first_contact() const {
  const std::optional<test::TimeBounds> bounds = exact_first_contact(data_->a, data_->b);
  return bounds ? bounds->high : 2;
}

}  // namespace encage::twins
