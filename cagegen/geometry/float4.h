// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace encage::makers {

/// Four floats with lane-wise arithmetic (compiler vector extension: SSE, NEON or scalar).
struct Float4 {
  using Lanes = float __attribute__((vector_size(16)));
  Lanes lanes;

  static Float4 broadcast(float x) { return {Lanes{x, x, x, x}}; }
  static Float4 load(const float* p) { return {Lanes{p[0], p[1], p[2], p[3]}}; }

  friend Float4 operator+(Float4 a, Float4 b) { return {a.lanes + b.lanes}; }
  friend Float4 operator-(Float4 a, Float4 b) { return {a.lanes - b.lanes}; }
  friend Float4 operator*(Float4 a, Float4 b) { return {a.lanes * b.lanes}; }
};

/// One truth value a lane.
struct Mask4 {
  using Lanes = std::int32_t __attribute__((vector_size(16)));
  Lanes lanes;

  bool lane(int i) const { return lanes[i] != 0; }
  bool any() const { return (lanes[0] | lanes[1] | lanes[2] | lanes[3]) != 0; }
  friend Mask4 operator&(Mask4 a, Mask4 b) { return {a.lanes & b.lanes}; }
};

inline Mask4 operator<=(Float4 a, Float4 b) { return {a.lanes <= b.lanes}; }
inline Float4 max(Float4 a, Float4 b) { return {a.lanes < b.lanes ? b.lanes : a.lanes}; }

}  // namespace encage::makers
