// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "daemon/health/diagnostics.h"
#include "daemon/pipeline/pipeline.h"

namespace lidard {

/// The items of everything in a pipeline.
std::vector<DiagnosticItem> items_of(const Pipeline& pipeline, Stamp now);
/// What /diagnostics says of one of output_topics() on which nothing came, or not all; empty: all came.
std::string why_missing(const Pipeline& pipeline, const std::string& topic);
/// What came out so far, one for each of output_topics(), with what was missing in it as its remark.
std::vector<TopicTotals> topic_totals(const Pipeline& pipeline);

/// Gives the items of a pipeline to a sink, once per second and when a source comes or goes.
class HealthReporter {
 public:
  /// The arguments must outlive this. `add_items`: adds what others know (sockets).
  HealthReporter(Pipeline& pipeline, DiagnosticSink& sink,
                 std::function<void(std::vector<DiagnosticItem>&)> add_items = {});
  ~HealthReporter() {
    pipeline_.set_reporter([](Stamp) {});
  }
  HealthReporter(const HealthReporter&) = delete;
  HealthReporter& operator=(const HealthReporter&) = delete;

 private:
  Pipeline& pipeline_;
};

}  // namespace lidard
