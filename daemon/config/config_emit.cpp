// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <sstream>

#include "core/base/number_text.h"
#include "daemon/config/calibration_file.h"
#include "daemon/config/config_cut.h"
#include "daemon/config/config_parts.h"

namespace lidard {
namespace {

/// Digits beyond these come from turning an angle into a matrix and back.
double rounded(double degrees) { return std::round(degrees * 1e9) / 1e9; }

/// Divides, so that the shortest text of a decimal fraction comes out.
double seconds_of(Span span) { return static_cast<double>(span.count()) / 1e9; }

/// yaml-cpp begins comments at the margin; each belongs to the mapping of the line above it.
std::string with_indented_comments(const std::string& yaml) {
  std::istringstream lines(yaml);
  std::string result;
  std::string indent;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.front() == '#')
      line.insert(0, indent);
    else
      indent = line.substr(0, line.find_first_not_of(' '));
    result += line + '\n';
  }
  return result;
}

class ConfigWriter {
 public:
  std::string write(const Config& config) {
    yaml_ << YAML::BeginMap;
    vehicle(config.vehicle);
    section("sensors", config.sensors, [this](const SensorConfig& sensor) { this->sensor(sensor); });
    section("merged_scans", config.merged_scans, [this](const MergedScanConfig& scan) { merged(scan); });
    section("virtual_scans", config.virtual_scans,
            [this](const VirtualScanConfig& scan) { virtual_scan(scan); });
    yaml_ << YAML::EndMap;
    return with_indented_comments(yaml_.c_str());
  }

 private:
  template <class List, class WriteOne>
  void section(const char* key, const List& list, WriteOne write_one) {
    if (list.empty()) return;
    yaml_ << YAML::Key << key << YAML::Value << YAML::BeginMap;
    for (const auto& entry : list) {
      yaml_ << YAML::Key << entry.name << YAML::Value << YAML::BeginMap;
      write_one(entry);
      yaml_ << YAML::EndMap;
    }
    yaml_ << YAML::EndMap;
  }
  void text(const char* key, const std::string& value) { yaml_ << YAML::Key << key << YAML::Value << value; }
  void number(const char* key, double value) { text(key, number_text(value)); }
  void flag(const char* key, bool value) { text(key, value ? "true" : "false"); }
  /// Says what holds while an optional key is not there.
  void unset(const char* remark) { yaml_ << YAML::Newline << YAML::Comment(remark); }
  void optional_number(const char* key, const std::optional<double>& value, const char* remark) {
    if (value)
      number(key, *value);
    else
      unset(remark);
  }
  void numbers(const std::vector<double>& values) {
    yaml_ << YAML::Flow << YAML::BeginSeq;
    for (const double value : values) yaml_ << number_text(value);
    yaml_ << YAML::EndSeq;
  }
  void names(const char* key, const std::vector<std::string>& values) {
    yaml_ << YAML::Key << key << YAML::Value << YAML::Flow << values;
  }
  void pose(const std::string& key, const Pose& value) {
    const Eigen::Vector3d rpy = rpy_of(value) * (180 / M_PI);
    const Eigen::Vector3d& xyz = value.translation();
    yaml_ << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginMap << YAML::Key << "xyz"
          << YAML::Value;
    numbers({xyz.x(), xyz.y(), xyz.z()});
    yaml_ << YAML::Key << "rpy_deg" << YAML::Value;
    numbers({rounded(rpy.x()), rounded(rpy.y()), rounded(rpy.z())});
    yaml_ << YAML::EndMap;
  }

  void vehicle(const VehicleConfig& vehicle);
  void sensor(const SensorConfig& sensor);
  void network(const SensorConfig& sensor);
  void cloud(const SensorConfig& sensor);
  void calibration(const SensorConfig& sensor);
  void cola(const DeviceRequests& requests);
  void output(const OutputScanConfig& output);
  void merged(const MergedScanConfig& scan);
  void schedule(const MergedScanConfig& scan);
  void source_settings(const std::string& name, const SourceSettings& settings);
  void options(const MergeOptions& options);
  void also_scans(const std::vector<AlsoScanConfig>& scans);
  void virtual_scan(const VirtualScanConfig& scan);

