// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/snapshot_view.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Role = SnapshotView::Role;

constexpr std::size_t most_cloud_points = 4000;

std::string percent(std::size_t part, std::size_t all) {
  const double share = all == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(all);
  return std::to_string(std::lround(share)) + "%";
}

std::size_t count(const PlanarScan& scan, BeamStatus status) {
  const auto end = scan.statuses.begin() + static_cast<std::ptrdiff_t>(scan.beams);
  return static_cast<std::size_t>(std::count(scan.statuses.begin(), end, status));
}

const char* to_word(Profile profile) {
  return profile == Profile::strict ? "strict" : profile == Profile::safety ? "safety" : "flatten";
}

Eigen::Vector2f from_above(const Pose& pose, double angle, double range) {
  const Eigen::Vector3d p = pose * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
  return p.head<2>().cast<float>();
}

/// Builds a view layer by layer.
class Gatherer {
 public:
  Gatherer(const Config& config, const FrameTree& poses, const FrameKeeper& frames, std::string areas)
      : config_(config), poses_(poses), frames_(frames), areas_(std::move(areas)) {}

  SnapshotView run() {
    view_.base_frame = config_.vehicle.base_frame;
    view_.footprint = config_.vehicle.footprint;
    for (const SensorConfig& sensor : config_.sensors) add_sensor(sensor);
    for (const MergedScanConfig& merged : config_.merged_scans) add_merged(merged);
    for (const VirtualScanConfig& group : config_.virtual_scans) add_virtual(group);
    // What a device itself says is as good as proven.
    if (first_input_ != nullptr && (shaded_ == nullptr || !areas_.empty()))
      choose_areas(first_input_topic_, *first_input_, Profile::strict);
    if (shaded_ == nullptr && !areas_.empty())
      throw std::runtime_error("--areas: no scan '" + areas_ + "' had come by then");
    if (shaded_ != nullptr) shade(*shaded_);
    return std::move(view_);
  }

