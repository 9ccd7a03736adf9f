// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "drivers/velodyne/model_row.h"

namespace lidard {
namespace velodyne {
namespace {

/// velodyne_pointcloud's rawdata.cc unpacks a VLS-128 separately, with angles only.
constexpr std::size_t lasers_of_vls128 = 128;
/// Full scale of the intensity formula, 65535 counts of 2 mm: the manual's 13100 is in cm, our focal distance
/// in m.
constexpr double focal_scale_m = 131;
constexpr double focal_scale_of_ros_drivers = 13100;

bool is_two_point(const LaserCalibration& laser, CalibrationModel model) {
  if (model == CalibrationModel::veloview) return false;
  if (laser.two_point != TwoPoint::unstated) return laser.two_point == TwoPoint::on;
  return model == CalibrationModel::exact && laser.dist_correction_x != 0 && laser.dist_correction_y != 0;
}

LaserCalibration angles_only(const LaserCalibration& laser) {
  LaserCalibration angles;
  angles.rot_correction = laser.rot_correction;
  angles.vert_correction = laser.vert_correction;
  return angles;
}

auto all_of(const LaserCalibration& l) {
  return std::tie(l.rot_correction, l.vert_correction, l.dist_correction, l.dist_correction_x,
                  l.dist_correction_y, l.vert_offset, l.horiz_offset, l.two_point, l.focal_distance,
                  l.focal_slope, l.min_intensity, l.max_intensity);
}

const ModelRow& row_of(const Model& model) { return *static_cast<const ModelRow*>(model.row); }

}  // namespace

std::vector<std::uint16_t> rings_by_elevation(const Calibration& calibration) {
  std::vector<std::size_t> order(calibration.lasers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return calibration.lasers[a].vert_correction < calibration.lasers[b].vert_correction;
  });
  std::vector<std::uint16_t> rings(order.size());
  for (std::size_t ring = 0; ring < order.size(); ++ring)
    rings[order[ring]] = static_cast<std::uint16_t>(ring);
  return rings;
}

CalibratedGeometry::CalibratedGeometry(const Calibration& calibration)
    : step_m_(calibration.distance_step_m),
      two_point_below_m_(calibration.model == CalibrationModel::ros_drivers
                             ? std::numeric_limits<double>::infinity()
                             : far_target_m) {
  const bool just_angles =
      calibration.model == CalibrationModel::ros_drivers && calibration.lasers.size() == lasers_of_vls128;
  lasers_.reserve(calibration.lasers.size());
  for (const LaserCalibration& laser : calibration.lasers)
    lasers_.push_back(terms_of(just_angles ? angles_only(laser) : laser, calibration.model));
}

CalibratedGeometry::Terms CalibratedGeometry::terms_of(const LaserCalibration& laser,
                                                       CalibrationModel model) {
  const bool exact = model != CalibrationModel::ros_drivers;
  Terms t{};
  t.rot_correction = laser.rot_correction;
  t.cos_rot = std::cos(laser.rot_correction);
  t.sin_rot = std::sin(laser.rot_correction);
  t.cos_vert = std::cos(laser.vert_correction);
  t.sin_vert = std::sin(laser.vert_correction);
  t.dist_correction = laser.dist_correction;
  t.horiz_offset = laser.horiz_offset;
  t.r_offset = exact ? 0 : laser.vert_offset * t.sin_vert;
  t.z_offset = exact ? laser.vert_offset : laser.vert_offset * t.cos_vert;
  t.two_point = is_two_point(laser, model);
  t.near_x = (laser.dist_correction - laser.dist_correction_x) / (far_target_m - near_target_x_m);
  t.near_y = (laser.dist_correction - laser.dist_correction_y) / (far_target_m - near_target_y_m);
  const double focal_nearness =
      1 - laser.focal_distance / (exact ? focal_scale_m : focal_scale_of_ros_drivers);
  t.focal = 256 * focal_nearness * focal_nearness;
  t.focal_slope = laser.focal_slope;
  t.min_intensity = laser.min_intensity;
  t.max_intensity = laser.max_intensity;
  if (model != CalibrationModel::veloview) return t;
  t.focal_slope = 0;
  t.min_intensity = 0;
  t.max_intensity = 255;
  return t;
}

Calibration table_of(const ModelRow& row) {
  Calibration calibration;
  calibration.distance_step_m = row.distance_step_m;
  for (std::size_t k = 0; k < row.lasers; ++k) {
    LaserCalibration& laser = calibration.lasers.emplace_back();
    laser.rot_correction = row.laser[k].rot_correction_deg * rad_per_deg;
    laser.vert_correction = row.laser[k].elevation_deg * rad_per_deg;
    laser.vert_offset = row.laser[k].z_offset_mm * 1e-3;
  }
  return calibration;
}

namespace {

/// The largest difference of the elevations, from the lowest laser to the highest; infinite: of their number.
double elevation_gap_deg(const Calibration& calibration, const ModelRow& row) {
  const auto elevations = [](const Calibration& one) {
    std::vector<double> all;
    for (const LaserCalibration& laser : one.lasers) all.push_back(laser.vert_correction * deg_per_rad);
    std::sort(all.begin(), all.end());
    return all;
  };
  const std::vector<double> own = elevations(calibration), usual = elevations(table_of(row));
  if (own.size() != usual.size()) return std::numeric_limits<double>::infinity();
  double gap = 0;
  for (std::size_t i = 0; i < own.size(); ++i) gap = std::max(gap, std::abs(own[i] - usual[i]));
  return gap;
}

}  // namespace

}  // namespace velodyne

