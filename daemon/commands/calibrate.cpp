// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/calibrate.h"

#include <map>
#include <ostream>
#include <stdexcept>

#include "core/base/angle.h"
#include "daemon/commands/pose_edit.h"
#include "daemon/config/yaml.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"
#include "daemon/ros/in/bag_topics.h"

namespace lidard {
namespace {

/// The place that a sensor sees, with the ground of a multi-plane lidar found first.
MountedSensor place_of(CalibratedSensor& sensor) {
  if (sensor.is_cloud) {
    sensor.ground = find_ground(sensor.scans.points(), sensor.before);
    if (sensor.ground) sensor.tilt = tilt_to(sensor.ground->up);
  }
  MountedSensor mounted;
  mounted.configured = sensor.configured();
  if (sensor.scans.frames() == 0) return mounted;
  mounted.place.views = sensor.scans.views(sensor.tilt);
  if (sensor.is_cloud)
    mounted.place.surfaces = find_upright(mounted.place.views);
  else
    find_surfaces(mounted.place.views[0], mounted.place.surfaces);
  mounted.place.height = sensor.ground ? sensor.ground->height : sensor.before.translation().z();
  return mounted;
}

/// The base poses and time offsets that the drive shows, from the places that the stop shows.
void solve(std::vector<CalibratedSensor>& sensors, std::size_t reference, Drive& drive) {
  std::vector<DrivenSensor> driven;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    CalibratedSensor& sensor = sensors[i];
    const auto& known = sensor.estimate.determined;
    sensor.is_held = sensor.is_found() && known[0] && known[1] && known[2];
    driven.push_back({sensor.is_found() ? sensor.estimate.pose : sensor.configured(),
                      sensor.is_held ? reference : i, sensor.tilt, std::move(sensor.sweeps)});
  }
  drive.solution = solve_drive(drive.odometry, driven);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    sensors[i].drive = drive.solution.sensors[i], sensors[i].sweeps = std::move(driven[i].sweeps);
}

/// The new pose: what was determined, and all else as configured.
Pose new_pose(const CalibratedSensor& sensor, bool has_drive) {
  const PlanarPose at = has_drive           ? sensor.drive.pose
                        : sensor.is_found() ? sensor.estimate.pose
                                            : sensor.configured();
  Pose pose = Pose::Identity();
  const double height = sensor.ground ? sensor.ground->height : sensor.before.translation().z();
  pose.translation() = Eigen::Vector3d(at.x, at.y, height);
  pose.linear() = Eigen::AngleAxisd(at.yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * sensor.tilt;
  return pose;
}

/// The configuration with other mounts. Throws std::runtime_error for a file that cannot be edited.
std::string edited(const std::string& config, const std::map<std::string, MountEdit>& mounts) {
  try {
    return with_mounts(read_file(config, "a readable YAML file"), mounts);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(config + ": " + error.what());
  }
}

void write_mounts(const CalibrateOptions& options, const std::vector<CalibratedSensor>& sensors) {
  std::map<std::string, MountEdit> mounts;
  for (const CalibratedSensor& sensor : sensors) {
    if (!sensor.is_changed()) continue;
    MountEdit& edit = mounts[sensor.config->name];
    edit.pose = sensor.after;
    if (sensor.sigma(3)) edit.time_offset = sensor.time_offset_after();
  }
  const std::string text = edited(options.config, mounts);
  static_cast<void>(
      parse_config(text, options.config));  // throws where the file has a form that cannot be edited
  TextFile file(options.output);
  file.write(text);
  file.close();
}

/// The sensors that gave frames.
std::vector<CalibratedSensor> seeing(std::vector<CalibratedSensor> all, std::ostream& err) {
  std::vector<CalibratedSensor> sensors;
  for (CalibratedSensor& sensor : all) {
    if (sensor.scans.frames() > 0 || !sensor.sweeps.empty())
      sensors.push_back(std::move(sensor));
    else
      err << sensor.config->name << ": no frame in the captures; see `lidard inspect`\n";
  }
  return sensors;
}

std::size_t reference_of(const std::vector<CalibratedSensor>& sensors, const std::string& wanted) {
  if (sensors.empty()) throw std::runtime_error("no sensor with a pose has frames in the captures");
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (wanted.empty() || sensors[i].config->name == wanted) return i;
  }
  throw std::runtime_error("--reference " + wanted +
                           ": no such sensor with a pose and frames in the captures");
}

int calibrate(const CalibrateOptions& options, std::ostream& out, std::ostream& err) {
  const Config config = load_config(options.config);
  for (const auto& warning : config.warnings) err << warning << '\n';
  std::optional<Drive> drive;
  if (!options.motion.empty()) drive = read_drive(options.motion, config.vehicle);
  Drive* const driven = drive ? &*drive : nullptr;
  std::vector<CalibratedSensor> sensors = seeing(play_calibrated(options, config, driven), err);
  const std::size_t reference = reference_of(sensors, options.reference);
  std::vector<MountedSensor> mounted;
  mounted.reserve(sensors.size());
  for (CalibratedSensor& sensor : sensors) mounted.push_back(place_of(sensor));
  const MountSolution solution = solve_mounts(mounted, reference);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    sensors[i].estimate = solution.sensors[i];
    if (sensors[i].is_found() && sensors[i].estimate.is_mirrored)
      sensors[i].tilt =
          Eigen::AngleAxisd(pi_d, Eigen::Vector3d::UnitX()).toRotationMatrix() * sensors[i].tilt;
  }
  if (driven != nullptr) solve(sensors, reference, *driven);
  bool any = false;
  for (CalibratedSensor& sensor : sensors) {
    if (sensor.is_changed()) sensor.after = new_pose(sensor, driven != nullptr);
    any = any || sensor.is_changed();
  }
  const CalibrationReport report = calibration_report(sensors, solution, driven);
  if (options.json) {
    out << report.dump(2) << '\n';
  } else {
    print_columns(calibration_table(report), out);
    for (const auto& [name, sensor] : report["sensors"].items())
      out << name << ": " << cell(sensor["remark"]) << '\n';
    if (driven != nullptr) out << cell(report["odometry"]["remark"]) << '\n';
  }
  if (!options.picture.empty()) draw_calibration(options.picture, sensors, config, driven);
  if (any && !options.output.empty()) write_mounts(options, sensors);
  if (!any) err << "nothing was determined, and nothing is written\n";
  return any ? exit_ok : exit_failed;
}

}  // namespace

int run_calibrate(const CalibrateOptions& given, std::ostream& out, std::ostream& err) {
  CalibrateOptions options = given;
  const std::vector<std::string> bags = split_bags(options.captures);
  if (bags.size() > 1 || (!bags.empty() && !options.bag.empty())) {
    err << "lidard calibrate: " << bags.front() << ": one bag is read\n";
    return exit_usage;
  }
  if (!bags.empty()) options.bag = bags.front();
  if (options.captures.empty() && options.bag.empty()) {
    err << "lidard calibrate: a capture or --bag is required\n";
    return exit_usage;
  }
  if (!options.picture.empty() && !picture_format(options.picture)) {
    err << "--picture: '" << options.picture << "' is neither a .png nor a .svg file\n";
    return exit_usage;
  }
  return guarded(err, [&] { return calibrate(options, out, err); });
}

}  // namespace lidard
