// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "daemon/pipeline/output_report.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

class Output;

/// The way on for frames: to every sink, and to the merged and virtual scans that are made of them. Sources
/// are numbered: sensors by their place in the configuration, after them the topics by OutputTopic::id.
class Outlet {
 public:
  /// The sinks must outlive this.
  Outlet(std::vector<OutputTopic> topics, std::vector<FrameSink*> sinks, std::size_t sensors);

  const std::vector<OutputTopic>& topics() const { return topics_; }
  std::size_t source_of(const OutputTopic& topic) const { return sensors_ + topic.id; }
  /// From now on `output` takes what the source gives, as its source number `place`.
  void connect(std::size_t source, Output& output, std::size_t place);

  /// To the sinks.
  void publish(const OutputTopic& topic, const PlanarScan& scan, Stamp now);
  /// May swap out cloud.points_bytes.
  void publish(const OutputTopic& topic, Cloud& cloud, Stamp now);
  void publish(const OutputTopic& topic, const DeviceMessage& message, Stamp now);
  void publish(const std::vector<DiagnosticItem>& items, Stamp now);
  /// To the outputs that are made of this source.
  void feed(std::size_t source, const PlanarScan& scan, Stamp now);
  void feed(std::size_t source, const Cloud& cloud, Stamp now);

  /// What came out, one for each of topics().
  const std::vector<OutputReport>& reports() const { return reports_; }

 private:
  struct Consumer {
    Output* output;
    std::size_t place;  // of the source among those of the output
  };
  const std::vector<OutputTopic> topics_;
  const std::vector<FrameSink*> sinks_;
  const std::size_t sensors_;
  std::vector<std::vector<Consumer>> consumers_;  // by source
  std::vector<OutputReport> reports_;
  Cloud copy_;  // for all sinks but the last
};

}  // namespace lidard
