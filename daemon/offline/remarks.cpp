// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/remarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/evidence/beam_rays.h"
#include "daemon/yaml/yaml.h"
#include "drivers/calibration.h"
#include "drivers/document.h"
#include "drivers/net/host_network.h"

namespace lidard {
namespace {

constexpr double near_vehicle_m = 20;

/// The remarks about one configuration, each at a key.
struct Remarks {
  const Config& config;
  Value root = parse_yaml(config.text, config.file);
  std::vector<std::pair<Value, std::string>> all{};

  void add(const Value& key, const std::string& sentence) { all.emplace_back(key, sentence); }
  /// In the order of the file, behind `sentences`.
  std::vector<std::string> sorted(std::vector<std::string> sentences = {}) {
    const auto line = [](const auto& one) {
      return std::pair(one.first.key_location().line, one.first.key_location().column);
    };
    std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return line(a) < line(b); });
    for (const auto& [key, sentence] : all)
      sentences.push_back(key.key_location().to_string() + ": " + key.path() + " " + sentence);
    return sentences;
  }

  Value entry(const char* section, const std::string& name) const {
    return value_at(value_at(root, section), name);
  }
  Value key(const char* section, const std::string& name, const char* key_of_it) const {
    return value_at(entry(section, name), key_of_it);
  }
};

/// m from a point to a footprint; 0: inside, or there is none.
double distance_to(const std::vector<Eigen::Vector2d>& footprint, const Eigen::Vector2d& point) {
  if (footprint.empty() || Footprint(footprint).contains(point)) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    const Eigen::Vector2d &begin = footprint[i], &end = footprint[(i + 1) % footprint.size()];
    const double along = (point - begin).dot(end - begin) / (end - begin).squaredNorm();
    least = std::min(least, (begin + std::clamp(along, 0.0, 1.0) * (end - begin) - point).norm());
  }
  return least;
}

double outside(const Config& config, const Eigen::Vector3d& at) {
  return distance_to(config.vehicle.footprint, at.head<2>());
}

Eigen::Vector2d extent_of(const Config& config) {
  Eigen::AlignedBox2d box(Eigen::Vector2d::Zero());
  for (const Eigen::Vector2d& vertex : config.vehicle.footprint) box.extend(vertex);
  return box.sizes();
}

/// True for a footprint wider than long in which all sensors lie once x and y are exchanged.
bool is_swapped(const Config& config) {
  constexpr double beside_m = 0.2;
  const Eigen::Vector2d size = extent_of(config);
  std::vector<Eigen::Vector2d> swapped;
  for (const Eigen::Vector2d& vertex : config.vehicle.footprint) swapped.emplace_back(vertex.y(), vertex.x());
  bool is_any_outside = false;
  for (const SensorConfig& sensor : config.sensors) {
    if (!sensor.pose) continue;
    const Eigen::Vector3d at = sensor.pose->translation();
    if (distance_to(swapped, at.head<2>()) > beside_m) return false;
    is_any_outside |= outside(config, at) > beside_m;
  }
  return is_any_outside && size.y() > size.x();
}

void question_footprint(Remarks& remarks) {
  constexpr double longest_m = 60;
  const double length = extent_of(remarks.config).maxCoeff();
  const Value key = value_at(value_at(remarks.root, "vehicle"), "footprint");
  if (is_swapped(remarks.config))
    remarks.add(key,
                "is wider than long, and sensors stand outside of it: are x (ahead) and y (left) swapped?");
  if (length > longest_m)
    remarks.add(key, fmt::format("is {:.0f} m long; are its numbers in m, and not in cm or mm?", length));
}

/// `at`: in base_frame; `lowest` and `farthest_outside`: limits, m.
void question_position(Remarks& remarks, const Value& entry, const std::string& key,
                       const Eigen::Vector3d& at, double lowest, double farthest_outside) {
  const Value pose = value_at(entry, key);
  if (pose.path() == entry.path()) return;
  const double distance = outside(remarks.config, at);
  if (at.norm() > near_vehicle_m)
    remarks.add(pose, fmt::format("is {:.0f} m away; are its numbers in m, and not in mm?", at.norm()));
  else if (at.z() < lowest)
    remarks.add(pose, fmt::format("is {:.2f} m below {}; z counts upwards: is its sign right?", -at.z(),
                                  remarks.config.vehicle.base_frame));
  else if (distance > farthest_outside && !is_swapped(remarks.config))
    remarks.add(pose, fmt::format("is {:.1f} m outside of vehicle.footprint; correct one of them", distance));
}

