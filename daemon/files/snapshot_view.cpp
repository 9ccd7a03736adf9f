// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/snapshot_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/module.h"

namespace lidard {
namespace {

using Role = SnapshotView::Role;

/// A scan older by this than the others shows surroundings that the vehicle has left, s.
constexpr double noticeably_older = 0.02;

/// The shares of counts, %, whose sum is 100: the largest remainders are rounded up.
std::vector<std::size_t> percentages(const std::vector<std::size_t>& counts) {
  const std::size_t all = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  std::vector<std::size_t> shares(counts.size());
  std::vector<std::pair<std::size_t, std::size_t>> remainders;
  for (std::size_t i = 0; i < counts.size() && all > 0; ++i) {
    shares[i] = 100 * counts[i] / all;
    remainders.emplace_back(100 * counts[i] % all, i);
  }
  std::sort(remainders.rbegin(), remainders.rend());
  std::size_t rest = 100 - std::accumulate(shares.begin(), shares.end(), std::size_t{0});
  for (const auto& [remainder, i] : remainders) {
    if (rest > 0) ++shares[i], --rest;
  }
  return shares;
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
  Gatherer(const Config& config, const FrameTree& poses, const FrameKeeper& frames, const ViewChoice& choice)
      : config_(config), poses_(poses), frames_(frames), choice_(choice), areas_(choice.areas) {}

  SnapshotView run() {
    view_.base_frame = config_.vehicle.base_frame;
    view_.footprint = config_.vehicle.footprint;
    for (const SensorConfig& sensor : config_.sensors) add_sensor(sensor);
    for (const MergedScanConfig& merged : config_.merged_scans) add_merged(merged);
    for (const MergedCloudConfig& merged : config_.merged_clouds)
      add_cloud(merged.destination_topic, nullptr, "merged cloud");
    for (const VirtualScanConfig& group : config_.virtual_scans) add_virtual(group);
    for (const std::string& topic : choice_.only) {
      if (topics_.count(topic) > 0) continue;
      throw std::runtime_error(fmt::format("--only: no output '{}' can be drawn; expected one of {}", topic,
                                           fmt::join(topics_, ", ")));
    }
    // A device's own free space counts as proven.
    if (first_input_ != nullptr && (shaded_ == nullptr || !areas_.empty()))
      choose_areas(first_input_topic_, *first_input_, Profile::strict);
    if (!areas_came_ && !areas_.empty())
      throw std::runtime_error("--areas: no scan '" + areas_ + "' had come by then");
    if (shaded_ != nullptr) shade(*shaded_);
    return std::move(view_);
  }

 private:
  bool is_wanted(const std::string& topic) {
    topics_.insert(topic);
    const auto& only = choice_.only;
    return only.empty() || topic == areas_ || std::count(only.begin(), only.end(), topic) > 0;
  }
  SnapshotView::Layer& add_layer(Role role, const std::string& name, const std::string& note) {
    return view_.layers.emplace_back(SnapshotView::Layer{role, numbers_[role]++, name, note, {}, {}, {}});
  }
  void add_sensor(const SensorConfig& sensor) {
    if (sensor.model == nullptr) {
      if (choice_.only.empty())
        view_.missing.push_back(sensor.name + " comes from the topic " + sensor.topic +
                                ", which a capture does not hold");
      return;
    }
    const bool cloud = sensor.model->kind == FrameKind::cloud;
    const std::string topic = frame_topic(sensor).name;
    if (cloud) return add_cloud(topic, &sensor, "cloud");
    const std::size_t number = numbers_[Role::input];
    if (const PlanarScan* scan =
            add_scan(Role::input, topic, sensor.frame_id, std::string(sensor.model->product))) {
      add_mark(sensor, Role::input, number);
      if (first_input_ == nullptr) first_input_ = scan, first_input_topic_ = topic;
    }
  }
  /// `sensor` may be nullptr: the cloud of several.
  void add_cloud(const std::string& topic, const SensorConfig* sensor, const std::string& what) {
    if (!is_wanted(topic)) return;
    const Cloud* cloud = frames_.find_cloud(topic);
    if (cloud == nullptr) {
      view_.missing.push_back(topic + " had not come by then");
      return;
    }
    // The message may be in another frame than the lidar.
    Pose pose;
    if (!find_pose(cloud->frame_id, cloud->stamp, pose)) return;
    auto& layer = add_layer(Role::cloud, topic,
                            what + ", " + std::to_string(cloud->size()) + " points" + age(cloud->stamp));
    const Eigen::Isometry3f to_base = pose.cast<float>();
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      const CloudPoint* const p = cloud->points() + i;
      const Eigen::Vector3f in_message(p->x, p->y, p->z);
      if (!in_message.allFinite()) continue;
      const Eigen::Vector3f at = to_base * in_message;
      layer.points.emplace_back(at.head<2>());
      layer.values.push_back(choice_.intensities ? p->intensity : at.z());
    }
    if (sensor != nullptr) add_mark(*sensor, Role::cloud, layer.number);
  }
  void add_mark(const SensorConfig& sensor, Role role, std::size_t number) {
    Pose pose;
    if (!find_pose(sensor.frame_id, frames_.newest(), pose)) return;
    view_.sensors.push_back({sensor.name, pose.translation().head<2>(), role, number});
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
      view_.layers.back().note += beside(scan->stamp);
      choose_areas(topic, *scan, group.output.profile);
    }
  }
  const PlanarScan* add_scan(Role role, const std::string& topic, const std::string& frame,
                             const std::string& what) {
    if (!is_wanted(topic)) return nullptr;
    const PlanarScan* scan = frames_.find_scan(topic, frame);
    if (scan == nullptr) {
      view_.missing.push_back(topic + " had not come by then");
      return nullptr;
    }
    Pose pose;
    if (!find_pose(frame, scan->stamp, pose)) return nullptr;
    auto& layer =
        add_layer(role, topic, what + ", " + std::to_string(scan->beams) + " beams" + age(scan->stamp));
    if (role != Role::input) layer.dot = 3;
    if (role != Role::virtual_scan) scans_stamp_ = std::max(scans_stamp_, scan->stamp);
    std::size_t last_hit = scan->beams;
    for (std::size_t i = 0; i < scan->beams; ++i) {
      if (scan->statuses[i] != BeamStatus::hit) continue;
      const auto r = static_cast<double>(scan->ranges[i]);
      layer.points.push_back(from_above(pose, static_cast<double>(scan->angle(i)), r));
      layer.joined.push_back(0);
      if (choice_.intensities && !scan->intensities.empty()) layer.values.push_back(scan->intensities[i]);
      const double step = std::abs(static_cast<double>(scan->angle_increment)) * r;
      const std::size_t n = layer.points.size();
      if (last_hit + 1 == i &&
          static_cast<double>((layer.points[n - 1] - layer.points[n - 2]).norm()) < 0.1 + 3 * step)
        layer.joined[n - 2] = 1;
      last_hit = i;
    }
    return scan;
  }
  /// Prefers scans with only proven evidence.
  void choose_areas(const std::string& topic, const PlanarScan& scan, Profile profile) {
    const bool better = shaded_ == nullptr || profile < shaded_profile_;
    if (areas_.empty() ? !better || profile == Profile::flatten : areas_ != topic) return;
    areas_came_ = true;
    if (profile == Profile::flatten) {
      view_.notes.push_back(topic +
                            " has the profile flatten, which proves no place to be free: no area is shaded.");
      return;
    }
    shaded_ = &scan;
    shaded_profile_ = profile;
    const auto shares = percentages({count(scan, BeamStatus::none) + count(scan, BeamStatus::hit),
                                     count(scan, BeamStatus::invalid), count(scan, BeamStatus::near)});
    view_.free_note = "seen to be free, says " + topic + " (" + std::to_string(shares[0]) + "% of its beams)";
    view_.unobserved_note = "not observed, says " + topic + " (" + std::to_string(shares[1]) + "%)";
    if (shares[2] > 0) view_.unobserved_note += "; too near to measure: " + std::to_string(shares[2]) + "%";
  }
  void shade(const PlanarScan& scan) {
    Pose pose;
    if (!find_pose(scan.frame_id, scan.stamp, pose)) return;
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
  bool find_pose(const std::string& frame, Stamp stamp, Pose& pose) {
    std::string why;
    if (poses_.find(config_.vehicle.base_frame, frame, stamp, pose, why)) return true;
    view_.missing.push_back(frame + " is not drawn: " + why);
    return false;
  }
  /// The age of a frame that is not of the same moment as the others.
  std::string age(Stamp stamp) const {
    const double old = seconds(frames_.newest() - stamp);
    return old < 0.3 ? "" : ", " + std::to_string(std::lround(old * 10) / 10) + " s old";
  }

  /// A remark on a virtual scan that is not of the same moment as the other scans.
  std::string beside(Stamp stamp) const {
    const double old = seconds(scans_stamp_ - stamp);
    if (scans_stamp_ == Stamp{} || std::abs(old) < noticeably_older) return {};
    return printed(", taken %.2f s ", std::abs(old)) + (old > 0 ? "before" : "after") +
           " the scans beside it";
  }

  const Config& config_;
  const FrameTree& poses_;
  const FrameKeeper& frames_;
  const ViewChoice& choice_;
  const std::string& areas_;
  std::set<std::string> topics_;  // that can be drawn
  bool areas_came_ = false;
  Stamp scans_stamp_{};  // of the newest scan that is not virtual
  const PlanarScan* shaded_ = nullptr;
  Profile shaded_profile_ = Profile::flatten;
  const PlanarScan* first_input_ = nullptr;
  std::string first_input_topic_;
  std::map<Role, std::size_t> numbers_;
  SnapshotView view_;
};

/// The narrowest range that holds a share of the values.
std::pair<double, double> narrowest(std::vector<float>& values, double share) {
  std::sort(values.begin(), values.end());
  const auto held = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  std::size_t best = 0;
  for (std::size_t i = 0; i + held <= values.size(); ++i) {
    if (values[i + held - 1] - values[i] < values[best + held - 1] - values[best]) best = i;
  }
  return {values[best], values[best + held - 1]};
}

/// Fits the ends of the colours to values, and says them.
std::string fit_scale(std::vector<float>& values, std::pair<double, double>& scale) {
  if (!values.empty()) scale = narrowest(values, 0.96);
  scale.second = std::max(scale.second, scale.first + 0.1);
  const auto number = [](double value) {
    return printed(std::abs(value) < 100 ? "%.3g" : "%.0f", std::abs(value) < 5e-4 ? 0.0 : value);
  };
  return number(scale.first) + " to " + number(scale.second);
}

}  // namespace

