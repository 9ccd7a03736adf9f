// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/sensor.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "daemon/log/log.h"

namespace lidard {
namespace {

/// The watch of a sensor: skipped scans lengthen the period; the period of another driver's topic is unknown.
ReceptionWatch watch_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return ReceptionWatch(0);
  return ReceptionWatch(sensor.model->frame_period * (1 + sensor.driver.requests.skip.value_or(0)));
}

/// Datagrams of two devices alternate many times a second, connections to them perhaps once in minutes.
Alternation watch_for_two(const SensorConfig& sensor) {
  if (sensor.model != nullptr && sensor.model->transport == Transport::udp)
    return Alternation(8, std::chrono::seconds(10));
  return Alternation();
}

/// Takes the geometry and limits of `shape` and makes every beam `invalid`: a sweep that says nothing.
void set_unobserved(const PlanarScan& shape, PlanarScan& scan) {
  scan.reset(shape.beams, 1, false);
  scan.set_angles(shape.angle_min, shape.angle_increment);
  scan.range_min = shape.range_min;
  scan.range_max = shape.range_max;
}

}  // namespace

Sensor::Sensor(const SensorConfig& config, std::size_t index, const PipelineContext& context)
    : config_(config),
      index_(index),
      context_(context),
      route_(context.router.source(config.name)),
      arranger_(config.layout),
      watch_(watch_of(config)),
      other_model_(config.model),
      devices_(watch_for_two(config)) {
  if (config.model == nullptr) return;
  driver_ = config.model->make(config.driver);
  if (config.filter.any()) filter_.emplace(config.filter), ring_filter_.emplace(config.filter);
  if (config.ring_scan) ring_scan_.emplace(*config.ring_scan);
  for (const OutputTopic& topic : sensor_topics(config_)) {
    Route& route = context.router.topic(topic.name);
    if (!topic.from.empty()) {
      device_topics_.emplace_back(topic.from, &route);
      continue;
    }
    switch (topic.kind) {
      case TopicKind::scan:
      case TopicKind::cloud:
        (topic_ == nullptr ? topic_ : ring_topic_) = &route;
        break;
      case TopicKind::echoes:
      case TopicKind::extended_scan:
        more_scan_topics_.push_back(&route);
        break;
      case TopicKind::message:
      case TopicKind::output_paths:
      case TopicKind::merged_cloud:
        throw std::logic_error("no sensor has what travels on " + topic.name);
    }
  }
  if (CloudPlacer::is_wanted(config)) placer_.emplace(config_, arranger_, context, *topic_);
}

void Sensor::change(const SensorConfig& wanted) {
  config_ = wanted;
  driver_->change(wanted.driver);
  arranger_ = CloudArranger(wanted.layout);
  if (ring_scan_ && wanted.ring_scan)
    ring_scan_->set_ranges(wanted.ring_scan->range_min, wanted.ring_scan->range_max);
}

/// Answers of a dialogue do not prove that measurement data arrive, on whichever connection they come.
void Sensor::receive(const Packet& packet, Stamp received) {
  watch_.advance(received, counters());
  const bool datagram = packet.transport == Transport::udp;
  if (datagram && std::exchange(sender_, packet.from.address) != packet.from.address)
    devices_ = watch_for_two(config_);
  const Verdict verdict = driver_->receive(packet, *this);
  if (verdict.reject != Reject::none && datagram) other_model_.refused(packet, verdict.reject);
  if (datagram) devices_.observe(verdict.device, received);
  if (packet.transport == config_.model->transport) {
    if (verdict.has_data) {
      data_sender_ = packet.from.address;
      notice_data(received);
      if (datagram && !config_.ip_address && config_.packet_topic.empty()) watch_.sender(sender_);
    } else if (datagram) {
      last_telemetry_ = received;
    }
  }
  apply_connection_request();
}

Span Sensor::correction_of(Stamp stamp, Span lasts, Stamp received) {
  const Stamp wanted = stamp + config_.driver.time_offset;
  return topic_clock_.correct(wanted, lasts, received + context_.messages_ahead) - stamp;
}

void Sensor::receive_message(Packet packet, Stamp received) {
  const Span correction = correction_of(packet.arrival, Span(0), received);
  packet.arrival = packet.arrival + correction - config_.driver.time_offset;  // which the driver adds
  receive(packet, received);
}

