// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pipeline.h"

#include <algorithm>

#include "core/motion/dead_reckoning.h"
#include "daemon/pipeline/merged_output.h"
#include "daemon/pipeline/missing_outputs.h"
#include "daemon/pipeline/motion_watch.h"
#include "daemon/pipeline/scan_tap.h"
#include "daemon/pipeline/sensor.h"
#include "daemon/pipeline/sensor_health.h"
#include "daemon/pipeline/start_watch.h"
#include "daemon/pipeline/transform_source.h"
#include "daemon/pipeline/unknown_senders.h"
#include "daemon/pipeline/virtual_output.h"

namespace lidard {
namespace {

constexpr Span diagnostics_period = std::chrono::seconds(1);

}  // namespace

struct Pipeline::Impl final : public LineOwner {
  Impl(const Config& configuration, TransformSource& pose_lookup, FrameSink& frame_sink)
      : LineOwner(frame_sink),
        lookup(pose_lookup),
        topics(output_topics(configuration)),
        vehicle(configuration.vehicle),
        poses(configuration, pose_lookup) {
    if (configuration.vehicle.has_motion()) poses.set_track(&track);
    for (const auto& sensor : configuration.sensors) {
      lines.push_back(std::make_unique<Sensor>(sensor, lines.size(), topics, *this));
    }
    for (const auto& entry : configuration.merged_scans)
      merged.push_back(std::make_unique<MergedOutput>(entry, vehicle, topics, poses));
    for (const auto& entry : configuration.virtual_scans)
      virtuals.push_back(std::make_unique<VirtualOutput>(entry, vehicle, topics, poses));
  }

  Sensor* find_line(const Packet& packet);
  void chunk(Packet packet);
  Sensor& line_named(const std::string& name);
  bool is_sensor(const std::string& name) const;
  void scan_from(const Sensor& line, const PlanarScan& scan) override;
  void cloud_from(const Sensor& line, const Cloud& cloud) override;
  /// A scan of a sensor or a virtual scan, for the merged scans that use it.
  void merge(const std::string& source_name, const PlanarScan& scan);
  /// Takes what tf has learned of the vehicle's way.
  void poll_motion();
  /// Time passes, perhaps by a jump. Packets that waited while we stood bring their time with them.
  void step_to(Stamp at);
  /// Publishes what is due at `at`.
  void advance_to(Stamp at);
  std::optional<Stamp> next_event() const;
  void tell(const std::vector<DiagnosticItem>& items, Stamp at);
  DiagnosticItem motion_item() const;
  template <class Output>
  bool rebuild(std::vector<std::unique_ptr<Output>>& outputs, const std::string& entry,
               const OutputScanConfig& wanted);

  TransformSource& lookup;
  const std::vector<OutputTopic> topics;
  PoseTrack track;
  std::vector<StampedPose> new_poses;
  Stamp last_poll{};  // of tf
  DeadReckoning reckoning;
  MotionWatch motion;
  std::string why_no_motion;
  std::uint64_t poses_refused = 0;  // since the pose of their frame on the vehicle is not known
  VehicleConfig vehicle;
  FrameTree poses;
  std::vector<std::unique_ptr<Sensor>> lines;
  std::vector<std::unique_ptr<MergedOutput>> merged;
  std::vector<std::unique_ptr<VirtualOutput>> virtuals;
  ScanTap tap{sink, [this](const OutputTopic& topic, const PlanarScan& scan) {
                // A sensor may have the name of a virtual scan's topic; then the name means the sensor.
                if (!is_sensor(topic.name)) merge(topic.name, scan);
              }};
  UnknownSenders unknown_senders;
  StartWatch start;
  Stamp last_diagnostics{};
  bool diagnostics_wanted = false;  // a source has come or gone
  std::function<void(std::vector<DiagnosticItem>&)> more_diagnostics;
};

Sensor* Pipeline::Impl::find_line(const Packet& packet) {
  Sensor* anybody = nullptr;
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
  if (known_port) unknown_senders.note(packet);
}

Sensor& Pipeline::Impl::line_named(const std::string& name) {
  for (const auto& line : lines) {
    if (line->config.name == name) return *line;
  }
  throw std::logic_error("no sensor named " + name);
}

bool Pipeline::Impl::is_sensor(const std::string& name) const {
  return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line->config.name == name; });
}

void Pipeline::Impl::scan_from(const Sensor& line, const PlanarScan& scan) {
  poll_motion();
  motion.data(scan.stamp, now);
  merge(line.config.name, scan);
}

void Pipeline::Impl::merge(const std::string& source_name, const PlanarScan& scan) {
  for (const auto& output : merged) {
    const int source = output->source_index(source_name);
    if (source >= 0) output->add(static_cast<std::size_t>(source), scan, now, sink);
  }
}

