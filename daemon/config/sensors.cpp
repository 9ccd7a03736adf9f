// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/sensors.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "daemon/config/filter.h"
#include "daemon/config/reading.h"
#include "daemon/config/rows.h"
#include "daemon/config/vehicle.h"
#include "daemon/yaml/yaml.h"
#include "drivers/calibration_file.h"
#include "drivers/registry/nearest_models.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

const Model* read_model(const Value& value) {
  const std::string name = value.text("a name from `lidard models`");
  if (const Model* model = find_model(name)) return model;
  std::string expected;
  for (const std::string_view near : nearest_models(name))
    expected.append(expected.empty() ? "" : " or ").append(near);
  value.fail("is " + value.quoted() + ", which is no model",
             expected.empty() ? "a name from `lidard models`" : expected + "; see `lidard models`");
}

/// Sets the model's defaults.
void set_defaults(SensorConfig& sensor) {
  const Model& model = *sensor.model;
  sensor.driver.model = sensor.model;
  sensor.ip_port = model.port;
  sensor.telemetry_port = model.telemetry_port;
  const bool cloud = model.kind == FrameKind::cloud;
  if (cloud) sensor.points_topic = sensor.name + "/points";
  if (!cloud || model.has(Trait::revolutions)) sensor.scan_topic = sensor.name + "/scan";
}

void read_kind(const Mapping& yaml, SensorConfig& sensor) {
  const auto model = yaml.find("model");
  if (model && yaml.has("topic"))
    yaml.where("topic").fail_at_key("is given beside model",
                                    "one of them: model (our driver) or topic (another driver)");
  if (!model && !yaml.has("topic"))
    yaml.fail_missing("has neither model nor topic", "model: a name from `lidard models`, or topic:");
  if (!model) return;
  sensor.model = read_model(*model);
  set_defaults(sensor);
}

void check_network(const Mapping& yaml, SensorConfig& sensor) {
  if (!sensor.packet_topic.empty()) {
    sensor.ip_port = sensor.telemetry_port = 0;
    return;
  }
  const bool tcp = sensor.model->transport == Transport::tcp;
  if (sensor.ip_port == 0 && !yaml.has("ip_port"))
    yaml.self().fail_at_key("has no ip_port",
                            tcp ? "the TCP port that the device listens on: its model has no usual one"
                                : "the UDP port that the sensor sends to: its model has no usual one");
  if (tcp && !yaml.has("ip_address"))
    yaml.self().fail_at_key("has no ip_address",
                            "the device's address: it is read over TCP, so somebody has to connect to it");
  if (sensor.model->has(Trait::gnss) && sensor.telemetry_port == sensor.ip_port)
    yaml.where_first({"telemetry_port", "ip_port"})
        .fail("is both ip_port and telemetry_port", "two ports, or telemetry_port: 0");
  if (!sensor.interface.empty() && !yaml.has("multicast_group"))
    yaml.where("interface")
        .fail_at_key("is given without multicast_group", "both: the interface is where the group is joined");
}

void check_requests(const Mapping& yaml, SensorConfig& sensor) {
  DeviceRequests& requests = sensor.driver.requests;
  if (requests.host_address) requests.host_port = sensor.ip_port;
  if (requests.host_address && !yaml.has("ip_address"))
    yaml.where("udp_receiver_ip")
        .fail_at_key("is given without ip_address",
                     "both: the device is told over TCP where to send, so its address must be known");
  if (sensor.model->has(Trait::skip_request) && requests.skip.value_or(0) > 9)
    yaml.where("skip").fail("is " + std::to_string(*requests.skip), "a whole number from 0 to 9");
  if (requests.listen_only && requests.allow_write)
    yaml.where("listen_only").fail_at_key("contradicts allow_write", "one of them");
  if (sensor.model->has(Trait::logins) && yaml.has("user_level") != yaml.has("user_level_password"))
    yaml.where_first({"user_level", "user_level_password"})
        .fail_at_key("is given alone", "both user_level and user_level_password, or none");
}

