// SPDX-License-Identifier: GPL-3.0-or-later
#include "cagegen/render/png.h"

#include "src/files/atomic_file.h"

#include <encage/error.h>

#include <png.h>

#include <string>

namespace encage::render {

void write_png(const std::filesystem::path& file, const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) == 0) {
    throw Error(file.string() + ": cannot encode PNG: " + header.message);
  }
  bytes.resize(size);
  write_atomically(file, bytes);
}

}  // namespace encage::render
