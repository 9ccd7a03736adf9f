// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/health/diagnostics.h"
#include "daemon/pipeline/status.h"

namespace lidard {

/// The item of an output: whether it publishes, its sources, mounts and motion.
DiagnosticItem output_health(const MakerStatus& status, Stamp now);
/// The item "motion": whether the poses of the vehicle keep up with the data.
DiagnosticItem motion_health(const MotionStatus& status);
/// What is missing in the newest frame, with the remedy; empty: nothing. `frame`: that of a sensor's clouds.
std::string pose_trouble(const PoseGate& gate, const std::string& frame = {});
/// "2 clouds not deskewed" with the newest trouble; empty: no losses.
std::string pose_losses(const PoseGate& gate, const std::string& frame);
/// Adds the counters, and WARN with pose_trouble() if the item is ok.
void add_pose_gate(const PoseGate& gate, const std::string& frame, DiagnosticItem& item);
/// Why stamps of `source` are replaced, with the remedy; `has_offset`: there is a key time_offset for them.
std::string clock_trouble(const std::string& source, Span ahead, bool has_offset);

}  // namespace lidard
