// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pipeline.h"

#include <algorithm>
#include <set>

#include "daemon/pipeline/merged_output.h"
#include "daemon/pipeline/sensor.h"
#include "daemon/pipeline/sensor_flows.h"
#include "daemon/pipeline/sensor_health.h"
#include "daemon/pipeline/start_watch.h"
#include "daemon/pipeline/virtual_output.h"

namespace lidard {
namespace {

constexpr Span diagnostics_period = std::chrono::seconds(1);

}  // namespace

/// The stages in order: whose packet it is (flows), the sensors with their drivers, what is made of their
/// frames (outputs), and the way on (outlet), which ends in the sinks.
struct Pipeline::Impl {
  Impl(const Config& config, TransformSource& transforms, std::vector<FrameSink*> sinks);

  Sensor* owner_of(const Packet& packet);
  Sensor& sensor_named(const std::string& name);
  std::size_t source_named(const std::string& name) const;
  void add_output(std::unique_ptr<Output> output);

  template <class Input>
  void take(Stamp at, Input input);
  void advance(Stamp now);
  void step_to(Stamp at);
  void advance_to(Stamp at);
  std::optional<Stamp> next_event() const;

  std::vector<DiagnosticItem> diagnostics(Stamp now) const;
  void publish_diagnostics(Stamp now);
  std::string why_silent(const std::string& source) const;

  const VehicleConfig vehicle;
  FrameTree frames;
  VehicleMotion motion;
  FlowTable<Sensor*> flows;
  std::set<std::uint16_t> tcp_ports;  // of devices that stream over TCP
  UnknownSenders unknown_senders;
  std::vector<std::unique_ptr<Sensor>> sensors;
  std::vector<std::unique_ptr<Output>> outputs;
  Outlet outlet;
  SensorContext sensor_context{outlet, motion};
  OutputContext output_context{vehicle, frames, outlet};
  StartWatch start;
  Stamp last_diagnostics{};
  bool diagnostics_wanted = false;  // a source has come or gone
  std::function<void(std::vector<DiagnosticItem>&)> more_diagnostics;
};

Pipeline::Impl::Impl(const Config& config, TransformSource& transforms, std::vector<FrameSink*> sinks)
    : vehicle(config.vehicle),
      frames(config, transforms),
      motion(vehicle, transforms, frames),
      outlet(output_topics(config), std::move(sinks), config.sensors.size()) {
  for (const SensorConfig& entry : config.sensors) {
    sensors.push_back(std::make_unique<Sensor>(entry, sensors.size(), sensor_context));
    for (const Flow& flow : flows_of(entry)) flows.add(flow, sensors.back().get());
    if (entry.model != nullptr && entry.model->transport == Transport::tcp) tcp_ports.insert(entry.ip_port);
  }
  for (const auto& entry : config.merged_scans)
    add_output(std::make_unique<MergedOutput>(entry, output_context));
  for (const auto& entry : config.virtual_scans)
    add_output(std::make_unique<VirtualOutput>(entry, output_context));
}

void Pipeline::Impl::add_output(std::unique_ptr<Output> output) {
  std::size_t place = 0;
  for (const std::string& name : output->sources()) outlet.connect(source_named(name), *output, place++);
  outputs.push_back(std::move(output));
}

/// A sensor, or a virtual scan by its topic.
std::size_t Pipeline::Impl::source_named(const std::string& name) const {
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (sensors[i]->config().name == name) return i;
  }
  return outlet.source_of(topic_named(outlet.topics(), name));
}

Sensor& Pipeline::Impl::sensor_named(const std::string& name) {
  const std::size_t place = source_named(name);
  return *sensors.at(place);
}

/// nullptr: nobody's, or of no interest.
Sensor* Pipeline::Impl::owner_of(const Packet& packet) {
  if (Sensor* const* owner = flows.find(packet)) return *owner;
  // What is sent to a device is of no interest.
  const bool to_device = packet.transport == Transport::tcp && flows.find_receiver(packet) != nullptr;
  const bool port_is_ours = packet.transport == Transport::udp || tcp_ports.count(packet.from.port) > 0;
  if (port_is_ours && !to_device) unknown_senders.note(packet);
  return nullptr;
}

