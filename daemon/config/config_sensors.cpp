// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <utility>

#include "daemon/config/config_parts.h"
#include "daemon/config/output_topics.h"
#include "drivers/registry/nearest_models.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

constexpr double longest_offset_s = 1e6;  // so that a nanosecond survives in a double

const std::vector<std::string_view> sensor_keys = {"model",
                                                   "topic",
                                                   "ip_address",
                                                   "ip_port",
                                                   "frame_id",
                                                   "pose",
                                                   "multicast_group",
                                                   "interface",
                                                   "clock",
                                                   "time_offset",
                                                   "cut_angle",
                                                   "cut_angle_deg",
                                                   "frame_cut",
                                                   "frame_duration",
                                                   "min_range",
                                                   "max_range",
                                                   "view_direction",
                                                   "view_direction_deg",
                                                   "view_width",
                                                   "view_width_deg",
                                                   "organize_cloud",
                                                   "publish_confidence",
                                                   "publish_echo",
                                                   "points_topic",
                                                   "scan_topic",
                                                   "scan_ring",
                                                   "scan_resolution",
                                                   "scan_resolution_deg",
                                                   "telemetry_port",
                                                   "packet_topic",
                                                   "angle_min",
                                                   "angle_min_deg",
                                                   "angle_max",
                                                   "angle_max_deg",
                                                   "cluster",
                                                   "skip",
                                                   "publish_intensity",
                                                   "publish_multiecho",
                                                   "calibrate_time",
                                                   "publish_states",
                                                   "frame_stamp",
                                                   "allow_write",
                                                   "listen_only",
                                                   "udp_receiver_ip",
                                                   "user_level",
                                                   "user_level_password",
                                                   "control",
                                                   "calibration",
                                                   "calibration_model"};

/// Why a key that this kind of sensor does not read is refused, and what to do instead.
std::pair<std::string, std::string> refusal(const std::string& key, const SensorConfig& sensor) {
  if (sensor.model == nullptr)
    return {"does not apply to a source with topic:", "topic, frame_id, pose and time_offset only"};
  if (key == "calibrate_time")
    return {"is not available in this version", "clock: smooth, which follows the device clock all the time"};
  const std::string model = "is not available for " + std::string(sensor.model->name);
  for (const char* request :
       {"allow_write", "listen_only", "udp_receiver_ip", "user_level", "user_level_password"}) {
    if (key == request)
      return {model + ", to whose settings nothing is said", "no such key; set it up in the device"};
  }
  if (key == "telemetry_port") return {model + ", which sends no telemetry beside its data", "no such key"};
  if (key == "packet_topic")
    return {model + ", whose packets travel in no message that is known", "a Velodyne, or no such key"};
  if (key == "publish_confidence")
    return {model + ", which does not vouch for its returns", "no such key: it applies to the VLS-128"};
  if (!sensor.packet_topic.empty())
    return {"is given beside packet_topic", "one of them: the network and its sensor are another node's"};
  if (key == "multicast_group" || key == "interface")
    return {model + ", which is read over TCP", "no such key"};
  if (key == "control")
    return {model + ", which has no web interface that is known",
            "no such key: it applies to Velodynes other than the HDL-64E"};
  if (key == "calibration" || key == "calibration_model")
    return {model + ", which sends calibrated measurements", "no such key"};
  const bool of_beams = key == "angle_min" || key == "angle_max" || key == "angle_min_deg" ||
                        key == "angle_max_deg" || key == "publish_intensity" || key == "publish_multiecho";
  if (sensor.model->kind == FrameKind::cloud && of_beams)
    return {model + ", whose clouds are complete with all returns",
            "no such key; view_direction and view_width keep a sector"};
  if (sensor.model->kind == FrameKind::scan && key != "cluster" && key != "skip" && !of_beams)
    return {model + ", which is no multi-plane lidar", "no such key"};
  if (sensor.model->kind == FrameKind::cloud)
    return {model + ", whose clouds are complete with all returns", "no such key"};
  return {model + ", which sends what its own configuration says", "no such key; set it in the device"};
}

