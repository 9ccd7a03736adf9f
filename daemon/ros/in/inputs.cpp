// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/inputs.h"

#include <ros/names.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "daemon/health/sentences.h"
#include "daemon/log/log.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/master/master_client.h"
#include "daemon/ros/messages/convert.h"
#include "daemon/ros/velodyne/velodyne_scan.h"

namespace lidard {
namespace {

/// Messages of one source that may wait for the sensor thread.
constexpr int most_pending = 4;

/// Until the master was asked and connections had time to come no publisher counts as missing.
constexpr auto first_patience = std::chrono::seconds(2);

/// The kind of frames that the outputs need from a source.
std::optional<FrameKind> use_of(const std::string& sensor, const Config& config) {
  for (const auto& merged : config.merged_scans) {
    const auto& names = merged.laserscan_topics;
    if (std::find(names.begin(), names.end(), sensor) != names.end()) return FrameKind::scan;
  }
  for (const auto& merged : config.merged_clouds) {
    if (std::find(merged.sources.begin(), merged.sources.end(), sensor) != merged.sources.end())
      return FrameKind::cloud;
  }
  for (const auto& group : config.virtual_scans) {
    if (group.cloud_topic == sensor) return FrameKind::cloud;
  }
  return std::nullopt;
}

void judge(const SourceReport& report, bool waits, DiagnosticItem& item) {
  if (!report.wrong_type.empty()) {
    item.set(Health::error, report.wrong_type);
  } else if (report.messages == 0) {
    waits ? item.set<says::waiting_for_message>() : item.set<says::nobody_publishes>(report.topic);
  } else if (report.rejected > 0 && std::chrono::steady_clock::now() - report.rejected_at < incident_lasts) {
    item.set<says::unusable_messages>(report.last_reason, report.topic);
  } else {
    item.set<says::receiving>();
  }
}

}  // namespace

std::vector<TopicSource> topic_sources(const Config& config) {
  std::vector<TopicSource> sources;
  for (const auto& sensor : config.sensors) {
    if (sensor.model == nullptr)
      sources.push_back({sensor.name, sensor.topic, false, use_of(sensor.name, config)});
    if (!sensor.packet_topic.empty()) sources.push_back({sensor.name, sensor.packet_topic, true, {}});
  }
  return sources;
}

const char* read_message(const sensor_msgs::LaserScan& message, const ClockStep& clock, PlanarScan& scan,
                         SourceReport& report) {
  const char* const error = from_ros(message, scan, clock);
  if (error == nullptr && !intensities_fit(message)) ++report.intensities_ignored;
  return error;
}

const char* read_message(const sensor_msgs::PointCloud2& message, const ClockStep& clock, Cloud& cloud,
                         SourceReport& report) {
  const CloudReading reading = from_ros(message, cloud, clock);
  if (reading.error != nullptr) return reading.error;
  report.points_dropped += reading.dropped;
  if (cloud.end == cloud.stamp) ++report.without_times;
  return nullptr;
}

struct RosInputs::Source {
  mutable std::mutex mutex;
  SourceReport report;
  int pending = 0;
  bool subscribed = false;  // belongs to the master thread

