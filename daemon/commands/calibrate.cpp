// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/calibrate.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <ostream>
#include <stdexcept>

#include "core/base/angle.h"
#include "core/mounts/seen_motion.h"
#include "daemon/commands/mount_edit.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"
#include "daemon/offline/remarks.h"
#include "daemon/ros/in/bag_topics.h"
#include "daemon/yaml/yaml.h"

namespace lidard {
namespace {

/// What a sensor sees, with the ground of a multi-plane lidar found first.
MountedSensor seen_by(CalibratedSensor& sensor) {
  if (sensor.is_cloud) {
    sensor.ground = find_ground(sensor.scans.points(), sensor.before);
    if (sensor.ground) sensor.tilt = tilt_to(sensor.ground->up);
  }
  MountedSensor mounted;
  mounted.configured = sensor.configured();
  if (sensor.scans.frames() == 0) return mounted;
  mounted.seen.views = sensor.scans.views(sensor.tilt);
  if (sensor.is_cloud)
    mounted.seen.surfaces = find_upright(mounted.seen.views);
  else
    find_surfaces(mounted.seen.views[0], mounted.seen.surfaces);
  mounted.seen.height = sensor.ground ? sensor.ground->height : sensor.before.translation().z();
  return mounted;
}

/// The base poses and time offsets that the drive shows, from the poses that the stop shows.
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

void write_mounts(const CalibrateOptions& options, const Config& before,
                  const std::vector<CalibratedSensor>& sensors) {
  std::map<std::string, MountEdit> mounts, wanted;
  for (const SensorConfig& sensor : before.sensors) {
    if (sensor.pose) wanted[sensor.name] = {*sensor.pose, seconds(sensor.driver.time_offset)};
  }
  for (const CalibratedSensor& sensor : sensors) {
    if (!sensor.is_changed()) continue;
    MountEdit& edit = mounts[sensor.config->name];
    edit.pose = sensor.after;
    if (sensor.sigma(3)) edit.time_offset = sensor.time_offset_after();
    wanted[sensor.config->name] = {sensor.after, edit.time_offset.value_or(sensor.time_offset_before())};
  }
  const std::string text =
      with_mounts(read_file(options.config, "a readable YAML file"), options.config, mounts);
  // An anchor may have carried a new mount to the entry of another sensor.
  for (const SensorConfig& sensor : parse_config(text, options.config).sensors) {
    const auto want = wanted.find(sensor.name);
    if (want == wanted.end()) continue;
    if ((sensor.pose->matrix() - want->second.pose.matrix()).norm() > 5e-4 ||
        std::abs(seconds(sensor.driver.time_offset) - *want->second.time_offset) > 2e-5)
      throw ConfigError(options.config + ": sensors." + sensor.name +
                        " shares its mount with another sensor by an anchor; expected its own: " +
                        mount_text(want->second));
  }
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

/// Throws std::runtime_error if half of the sensors see that the vehicle moves.
void require_standing(const std::vector<CalibratedSensor>& sensors) {
  constexpr double highest_ground_m = 0.25;
  std::size_t moving = 0;
  SeenMotion most;
  std::string by;
  for (const CalibratedSensor& sensor : sensors) {
    const double lowest = sensor.is_cloud ? highest_ground_m - sensor.before.translation().z() : -1e9;
    const auto motion = find_motion(sensor.sweeps, sensor.tilt, sensor.configured(), lowest);
    if (!motion) continue;
    if (++moving == 1 || (motion->is_measured && !most.is_measured)) most = *motion, by = sensor.config->name;
  }
  if (moving == 0 || 2 * moving < sensors.size()) return;
  throw std::runtime_error(fmt::format(
      "the vehicle moves in this capture: {} sees {} from {:.1f} s on; record while it stands, or give "
      "its odometry with --motion",
      by,
      most.is_measured
          ? fmt::format("it go at least {:.2f} m and turn by {:.1f} deg", most.way, most.turn * deg_per_rad)
          : "other surroundings",
      most.time));
}

int calibrate(const CalibrateOptions& options, std::ostream& out, std::ostream& err) {
  const Config config = load_config(options.config);
  for (const auto& warning : remarks_on(config)) err << warning << '\n';
  std::optional<Drive> drive;
  if (!options.motion.empty()) drive = read_drive(options.motion, config.vehicle);
  Drive* const driven = drive ? &*drive : nullptr;
  std::vector<CalibratedSensor> sensors = seeing(play_calibrated(options, config, driven), err);
  const std::size_t reference = reference_of(sensors, options.reference);
  if (driven == nullptr) require_standing(sensors);
  std::vector<MountedSensor> mounted;
  mounted.reserve(sensors.size());
  for (CalibratedSensor& sensor : sensors) mounted.push_back(seen_by(sensor));
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
  if (any && !options.output.empty()) write_mounts(options, config, sensors);
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
