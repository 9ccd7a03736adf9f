// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "daemon/files/snapshot_view.h"

namespace lidard {

/// Writes pictures of one size as a loop that a browser or a chat shows.
class Animation {
 public:
  virtual ~Animation() = default;
  /// Throws std::runtime_error if it cannot be taken.
  virtual void add(const Pixels& picture) = 0;
  /// Completes the file; throws std::runtime_error.
  virtual void finish() = 0;
};

/// A .gif or a .webp, by the path's end; each picture is shown for `seconds`.
std::unique_ptr<Animation> make_animation(const std::string& path, double seconds);

}  // namespace lidard