void check_control_of(const Mapping& parent, SensorConfig& sensor, Reading& reading) {
  sensor.control.data_port = sensor.ip_port;
  if (!parent.has("control")) return;
  check_control(parent.inside("control"), sensor.ip_address, sensor.control, reading.warnings);
  if (sensor.control.wanted.any()) sensor.driver.control = std::make_shared<VelodyneControl>(sensor.control);
}

void check_frames(const Mapping& yaml, DriverConfig& driver) {
  if (driver.max_range != 0 && driver.max_range <= driver.min_range && yaml.has("max_range"))
    yaml.where("max_range").fail("is not above min_range", "min_range < max_range, or 0 for no limit");
  if (std::abs(driver.view_direction) > two_pi)
    yaml.where("view_direction").fail("is more than a turn", "an angle in [-pi, pi], 0 ahead");
  if (driver.view_width <= 0 || driver.view_width > two_pi + 1e-6)
    yaml.where("view_width").fail("is no width of a sector", "an angle in (0, 2 pi]");
  driver.view_width = std::min(driver.view_width, two_pi);
}

/// The requested ring; empty: auto or none.
std::optional<std::uint16_t> read_ring(const std::optional<Value>& value, const SensorConfig& sensor) {
  if (!value || value->text("auto, or a ring counted from 0") == "-1") return std::nullopt;
  const Model& model = *sensor.model;
  if (value->text() != "auto")
    return static_cast<std::uint16_t>(value->integer(0, static_cast<long>(model.beams) - 1));
  if (model.level_ring == nullptr)
    value->fail("is auto, but it is not known which ring of this model is level", "a ring counted from 0");
  return model.level_ring(sensor.driver);
}

/// Reads the ring that is published as a planar scan. Call it after the calibration, which may determine the
/// level ring.
void read_ring_scan(const Mapping& yaml, SensorConfig& sensor) {
  const auto asked = yaml.find("scan_ring");
  const auto ring = read_ring(asked, sensor);
  const auto resolution = yaml.angle("scan_resolution");
  for (const char* key : {"scan_resolution", "scan_topic", "counter_clockwise"}) {
    if (!ring && yaml.has(key)) yaml.where(key).fail_at_key("is given without scan_ring", "both, or neither");
  }
  if (!ring) return;
  RingScanSpec spec;
  spec.ring = *ring;
  spec.resolution = resolution.value_or(spec.resolution);
  if (!(spec.resolution >= 0.0005 && spec.resolution <= 0.2))
    yaml.where("scan_resolution").fail("is out of range", "0.0005 to 0.2 rad");
  sensor.ring_scan = spec;
  set_ring_limits(sensor);
  sensor.driver.keep_too_near = true;
}

void check_cloud(const Mapping& yaml, SensorConfig& sensor, const Reading& reading) {
  if (sensor.deskew && !reading.vehicle.has_motion() && reading.is_vehicle_valid)
    yaml.where("deskew").fail_at_key("needs to know how the vehicle moves",
                                     "vehicle.odometry_frame, vehicle.odometry_topic or vehicle.imu_topic");
  if (!sensor.model->has(Trait::revolutions)) return;
  check_frames(yaml, sensor.driver);
  read_ring_scan(yaml, sensor);
}

/// Claims the topics that the sensor publishes and listens to.
void claim_topics(const Mapping& yaml, const SensorConfig& sensor, Reading& reading) {
  const std::string& owner = yaml.self().path();
  for (const OutputTopic& topic : sensor_topics(sensor))
    reading.claims.publishes(topic.name, owner, yaml.self());
  if (!sensor.packet_topic.empty()) reading.claims.listens(sensor.packet_topic, owner, yaml.self());
  if (!sensor.topic.empty()) reading.claims.listens(sensor.topic, owner, yaml.where("topic"));
}

