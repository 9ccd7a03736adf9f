// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "daemon/config/output_topics.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// What came out on one topic, or into one file.
struct OutputReport {
  std::string name;
  std::uint64_t messages = 0;
  Stamp first{}, last{};  ///< when the first and the last one were released
  bool promised = true;   ///< false: it depends on what the device has to tell
  std::string remark;     ///< why there is none, or what was missing

  void count(Stamp released);
  /// Messages per second; 0: fewer than two.
  double rate() const;
};

/// Hands everything on to another sink and counts it by topic.
class CountingSink final : public FrameSink {
 public:
  /// `sink` must outlive this; `topics` as in output_topics().
  CountingSink(FrameSink& sink, const std::vector<OutputTopic>& topics);

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override;
  void message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override {
    sink_.transforms(transforms, released);
  }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override {
    sink_.diagnostics(items, released);
  }

  /// One per topic, in the order of the configuration, without remarks.
  const std::vector<OutputReport>& reports() const { return reports_; }

 private:
  FrameSink& sink_;
  std::vector<OutputReport> reports_;
};

/// The table of outputs: a row for each that was promised or came, and one line for the others.
void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<OutputReport>& outputs);

}  // namespace lidard