  YAML::Emitter yaml_;
};

void ConfigWriter::vehicle(const VehicleConfig& vehicle) {
  yaml_ << YAML::Key << "vehicle" << YAML::Value << YAML::BeginMap;
  text("base_frame", vehicle.base_frame);
  yaml_ << YAML::Key << "footprint" << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const Eigen::Vector2d& vertex : vehicle.footprint) numbers({vertex.x(), vertex.y()});
  yaml_ << YAML::EndSeq;
  text("odometry_frame", vehicle.odometry_frame);
  text("odometry_topic", vehicle.odometry_topic);
  text("imu_topic", vehicle.imu_topic);
  text("speed_topic", vehicle.speed_topic);
  yaml_ << YAML::EndMap;
}

void ConfigWriter::network(const SensorConfig& sensor) {
  if (!sensor.packet_topic.empty()) {
    text("packet_topic", sensor.packet_topic);
    return;
  }
  if (sensor.ip_address)
    text("ip_address", sensor.ip_address->to_string());
  else
    unset("ip_address: any sender that no other sensor claims");
  number("ip_port", sensor.ip_port);
  if (sensor.model->has(Trait::gnss)) number("telemetry_port", sensor.telemetry_port);
  if (!sensor.multicast_group) return;
  text("multicast_group", sensor.multicast_group->to_string());
  text("interface", sensor.interface);
}

void ConfigWriter::sensor(const SensorConfig& sensor) {
  const DriverConfig& driver = sensor.driver;
  if (sensor.model != nullptr) {
    text("model", std::string(sensor.model->name));
    network(sensor);
  } else {
    text("topic", sensor.topic);
  }
  text("frame_id", sensor.frame_id);
  if (sensor.pose)
    pose("pose", *sensor.pose);
  else
    unset("pose: from tf");
  number("time_offset", seconds_of(driver.time_offset));
  if (sensor.model == nullptr) return;
  text("clock", driver.clock == ClockMode::smooth ? "smooth" : "arrival");
  for (const auto& [key, value] : requests_text(sensor)) text(key.c_str(), value);
  if (sensor.model->has(Trait::web_control) && sensor.packet_topic.empty()) {
    yaml_ << YAML::Key << "control" << YAML::Value;
    write_control(yaml_, sensor.control);
  }
  if (sensor.model->kind == FrameKind::cloud) {
    if (sensor.model->has(Trait::skip_setting)) cola(driver.requests);
    cloud(sensor);
    calibration(sensor);
    return;
  }
  optional_number("angle_min", driver.angle_min, "angle_min: all beams");
  optional_number("angle_max", driver.angle_max, "angle_max: all beams");
  flag("publish_intensity", driver.publish_intensity);
  text("scan_topic", sensor.scan_topic);
  if (sensor.model->has(Trait::echoes)) flag("publish_multiecho", driver.publish_multiecho);
  if (sensor.model->has(Trait::skip_setting)) cola(driver.requests);
  if (!sensor.model->has(Trait::skip_request)) return;
  number("skip", driver.requests.skip.value_or(0));
  number("cluster", driver.requests.cluster.value_or(1));
  flag("calibrate_time", driver.requests.calibrate_time);
}

void ConfigWriter::cola(const DeviceRequests& requests) {
  flag("publish_states", requests.device_states);
  if (requests.skip)
    number("skip", *requests.skip);
  else
    unset("skip: as the device is set");
}

