// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys of `sensors:`.
#include <algorithm>

#include "daemon/config/filter.h"
#include "daemon/config/sensors.h"
#include "drivers/calibration_file.h"

namespace lidard {
namespace {

using S = SensorConfig;
using D = DriverConfig;
using R = DeviceRequests;

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

KeyValue model_of(const S& sensor) {
  return sensor.model == nullptr ? KeyValue() : std::string(sensor.model->name);
}
KeyValue ring_of(const S& sensor) {
  return sensor.ring_scan ? key_value(sensor.ring_scan->ring) : KeyValue();
}
KeyValue resolution_of(const S& sensor) { return sensor.ring_scan.value_or(RingScanSpec()).resolution; }
KeyValue equations_of(const S& sensor) {
  const Calibration* const calibration = own_calibration(sensor.driver);
  return calibration == nullptr ? KeyValue() : std::string(name_of(calibration->model));
}

template <class T>
auto of(T D::*member) {
  return at(&S::driver, member);
}
template <class T>
auto of(T R::*member) {
  return at(&S::driver, &D::requests, member);
}
template <class T>
auto of(T CloudLayout::*member) {
  return at(&S::layout, member);
}

Keys<S> of(Trait trait, Keys<S> keys) {
  for (Key& key : keys) key.trait = trait;
  return keys;
}

/// Where its packets come from.
Keys<S> input_keys() {
  using namespace keys;
  return {
      of(Trait::known, {{"model", model_of, special("a name from `lidard models`"), "the product",
                         preset("none: then topic is needed")}}),
      of(Trait::packet_messages,
         {{"packet_topic", &S::packet_topic, topic, "velodyne_msgs/VelodyneScan in place of the network"},
          {"raw_topic", &S::raw_topic, topic, "publishes its packets, as velodyne_msgs/VelodyneScan"}}),
      of(Trait::known,
         {{"ip_address", &S::ip_address, text(sender_form, no_sender), "only packets from here are accepted",
           remark("any sender that no other sensor claims")},
          {"ip_port", &S::ip_port, whole(1, last_port),
           "local UDP port; of a device that is read over TCP: its own port", preset("of the model")}}),
      of(Trait::gnss,
         {{"telemetry_port", &S::telemetry_port, whole(0, last_port),
           "local UDP port of a satellite receiver's sentences; 0: none", preset("of the model")},
          {"expect_pps", of(&D::expect_pps), flag,
           "warns when the sensor's clock does not follow a receiver's PPS and NMEA"}}),
      of(Trait::datagrams,
         {{"multicast_group", &S::multicast_group, text(group_form, no_group), "a group to join"},
          {"interface", &S::interface, text("the name of a network interface"),
           "where the group is joined; empty: the kernel's choice", or_none}}),
      Keys<S>{{"topic", &S::topic, topic, "a LaserScan or PointCloud2 of another driver, in place of model"},
              {"frame_id", &S::frame_id, frame, "frame of its messages", preset("the sensor's name")},
              {"pose", &S::pose, pose, "of the sensor in vehicle.base_frame", remark("from tf")},
              {"time_offset", of(&D::time_offset), number(-longest_offset_s, longest_offset_s, "s"),
               "added to every stamp"}},
      of(Trait::known,
         {{"clock", of(&D::clock), word({{"smooth", ClockMode::smooth}, {"arrival", ClockMode::arrival}}),
           "stamps follow the device clock, or each packet's arrival"},
          {"filter", &S::filter, filter_keys(),
           "what is left out of its messages; merged and virtual scans see all of it"}})};
}

/// What the device is asked for.
Keys<S> device_keys() {
  using namespace keys;
  return {of(Trait::settings_writable,
             {{"allow_write", of(&R::allow_write), flag,
               "settings of the device that differ from the configuration are written"}}),
          of(Trait::receiver_settable,
             {{"listen_only", of(&R::listen_only), flag, "no connection to the device at all"},
              {"udp_receiver_ip", of(&R::host_address), text(receiver_form, no_receiver),
               "where the device shall send its datagrams"}}),
          of(Trait::logins, {{"user_level", of(&R::user_level), whole(1, 9),
                              "number of the level to log in at", preset("of the model")},
                             {"user_level_password", of(&R::password_hash), text(hash_form, no_hash),
                              "hash of its password", preset("of the model")}}),
          of(Trait::web_control, {{"control", &S::control, control_keys(), "the web interface of the sensor",
                                   SectionStyle::one_line}})};
}

/// What planar scanners give.
Keys<S> scan_keys() {
  using namespace keys;
  return {
      of(Trait::planar,
         {{"angle_min", of(&D::angle_min), angle(-most_turn_rad, most_turn_rad),
           "begin of the sector that is kept, counter-clockwise to angle_max", remark("all beams")},
          {"angle_max", of(&D::angle_max), angle(-most_turn_rad, most_turn_rad),
           "its end; below angle_min: the sector goes through straight behind", remark("all beams")},
          {"publish_intensity", of(&D::publish_intensity), flag, "scans have intensities"}}),
      of(Trait::scans,
         {{"scan_topic", &S::scan_topic, topic, "its LaserScan, or that of scan_ring", preset("NAME/scan")},
          {"counter_clockwise", &S::counter_clockwise, flag,
           "a LaserScan of a sensor that turns clockwise begins with the last beam: angle_increment > 0, "
           "time_increment < 0"}}),
      of(Trait::echoes,
         {{"publish_multiecho", of(&D::publish_multiecho), flag, "all echoes, on NAME/echoes"}}),
      of(Trait::output_paths,
         {{"extended_scan_topic", &S::extended_scan_topic, topic,
           "its scan with the flags of the beams, as sick_safetyscanners/ExtendedLaserScanMsg"},
          {"output_paths_topic", &S::output_paths_topic, topic,
           "its output paths, as sick_safetyscanners/OutputPathsMsg in place of NAME/output_paths"}}),
      of(Trait::states_on_request,
         {{"publish_states", of(&R::device_states), flag,
           "its states too, on NAME/lferec, lidinputstate, lidoutputstate, encoder, or system_state, "
           "output_paths, intrusion, beam_status"}}),
      of(Trait::skips,
         {{"skip", of(&R::skip), whole(0, 999), "scans left out between two; of a Hokuyo 0 to 9",
           remark("as a SICK scanner is set, 0 of a Hokuyo")}}),
      of(Trait::skip_request,
         {{"cluster", of(&R::cluster), whole(1, 99), "beams merged into one", remark({}, 1.0)}}),
      of(Trait::clock_request, {{"calibrate_time", of(&R::calibrate_time), flag,
                                 "compares both clocks once before the stream starts"}})};
}

/// What multi-plane lidars give.
Keys<S> cloud_keys() {
  using namespace keys;
  return {
      of(Trait::multi_plane,
         {{"points_topic", &S::points_topic, topic, "its cloud", preset("NAME/points")},
          {"points_frame", &S::points_frame, frame,
           "the frame that its cloud is published in; empty: frame_id", or_none},
          {"deskew", &S::deskew, flag,
           "its cloud shows the instant of its stamp; needs the motion of the vehicle"},
          {"frame_stamp", of(&CloudLayout::stamp),
           word({{"first", FrameStamp::first}, {"last", FrameStamp::last}}, "one of first, last"),
           "the firing that a cloud is stamped with"}}),
      of(Trait::revolutions,
         {{"cut_angle", of(&D::cut_angle), angle(-two_pi, two_pi),
           "where a frame ends, as the sensor counts azimuth"},
          {"min_range", of(&D::min_range), number(0, farthest_return_m, "m"), "nearer returns are left out"},
          {"max_range", of(&D::max_range), number(0, farthest_return_m, "m"),
           "farther returns are left out; 0: no limit"},
          {"view_direction", of(&D::view_direction), angle(-two_pi, two_pi),
           "middle of the sector that is kept, counter-clockwise from the front"},
          {"view_width", of(&D::view_width), angle(0, two_pi), "width of that sector"},
          {"organize_cloud", of(&CloudLayout::order),
           word({{"true", CloudOrder::ring_rows},
                 {"false", CloudOrder::list},
                 {"rings", CloudOrder::ring_rows},
                 {"firings", CloudOrder::firing_rows}}),
           "a list of returns, or organised with a row per ring or per firing sequence"},
          {"scan_ring", ring_of, special("auto, or a ring counted from 0"),
           "a ring as a LaserScan, 0 the lowest; auto: the level one", remark("no LaserScan")},
          {"scan_resolution",
           resolution_of,
           {KeyKind::angle, 0, 0, "rad", "0.0005 to 0.2 rad"},
           "between beams of that scan"}}),
      of(Trait::calibration,
         {{"calibration", &S::calibration,
           special("a calibration file, relative to the configuration's folder"),
           "YAML of velodyne_pointcloud or db.xml, relative to the configuration's folder",
           remark("what the model or the device itself says")},
          {"calibration_model", equations_of, special("ros_drivers, exact or veloview"),
           "the equations: those of velodyne_pointcloud, the manual or the viewer",
           preset("that of the file's format")}})};
}

}  // namespace

const Keys<S>& sensor_keys() {
  static const Keys<S> rows{input_keys(), device_keys(), scan_keys(), cloud_keys()};
  return rows;
}

std::string_view products_with(Trait trait) { return products_of(trait).names; }

bool accepts(const S& sensor, const Key& key) {
  if (!key.trait) return true;
  const bool has_network = sensor.packet_topic.empty();
  return sensor.model != nullptr && sensor.model->has(*key.trait) && (has_network || !is_of_network(key));
}

Rejection refusal(const S& sensor, const Key& key) {
  if (sensor.model == nullptr)
    return {"does not apply to a source with topic:", "topic, frame_id, pose and time_offset only"};
  if (sensor.model->has(*key.trait))
    return {"is given beside packet_topic", "one of them: the network and its sensor are another node's"};
  const Products others = products_of(*key.trait);
  return {
      "is not available for " + std::string(sensor.model->name) + ", only for " + std::string(others.names),
      std::string(others.instead)};
}

bool applies(const Key& key, const S& sensor) {
  if (!accepts(sensor, key)) return false;
  if (key.name == "interface") return sensor.multicast_group.has_value();
  if (key.name == "scan_resolution") return sensor.ring_scan.has_value();
  if (key.name == "scan_topic" || key.name == "counter_clockwise")
    return sensor.ring_scan || sensor.model->kind == FrameKind::scan;
  return applies(key, sensor.filter);
}

}  // namespace lidard
