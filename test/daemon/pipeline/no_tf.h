// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/motion/frame_tree.h"
#include "daemon/pipeline/pipeline.h"

namespace lidard {

/// A vehicle without tf.
class NoTf final : public TransformSource {
 public:
  bool lookup(const std::string&, const std::string& child, Stamp, Pose&, std::string& why_not) override {
    why_not = "no tf for " + child;
    return false;
  }
};

}  // namespace lidard