void ConfigWriter::cloud(const SensorConfig& sensor) {
  const CloudLayout& layout = sensor.layout;
  text("points_topic", sensor.points_topic);
  text("frame_stamp", layout.stamp == FrameStamp::first ? "first" : "last");
  if (!sensor.model->has(Trait::revolutions)) return;
  const DriverConfig& driver = sensor.driver;
  switch (driver.frame_cut) {
    case FrameCut::angle:
    case FrameCut::view:
      text("frame_cut", driver.frame_cut == FrameCut::view ? "view" : "angle");
      number("cut_angle", driver.cut_angle);
      break;
    case FrameCut::time:
      text("frame_cut", "time");
      number("frame_duration", seconds_of(driver.frame_duration));
      break;
  }
  number("min_range", driver.min_range);
  number("max_range", driver.max_range);
  number("view_direction", driver.view_direction);
  number("view_width", driver.view_width);
  text("organize_cloud", layout.order == CloudOrder::list        ? "false"
                         : layout.order == CloudOrder::ring_rows ? "rings"
                                                                 : "firings");
  if (sensor.model->has(Trait::confidence)) flag("publish_confidence", layout.confidence);
  flag("publish_echo", layout.echo);
  if (!sensor.ring_scan) {
    unset("scan_ring: no LaserScan");
    return;
  }
  number("scan_ring", sensor.ring_scan->ring);
  number("scan_resolution", sensor.ring_scan->resolution);
  text("scan_topic", sensor.scan_topic);
}

void ConfigWriter::calibration(const SensorConfig& sensor) {
  if (!takes_calibration(*sensor.model)) return;
  if (sensor.driver.calibration == nullptr) {
    unset("calibration: what the model or the device itself says");
    return;
  }
  if (sensor.calibration.empty())
    unset("calibration: the model's table");
  else
    text("calibration", sensor.calibration);
  text("calibration_model", std::string(name_of(sensor.driver.calibration->model)));
}

void ConfigWriter::output(const OutputScanConfig& output) {
  text("profile", word_of(output.profile));
  const ScanGridSpec& grid = output.grid;
  number("angle_min", grid.angle_min);
  number("angle_max", grid.angle_max);
  if (grid.beams) number("beams", static_cast<double>(*grid.beams));
  if (grid.angle_increment) number("angle_increment", *grid.angle_increment);
  number("time_increment", grid.time_increment);
  number("scan_time", grid.scan_time);
  number("range_min", grid.range_min);
  number("range_max", grid.range_max);
  text("empty", word_of(output.empty));
  text("unobserved", word_of(output.unobserved));
  optional_number("min_height", output.min_height, "min_height: no limit");
  optional_number("max_height", output.max_height, "max_height: no limit");
}

void ConfigWriter::merged(const MergedScanConfig& scan) {
  names("laserscan_topics", scan.laserscan_topics);
  text("destination_frame", scan.destination_frame);
  if (scan.destination_pose)
    pose("destination_pose", *scan.destination_pose);
  else
    unset("destination_pose: from tf");
  text("scan_destination_topic", scan.scan_destination_topic);
  text("cloud_destination_topic", scan.cloud_destination_topic);
  text("status_topic", scan.status_topic);
  schedule(scan);
  output(scan.output);
  text("fuse", scan.mean ? "mean" : "nearest");
  text("echoes", word_of(scan.echoes));
  flag("veil_filter", scan.veil_filter);
  number("range_noise", scan.range_noise);
  number("free_required", scan.free_required > 0 ? scan.free_required : scan.output.grid.range_max);
  options(scan.options);
  also_scans(scan.also);
}

void ConfigWriter::options(const MergeOptions& options) {
  text("conflicts", options.newest_wins ? "newest" : "keep");
  text("free_requires", options.all_heights ? "all" : "any");
  flag("veil_cross_check", options.veil_cross_check);
  text("intensity", word_of(options.intensities));
  if (options.intensities == Intensities::on)
    number("missing_intensity", static_cast<double>(options.missing_intensity));
}

