// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>

#include "core/base/angle.h"
#include "core/mounts/ground.h"
#include "core/mounts/mount_solver.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/player.h"
#include "daemon/config/pose_edit.h"
#include "daemon/config/reading.h"
#include "daemon/files/text_file.h"
#include "daemon/files/text_table.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/messages/bags_module.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

/// A sensor of the configuration and what it saw.
struct ParkedSensor {
  const SensorConfig* config;
  StillScans scans;
  Pose before, after;
  Eigen::Matrix3d tilt;
  std::optional<GroundPlane> ground;
  MountEstimate estimate;

  // More frames add no accuracy: what is left is no noise.
  static constexpr std::size_t most_scans = 1000, most_clouds = 100;
  void add(const PlanarScan& scan) {
    if (scans.frames() < most_scans) scans.add(scan);
  }
  void add(const Cloud& cloud) {
    if (scans.frames() < most_clouds) scans.add(cloud);
  }
  bool is_changed() const {
    const auto& d = estimate.determined;
    return ground.has_value() || (estimate.verdict == MountVerdict::found && (d[0] || d[1] || d[2]));
  }
};

/// Collects the frames of the sensors.
class StillSink final : public FrameSink {
 public:
  StillSink(std::vector<ParkedSensor>& parked, std::vector<std::string> topics)
      : watched_(parked), topics_(std::move(topics)) {}
  void publish(const OutputTopic& topic, const Payload& payload, Stamp /*released*/) override {
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      if (topics_[i] != topic.name) continue;
      if (const auto* scan = std::get_if<const PlanarScan*>(&payload))
        watched_[i].add(**scan);
      else if (auto* cloud = std::get_if<Cloud*>(&payload); cloud != nullptr && (*cloud)->complete)
        watched_[i].add(**cloud);
    }
  }

 private:
  std::vector<ParkedSensor>& watched_;
  std::vector<std::string> topics_;
};

/// The configuration without what changes the frames of a sensor or is made of them.
Config bare(Config config) {
  config.merged_scans.clear();
  config.merged_clouds.clear();
  config.virtual_scans.clear();
  for (SensorConfig& sensor : config.sensors) {
    sensor.filter = {};
    sensor.layout = {};
    sensor.points_frame.clear();
    sensor.deskew = false;
    sensor.ring_scan.reset();
  }
  return config;
}

/// Adds what other drivers published.
void add_topics(const std::string& path, std::vector<ParkedSensor>& parked) {
  PlanarScan scan;
  Cloud cloud;
  const auto for_each_of = [&](const std::string& topic, const auto& use) {
    for (ParkedSensor& sensor : parked) {
      const std::string& own = sensor.config->topic;
      if (!own.empty() && (own == topic || "/" + own == topic)) use(sensor);
    }
  };
  const auto use_scan = [&](const std::string& topic, const sensor_msgs::LaserScan& message) {
    for_each_of(topic, [&](ParkedSensor& sensor) {
      if (from_ros(message, scan) == nullptr) sensor.add(scan);
    });
  };
  const auto use_cloud = [&](const std::string& topic, const sensor_msgs::PointCloud2& message) {
    for_each_of(topic, [&](ParkedSensor& sensor) {
      if (from_ros(message, cloud).error == nullptr) sensor.add(cloud);
    });
  };
  try {
    bags_function<decltype(lidard_read_scans)>("lidard_read_scans")(path, use_scan, use_cloud);
  } catch (const std::exception& problem) {
    throw std::runtime_error(path + ": " + problem.what());
  }
}

std::vector<ParkedSensor> play_parked(const CalibrateOptions& options, const Config& config) {
  std::vector<ParkedSensor> parked;
  std::vector<std::string> topics;
  for (const SensorConfig& sensor : config.sensors) {
    if (!sensor.pose) continue;
    parked.push_back({&sensor, {}, *sensor.pose, *sensor.pose, tilt_of(sensor.pose->linear()), {}, {}});
    topics.push_back(sensor.model == nullptr ? std::string() : frame_topic(sensor).name);
  }
  if (!options.bag.empty()) add_topics(options.bag, parked);
  StillSink sink(parked, topics);
  MergedCapture capture(options.captures);
  BagPoses no_motion("", "");
  const Config played = bare(config);
  Pipeline pipeline(played, no_motion, sink);
  ReplayOptions fast;
  fast.rate = 0;
  Player(fast, capture, pipeline).play([] { return false; });
  return parked;
}

