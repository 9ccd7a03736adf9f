// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/pipeline/sink.h"

namespace lidard::test {

/// The value of a diagnostic item; "no such key" if it has none of that name.
inline std::string value_of(const DiagnosticItem& item, const std::string& key) {
  for (const auto& [name, text] : item.values)
    if (name == key) return text;
  return "no such key";
}

/// Keeps everything that a pipeline hands on, and fails the test for a scan that is not sound.
class RecordingSink final : public FrameSink {
 public:
  /// `keep_frames` false: scans and clouds are counted and not kept, for long streams.
  explicit RecordingSink(bool keep_frames = true) : keep_frames_(keep_frames) {}

  void scan(const std::string& topic, const PlanarScan& scan, Stamp at) override {
    EXPECT_EQ(violation(scan), nullptr) << topic;
    note(topic, at);
    if (keep_frames_) scans[topic].push_back(scan);
  }
  void cloud(const std::string& topic, Cloud& cloud, Stamp at) override {
    note(topic, at);
    if (keep_frames_) clouds[topic].push_back(cloud);
  }
  void fix(const std::string& topic, const GnssFix& fix, Stamp at) override {
    note(topic, at);
    fixes[topic].push_back(fix);
  }
  void time_reference(const std::string& topic, const TimeReference& reference, Stamp at) override {
    note(topic, at);
    references[topic].push_back(reference);
  }
  void imu(const std::string& topic, const ImuSample& sample, Stamp at) override {
    note(topic, at);
    samples[topic].push_back(sample);
  }
  void state(const std::string& topic, const DeviceState& state, Stamp at) override {
    note(topic, at);
    states[topic].push_back(state);
  }
  void transforms(const std::vector<StaticTransform>& all, Stamp) override { static_transforms = all; }
  void diagnostics(const std::vector<DiagnosticItem>& items, Stamp at) override {
    ++tellings;
    newest = items;
    for (const auto& item : items) {
      auto& changes = healths[item.name];
      if (changes.empty() || changes.back().first != item.health) changes.emplace_back(item.health, at);
    }
  }

  /// The newest diagnostic item of that name.
  const DiagnosticItem& item(const std::string& name) const {
    for (const auto& one : newest)
      if (one.name == name) return one;
    throw std::out_of_range(name);
  }
  /// How many messages came on a topic.
  std::size_t count(const std::string& topic) const {
    const auto found = released.find(topic);
    return found == released.end() ? 0 : found->second.size();
  }

  std::vector<std::string> topics;  ///< of all messages, in their order
  std::map<std::string, std::vector<Stamp>> released;
  std::map<std::string, std::vector<PlanarScan>> scans;
  std::map<std::string, std::vector<Cloud>> clouds;
  std::map<std::string, std::vector<GnssFix>> fixes;
  std::map<std::string, std::vector<TimeReference>> references;
  std::map<std::string, std::vector<ImuSample>> samples;
  std::map<std::string, std::vector<DeviceState>> states;
  std::vector<StaticTransform> static_transforms;
  std::vector<DiagnosticItem> newest;
  std::map<std::string, std::vector<std::pair<Health, Stamp>>> healths;  ///< changes, by the item's name
  int tellings = 0;                                                      ///< of diagnostics

 private:
  void note(const std::string& topic, Stamp at) {
    if (keep_frames_) topics.push_back(topic);
    released[topic].push_back(at);
  }

  bool keep_frames_;
};

}  // namespace lidard::test
