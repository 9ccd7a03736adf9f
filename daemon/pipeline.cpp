// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline.h"

#include <map>
#include <utility>

#include "daemon/merged_output.h"
#include "daemon/sensor_health.h"
#include "daemon/sensor_line.h"
#include "daemon/virtual_output.h"

namespace lidard {
namespace {

/// So many unknown senders are remembered by name; a flood of forged ones must not grow memory.
constexpr std::size_t max_strangers = 32;
constexpr Span diagnostics_period = std::chrono::seconds(1);

}  // namespace

struct Pipeline::Impl final : public LineOwner {
  Impl(const Config& configuration, PoseLookup& lookup, FrameSink& frame_sink)
      : LineOwner(frame_sink), poses(configuration, lookup) {
    for (const auto& sensor : configuration.sensors) {
      lines.push_back(std::make_unique<SensorLine>(sensor, lines.size(), *this));
    }
    for (const auto& entry : configuration.merged_scans) {
      merged.push_back(std::make_unique<MergedOutput>(entry, configuration.vehicle, poses));
    }
    for (const auto& entry : configuration.virtual_scans) {
      virtuals.push_back(std::make_unique<VirtualOutput>(entry, configuration.vehicle, poses));
    }
  }

  SensorLine* find_line(const Packet& packet);
  void chunk(Packet packet);
  SensorLine& line_named(const std::string& name);
  void scan_from(const SensorLine& line, const PlanarScan& scan) override;
  void cloud_from(const SensorLine& line, const Cloud& cloud) override;
  void note_stranger(const Packet& packet);

  PoseBook poses;
  std::vector<std::unique_ptr<SensorLine>> lines;
  std::vector<std::unique_ptr<MergedOutput>> merged;
  std::vector<std::unique_ptr<VirtualOutput>> virtuals;
  /// Sender's address with the destination port, or with its own where it was a connection.
  std::map<std::pair<Transport, Endpoint>, std::uint64_t> strangers;
  std::uint64_t strangers_not_named = 0;
  Stamp last_diagnostics{};
  std::function<void(std::vector<DiagnosticItem>&)> more_diagnostics;
};

std::vector<TopicInfo> pipeline_topics(const Config& config) {
  std::vector<TopicInfo> topics;
  for (const auto& sensor : config.sensors) {
    for (auto& topic : sensor_topics(sensor)) topics.push_back(std::move(topic));
  }
  for (const auto& merged : config.merged_scans) {
    topics.push_back({merged.scan_destination_topic, TopicKind::scan});
    for (const auto& also : merged.also) topics.push_back({also.topic, TopicKind::scan});
    if (!merged.cloud_destination_topic.empty())
      topics.push_back({merged.cloud_destination_topic, TopicKind::cloud});
  }
  for (const auto& group : config.virtual_scans) {
    if (!group.output_laser_topic.empty()) {
      topics.push_back({group.output_laser_topic, TopicKind::scan});
      continue;
    }
    for (const auto& frame : group.virtual_laser_scan) topics.push_back({frame, TopicKind::scan});
  }
  return topics;
}

SensorLine* Pipeline::Impl::find_line(const Packet& packet) {
  SensorLine* anybody = nullptr;
  for (const auto& line : lines) {
    if (!line->owns_port(packet.to.port)) continue;
    if (!line->config.ip_address) {
      anybody = line.get();
    } else if (*line->config.ip_address == packet.from.address) {
      return line.get();
    }
  }
  return anybody;
}

/// A chunk of a connection in a capture; what was sent to a device is not of interest.
void Pipeline::Impl::chunk(Packet packet) {
  bool known_port = false;
  for (const auto& line : lines) {
    const Endpoint device = line->device();
    if (device.port == 0) continue;
    if (packet.to == device) return;
    if (packet.from == device) {
      if (line->connection.pick(packet)) line->receive(packet, packet.arrival);
      return;
    }
    known_port = known_port || (line->config.model->transport == Transport::tcp &&
                                line->config.ip_port == packet.from.port);
  }
  if (known_port) note_stranger(packet);
}

SensorLine& Pipeline::Impl::line_named(const std::string& name) {
  for (const auto& line : lines) {
    if (line->config.name == name) return *line;
  }
  throw std::logic_error("no sensor named " + name);
}

void Pipeline::Impl::scan_from(const SensorLine& line, const PlanarScan& scan) {
  for (const auto& output : merged) {
    const int source = output->source_index(line.config.name);
    if (source >= 0) output->add(static_cast<std::size_t>(source), scan, now, sink);
  }
}

void Pipeline::Impl::cloud_from(const SensorLine& line, const Cloud& cloud) {
  for (const auto& output : virtuals) {
    if (output->cloud_sensor() == line.config.name) output->add(cloud, now, sink);
  }
}

void Pipeline::Impl::note_stranger(const Packet& packet) {
  const bool datagram = packet.transport == Transport::udp;
  const std::pair key(packet.transport,
                      Endpoint{packet.from.address, datagram ? packet.to.port : packet.from.port});
  const auto entry = strangers.find(key);
  if (entry != strangers.end()) {
    ++entry->second;
  } else if (strangers.size() < max_strangers) {
    strangers.emplace(key, 1);
  } else {
    ++strangers_not_named;
  }
}

Pipeline::Pipeline(const Config& config, PoseLookup& poses, FrameSink& sink)
    : impl_(std::make_unique<Impl>(config, poses, sink)) {}
Pipeline::~Pipeline() = default;

std::vector<StaticTransform> Pipeline::static_transforms() const { return impl_->poses.transforms(); }

void Pipeline::packet(const Packet& packet) {
  impl_->now = packet.arrival;
  if (packet.transport == Transport::tcp) return impl_->chunk(packet);
  SensorLine* line = impl_->find_line(packet);
  if (line == nullptr) {
    impl_->note_stranger(packet);
    return;
  }
  line->receive(packet, packet.arrival);
}

void Pipeline::set_links(DeviceLinks* links) { impl_->links = links; }

void Pipeline::chunk(std::size_t sensor, const Packet& packet) {
  impl_->now = packet.arrival;
  impl_->lines.at(sensor)->receive(packet, packet.arrival);
}

void Pipeline::connected(std::size_t sensor, Stamp now) {
  impl_->now = now;
  SensorLine& line = *impl_->lines.at(sensor);
  line.driver->connected(now, line);
  line.settle();
}

void Pipeline::disconnected(std::size_t sensor) { impl_->lines.at(sensor)->driver->disconnected(); }

std::uint64_t Pipeline::frames(std::size_t sensor) const {
  return impl_->lines.at(sensor)->driver->counters().frames;
}

void Pipeline::packet_message(const std::string& sensor, const Packet& packet, Stamp received) {
  impl_->now = received;
  impl_->line_named(sensor).receive(packet, received);
}

void Pipeline::scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) {
  impl_->now = received;
  SensorLine& line = impl_->line_named(sensor);
  line.seen = true;
  line.last_arrival = received;
  ++line.topic_counters.packets;
  if (violation(scan) != nullptr) {
    line.topic_counters.reject(Reject::field);
    return;
  }
  ++line.topic_counters.frames;
  impl_->scan_from(line, scan);
}

