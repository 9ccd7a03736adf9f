// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <diagnostic_msgs/DiagnosticArray.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <sensor_msgs/TimeReference.h>

#include "core/frames/device_message.h"

namespace lidard {

/// `at`: the message's own stamp on the host's clock. The covariance is unknown.
void to_ros(const GnssFix& fix, HostStamp at, sensor_msgs::NavSatFix& message);
void to_ros(const TimeReference& reference, HostStamp at, sensor_msgs::TimeReference& message);
/// The covariances are unknown.
void to_ros(const ImuSample& sample, HostStamp at, sensor_msgs::Imu& message);
/// One status of an array, which has a stamp and needs no message package of ours; `topic` is its name.
void to_ros(const DeviceState& state, HostStamp at, diagnostic_msgs::DiagnosticArray& message);

}  // namespace lidard
