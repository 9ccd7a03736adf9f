// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/field_sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "core/evidence/beam_rays.h"

namespace lidard {
namespace {

constexpr double ahead_rad = 30 * rad_per_deg;
/// An outline that ends so far before a scanner, m, is drawn too far out; otherwise the vehicle stands there.
constexpr double near_m = 1;
/// Shares below are not worth a sentence, %.
constexpr double least_share = 0.5;

/// The share of the beams that pass.
template <class Passes>
BeamShares share_of(const PlanarScan& scan, Passes passes) {
  double passing = 0, ahead = 0, passing_ahead = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const bool is_ahead = std::abs(std::remainder(static_cast<double>(scan.angle(i)), two_pi)) <= ahead_rad;
    const bool does_pass = passes(i);
    passing += does_pass ? 1 : 0;
    ahead += is_ahead ? 1 : 0;
    passing_ahead += is_ahead && does_pass ? 1 : 0;
  }
  return {100 * passing / static_cast<double>(scan.beams), ahead > 0 ? 100 * passing_ahead / ahead : -1};
}

bool is_free(const PlanarScan& scan, std::size_t beam) { return scan.statuses[beam] == BeamStatus::none; }

/// The scan of an output in a field, or nullptr.
const PlanarScan* scan_of(const FieldSight& sight, const EmptyField& field) {
  return field.frames().find_scan(sight.topic, sight.frame);
}

void add_lidars(const Config& config, const VirtualScanConfig& group, FieldSight& sight) {
  for (const std::string& lidar : config.lidars_of(group)) sight.sensors.insert(lidar);
}

/// The outputs of a configuration, of which nothing is known yet.
std::vector<FieldSight> outputs_of(const Config& config) {
  std::vector<FieldSight> outputs;
  for (const MergedScanConfig& merged : config.merged_scans) {
    FieldSight& sight =
        outputs.emplace_back(FieldSight{"merged_scans." + merged.name, merged.destination_frame,
                                        merged.scan_destination_topic, merged.has_visibility()});
    sight.sensors.insert(merged.laserscan_topics.begin(), merged.laserscan_topics.end());
    for (const VirtualScanConfig& group : config.virtual_scans) {
      for (const std::string& frame : group.virtual_laser_scan)
        if (sight.sensors.count(group.topic(frame)) > 0) add_lidars(config, group, sight);
    }
  }
  for (const VirtualScanConfig& group : config.virtual_scans) {
    for (const std::string& frame : group.virtual_laser_scan)
      add_lidars(config, group,
                 outputs.emplace_back(FieldSight{"virtual_scans." + group.name + "." + frame, frame,
                                                 group.topic(frame), group.has_visibility()}));
  }
  return outputs;
}

/// Finds what is in the way of one output, by leaving out one limit after the other.
class Inquiry {
 public:
  Inquiry(const EmptyField& field, FieldSight& sight)
      : field_(field), sight_(sight), scan_(*scan_of(sight, field)) {}

  /// Adds the beams that are free without limits, but not with this one alone.
  void compare(Limit limit, const EmptyField& limited, const EmptyField& unlimited) {
    const PlanarScan* const with = scan_of(sight_, limited);
    const PlanarScan* const without = scan_of(sight_, unlimited);
    if (with == nullptr || without == nullptr) return;
    add(limit, sentence_of(limit),
        [&](std::size_t beam) { return is_free(*without, beam) && !is_free(*with, beam); });
  }

  /// Adds the beams that are not free without limits either.
  void find_outline(const EmptyField& unlimited) {
    Pose vehicle;
    std::string why;
    const PlanarScan* const without = scan_of(sight_, unlimited);
    const VehicleConfig& config = field_.config().vehicle;
    if (without == nullptr || !field_.poses().find(sight_.frame, config.base_frame, Stamp{}, vehicle, why))
      return;
    const Footprint outline = Footprint(config.footprint).transformed(vehicle);
    std::string before;
    double nearest = near_m;
    std::vector<char> by_outline(without->beams);
    each_sensor(FrameKind::scan, [&](const SensorConfig& sensor, const Pose& pose) {
      bool is_behind = false;
      for (std::size_t beam = 0; beam < without->beams; ++beam) {
        const double ahead = to_edge(outline, pose, static_cast<double>(without->angle(beam)));
        if (is_free(*without, beam) || ahead >= near_m) continue;
        by_outline[beam] = 1;
        is_behind = true;
        nearest = std::min(nearest, ahead);
      }
      if (is_behind) before += (before.empty() ? "" : ", ") + sensor.name;
    });
    add(Limit::none,
        "the vehicle's outline (footprint) ends " + printed("%.2f", nearest) + " m beyond " + before +
            "; move its edge to the scanner, or the scanner out of it",
        [&](std::size_t beam) { return by_outline[beam] != 0; });
    add(Limit::none, "the vehicle itself stands in the way; a scanner on its other side sees there",
        [&](std::size_t beam) { return by_outline[beam] == 0 && !is_free(*without, beam); });
  }

