// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/virtualizer.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// A band that reaches into the ground is observed from so much above the ground on, m.
constexpr double above_ground = 0.02;

template <class Point>
Eigen::Vector3d position_of(const Point& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

}  // namespace

Virtualizer::Virtualizer(const ScanGrid& grid, HeightBand band, std::size_t frames,
                         const VirtualSettings& settings, std::size_t lidars)
    : settings_(settings), band_(band), flattener_(grid, band) {
  for (std::size_t i = 0; i < lidars; ++i) lidars_.push_back(std::make_unique<Lidar>(settings.beams));
  if (!settings.visibility) return;
  VisibilitySettings how = settings.how;
  how.one_level = settings.mode == CutMode::slice;
  for (std::size_t i = 0; i < frames; ++i)
    frames_.push_back(std::make_unique<Frame>(Frame{Visibility(grid, how, lidars)}));
}

void Virtualizer::set_footprint(const Footprint& footprint) {
  footprint_ = footprint;
  own_ = footprint.padded(Footprint::margin_m);
  for (const auto& lidar : lidars_) lidar->has_pose = false;
  for (const auto& frame : frames_) frame->has_footprint = false;
}

const char* Virtualizer::why_no_surfaces() const {
  for (const auto& lidar : lidars_) {
    if (lidar->placed.cloud != nullptr && !lidar->organised) return lidar->grid.why_not();
  }
  return "";
}

std::uint64_t Virtualizer::own_returns() const {
  std::uint64_t sum = 0;
  for (const auto& lidar : lidars_) sum += lidar->grid.own_returns;
  return sum;
}

/// What depends on the lidar's pose on the vehicle alone.
void Virtualizer::set_pose(std::size_t index, const Pose& vehicle_from_cloud) {
  Lidar& lidar = *lidars_[index];
  if (lidar.has_pose && lidar.placed.vehicle_from_cloud.matrix() == vehicle_from_cloud.matrix()) return;
  lidar.has_pose = true;
  lidar.grid.set_footprint(own_, vehicle_from_cloud);
}

void Virtualizer::set_clouds(const std::vector<PlacedCloud>& clouds) {
  for (std::size_t i = 0; i < lidars_.size(); ++i) {
    if (clouds[i].cloud != nullptr)
      set_cloud(i, clouds[i]);
    else
      lidars_[i]->placed.cloud = nullptr;
  }
}

void Virtualizer::set_cloud(std::size_t index, const PlacedCloud& cloud) {
  Lidar& lidar = *lidars_[index];
  set_pose(index, cloud.vehicle_from_cloud);
  lidar.placed = cloud;
  if (cloud.motion != nullptr && cloud.motion->stands()) lidar.placed.motion = nullptr;
  if (!settings_.visibility) return;
  lidar.organised = !cloud.is_sweep && lidar.grid.organise(*cloud.cloud, lidar.placed.motion);
  if (!lidar.organised) return;
  find_ground(lidar.grid, settings_.ground, cloud.vehicle_from_cloud, lidar.ground);
  lidar.links.set(lidar.grid, settings_.how.noise);
  const Eigen::Vector3f up = cloud.vehicle_from_cloud.linear().row(2).transpose().cast<float>();
  lidar.view.set_cloud(lidar.grid, lidar.ground, lidar.links, up);
}

/// Calls use(return, its position in the virtual frame) for all at heights that count but the vehicle's own.
/// The vehicle's own returns move with it, so the position where they were measured decides.
template <class Use>
void Virtualizer::each_return(const PlacedCloud& placed, const Pose& virtual_from_cloud, Use use) const {
  const Cloud& cloud = *placed.cloud;
  const auto each_of = [&](const Pose& pose, std::size_t begin, std::size_t end) {
    const Eigen::Matrix3d& turn = pose.linear();
    const Eigen::Vector3d& at = pose.translation();
    for (std::size_t i = begin; i < end; ++i) {
      const CloudPoint& point = cloud.points()[i];
      const Eigen::Vector3d measured = position_of(point);
      // Most returns are at other heights.
      const double z = turn.row(2).dot(measured) + at.z();
      if (!(z >= band_.min && z <= band_.max)) continue;
      if (!own_.empty() && own_.contains((placed.vehicle_from_cloud * measured).head<2>())) continue;
      use(point, {turn.row(0).dot(measured) + at.x(), turn.row(1).dot(measured) + at.y(), z});
    }
  };
  if (placed.motion == nullptr) return each_of(virtual_from_cloud, 0, cloud.size());
  for (std::size_t c = 0; c < cloud.columns.size(); ++c)
    each_of(virtual_from_cloud * placed.motion->columns()[c], cloud.columns[c].first_point,
            cloud.points_end(c));
  if (!cloud.columns.empty()) return;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    each_of(virtual_from_cloud * placed.motion->at(static_cast<double>(cloud.points()[i].time)), i, i + 1);
}

void Virtualizer::flatten(const Pose* virtual_from_cloud, PlanarScan& scan) {
  flattener_.begin(scan, true);
  for (std::size_t i = 0; i < lidars_.size(); ++i) {
    if (lidars_[i]->placed.cloud == nullptr) continue;
    each_return(lidars_[i]->placed, virtual_from_cloud[i],
                [this](const CloudPoint& point, const Eigen::Vector3d& position) {
                  flattener_.add(position, point.intensity);
                });
  }
  flattener_.end();
}

