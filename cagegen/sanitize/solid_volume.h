// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <encage/mesh.h>

namespace encage::io {

/// Volume of the points that a closed mesh winds around, in cubic units; where its parts overlap, contain or intersect
/// each other, signed_volume() counts points several times. Equal to signed_volume() if no ray of a grid finds such
/// points. Otherwise their volume is summed along the rays: accurate to about a thousandth of that volume.
double solid_volume(const TriangleMesh& mesh);

}  // namespace encage::io
