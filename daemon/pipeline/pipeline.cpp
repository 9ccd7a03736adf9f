// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pipeline.h"

#include <algorithm>

namespace lidard {
namespace {

constexpr Span report_period = std::chrono::seconds(1);

}  // namespace

Pipeline::Pipeline(const Config& config, TransformSource& transforms, FrameSink& sink)
    : vehicle_(config.vehicle),
      frames_(config.vehicle.base_frame, fixed_poses(config), transforms),
      motion_(vehicle_, transforms, frames_),
      router_(sink) {
  configure(config);
}

void Pipeline::configure(const Config& config) {
  List<Sensor> sensors = std::exchange(sensors_, {});
  List<Maker> makers = std::exchange(makers_, {});
  // What a maker shows depends on the vehicle's outline too.
  const bool is_other_vehicle = !(vehicle_ == config.vehicle);
  if (is_other_vehicle) makers.clear();
  vehicle_ = config.vehicle;
  frames_.configure(config.vehicle.base_frame, fixed_poses(config));
  if (is_other_vehicle) motion_.restart();  // poses in another frame do not continue those before
  router_.configure(config);
  flows_ = {};
  tcp_ports_.clear();
  for (std::size_t index = 0; index < config.sensors.size(); ++index)
    add_sensor(config.sensors[index], index, sensors);
  for (const auto& entry : config.merged_scans) add_maker(entry, makers);
  for (const auto& entry : config.merged_clouds) add_maker(entry, makers);
  for (const auto& entry : config.virtual_scans) add_maker(entry, makers);
  next_event_after_.reset();
  report_wanted_ = true;
}

void Pipeline::add_sensor(const SensorConfig& entry, std::size_t index, List<Sensor>& before) {
  const auto same = std::find_if(before.begin(), before.end(),
                                 [&](const auto& one) { return one && one->config() == entry; });
  const bool is_new = same == before.end();
  sensors_.push_back(is_new ? std::make_unique<Sensor>(entry, index, context_) : std::move(*same));
  if (is_new) sensors_.back()->begun = context_.now;
  sensors_.back()->set_index(index);
  for (const Flow& flow : flows_of(entry)) flows_.add(flow, sensors_.back().get());
  if (entry.model != nullptr && entry.model->transport == Transport::tcp) tcp_ports_.insert(entry.ip_port);
}

template <class Entry>
void Pipeline::add_maker(const Entry& entry, List<Maker>& before) {
  const auto same =
      std::find_if(before.begin(), before.end(), [&](const auto& one) { return one && one->is_of(entry); });
  const bool is_new = same == before.end();
  makers_.push_back(is_new ? make_maker(entry, context_) : std::move(*same));
  if (is_new) makers_.back()->begun = context_.now;
  router_.connect(*makers_.back(), makers_.back()->sources);
}

/// The sensor that a packet belongs to; nullptr: no sensor, or a packet without use.
Sensor* Pipeline::owner_of(const Packet& packet) {
  if (Sensor* const* owner = flows_.find(packet)) {
    const SensorConfig& config = (*owner)->config();
    if (config.ip_address || packet.to.port != config.telemetry_port) return *owner;
    // Sensors without ip_address may share a telemetry port: it is whose data come from the same sender.
    const auto sends = [&](const auto& sensor) { return sensor->sends_telemetry(packet); };
    const auto sender = std::find_if(sensors_.begin(), sensors_.end(), sends);
    return sender != sensors_.end() ? sender->get() : *owner;
  }
  // What is sent to a device is of no interest.
  const bool to_device = packet.transport == Transport::tcp && flows_.find_receiver(packet) != nullptr;
  const bool port_is_ours = packet.transport == Transport::udp || tcp_ports_.count(packet.from.port) > 0;
  if (port_is_ours && !to_device) unknown_senders_.note(packet);
  return nullptr;
}

Stamp Pipeline::time_of(const Packet& packet) const {
  constexpr Span one_time = std::chrono::seconds(2);
  const bool lacks_time = made_time_ && std::chrono::abs(packet.arrival - made_time_->arrival) < one_time;
  return lacks_time ? made_time_->now : packet.arrival;
}

void Pipeline::packet(const Packet& packet) {
  const Stamp now = time_of(packet);
  made_ahead_ = now - packet.arrival;
  advance(now);
  Sensor* const sensor = owner_of(packet);
  if (sensor == nullptr) return;
  if (packet.transport == Transport::tcp)
    sensor->receive_recorded(packet, now);
  else
    sensor->receive(packet, now);
  if (const auto newest = sensor->made_time()) made_time_ = MadeTime{packet.arrival, std::max(*newest, now)};
}

void Pipeline::chunk(std::size_t sensor, const Packet& packet) {
  advance(packet.arrival);
  sensors_.at(sensor)->receive(packet, packet.arrival);
}

void Pipeline::connected(std::size_t sensor, Stamp now) {
  context_.now = now;
  sensors_.at(sensor)->connected(now);
}

void Pipeline::forwarded_scan(const std::string& source, const PlanarScan& scan, Stamp received) {
  Route* const route = router_.find_source(source);
  if (route == nullptr) return;  // a reload has removed it
  advance(received);
  motion_.poll(received);
  motion_.note_data(scan.stamp, received);
  route->deliver(scan, received);
}

/// nullptr: a reload has removed it, or given it another kind of input.
Sensor* Pipeline::find_sensor(const std::string& name, bool with_driver) const {
  for (const auto& sensor : sensors_) {
    if (sensor->config().name == name && sensor->has_driver() == with_driver) return sensor.get();
  }
  return nullptr;
}

void Pipeline::packet_message(const std::string& name, const Packet& packet, Stamp received) {
  advance(received);
  if (Sensor* const sensor = find_sensor(name, true)) sensor->receive_message(packet, received);
}

void Pipeline::scan_message(const std::string& name, PlanarScan& scan, Stamp received) {
  advance(received);
  if (Sensor* const sensor = find_sensor(name, false)) sensor->receive(scan, received);
}

void Pipeline::cloud_message(const std::string& name, Cloud& cloud, Stamp received) {
  advance(received);
  if (Sensor* const sensor = find_sensor(name, false)) sensor->receive(cloud, received);
}

void Pipeline::pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) {
  if (!vehicle_.has_motion()) return;
  advance(received);
  motion_.add_pose(motion_.stamp_of(stamp, received + context_.messages_ahead), pose, child, received);
  advance_to(received);
}