void Sensor::receive_recorded(Packet chunk, Stamp received) {
  if (connection_.pick(chunk)) receive(chunk, received);
}

std::optional<Stamp> Sensor::made_time() const {
  const DeviceClock* const clock = driver_ ? driver_->clock() : nullptr;
  if (clock == nullptr || !clock->lacks_now()) return std::nullopt;
  return clock->newest();
}

void Sensor::scan(PlanarScan& scan) {
  notice_shape(scan);
  watch_.scan(scan);
  publish_scan(*topic_, filter_, scan);
}

void Sensor::publish_scan(Route& topic, std::optional<FrameFilter>& filter, PlanarScan& scan) {
  if (filter) {
    deliver(scan, scan.stamp);
    filter->apply(scan);
  }
  const PlanarScan& published = in_order(scan);
  topic.deliver(published, context_.now);
  for (Route* more : more_scan_topics_) more->deliver(published, context_.now);
  if (!filter) deliver(scan, scan.stamp);
}

PlanarScan& Sensor::in_order(PlanarScan& scan) {
  if (!config_.counter_clockwise || !(scan.angle_increment < 0)) return scan;
  (reversed_ = scan).reverse();
  return reversed_;
}

bool Sensor::wants_cloud() {
  cloud_wanted_ = ring_scan_ || route_.is_wanted() || topic_->is_wanted();
  return *cloud_wanted_;
}

void Sensor::cloud(Cloud& cloud) {
  watch_.cloud(cloud);
  const bool has_points = cloud_wanted_ ? *cloud_wanted_ : wants_cloud();
  cloud_wanted_.reset();
  deliver({cloud, has_points}, cloud.stamp);
  if (has_points && ring_scan_ && ring_scan_->convert(cloud, ring_))
    publish_scan(*ring_topic_, ring_filter_, ring_);
  if (!has_points || !topic_->is_wanted()) return topic_->deliver({cloud, false}, context_.now);
  if (filter_) filter_->apply(cloud);
  // The sinks come last, since they may keep the points.
  if (placer_)
    placer_->add(cloud, context_.now);
  else
    topic_->deliver(arranger_.message_of(cloud), context_.now);
}

void Sensor::deliver(const Frame& frame, Stamp stamp) {
  context_.motion.poll(context_.now);
  context_.motion.note_data(stamp, context_.now);
  route_.deliver(frame, context_.now);
}

void Sensor::publish_from_device(std::string_view name, const Frame& frame) {
  for (const auto& [own, topic] : device_topics_) {
    if (own == name) topic->deliver(frame, context_.now);
  }
}

void Sensor::message(const DeviceMessage& message) { publish_from_device(topic_of(message), message); }

void Sensor::extra_scan(std::string_view name, PlanarScan& scan) { publish_from_device(name, scan); }

void Sensor::note(std::string_view sentence) { log_info("{}: {}", config_.name, sentence); }

void Sensor::request(ByteView bytes) {
  if (context_.connections != nullptr) context_.connections->send(index_, bytes);
}

Stamp Sensor::leaves(Stamp arrival) {
  return context_.connections != nullptr ? std::max(arrival, context_.connections->now()) : arrival;
}

void Sensor::apply_connection_request() {
  const ConnectionRequest what = std::exchange(request_, ConnectionRequest::none);
  DeviceConnections* const connections = context_.connections;
  if (connections == nullptr || what == ConnectionRequest::none) return;
  if (what != ConnectionRequest::connect)
    return connections->disconnect(index_, what == ConnectionRequest::connect_anew);
  const IpAddress address = config_.ip_address.value_or(sender_);
  if (address != IpAddress()) connections->connect(index_, address);
}

void Sensor::connected(Stamp now) {
  driver_->connected(now, *this);
  apply_connection_request();
}

void Sensor::receive(PlanarScan& scan, Stamp received) {
  watch_.advance(received, counters());
  notice_data(received);
  ++topic_counters_.packets;
  if (scan.beams == 0) fill_empty(scan);
  if (violation(scan) != nullptr) return topic_counters_.reject(Reject::field);
  ++topic_counters_.frames;
  watch_.scan(scan);
  const Span lasts = has_usable_times(scan) ? times_of(scan).last() - scan.stamp : Span(0);
  scan.stamp = scan.stamp + correction_of(scan.stamp, lasts, received);
  // The configured pose counts whatever frame the message names.
  if (config_.pose) scan.frame_id = config_.frame_id;
  notice_shape(scan);
  deliver(scan, scan.stamp);
}

