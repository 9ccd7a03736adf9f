// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tf2/buffer_core.h>

#include <string>
#include <vector>

#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/transform_source.h"

namespace lidard {

/// TransformSource::lookup() on a buffer. The names may have a leading slash.
bool look_up(const tf2::BufferCore& buffer, const std::string& parent, const std::string& child, Stamp stamp,
             Pose& pose, std::string& why_not);

/// TransformSource::history() on a buffer.
void read_history(const tf2::BufferCore& buffer, const std::string& parent, const std::string& child,
                  Stamp after, Stamp until, std::vector<StampedPose>& poses);

}  // namespace lidard