void Virtualizer::transform_footprint(Frame& frame, const Pose& virtual_from_vehicle) const {
  if (frame.has_footprint && frame.virtual_from_vehicle.matrix() == virtual_from_vehicle.matrix()) return;
  frame.has_footprint = true;
  frame.virtual_from_vehicle = virtual_from_vehicle;
  frame.visibility.set_footprint(footprint_.transformed(virtual_from_vehicle));
}

/// The plane on which a frame's beams must be free: of a band the limit that is farther from the sensor,
/// since nothing of the band is hidden from beams that reach it.
float Virtualizer::evidence_level(const Lidar& lidar, const Pose& virtual_from_cloud) const {
  if (settings_.mode == CutMode::slice) return 0;
  if (virtual_from_cloud.translation().z() < band_.min) return static_cast<float>(band_.max);
  double level = band_.min;
  if (lidar.ground.known) {
    const Pose vehicle = virtual_from_cloud * lidar.placed.vehicle_from_cloud.inverse();
    const double ground = (vehicle * Eigen::Vector3d(0, 0, settings_.ground.z)).z();
    level = std::max(level, ground + settings_.ground.tolerance + above_ground);
  }
  return static_cast<float>(level);
}

/// Single points at heights that count: earlier returns, and all where no surfaces are known.
void Virtualizer::splat_points(const Lidar& lidar, Visibility& visibility,
                               const Pose& virtual_from_cloud) const {
  const auto splat = [&visibility](const auto& point, const Eigen::Vector3d& p) {
    visibility.raster().draw_point({static_cast<float>(p.x()), static_cast<float>(p.y()), point.intensity},
                                   visibility.surfaces());
  };
  if (!lidar.organised) each_return(lidar.placed, virtual_from_cloud, splat);
  for (const BeamEnd& point : lidar.grid.early) {
    const Eigen::Vector3d position = virtual_from_cloud * position_of(point);
    if (position.z() >= band_.min && position.z() <= band_.max) splat(point, position);
  }
}

void Virtualizer::look(Frame& frame, const Pose* virtual_from_cloud) {
  frame.visibility.begin();
  for (std::size_t i = 0; i < lidars_.size(); ++i) {
    if (lidars_[i]->placed.cloud != nullptr) look(frame, i, virtual_from_cloud[i]);
  }
  frame.visibility.compute();
}

/// Adds what a lidar sees.
void Virtualizer::look(Frame& frame, std::size_t index, const Pose& virtual_from_cloud) {
  Lidar& lidar = *lidars_[index];
  Visibility& visibility = frame.visibility;
  transform_footprint(frame, virtual_from_cloud * lidar.placed.vehicle_from_cloud.inverse());
  splat_points(lidar, visibility, virtual_from_cloud);
  if (!lidar.organised) return;
  lidar.view.set_frame(virtual_from_cloud);
  const bool band = settings_.mode == CutMode::band;
  if (band)
    cut_band(lidar, visibility, evidence_level(lidar, virtual_from_cloud));
  else
    cut_slice(lidar, visibility, 0);
  evidence_.find(lidar.view, tops_, band ? band_ : HeightBand{0, 0}, index, visibility);
}

void Virtualizer::cut_slice(Lidar& lidar, Visibility& visibility, double level) {
  lidar.view.set_level(static_cast<float>(level));
  tops_.find(lidar.view);
  cut_.draw_slice(lidar.view, tops_, visibility.raster(), visibility.surfaces());
}

void Virtualizer::cut_band(Lidar& lidar, Visibility& visibility, float evidence_level) {
  if (std::isfinite(band_.max)) cut_slice(lidar, visibility, band_.max);
  if (std::isfinite(band_.min)) cut_slice(lidar, visibility, band_.min);
  // Mostly the evidence is that of the band's lower limit, which was cut last.
  if (!std::isfinite(band_.min) || static_cast<float>(band_.min) != evidence_level) {
    lidar.view.set_level(evidence_level);
    tops_.find(lidar.view);
  }
  cut_.draw_edges(lidar.view, band_, visibility.raster(), visibility.surfaces());
}

void Virtualizer::project(std::size_t frame, const Pose* virtual_from_cloud,
                          const std::vector<VirtualScan>& outputs) {
  const bool needed = std::any_of(outputs.begin(), outputs.end(),
                                  [](const VirtualScan& one) { return one.profile != Profile::flatten; });
  if (needed) look(*frames_[frame], virtual_from_cloud);
  const auto first = std::find_if(lidars_.begin(), lidars_.end(),
                                  [](const auto& lidar) { return lidar->placed.cloud != nullptr; });
  for (const VirtualScan& output : outputs) {
    PlanarScan& scan = *output.scan;
    if (output.profile == Profile::flatten)
      flatten(virtual_from_cloud, scan);
    else
      frames_[frame]->visibility.encode(output.profile, scan, true);
    if (first == lidars_.end()) continue;
    const Cloud& cloud = *(*first)->placed.cloud;
    scan.stamp = cloud.stamp;
    if (scan.scan_time == 0 && cloud.end > cloud.stamp)
      scan.scan_time = static_cast<float>(seconds(cloud.end - cloud.stamp));
  }
}

}  // namespace lidard