void question_positions(Remarks& remarks) {
  // base_frame may lie above the ground, at an axle; base_footprint lies there.
  constexpr double lowest = -0.3;
  const Config& config = remarks.config;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.pose)
      question_position(remarks, remarks.entry("sensors", sensor.name), "pose", sensor.pose->translation(),
                        lowest, 2);
  }
  const auto question_destination = [&](const char* section, const auto& merged) {
    if (merged.destination_pose)
      question_position(remarks, remarks.entry(section, merged.name), "destination_pose",
                        merged.destination_pose->translation(), -near_vehicle_m, near_vehicle_m);
  };
  for (const MergedScanConfig& merged : config.merged_scans) question_destination("merged_scans", merged);
  for (const MergedCloudConfig& merged : config.merged_clouds) question_destination("merged_clouds", merged);
  for (const VirtualScanConfig& group : config.virtual_scans) {
    std::optional<Pose> base;
    if (group.base_frame == config.vehicle.base_frame) base = Pose::Identity();
    for (const SensorConfig& sensor : config.sensors) {
      if (!base && sensor.frame_id == group.base_frame) base = sensor.pose;
    }
    const Value poses = remarks.key("virtual_scans", group.name, "poses");
    for (const auto& [frame, pose] : group.poses) {
      if (base) question_position(remarks, poses, frame, *base * pose.translation(), lowest, 10);
    }
  }
}

void question_twins(Remarks& remarks) {
  constexpr double same_m = 0.001;
  const Config& config = remarks.config;
  // A configuration that `inspect` wrote has all sensors at the origin.
  const bool is_new = config.merged_scans.empty() && config.merged_clouds.empty();
  for (auto one = config.sensors.begin(); one != config.sensors.end(); ++one) {
    for (auto other = config.sensors.begin(); other != one; ++other) {
      // Another driver may publish one device on several topics.
      if (one->model == nullptr || other->model == nullptr) continue;
      const Value entry = remarks.entry("sensors", one->name);
      const bool is_twin =
          one->pose && other->pose && (one->pose->matrix() - other->pose->matrix()).norm() < same_m;
      if (one->frame_id == other->frame_id)
        remarks.add(value_at(entry, "frame_id"), "has the frame of sensors." + other->name + ", " +
                                                     one->frame_id + ": give each sensor a frame of its own");
      else if (is_twin && !(is_new && one->pose->matrix().isIdentity()))
        remarks.add(value_at(entry, "pose"),
                    "is that of sensors." + other->name + " too: give each sensor the pose where it stands");
    }
  }
}

bool uses(const std::vector<std::string>& sources, const SensorConfig& sensor) {
  return std::find(sources.begin(), sources.end(), sensor.name) != sources.end();
}

/// A tilted scanner meets the ground. One whose plane stands measures profiles, unless it is merged.
void question_tilt(Remarks& remarks) {
  constexpr double least_deg = 5, standing_deg = 60;
  for (const SensorConfig& sensor : remarks.config.sensors) {
    const bool is_scanner = sensor.model != nullptr && sensor.model->kind == FrameKind::scan;
    if (!is_scanner || !sensor.pose) continue;
    const double up = std::abs(sensor.pose->linear()(2, 2));
    const double tilt_deg = std::acos(std::min(up, 1.0)) * deg_per_rad;
    bool is_meant = tilt_deg < least_deg || tilt_deg > standing_deg;
    for (const MergedScanConfig& merged : remarks.config.merged_scans) {
      if (uses(merged.laserscan_topics, sensor))
        is_meant = tilt_deg < least_deg || merged.output.min_height.has_value();
    }
    if (!is_meant)
      remarks.add(
          remarks.key("sensors", sensor.name, "pose"),
          fmt::format(
              "tilts a planar scanner by {:.0f} deg: correct roll and pitch, or merge it with min_height",
              tilt_deg));
  }
}

/// A beam is free where one scanner sees it: what stands at the height of another one may be lower or higher.
void question_heights(Remarks& remarks) {
  constexpr double one_height = 0.2;  // m
  for (const MergedScanConfig& merged : remarks.config.merged_scans) {
    if (!merged.has_visibility() || !merged.free_requires.empty()) continue;
    Eigen::AlignedBox1d heights;
    for (const SensorConfig& sensor : remarks.config.sensors) {
      if (sensor.pose && uses(merged.laserscan_topics, sensor))
        heights.extend(Eigen::Matrix<double, 1, 1>(sensor.pose->translation().z()));
    }
    if (heights.isEmpty() || heights.sizes()[0] <= one_height) continue;
    remarks.add(
        remarks.key("merged_scans", merged.name, "laserscan_topics"),
        fmt::format("merges scanners {:.2f} to {:.2f} m high: a beam is free where one of them sees its "
                    "way, whatever stands lower or higher; name those that must see it in free_requires",
                    heights.min()[0], heights.max()[0]));
  }
}