bool operator==(const LaserCalibration& a, const LaserCalibration& b) {
  return velodyne::all_of(a) == velodyne::all_of(b);
}

using velodyne::elevation_gap_deg;
using velodyne::row_of;

Calibration table_calibration(const Model& model) {
  Calibration calibration = velodyne::table_of(row_of(model));
  calibration.model = CalibrationModel::ros_drivers;
  for (LaserCalibration& laser : calibration.lasers) laser.vert_offset = 0;
  return calibration;
}

bool needs_own_calibration(const Model& model) { return row_of(model).banks == 2; }

CalibrationModel usual_equations(const Calibration& calibration, const Model& model) {
  const bool is_s1 = row_of(model).bank_by_bank;
  return is_s1 && calibration.is_db_xml ? CalibrationModel::veloview : CalibrationModel::ros_drivers;
}

std::string calibration_rejection(const Calibration& calibration, const Model& model) {
  const std::string product(model.product);
  if (!model.has(Trait::calibration)) return "is for a Velodyne, " + product + " has none";
  if (model.beams == calibration.lasers.size()) return {};
  return "has " + std::to_string(calibration.lasers.size()) + " lasers, " + product + " has " +
         std::to_string(model.beams);
}

std::string calibration_warning(const Calibration& calibration, const Model& model) {
  if (!model.has(Trait::calibration)) return {};
  const velodyne::ModelRow& row = row_of(model);
  const auto mm = [](double m) { return printed("%g mm", std::round(m * 1e6) / 1e3); };
  if (std::abs(calibration.distance_step_m - row.distance_step_m) > 1e-6)
    return "has a distance step of " + mm(calibration.distance_step_m) + ", but " +
           std::string(model.product) + " counts in " + mm(row.distance_step_m) + ": is it the right file?";
  if (needs_own_calibration(model)) return {};
  constexpr double most_between_units_deg = 1;
  const double gap = elevation_gap_deg(calibration, row);
  if (gap < most_between_units_deg) return {};
  std::string other;
  for (const velodyne::ModelRow* each : velodyne::model_rows()) {
    if (elevation_gap_deg(calibration, *each) < gap / 2) other = ", and fits " + std::string(each->product);
  }
  return printed("has elevations up to %.1f deg off those of ", gap) + std::string(model.product) + other +
         ": is it the right file?";
}

}  // namespace lidard
