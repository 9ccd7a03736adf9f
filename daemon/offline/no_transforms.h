// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/motion/frame_tree.h"

namespace lidard {

/// The source without ROS: no transforms.
class NoTransforms final : public TransformSource {
 public:
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose&,
              std::string& why_not) override {
    why_not = "the pose of " + child + " in " + parent + " would come from tf, which needs ROS; configure it";
    return false;
  }
};

}  // namespace lidard
