// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/health/diagnostics.h"
#include "daemon/health/topic_watch.h"

namespace lidard {

/// The item of a topic: rate, regularity and latency, and whether a subscriber is too slow.
DiagnosticItem topic_health(const std::string& topic, const TopicFigures& figures);

}  // namespace lidard
