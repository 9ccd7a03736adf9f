// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/virtualizer.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// Sources of a frame's Visibility: the evidence's free pieces, what is blind, ways over low things.
constexpr std::size_t blind_source = CutEvidence::pieces;
constexpr std::size_t over_source = blind_source + 1;
constexpr std::size_t visibility_sources = over_source + 1;
// Columns whose width changed by less (share) still fit the tables.
constexpr double width_slack = 0.05;
// A band that reaches into the ground is observed from so much above the ground on, m.
constexpr double above_ground = 0.02;

Eigen::Vector3d place_of(const CloudPoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

}  // namespace

Virtualizer::Frame::Frame(const ScanGrid& grid, const VisibilitySettings& how)
    : visibility(grid, how, visibility_sources) {}

Virtualizer::Virtualizer(const ScanGrid& grid, HeightBand band, std::size_t frames,
                         const VirtualSettings& settings)
    : settings_(settings), band_(band), flattener_(grid, band), grid_(settings.beams) {
  if (!settings.visibility) return;
  for (std::size_t i = 0; i < frames; ++i) frames_.push_back(std::make_unique<Frame>(grid, settings.how));
}

void Virtualizer::set_footprint(const Footprint& footprint) {
  footprint_ = footprint;
  own_ = footprint.padded(Footprint::margin_m);
  placed_ = false;
}

/// What depends on the lidar's place on the vehicle alone.
void Virtualizer::place_cloud(const Pose& vehicle_from_cloud) {
  if (placed_ && vehicle_from_cloud_.matrix() == vehicle_from_cloud.matrix()) return;
  placed_ = true;
  vehicle_from_cloud_ = vehicle_from_cloud;
  grid_.set_footprint(own_, vehicle_from_cloud);
  for (auto& frame : frames_) frame->placed = false;
}

void Virtualizer::set_cloud(const Cloud& cloud, const Pose& vehicle_from_cloud, const CloudMotion* motion) {
  cloud_ = &cloud;
  motion_ = motion != nullptr && !motion->stands() ? motion : nullptr;
  place_cloud(vehicle_from_cloud);
  if (!settings_.visibility) return;
  organised_ = grid_.organise(cloud, motion_);
  if (!organised_) return;
  find_ground(grid_, settings_.ground, vehicle_from_cloud, ground_);
  neighbours_.set(grid_, settings_.how.noise);
  const Eigen::Vector3f up = vehicle_from_cloud.linear().row(2).transpose().cast<float>();
  view_.set_cloud(grid_, ground_, neighbours_, up);
}

/// Calls use(return, its place in the virtual frame) for all at heights that count but the vehicle's own. The
/// vehicle's own returns move with it, so the place where they were measured decides.
template <class Use>
void Virtualizer::each_return(const Pose& virtual_from_cloud, Use use) const {
  const auto each_of = [&](const Pose& pose, std::size_t begin, std::size_t end) {
    const Eigen::Matrix3d& turn = pose.linear();
    const Eigen::Vector3d& at = pose.translation();
    for (std::size_t i = begin; i < end; ++i) {
      const CloudPoint& point = cloud_->points()[i];
      const Eigen::Vector3d measured = place_of(point);
      // Most returns are at other heights.
      const double z = turn.row(2).dot(measured) + at.z();
      if (!(z >= band_.min && z <= band_.max)) continue;
      if (!own_.empty() && own_.contains((vehicle_from_cloud_ * measured).head<2>())) continue;
      use(point, {turn.row(0).dot(measured) + at.x(), turn.row(1).dot(measured) + at.y(), z});
    }
  };
  if (motion_ == nullptr) return each_of(virtual_from_cloud, 0, cloud_->size());
  for (std::size_t c = 0; c < cloud_->columns.size(); ++c)
    each_of(virtual_from_cloud * motion_->columns()[c], cloud_->columns[c].first_point,
            cloud_->points_end(c));
  if (!cloud_->columns.empty()) return;
  for (std::size_t i = 0; i < cloud_->size(); ++i)
    each_of(virtual_from_cloud * motion_->at(static_cast<double>(cloud_->points()[i].time)), i, i + 1);
}

void Virtualizer::flatten(const Pose& virtual_from_cloud, PlanarScan& scan) {
  flattener_.begin(scan, true);
  each_return(virtual_from_cloud, [this](const CloudPoint& point, const Eigen::Vector3d& place) {
    flattener_.add(place, point.intensity);
  });
  flattener_.end();
}

