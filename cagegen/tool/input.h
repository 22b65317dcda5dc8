// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "src/asset/aligned_bytes.h"
#include "src/asset/view.h"

#include <encage/bake.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace encage::tool {

/// Takes what a reader notes about a file.
using NoteSink = std::function<void(const std::string& note)>;

/// A file that a command reads, an asset or a mesh. "-" is standard input. What is no regular file is read once, into
/// memory.
class Input {
 public:
  /// `format` is an extension without its dot, and goes before that of the file. Reads nothing yet.
  explicit Input(std::filesystem::path file, std::string format = {});

  /// How messages call it: "standard input" for "-".
  const std::string& name() const { return name_; }
  /// Whether this is an asset of ours, damaged or not.
  bool is_asset();
  /// The format named, or that of the extension, in lower case; empty if there is none.
  std::string format() const;
  /// All bytes; valid as long as this object.
  std::string_view bytes();
  /// Throws Error unless this can be read and is binary glTF.
  void require_glb();
  /// The view is valid as long as this object.
  AssetView view(Verify verify);
  CageHierarchy asset(Verify verify);
  /// Calls `note` with "file: what the reader skipped or put up with".
  TriangleMesh mesh(const NoteSink& note);

 private:
  std::filesystem::path file_;
  std::string format_;
  std::string name_;  // for messages
  bool is_stream_;
  std::optional<std::string> bytes_;
  AlignedBytes aligned_;
};

/// Prints "note: …" on standard error.
void print_note(const std::string& note);

}  // namespace encage::tool
