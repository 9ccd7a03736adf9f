// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/missing_outputs.h"

#include <spdlog/fmt/fmt.h>

#include "daemon/config/output_topics.h"
#include "daemon/pipeline/merged_output.h"
#include "daemon/pipeline/report.h"
#include "daemon/pipeline/sensor.h"
#include "daemon/pipeline/sensor_health.h"
#include "daemon/pipeline/virtual_output.h"

namespace lidard {
namespace {

/// Why a sensor gave no frames; empty: it gave some.
std::string why_no_frames(const Sensor& line, const std::vector<std::string>& unclaimed_senders) {
  if (line.driver == nullptr) {
    if (line.topic_counters.frames > 0) return {};
    return line.seen ? "no message of " + line.config.topic + " could be used"
                     : "no message came on " + line.config.topic + ", which another node publishes";
  }
  const Counters& counters = line.driver->counters();
  if (counters.frames > 0) return {};
  if (line.seen) return why_no_frame(*line.config.model, counters, line.last_arrival - line.first_arrival);
  std::string text = "nothing came from " + where_from(line.config);
  if (const std::string sender = likely_sender(line.config, unclaimed_senders); !sender.empty())
    text += ", but packets from " + sender + ": correct ip_address?";
  return text;
}

bool has_topic(const Sensor& line, const std::string& topic) {
  for (const OutputTopic& one : sensor_topics(line.config)) {
    if (one.name == topic) return true;
  }
  return false;
}

}  // namespace

std::string why_no_frame(const Model& model, const Counters& counters, Span span) {
  if (counters.packets > 0 && counters.rejected_total() >= counters.packets)
    return "no packet could be used, rejected " + rejected_text(counters) + "; is it a " +
           std::string(model.product) + "?";
  const std::string data = fmt::format("{} packets in {:.3f} s, a whole one usually takes {} s",
                                       counters.packets, seconds(span), model.frame_period);
  const double part = seconds(span) / model.frame_period;
  if (part < 0.95) return fmt::format("only about {:.1f} of a frame: {}", part, data);
  return fmt::format("no whole frame: {}; {} lost, {} frames cut off by begin, end or loss", data,
                     counters.lost_packets, counters.partial_frames);
}

std::string why_missing(const std::string& topic, const std::vector<std::unique_ptr<Sensor>>& lines,
                        const std::vector<std::unique_ptr<MergedOutput>>& merged,
                        const std::vector<std::unique_ptr<VirtualOutput>>& virtuals,
                        const std::vector<std::string>& unclaimed_senders) {
  const auto why_silent = [&](const std::string& source) -> std::string {
    for (const auto& line : lines) {
      if (line->config.name != source) continue;
      const std::string why = why_no_frames(*line, unclaimed_senders);
      return why.empty() ? why : " (" + why + ")";
    }
    return {};
  };
  for (const auto& output : merged) {
    if (output->publishes(topic)) return output->why_missing(why_silent);
  }
  for (const auto& output : virtuals) {
    if (output->publishes(topic)) return output->why_missing(topic, why_silent);
  }
  for (const auto& line : lines) {
    if (has_topic(*line, topic)) return why_no_frames(*line, unclaimed_senders);
  }
  return {};
}

}  // namespace lidard
