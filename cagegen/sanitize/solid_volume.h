// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

#include <cstdint>
#include <vector>

namespace encage::io {

/// Volume of the points that a closed mesh winds around, in cubic units. signed_volume() is that too, but where parts
/// contain, overlap or intersect each other it counts points several times. `parts` are the closed surfaces that the
/// mesh consists of, as lists of triangles. Rays of a grid tell what is counted several times: if nothing is, the
/// result is signed_volume(); if parts only contain each other, it is exact up to rounding; otherwise it is summed
/// along the rays, and off by about a thousandth.
double solid_volume(const TriangleMesh& mesh, const std::vector<std::vector<std::int32_t>>& parts);

}  // namespace encage::io
