// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/frames/frame_filter.h"
#include "drivers/document.h"
#include "drivers/key.h"
#include "drivers/model.h"

namespace lidard {

/// `filter:` of a sensor: returns that are removed from the messages of its own topics.
/// Those of filters that are switched off do not apply.
Keys filter_keys(FrameFilterSettings& filter);
/// What is filtered: a device that gives a scan, be it that of a ring, or none, with or without intensities.
struct FilteredFrames {
  const Model& model;
  bool have_scan, have_intensities;
};
/// Reads the boxes, and loads what is needed. `yaml`: the section.
void check_filter(const Mapping& yaml, const FilteredFrames& frames, FrameFilterSettings& filter);

}  // namespace lidard