std::optional<IpAddress> read_address(const std::optional<Value>& value, bool multicast) {
  if (!value) return std::nullopt;
  const std::string expected = multicast ? "a multicast address like 239.0.0.10"
                                         : "the sensor's IPv4 or IPv6 address like 192.168.1.201";
  const auto address = IpAddress::parse(value->text(expected));
  if (!address) value->fail("is " + value->quoted() + ", which is no address", expected);
  if (address->is_multicast() != multicast)
    value->fail(
        "is " + value->quoted() + (multicast ? ", which is no multicast group" : ", a multicast group"),
        multicast ? expected : expected + "; the group goes into multicast_group");
  return address;
}

const Model* read_model(const Value& value) {
  const std::string name = value.text("a name from `lidard models`");
  if (const Model* model = find_model(name)) return model;
  std::string expected;
  for (const std::string_view near : nearest_models(name))
    expected.append(expected.empty() ? "" : " or ").append(near);
  value.fail("is " + value.quoted() + ", which is no model",
             expected.empty() ? "a name from `lidard models`" : expected + "; see `lidard models`");
}

ClockMode read_clock(const Value& value) {
  const std::string word = value.text("smooth or arrival");
  if (word == "smooth") return ClockMode::smooth;
  if (word == "arrival") return ClockMode::arrival;
  value.fail("is " + value.quoted(), "smooth or arrival");
}

void read_telemetry_port(Mapping& yaml, SensorConfig& sensor) {
  sensor.telemetry_port = sensor.model->telemetry_port;
  if (!sensor.model->has(Trait::gnss)) return;
  const auto port = yaml.find("telemetry_port");
  if (port) sensor.telemetry_port = static_cast<std::uint16_t>(port->integer(0, 65535));
  if (sensor.telemetry_port != sensor.ip_port) return;
  (port ? *port : *yaml.find("ip_port"))
      .fail("is both ip_port and telemetry_port", "two ports, or telemetry_port: 0");
}

void read_network(Mapping& yaml, SensorConfig& sensor) {
  const bool tcp = sensor.model->transport == Transport::tcp;
  if (sensor.model->has(Trait::packet_messages)) {
    if (const auto packets = yaml.find("packet_topic")) {
      sensor.packet_topic = read_topic(*packets);
      return;  // the keys of the network stay unread, which is refused
    }
  }
  sensor.ip_address = read_address(yaml.find("ip_address"), false);
  sensor.ip_port = sensor.model->port;
  if (const auto port = yaml.find("ip_port"))
    sensor.ip_port = static_cast<std::uint16_t>(port->integer(1, 65535));
  if (sensor.ip_port == 0)
    yaml.self().fail_at_key("has no ip_port",
                            tcp ? "the TCP port that the device listens on: its model has no usual one"
                                : "the UDP port that the sensor sends to: its model has no usual one");
  if (tcp) {
    if (!sensor.ip_address)
      yaml.self().fail_at_key("has no ip_address",
                              "the device's address: it is read over TCP, so somebody has to connect to it");
    return;  // the keys of multicast stay unread, which is refused
  }
  read_telemetry_port(yaml, sensor);
  sensor.multicast_group = read_address(yaml.find("multicast_group"), true);
  const auto interface = yaml.find("interface");
  if (!interface) return;
  sensor.interface = interface->text_or_empty();
  if (!sensor.interface.empty() && !sensor.multicast_group)
    interface->fail_at_key("is given without multicast_group",
                           "both: the interface is where the group is joined");
}

void read_beams_kept(Mapping& yaml, DriverConfig& driver) {
  driver.angle_min = yaml.angle("angle_min");
  driver.angle_max = yaml.angle("angle_max");
  if (driver.angle_min && driver.angle_max && *driver.angle_max <= *driver.angle_min)
    yaml.where(yaml.has("angle_max") ? "angle_max" : "angle_max_deg")
        .fail("is not above angle_min", "angle_min < angle_max");
  if (const auto intensity = yaml.find("publish_intensity")) driver.publish_intensity = intensity->boolean();
  if (!driver.model->has(Trait::echoes)) return;
  if (const auto echoes = yaml.find("publish_multiecho")) driver.publish_multiecho = echoes->boolean();
}

/// What a request for distances of SCIP may ask for.
void read_scip_requests(Mapping& yaml, DeviceRequests& requests) {
  if (const auto skip = yaml.find("skip")) requests.skip = static_cast<int>(skip->integer(0, 9));
  if (const auto cluster = yaml.find("cluster")) requests.cluster = static_cast<int>(cluster->integer(1, 99));
  if (const auto calibrate = yaml.find("calibrate_time")) requests.calibrate_time = calibrate->boolean();
}