/// Claims the pose of the sensor's frame; frames in messages of other drivers are not known.
void claim_pose(const Mapping& yaml, SensorConfig& sensor, Reading& reading) {
  const std::string& base = reading.vehicle.base_frame;
  if (sensor.pose)
    reading.claims.holds_frame(sensor.frame_id, base, *sensor.pose, yaml.self().path(), yaml.where("pose"));
  else if (sensor.model != nullptr && sensor.frame_id == base)
    sensor.pose = Pose::Identity();
}

/// Sensors are distinguished by port and sender; rejects ambiguous ones.
void check_distinct(const Mapping& yaml, const SensorConfig& sensor,
                    const std::vector<SensorConfig>& earlier) {
  if (sensor.model == nullptr || !sensor.packet_topic.empty()) return;
  for (const SensorConfig& other : earlier) {
    if (other.model == nullptr || !other.packet_topic.empty()) continue;
    if (other.model->transport != sensor.model->transport) continue;
    if (other.ip_port != sensor.ip_port || other.ip_address != sensor.ip_address) continue;
    const std::string port = std::to_string(sensor.ip_port);
    if (sensor.ip_address)
      yaml.where("ip_address")
          .fail("and port " + port + " are those of sensors." + other.name + " too",
                "another ip_address or ip_port for each sensor");
    yaml.self().fail_at_key("and sensors." + other.name + " share port " + port +
                                " without ip_address, so nothing tells them apart",
                            "ip_address for at least one of them");
  }
}

std::string in_folder_of(const std::string& config_file, const std::string& path) {
  const auto slash = config_file.rfind('/');
  return path.front() == '/' || slash == std::string::npos ? path : config_file.substr(0, slash + 1) + path;
}

/// Reads the calibration that the keys name.
void read_calibration(const Mapping& yaml, SensorConfig& sensor, Reading& reading) {
  std::optional<CalibrationFile> read;
  if (const auto file = yaml.find("calibration")) {
    const std::string expected = "a calibration file, relative to the configuration's folder";
    sensor.calibration = file->text(expected);
    const std::string path = in_folder_of(reading.file, sensor.calibration);
    if (::access(path.c_str(), R_OK) != 0)
      file->fail("is " + file->quoted() + ", which cannot be read: " + std::strerror(errno), expected);
    read = {path, read_file(path, calibration_files)};
    sensor.calibration_digest = std::hash<std::string>()(read->text);
  }
  sensor.driver.calibration = check_calibration(yaml, *sensor.model, read, parse_yaml, reading.warnings);
}

void check_filter_of(const Mapping& parent, SensorConfig& sensor) {
  if (!parent.has("filter")) return;
  const bool has_scan = sensor.model->kind == FrameKind::scan || parent.has("scan_ring");
  check_filter(parent.inside("filter"), {*sensor.model, has_scan, sensor.driver.publish_intensity},
               sensor.filter);
}

void check_device(const Mapping& yaml, SensorConfig& sensor, Reading& reading, Mistakes& mistakes) {
  mistakes.attempt([&] { check_network(yaml, sensor); });
  mistakes.attempt([&] { check_sector(yaml, sensor.driver.sector()); });
  mistakes.attempt([&] { check_filter_of(yaml, sensor); });
  if (sensor.model->has(Trait::web_control) && sensor.packet_topic.empty())
    mistakes.attempt([&] { check_control_of(yaml, sensor, reading); });
  if (sensor.model->has(Trait::calibration))
    mistakes.attempt([&] { read_calibration(yaml, sensor, reading); });
  mistakes.attempt([&] { check_requests(yaml, sensor); });
  // The level ring may depend on the calibration.
  if (!mistakes.any()) mistakes.attempt([&] { check_cloud(yaml, sensor, reading); });
}

