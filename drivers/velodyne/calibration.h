// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace lidard {
struct Model;
}

namespace lidard::velodyne {

struct ModelRow;

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
bool operator==(const LaserCalibration& a, const LaserCalibration& b);

/// One sensor's calibration; lasers in the order of the slots of a firing sequence.
struct Calibration {
  double distance_step_m = 0.002;  ///< one count of the packet's distances
  std::vector<LaserCalibration> lasers;
  CalibrationModel model = CalibrationModel::exact;
  bool is_db_xml = false;  ///< it came as the vendor's viewer reads it
};

/// Rings in ascending order of elevation, equal ones in order of the laser's number.
std::vector<std::uint16_t> rings_by_elevation(const Calibration& calibration);

/// Places returns with a calibration; everything that does not depend on the return was computed beforehand.
///
/// With D the distance with its far correction, ω the elevation, α the azimuth without rot_correction, v and
/// h the offsets (sensor frame: Y ahead, X right):
///
///     exact, veloview: r = D cos ω        Z = Dy sin ω + v
///     ros_drivers:  r = D cos ω − v sin ω  Z = Dy sin ω + v cos ω
///     X = r(Dx) sin α − h cos α           Y = r(Dy) cos α + h sin α
///
/// where Dx and Dy are D moved between the near and the far correction in proportion to |X| and |Y|.
/// The loops of sequence_kernel.h do it in float, for eight returns at once.
class CalibratedGeometry {
 public:
  explicit CalibratedGeometry(const Calibration& calibration);

  std::size_t lasers() const { return lasers_.size(); }
  /// The distance with its far correction, m: what range limits apply to.
  double distance(std::size_t laser, std::uint16_t count) const {
    return count * step_m_ + lasers_[laser].dist_correction;
  }

  /// Where the two-point calibration was made: 63-HDL64ES3 Rev K p. 43.
  static constexpr double far_target_m = 25.04;
  static constexpr double near_target_x_m = 2.40;
  static constexpr double near_target_y_m = 1.93;

  /// What the equations need of one laser.
  struct Terms {
    double rot_correction, cos_rot, sin_rot, cos_vert, sin_vert;
    double dist_correction, horiz_offset;
    double r_offset, z_offset;  ///< what vert_offset takes from the ground distance and adds to the height
    double near_x, near_y;      ///< change of the correction per metre towards the near target
    double focal, focal_slope;
    double min_intensity, max_intensity;
    bool two_point;
    /// True if a distance along the beam and the beam's own two angles place a return, and intensities stay
    /// as they come.
    bool is_straight() const {
      return horiz_offset == 0 && !two_point && focal_slope == 0 && min_intensity <= 0 &&
             max_intensity >= 255;
    }
  };
  const Terms& terms(std::size_t laser) const { return lasers_[laser]; }
  double step_m() const { return step_m_; }
  /// The near corrections apply to shorter distances.
  double two_point_below_m() const { return two_point_below_m_; }

 private:
  static Terms terms_of(const LaserCalibration& laser, CalibrationModel model);

  double step_m_;
  double two_point_below_m_;
  std::vector<Terms> lasers_;
};

/// The model's table as a calibration: nothing but angles and heights.
Calibration table_of(const ModelRow& row);
/// Its angles with the equations of velodyne_pointcloud. Like the files that velodyne_pointcloud ships it has
/// no offsets: its users' clouds lack the height of the beam's origin.
Calibration table_calibration(const Model& model);

/// True if sensors of this model differ so much that a table tells little (HDL-64E).
bool needs_own_calibration(const Model& model);

}  // namespace lidard::velodyne