void Pipeline::turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                            Stamp received) {
  if (!vehicle_.has_motion()) return;
  advance(received);
  motion_.add_turn(motion_.stamp_of(stamp, received + context_.messages_ahead), rates, frame, received);
  advance_to(received);
}

std::string Pipeline::set_scan(const MakerId& maker, const OutputScanConfig& wanted) {
  if (const auto grid = make_grid(wanted.grid); !grid) return grid.reason();
  for (const auto& one : makers_) {
    if (!(one->id == maker)) continue;
    one->set_scan(wanted);
    next_event_after_.reset();
    return {};
  }
  return "there is no output named " + maker.entry;
}

std::string Pipeline::set_sensor(const SensorConfig& wanted) {
  for (const auto& sensor : sensors_) {
    if (sensor->config().name != wanted.name) continue;
    sensor->change(wanted);
    return {};
  }
  return "there is no sensor named " + wanted.name;
}

/// Publishes what is due at `at`.
void Pipeline::advance_to(Stamp at) {
  context_.now = at;
  motion_.poll(at);
  for (const auto& maker : makers_) {
    maker->advance(at);
    report_wanted_ = maker->states_changed(at) || report_wanted_;
  }
  next_event_after_.reset();
}

std::optional<Stamp> Pipeline::next_event() {
  if (next_event_after_ == router_.delivered()) return next_event_;
  next_event_.reset();
  const auto consider = [this](const auto& all) {
    for (const auto& one : all) {
      const auto event = one->next_event();
      if (event && (!next_event_ || *event < *next_event_)) next_event_ = event;
    }
  };
  consider(sensors_);
  consider(makers_);
  next_event_after_ = router_.delivered();
  return next_event_;
}

void Pipeline::advance(Stamp now) {
  // Time may jump. Packets that waited while this thread stood bring their time with them.
  if (start_.step(now)) {
    for (const auto& sensor : sensors_) sensor->clock_jumped(now);
  }
  auto event = next_event();
  if (event && *event <= now) {
    for (const auto& sensor : sensors_) sensor->advance(now);
    next_event_after_.reset();
  }
  // After a long pause, outputs of the past are not published.
  constexpr Span longest_pause = std::chrono::seconds(1);
  const Stamp newest_past = now - longest_pause;
  constexpr int most_rounds = 10'000;  // far more than outputs publish in that time
  event = next_event();
  for (int round = 0; event && *event <= now && round < most_rounds; ++round, event = next_event()) {
    const Stamp at = std::max(*event, newest_past);
    advance_to(at);
    if (report_wanted_) call_reporter(at);
  }
  context_.now = now;
}

void Pipeline::tick(Stamp now) {
  // What arrived after the caller looked at its clock is known already.
  const Stamp known = context_.now;
  if (now < known && known - now < report_period) now = known;
  for (const auto& sensor : sensors_) sensor->advance(now);
  advance(now);
  advance_to(now);
  for (const auto& sensor : sensors_) {
    sensor->tick(now - made_ahead_);
    report_wanted_ = sensor->silence_changed(now) || report_wanted_;
  }
  const Span since = now - last_report_;
  if (report_wanted_ || since < Span(0) || since >= report_period) call_reporter(now);
}

void Pipeline::finish(Stamp now) {
  context_.now = now;
  for (const auto& sensor : sensors_) sensor->finish();
}

void Pipeline::restart() {
  for (const auto& sensor : sensors_) sensor->restart();
  for (const auto& maker : makers_) maker->restart();
  motion_.restart();
  made_time_.reset();
  next_event_after_.reset();
}

PipelineStatus Pipeline::status(Stamp now) const {
  PipelineStatus status;
  status.now = now;
  for (const auto& sensor : sensors_) {
    status.sensors.push_back(sensor->status());
    status.sensors.back().starting = start_.is_starting(now, sensor->begun);
  }
  status.motion = motion_.status(context_.now);
  for (const auto& maker : makers_) {
    status.makers.push_back(maker->status(now));
    status.makers.back().starting = start_.is_starting(now, maker->begun);
  }
  status.unknown_senders = &unknown_senders_;
  return status;
}

void Pipeline::call_reporter(Stamp now) {
  report_wanted_ = false;
  last_report_ = now;
  reporter_(now);
}

}  // namespace lidard