/// What the keys of an entry have to fulfil together, and what follows from them.
void check_sensor(const Mapping& yaml, SensorConfig& sensor, Reading& reading) {
  Mistakes mistakes;
  sensor.driver.frame_id = sensor.frame_id;
  if (!sensor.raw_topic.empty()) sensor.driver.raw_packets = sensor.layout.stamp;
  mistakes.attempt([&] { claim_pose(yaml, sensor, reading); });
  if (sensor.model != nullptr) check_device(yaml, sensor, reading, mistakes);
  mistakes.attempt([&] { claim_topics(yaml, sensor, reading); });
  mistakes.attempt([&] { check_distinct(yaml, sensor, reading.sensors); });
  mistakes.throw_if_any();
}

/// Rejects keys that the sensor does not accept.
void check_keys(const Mapping& yaml, const Keys& keys, const SensorConfig& sensor, Mistakes& mistakes) {
  for (const Key& key : keys) {
    if (!yaml.has(key.name) || accepts(sensor, key)) continue;
    const Rejection why = refusal(sensor, key);
    mistakes.attempt([&] { yaml.where(key.name).fail_at_key(why.what, why.expected); });
  }
}

/// Adds the name of the sensor, and the topics that it listens to or publishes frames on.
void add_candidates(const SensorConfig& sensor, std::vector<Candidate>& candidates) {
  const Source source = source_of(sensor);
  const std::string path = "sensors." + sensor.name;
  const bool gives_both = sensor.model == nullptr || sensor.ring_scan;
  const auto of_name = gives_both ? std::nullopt : std::optional<FrameKind>(sensor.model->kind);
  std::string nature;
  if (sensor.model != nullptr)
    nature = std::string(sensor.model->name) + ", which gives " +
             (sensor.model->kind == FrameKind::cloud ? "clouds" : "scans");
  candidates.push_back({sensor.name, of_name, source, path, "a " + nature});
  const auto add_topic = [&](const std::string& topic, std::optional<FrameKind> kind) {
    candidates.push_back({topic, kind, source, "the topic of " + path, "of a " + nature});
  };
  if (sensor.model == nullptr) add_topic(sensor.topic, {});
  for (const OutputTopic& topic : sensor_topics(sensor)) {
    const bool is_cloud = topic.kind == TopicKind::cloud;
    if (topic.promised && (is_cloud || topic.kind == TopicKind::scan))
      add_topic(topic.name, is_cloud ? FrameKind::cloud : FrameKind::scan);
  }
}

SensorConfig read_sensor(const std::string& name, const Value& entry, Reading& reading) {
  Mistakes mistakes;
  SensorConfig sensor;
  sensor.name = sensor.frame_id = name;
  const Keys keys = sensor_keys(sensor);
  const Mapping yaml = mapping_of(entry, keys, mistakes);
  const bool is_known = mistakes.attempt([&] { read_kind(yaml, sensor); });
  for (const Key& key : keys) {
    if (!is_known || accepts(sensor, key)) mistakes.attempt([&] { read_key(yaml, key); });
  }
  if (is_known) check_keys(yaml, keys, sensor, mistakes);
  // The rules between keys need all of them.
  mistakes.throw_if_any();
  check_sensor(yaml, sensor, reading);
  add_candidates(sensor, reading.candidates);
  reading.has_sensors = true;
  return sensor;
}

/// Topics of the device's messages beside its frames.
void add_device_topics(const SensorConfig& sensor, std::vector<OutputTopic>& topics) {
  const std::string below = sensor.name + "/";
  const bool states = !sensor.model->has(Trait::states_on_request) || sensor.driver.requests.device_states;
  for (const MessageTopic& message : sensor.model->messages) {
    if (message.kind == message_kind<DeviceState>() && !states) continue;
    if (message.name == output_paths_topic && !sensor.output_paths_topic.empty()) continue;
    topics.push_back(
        {below + std::string(message.name), TopicKind::message, false, message.kind, 0, message.name});
  }
  if (!states) return;
  for (const auto name : sensor.model->extra_scans)
    topics.push_back({below + std::string(name), TopicKind::scan, false, 0, 0, name});
}

}  // namespace

