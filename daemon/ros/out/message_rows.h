// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "daemon/ros/messages/message_row.h"

namespace lidard {

/// The row of what travels on a topic.
const MessageRow& row_of(const OutputTopic& topic);

/// For fixed transforms, and for the time of a replay.
std::unique_ptr<MessageMaker> transforms_maker();
std::unique_ptr<MessageMaker> clock_maker();

/// Where the outline of the vehicle is published, if it has one.
constexpr const char* outline_topic = "footprint";
/// The outline of the vehicle, at any time (geometry_msgs/PolygonStamped).
RawMessage outline_of(const VehicleConfig& vehicle);

}  // namespace lidard