void read_device(Mapping& yaml, SensorConfig& sensor) {
  read_network(yaml, sensor);
  DriverConfig& driver = sensor.driver;
  driver.model = sensor.model;
  driver.frame_id = sensor.frame_id;
  if (const auto clock = yaml.find("clock")) driver.clock = read_clock(*clock);
  if (sensor.model->has(Trait::skip_setting)) read_cola_requests(yaml, driver.requests);
  if (sensor.model->kind == FrameKind::cloud) return;
  read_beams_kept(yaml, driver);
  if (sensor.model->has(Trait::skip_request)) read_scip_requests(yaml, driver.requests);
  const auto topic = yaml.find("scan_topic");
  sensor.scan_topic = topic ? read_topic(*topic) : sensor.name + "/scan";
}

/// Everything that the sensor publishes.
void claim_topics(const SensorConfig& sensor, const Value& value, ConfigClaims& claims) {
  const std::string owner = "sensors." + sensor.name;
  for (const OutputTopic& topic : sensor_topics(sensor)) claims.publishes(topic.name, owner, value);
  if (!sensor.packet_topic.empty()) claims.listens(sensor.packet_topic, owner, value);
}

/// `ours`: its frames carry `frame_id`; messages of other drivers carry what these say.
void read_pose_of(Mapping& yaml, bool ours, SensorConfig& sensor, const Config& config,
                  ConfigClaims& claims) {
  if (const auto pose = yaml.find("pose")) {
    sensor.pose = read_pose(*pose);
    claims.holds_frame(sensor.frame_id, config.vehicle.base_frame, *sensor.pose, "sensors." + sensor.name,
                       *pose);
  } else if (ours && sensor.frame_id == config.vehicle.base_frame) {
    sensor.pose = Pose::Identity();
  }
}

SensorConfig read_sensor(const std::string& name, Mapping& yaml, Config& config, ConfigClaims& claims) {
  SensorConfig sensor;
  sensor.name = name;
  sensor.frame_id = name;
  const auto model = yaml.find("model");
  const auto topic = yaml.find("topic");
  if (model && topic)
    topic->fail_at_key("is given beside model", "one of them: model (our driver) or topic (another driver)");
  if (!model && !topic)
    yaml.self().fail_at_key("has neither model nor topic", "model: a name from `lidard models`, or topic:");
  if (const auto frame = yaml.find("frame_id")) sensor.frame_id = read_frame(*frame);
  read_pose_of(yaml, model.has_value(), sensor, config, claims);
  if (const auto offset = yaml.find("time_offset"))
    sensor.driver.time_offset = offset->duration(-longest_offset_s, longest_offset_s);
  if (model) {
    sensor.model = read_model(*model);
    read_device(yaml, sensor);
    if (sensor.model->has(Trait::web_control) && sensor.packet_topic.empty()) {
      if (const auto control = yaml.find("control")) sensor.control = read_control(*control, sensor, config);
    }
    read_calibration(yaml, sensor, config);
    read_requests(yaml, sensor);
    if (sensor.model->kind == FrameKind::cloud) read_cloud_keys(yaml, sensor);
    claim_topics(sensor, yaml.self(), claims);
  } else {
    sensor.topic = read_topic(*topic);
    claims.listens(sensor.topic, "sensors." + name, *topic);
  }
  yaml.finish([&](const std::string& key) { return refusal(key, sensor); });
  return sensor;
}

/// Sensors are told apart by port and sender; refuses what cannot be.
void check_distinct(const SensorConfig& sensor, const Mapping& yaml,
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

}  // namespace

void read_sensors(Mapping& root, Config& config, ConfigClaims& claims) {
  const std::string expected = "sensors: with at least one entry, each with model: or topic:";
  const Value section = root.require("sensors", expected);
  for (auto& [name, entry] : named_entries(section)) {
    check_entry_name(name, entry);
    Mapping yaml(entry, sensor_keys);
    SensorConfig sensor = read_sensor(name, yaml, config, claims);
    check_distinct(sensor, yaml, config.sensors);
    config.sensors.push_back(std::move(sensor));
  }
  if (config.sensors.empty()) section.fail("is empty", expected);
}

}  // namespace lidard
