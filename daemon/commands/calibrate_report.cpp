// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "daemon/commands/calibrate.h"
#include "daemon/config/values.h"

namespace lidard {
namespace {

// A scale of the odometry that is known no better is not determined.
constexpr double worst_scale = 0.005;
constexpr std::array<const char*, 4> drive_names{"x", "y", "yaw", "time offset"};

Eigen::Vector3d degrees_of(const Pose& pose) { return deg_per_rad * rpy_of(pose); }

double sigma_of(const MountEstimate& e, Eigen::Index i) { return std::sqrt(e.covariance(i, i)); }

/// What the stop shows of x, y and yaw against the reference.
std::string stop_sentence(const CalibratedSensor& sensor) {
  const MountEstimate& e = sensor.estimate;
  std::string text;
  switch (e.verdict) {
    case MountVerdict::reference:
      return "the reference: x, y and yaw stay as configured";
    case MountVerdict::uncertain:
      return fmt::format(
          "x, y, yaw: not determined: known to {:.0f} mm and {:.2f} deg only; park where walls stand in "
          "more directions",
          1000 * std::max(sigma_of(e, 0), sigma_of(e, 1)), deg_per_rad * sigma_of(e, 2));
    case MountVerdict::ambiguous:
      return "x, y, yaw: not determined: what it sees fits as well at another place (a bare rectangle, a "
             "corridor, a round room or rows of equal columns); "
             "park where walls and boxes stand irregularly";
    case MountVerdict::unconnected:
      return fmt::format(
          "x, y, yaw: not determined: it shares too few upright surfaces with the other sensors ({} frames); "
          "park where "
          "both see the same walls",
          sensor.scans.frames());
    case MountVerdict::found:
      break;
  }
  if (e.is_mirrored) text = "fits upside down, not as configured; ";
  for (const FreeDirection& free : e.free)
    text += free.turn ? fmt::format("not determined: turning about the point ({:.1f}, {:.1f}); ",
                                    free.about.x(), free.about.y())
                      : fmt::format("not determined: a shift along ({:.2f}, {:.2f}); ", free.shift.x(),
                                    free.shift.y());
  if (!e.free.empty()) return text + "kept as configured there; park where walls stand across that direction";
  return text + fmt::format("{} shared surfaces, agreement {:.1f} % before, {:.1f} % after", e.surfaces,
                            100 * e.as_configured.share(), 100 * e.as_found.share());
}

/// What the drive shows of the position in base_frame and of the time offset.
std::string drive_sentence(const CalibratedSensor& sensor, const Drive& drive) {
  std::string missing;
  for (std::size_t i = 0; i < drive_names.size(); ++i) {
    if (!sensor.drive.determined[i]) missing += (missing.empty() ? "" : ", ") + std::string(drive_names[i]);
  }
  const std::string used = fmt::format("{} moves between sweeps of the drive", sensor.drive.moves);
  if (missing.empty()) return "place in base_frame and time offset from " + used;
  return missing + " in base_frame: not determined by " + used + ", and as configured; " +
         (sensor.drive.moves < 10 ? "drive where walls and boxes stand on several sides" : drive.advice());
}

/// What is known of a sensor, or why not, and what would help.
std::string calibration_sentence(const CalibratedSensor& sensor, const Drive* drive) {
  std::string grids;
  if (sensor.left_out > 0)
    grids = fmt::format(
        "; {} of {} scans of the stop are left out: their beams or angles differ from those of the first "
        "scan; record with unchanged settings of the scanner",
        sensor.left_out, sensor.left_out + sensor.scans.frames());
  if (drive == nullptr) return stop_sentence(sensor) + grids;
  std::string text = sensor.scans.frames() == 0
                         ? "no stop: stand 5 s before the drive, so that sensors are found "
                           "against each other, too"
                     : sensor.estimate.verdict == MountVerdict::reference ? "the reference"
                                                                          : stop_sentence(sensor);
  return text + grids + "; " + drive_sentence(sensor, *drive);
}

/// What is known of the odometry.
std::string odometry_sentence(const Drive& drive) {
  const DriveSolution& s = drive.solution;
  const auto factor = [](double scale, double sigma) {
    return sigma < worst_scale ? fmt::format("{:.4f} +- {:.4f}", scale, sigma) : "- (not determined)";
  };
  return fmt::format(
      "odometry: multiply distances by {}, turns by {}; it strays by {:.1f} mm and {:.2f} deg in 1 m",
      factor(s.scale, s.scale_sigma), factor(s.turn_scale, s.turn_scale_sigma), 1000 * s.way_noise,
      s.turn_noise * deg_per_rad);
}

}  // namespace

std::optional<double> CalibratedSensor::sigma(std::size_t i) const {
  const auto at = static_cast<Eigen::Index>(i);
  const double against = i < 3 && is_found() && estimate.determined[i] ? estimate.covariance(at, at) : 0;
  if (drive.determined[i]) return std::sqrt(drive.covariance(at, at) + (is_held ? against : 0));
  return against > 0 ? std::optional(std::sqrt(against)) : std::nullopt;
}

std::string Drive::advice() const {
  constexpr double step = 0.5;
  const double length = odometry.back().time;
  double turned = 0, sum = 0, square = 0, count = 0;
  for (double t = 0; t + step < length; t += step, ++count) {
    const double turn = std::remainder(track.at(t + step).yaw - track.at(t).yaw, two_pi);
    turned += std::abs(turn), sum += turn, square += turn * turn;
  }
  if (track.way(length) < 10) return "drive farther: 60 s, with curves to both sides";
  if (turned < 60 * rad_per_deg) return "drive curves to both sides, such as an eight";
  if (std::sqrt(std::max(0.0, square / count - std::pow(sum / count, 2))) / step < 0.15)
    return "at a constant turn rate a time offset looks like another place: drive with changing turn rate, "
           "such as an eight";
  return "drive longer, with changing turn rate, where walls and boxes stand on several sides";
}

TextTable calibration_table(const CalibrationReport& report) {
  TextTable table{{"SENSOR", "", "X", "Y", "Z", "ROLL", "PITCH", "YAW", "TIME"}};
  const auto number = [](const CalibrationReport& value) {
    return value.is_null() ? std::string("-") : fmt::format("{:.4f}", value.get<double>());
  };
  for (const auto& [name, sensor] : report["sensors"].items()) {
    for (const char* when : {"before", "after"}) {
      table.push_back({*when == 'b' ? name : "", when});
      for (const char* part : {"xyz", "rpy_deg"}) {
        for (const auto& value : sensor[when][part]) table.back().push_back(number(value));
      }
      table.back().push_back(number(sensor[when]["time_offset"]));
    }
    table.push_back({"", "+-"});
    for (const auto& value : sensor["deviation"]) table.back().push_back(number(value));
  }
  return table;
}

CalibrationReport calibration_report(const std::vector<CalibratedSensor>& sensors,
                                     const MountSolution& solution, const Drive* drive) {
  constexpr const char* verdicts[] = {"reference", "found", "uncertain", "ambiguous", "unconnected"};
  const auto mount = [](const Pose& p, double time_offset) {
    const Eigen::Vector3d at = p.translation(), angles = degrees_of(p);
    return CalibrationReport{{"xyz", {at.x(), at.y(), at.z()}},
                             {"rpy_deg", {angles.x(), angles.y(), angles.z()}},
                             {"time_offset", time_offset}};
  };
  CalibrationReport all = CalibrationReport::object();
  for (const CalibratedSensor& s : sensors) {
    const auto known = [&](std::size_t i, double scale) {
      const auto sigma = s.sigma(i);
      return sigma ? CalibrationReport(scale * *sigma) : CalibrationReport();
    };
    const auto ground = [&](double sigma) {
      return s.ground ? CalibrationReport(sigma) : CalibrationReport();
    };
    const double tilt = ground_tilt_sigma * deg_per_rad;
    all[s.config->name] = {{"verdict", verdicts[static_cast<std::size_t>(s.estimate.verdict)]},
                           {"frames", s.scans.frames()},
                           {"frames_left_out", s.left_out},
                           {"before", mount(s.before, s.time_offset_before())},
                           {"after", mount(s.after, s.time_offset_after())},
                           {"deviation",
                            {{"x", known(0, 1)},
                             {"y", known(1, 1)},
                             {"z", ground(ground_height_sigma)},
                             {"roll_deg", ground(tilt)},
                             {"pitch_deg", ground(tilt)},
                             {"yaw_deg", known(2, deg_per_rad)},
                             {"time_offset", known(3, 1)}}},
                           {"moves", s.drive.moves},
                           {"upside_down", s.estimate.is_mirrored},
                           {"range_offset", s.estimate.range_offset},
                           {"agreement_before", s.estimate.as_configured.share()},
                           {"agreement_after", s.estimate.as_found.share()},
                           {"remark", calibration_sentence(s, drive)}};
  }
  CalibrationReport result = {{"sensors", all}, {"bias", solution.bias}, {"chi_square", solution.chi_square}};
  if (drive == nullptr) return result;
  const DriveSolution& d = drive->solution;
  const auto known = [](double value, double sigma) {
    return sigma < worst_scale ? CalibrationReport(value) : CalibrationReport();
  };
  result["odometry"] = {{"scale", known(d.scale, d.scale_sigma)},
                        {"scale_deviation", known(d.scale_sigma, d.scale_sigma)},
                        {"turn_scale", known(d.turn_scale, d.turn_scale_sigma)},
                        {"turn_scale_deviation", known(d.turn_scale_sigma, d.turn_scale_sigma)},
                        {"noise", d.way_noise},
                        {"turn_noise_deg", d.turn_noise * deg_per_rad},
                        {"remark", odometry_sentence(*drive)}};
  return result;
}

}  // namespace lidard