void Pipeline::Impl::cloud_from(const Sensor& line, const Cloud& cloud) {
  poll_motion();
  motion.data(cloud.stamp, now);
  for (const auto& output : virtuals) {
    if (output->cloud_sensor() == line.config.name) output->add(cloud, now, tap);
  }
}

Pipeline::Pipeline(const Config& config, TransformSource& poses, FrameSink& sink)
    : impl_(std::make_unique<Impl>(config, poses, sink)) {}
Pipeline::~Pipeline() = default;

std::vector<StaticTransform> Pipeline::static_transforms() const { return impl_->poses.transforms(); }

void Pipeline::packet(const Packet& packet) {
  advance(packet.arrival);
  impl_->now = packet.arrival;
  if (packet.transport == Transport::tcp) return impl_->chunk(packet);
  Sensor* line = impl_->find_line(packet);
  if (line == nullptr) {
    impl_->unknown_senders.note(packet);
    return;
  }
  line->receive(packet, packet.arrival);
}

void Pipeline::set_links(DeviceConnections* links) { impl_->links = links; }
void Pipeline::chunk(std::size_t sensor, const Packet& packet) {
  advance(packet.arrival);
  impl_->now = packet.arrival;
  impl_->lines.at(sensor)->receive(packet, packet.arrival);
}

void Pipeline::connected(std::size_t sensor, Stamp now) {
  impl_->now = now;
  Sensor& line = *impl_->lines.at(sensor);
  line.driver->connected(now, line);
  line.apply_connection_request();
}

void Pipeline::disconnected(std::size_t sensor) { impl_->lines.at(sensor)->driver->disconnected(); }

std::uint64_t Pipeline::frames(std::size_t sensor) const {
  return impl_->lines.at(sensor)->driver->counters().frames;
}

void Pipeline::packet_message(const std::string& sensor, const Packet& packet, Stamp received) {
  advance(received);
  impl_->now = received;
  impl_->line_named(sensor).receive(packet, received);
}

void Pipeline::scan_message(const std::string& sensor, PlanarScan& scan, Stamp received) {
  advance(received);
  impl_->now = received;
  Sensor& line = impl_->line_named(sensor);
  if (line.take_message(scan, received)) impl_->scan_from(line, scan);
}

void Pipeline::cloud_message(const std::string& sensor, Cloud& cloud, Stamp received) {
  advance(received);
  impl_->now = received;
  Sensor& line = impl_->line_named(sensor);
  line.take_message(cloud, received);
  impl_->cloud_from(line, cloud);
}

void Pipeline::pose_message(Stamp stamp, const Pose& pose, const std::string& child, Stamp received) {
  advance(received);
  Pose child_from_base = Pose::Identity();
  const bool known = child.empty() || impl_->poses.find(child, impl_->vehicle.base_frame, stamp,
                                                        child_from_base, impl_->why_no_motion);
  if (known) impl_->track.add(stamp, pose * child_from_base);
  impl_->motion.poses(impl_->track, received);
  impl_->poses_refused += known ? 0 : 1;
  impl_->advance_to(received);
}

void Pipeline::turn_message(Stamp stamp, const Eigen::Vector3d& rates, const std::string& frame,
                            Stamp received) {
  advance(received);
  Pose base_from_imu = Pose::Identity();
  const bool known = frame.empty() || impl_->poses.find(impl_->vehicle.base_frame, frame, stamp,
                                                        base_from_imu, impl_->why_no_motion);
  if (known) impl_->reckoning.turn(stamp, base_from_imu.linear() * rates, impl_->track);
  impl_->motion.poses(impl_->track, received);
  impl_->poses_refused += known ? 0 : 1;
  impl_->advance_to(received);
}

void Pipeline::speed_message(double speed) { impl_->reckoning.speed(speed); }

DiagnosticItem Pipeline::Impl::motion_item() const {
  DiagnosticItem item = motion.diagnostics(track, poses_refused, why_no_motion, now);
  item.values.emplace_back("Out of order", std::to_string(track.out_of_order() + reckoning.refused()));
  return item;
}

void Pipeline::Impl::poll_motion() {
  // Packets come by the thousand, poses by the dozen.
  constexpr Span between_polls = std::chrono::milliseconds(5);
  if (vehicle.odometry_frame.empty()) return;
  if (now >= last_poll && now - last_poll < between_polls) return;
  last_poll = now;
  new_poses.clear();
  lookup.history(vehicle.odometry_frame, vehicle.base_frame, track.newest(), now, new_poses);
  for (const StampedPose& one : new_poses) track.add(one.stamp, one.pose);
  motion.poses(track, now);
}