SnapshotView make_view(const Config& config, const FrameTree& poses, const FrameKeeper& frames,
                       const ViewChoice& choice) {
  return Gatherer(config, poses, frames, choice).run();
}

SnapshotView::Framing fit_to_points(const SnapshotView& view) {
  const bool has_scanners = std::any_of(view.layers.begin(), view.layers.end(), [](const auto& layer) {
    return !layer.points.empty() && (layer.role == Role::input || layer.role == Role::merged);
  });
  std::vector<float> x{0}, y{0};
  for (const auto& layer : view.layers) {
    // A roof lidar sees far beyond the scanners.
    if (layer.role == Role::cloud && has_scanners) continue;
    for (const auto& p : layer.points) x.push_back(p.x()), y.push_back(p.y());
  }
  // Of each axis 2.5 % are left out, so of both together at most 5 %.
  auto [back, front] = narrowest(x, 0.975);
  auto [right, left] = narrowest(y, 0.975);
  // The vehicle itself is always in the picture.
  back = std::min(back, -1.0), front = std::max(front, 1.0);
  right = std::min(right, -1.0), left = std::max(left, 1.0);
  SnapshotView::Framing out;
  out.center = {(back + front) / 2, (right + left) / 2};
  out.half = {std::max(2.0, 0.53 * (front - back)), std::max(2.0, 0.53 * (left - right))};
  return out;
}

