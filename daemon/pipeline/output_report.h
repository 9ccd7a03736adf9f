// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
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
  /// `sink` must outlive this.
  CountingSink(FrameSink& sink, const std::vector<OutputTopic>& topics);

  void scan(const std::string& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const std::string& topic, Cloud& cloud, Stamp released) override;
  void fix(const std::string& topic, const GnssFix& fix, Stamp released) override;
  void time_reference(const std::string& topic, const TimeReference& reference, Stamp released) override;
  void imu(const std::string& topic, const ImuSample& sample, Stamp released) override;
  void state(const std::string& topic, const DeviceState& state, Stamp released) override;
  void transforms(const std::vector<StaticTransform>& transforms, Stamp released) override {
    sink_.transforms(transforms, released);
  }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) override {
    sink_.diagnostics(items, released);
  }

  /// One per topic, in the order of the configuration, without remarks.
  const std::vector<OutputReport>& reports() const { return reports_; }

 private:
  void count(const std::string& topic, Stamp released);

  FrameSink& sink_;
  std::vector<OutputReport> reports_;
  std::map<std::string, std::size_t> places_;  // of a topic in reports_
};

/// The table of outputs: a row for each that was promised or came, and one line for the others.
void print_outputs(const char* head, const std::vector<OutputReport>& outputs, std::ostream& out);
/// False if an output that was promised never came.
bool all_came(const std::vector<OutputReport>& outputs);

}  // namespace lidard
