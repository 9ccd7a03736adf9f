// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys of `sensors:`, grouped by the required traits of the model.
#include "daemon/config/calibration_file.h"
#include "daemon/config/sections.h"
#include "drivers/driver_keys.h"

namespace lidard {
namespace {

using namespace keys;
using S = SensorConfig;
using Rows = Keys<S>;

constexpr double longest_offset_s = 1e6;  // keeps nanoseconds exact in a double
constexpr double last_port = 65535;
constexpr const char* sender_form = "the sensor's IPv4 address like 192.168.1.201";
constexpr const char* group_form = "a multicast address like 239.0.0.10";

/// What to do with a key that the model does not have.
constexpr std::string_view set_in_device = "no such key; set it up in the device";
constexpr std::string_view by_sector =
    "no such key; of a Velodyne view_direction and view_width keep a sector";
constexpr std::string_view by_clock = "clock: smooth, which follows the device clock all the time";

bool any_model(const Model& /*model*/) { return true; }
template <FrameKind kind>
bool gives(const Model& model) {
  return model.kind == kind;
}
template <Trait trait>
bool can(const Model& model) {
  return model.has(trait);
}

bool gives_scans(const Model& model) {
  return model.kind == FrameKind::scan || model.has(Trait::revolutions);
}
bool can_skip(const Model& model) { return model.has(Trait::skip_setting) || model.has(Trait::skip_request); }

/// True for SICK's safety scanners.
bool has_output_paths(const Model& model) {
  return std::any_of(model.messages.begin(), model.messages.end(),
                     [](const MessageTopic& message) { return message.name == output_paths_topic; });
}

Rows of_driver(const Keys<DriverConfig>& keys) { return within(&S::driver, keys); }
Rows of_requests(const Keys<DeviceRequests>& keys) {
  return of_driver(within(&DriverConfig::requests, keys));
}

std::optional<Rejection> no_sender(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (!address) return Rejection{"is {}, which is no address", sender_form};
  if (address->v6) return Rejection{"is {}, an IPv6 address, from which nothing is received", sender_form};
  if (!address->is_multicast()) return std::nullopt;
  return Rejection{"is {}, a multicast group",
                   std::string(sender_form) + "; the group goes into multicast_group"};
}

std::optional<Rejection> no_group(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (!address) return Rejection{"is {}, which is no address", group_form};
  if (address->v6) return Rejection{"is {}, an IPv6 address, from which nothing is received", group_form};
  if (address->is_multicast()) return std::nullopt;
  return Rejection{"is {}, which is no multicast group", group_form};
}

KeyOf<S> model_row() {
  return special<S>(
             "model", "a name from `lidard models`",
             [](const S& sensor) {
               return sensor.model == nullptr ? KeyValue() : std::string(sensor.model->name);
             },
             "the product")
      .by_default("none: then topic is needed");
}

Rows network_rows() {
  return {text("ip_address", &S::ip_address, sender_form, "only packets from here are accepted")
              .unless_set("any sender that no other sensor claims")
              .checked(no_sender),
          whole("ip_port", &S::ip_port, 1, last_port,
                "local UDP port; of a device that is read over TCP: its own port")
              .by_default("of the model")};
}

Rows group_rows() {
  return {text("multicast_group", &S::multicast_group, group_form, "a group to join").checked(no_group),
          text("interface", &S::interface, "the name of a network interface",
               "where the group is joined; empty: the kernel's choice")
              .or_empty()
              .shown_if([](const S& sensor) { return sensor.multicast_group.has_value(); })};
}

Rows place_rows() {
  return {
      topic("topic", &S::topic, "a LaserScan or PointCloud2 of another driver, in place of model"),
      frame("frame_id", &S::frame_id, "frame of its messages").by_default("the sensor's name"),
      of_kind(KeyKind::pose, "pose", &S::pose, "of the sensor in vehicle.base_frame").unless_set("from tf")};
}

Keys<DriverConfig> time_rows() {
  return {number("time_offset", &DriverConfig::time_offset, -longest_offset_s, longest_offset_s, "s",
                 "added to every stamp")};
}

Keys<DriverConfig> clock_rows() {
  return {word("clock", &DriverConfig::clock,
               {{"smooth", ClockMode::smooth}, {"arrival", ClockMode::arrival}},
               "stamps follow the device clock, or each packet's arrival")};
}

Rows control_rows() {
  return {section("control", within(&S::control, control_keys()), "the web interface of the sensor")
              .in_one_line()};
}

Keys<DriverConfig> planar_rows() {
  using D = DriverConfig;
  return {angle("angle_min", &D::angle_min, -most_turn_rad, most_turn_rad,
                "begin of the sector that is kept, counter-clockwise to angle_max")
              .unless_set("all beams"),
          angle("angle_max", &D::angle_max, -most_turn_rad, most_turn_rad,
                "its end; below angle_min: the sector goes through straight behind")
              .unless_set("all beams"),
          flag("publish_intensity", &D::publish_intensity, "scans have intensities")};
}

Rows scan_topic_rows() {
  const auto has_scan = [](const S& sensor) {
    return sensor.ring_scan || sensor.model->kind == FrameKind::scan;
  };
  return {topic("scan_topic", &S::scan_topic, "its LaserScan, or that of scan_ring")
              .by_default("NAME/scan")
              .shown_if(has_scan),
          flag("counter_clockwise", &S::counter_clockwise,
               "a LaserScan of a sensor that turns clockwise begins with the last beam: angle_increment > 0, "
               "time_increment < 0")
              .shown_if(has_scan)};
}

Keys<DriverConfig> echo_rows() {
  return {flag("publish_multiecho", &DriverConfig::publish_multiecho, "all echoes, on NAME/echoes")};
}

Rows cloud_rows() {
  const Keys<CloudLayout> stamp{word("frame_stamp", &CloudLayout::stamp,
                                     {{"first", FrameStamp::first}, {"last", FrameStamp::last}},
                                     "the firing that a cloud is stamped with")
                                    .of_form("one of first, last")};
  return joined<S>(
      {{topic("points_topic", &S::points_topic, "its cloud").by_default("NAME/points"),
        frame("points_frame", &S::points_frame, "the frame that its cloud is published in; empty: frame_id")
            .or_empty(),
        flag("deskew", &S::deskew,
             "its cloud shows the instant of its stamp; needs the motion of the vehicle")},
       within(&S::layout, stamp)});
}

Keys<CloudLayout> order_rows() {
  const Words<CloudOrder> orders{{"true", CloudOrder::ring_rows},
                                 {"false", CloudOrder::list},
                                 {"rings", CloudOrder::ring_rows},
                                 {"firings", CloudOrder::firing_rows}};
  return {word("organize_cloud", &CloudLayout::order, orders,
               "a list of returns, or organised with a row per ring or per firing sequence")};
}

/// The section reads these keys, since it knows the rings of the model.
Rows ring_rows() {
  const auto has_ring = [](const S& sensor) { return sensor.ring_scan.has_value(); };
  return {
      special<S>(
          "scan_ring", "auto, or a ring counted from 0",
          [](const S& sensor) { return sensor.ring_scan ? key_value(sensor.ring_scan->ring) : KeyValue(); },
          "a ring as a LaserScan, 0 the lowest; auto: the level one")
          .unless_set("no LaserScan"),
      special<S>(
          "scan_resolution", "0.0005 to 0.2 rad",
          [](const S& sensor) { return key_value(sensor.ring_scan.value_or(RingScanSpec()).resolution); },
          "between beams of that scan")
          .as_angle()
          .shown_if(has_ring)};
}

Rows packet_rows() {
  return {topic("packet_topic", &S::packet_topic, "velodyne_msgs/VelodyneScan in place of the network"),
          topic("raw_topic", &S::raw_topic, "publishes its packets, as velodyne_msgs/VelodyneScan")};
}

Rows safety_topic_rows() {
  return {topic("extended_scan_topic", &S::extended_scan_topic,
                "its scan with the flags of the beams, as sick_safetyscanners/ExtendedLaserScanMsg"),
          topic("output_paths_topic", &S::output_paths_topic,
                "its output paths, as sick_safetyscanners/OutputPathsMsg in place of NAME/output_paths")};
}

Rows calibration_rows() {
  return {special<S>(
              "calibration", "a calibration file, relative to the configuration's folder",
              [](const S& sensor) { return key_value(sensor.calibration); },
              "YAML of velodyne_pointcloud or db.xml, relative to the configuration's folder")
              .unless_set("what the model or the device itself says"),
          special<S>(
              "calibration_model", "ros_drivers, exact or veloview",
              [](const S& sensor) {
                return sensor.driver.calibration == nullptr
                           ? KeyValue()
                           : std::string(name_of(sensor.driver.calibration->model));
              },
              "the equations: those of velodyne_pointcloud, the manual or the viewer")
              .by_default("that of the file's format")};
}

}  // namespace

bool takes(const S& sensor, const SensorGroup& group) {
  if (group.takes == nullptr) return true;
  if (sensor.model == nullptr || (group.network && !sensor.packet_topic.empty())) return false;
  return group.takes(*sensor.model);
}

const std::vector<SensorGroup>& sensor_groups() {
  const auto udp = [](const Model& model) { return model.transport == Transport::udp; };
  const auto echoes = [](const Model& model) {
    return model.has(Trait::echoes) && model.kind == FrameKind::scan;
  };
  static const std::vector<SensorGroup> groups{
      {"", any_model, false, {model_row()}},
      {"Velodynes", can<Trait::packet_messages>, false, packet_rows()},
      {"", any_model, true, network_rows()},
      {"devices with a satellite receiver",
       can<Trait::gnss>,
       true,
       {whole("telemetry_port", &S::telemetry_port, 0, last_port,
              "local UDP port of a satellite receiver's sentences; 0: none")
            .by_default("of the model")}},
      {"devices with a satellite receiver", can<Trait::gnss>, false, of_driver(receiver_clock_keys())},
      {"devices that stream over UDP", udp, true, group_rows()},
      {"", nullptr, false, joined<S>({place_rows(), of_driver(time_rows())})},
      {"", any_model, false, of_driver(clock_rows())},
      {"", any_model, false, filter_rows()},
      {"SICK devices with settings", can<Trait::settings_writable>, false, of_requests(write_keys()),
       set_in_device},
      {"SICK devices that stream over UDP", can<Trait::receiver_settable>, false,
       of_requests(receiver_keys()), set_in_device},
      {"SICK devices with logins", can<Trait::logins>, false, of_requests(login_keys()), set_in_device},
      {"Velodynes but the HDL-64E", can<Trait::web_control>, true, control_rows()},
      {"planar scanners", gives<FrameKind::scan>, false, of_driver(planar_rows()), by_sector},
      {"planar scanners and Velodynes", gives_scans, false, scan_topic_rows()},
      {"planar scanners with several echoes", echoes, false, of_driver(echo_rows())},
      {"SICK safety scanners", has_output_paths, false, safety_topic_rows()},
      {"SICK safety scanners, SICK scanners that speak CoLa", can<Trait::states_on_request>, false,
       of_requests(state_keys())},
      {"SICK scanners that speak CoLa, Hokuyos that speak SCIP", can_skip, false, of_requests(skip_keys()),
       set_in_device},
      {"Hokuyos that speak SCIP", can<Trait::skip_request>, false, of_requests(scip_keys())},
      {"Hokuyos that speak SCIP", can<Trait::skip_request>, false, of_requests(scip_clock_keys()), by_clock},
      {"multi-plane lidars", gives<FrameKind::cloud>, false, cloud_rows()},
      {"Velodynes", can<Trait::revolutions>, false,
       joined<S>({of_driver(revolution_keys()), within(&S::layout, order_rows())})},
      {"Velodynes", can<Trait::revolutions>, false, ring_rows()},
      {"Velodynes", can<Trait::calibration>, false, calibration_rows()}};
  return groups;
}

}  // namespace lidard