/// What is due before the input comes first.
template <class Input>
void Pipeline::Impl::take(Stamp at, Input input) {
  advance(at);
  sensor_context.now = at;
  input();
}

/// Time passes, perhaps by a jump. Packets that waited while we stood bring their time with them.
void Pipeline::Impl::step_to(Stamp at) {
  const bool jumped = start.step(at);
  for (const auto& sensor : sensors) sensor->advance(at, jumped);
}

/// Publishes what is due at `at`.
void Pipeline::Impl::advance_to(Stamp at) {
  sensor_context.now = at;
  motion.poll(at);
  for (const auto& output : outputs) {
    output->advance(at);
    diagnostics_wanted = output->states_changed(at) || diagnostics_wanted;
  }
}

std::optional<Stamp> Pipeline::Impl::next_event() const {
  std::optional<Stamp> next;
  for (const auto& output : outputs) {
    const auto event = output->next_event();
    if (event && (!next || *event < *next)) next = event;
  }
  return next;
}

void Pipeline::Impl::advance(Stamp now) {
  step_to(now);
  // After a long pause there is nobody to publish the past for.
  constexpr Span longest_pause = std::chrono::seconds(1);
  const Stamp newest_past = now - longest_pause;
  for (auto event = next_event(); event && *event <= now; event = next_event()) {
    const Stamp at = std::max(*event, newest_past);
    advance_to(at);
    if (diagnostics_wanted) publish_diagnostics(at);
  }
}

std::vector<DiagnosticItem> Pipeline::Impl::diagnostics(Stamp now) const {
  std::vector<DiagnosticItem> items;
  const bool starting = start.is_starting(now);
  for (const auto& sensor : sensors) {
    SensorReport report = sensor->report();
    report.starting = starting;
    items.push_back(sensor_health(sensor->config(), report, unknown_senders, now));
  }
  for (const auto& sensor : sensors) {
    if (auto item = sensor->settings(now)) items.push_back(std::move(*item));
  }
  if (auto item = motion.diagnostics(sensor_context.now)) items.push_back(std::move(*item));
  for (const auto& output : outputs) items.push_back(output->diagnostics(now, starting));
  if (const auto names = unknown_senders.names(); !names.empty())
    items.push_back(unknown_senders_item(names));
  if (more_diagnostics) more_diagnostics(items);
  return items;
}

void Pipeline::Impl::publish_diagnostics(Stamp now) {
  diagnostics_wanted = false;
  last_diagnostics = now;
  outlet.publish(diagnostics(now), now);
}

std::string Pipeline::Impl::why_silent(const std::string& source) const {
  for (const auto& sensor : sensors) {
    if (sensor->config().name != source) continue;
    const std::string why = sensor->why_no_frames(unknown_senders);
    return why.empty() ? why : " (" + why + ")";
  }
  return {};
}

// ---- interface

Pipeline::Pipeline(const Config& config, TransformSource& transforms, FrameSink& sink)
    : Pipeline(config, transforms, std::vector<FrameSink*>{&sink}) {}
Pipeline::Pipeline(const Config& config, TransformSource& transforms, std::vector<FrameSink*> sinks)
    : impl_(std::make_unique<Impl>(config, transforms, std::move(sinks))) {}
Pipeline::~Pipeline() = default;

std::vector<StaticTransform> Pipeline::static_transforms() const { return impl_->frames.transforms(); }

void Pipeline::packet(const Packet& packet) {
  impl_->take(packet.arrival, [&] {
    Sensor* const sensor = impl_->owner_of(packet);
    if (sensor == nullptr) return;
    if (packet.transport == Transport::tcp)
      sensor->receive_recorded(packet);
    else
      sensor->receive(packet, packet.arrival);
  });
}

void Pipeline::set_links(DeviceConnections* links) { impl_->sensor_context.connections = links; }

void Pipeline::chunk(std::size_t sensor, const Packet& packet) {
  impl_->take(packet.arrival, [&] { impl_->sensors.at(sensor)->receive(packet, packet.arrival); });
}