void fit_colors(SnapshotView& view, bool intensities) {
  std::vector<float> shown;
  for (auto& layer : view.layers) {
    bool any = false;
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
      const Eigen::Vector2d from_center = layer.points[i].cast<double>() - view.framing.center;
      if (!std::isfinite(layer.values[i])) continue;
      any |= layer.values[i] != 0;
      if ((from_center.cwiseAbs().array() <= view.framing.half.array()).all())
        shown.push_back(layer.values[i]);
    }
    if (!intensities) continue;
    if (!any) layer.values.clear();
    layer.note += any ? ", intensity " + fit_scale(shown, layer.scale) : ", no intensities";
    if (any) view.colors_note = "lowest to highest intensity of each, as the device counts it";
    shown.clear();
  }
  if (shown.empty()) return;
  std::pair<double, double> scale;
  view.colors_note = fit_scale(shown, scale) + ": height above " + view.base_frame + ", m";
  for (auto& layer : view.layers) layer.scale = scale;
}

std::optional<PictureFormat> picture_format(const std::string& path) {
  const std::string end = path.size() > 4 ? path.substr(path.size() - 4) : std::string();
  if (end == ".png") return PictureFormat::png;
  return end == ".svg" ? std::optional(PictureFormat::svg) : std::nullopt;
}

std::string draw_snapshot(const std::vector<SnapshotView>& views, PictureFormat format) {
  const auto draw = reinterpret_cast<decltype(&lidard_draw_snapshot)>(module_function(
      "lidard_pictures", "lidard_draw_snapshot", "pictures need lidard's module for pictures"));
  std::string bytes;
  draw(views, format, bytes);
  return bytes;
}

}  // namespace lidard