/// Checks that a scanner sees most of a sector between angle_min and angle_max.
void question_sector(Remarks& remarks, const Value& entry, const SensorConfig* sensor, const Sector& sector) {
  if (sensor == nullptr || sensor->model == nullptr || sensor->model->kind != FrameKind::scan) return;
  const double end = sensor->model->field.width() / 2;
  if (end <= 0 || sector.is_line()) return;
  int kept = 0, left_out = 0, wanted = 0;  // degrees
  for (int deg = -180; deg < 180; ++deg) {
    const double middle = (deg + 0.5) * rad_per_deg;
    const bool is_wanted = sector.holds(middle), is_seen = std::abs(middle) <= end;
    wanted += is_wanted ? 1 : 0;
    if (is_seen) ++(is_wanted ? kept : left_out);
  }
  if (left_out == 0 || kept > 0.75 * wanted) return;
  remarks.add(
      value_at(entry, "angle_min"),
      fmt::format(
          "begins a sector of {} deg, of which only {} are in the view of the scanner, {:.1f} to {:.1f} deg",
          wanted, kept, -end * deg_per_rad, end * deg_per_rad));
}

void question_windows(Remarks& remarks) {
  for (const SensorConfig& sensor : remarks.config.sensors)
    question_sector(remarks, remarks.entry("sensors", sensor.name), &sensor, sensor.driver.sector());
  for (const MergedScanConfig& merged : remarks.config.merged_scans) {
    const Value settings = remarks.key("merged_scans", merged.name, "source_settings");
    for (const auto& [source, own] : merged.source_settings)
      question_sector(remarks, value_at(settings, source), remarks.config.find_sensor(source),
                      sector_between(own.angle_min, own.angle_max));
  }
}

/// Values above `most` are possible, but no sensible configuration has them.
struct UnitQuestion {
  std::string_view key;
  double most;
  const char *unit, *mistaken;
};
constexpr UnitQuestion unit_questions[] = {
    {"angle_increment", 0.1, "rad", "degrees (angle_increment_deg)"},
    {"deadline", 5, "s", "ms"},
    {"lost_after", 120, "s", "ms"},
    {"max_range", 1000, "m", "mm"},
    {"min_range", near_vehicle_m, "m", "cm or mm"},
    {"outlier_radius", 5, "m", "cm or mm"},
    {"range_max", 1000, "m", "mm"},
    {"range_min", near_vehicle_m, "m", "cm or mm"},
    {"range_noise", 0.3, "m", "cm or mm"},
    {"scan_time", 10, "s", "ms"},
    {"time_increment", 0.1, "s", "ms"},
    {"time_offset", 1, "s", "ms"},
    {"tolerance", 2, "m", "cm or mm"},
    {"voxel_size", 3, "m", "cm or mm"},
};

/// Offsets of whole hours, and of GPS and atomic time (TAI) to UTC.
bool is_time_scale(double s) { return std::remainder(s, 3600) == 0 || s == 18 || s == 19 || s == 37; }

/// True for multiples of pi/4, with two digits or more.
bool looks_like_rad(double angle) {
  const bool is_long = std::abs(std::remainder(angle, 0.1)) > 1e-6;
  return is_long && std::abs(angle) > 0.5 && std::abs(std::remainder(angle, pi_d / 4)) < 0.005;
}

void question_units(Remarks& remarks, const std::string& name, const Value& value) {
  std::vector<double> numbers;
  for (const Value& one : value.is_list() ? value.items({}) : std::vector<Value>{value})
    numbers.push_back(one.as_number().value_or(0));
  const auto is_small = [](double angle) { return std::abs(angle) < two_pi + 0.01; };
  const std::size_t unit = name.rfind("_deg");
  if (unit != std::string::npos && std::all_of(numbers.begin(), numbers.end(), is_small) &&
      std::any_of(numbers.begin(), numbers.end(), looks_like_rad))
    remarks.add(value, "looks like rad and is taken as degrees; in rad the key is " + name.substr(0, unit));
  for (const UnitQuestion& one : unit_questions) {
    if (one.key != name || numbers.size() != 1 || std::abs(numbers[0]) <= one.most) continue;
    if (name == "time_offset" && is_time_scale(std::abs(numbers[0]))) continue;
    remarks.add(value, fmt::format("is {} {}; is it meant in {}?", numbers[0], one.unit, one.mistaken));
  }
}

void question_units(Remarks& remarks, const Value& section, int depth = 0) {
  constexpr int deepest = 5;
  if (!section.is_map() || depth > deepest) return;
  for (const auto& [name, value] : section.entries()) {
    if (!value.is_map()) question_units(remarks, name, value);
    question_units(remarks, value, depth + 1);
  }
}

