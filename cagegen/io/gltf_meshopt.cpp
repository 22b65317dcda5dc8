// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/io/gltf_meshopt.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace encage::io {
namespace {

/// Decodes version 1 of the attribute codec (KHR_meshopt_compression, appendix A, mode 0), which Debian 12's library
/// does not know. Elements stand in blocks. A block holds, for each byte of an element, the deltas from element to
/// element, 16 in a group.
class MeshoptAttributes {
 public:
  MeshoptAttributes(std::span<const std::uint8_t> data, std::size_t count, std::size_t stride)
      : count_(count), stride_(stride), channels_(stride / 4) {
    // The tail holds the element before the first one, and how each four bytes of an element are encoded.
    const std::size_t tail = std::max<std::size_t>(24, stride_ + channels_);
    valid_ = data.size() >= 1 + tail;
    if (!valid_) return;
    previous_.assign(data.end() - static_cast<std::ptrdiff_t>(stride_ + channels_),
                     data.end() - static_cast<std::ptrdiff_t>(channels_));
    modes_ = data.last(channels_);
    data_ = data.subspan(1, data.size() - 1 - tail);
  }

  std::optional<std::vector<std::uint8_t>> decode() {
    for (const std::uint8_t mode : modes_) {
      if ((mode & 15) > rotated || ((mode & 15) != rotated && mode >> 4 != 0)) return std::nullopt;
    }
    const std::size_t block = std::min<std::size_t>(8192 / stride_ & ~std::size_t{15}, max_block);
    for (std::size_t done = 0; valid_ && done < count_; done += block) decode_block(std::min(block, count_ - done));
    if (!valid_ || !data_.empty()) return std::nullopt;
    return std::move(result_);
  }

 private:
  static constexpr std::size_t max_block = 256, group = 16;
  enum ChannelMode : int { bytes, pairs, rotated };  ///< deltas of bytes, of two bytes, rotated ones of four
  using Deltas = std::array<std::uint8_t, max_block>;

  /// The next bytes of the data; none, and the data are not valid, if there are not so many.
  std::span<const std::uint8_t> take(std::size_t size) {
    valid_ = valid_ && size <= data_.size();
    if (!valid_) return {};
    const auto taken = data_.first(size);
    data_ = data_.subspan(size);
    return taken;
  }

  void decode_block(std::size_t elements) {
    const auto controls = take(channels_);
    for (std::size_t c = 0; c < channels_; ++c) {
      for (std::size_t k = 0; k < 4 && valid_; ++k) decode_deltas(controls[c] >> 2 * k & 3, elements, deltas_[k]);
      if (!valid_) return;
      result_.resize(std::max(result_.size(), (first_ + elements) * stride_));
      for (std::size_t i = 0; i < elements; ++i) {
        std::uint8_t* const before = previous_.data() + 4 * c;
        add_deltas(modes_[c], {deltas_[0][i], deltas_[1][i], deltas_[2][i], deltas_[3][i]}, before);
        std::memcpy(result_.data() + (first_ + i) * stride_ + 4 * c, before, 4);
      }
    }
    first_ += elements;
  }

  /// Makes four bytes of an element of those of the element before it.
  static void add_deltas(std::uint8_t mode, const std::array<std::uint8_t, 4>& deltas, std::uint8_t* value) {
    if ((mode & 15) == rotated) {
      std::uint32_t delta = 0, number = 0;
      std::memcpy(&delta, deltas.data(), 4);
      std::memcpy(&number, value, 4);
      number ^= std::rotr(delta, mode >> 4);
      std::memcpy(value, &number, 4);
    } else if (mode == pairs) {
      for (std::size_t k = 0; k < 4; k += 2) {
        const int delta = deltas[k] | deltas[k + 1] << 8;
        const int number = (value[k] | value[k + 1] << 8) + ((delta & 1) != 0 ? ~(delta >> 1) : delta >> 1);
        value[k] = static_cast<std::uint8_t>(number);
        value[k + 1] = static_cast<std::uint8_t>(number >> 8);
      }
    } else {
      for (std::size_t k = 0; k < 4; ++k) {
        const int delta = deltas[k];
        value[k] = static_cast<std::uint8_t>(value[k] + ((delta & 1) != 0 ? ~(delta >> 1) : delta >> 1));
      }
    }
  }

