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
  const auto percent = [&](std::size_t part) { return beams[part] > 0 ? 100 * passing[part] / beams[part] : -1; };
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
      sights_.push_back({"merged_scans." + merged.name, merged.destination_frame,
                         merged.scan_destination_topic, merged.has_visibility(), false, {}, {}});
      sources_.emplace_back(merged.laserscan_topics.begin(), merged.laserscan_topics.end());
    }
    for (const VirtualScanConfig& group : config_.virtual_scans) {
      for (const std::string& frame : group.virtual_laser_scan) {
        sights_.push_back({"virtual_scans." + group.name + "." + frame, frame, group.topic(frame),
                           group.has_visibility(), false, {}, {}});
        sources_.push_back({group.topic(frame)});
      }
    }
    measure();
    return std::move(sights_);
  }

 private:
  const PlanarScan* scan_of(const FieldSight& sight, const EmptyField& field) const {
    return field.frames().find_scan(sight.topic, sight.frame);
  }
  void measure() {
    std::vector<std::vector<Limit>> causes(sights_.size());
    bool all_free = true;
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      const PlanarScan* const scan = scan_of(sights_[i], field_);
      sights_[i].came = scan != nullptr;
      if (scan == nullptr) continue;
      sights_[i].free = share_of(*scan, [&](std::size_t beam) { return is_free(*scan, beam); });
      all_free = all_free && sights_[i].free.all > 100 - least_share;
      causes[i].assign(scan->beams, Limit::nothing);
    }
    if (all_free) return;
    for (const Limit limit : {Limit::angles, Limit::elevations, Limit::heights, Limit::reach})
      leave_out(limit, causes);
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      if (sights_[i].came) describe(i, causes[i]);
    }
  }
  /// Sets the cause of those beams that are free from now on.
  void leave_out(Limit limit, std::vector<std::vector<Limit>>& causes) const {
    const EmptyField without(config_, limit);
    for (std::size_t i = 0; i < sights_.size(); ++i) {
      const PlanarScan *const before = scan_of(sights_[i], field_), *const now = scan_of(sights_[i], without);
      if (before == nullptr || now == nullptr || now->beams != before->beams) continue;
      for (std::size_t beam = 0; beam < now->beams; ++beam) {
        if (!is_free(*before, beam) && causes[i][beam] == Limit::nothing && is_free(*now, beam))
          causes[i][beam] = limit;
      }
    }
  }
  void describe(std::size_t index, const std::vector<Limit>& causes) {
    FieldSight& sight = sights_[index];
    const PlanarScan& scan = *scan_of(sight, field_);
    const auto add = [&](Limit limit, const std::string& sentence, auto passes) {
      const BeamShares beams = share_of(scan, [&](std::size_t beam) {
        return !is_free(scan, beam) && causes[beam] == limit && passes(beam);
      });
      if (beams.all >= least_share || beams.ahead >= least_share)
        sight.hindrances.push_back({limit, beams, sentence});
    };
    const auto any = [](std::size_t) { return true; };
    add(Limit::angles,
        "no source looks there (fields of view and angles); a scanner that looks there sees it", any);
    add(Limit::elevations, blind_zone(index), any);
    add(Limit::heights, heights(index), any);
    add(Limit::reach,
        "the way is longer than the sources see; lower range_max or free_required (no_return_free_range: 0 "
        "proves nothing at all)",
        any);
    std::set<std::string> before;
    double nearest = near_m;
    std::vector<char> by_outline(scan.beams);
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      if (!is_free(scan, beam) && causes[beam] == Limit::nothing)
        by_outline[beam] = is_behind_outline(index, scan, beam, before, nearest) ? 1 : 0;
    }
    add(Limit::nothing,
        "the vehicle's outline (footprint) ends " + printed("%.2f", nearest) + " m beyond " + listed(before) +
            "; move its edge to the scanner, or the scanner out of it",
        [&](std::size_t beam) { return by_outline[beam] != 0; });
    add(Limit::nothing, "the vehicle itself stands in the way; a scanner on its other side sees there",
        [&](std::size_t beam) { return by_outline[beam] == 0; });
    std::stable_sort(sight.hindrances.begin(), sight.hindrances.end(),
                     [](const Hindrance& a, const Hindrance& b) { return a.beams.all > b.beams.all; });
  }
  /// Calls use(sensor, its pose in the output's frame) for each planar scanner, or each lidar, behind an
  /// output.
  template <class Use>
  void each_sensor(std::size_t index, FrameKind kind, Use use) const {
    for (const SensorConfig& sensor : field_.config().sensors) {
      Pose pose;
      std::string why;
      if (sensor.model->kind != kind || !is_source(sensor.name, index) ||
          !field_.poses().find(sights_[index].frame, sensor.frame_id, Stamp{}, pose, why))
        continue;
      use(sensor, pose);
    }
  }
  bool is_source(const std::string& sensor, std::size_t index) const {
    const std::set<std::string>& sources = sources_[index];
    if (sources.count(sensor) > 0) return true;
    return std::any_of(
        config_.virtual_scans.begin(), config_.virtual_scans.end(), [&](const VirtualScanConfig& group) {
          const auto lidars = config_.lidars_of(group);
          return std::find(lidars.begin(), lidars.end(), sensor) != lidars.end() &&
                 std::any_of(group.virtual_laser_scan.begin(), group.virtual_laser_scan.end(),
                             [&](const std::string& frame) { return sources.count(group.topic(frame)) > 0; });
        });
  }
  std::string blind_zone(std::size_t index) const {
    std::string lidars;
    each_sensor(index, FrameKind::cloud, [&](const SensorConfig& sensor, const Pose& pose) {
      lidars += (lidars.empty() ? "" : ", ") + sensor.name;
      const double height = pose.translation().z(), down = -field_.lowest_elevation(sensor);
      // Of a virtual scan in a merged scan's plane, about.
      if (height > 0 && down > 0) lidars += printed(" (nearer than %.1f m)", height / std::tan(down));
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
  /// Whether some scanner would see along a beam, if the outline ended at the scanner.
  bool is_behind_outline(std::size_t index, const PlanarScan& scan, std::size_t beam,
                         std::set<std::string>& before, double& nearest) const {
    Pose frame;
    std::string why;
    const std::string& base = config_.vehicle.base_frame;
    if (!field_.poses().find(sights_[index].frame, base, Stamp{}, frame, why)) return false;
    const Footprint outline = Footprint(config_.vehicle.footprint).transformed(frame);
    const auto angle = static_cast<double>(scan.angle(beam));
    bool found = false;
    each_sensor(index, FrameKind::scan, [&](const SensorConfig& sensor, const Pose& pose) {
      const auto pieces =
          outline.crossings(pose.translation().head<2>(), {std::cos(angle), std::sin(angle)});
      if (pieces.empty() || pieces.front().out >= near_m) return;
      found = true;
      before.insert(sensor.name);
      nearest = std::min(nearest, pieces.front().out);
    });
    return found;
  }

  const Config& config_;
  const EmptyField& field_;
  std::vector<FieldSight> sights_;
  std::vector<std::set<std::string>> sources_;  // of each one, as they are named in the configuration
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