/// Frames per second that the sensor sends at most; 0: not known.
double highest_rate(const SensorConfig* sensor) {
  if (sensor == nullptr || sensor->model == nullptr || sensor->model->frame_period <= 0) return 0;
  // A Velodyne turns at 5 to 20 Hz, other devices can be set too.
  const double settable =
      sensor->model->has(Trait::revolutions) || sensor->model->has(Trait::skip_setting) ? 2 : 1;
  return settable / sensor->model->frame_period / (1 + sensor->driver.requests.skip.value_or(0));
}

void question_rate(Remarks& remarks, const Value& entry, const ScheduleSettings& schedule,
                   const std::vector<std::string>& sources) {
  double most = 0;
  for (const std::string& source : sources) {
    const double own = highest_rate(remarks.config.find_sensor(source));
    if (own == 0) return;
    most += own;
  }
  if (schedule.policy == Policy::rate && schedule.rate > most * 1.01)
    remarks.add(value_at(entry, "rate"),
                fmt::format("is {} per s, and its sources send {:.3g} sweeps per s at most; set it lower",
                            schedule.rate, most));
}

void question_rates(Remarks& remarks) {
  for (const auto& one : remarks.config.merged_scans)
    question_rate(remarks, remarks.entry("merged_scans", one.name), one.schedule, one.laserscan_topics);
  for (const auto& one : remarks.config.merged_clouds)
    question_rate(remarks, remarks.entry("merged_clouds", one.name), one.schedule, one.sources);
}

bool is_own(const IpAddress& address) {
  const auto all = read_network().interfaces;
  return std::any_of(all.begin(), all.end(), [&](const auto& one) { return one.address == address; });
}

/// True if packets of the sensor come over the network of this host.
bool has_network(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.packet_topic.empty();
}

void question_addresses(Remarks& remarks) {
  const IpAddress nobody = IpAddress::v4(0, 0, 0, 0), everybody = IpAddress::v4(255, 255, 255, 255);
  for (const SensorConfig& sensor : remarks.config.sensors) {
    if (has_network(sensor) && (sensor.ip_address == nobody || sensor.ip_address == everybody))
      remarks.add(
          remarks.key("sensors", sensor.name, "ip_address"),
          "is " + sensor.ip_address->to_string() + ", the address of no device; set that of the sensor");
  }
}

/// Remarks on what the host does not have, or does not allow.
void question_host(Remarks& remarks, const SensorConfig& sensor) {
  constexpr int first_free_port = 1024;
  const auto& receiver = sensor.driver.requests.host_address;
  if (receiver && *receiver != IpAddress::v4(0, 0, 0, 0) && !receiver->is_multicast() && !is_own(*receiver))
    remarks.add(
        remarks.key("sensors", sensor.name, "udp_receiver_ip"),
        "is " + receiver->to_string() + ", which is no address of this host; `ip address` lists those");
  const auto question_port = [&](const char* key, int port) {
    if (port > 0 && port < first_free_port)
      remarks.add(remarks.key("sensors", sensor.name, key),
                  "is " + std::to_string(port) + ": ports below 1024 need privileges; set a higher one");
  };
  if (sensor.model->transport == Transport::udp) question_port("ip_port", sensor.ip_port);
  question_port("telemetry_port", sensor.telemetry_port);
}

void question_calibrations(Remarks& remarks) {
  for (const SensorConfig& sensor : remarks.config.sensors) {
    if (sensor.model == nullptr || !sensor.model->has(Trait::calibration)) continue;
    const Value entry = remarks.entry("sensors", sensor.name);
    if (sensor.driver.calibration == nullptr) {
      // What the driver reports before the first packet.
      const auto driver = sensor.model->make(sensor.driver);
      for (const std::string& warning : driver->info().warnings)
        remarks.add(value_at(entry, "model"), "has no calibration: " + warning);
      continue;
    }
    const std::string warning = calibration_warning(*own_calibration(sensor.driver), *sensor.model);
    if (!warning.empty()) remarks.add(value_at(entry, "calibration"), warning);
  }
}

}  // namespace

std::vector<std::string> remarks_on(const Config& config) {
  Remarks remarks{config};
  for (const auto question :
       {question_footprint, question_positions, question_twins, question_tilt, question_heights,
        question_windows, question_rates, question_calibrations, question_addresses})
    question(remarks);
  question_units(remarks, remarks.root);
  return remarks.sorted(config.warnings);
}

std::vector<std::string> host_remarks_on(const Config& config) {
  Remarks remarks{config};
  for (const SensorConfig& sensor : config.sensors) {
    if (has_network(sensor)) question_host(remarks, sensor);
  }
  return remarks.sorted();
}

}  // namespace lidard
