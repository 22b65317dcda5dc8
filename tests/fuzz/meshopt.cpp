// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/fuzz/meshopt.h"

#include "cagegen/io/gltf_meshopt.h"
#include "tests/fuzz/fuzz.h"

#include <cstring>
#include <optional>
#include <span>
#include <vector>

using namespace encage;

// The glTF reader asks for nothing else than what the types of a MeshoptInput allow.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::MeshoptInput input;
  if (size < sizeof input) return -1;
  std::memcpy(&input, data, sizeof input);
  const std::span compressed(data + sizeof input, size - sizeof input);
  const auto mode = static_cast<io::MeshoptMode>(input.mode % 3);
  const bool attributes = mode == io::MeshoptMode::attributes;
  const std::size_t stride = attributes ? input.stride % 64 * 4u + 4 : input.stride % 2 * 2u + 2;
  const std::size_t count = (input.count + std::size_t{1}) * (mode == io::MeshoptMode::triangles ? 3 : 1);
  fuzz::reads(fuzz::memory_for(size), [&] {
    std::optional<std::vector<std::uint8_t>> result = io::decode_meshopt(mode, compressed, count, stride);
    if (!result) return;
    fuzz::require(result->size() == count * stride, "another number of bytes than asked for");
    if (!attributes) return;
    io::apply_meshopt_filter(fuzz::meshopt_filters[input.filter % std::size(fuzz::meshopt_filters)], *result, stride);
    fuzz::require(result->size() == count * stride, "a filter changed the number of bytes");
  });
  return 0;
}
