// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/model.h"

// What is known outside of the family of a Velodyne's calibration; the functions stand with the family.
namespace lidard::velodyne {

/// Whose equations turn a calibrated return into a point.
///
/// `exact`: those of the HDL-64E S3 manual (63-HDL64ES3 Rev K, appendix F): the beam starts vert_offset above
/// the origin, and the two-point correction is for returns nearer than the far target only. `ros_drivers`:
/// those of velodyne_pointcloud (rawdata.cc), so that its users get the cloud they know: the offset turns
/// with the beam, the two-point correction goes on beyond the far target, the intensity formula takes the
/// metres of the focal distance for centimetres, and of a VLS-128's calibration only the angles count.
/// `veloview`: those of the vendor's viewer, which a db.xml is made for, as they were when the capture of an
/// HDL-64E S1 was published (2016): the beam starts vert_offset above the origin, near corrections are never
/// used, intensities stay as they come. They give all 89,105 points of the published frame; later versions of
/// the viewer take the offset's turn with the beam off the distance over ground, but leave the height.
enum class CalibrationModel : std::uint8_t { exact, ros_drivers, veloview };

/// Whether the near corrections are interpolated. Files written for velodyne_pointcloud often hold them
/// without the key that enables them: then `ros_drivers` leaves them out, as it does there, and `exact` uses
/// them where both are there.
enum class TwoPoint : std::uint8_t { off, on, unstated };

/// What was measured of one laser at the factory. Angles in rad, lengths in m.
struct LaserCalibration {
  double rot_correction = 0;     ///< subtracted from the azimuth
  double vert_correction = 0;    ///< elevation
  double dist_correction = 0;    ///< added to the distance; measured at 25.04 m
  double dist_correction_x = 0;  ///< instead, across, at 2.40 m
  double dist_correction_y = 0;  ///< instead, ahead, at 1.93 m
  double vert_offset = 0;        ///< of the beam's origin, up
  double horiz_offset = 0;       ///< of the beam's origin, to the left of its direction
  TwoPoint two_point = TwoPoint::off;
  double focal_distance = 0;
  double focal_slope = 0;  ///< 0: intensities as they come
  int min_intensity = 0;
  int max_intensity = 255;
};

/// One sensor's calibration; lasers in the order of the slots of a firing sequence.
struct Calibration {
  double distance_step_m = 0.002;  ///< one count of the packet's distances
  std::vector<LaserCalibration> lasers;
  CalibrationModel model = CalibrationModel::exact;
  bool is_db_xml = false;  ///< it came as the vendor's viewer reads it
};

/// The table of a model with the equations of velodyne_pointcloud. Like the files that velodyne_pointcloud ships
/// it has no offsets: its users' clouds lack the height of the beam's origin.
Calibration table_calibration(const Model& model);
/// True if sensors of this model differ so much that a table says little (HDL-64E).
bool needs_own_calibration(const Model& model);
/// The equations to use with a file if nobody asks for others: those of velodyne_pointcloud, as users of such
/// files expect, but with the db.xml of an HDL-64E S1 the viewer's, which its published frame proves.
CalibrationModel usual_equations(const Calibration& calibration, const Model& model);

/// What keeps this calibration from being that of a sensor of the model: "has 32 lasers, VLP-16 has 16";
/// empty if nothing does.
std::string calibration_rejection(const Calibration& calibration, const Model& model);
/// What is suspicious about it, but no reason to refuse it; else empty.
std::string calibration_warning(const Calibration& calibration, const Model& model);

}  // namespace lidard::velodyne
