// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/sensor.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "daemon/config/output_topics.h"
#include "daemon/pipeline/pipeline.h"

namespace lidard {
namespace {

/// The watch of a sensor: a device that leaves scans out between two sends more seldom; another driver's
/// topic promises nothing.
ReceptionWatch watch_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return ReceptionWatch(0);
  const DriverConfig& driver = sensor.driver;
  if (sensor.model->kind == FrameKind::cloud && driver.frame_cut == FrameCut::time)
    return ReceptionWatch(seconds(driver.frame_duration), true);
  return ReceptionWatch(sensor.model->frame_period * (1 + driver.requests.skip.value_or(0)));
}

/// Takes the geometry and limits of `shape` and makes every beam `invalid`: a sweep that says nothing.
void set_unobserved(const PlanarScan& shape, PlanarScan& scan) {
  scan.reset(shape.beams, 1, false);
  scan.set_angles(shape.angle_min, shape.angle_increment);
  scan.range_min = shape.range_min;
  scan.range_max = shape.range_max;
}

}  // namespace

Sensor::Sensor(const SensorConfig& sensor, std::size_t place, const std::vector<OutputTopic>& topics,
               LineOwner& line_owner)
    : config(sensor), index(place), owner(line_owner), arranger(sensor.layout), watch(watch_of(sensor)) {
  if (config.model == nullptr) return;
  driver = config.model->make(config.driver);
  topic = &topic_named(topics, frame_topic(config).name);
  if (config.ring_scan) {
    ring_scan.emplace(*config.ring_scan);
    ring_topic = &topic_named(topics, config.scan_topic);
  }
  for (const OutputTopic& own : sensor_topics(config)) {
    const OutputTopic& entry = topic_named(topics, own.name);
    if (entry.kind == TopicKind::echoes) echoes_topic = &entry;
    if (!entry.promised) told_topics[std::string_view(entry.name).substr(config.name.size() + 1)] = &entry;
  }
}

void Sensor::scan(PlanarScan& scan) {
  notice_shape(scan);
  watch.scan(scan);
  owner.sink.scan(*topic, scan, owner.now);
  if (echoes_topic != nullptr) owner.sink.scan(*echoes_topic, scan, owner.now);
  owner.scan_from(*this, scan);
}

void Sensor::cloud(Cloud& cloud) {
  watch.cloud(cloud);
  owner.cloud_from(*this, cloud);
  if (ring_scan && ring_scan->convert(cloud, ring)) {
    owner.sink.scan(*ring_topic, ring, owner.now);
    owner.scan_from(*this, ring);
  }
  owner.sink.cloud(*topic, arranger.is_plain() ? cloud : arranger.arrange(cloud), owner.now);
}

void Sensor::message(const DeviceMessage& message) {
  const auto published = told_topics.find(topic_of(message));
  if (published != told_topics.end()) owner.sink.message(*published->second, message, owner.now);
}

void Sensor::extra_scan(std::string_view name, PlanarScan& scan) {
  owner.sink.scan(*told_topics.at(name), scan, owner.now);
}

void Sensor::request(ByteView bytes) {
  if (owner.links != nullptr) owner.links->send(index, bytes);
}

void Sensor::apply_connection_request() {
  const ConnectionRequest what = std::exchange(wish, ConnectionRequest::none);
  if (owner.links == nullptr || what == ConnectionRequest::none) return;
  if (what != ConnectionRequest::connect)
    return owner.links->disconnect(index, what == ConnectionRequest::connect_anew);
  const IpAddress address = config.ip_address.value_or(sender);
  if (address != IpAddress()) owner.links->connect(index, address);
}

/// What comes in a dialogue does not show that the data come, whether it has a connection of its own or the
/// one of the data.
void Sensor::receive(const Packet& packet, Stamp received) {
  const bool datagram = packet.transport == Transport::udp;
  if (datagram) sender = packet.from.address;
  const std::uint64_t data_packets = driver->counters().packets;
  driver->receive(packet, *this);
  if (packet.transport == config.model->transport) {
    if (driver->counters().packets != data_packets) {
      notice_data(received);
      if (datagram && !config.ip_address && config.packet_topic.empty()) watch.sender(sender);
    } else if (datagram) {
      last_telemetry = received;
    }
  }
  apply_connection_request();
}

bool Sensor::take_message(PlanarScan& scan, Stamp received) {
  notice_data(received);
  ++topic_counters.packets;
  if (scan.beams == 0) fill_empty(scan);
  if (violation(scan) != nullptr) {
    topic_counters.reject(Reject::field);
    return false;
  }
  ++topic_counters.frames;
  watch.scan(scan);
  scan.stamp = scan.stamp + config.driver.time_offset;
  place(scan.frame_id);
  notice_shape(scan);
  return true;
}

void Sensor::take_message(Cloud& cloud, Stamp received) {
  notice_data(received);
  ++topic_counters.packets;
  ++topic_counters.frames;
  watch.cloud(cloud);
  cloud.stamp = cloud.stamp + config.driver.time_offset;
  cloud.end = cloud.end + config.driver.time_offset;
  place(cloud.frame_id);
}

void Sensor::notice_data(Stamp received) {
  if (!seen) first_arrival = received;
  seen = true;
  last_arrival = received;
}

SensorReport Sensor::report() const {
  SensorReport report;
  report.name = config.name;
  report.model = driver ? std::string(config.model->name) : "topic";
  report.counters = counters();
  if (driver) report.info = driver->info();
  report.seen = seen;
  report.last_arrival = last_arrival;
  report.last_telemetry = last_telemetry;
  if (owner.links != nullptr) report.link_trouble = owner.links->trouble(index);
  report.recent = watch.recent();
  report.whole = watch.whole();
  report.rivals = watch.rivals();
  report.rivals_ever = watch.rivals_ever();
  return report;
}

void Sensor::fill_empty(PlanarScan& scan) const {
  if (shape.beams > 0) return set_unobserved(shape, scan);
  scan.reset(1, 1, false);
  scan.set_angles(0, 0);
  scan.range_min = 0;
  scan.range_max = 1;
}

void Sensor::notice_shape(const PlanarScan& scan) {
  if (scan.beams == shape.beams && scan.angle_min == shape.angle_min &&
      scan.angle_increment == shape.angle_increment)
    return;
  if (shape.beams != 0 && shape.beams != scan.beams)
    note("now has " + std::to_string(scan.beams) + " beams instead of " + std::to_string(shape.beams));
  set_unobserved(scan, shape);
}

void Sensor::note(std::string_view sentence) { spdlog::info("{}: {}", config.name, sentence); }

}  // namespace lidard