  void decode_deltas(int control, std::size_t elements, Deltas& deltas) {
    constexpr int widths[2][4] = {{0, 1, 2, 4}, {1, 2, 4, 8}};
    constexpr int all_zero = 2, literal = 3;
    if (control == all_zero) return deltas.fill(0);
    if (control == literal) {
      const auto raw = take(elements);
      std::copy(raw.begin(), raw.end(), deltas.begin());
      return;
    }
    const std::size_t groups = (elements + group - 1) / group;
    const auto header = take((groups + 3) / 4);
    for (std::size_t g = 0; g < groups && valid_; ++g) {
      decode_group(widths[control][header[g / 4] >> 2 * (g % 4) & 3], deltas.data() + g * group);
    }
  }

  /// Deltas of so many bits; those that do not fit follow behind as bytes.
  void decode_group(int bits, std::uint8_t* deltas) {
    const auto packed = take(group * static_cast<std::size_t>(bits) / 8);
    const int escape = (1 << bits) - 1;
    for (std::size_t i = 0; i < group && valid_; ++i) {
      const std::size_t bit = i * static_cast<std::size_t>(bits);
      // Single bits begin with the lowest of a byte, others with the highest.
      const std::size_t shift = bits == 1 ? bit % 8 : 8 - static_cast<std::size_t>(bits) - bit % 8;
      const int delta = bits == 0 ? 0 : packed[bit / 8] >> shift & escape;
      if (bits == 0 || bits == 8 || delta != escape) {
        deltas[i] = static_cast<std::uint8_t>(delta);
      } else if (const auto whole = take(1); valid_) {
        deltas[i] = whole[0];
      }
    }
  }

  std::span<const std::uint8_t> data_;  ///< not decoded yet
  std::span<const std::uint8_t> modes_;
  std::vector<std::uint8_t> previous_;  ///< the element before the next one
  std::size_t count_, stride_, channels_;
  std::size_t first_ = 0;  ///< element of the next block
  bool valid_ = true;
  std::array<Deltas, 4> deltas_{};
  std::vector<std::uint8_t> result_;
};

std::optional<std::vector<std::uint8_t>> decode_exactly(MeshoptMode mode, std::span<const std::uint8_t> data,
                                                        std::size_t count, std::size_t stride) {
  constexpr std::uint8_t attributes_version_1 = 0xA1;
  if (mode == MeshoptMode::attributes && !data.empty() && data[0] == attributes_version_1) {
    return MeshoptAttributes(data, count, stride).decode();
  }
  std::vector<std::uint8_t> result(count * stride);
  const int error = mode == MeshoptMode::attributes
                        ? meshopt_decodeVertexBuffer(result.data(), count, stride, data.data(), data.size())
                    : mode == MeshoptMode::triangles
                        ? meshopt_decodeIndexBuffer(result.data(), count, stride, data.data(), data.size())
                        : meshopt_decodeIndexSequence(result.data(), count, stride, data.data(), data.size());
  if (error != 0) return std::nullopt;
  return result;
}

}  // namespace

std::optional<std::vector<std::uint8_t>> decode_meshopt(MeshoptMode mode, std::span<const std::uint8_t> data,
                                                        std::size_t count, std::size_t stride) {
  // A group of 16 bytes takes two bits at least, in version 1 a block of 256.
  if (count > 1024 * (data.size() + 1) / stride) return std::nullopt;
  std::optional<std::vector<std::uint8_t>> result = decode_exactly(mode, data, count, stride);
  // Some writers round the length up to whole words. The codecs notice every byte too many.
  for (int padding = 1; !result && padding < 4 && !data.empty() && data.back() == 0; ++padding) {
    data = data.first(data.size() - 1);
    result = decode_exactly(mode, data, count, stride);
  }
  return result;
}

bool apply_meshopt_filter(std::string_view filter, std::vector<std::uint8_t>& elements, std::size_t stride) {
  const std::size_t count = elements.size() / stride;
  if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
    meshopt_decodeFilterOct(elements.data(), count, stride);
  } else if (filter == "QUATERNION" && stride == 8) {
    meshopt_decodeFilterQuat(elements.data(), count, stride);
  } else if (filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(elements.data(), count, stride);
  } else {
    return filter == "NONE";
  }
  return true;
}

}  // namespace encage::io