 private:
  SnapshotView::Layer& add_layer(Role role, const std::string& name, const std::string& note) {
    return view_.layers.emplace_back(SnapshotView::Layer{role, numbers_[role]++, name, note, {}, {}});
  }
  void add_sensor(const SensorConfig& sensor) {
    if (sensor.model == nullptr) {
      view_.missing.push_back(sensor.name + " comes from the topic " + sensor.topic +
                              ", which a capture does not hold");
      return;
    }
    const bool cloud = sensor.model->kind == FrameKind::cloud;
    const std::string topic = frame_topic(sensor).name;
    if (cloud) return add_cloud(sensor, topic);
    const std::size_t number = numbers_[Role::input];
    if (const PlanarScan* scan =
            add_scan(Role::input, topic, sensor.frame_id, std::string(sensor.model->product))) {
      add_field(sensor, scan, number);
      if (first_input_ == nullptr) first_input_ = scan, first_input_topic_ = topic;
    }
  }
  void add_cloud(const SensorConfig& sensor, const std::string& topic) {
    const Cloud* cloud = frames_.find_cloud(topic);
    if (cloud == nullptr) {
      view_.missing.push_back(topic + " had not come by then");
      return;
    }
    Pose pose;
    if (!place(cloud->frame_id, cloud->stamp, pose)) return;
    auto& layer =
        add_layer(Role::cloud, topic,
                  "cloud, " + std::to_string(cloud->size()) + " points, thinned" + age(cloud->stamp));
    // An odd stride visits every ring.
    const std::size_t stride = (cloud->size() / most_cloud_points) | 1U;
    for (std::size_t i = 0; i < cloud->size(); i += stride) {
      const auto* p =
          reinterpret_cast<const CloudPoint*>(cloud->points_bytes.data() + i * cloud->format.point_step);
      const Eigen::Vector3f in_sensor(p->x, p->y, p->z);
      if (in_sensor.allFinite()) layer.points.push_back((pose.cast<float>() * in_sensor).head<2>());
    }
    add_field(sensor, nullptr, layer.number);
  }
  void add_field(const SensorConfig& sensor, const PlanarScan* scan, std::size_t number) {
    Pose pose;
    if (!place(sensor.frame_id, frames_.newest(), pose)) return;
    SnapshotView::Sensor drawn;
    drawn.name = sensor.name;
    drawn.at = pose.translation().head<2>();
    drawn.role = scan == nullptr ? Role::cloud : Role::input;
    drawn.number = number;
    double first = 0;
    double last = two_pi;
    if (scan != nullptr) {
      first = static_cast<double>(scan->angle_min);
      last = static_cast<double>(scan->angle_max);
    } else if (sensor.driver.view_width < two_pi) {
      first = sensor.driver.view_direction - sensor.driver.view_width / 2;
      last = first + sensor.driver.view_width;
    }
    drawn.all_round = std::abs(last - first) > two_pi - 0.02;
    constexpr int steps = 48;
    for (int i = 0; i <= steps; ++i) {
      const double angle = first + (last - first) * i / steps;
      const Eigen::Vector3d beam = pose.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
      drawn.field.emplace_back(beam.head<2>().normalized());
    }
    view_.sensors.push_back(std::move(drawn));
  }
  void add_merged(const MergedScanConfig& merged) {
    const auto add = [&](const std::string& topic, Profile profile) {
      const PlanarScan* scan =
          add_scan(Role::merged, topic, merged.destination_frame, std::string("merged, ") + to_word(profile));
      if (scan != nullptr) choose_areas(topic, *scan, profile);
    };
    add(merged.scan_destination_topic, merged.output.profile);
    for (const AlsoScanConfig& also : merged.also) add(also.topic, also.profile);
  }
  void add_virtual(const VirtualScanConfig& group) {
    for (const std::string& frame : group.virtual_laser_scan) {
      const std::string& topic = group.output_laser_topic.empty() ? frame : group.output_laser_topic;
      const PlanarScan* scan = add_scan(Role::virtual_scan, topic, frame,
                                        std::string("virtual, ") + to_word(group.output.profile));
      if (scan == nullptr) continue;
      if (topic != frame) view_.layers.back().name += " (" + frame + ")";
      choose_areas(topic, *scan, group.output.profile);
    }
  }
  const PlanarScan* add_scan(Role role, const std::string& topic, const std::string& frame,
                             const std::string& what) {
    const PlanarScan* scan = frames_.find_scan(topic, frame);
    if (scan == nullptr) {
      view_.missing.push_back(topic + " had not come by then");
      return nullptr;
    }
    Pose pose;
    if (!place(frame, scan->stamp, pose)) return nullptr;
    auto& layer =
        add_layer(role, topic, what + ", " + std::to_string(scan->beams) + " beams" + age(scan->stamp));
    std::size_t last_hit = scan->beams;
    for (std::size_t i = 0; i < scan->beams; ++i) {
      if (scan->statuses[i] != BeamStatus::hit) continue;
      const auto r = static_cast<double>(scan->ranges[i]);
      layer.points.push_back(from_above(pose, static_cast<double>(scan->angle(i)), r));
      layer.joined.push_back(0);
      const double step = std::abs(static_cast<double>(scan->angle_increment)) * r;
      const std::size_t n = layer.points.size();
      if (last_hit + 1 == i &&
          static_cast<double>((layer.points[n - 1] - layer.points[n - 2]).norm()) < 0.1 + 3 * step)
        layer.joined[n - 2] = 1;
      last_hit = i;
    }
    return scan;
  }
  /// Prefers scans that say only what is proven.
  void choose_areas(const std::string& topic, const PlanarScan& scan, Profile profile) {
    const bool better = shaded_ == nullptr || profile < shaded_profile_;
    if (areas_.empty() ? !better : areas_ != topic) return;
    shaded_ = &scan;
    shaded_profile_ = profile;
    const std::string shares =
        percent(count(scan, BeamStatus::none) + count(scan, BeamStatus::hit), scan.beams);
    view_.free_note = profile == Profile::flatten
                          ? "no return there, says " + topic + " (flatten: not proven free)"
                          : "seen to be free, says " + topic + " (" + shares + " of its beams)";
    view_.unobserved_note =
        "not observed, says " + topic + " (" + percent(count(scan, BeamStatus::invalid), scan.beams) + ")";
  }
  void shade(const PlanarScan& scan) {
    Pose pose;
    if (!place(scan.frame_id, scan.stamp, pose)) return;
    const double half = std::abs(static_cast<double>(scan.angle_increment)) / 2;
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const BeamStatus status = scan.statuses[i];
      if (status == BeamStatus::near) continue;
      const double range = static_cast<double>(status == BeamStatus::hit ? scan.ranges[i] : scan.range_max);
      const auto angle = static_cast<double>(scan.angle(i));
      SnapshotView::Wedge wedge{
          {pose.translation().head<2>().cast<float>(), from_above(pose, angle - half, range),
           from_above(pose, angle + half, range)},
          status != BeamStatus::invalid};
      view_.wedges.push_back(wedge);
    }
  }
  bool place(const std::string& frame, Stamp stamp, Pose& pose) {
    std::string why;
    if (poses_.find(config_.vehicle.base_frame, frame, stamp, pose, why)) return true;
    view_.missing.push_back(frame + " is not drawn: " + why);
    return false;
  }
  /// Says how old a frame is when it is not of the same moment as the others.
  std::string age(Stamp stamp) const {
    const double old = seconds(frames_.newest() - stamp);
    return old < 0.3 ? "" : ", " + std::to_string(std::lround(old * 10) / 10) + " s old";
  }

  const Config& config_;
  const FrameTree& poses_;
  const FrameKeeper& frames_;
  std::string areas_;
  const PlanarScan* shaded_ = nullptr;
  Profile shaded_profile_ = Profile::flatten;
  const PlanarScan* first_input_ = nullptr;
  std::string first_input_topic_;
  std::map<Role, std::size_t> numbers_;
  SnapshotView view_;
};

/// The middle of most values, and half the width that holds them.
std::pair<double, double> spread(std::vector<float>& values) {
  const auto at = [&](double share) {
    const auto n = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + n, values.end());
    return static_cast<double>(values[static_cast<std::size_t>(n)]);
  };
  const double low = at(0.01);
  const double high = at(0.99);
  return {(low + high) / 2, (high - low) / 2};
}

}  // namespace

SnapshotView make_view(const Config& config, const FrameTree& poses, const FrameKeeper& frames,
                       const std::string& areas) {
  return Gatherer(config, poses, frames, areas).run();
}

void fit_to_points(SnapshotView& view) {
  std::vector<float> x{-1, 1};
  std::vector<float> y{-1, 1};
  const bool only_clouds = std::all_of(view.layers.begin(), view.layers.end(),
                                       [](const auto& layer) { return layer.role == Role::cloud; });
  for (const auto& layer : view.layers) {
    // A roof lidar sees far over what the scans show.
    if (layer.role == Role::cloud && !only_clouds) continue;
    for (const auto& p : layer.points) x.push_back(p.x()), y.push_back(p.y());
  }
  const auto [center_x, half_x] = spread(x);
  const auto [center_y, half_y] = spread(y);
  view.center = {center_x, center_y};
  view.half = {std::max(2.0, 1.06 * half_x), std::max(2.0, 1.06 * half_y)};
}

}  // namespace lidard
