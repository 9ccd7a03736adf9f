// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/field_sight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <set>

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
  std::array<double, 2> beams{}, passing{};
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const bool is_ahead = std::abs(std::remainder(static_cast<double>(scan.angle(i)), two_pi)) <= ahead_rad;
    for (std::size_t part = 0; part <= (is_ahead ? 1U : 0U); ++part) {
      ++beams[part];
      passing[part] += passes(i) ? 1 : 0;
    }
  }
  const auto percent = [&](std::size_t part) {
    return beams[part] > 0 ? 100 * passing[part] / beams[part] : -1;
  };
  return {percent(0), percent(1)};
}

bool is_free(const PlanarScan& scan, std::size_t beam) { return scan.statuses[beam] == BeamStatus::none; }

std::string listed(const std::set<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

/// Finds what is in the way, by leaving out one limit after the other.
class Inquiry {
 public:
  Inquiry(const Config& config, const EmptyField& field) : config_(config), field_(field) {}

  std::vector<FieldSight> run() {
    for (const MergedScanConfig& merged : config_.merged_scans) {
      const std::string &frame = merged.destination_frame, &topic = merged.scan_destination_topic;
      sights_.push_back({"merged_scans." + merged.name, frame, topic, merged.has_visibility()});
      sensors_.emplace_back(merged.laserscan_topics.begin(), merged.laserscan_topics.end());
      for (const VirtualScanConfig& group : config_.virtual_scans) {
        for (const std::string& source : group.virtual_laser_scan)
          if (sensors_.back().count(group.topic(source)) > 0) add_lidars(group);
      }
    }
    for (const VirtualScanConfig& group : config_.virtual_scans) {
      for (const std::string& frame : group.virtual_laser_scan) {
        const std::string entry = "virtual_scans." + group.name + "." + frame;
        sights_.push_back({entry, frame, group.topic(frame), group.has_visibility()});
        sensors_.emplace_back();
        add_lidars(group);
      }
    }
    measure();
    return std::move(sights_);
  }

 private:
  void add_lidars(const VirtualScanConfig& group) {
    for (const std::string& lidar : config_.lidars_of(group)) sensors_.back().insert(lidar);
  }
  const PlanarScan* scan_of(const FieldSight& sight, const EmptyField& field) const {
    return field.frames().find_scan(sight.topic, sight.frame);
  }
  void measure() {
    bool all_free = true;
    for (FieldSight& sight : sights_) {
      const PlanarScan* const scan = scan_of(sight, field_);
      sight.came = scan != nullptr;
      if (scan == nullptr) continue;
      sight.free = share_of(*scan, [&](std::size_t beam) { return is_free(*scan, beam); });
      all_free = all_free && sight.free.all > 100 - least_share;
    }
    if (all_free) return;
    const EmptyField unlimited(config_, Limit::none);
    for (const Limit limit : {Limit::angles, Limit::elevations, Limit::heights, Limit::reach}) {
      const EmptyField limited(config_, limit);
      for (std::size_t i = 0; i < sights_.size(); ++i) compare(i, limit, limited, unlimited);
    }
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      if (sights_[i].came) find_outline(i, unlimited);
    }
  }
  /// Adds a hindrance: the beams that pass and are not free.
  template <class Passes>
  void add(std::size_t index, Limit limit, const std::string& sentence, Passes passes) {
    const PlanarScan& scan = *scan_of(sights_[index], field_);
    const BeamShares beams =
        share_of(scan, [&](std::size_t beam) { return !is_free(scan, beam) && passes(beam); });
    if (beams.all >= least_share || beams.ahead >= least_share)
      sights_[index].hindrances.push_back({limit, beams, sentence});
  }
  /// Adds the beams that are free without limits, but not with this one alone.
  void compare(std::size_t index, Limit limit, const EmptyField& limited, const EmptyField& unlimited) {
    const PlanarScan* const with = scan_of(sights_[index], limited);
    const PlanarScan* const without = scan_of(sights_[index], unlimited);
    if (!sights_[index].came || with == nullptr || without == nullptr) return;
    add(index, limit, sentence_of(limit, index),
        [&](std::size_t beam) { return is_free(*without, beam) && !is_free(*with, beam); });
  }
  std::string sentence_of(Limit limit, std::size_t index) const {
    if (limit == Limit::elevations) return blind_zone(index);
    if (limit == Limit::heights) return heights(index);
    if (limit == Limit::angles)
      return "no source looks there (fields of view and angles); a scanner that looks there sees it";
    return "the way is longer than the sources see; lower range_max or free_required (a source with "
           "no_return_free_range: 0 proves nothing)";
  }
  /// Adds the beams that are not free without limits either.
  void find_outline(std::size_t index, const EmptyField& unlimited) {
    const PlanarScan* const without = scan_of(sights_[index], unlimited);
    if (without == nullptr) return;
    std::set<std::string> before;
    double nearest = near_m;
    std::vector<char> by_outline(without->beams);
    for (std::size_t beam = 0; beam < without->beams; ++beam)
      by_outline[beam] =
          !is_free(*without, beam) && is_behind_outline(index, *without, beam, before, nearest) ? 1 : 0;
    add(index, Limit::none,
        "the vehicle's outline (footprint) ends " + printed("%.2f", nearest) + " m beyond " + listed(before) +
            "; move its edge to the scanner, or the scanner out of it",
        [&](std::size_t beam) { return by_outline[beam] != 0; });
    add(index, Limit::none, "the vehicle itself stands in the way; a scanner on its other side sees there",
        [&](std::size_t beam) { return by_outline[beam] == 0 && !is_free(*without, beam); });
    auto& all = sights_[index].hindrances;
    std::stable_sort(all.begin(), all.end(),
                     [](const Hindrance& a, const Hindrance& b) { return a.beams.all > b.beams.all; });
  }
  /// Calls use(sensor, its pose in the output's frame) for each planar scanner, or each lidar, behind an
  /// output.
  template <class Use>
  void each_sensor(std::size_t index, FrameKind kind, Use use) const {
    for (const SensorConfig& sensor : field_.config().sensors) {
      Pose pose;
      std::string why;
      if (sensor.model->kind != kind || sensors_[index].count(sensor.name) == 0 ||
          !field_.poses().find(sights_[index].frame, sensor.frame_id, Stamp{}, pose, why))
        continue;
      use(sensor, pose);
    }
  }
  std::string blind_zone(std::size_t index) const {
    std::string lidars;
    each_sensor(index, FrameKind::cloud, [&](const SensorConfig& sensor, const Pose& pose) {
      lidars += (lidars.empty() ? "" : ", ") + sensor.name;
      if (const double range = EmptyField::blind_range(sensor, pose); range > 0)
        lidars += printed(" (nearer than %.1f m)", range);
    });
    return "the blind zone of " + lidars +
           ", where no ring meets the plane; merge it with scanners at that height, or mount the lidar lower "
           "or tilted";
  }
  std::string heights(std::size_t index) const {
    std::string planes;
    each_sensor(index, FrameKind::scan, [&](const SensorConfig& sensor, const Pose& pose) {
      const double tilt = std::acos(std::min(1.0, std::abs(pose.linear()(2, 2)))) * deg_per_rad;
      planes += (planes.empty() ? "" : ", ") + sensor.name + printed(" %.2f m", pose.translation().z()) +
                (tilt > 0.05 ? printed(", tilted by %.1f degrees", tilt) : "");
    });
    return "another height: above " + sights_[index].frame + " stand " + planes +
           "; mount them level at one height, or widen min_height and max_height";
  }
  /// Whether an edge of the outline lies before a scanner, where it looks along a beam.
  bool is_behind_outline(std::size_t index, const PlanarScan& scan, std::size_t beam,
                         std::set<std::string>& before, double& nearest) const {
    Pose vehicle;
    std::string why;
    if (!field_.poses().find(sights_[index].frame, config_.vehicle.base_frame, Stamp{}, vehicle, why))
      return false;
    const auto angle = static_cast<double>(scan.angle(beam));
    const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
    const std::vector<Eigen::Vector2d> corners =
        Footprint(config_.vehicle.footprint).transformed(vehicle).vertices();
    bool found = false;
    each_sensor(index, FrameKind::scan, [&](const SensorConfig& sensor, const Pose& pose) {
      const Eigen::Vector2d at = pose.translation().head<2>(), looks = pose.linear().col(0).head<2>();
      for (std::size_t i = 0; i < corners.size(); ++i) {
        // The corners are counter-clockwise: the outside lies right of each edge.
        const Eigen::Vector2d a = corners[i], edge = (corners[(i + 1) % corners.size()] - a);
        const Eigen::Vector2d outward = Eigen::Vector2d(edge.y(), -edge.x()).normalized();
        const double ahead = outward.dot(a - at), crossed = ahead / outward.dot(ray);
        const double along = (at + crossed * ray - a).dot(edge) / edge.squaredNorm();
        if (!(outward.dot(looks) > 0.3 && ahead > 0.005 && ahead < near_m && crossed > 0 && along >= 0 &&
              along <= 1))
          continue;
        found = true;
        before.insert(sensor.name);
        nearest = std::min(nearest, ahead);
      }
    });
    return found;
  }

  const Config& config_;
  const EmptyField& field_;
  std::vector<FieldSight> sights_;
  std::vector<std::set<std::string>> sensors_;  // behind each one
};

}  // namespace

std::vector<FieldSight> sights_of(const Config& config, const EmptyField& field) {
  return Inquiry(config, field).run();
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
    text += "# " + name + ": its field of view is not known, " +
            std::string(field.config().find_sensor(name)->model->product) + "\n";
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
