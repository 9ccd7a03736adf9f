// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/field_views.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/base/angle.h"
#include "daemon/offline/field_sight.h"

namespace lidard {
namespace {

/// Pixels of a field where several stand side by side, and those that the legend adds to the last one.
constexpr int field_width = 500, legend_width = 300, view_gap = 20;

std::vector<Eigen::Vector2d> border_of(const PlanarScan& scan, const Pose& base_from_sensor) {
  std::vector<Eigen::Vector2d> border = {base_from_sensor.translation().head<2>()};
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const auto angle = static_cast<double>(scan.angle(i)), range = static_cast<double>(scan.range_max);
    border.emplace_back(
        (base_from_sensor * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0)).head<2>());
  }
  return border;
}

/// Where the first ring meets the plane of a frame, for a lidar that is not tilted against it.
std::vector<Eigen::Vector2d> blind_border(const EmptyField& field, const SensorConfig& lidar,
                                          const Pose& frame_from_lidar, const Pose& base_from_lidar) {
  std::vector<Eigen::Vector2d> border;
  const double range = field.blind_range(lidar, frame_from_lidar);
  for (int deg = 0; deg < 360 && range > 0; deg += 3)
    border.emplace_back(base_from_lidar.translation().head<2>() +
                        range * Eigen::Vector2d(std::cos(deg * rad_per_deg), std::sin(deg * rad_per_deg)));
  return border;
}

void add_fields(const EmptyField& field, const std::string& frame, SnapshotView& view) {
  for (std::size_t i = 0; i < view.sensors.size(); ++i) {
    const SensorConfig& sensor = *field.config().find_sensor(view.sensors[i].name);
    Pose in_base, in_frame;
    std::string why;
    if (!field.poses().find(view.base_frame, sensor.frame_id, Stamp{}, in_base, why)) continue;
    const PlanarScan* scan = field.frames().find_scan(frame_topic(sensor).name, sensor.frame_id);
    if (scan != nullptr)
      view.fields.push_back({border_of(*scan, in_base), i, false});
    else if (field.poses().find(frame, sensor.frame_id, Stamp{}, in_frame, why))
      view.fields.push_back({blind_border(field, sensor, in_frame, in_base), i, true});
  }
}

/// m from base_frame to the edge: the vehicle and what is near to it.
double usual_range(const Config& config) {
  double extent = 4;
  for (const Eigen::Vector2d& corner : config.vehicle.footprint) extent = std::max(extent, corner.norm());
  return 3 * extent;
}

}  // namespace

std::vector<SnapshotView> views_of_field(const SnapshotOptions& options, const Config& config) {
  const EmptyField field(config);
  std::vector<SnapshotView> views;
  std::vector<std::string> notes;
  const double range = options.range.value_or(usual_range(config));
  const auto add_view = [&](const std::string& topic, const std::string& frame) {
    SnapshotView& view =
        views.emplace_back(make_view(field.config(), field.poses(), field.frames(), {topic, options.only}));
    add_fields(field, frame, view);
    view.title = topic.empty() ? "What the sensors can see" : topic;
    view.framing.half = {range, range};
    fit_colors(view, false);
    return &view;
  };
  for (const FieldSight& sight : sights_of(config, field)) {
    const auto& only = options.only;
    const bool is_wanted = only.empty() || std::count(only.begin(), only.end(), sight.topic) > 0;
    if (!sight.came || (options.areas.empty() ? !is_wanted : options.areas != sight.topic)) continue;
    add_view(sight.topic, sight.frame)->subtitle = "+inf in an empty field: " + to_text(sight.free);
    for (const Hindrance& one : sight.hindrances)
      notes.push_back(sight.topic + ", " + to_text(one.beams) + ": " + one.sentence + ".");
  }
  if (views.empty() && !options.areas.empty())
    throw std::runtime_error("--areas: no scan '" + options.areas + "' comes of this configuration");
  if (views.empty()) add_view("", config.vehicle.base_frame);
  const auto count = static_cast<int>(views.size());
  for (SnapshotView& view : views) {
    const bool is_last = &view == &views.back();
    const int each = options.width > 0 ? (options.width - legend_width) / count - view_gap : field_width;
    if (options.width > 0 || count > 1) view.framing.width = each + view_gap + (is_last ? legend_width : 0);
  }
  views.back().notes = notes;
  return views;
}

}  // namespace lidard