void set_ring_limits(SensorConfig& sensor) {
  if (!sensor.ring_scan) return;
  const DriverConfig& driver = sensor.driver;
  sensor.ring_scan->range_min = driver.min_range > 0 ? driver.min_range : sensor.model->range_min;
  sensor.ring_scan->range_max = driver.max_range > 0 ? driver.max_range : sensor.model->range_max;
}

Source source_of(const SensorConfig& sensor) {
  const ScanGridSpec usual;
  if (sensor.model == nullptr) return {Source::Kind::topic, sensor.name, usual.range_min, usual.range_max};
  const Model& model = *sensor.model;
  const double proven = model.dark_range > 0 ? model.free_range() : 0;
  return {Source::Kind::sensor, sensor.name, model.range_min, model.range_max, proven};
}

const SensorConfig* find_sensor(const std::vector<SensorConfig>& sensors, const std::string& name) {
  const auto found =
      std::find_if(sensors.begin(), sensors.end(), [&](const auto& one) { return one.name == name; });
  return found == sensors.end() ? nullptr : &*found;
}

std::string names_of(const std::vector<SensorConfig>& sensors, FrameKind kind) {
  std::string list;
  for (const SensorConfig& sensor : sensors) {
    const bool gives_both = sensor.model == nullptr || sensor.ring_scan;
    if (gives_both || sensor.model->kind == kind) list += (list.empty() ? "" : ", ") + sensor.name;
  }
  return list.empty() ? "none is configured" : list;
}

void read_sensors(const Mapping& root, Reading& reading) {
  const std::string expected = "sensors: with at least one entry, each with model: or topic:";
  // A section that is indented too far is an unknown key of `vehicle`.
  if (!root.has("sensors") && !reading.is_vehicle_valid) return;
  const Value section = root.require("sensors", expected);
  read_entries(section, reading.sensors, reading, read_sensor);
  if (reading.sensors.empty()) section.fail("is empty", expected);
}

std::vector<Flow> flows_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return {};
  std::vector<Flow> flows = flows_of(*sensor.model, sensor.ip_address.value_or(IpAddress()), sensor.ip_port,
                                     sensor.telemetry_port, sensor.device_port());
  const auto is_foreign = [&](const Flow& flow) {
    // Another node receives the datagrams; a connection identifies a device only by address.
    return flow.transport == Transport::udp ? !sensor.packet_topic.empty() : !sensor.ip_address;
  };
  flows.erase(std::remove_if(flows.begin(), flows.end(), is_foreign), flows.end());
  return flows;
}

OutputTopic frame_topic(const SensorConfig& sensor) {
  if (sensor.model != nullptr && sensor.model->kind == FrameKind::cloud)
    return {sensor.points_topic.empty() ? sensor.name + "/points" : sensor.points_topic, TopicKind::cloud};
  return {sensor.scan_topic.empty() ? sensor.name + "/scan" : sensor.scan_topic, TopicKind::scan};
}

std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor) {
  std::vector<OutputTopic> topics;
  if (sensor.model == nullptr) return topics;
  topics.push_back(frame_topic(sensor));
  if (sensor.ring_scan) topics.push_back({sensor.scan_topic, TopicKind::scan});
  if (sensor.model->has(Trait::echoes) && sensor.driver.publish_multiecho)
    topics.push_back({sensor.name + "/echoes", TopicKind::echoes});
  if (!sensor.raw_topic.empty())
    topics.push_back(
        {sensor.raw_topic, TopicKind::message, true, message_kind<RawPackets>(), 0, RawPackets::topic});
  if (!sensor.extended_scan_topic.empty())
    topics.push_back({sensor.extended_scan_topic, TopicKind::extended_scan});
  if (!sensor.output_paths_topic.empty())
    topics.push_back({sensor.output_paths_topic, TopicKind::output_paths, false, 0, 0, output_paths_topic});
  add_device_topics(sensor, topics);
  return topics;
}

}  // namespace lidard
