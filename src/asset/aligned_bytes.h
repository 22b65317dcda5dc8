// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "src/asset/glb.h"

#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <string_view>

namespace encage {

/// A copy of a file's bytes at an address that AssetView takes. Nothing lies behind them, so that the address sanitizer
/// detects every read beyond the end.
class AlignedBytes {
 public:
  AlignedBytes() = default;
  explicit AlignedBytes(std::string_view bytes)
      : data_(static_cast<std::byte*>(::operator new(bytes.size(), alignment))), size_(bytes.size()) {
    if (size_ > 0) std::memcpy(data_.get(), bytes.data(), size_);
  }
  std::span<const std::byte> span() const { return {data_.get(), size_}; }

 private:
  static constexpr std::align_val_t alignment{asset_alignment};
  struct Release {
    void operator()(std::byte* data) const { ::operator delete(data, alignment); }
  };
  std::unique_ptr<std::byte, Release> data_;
  std::size_t size_ = 0;
};

}  // namespace encage
