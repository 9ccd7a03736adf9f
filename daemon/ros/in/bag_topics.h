// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/offline/player.h"
#include "daemon/ros/in/inputs.h"
#include "daemon/ros/messages/bags_module.h"

namespace lidard {

/// True if the file's name ends with .bag.
bool is_bag(const std::string& path);
/// Moves the bags of a list into a list of their own.
std::vector<std::string> split_bags(std::vector<std::string>& captures);

/// True for one topic; either name may have a leading slash or none.
bool same_topic(const std::string& a, const std::string& b);
/// Opens bags. Throws std::runtime_error that names the file.
std::unique_ptr<BagReader> open_bags(const std::vector<std::string>& bags);

/// A configuration with the scans and clouds of bags as sources, with the other topics as comments.
std::string config_of_bags(const std::vector<std::string>& bags);

/// The messages of bags for sensors with `topic:` or `packet_topic:`, in the order in which they were
/// recorded.
class BagTopics final : public TimedMessages {
 public:
  /// Throws std::runtime_error that names what is missing: a source whose topic no bag has, or all sources.
  BagTopics(const std::vector<std::string>& bags, const Config& config);

  std::optional<Stamp> next() const override { return at_; }
  void feed(MessageReceiver* to, Stamp until) override;
  /// Messages passed and left out, by source.
  const std::vector<SourceReport>& report() const { return sources_; }
  /// Why the messages end before the bags do, with the files; empty: they do not.
  const std::string& damage() const { return damage_; }

 private:
  void advance();
  void check(const std::vector<std::string>& bags) const;
  const char* pass(SourceReport& source, MessageReceiver& to, Stamp received);

  std::unique_ptr<BagReader> reader_;
  std::vector<SourceReport> sources_;
  ClockStep clock_;
  BagMessage message_;
  std::optional<Stamp> at_;
  std::string damage_;
  PlanarScan scan_;
  Cloud cloud_;
};

}  // namespace lidard
