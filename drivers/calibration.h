// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/model.h"

// The calibration of single lasers. drivers/velodyne defines the functions.
namespace lidard {

/// The equations that place a calibrated return.
///
/// `exact`: those of the HDL-64E S3 manual (63-HDL64ES3 Rev K, appendix F): the beam starts vert_offset above
/// the origin, and the two-point correction is for returns nearer than the far target only. `ros_drivers`:
/// those of velodyne_pointcloud (rawdata.cc), for the same cloud: the offset turns with the beam, the
/// two-point correction continues beyond the far target, the intensity formula uses the focal distance in
/// metres as centimetres, and a VLS-128's calibration has only angles. `veloview`: those of the vendor's
/// viewer for a db.xml, as of the published capture of an HDL-64E S1 (2016): the beam starts vert_offset
/// above the origin, near corrections are not used, intensities are raw. They reproduce all 89,105 points of
/// the published frame; later versions of the viewer correct the distance over ground, but not the height,
/// for the turn of the offset.
enum class CalibrationModel : std::uint8_t { exact, ros_drivers, veloview };

/// Whether the near corrections are interpolated. `unstated`: the file has near corrections but not the key
/// that enables them; then `ros_drivers` ignores them, as velodyne_pointcloud does, and `exact` uses them if
/// both are present.
enum class TwoPoint : std::uint8_t { off, on, unstated };

/// The factory calibration of one laser. Angles in rad, lengths in m.
struct LaserCalibration {
  double rot_correction = 0;     ///< subtracted from the azimuth
  double vert_correction = 0;    ///< elevation
  double dist_correction = 0;    ///< added to the distance; measured at 25.04 m
  double dist_correction_x = 0;  ///< added instead across, at 2.40 m
  double dist_correction_y = 0;  ///< added instead ahead, at 1.93 m
  double vert_offset = 0;        ///< of the beam's origin, up
  double horiz_offset = 0;       ///< of the beam's origin, to the left of its direction
  TwoPoint two_point = TwoPoint::off;
  double focal_distance = 0;
  double focal_slope = 0;  ///< 0: raw intensities
  int min_intensity = 0;
  int max_intensity = 255;
};

/// One sensor's calibration; lasers in the order of the slots of a firing sequence.
struct Calibration : FamilySettings {
  double distance_step_m = 0.002;  ///< one count of the packet's distances
  std::vector<LaserCalibration> lasers;
  CalibrationModel model = CalibrationModel::exact;
  bool is_db_xml = false;  ///< it comes from a db.xml of the vendor's viewer
};

/// The sensor's own calibration; nullptr: the model's table holds.
inline const Calibration* own_calibration(const DriverConfig& config) {
  return static_cast<const Calibration*>(config.calibration.get());
}

/// The table of a model with the equations of velodyne_pointcloud. Like the files of velodyne_pointcloud it
/// has no vertical offsets.
Calibration table_calibration(const Model& model);
/// Only for a model with Trait::calibration: true if sensors of this model differ too much for a common table
/// (HDL-64E).
bool needs_own_calibration(const Model& model);
/// The default equations for a file: those of velodyne_pointcloud, or for the db.xml of an HDL-64E S1 those
/// of the viewer, which reproduce its published frame.
CalibrationModel usual_equations(const Calibration& calibration, const Model& model);

/// Why the calibration cannot belong to a sensor of the model: "has 32 lasers, VLP-16 has 16"; empty if it
/// can.
std::string calibration_rejection(const Calibration& calibration, const Model& model);
/// A warning about an accepted calibration; empty: none.
std::string calibration_warning(const Calibration& calibration, const Model& model);

}  // namespace lidard