void Pipeline::connected(std::size_t sensor, Stamp now) {
  impl_->sensor_context.now = now;
  impl_->sensors.at(sensor)->connected(now);
}

void Pipeline::disconnected(std::size_t sensor) { impl_->sensors.at(sensor)->disconnected(); }

std::uint64_t Pipeline::frames(std::size_t sensor) const {
  return impl_->sensors.at(sensor)->counters().frames;
}

void Pipeline::packet_message(const std::string& sensor, const Packet& packet, Stamp received) {
  impl_->take(received, [&] { impl_->sensor_named(sensor).receive(packet, received); });
}

void Pipeline::scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) {
  impl_->take(received, [&] { impl_->sensor_named(sensor).take_message(scan, received); });
}

void Pipeline::cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) {
  impl_->take(received, [&] { impl_->sensor_named(sensor).take_message(cloud, received); });
}

void Pipeline::pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) {
  impl_->advance(received);
  impl_->motion.add_pose(stamp, pose, child, received);
  impl_->advance_to(received);
}

void Pipeline::turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                            Stamp received) {
  impl_->advance(received);
  impl_->motion.add_turn(stamp, rates, frame, received);
  impl_->advance_to(received);
}

void Pipeline::speed_message(double speed) { impl_->motion.add_speed(speed); }

std::optional<Stamp> Pipeline::next_event() const { return impl_->next_event(); }
void Pipeline::advance(Stamp now) { impl_->advance(now); }

void Pipeline::tick(Stamp now) {
  // What arrived after the caller looked at its clock is known already.
  const Stamp known = impl_->sensor_context.now;
  if (now < known && known - now < diagnostics_period) now = known;
  impl_->advance(now);
  impl_->advance_to(now);
  for (const auto& sensor : impl_->sensors) sensor->tick(now);
  const Span since = now - impl_->last_diagnostics;
  if (impl_->diagnostics_wanted || since < Span(0) || since >= diagnostics_period)
    impl_->publish_diagnostics(now);
}

void Pipeline::finish(Stamp now) {
  impl_->sensor_context.now = now;
  for (const auto& sensor : impl_->sensors) sensor->finish();
}

void Pipeline::restart() {
  for (const auto& sensor : impl_->sensors) sensor->restart();
  for (const auto& output : impl_->outputs) output->restart();
  impl_->motion.restart();
}

std::string Pipeline::set_output(const OutputId& output, const OutputScanConfig& wanted) {
  if (const auto grid = make_grid(wanted.grid); !grid) return grid.reason();
  for (const auto& one : impl_->outputs) {
    if (!(one->id() == output)) continue;
    one->set_scan(wanted);
    return "";
  }
  return "there is no output named " + output.entry;
}

std::vector<SensorReport> Pipeline::report() const {
  std::vector<SensorReport> reports;
  for (const auto& sensor : impl_->sensors) reports.push_back(sensor->report());
  return reports;
}

std::vector<OutputReport> Pipeline::output_report() const {
  std::vector<OutputReport> reports = impl_->outlet.reports();
  for (OutputReport& report : reports) report.remark = why_missing(report.name);
  return reports;
}

std::vector<std::string> Pipeline::unclaimed_senders() const { return impl_->unknown_senders.names(); }

std::vector<DiagnosticItem> Pipeline::diagnostics(Stamp now) const { return impl_->diagnostics(now); }

std::string Pipeline::why_missing(const std::string& topic) const {
  for (const auto& output : impl_->outputs) {
    if (output->publishes(topic))
      return output->why_missing(topic,
                                 [this](const std::string& source) { return impl_->why_silent(source); });
  }
  for (const auto& sensor : impl_->sensors) {
    for (const OutputTopic& own : sensor_topics(sensor->config())) {
      if (own.name == topic) return sensor->why_no_frames(impl_->unknown_senders);
    }
  }
  return {};
}

void Pipeline::add_diagnostics(std::function<void(std::vector<DiagnosticItem>&)> source) {
  impl_->more_diagnostics = std::move(source);
}

}  // namespace lidard
