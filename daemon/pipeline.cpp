// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline.h"

#include <spdlog/spdlog.h>

#include <map>
#include <utility>

#include "daemon/merged_output.h"
#include "daemon/sensor_health.h"
#include "daemon/virtual_output.h"
#include "drivers/connection_picker.h"

namespace lidard {
namespace {

/// So many unknown senders are remembered by name; a flood of forged ones must not grow memory.
constexpr std::size_t max_strangers = 32;
constexpr Span diagnostics_period = std::chrono::seconds(1);

bool sends_clouds(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.model->kind == FrameKind::cloud;
}

TopicInfo sensor_topic(const SensorConfig& sensor) {
  const bool cloud = sends_clouds(sensor);
  if (cloud)
    return {sensor.points_topic.empty() ? sensor.name + "/points" : sensor.points_topic, TopicKind::cloud};
  return {sensor.scan_topic.empty() ? sensor.name + "/scan" : sensor.scan_topic, TopicKind::scan};
}

bool sends_echoes(const SensorConfig& sensor) {
  return sensor.model->has_echoes && sensor.driver.publish_multiecho;
}

std::string topic_below(const SensorConfig& sensor, std::string_view name) {
  return sensor.name + "/" + std::string(name);
}

}  // namespace

/// One sensor: its driver, and where its frames go.
struct SensorLine final : public DriverOutput {
  SensorLine(const SensorConfig& sensor, std::size_t place, Pipeline::Impl& pipeline)
      : config(sensor), index(place), owner(pipeline), arranger(sensor.layout) {
    if (config.model != nullptr) driver = config.model->make(config.driver);
    topic = sensor_topic(config).name;
    fix_topic = config.name + "/fix";
    time_topic = config.name + "/time_reference";
    imu_topic = config.name + "/imu";
    if (config.model == nullptr) return;
    if (config.ring_scan) ring_scan.emplace(*config.ring_scan);
    if (sends_echoes(config)) echoes_topic = config.name + "/echoes";
    for (const auto name : config.model->state_topics) named_topics[name] = topic_below(config, name);
    for (const auto name : config.model->extra_scans) named_topics[name] = topic_below(config, name);
  }
  bool owns_port(std::uint16_t port) const {
    if (config.model == nullptr || config.model->transport != Transport::udp) return false;
    if (!config.packet_topic.empty()) return false;
    return port == config.ip_port || (config.telemetry_port != 0 && port == config.telemetry_port);
  }
  /// Where the device listens for its TCP connection; port 0: it has none, or its address is not known.
  Endpoint device() const {
    if (config.model == nullptr || !config.ip_address) return {};
    const bool streams = config.model->transport == Transport::tcp;
    return {*config.ip_address, streams ? config.ip_port : config.model->dialogue_port};
  }
  void receive(const Packet& packet, Stamp received);
  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  void fix(const GnssFix& fix) override;
  void time_reference(const TimeReference& reference) override;
  void imu(const ImuSample& sample) override;
  void state(const DeviceState& state) override;
  void extra_scan(std::string_view name, PlanarScan& scan) override;
  void note(std::string_view sentence) override;
  void request(ByteView bytes) override;
  void connect() override { wish = Wish::connect; }
  void disconnect(bool again) override { wish = again ? Wish::connect_anew : Wish::hang_up; }
  /// Does with the connection what the driver asked for in the call that just returned.
  void settle();

  enum class Wish : std::uint8_t { none, connect, connect_anew, hang_up };

