// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config_sources.h"

#include <algorithm>

#include "core/base/nearest.h"
#include "daemon/config/output_topics.h"

namespace lidard {
namespace {

std::string kind_of(const SensorConfig& sensor) {
  const bool cloud = sensor.model->kind == FrameKind::cloud;
  return std::string(sensor.model->name) + (cloud ? ", which gives clouds" : ", which gives scans");
}

bool can_give(const SensorConfig& sensor, FrameKind kind) {
  if (kind == FrameKind::scan && sensor.ring_scan) return true;
  return sensor.model == nullptr || sensor.model->kind == kind;
}

/// A name by which something may be called, and what it is.
struct Candidate {
  std::string called;  // as in the configuration
  FrameKind kind;      // of the frames under that name
  NamedSource source;
  std::string what;  // for messages
};

void add_sensor(const SensorConfig& sensor, FrameKind wanted, std::vector<Candidate>& candidates) {
  const NamedSource source{&sensor, nullptr, sensor.name};
  const std::string path = "sensors." + sensor.name;
  candidates.push_back({sensor.name, can_give(sensor, wanted) ? wanted : sensor.model->kind, source, path});
  if (sensor.model == nullptr) {
    candidates.push_back({sensor.topic, wanted, source, "the topic of " + path});
    return;
  }
  for (const OutputTopic& topic : sensor_topics(sensor)) {
    const TopicKind kind = topic.kind;
    if (!topic.promised || (kind != TopicKind::scan && kind != TopicKind::cloud)) continue;
    candidates.push_back({topic.name, kind == TopicKind::cloud ? FrameKind::cloud : FrameKind::scan, source,
                          "the topic of " + path});
  }
}

/// Groups whose topics carry the scans of one frame each.
bool has_own_topics(const VirtualScanConfig& group) {
  return group.output_laser_topic.empty() || group.virtual_laser_scan.size() == 1;
}

std::vector<Candidate> candidates_of(const Config& config, FrameKind wanted) {
  std::vector<Candidate> candidates;
  for (const SensorConfig& sensor : config.sensors) add_sensor(sensor, wanted, candidates);
  for (const VirtualScanConfig& group : config.virtual_scans) {
    if (!has_own_topics(group)) continue;
    for (const std::string& frame : group.virtual_laser_scan)
      candidates.push_back({group.topic(frame),
                            FrameKind::scan,
                            {nullptr, &group, group.topic(frame)},
                            "the topic of virtual_scans." + group.name});
  }
  return candidates;
}

bool same_source(const Candidate& a, const Candidate& b) {
  return a.source.sensor == b.source.sensor && a.source.name == b.source.name;
}

/// The names that somebody who wrote `written` may have meant, best first, at most three.
std::string nearest_of(const std::string& written, const std::vector<Candidate>& candidates,
                       FrameKind wanted) {
  constexpr std::size_t most = 3;
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const Candidate& one : candidates) {
    const std::size_t distance = edit_distance(without_slash(written), without_slash(one.called));
    if (one.kind == wanted && is_plausible_slip(written, distance)) near.emplace_back(distance, one.called);
  }
  std::sort(near.begin(), near.end());
  near.erase(std::unique(near.begin(), near.end()), near.end());
  std::string list;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i)
    list += (i == 0 ? "" : " or ") + near[i].second;
  return list;
}

[[noreturn]] void fail_unknown(const Value& value, const std::vector<Candidate>& candidates, FrameKind wanted,
                               const std::string& expected) {
  const std::string near = nearest_of(value.text(), candidates, wanted);
  value.fail("names " + value.quoted() + ", which is no sensor and no topic of one",
             near.empty() ? expected : near);
}

}  // namespace

std::string names_of(const Config& config, FrameKind kind) {
  std::string list;
  for (const SensorConfig& sensor : config.sensors) {
    if (can_give(sensor, kind)) list += (list.empty() ? "" : ", ") + sensor.name;
  }
  return list.empty() ? "none is configured" : list;
}

NamedSource read_source(const Value& value, FrameKind kind, const Reading& reading,
                        const std::string& expected) {
  const std::string name = without_slash(value.text(expected));
  const std::vector<Candidate> candidates = candidates_of(reading.config, kind);
  const Candidate* found = nullptr;
  const Candidate* other_kind = nullptr;
  for (const Candidate& one : candidates) {
    if (without_slash(one.called) != name) continue;
    if (one.kind != kind) {
      other_kind = &one;
    } else if (found == nullptr) {
      found = &one;
    } else if (!same_source(*found, one)) {
      value.fail("names " + value.quoted() + ", which is " + found->what + " and " + one.what,
                 "a name that only one of them has");
    }
  }
  if (found != nullptr) return found->source;
  if (reading.may_be_named(name)) throw AlreadyNoted();
  if (other_kind == nullptr) fail_unknown(value, candidates, kind, expected);
  if (other_kind->source.sensor == nullptr)
    value.fail("names " + other_kind->called + ", a virtual scan, which gives no clouds", expected);
  value.fail("names " + other_kind->called + ", " +
                 (other_kind->called == other_kind->source.name ? "a " : "of a ") +
                 kind_of(*other_kind->source.sensor),
             expected);
}

std::vector<std::string> virtual_topics(const Config& config) {
  std::vector<std::string> topics;
  for (const VirtualScanConfig& group : config.virtual_scans) {
    if (!has_own_topics(group)) continue;
    for (const std::string& frame : group.virtual_laser_scan) topics.push_back(group.topic(frame));
  }
  return topics;
}

}  // namespace lidard