void Sensor::receive(Cloud& cloud, Stamp received) {
  watch_.advance(received, counters());
  notice_data(received);
  ++topic_counters_.packets;
  ++topic_counters_.frames;
  watch_.cloud(cloud);
  const Span correction = correction_of(cloud.stamp, std::max(Span(0), cloud.end - cloud.stamp), received);
  cloud.stamp = cloud.stamp + correction;
  cloud.end = cloud.end + correction;
  if (config_.pose) cloud.frame_id = config_.frame_id;
  deliver(cloud, cloud.stamp);
}

void Sensor::notice_data(Stamp received) {
  seen_ = true;
  last_arrival_ = received;
}

void Sensor::advance(Stamp now) {
  watch_.advance(now, counters());
  if (placer_) placer_->advance(now);
}

void Sensor::clock_jumped(Stamp now) {
  // An arrival in the future counts as now.
  last_arrival_ = std::min(last_arrival_, now);
  if (last_telemetry_) last_telemetry_ = std::min(*last_telemetry_, now);
}

void Sensor::tick(Stamp by_arrivals) {
  if (driver_ == nullptr) return;
  driver_->tick(by_arrivals, *this);
  if (config_.model->transport == Transport::tcp) devices_.observe(driver_->info().serial, by_arrivals);
  apply_connection_request();
}

bool Sensor::silence_changed(Stamp now) {
  const SilenceLevel is = seen_ ? silence_of(last_arrival_, watch_.period_s(), now) : SilenceLevel::none;
  return std::exchange(silence_, is) != is;
}

void Sensor::finish() {
  if (driver_ != nullptr) driver_->finish(*this);
  if (placer_) placer_->finish(context_.now);
}

void Sensor::restart() {
  if (driver_ != nullptr) driver_->restart();
  connection_.restart();
  watch_.restart();
}

SensorStatus Sensor::status() const {
  SensorStatus status;
  status.name = config_.name;
  status.config = &config_;
  status.model = driver_ ? std::string(config_.model->name) : "topic";
  status.counters = counters();
  if (driver_ && !config_.packet_topic.empty())
    status.info = info_of(*driver_, "topic " + config_.packet_topic);
  else if (driver_)
    // The kernel stamps live packets; of those that waited while the daemon was stopped many have one stamp.
    status.info = context_.connections != nullptr ? driver_->info() : info_of(*driver_);
  if (filter_) status.filters.push_back({topic_->name(), filter_->counters()});
  if (filter_ && ring_topic_ != nullptr)
    status.filters.push_back({ring_topic_->name(), ring_filter_->counters()});
  if (placer_) status.gate = placer_->gate();
  status.seen = seen_;
  status.last_arrival = last_arrival_;
  status.last_telemetry = last_telemetry_;
  const bool silent =
      !seen_ || silence_of(last_arrival_, watch_.period_s(), context_.now) != SilenceLevel::none;
  if (context_.connections != nullptr && silent) status.connection = context_.connections->status(index_);
  status.other_models = other_model_.models();
  status.clock_ahead = topic_clock_.ahead();
  status.stamps_replaced = topic_clock_.replaced();
  status.address = config_.ip_address.value_or(data_sender_);
  if (driver_) status.rivals = devices_.both(context_.now);
  status.recent = watch_.recent();
  status.whole = watch_.whole();
  return status;
}

void Sensor::fill_empty(PlanarScan& scan) const {
  if (shape_.beams > 0) return set_unobserved(shape_, scan);
  scan.reset(1, 1, false);
  scan.set_angles(0, 0);
  scan.range_min = 0;
  scan.range_max = 1;
}

void Sensor::notice_shape(const PlanarScan& scan) {
  if (scan.beams == shape_.beams && scan.angle_min == shape_.angle_min &&
      scan.angle_increment == shape_.angle_increment)
    return;
  // Of some topics each scan has another number of beams.
  constexpr Span between_notes = std::chrono::seconds(10);
  if (shape_.beams != 0 && shape_.beams != scan.beams && context_.now - shape_noted_ > between_notes) {
    shape_noted_ = context_.now;
    note("now has " + std::to_string(scan.beams) + " beams instead of " + std::to_string(shape_.beams));
  }
  set_unobserved(scan, shape_);
}

}  // namespace lidard
