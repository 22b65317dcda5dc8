// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bench/covers/pair_lists.h"

#include <memory>
#include <string>
#include <vector>

namespace encage::covers {

/// Something simpler than a body, or the body itself: proves surfaces of two bodies of the same shape apart. Whether
/// one body lies wholly inside the other is not asked.
class Contestant {
 public:
  Contestant(std::string name, std::size_t bytes) : name_(std::move(name)), bytes_(bytes) {}
  virtual ~Contestant() = default;

  virtual bool apart(const PairCase& pair) const = 0;

  const std::string& name() const { return name_; }
  std::size_t bytes() const { return bytes_; }  ///< per shape

 private:
  std::string name_;
  std::size_t bytes_;
};

using Contestants = std::vector<std::unique_ptr<Contestant>>;

/// Sizes of covers to compare.
struct CoverSizes {
  std::vector<std::int64_t> balls = {200, 700, 2000, 8000};
  std::vector<std::int64_t> boxes = {500, 2000, 4000, 8000, 32000};
};

/// The fine mesh first; then cages, covers and combinations. They refer to the shape, which must have a fine mesh.
Contestants make_contestants(const Shape& shape, const CoverSizes& sizes);

}  // namespace encage::covers