void ConfigWriter::also_scans(const std::vector<AlsoScanConfig>& scans) {
  yaml_ << YAML::Key << "also" << YAML::Value << YAML::BeginMap;
  for (const AlsoScanConfig& also : scans) {
    yaml_ << YAML::Key << also.topic << YAML::Value << YAML::BeginMap;
    text("profile", word_of(also.profile));
    text("empty", word_of(also.empty));
    text("unobserved", word_of(also.unobserved));
    yaml_ << YAML::EndMap;
  }
  yaml_ << YAML::EndMap;
}

void ConfigWriter::schedule(const MergedScanConfig& scan) {
  const ScheduleSettings& s = scan.schedule;
  text("policy", to_string(s.policy));
  if (s.policy == Policy::rate) number("rate", s.rate);
  if (s.policy == Policy::trigger) text("trigger", scan.laserscan_topics[s.trigger]);
  if (s.deadline)
    number("deadline", seconds_of(*s.deadline));
  else
    yaml_ << YAML::Comment("deadline: 0.3 of the shortest period of the sources") << YAML::Newline;
  if (s.max_age)
    number("max_age", seconds_of(*s.max_age));
  else
    yaml_ << YAML::Comment("max_age: until the next sweep of the source is overdue by the deadline")
          << YAML::Newline;
  number("lost_after", seconds_of(s.lost_after));
  flag("publish_when_empty", s.publish_when_empty);
  text("on_missing_motion", word_of(scan.on_missing_motion));
  yaml_ << YAML::Key << "source_settings" << YAML::Value << YAML::BeginMap;
  for (const auto& [name, settings] : scan.source_settings) source_settings(name, settings);
  yaml_ << YAML::EndMap;
}

void ConfigWriter::source_settings(const std::string& name, const SourceSettings& settings) {
  const auto limit = [this](const char* key, double value) {
    if (std::isfinite(value)) number(key, value);
  };
  yaml_ << YAML::Key << name << YAML::Value << YAML::BeginMap;
  limit("range_min", settings.range_min);
  limit("range_max", settings.range_max);
  limit("angle_min", settings.angle_min);
  limit("angle_max", settings.angle_max);
  limit("intensity_min", settings.intensity_min);
  limit("intensity_max", settings.intensity_max);
  number("range_noise", settings.noise);
  limit("no_return_free_range", settings.no_return_free_range);
  text("echoes", word_of(settings.echoes));
  flag("veil_filter", settings.veil_filter);
  yaml_ << YAML::EndMap;
}

void ConfigWriter::virtual_scan(const VirtualScanConfig& scan) {
  text("cloud_topic", scan.cloud_topic);
  text("base_frame", scan.base_frame);
  names("virtual_laser_scan", scan.virtual_laser_scan);
  yaml_ << YAML::Key << "poses" << YAML::Value << YAML::BeginMap;
  for (const auto& [frame, value] : scan.poses) pose(frame, value);
  yaml_ << YAML::EndMap;
  text("output_laser_topic", scan.output_laser_topic);
  output(scan.output);
  also_scans(scan.also);
  if (!scan.has_visibility()) return;
  text("mode", word_of(scan.mode));
  yaml_ << YAML::Key << "ground" << YAML::Value << YAML::BeginMap;
  text("model", word_of(scan.ground.model));
  number("z", scan.ground.z);
  number("tolerance", scan.ground.tolerance);
  if (scan.ground.model == GroundModel::slope) number("steepest", scan.ground.steepest);
  yaml_ << YAML::EndMap;
  flag("keep_ground", scan.keep_ground);
  text("echoes", word_of(scan.early_returns ? EchoChoice::all : EchoChoice::last));
  number("range_noise", scan.range_noise);
  number("free_required", scan.free_required > 0 ? scan.free_required : scan.output.grid.range_max);
  number("no_return_free_range", scan.no_return_free_range);
}

}  // namespace

std::string to_yaml(const Config& config) { return ConfigWriter().write(config); }

}  // namespace lidard
