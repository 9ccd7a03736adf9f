// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "daemon/health/diagnostics.h"

namespace lidard::test {

/// The value of a diagnostic item; "no such key" if it has none of that name.
inline std::string value_of(const DiagnosticItem& item, const std::string& key) {
  for (const auto& [name, text] : item.values)
    if (name == key) return text;
  return "no such key";
}

/// Keeps everything that a pipeline hands on, and fails the test for a scan that is not sound.
class RecordingSink final : public DiagnosticSink {
 public:
  /// `keep_frames` false: scans and clouds are counted and not kept, for long streams.
  explicit RecordingSink(bool keep_frames = true) : keep_frames_(keep_frames) {}

  void publish(const OutputTopic& topic, const Frame& frame, Stamp at) override {
    note(topic.name, at);
    if (const PlanarScan* const scan = frame.scan()) {
      EXPECT_EQ(violation(*scan), nullptr) << topic.name;
      if (keep_frames_) scans[topic.name].push_back(*scan);
    } else if (const Cloud* const cloud = frame.cloud()) {
      if (keep_frames_) clouds[topic.name].push_back(*cloud);
    } else if (const MergedCloud* const merged = frame.merged_cloud()) {
      if (keep_frames_) merged_clouds[topic.name].push_back(*merged);
    } else {
      messages[topic.name].push_back(*std::get<const DeviceMessage*>(frame));
    }
  }
  /// The messages of one type that came on a topic.
  template <class Kind>
  std::vector<Kind> of(const std::string& topic) const {
    std::vector<Kind> all;
    const auto found = messages.find(topic);
    if (found == messages.end()) return all;
    for (const DeviceMessage& message : found->second)
      if (const Kind* one = std::get_if<Kind>(&message)) all.push_back(*one);
    return all;
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
  std::map<std::string, std::vector<MergedCloud>> merged_clouds;
  std::map<std::string, std::vector<DeviceMessage>> messages;
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
