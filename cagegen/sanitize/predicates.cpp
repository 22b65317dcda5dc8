// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/sanitize/predicates.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

namespace encage::io {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_2 point(const Eigen::Vector2d& p) { return {p[0], p[1]}; }
Kernel::Point_3 point(const Eigen::Vector3d& p) { return {p[0], p[1], p[2]}; }

}  // namespace

int orientation(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return CGAL::orientation(point(a), point(b), point(c));
}

int orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                const Eigen::Vector3d& d) {
  return CGAL::orientation(point(a), point(b), point(c), point(d));
}

bool collinear(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return CGAL::collinear(point(a), point(b), point(c));
}

bool strictly_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return CGAL::collinear_are_strictly_ordered_along_line(point(a), point(b), point(c));
}

}  // namespace encage::io