/// The place that a sensor sees, with the ground of a multi-plane lidar found first.
MountedSensor place_of(ParkedSensor& sensor) {
  if (sensor.scans.is_cloud()) {
    sensor.ground = find_ground(sensor.scans.points(), sensor.before);
    if (sensor.ground) sensor.tilt = tilt_to(sensor.ground->up);
  }
  MountedSensor mounted;
  mounted.place.views = sensor.scans.views(sensor.tilt);
  mounted.place.surfaces =
      sensor.scans.is_cloud() ? find_upright(mounted.place.views) : find_surfaces(mounted.place.views[0]);
  mounted.place.height = sensor.ground ? sensor.ground->height : sensor.before.translation().z();
  const Eigen::Vector3d at = sensor.before.translation();
  mounted.configured = {at.x(), at.y(), yaw_of(sensor.before.linear())};
  return mounted;
}

/// The new pose: what was determined, and all else as configured.
Pose new_pose(const ParkedSensor& sensor) {
  const MountEstimate& e = sensor.estimate;
  Eigen::Vector3d at = sensor.before.translation();
  double yaw = yaw_of(sensor.before.linear());
  Eigen::Matrix3d tilt = sensor.tilt;
  if (e.verdict == MountVerdict::found) {
    at.x() = e.pose.x, at.y() = e.pose.y, yaw = e.pose.yaw;
    if (e.is_mirrored) tilt = Eigen::AngleAxisd(pi_d, Eigen::Vector3d::UnitX()).toRotationMatrix() * tilt;
  }
  if (sensor.ground) at.z() = sensor.ground->height;
  Pose pose = Pose::Identity();
  pose.translation() = at;
  pose.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * tilt;
  return pose;
}

Eigen::Vector3d degrees_of(const Pose& pose) { return deg_per_rad * rpy_of(pose); }

double sigma_of(const MountEstimate& e, Eigen::Index i) { return std::sqrt(e.covariance(i, i)); }

/// What is known of x, y and yaw, or why not, and what would help.
std::string sentence_of(const ParkedSensor& sensor) {
  const MountEstimate& e = sensor.estimate;
  std::string text;
  switch (e.verdict) {
    case MountVerdict::reference:
      return "the reference: x, y and yaw stay as configured";
    case MountVerdict::uncertain:
      return fmt::format(
          "x, y, yaw: not determined: known to {:.0f} mm and {:.2f} deg only; park where walls stand in more "
          "directions",
          1000 * std::max(sigma_of(e, 0), sigma_of(e, 1)), deg_per_rad * sigma_of(e, 2));
    case MountVerdict::ambiguous:
      return "x, y, yaw: not determined: what it sees fits as well at another place (a bare rectangle, a "
             "corridor or a round room); "
             "park where walls and boxes stand irregularly";
    case MountVerdict::unconnected:
      return fmt::format(
          "x, y, yaw: not determined: it shares too few upright surfaces with the other sensors ({} frames); "
          "park where "
          "both see the same walls",
          sensor.scans.frames());
    case MountVerdict::found:
      break;
  }
  if (e.is_mirrored) text = "fits upside down, not as configured; ";
  for (const FreeDirection& free : e.free)
    text += free.turn ? fmt::format("not determined: turning about the point ({:.1f}, {:.1f}); ",
                                    free.about.x(), free.about.y())
                      : fmt::format("not determined: a shift along ({:.2f}, {:.2f}); ", free.shift.x(),
                                    free.shift.y());
  if (!e.free.empty()) return text + "kept as configured there; park where walls stand across that direction";
  return text + fmt::format("{} shared surfaces, agreement {:.1f} % before, {:.1f} % after", e.surfaces,
                            100 * e.as_configured.share(), 100 * e.as_found.share());
}

TextTable table_of(const std::vector<ParkedSensor>& sensors) {
  TextTable table{{"SENSOR", "", "X", "Y", "Z", "ROLL", "PITCH", "YAW"}};
  const auto row = [](std::string name, const char* what, const Pose& pose) {
    const Eigen::Vector3d at = pose.translation(), angles = degrees_of(pose);
    return std::vector<std::string>{std::move(name),
                                    what,
                                    fmt::format("{:.4f}", at.x()),
                                    fmt::format("{:.4f}", at.y()),
                                    fmt::format("{:.4f}", at.z()),
                                    fmt::format("{:.3f}", angles.x()),
                                    fmt::format("{:.3f}", angles.y()),
                                    fmt::format("{:.3f}", angles.z())};
  };
  for (const ParkedSensor& sensor : sensors) {
    table.push_back(row(sensor.config->name, "before", sensor.before));
    table.push_back(row("", "after", sensor.after));
    const auto known = [&](int i, double scale, const char* format) {
      if (sensor.estimate.verdict != MountVerdict::found ||
          !sensor.estimate.determined[static_cast<std::size_t>(i)])
        return std::string("-");
      return fmt::format(fmt::runtime(format), scale * sigma_of(sensor.estimate, i));
    };
    const bool ground = sensor.ground.has_value();
    table.push_back({"", "+-", known(0, 1, "{:.4f}"), known(1, 1, "{:.4f}"),
                     ground ? fmt::format("{:.3f}", ground_height_sigma) : "-",
                     ground ? fmt::format("{:.2f}", ground_tilt_sigma * deg_per_rad) : "-",
                     ground ? fmt::format("{:.2f}", ground_tilt_sigma * deg_per_rad) : "-",
                     known(2, deg_per_rad, "{:.3f}")});
  }
  return table;
}