  SensorConfig config;
  std::size_t index;  // in the configuration
  Pipeline::Impl& owner;
  std::unique_ptr<Driver> driver;
  CloudArranger arranger;
  std::optional<RingScan> ring_scan;
  PlanarScan ring;
  std::string topic;
  std::string fix_topic;
  std::string time_topic;
  std::string imu_topic;
  std::string echoes_topic;                              // empty: none
  std::map<std::string_view, std::string> named_topics;  // states and further scans
  ConnectionPicker connection;
  IpAddress sender;  // of the last datagram
  Wish wish = Wish::none;
  bool seen = false;  // data; not what a device tells beside it
  Stamp last_arrival{};
  Stamp last_telemetry{};
  Counters topic_counters;  // of a `topic:` source
};

struct Pipeline::Impl {
  Impl(const Config& configuration, PoseLookup& lookup, FrameSink& frame_sink)
      : poses(configuration, lookup), sink(frame_sink) {
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
  void scan_from(const SensorLine& line, const PlanarScan& scan);
  void cloud_from(const SensorLine& line, const Cloud& cloud);
  void note_stranger(const Packet& packet);

  PoseBook poses;
  FrameSink& sink;
  std::vector<std::unique_ptr<SensorLine>> lines;
  std::vector<std::unique_ptr<MergedOutput>> merged;
  std::vector<std::unique_ptr<VirtualOutput>> virtuals;
  DeviceLinks* links = nullptr;
  /// Sender's address with the destination port, or with its own where it was a connection.
  std::map<std::pair<Transport, Endpoint>, std::uint64_t> strangers;
  std::uint64_t strangers_not_named = 0;
  Stamp now{};
  Stamp last_diagnostics{};
  std::function<void(std::vector<DiagnosticItem>&)> more_diagnostics;
};

void SensorLine::scan(PlanarScan& scan) {
  owner.sink.scan(topic, scan, owner.now);
  if (!echoes_topic.empty()) owner.sink.scan(echoes_topic, scan, owner.now);
  owner.scan_from(*this, scan);
}

void SensorLine::cloud(Cloud& cloud) {
  owner.cloud_from(*this, cloud);
  if (ring_scan && ring_scan->convert(cloud, ring)) owner.sink.scan(config.scan_topic, ring, owner.now);
  owner.sink.cloud(topic, arranger.is_plain() ? cloud : arranger.arrange(cloud), owner.now);
}

void SensorLine::fix(const GnssFix& fix) { owner.sink.fix(fix_topic, fix, owner.now); }

void SensorLine::time_reference(const TimeReference& reference) {
  owner.sink.time_reference(time_topic, reference, owner.now);
}

void SensorLine::imu(const ImuSample& sample) { owner.sink.imu(imu_topic, sample, owner.now); }

void SensorLine::state(const DeviceState& state) {
  owner.sink.state(named_topics.at(state.topic), state, owner.now);
}

void SensorLine::extra_scan(std::string_view name, PlanarScan& scan) {
  owner.sink.scan(named_topics.at(name), scan, owner.now);
}

void SensorLine::request(ByteView bytes) {
  if (owner.links != nullptr) owner.links->send(index, bytes);
}

void SensorLine::settle() {
  const Wish what = std::exchange(wish, Wish::none);
  if (owner.links == nullptr || what == Wish::none) return;
  if (what != Wish::connect) return owner.links->disconnect(index, what == Wish::connect_anew);
  const IpAddress address = config.ip_address.value_or(sender);
  if (address != IpAddress()) owner.links->connect(index, address);
}

/// What comes in a dialogue beside the data does not show that the data come.
void SensorLine::receive(const Packet& packet, Stamp received) {
  const bool datagram = packet.transport == Transport::udp;
  if (datagram) sender = packet.from.address;
  const std::uint64_t data_packets = driver->counters().packets;
  driver->receive(packet, *this);
  if (packet.transport == config.model->transport) {
    // Chunks of a stream are data whether or not a telegram is complete.
    const bool data = !datagram || driver->counters().packets != data_packets;
    (data ? last_arrival : last_telemetry) = received;
    seen = seen || data;
  }
  settle();
}

void SensorLine::note(std::string_view sentence) { spdlog::info("{}: {}", config.name, sentence); }

std::vector<TopicInfo> pipeline_topics(const Config& config) {
  std::vector<TopicInfo> topics;
  for (const auto& sensor : config.sensors) {
    if (sensor.model == nullptr) continue;
    topics.push_back(sensor_topic(sensor));
    if (sensor.ring_scan) topics.push_back({sensor.scan_topic, TopicKind::scan});
    if (sensor.model->has_gnss()) {
      topics.push_back({sensor.name + "/fix", TopicKind::fix});
      topics.push_back({sensor.name + "/time_reference", TopicKind::time_reference});
    }
    if (sensor.model->has_imu) topics.push_back({sensor.name + "/imu", TopicKind::imu});
    if (sends_echoes(sensor)) topics.push_back({sensor.name + "/echoes", TopicKind::echoes});
    for (const auto name : sensor.model->state_topics)
      topics.push_back({topic_below(sensor, name), TopicKind::state});
    for (const auto name : sensor.model->extra_scans)
      topics.push_back({topic_below(sensor, name), TopicKind::scan});
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
