// SPDX-License-Identifier: Apache-2.0
#pragma once

// Numbers that several parts of the library share. Each is defined once, with its unit and its reason.

#include <limits>

namespace encage {

/// 2^-52, twice the largest relative error of one operation in double. It is the unit of error bounds.
inline constexpr double eps = std::numeric_limits<double>::epsilon();

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// World units. Largest coordinate, margin and size that queries accept: products of two such lengths, and sums of many
/// products, stay below 1e308.
inline constexpr double largest_length = 1e150;

/// Range of a body's scale. The product of the scales of a body, of its part and of a part of that stays far from
/// overflow and underflow.
inline constexpr double smallest_scale = 1e-50, largest_scale = 1e50;

/// Units of the mesh. Largest coordinate of a mesh that is rounded to float32: boxes around it, with their rounding,
/// stay below the largest float, 3.4e38.
inline constexpr double largest_coordinate = 1e37;

/// Units of the mesh. The least extent of a source: float32 holds coordinates within it as normal numbers.
inline constexpr double smallest_extent = 1e-30;

/// Without unit. Bounds how far R^T R of a pose may be from the identity (spectral norm), and the length of a normal
/// from 1. Poses that a simulation integrates in double stay within it; bounds of lengths grow by a factor of 1 + 1e-9
/// at most.
inline constexpr double rigid_tolerance = 1e-9;

/// Units squared. Where a squared norm exceeds it, the bits that its terms lost to underflow are below their rounding:
/// eps * 1e-280 is a normal number.
inline constexpr double smallest_square = 1e-280;

/// The same for products that are compared with an error bound.
inline constexpr double smallest_product = 1e-290;

}  // namespace encage
