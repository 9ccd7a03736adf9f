// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys of `sensors:`.
#include <algorithm>

#include "daemon/config/filter.h"
#include "daemon/config/sensors.h"
#include "drivers/calibration_file.h"

namespace lidard {
namespace {

constexpr double longest_offset_s = 1e6;  // keeps nanoseconds exact in a double
constexpr double last_port = 65535;
constexpr double farthest_return_m = 1000;
constexpr const char* sender_form = "the sensor's IPv4 address like 192.168.1.201";
constexpr const char* group_form = "a multicast address like 239.0.0.10";
constexpr const char* receiver_form =
    "an IPv4 address of this host (or a multicast group) like 192.168.0.100";
constexpr const char* hash_form = "the hash of the password, 8 hexadecimal digits like F4724744";

/// Who has a trait, and what to do with its keys elsewhere.
struct Products {
  Trait trait;
  std::string_view names, instead = "no such key";
};
constexpr std::string_view set_in_device = "no such key; set it up in the device";
constexpr Products products[] = {
    {Trait::packet_messages, "Velodynes"},
    {Trait::revolutions, "Velodynes"},
    {Trait::calibration, "Velodynes"},
    {Trait::web_control, "Velodynes but the HDL-64E"},
    {Trait::gnss, "devices with a satellite receiver"},
    {Trait::datagrams, "devices that stream over UDP"},
    {Trait::settings_writable, "SICK devices with settings", set_in_device},
    {Trait::receiver_settable, "SICK devices that stream over UDP", set_in_device},
    {Trait::logins, "SICK devices with logins", set_in_device},
    {Trait::planar, "planar scanners",
     "no such key; of a Velodyne view_direction and view_width keep a sector"},
    {Trait::scans, "planar scanners and Velodynes"},
    {Trait::echoes, "planar scanners with several echoes"},
    {Trait::output_paths, "SICK safety scanners"},
    {Trait::states_on_request, "SICK safety scanners, SICK scanners that speak CoLa"},
    {Trait::skips, "SICK scanners that speak CoLa, Hokuyos that speak SCIP", set_in_device},
    {Trait::skip_request, "Hokuyos that speak SCIP"},
    {Trait::clock_request, "Hokuyos that speak SCIP",
     "clock: smooth, which follows the device clock all the time"},
    {Trait::multi_plane, "multi-plane lidars"}};

Products products_of(Trait trait) {
  const auto* const found = std::find_if(std::begin(products), std::end(products),
                                         [&](const auto& one) { return one.trait == trait; });
  return found == std::end(products) ? Products{trait, {}} : *found;
}

/// Keys that mean nothing beside packet_topic: another node has the network.
bool is_of_network(const Key& key) {
  constexpr std::string_view names[] = {"ip_address",      "ip_port",   "telemetry_port",
                                        "multicast_group", "interface", "control"};
  return std::find(std::begin(names), std::end(names), key.name) != std::end(names);
}

/// A rejection of what is no IPv4 address, or one of a group where none is wanted, or the other way round.
std::optional<Rejection> no_peer(const KeyValue& value, bool of_group, const char* form) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (!address) return Rejection{"is {}, which is no address", form};
  if (address->v6) return Rejection{"is {}, an IPv6 address, from which nothing is received", form};
  if (address->is_multicast() == of_group) return std::nullopt;
  if (of_group) return Rejection{"is {}, which is no multicast group", form};
  return Rejection{"is {}, a multicast group", std::string(form) + "; the group goes into multicast_group"};
}
std::optional<Rejection> no_sender(const KeyValue& value) { return no_peer(value, false, sender_form); }
std::optional<Rejection> no_group(const KeyValue& value) { return no_peer(value, true, group_form); }

std::optional<Rejection> no_receiver(const KeyValue& value) {
  const auto address = IpAddress::parse(std::get<std::string>(value));
  if (address && !address->v6) return std::nullopt;
  return Rejection{"is {}, which is not an IPv4 address", receiver_form};
}

std::optional<Rejection> no_hash(const KeyValue& value) {
  const auto& text = std::get<std::string>(value);
  if (text.size() == 8 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos)
    return std::nullopt;
  return Rejection{"is not 8 hexadecimal digits", hash_form};
}

KeyValue model_of(const SensorConfig& sensor) {
  return sensor.model == nullptr ? KeyValue() : std::string(sensor.model->name);
}
KeyValue ring_of(const SensorConfig& sensor) {
  return sensor.ring_scan ? KeyValue(static_cast<double>(sensor.ring_scan->ring)) : KeyValue();
}
KeyValue equations_of(const SensorConfig& sensor) {
  const Calibration* const calibration = own_calibration(sensor.driver);
  return calibration == nullptr ? KeyValue() : std::string(name_of(calibration->model));
}

Keys of(Trait trait, Keys keys) {
  for (Key& key : keys) key.trait = trait;
  return keys;
}

/// Where its packets come from.
Keys input_keys(SensorConfig& s) {
  using namespace keys;
  return join(
      {of(Trait::known, {{"model", model_of(s), special("a name from `lidard models`"), "the product",
                          preset("none: then topic is needed")}}),
       of(Trait::packet_messages,
          {{"packet_topic", s.packet_topic, topic, "velodyne_msgs/VelodyneScan in place of the network"},
           {"raw_topic", s.raw_topic, topic, "publishes its packets, as velodyne_msgs/VelodyneScan"}}),
       of(Trait::known,
          {{"ip_address", s.ip_address, text(sender_form, no_sender), "only packets from here are accepted",
            remark("any sender that no other sensor claims")},
           {"ip_port", s.ip_port, whole(1, last_port),
            "local UDP port; of a device that is read over TCP: its own port", preset("of the model")}}),
       of(Trait::gnss,
          {{"telemetry_port", s.telemetry_port, whole(0, last_port),
            "local UDP port of a satellite receiver's sentences; 0: none", preset("of the model")},
           {"expect_pps", s.driver.expect_pps, flag,
            "warns when the sensor's clock does not follow a receiver's PPS and NMEA"}}),
       of(Trait::datagrams,
          {{"multicast_group", s.multicast_group, text(group_form, no_group), "a group to join"}}),
       only_if(s.multicast_group.has_value(),
               of(Trait::datagrams, {{"interface", s.interface, text("the name of a network interface"),
                                      "where the group is joined; empty: the kernel's choice", or_none}})),
       {{"topic", s.topic, topic, "a LaserScan or PointCloud2 of another driver, in place of model"},
        {"frame_id", s.frame_id, frame, "frame of its messages", preset("the sensor's name")},
        {"pose", s.pose, pose, "of the sensor in vehicle.base_frame", remark("from tf")},
        {"time_offset", s.driver.time_offset, number(-longest_offset_s, longest_offset_s, "s"),
         "added to every stamp"}},
       of(Trait::known,
          {{"clock", s.driver.clock, word({{"smooth", ClockMode::smooth}, {"arrival", ClockMode::arrival}}),
            "stamps follow the device clock, or each packet's arrival"},
           {"filter", filter_keys(s.filter),
            "what is left out of its messages; merged and virtual scans see all of it"}})});
}

/// What the device is asked for.
Keys device_keys(SensorConfig& s) {
  using namespace keys;
  return join(
      {of(Trait::settings_writable,
          {{"allow_write", s.driver.requests.allow_write, flag,
            "settings of the device that differ from the configuration are written"}}),
       of(Trait::receiver_settable,
          {{"listen_only", s.driver.requests.listen_only, flag, "no connection to the device at all"},
           {"udp_receiver_ip", s.driver.requests.host_address, text(receiver_form, no_receiver),
            "where the device shall send its datagrams"}}),
       of(Trait::logins, {{"user_level", s.driver.requests.user_level, whole(1, 9),
                           "number of the level to log in at", preset("of the model")},
                          {"user_level_password", s.driver.requests.password_hash, text(hash_form, no_hash),
                           "hash of its password", preset("of the model")}}),
       of(Trait::web_control, {{"control", control_keys(s.control), "the web interface of the sensor",
                                SectionStyle::one_line}})});
}

/// What planar scanners give.
Keys scan_keys(SensorConfig& s) {
  using namespace keys;
  const bool gives_scans = s.ring_scan || (s.model != nullptr && s.model->kind == FrameKind::scan);
  return join(
      {of(Trait::planar,
          {{"angle_min", s.driver.angle_min, angle(-most_turn_rad, most_turn_rad),
            "begin of the sector that is kept, counter-clockwise to angle_max", remark("all beams")},
           {"angle_max", s.driver.angle_max, angle(-most_turn_rad, most_turn_rad),
            "its end; below angle_min: the sector goes through straight behind", remark("all beams")},
           {"publish_intensity", s.driver.publish_intensity, flag, "scans have intensities"}}),
       only_if(gives_scans, of(Trait::scans, {{"scan_topic", s.scan_topic, topic,
                                               "its LaserScan, or that of scan_ring", preset("NAME/scan")},
                                              {"counter_clockwise", s.counter_clockwise, flag,
                                               "a LaserScan of a sensor that turns clockwise begins with the "
                                               "last beam: angle_increment > 0, "
                                               "time_increment < 0"}})),
       of(Trait::echoes,
          {{"publish_multiecho", s.driver.publish_multiecho, flag, "all echoes, on NAME/echoes"}}),
       of(Trait::output_paths,
          {{"extended_scan_topic", s.extended_scan_topic, topic,
            "its scan with the flags of the beams, as sick_safetyscanners/ExtendedLaserScanMsg"},
           {"output_paths_topic", s.output_paths_topic, topic,
            "its output paths, as sick_safetyscanners/OutputPathsMsg in place of NAME/output_paths"}}),
       of(Trait::states_on_request,
          {{"publish_states", s.driver.requests.device_states, flag,
            "its states too, on NAME/lferec, lidinputstate, lidoutputstate, encoder, or system_state, "
            "output_paths, "
            "intrusion, beam_status"}}),
       of(Trait::skips,
          {{"skip", s.driver.requests.skip, whole(0, 999), "scans left out between two; of a Hokuyo 0 to 9",
            remark("as a SICK scanner is set, 0 of a Hokuyo")}}),
       of(Trait::skip_request,
          {{"cluster", s.driver.requests.cluster, whole(1, 99), "beams merged into one", remark({}, 1.0)}}),
       of(Trait::clock_request, {{"calibrate_time", s.driver.requests.calibrate_time, flag,
                                  "compares both clocks once before the stream starts"}})});
}

/// What multi-plane lidars give.
Keys cloud_keys(SensorConfig& s) {
  using namespace keys;
  return join({of(Trait::multi_plane,
                  {{"points_topic", s.points_topic, topic, "its cloud", preset("NAME/points")},
                   {"points_frame", s.points_frame, frame,
                    "the frame that its cloud is published in; empty: frame_id", or_none},
                   {"deskew", s.deskew, flag,
                    "its cloud shows the instant of its stamp; needs the motion of the vehicle"},
                   {"frame_stamp", s.layout.stamp,
                    word({{"first", FrameStamp::first}, {"last", FrameStamp::last}}, "one of first, last"),
                    "the firing that a cloud is stamped with"}}),
               of(Trait::revolutions,
                  {{"cut_angle", s.driver.cut_angle, angle(-two_pi, two_pi),
                    "where a frame ends, as the sensor counts azimuth"},
                   {"min_range", s.driver.min_range, number(0, farthest_return_m, "m"),
                    "nearer returns are left out"},
                   {"max_range", s.driver.max_range, number(0, farthest_return_m, "m"),
                    "farther returns are left out; 0: no limit"},
                   {"view_direction", s.driver.view_direction, angle(-two_pi, two_pi),
                    "middle of the sector that is kept, counter-clockwise from the front"},
                   {"view_width", s.driver.view_width, angle(0, two_pi), "width of that sector"},
                   {"organize_cloud", s.layout.order,
                    word({{"true", CloudOrder::ring_rows},
                          {"false", CloudOrder::list},
                          {"rings", CloudOrder::ring_rows},
                          {"firings", CloudOrder::firing_rows}}),
                    "a list of returns, or organised with a row per ring or per firing sequence"},
                   {"scan_ring", ring_of(s), special("auto, or a ring counted from 0"),
                    "a ring as a LaserScan, 0 the lowest; auto: the level one", remark("no LaserScan")}}),
               only_if(s.ring_scan.has_value(),
                       of(Trait::revolutions, {{"scan_resolution",
                                                KeyValue(s.ring_scan.value_or(RingScanSpec()).resolution),
                                                {KeyKind::angle, 0, 0, "rad", "0.0005 to 0.2 rad"},
                                                "between beams of that scan"}})),
               of(Trait::calibration,
                  {{"calibration", s.calibration,
                    special("a calibration file, relative to the configuration's folder"),
                    "YAML of velodyne_pointcloud or db.xml, relative to the configuration's folder",
                    remark("what the model or the device itself says")},
                   {"calibration_model", equations_of(s), special("ros_drivers, exact or veloview"),
                    "the equations: those of velodyne_pointcloud, the manual or the viewer",
                    preset("that of the file's format")}})});
}

}  // namespace

Keys sensor_keys(SensorConfig& sensor) {
  Keys all = keys::join({input_keys(sensor), device_keys(sensor), scan_keys(sensor), cloud_keys(sensor)});
  for (Key& key : all) key.applies = key.applies && accepts(sensor, key);
  return all;
}

std::string_view products_with(Trait trait) { return products_of(trait).names; }

bool accepts(const SensorConfig& sensor, const Key& key) {
  if (!key.trait) return true;
  const bool has_network = sensor.packet_topic.empty();
  return sensor.model != nullptr && sensor.model->has(*key.trait) && (has_network || !is_of_network(key));
}

Rejection refusal(const SensorConfig& sensor, const Key& key) {
  if (sensor.model == nullptr)
    return {"does not apply to a source with topic:", "topic, frame_id, pose and time_offset only"};
  if (sensor.model->has(*key.trait))
    return {"is given beside packet_topic", "one of them: the network and its sensor are another node's"};
  const Products others = products_of(*key.trait);
  return {
      "is not available for " + std::string(sensor.model->name) + ", only for " + std::string(others.names),
      std::string(others.instead)};
}

}  // namespace lidard
