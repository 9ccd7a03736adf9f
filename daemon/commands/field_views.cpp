// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/field_views.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/base/angle.h"
#include "daemon/commands/field_sight.h"

namespace lidard {
namespace {

/// Pixels of a field where several stand side by side, and those that the legend adds to the last one.
constexpr int field_width = 500, legend_width = 300, gap = 20;

std::vector<Eigen::Vector2d> border_of(const PlanarScan& scan, const Pose& base_from_sensor) {
  std::vector<Eigen::Vector2d> border = {base_from_sensor.translation().head<2>()};
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const auto angle = static_cast<double>(scan.angle(i)), range = static_cast<double>(scan.range_max);
    border.emplace_back(
        (base_from_sensor * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0)).head<2>());
  }
  return border;
}

/// Where the lowest ring meets the plane of a frame; empty if it does not all around.
std::vector<Eigen::Vector2d> blind_border(const EmptyField& field, const SensorConfig& sensor,
                                          const Pose& frame_from_sensor, const Pose& base_from_sensor) {
  std::vector<Eigen::Vector2d> border;
  const double up = field.lowest_elevation(sensor);
  for (int deg = 0; deg < 360; deg += 3) {
    const Eigen::Vector3d ray(std::cos(up) * std::cos(deg * rad_per_deg),
                              std::cos(up) * std::sin(deg * rad_per_deg), std::sin(up));
    const double height = frame_from_sensor.translation().z(), climb = (frame_from_sensor.linear() * ray).z();
    if (!(height * climb < 0)) return {};
    border.emplace_back((base_from_sensor * (height / -climb * ray)).head<2>());
  }
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
  for (const FieldSight& sight : sights_of(config, field)) {
    if (!sight.came || (!options.areas.empty() && options.areas != sight.topic)) continue;
    SnapshotView& view =
        views.emplace_back(make_view(field.config(), field.poses(), field.frames(), sight.topic));
    add_fields(field, sight.frame, view);
    view.title = sight.topic;
    view.subtitle = "+inf in an empty field: " + to_text(sight.free);
    const double range = options.range.value_or(usual_range(config));
    view.framing.half = {range, range};
    for (const Hindrance& one : sight.hindrances)
      notes.push_back(sight.topic + ", " + to_text(one.beams) + ": " + one.sentence + ".");
  }
  if (views.empty())
    throw std::runtime_error(options.areas.empty()
                                 ? "no merged or virtual scan whose poses are configured: see `lidard check`"
                                 : "--areas: no scan '" + options.areas + "' comes of this configuration");
  const auto count = static_cast<int>(views.size());
  for (SnapshotView& view : views) {
    const bool is_last = &view == &views.back();
    const int each = options.width > 0 ? (options.width - legend_width) / count - gap : field_width;
    if (options.width > 0 || count > 1) view.framing.width = each + gap + (is_last ? legend_width : 0);
  }
  views.back().notes = notes;
  return views;
}

}  // namespace lidard
