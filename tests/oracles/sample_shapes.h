// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Small shapes with handmade cages: concave, with cavities, of several parts, open.

#include <encage/shape.h>

#include <string>
#include <vector>

namespace encage::test {

struct Sample {
  std::string name;
  TriangleMesh source;  ///< local frame, in double; hierarchy.fine is this mesh rounded to float32
  CageHierarchy hierarchy;
};

/// Shapes of diagonal 1 to 5 about the origin. `jitter` moves the source's vertices away from their fine vertices, as
/// far as hierarchy.fine_error says.
std::vector<Sample> sample_shapes(double jitter);

/// Shapes of the same kinds with 1,000 to 2,048 triangles.
std::vector<Sample> large_sample_shapes(double jitter);

/// Sheets that are 2 and 2,048 wide, in coordinate planes (except for `jitter`): open ones, and closed ones without
/// volume.
std::vector<Sample> flat_shapes(double jitter);
std::vector<Sample> large_flat_shapes(double jitter);

/// Slivers: a needle 1e-4 thin, a fan of thin triangles, and tiny features on a large face.
std::vector<Sample> thin_shapes(double jitter);

/// Returns 2 n^2 triangles over [-half, half]^2 whose coordinates along the axis `across` are all 0.
TriangleMesh sheet(int n, int across, double half);

/// Returns the same sample in another unit: 2^exponent, so that float32 stays exact.
Sample scaled(const Sample& sample, int exponent);

/// Return the sample without its cages, or without its fine mesh.
Sample without_cages(Sample sample);
Sample without_fine(Sample sample);

}  // namespace encage::test