 private:
  /// Adds a hindrance: the beams that pass and are not free.
  template <class Passes>
  void add(Limit limit, const std::string& sentence, Passes passes) {
    const BeamShares beams =
        share_of(scan_, [&](std::size_t beam) { return !is_free(scan_, beam) && passes(beam); });
    if (beams.all >= least_share || beams.ahead >= least_share)
      sight_.hindrances.push_back({limit, beams, sentence});
  }
  std::string sentence_of(Limit limit) const {
    if (limit == Limit::elevations) return blind_zone();
    if (limit == Limit::heights) return heights();
    if (limit == Limit::angles)
      return "no source looks there (fields of view and angles); a scanner that looks there sees it";
    return "the way is longer than the sources see; lower range_max or free_required (a source with "
           "no_return_free_range: 0 proves nothing)";
  }
  /// Calls use(sensor, its pose in the output's frame) for each planar scanner, or each lidar, behind the
  /// output.
  template <class Use>
  void each_sensor(FrameKind kind, Use use) const {
    for (const SensorConfig& sensor : field_.config().sensors) {
      Pose pose;
      std::string why;
      if (sensor.model->kind == kind && sight_.sensors.count(sensor.name) > 0 &&
          field_.poses().find(sight_.frame, sensor.frame_id, Stamp{}, pose, why))
        use(sensor, pose);
    }
  }
  std::string blind_zone() const {
    std::string lidars;
    each_sensor(FrameKind::cloud, [&](const SensorConfig& sensor, const Pose& pose) {
      lidars += (lidars.empty() ? "" : ", ") + sensor.name;
      if (const double range = field_.blind_range(sensor, pose); range > 0)
        lidars += printed(" (nearer than %.1f m)", range);
    });
    return "the blind zone of " + lidars +
           ", where no ring meets the plane; merge it with scanners at that height, or mount the lidar lower "
           "or tilted";
  }
  std::string heights() const {
    std::string planes;
    each_sensor(FrameKind::scan, [&](const SensorConfig& sensor, const Pose& pose) {
      const double tilt = std::acos(std::min(1.0, std::abs(pose.linear()(2, 2)))) * deg_per_rad;
      planes += (planes.empty() ? "" : ", ") + sensor.name + printed(" %.2f m", pose.translation().z()) +
                (tilt > 0.05 ? printed(", tilted by %.1f degrees", tilt) : "");
    });
    return "another height: above " + sight_.frame + " stand " + planes +
           "; mount them level at one height, or widen min_height and max_height";
  }
  /// m from a scanner to the near edge of the outline before it that a beam of the output crosses; infinite:
  /// it crosses none.
  static double to_edge(const Footprint& outline, const Pose& scanner, double angle) {
    const Eigen::Vector2d at = scanner.translation().head<2>(), looks = scanner.linear().col(0).head<2>();
    const Eigen::Vector2d beam(std::cos(angle), std::sin(angle));
    const auto& corners = outline.vertices();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      // The corners are counter-clockwise: the outside lies right of each edge.
      const Eigen::Vector2d& a = corners[i];
      const Eigen::Vector2d edge = corners[(i + 1) % corners.size()] - a;
      const Eigen::Vector2d outward = Eigen::Vector2d(edge.y(), -edge.x()).normalized();
      const double ahead = outward.dot(a - at), crossed = ahead / outward.dot(beam);
      const double along = (at + crossed * beam - a).dot(edge) / edge.squaredNorm();
      const bool is_before = outward.dot(looks) > 0.3 && ahead > 0.005 && ahead < near_m;
      if (is_before && crossed > 0 && along >= 0 && along <= 1) return ahead;
    }
    return std::numeric_limits<double>::infinity();
  }

  const EmptyField& field_;
  FieldSight& sight_;
  const PlanarScan& scan_;
};

}  // namespace

std::vector<FieldSight> sights_of(const Config& config, const EmptyField& field) {
  std::vector<FieldSight> sights = outputs_of(config);
  std::vector<Inquiry> inquiries;  // of what is not free
  for (FieldSight& sight : sights) {
    const PlanarScan* const scan = scan_of(sight, field);
    sight.came = scan != nullptr;
    if (scan == nullptr) continue;
    sight.free = share_of(*scan, [&](std::size_t beam) { return is_free(*scan, beam); });
    if (sight.free.all <= 100 - least_share) inquiries.emplace_back(field, sight);
  }
  if (inquiries.empty()) return sights;
  const EmptyField unlimited(config, Limit::none);
  for (const Limit limit : {Limit::angles, Limit::elevations, Limit::heights, Limit::reach}) {
    const EmptyField limited(config, limit);
    for (Inquiry& inquiry : inquiries) inquiry.compare(limit, limited, unlimited);
  }
  for (Inquiry& inquiry : inquiries) inquiry.find_outline(unlimited);
  for (FieldSight& sight : sights)
    std::stable_sort(sight.hindrances.begin(), sight.hindrances.end(),
                     [](const Hindrance& a, const Hindrance& b) { return a.beams.all > b.beams.all; });
  return sights;
}

std::string to_text(const BeamShares& shares) {
  return printed("%.3g %% of the beams", shares.all) +
         (shares.ahead < 0 ? "" : printed(" (ahead %.3g %%)", shares.ahead));
}

std::string comments_of(const std::vector<FieldSight>& sights, const EmptyField& field) {
  if (sights.empty()) return {};
  std::string text =
      "# Which beams can be +inf in an empty field; ahead: within 30 degrees of x of the output's frame.\n";
  for (const std::string& name : field.assumed())
    text += "# " + name + ": its field of view is not known, assumed: that of a " +
            std::string(usual_model(field.config().find_sensor(name)->model->kind).product) + "\n";
  for (const FieldSight& sight : sights) {
    text += "# " + sight.entry + ": ";
    if (!sight.came) {
      text += "not known, since a pose comes from tf only\n";
      continue;
    }
    text += to_text(sight.free) + (sight.proves ? "" : " in profile strict; flatten proves nothing") + "\n";
    for (const Hindrance& one : sight.hindrances)
      text += "#   " + to_text(one.beams) + ": " + one.sentence + "\n";
  }
  return text;
}

}  // namespace lidard