void Pipeline::cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) {
  impl_->now = received;
  SensorLine& line = impl_->line_named(sensor);
  line.seen = true;
  line.last_arrival = received;
  ++line.topic_counters.packets;
  ++line.topic_counters.frames;
  impl_->cloud_from(line, cloud);
}

void Pipeline::tick(Stamp now) {
  impl_->now = now;
  for (const auto& line : impl_->lines) {
    if (line->driver == nullptr) continue;
    line->driver->tick(now, *line);
    line->settle();
  }
  const Span since = now - impl_->last_diagnostics;
  if (since >= Span(0) && since < diagnostics_period) return;
  impl_->last_diagnostics = now;
  impl_->sink.diagnostics(diagnostics(now), now);
}

void Pipeline::finish(Stamp now) {
  impl_->now = now;
  for (const auto& line : impl_->lines) {
    if (line->driver) line->driver->finish(*line);
  }
}

void Pipeline::restart() {
  for (const auto& line : impl_->lines) {
    if (line->driver) line->driver->restart();
    line->connection.restart();
  }
  for (const auto& output : impl_->merged) output->restart();
}

std::vector<SensorReport> Pipeline::report() const {
  std::vector<SensorReport> reports;
  for (const auto& line : impl_->lines) {
    SensorReport report;
    report.name = line->config.name;
    report.model = line->driver ? std::string(line->config.model->name) : "topic";
    report.counters = line->driver ? line->driver->counters() : line->topic_counters;
    if (line->driver) report.info = line->driver->info();
    report.seen = line->seen;
    report.last_arrival = line->last_arrival;
    if (impl_->links != nullptr) report.link_trouble = impl_->links->trouble(line->index);
    report.last_telemetry = line->last_telemetry;
    reports.push_back(std::move(report));
  }
  return reports;
}

std::vector<std::string> Pipeline::unclaimed_senders() const {
  std::vector<std::string> senders;
  for (const auto& [key, count] : impl_->strangers) {
    const auto& [transport, sender] = key;
    const std::string which = transport == Transport::udp
                                  ? sender.address.to_string() + " -> port " + std::to_string(sender.port)
                                  : sender.to_string() + " over TCP";
    senders.push_back(which + " (" + std::to_string(count) + " packets)");
  }
  if (impl_->strangers_not_named > 0) {
    senders.push_back("further senders (" + std::to_string(impl_->strangers_not_named) + " packets)");
  }
  return senders;
}

std::vector<DiagnosticItem> Pipeline::diagnostics(Stamp now) const {
  std::vector<DiagnosticItem> items;
  const auto reports = report();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    items.push_back(sensor_health(impl_->lines[i]->config, reports[i], unclaimed_senders(), now));
  }
  for (const auto& output : impl_->merged) items.push_back(output->diagnostics(now));
  for (const auto& output : impl_->virtuals) items.push_back(output->diagnostics(now));
  if (const auto strangers = unclaimed_senders(); !strangers.empty())
    items.push_back(unknown_senders_item(strangers));
  if (impl_->more_diagnostics) impl_->more_diagnostics(items);
  return items;
}

void Pipeline::add_diagnostics(std::function<void(std::vector<DiagnosticItem>&)> source) {
  impl_->more_diagnostics = std::move(source);
}

}  // namespace lidard
