// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/tank/detector.h"

#include <algorithm>
#include <cmath>

namespace encage::tank {

/// Balls about the origin of the body frame: contacts in closed form.
class BallDetector : public Detector {
 public:
  explicit BallDetector(double radius) : radius_(radius) {}

  Eigen::AlignedBox3d box(const Eigen::Isometry3d& pose) const override {
    const double reach = radius_ + 1e-9;
    return {pose.translation().array() - reach, pose.translation().array() + reach};
  }
  double arc(const Motion&) const override { return 0; }

  std::optional<Contact> pair(const Motion& a, const Motion& b, const ContactOptions&) const override {
    const Eigen::Vector3d from = a.start.translation() - b.start.translation();
    const Eigen::Vector3d way = a.end.translation() - b.end.translation() - from;
    const double reach = 2 * radius_ + 1e-12;
    // Least t with |from + t way| = reach.
    const double qa = way.squaredNorm(), qb = from.dot(way), qc = from.squaredNorm() - reach * reach;
    double time = 0;
    if (qc > 0) {
      const double root = qb * qb - qa * qc;
      if (qb >= 0 || root < 0) return {};
      time = qc / (-qb + std::sqrt(root));
      if (time > 1) return {};
    }
    Contact contact;
    contact.time = time;
    contact.normal = (from + time * way).normalized();
    const Eigen::Vector3d at = b.start.translation() + time * (b.end.translation() - b.start.translation());
    contact.point = at + radius_ * contact.normal;
    return contact;
  }

  std::optional<Contact> wall(const Motion& motion, const HalfSpace& wall, const ContactOptions&) const override {
    const double before = wall.normal.dot(motion.start.translation()) - wall.offset - radius_ - 1e-12;
    const double after = wall.normal.dot(motion.end.translation()) - wall.offset - radius_ - 1e-12;
    if (after > 0) return {};
    Contact contact;
    contact.time = before > 0 ? before / (before - after) : 0;
    contact.kind = ContactKind::vertex_plane;
    contact.normal = wall.normal;
    const Eigen::Vector3d at =
        motion.start.translation() + contact.time * (motion.end.translation() - motion.start.translation());
    contact.point = at - radius_ * wall.normal;
    return contact;
  }

 private:
  double radius_;
};

}  // namespace encage::tank