void Pipeline::Impl::step_to(Stamp at) {
  const bool jumped = start.step(at);
  for (const auto& line : lines) {
    line->watch.advance(at, line->counters());
    if (jumped) line->clock_jumped_to(at);
  }
}

void Pipeline::Impl::advance_to(Stamp at) {
  now = at;
  poll_motion();
  bool changed = false;
  for (const auto& output : merged) {
    output->advance(at, sink);
    changed = output->states_changed(at) || changed;
  }
  if (changed) diagnostics_wanted = true;
}

void Pipeline::Impl::tell(const std::vector<DiagnosticItem>& items, Stamp at) {
  diagnostics_wanted = false;
  last_diagnostics = at;
  sink.diagnostics(items, at);
}

std::optional<Stamp> Pipeline::Impl::next_event() const {
  std::optional<Stamp> next;
  for (const auto& output : merged) {
    const auto event = output->next_event();
    if (event && (!next || *event < *next)) next = event;
  }
  return next;
}

std::optional<Stamp> Pipeline::next_event() const { return impl_->next_event(); }
void Pipeline::advance(Stamp now) {
  impl_->step_to(now);
  // After a long pause there is nobody to publish the past for.
  constexpr Span longest_pause = std::chrono::seconds(1);
  const Stamp newest_past = now - longest_pause;
  for (auto event = impl_->next_event(); event && *event <= now; event = impl_->next_event()) {
    const Stamp at = std::max(*event, newest_past);
    impl_->advance_to(at);
    if (impl_->diagnostics_wanted) impl_->tell(diagnostics(at), at);
  }
}

void Pipeline::tick(Stamp now) {
  // What arrived after the caller looked at its clock is known already.
  if (now < impl_->now && impl_->now - now < diagnostics_period) now = impl_->now;
  advance(now);
  impl_->advance_to(now);
  for (const auto& line : impl_->lines) {
    if (line->driver == nullptr) continue;
    line->driver->tick(now, *line);
    line->apply_connection_request();
  }
  const Span since = now - impl_->last_diagnostics;
  if (impl_->diagnostics_wanted || since < Span(0) || since >= diagnostics_period)
    impl_->tell(diagnostics(now), now);
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
    line->watch.restart();
  }
  for (const auto& output : impl_->merged) output->restart();
  impl_->track.clear();
}

template <class Output>
bool Pipeline::Impl::rebuild(std::vector<std::unique_ptr<Output>>& outputs, const std::string& entry,
                             const OutputScanConfig& wanted) {
  for (auto& output : outputs) {
    if (output->config().name != entry) continue;
    auto config = output->config();
    config.output = wanted;
    auto next = std::make_unique<Output>(config, vehicle, topics, poses);
    next->continue_from(*output);
    output = std::move(next);
    return true;
  }
  return false;
}

std::string Pipeline::set_output(const OutputId& output, const OutputScanConfig& wanted) {
  std::string complaint;
  if (!make_grid(wanted.grid, complaint)) return complaint;
  const bool found = output.kind == OutputId::Kind::merged
                         ? impl_->rebuild(impl_->merged, output.entry, wanted)
                         : impl_->rebuild(impl_->virtuals, output.entry, wanted);
  return found ? "" : "there is no output named " + output.entry;
}

std::vector<SensorReport> Pipeline::report() const {
  std::vector<SensorReport> reports;
  for (const auto& line : impl_->lines) reports.push_back(line->report());
  return reports;
}

std::vector<std::string> Pipeline::unclaimed_senders() const { return impl_->unknown_senders.names(); }

std::vector<DiagnosticItem> Pipeline::diagnostics(Stamp now) const {
  std::vector<DiagnosticItem> items;
  const bool starting = impl_->start.is_starting(now);
  auto reports = report();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    reports[i].starting = starting;
    items.push_back(sensor_health(impl_->lines[i]->config, reports[i], unclaimed_senders(), now));
  }
  if (impl_->poses.track() != nullptr) items.push_back(impl_->motion_item());
  for (const auto& output : impl_->merged) items.push_back(output->diagnostics(now, starting));
  for (const auto& output : impl_->virtuals) items.push_back(output->diagnostics(now, starting));
  if (const auto unknown_senders = unclaimed_senders(); !unknown_senders.empty())
    items.push_back(unknown_senders_item(unknown_senders));
  if (impl_->more_diagnostics) impl_->more_diagnostics(items);
  return items;
}

std::string Pipeline::why_missing(const std::string& topic) const {
  return lidard::why_missing(topic, impl_->lines, impl_->merged, impl_->virtuals, unclaimed_senders());
}

void Pipeline::add_diagnostics(std::function<void(std::vector<DiagnosticItem>&)> source) {
  impl_->more_diagnostics = std::move(source);
}

}  // namespace lidard
