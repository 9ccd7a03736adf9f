// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/model.h"

namespace lidard {

struct Sensor;
class MergedOutput;
class VirtualOutput;

/// Why a driver that got packets over a time of `span` gave no whole frame: "only about 0.4 of a frame: …".
std::string why_no_frame(const Model& model, const Counters& counters, Span span);

/// Why nothing came on a topic of a pipeline with these parts; empty: nothing is missing.
/// `unclaimed_senders` as in Pipeline.
std::string why_missing(const std::string& topic, const std::vector<std::unique_ptr<Sensor>>& lines,
                        const std::vector<std::unique_ptr<MergedOutput>>& merged,
                        const std::vector<std::unique_ptr<VirtualOutput>>& virtuals,
                        const std::vector<std::string>& unclaimed_senders);

}  // namespace lidard