  bool accepts(FrameKind frames) const { return !report.packets && report.kind.value_or(frames) == frames; }
  void reject_type() {
    std::string expected = report.packets ? VelodyneScanMessage::message_type().name : "";
    if (accepts(FrameKind::scan)) expected = type_of<sensor_msgs::LaserScan>().name;
    if (accepts(FrameKind::cloud))
      expected += (expected.empty() ? "" : " or ") + type_of<sensor_msgs::PointCloud2>().name;
    const std::lock_guard lock(mutex);
    report.wrong_type = text<says::wrong_type>(report.topic, report.type, expected);
    log_error("{}", report.wrong_type);
  }
};

RosInputs::RosInputs(const std::vector<TopicSource>& sources, RosPost post, SharedClockStep clock)
    : post_(std::move(post)), clock_(std::move(clock)) {
  for (const auto& source : sources) {
    sources_.push_back(std::make_shared<Source>());
    static_cast<TopicSource&>(sources_.back()->report) = source;
  }
}

RosInputs::~RosInputs() = default;

void RosInputs::disconnected() {
  ros_ = nullptr;
  for (auto& source : sources_) {
    const std::lock_guard lock(source->mutex);
    source->subscribed = false;
    source->report.type.clear();
  }
}

/// `read` makes a task of a message, or returns its fault.
template <typename Message, typename Read>
void RosInputs::subscribe_as(const MessageType& type, const std::shared_ptr<Source>& source, Read read) {
  const auto receive = [source, read, post = post_](const boost::shared_ptr<const Message>& message) {
    const std::lock_guard lock(source->mutex);
    SourceReport& report = source->report;
    ++report.messages;
    if (source->pending >= most_pending) {
      ++report.dropped;
      return;
    }
    RosTask task;
    if (const char* const reason = read(message, report, task)) {
      ++report.rejected;
      report.rejected_at = std::chrono::steady_clock::now();
      if (report.last_reason != reason) log_warn("{}", text<says::unusable_messages>(reason, report.topic));
      report.last_reason = reason;
      return;
    }
    ++source->pending;
    post(report.sensor, [source, task](MessageReceiver& to, Stamp received) {
      task(to, received);
      const std::lock_guard done(source->mutex);
      --source->pending;
    });
  };
  // roscpp itself refuses a publisher of another type or md5sum.
  RosComponent::subscribe<Message>(*ros_, source->report.topic, 10, receive, type);
  source->subscribed = true;
}

void RosInputs::subscribe(const std::shared_ptr<Source>& source, const std::string& type) {
  using sensor_msgs::LaserScan;
  using sensor_msgs::PointCloud2;
  const auto& packets = VelodyneScanMessage::message_type();
  const std::string& sensor = source->report.sensor;
  if (source->report.packets && type == packets.name) {
    subscribe_as<RawMessage>(
        packets, source, [sensor, clock = clock_](const auto& message, SourceReport&, RosTask& task) {
          const ByteView bytes(message->data.message_start, message->size());
          task = [=, keeps_bytes = message](auto& to, Stamp received) {
            read_velodyne_scan(bytes, [&](ByteView packet, HostStamp arrival) {
              // A missing stamp (1970) is the time of reception.
              const Stamp stamp = arrival == HostStamp{} ? received : clock->steady(arrival);
              to.packet_message(sensor, {packet, stamp, {}, {}}, received);
            });
          };
          // Parse it before it is passed on, so that a bad message is counted at once.
          return read_velodyne_scan(bytes, [](ByteView, HostStamp) {});
        });
  } else if (type == type_of<LaserScan>().name && source->accepts(FrameKind::scan)) {
    subscribe_as<LaserScan>(
        type_of<LaserScan>(), source,
        [sensor, clock = clock_](const auto& message, SourceReport& report, RosTask& task) {
          const auto scan = std::make_shared<PlanarScan>();
          const char* const error = read_message(*message, *clock, *scan, report);
          task = [=](auto& to, Stamp received) { to.scan_message(sensor, *scan, received); };
          return error;
        });
  } else if (type == type_of<PointCloud2>().name && source->accepts(FrameKind::cloud)) {
    subscribe_as<PointCloud2>(
        type_of<PointCloud2>(), source,
        [sensor, clock = clock_](const auto& message, SourceReport& report, RosTask& task) {
          const auto cloud = std::make_shared<Cloud>();
          const char* const error = read_message(*message, *clock, *cloud, report);
          task = [=](auto& to, Stamp received) { to.cloud_message(sensor, *cloud, received); };
          return error;
        });
  } else {
    source->reject_type();
  }
}

void RosInputs::poll(MasterClient& master) {
  const bool all = std::all_of(sources_.begin(), sources_.end(), [](const auto& s) { return s->subscribed; });
  if (all || ros_ == nullptr) return;
  const auto types = master.topic_types();
  for (auto& source : sources_) {
    const auto found = types.find(ros::names::resolve(source->report.topic));
    // "*" is the type of a topic with subscribers only.
    if (source->subscribed || found == types.end() || found->second == "*") continue;
    {
      const std::lock_guard lock(source->mutex);
      if (std::exchange(source->report.type, found->second) == found->second) continue;
      source->report.wrong_type.clear();
    }
    subscribe(source, found->second);
  }
}

std::vector<SourceReport> RosInputs::report() const {
  std::vector<SourceReport> all;
  for (const auto& source : sources_) {
    const std::lock_guard lock(source->mutex);
    all.push_back(source->report);
  }
  return all;
}

std::vector<DiagnosticItem> RosInputs::diagnostics() {
  std::vector<DiagnosticItem> items;
  for (const auto& r : report()) {
    DiagnosticItem item{r.sensor + " input"};
    judge(r, std::chrono::steady_clock::now() - connected_at_ < first_patience, item);
    item.values = {{"Topic", r.topic},
                   {"Type", r.type},
                   {"Messages", std::to_string(r.messages)},
                   {"Rejected", std::to_string(r.rejected)},
                   {"Dropped", std::to_string(r.dropped)},
                   {"Points not finite", std::to_string(r.points_dropped)},
                   {"Clouds without times", std::to_string(r.without_times)},
                   {"Intensities ignored", std::to_string(r.intensities_ignored)}};
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace lidard