nlohmann::json json_of(const std::vector<ParkedSensor>& sensors, const MountSolution& solution) {
  constexpr const char* verdicts[] = {"reference", "found", "uncertain", "ambiguous", "unconnected"};
  const auto pose = [](const Pose& p) {
    const Eigen::Vector3d at = p.translation(), angles = degrees_of(p);
    return nlohmann::json{{"xyz", {at.x(), at.y(), at.z()}},
                          {"rpy_deg", {angles.x(), angles.y(), angles.z()}}};
  };
  nlohmann::json all = nlohmann::json::object();
  for (const ParkedSensor& s : sensors) {
    nlohmann::json sigma = nlohmann::json::object();
    constexpr const char* names[] = {"x", "y", "yaw_deg"};
    for (int i = 0; i < 3; ++i) {
      const bool known =
          s.estimate.verdict == MountVerdict::found && s.estimate.determined[static_cast<std::size_t>(i)];
      sigma[names[i]] =
          known ? nlohmann::json(sigma_of(s.estimate, i) * (i == 2 ? deg_per_rad : 1)) : nlohmann::json();
    }
    sigma["z"] = s.ground ? nlohmann::json(ground_height_sigma) : nlohmann::json();
    sigma["roll_deg"] = sigma["pitch_deg"] =
        s.ground ? nlohmann::json(ground_tilt_sigma * deg_per_rad) : nlohmann::json();
    all[s.config->name] = {{"verdict", verdicts[static_cast<std::size_t>(s.estimate.verdict)]},
                           {"frames", s.scans.frames()},
                           {"before", pose(s.before)},
                           {"after", pose(s.after)},
                           {"deviation", sigma},
                           {"upside_down", s.estimate.is_mirrored},
                           {"range_offset", s.estimate.range_offset},
                           {"agreement_before", s.estimate.as_configured.share()},
                           {"agreement_after", s.estimate.as_found.share()},
                           {"remark", sentence_of(s)}};
  }
  return {{"sensors", all}, {"bias", solution.bias}, {"chi_square", solution.chi_square}};
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_poses(const CalibrateOptions& options, const std::vector<ParkedSensor>& sensors) {
  std::map<std::string, Pose> poses;
  for (const ParkedSensor& sensor : sensors) {
    if (sensor.is_changed()) poses[sensor.config->name] = sensor.after;
  }
  TextFile file(options.output);
  file.write(with_poses(content_of(options.config), poses));
  file.close();
}

}  // namespace

int run_calibrate(const CalibrateOptions& options, std::ostream& out, std::ostream& err) {
  try {
    const Config config = load_config(options.config);
    for (const auto& warning : config.warnings) err << warning << '\n';
    std::vector<ParkedSensor> parked = play_parked(options, config);
    std::vector<ParkedSensor> sensors;
    for (ParkedSensor& sensor : parked) {
      if (sensor.scans.frames() > 0)
        sensors.push_back(std::move(sensor));
      else
        err << sensor.config->name << ": no frame in the captures; see `lidard inspect`\n";
    }
    std::size_t reference = 0;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      if (sensors[i].config->name == options.reference) reference = i;
    }
    if (sensors.empty() ||
        (!options.reference.empty() && sensors[reference].config->name != options.reference)) {
      err << (sensors.empty() ? "no sensor with a pose has frames in the captures\n"
                              : "--reference " + options.reference +
                                    ": no such sensor with a pose and frames in the captures\n");
      return exit_failed;
    }
    std::vector<MountedSensor> mounted;
    for (ParkedSensor& sensor : sensors) mounted.push_back(place_of(sensor));
    const MountSolution solution = solve_mounts(mounted, reference);
    bool any = false;
    for (std::size_t i = 0; i < sensors.size(); ++i) {
      sensors[i].estimate = solution.sensors[i];
      sensors[i].after = sensors[i].is_changed() ? new_pose(sensors[i]) : sensors[i].before;
      any = any || sensors[i].is_changed();
    }
    if (options.json) {
      out << json_of(sensors, solution).dump(2) << '\n';
    } else {
      print_columns(table_of(sensors), out);
      for (const ParkedSensor& sensor : sensors)
        out << sensor.config->name << ": " << sentence_of(sensor) << '\n';
    }
    if (any && !options.output.empty()) write_poses(options, sensors);
    if (!any) err << "nothing was determined, and nothing is written\n";
    return any ? exit_ok : exit_failed;
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  } catch (const std::exception& e) {
    err << e.what() << '\n';
    return exit_failed;
  }
}

}  // namespace lidard