void Virtualizer::place(Frame& frame, const Pose& virtual_from_cloud) const {
  const double step = organised_ ? grid_.step() : frame.step;
  const bool same = frame.placed && frame.pose.matrix() == virtual_from_cloud.matrix() &&
                    std::abs(step - frame.step) <= width_slack * frame.step;
  if (same) return;
  frame.placed = true;
  frame.pose = virtual_from_cloud;
  frame.step = step;
  const Pose vehicle = virtual_from_cloud * vehicle_from_cloud_.inverse();
  frame.visibility.set_footprint(footprint_.transformed(vehicle));
  const Eigen::Vector3d at = virtual_from_cloud.translation();
  frame.visibility.set_place(static_cast<float>(at.x()), static_cast<float>(at.y()), step,
                             CutEvidence::pieces);
}

/// The plane on which a frame's beams must be free: of a band the limit that is farther from the sensor,
/// since nothing of the band is hidden from beams that reach it.
float Virtualizer::evidence_level(const Pose& virtual_from_cloud) const {
  if (settings_.mode == CutMode::slice) return 0;
  if (virtual_from_cloud.translation().z() < band_.min) return static_cast<float>(band_.max);
  double level = band_.min;
  if (ground_.known) {
    const Pose vehicle = virtual_from_cloud * vehicle_from_cloud_.inverse();
    const double ground = (vehicle * Eigen::Vector3d(0, 0, settings_.ground.z)).z();
    level = std::max(level, ground + settings_.ground.tolerance + above_ground);
  }
  return static_cast<float>(level);
}

/// Single points at heights that count: earlier returns, and all where no surfaces are known.
void Virtualizer::splat_points(Frame& frame, const Pose& virtual_from_cloud) {
  const auto splat = [&frame](const CloudPoint& point, const Eigen::Vector3d& p) {
    frame.visibility.raster().draw_point(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), point.intensity}, frame.visibility.surfaces());
  };
  if (!organised_) each_return(virtual_from_cloud, splat);
  for (const CloudPoint& point : grid_.early) {
    const Eigen::Vector3d place = virtual_from_cloud * place_of(point);
    if (place.z() >= band_.min && place.z() <= band_.max) splat(point, place);
  }
}

void Virtualizer::look(Frame& frame, const Pose& virtual_from_cloud) {
  place(frame, virtual_from_cloud);
  Visibility& visibility = frame.visibility;
  visibility.begin();
  splat_points(frame, virtual_from_cloud);
  if (organised_) {
    view_.set_frame(virtual_from_cloud);
    const bool band = settings_.mode == CutMode::band;
    if (band)
      cut_band(visibility, evidence_level(virtual_from_cloud));
    else
      cut_slice(visibility, 0);
    evidence_.find(view_, tops_, band ? band_ : HeightBand{0, 0},
                   {&visibility.free_space(0), &visibility.free_space(1)},
                   visibility.free_space(blind_source), visibility.free_space(over_source));
  }
  visibility.compute();
}

void Virtualizer::cut_slice(Visibility& visibility, double level) {
  view_.set_level(static_cast<float>(level));
  tops_.find(view_);
  cut_.draw_slice(view_, tops_, visibility.raster(), visibility.surfaces());
}

void Virtualizer::cut_band(Visibility& visibility, float evidence_level) {
  if (std::isfinite(band_.min)) cut_slice(visibility, band_.min);
  if (std::isfinite(band_.max)) cut_slice(visibility, band_.max);
  view_.set_level(evidence_level);
  tops_.find(view_);
  draw_band_edges(view_, band_, visibility.raster(), visibility.surfaces());
}

void Virtualizer::project(std::size_t frame, const Pose& virtual_from_cloud,
                          const std::vector<VirtualScan>& outputs) {
  const bool needed = std::any_of(outputs.begin(), outputs.end(),
                                  [](const VirtualScan& one) { return one.profile != Profile::flatten; });
  if (needed) look(*frames_[frame], virtual_from_cloud);
  for (const VirtualScan& output : outputs) {
    PlanarScan& scan = *output.scan;
    if (output.profile == Profile::flatten)
      flatten(virtual_from_cloud, scan);
    else
      frames_[frame]->visibility.encode(output.profile, scan, true);
    scan.stamp = cloud_->stamp;
    if (scan.scan_time == 0 && cloud_->end > cloud_->stamp)
      scan.scan_time = static_cast<float>(seconds(cloud_->end - cloud_->stamp));
  }
}

}  // namespace lidard
