// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "core/merge/merger.h"
#include "core/merge/mount_check.h"
#include "core/merge/scheduler.h"
#include "daemon/pipeline/output.h"
#include "daemon/pipeline/pose_gate.h"

namespace lidard {
namespace {

MergeSettings settings_of(const MergedScanConfig& config) {
  MergeSettings settings;
  settings.points = config.output.profile == Profile::flatten || !config.cloud_destination_topic.empty();
  for (const AlsoScanConfig& also : config.also) settings.points |= also.profile == Profile::flatten;
  settings.visibility = config.has_visibility() || !config.status_topic.empty();
  settings.how.noise = settings.source.noise = config.range_noise;
  settings.how.free_required = config.free_required;
  settings.source.echoes = config.echoes;
  settings.source.veil_filter = config.veil_filter;
  for (const std::string& name : config.laserscan_topics) {
    const auto own = config.source_settings.find(name);
    settings.each.push_back(own == config.source_settings.end() ? settings.source : own->second);
  }
  return settings;
}

/// What to add to the pose of the pair's second source, in the output frame.
std::string correction_of(const OverlapState& pair) {
  const auto part = [&](std::size_t i, const char* name, double value, const char* unit) {
    return pair.determined[i] ? fmt::format("{} {:+.3f} {}", name, value, unit)
                              : fmt::format("{} not determined by the surroundings", name);
  };
  constexpr double degrees = 57.29577951308232;
  return part(0, "yaw", pair.correction[0] * degrees, "deg") + ", " + part(1, "x", pair.correction[1], "m") +
         ", " + part(2, "y", pair.correction[2], "m");
}

/// A stamp to tell a sweep's age by. Stamps that are far from the time at hand are of another clock, a bag's
/// or a simulator's: then the arrival counts.
Stamp comparable(Stamp stamp, Stamp now) {
  constexpr Span another_clock = std::chrono::seconds(10);
  return now - stamp > another_clock || stamp - now > another_clock ? now : stamp;
}

/// A merged scan: takes the scans of its sources, publishes when one is due.
class MergedOutput final : public Output {
 public:
  MergedOutput(const MergedScanConfig& config, const OutputContext& context)
      : config_(config),
        context_(context),
        poses_(context.poses),
        footprint_(context.vehicle.footprint),
        scheduler_(config.laserscan_topics.size(), config.schedule),
        overlap_(config.laserscan_topics.size()),
        compared_(config.laserscan_topics.size(), nullptr),
        places_(config.laserscan_topics.size(), Eigen::Vector2d::Zero()),
        reported_(config.laserscan_topics.size()),
        why_unplaced_(config.laserscan_topics.size()),
        taken_(config.laserscan_topics.size(), 0) {
    const auto topic = [&](const std::string& name) {
      return name.empty() ? nullptr : &context.outlet.topic(name);
    };
    scan_topics_ = {topic(config.scan_destination_topic)};
    for (const AlsoScanConfig& also : config.also) scan_topics_.push_back(topic(also.topic));
    cloud_topic_ = topic(config.cloud_destination_topic);
    status_topic_ = topic(config.status_topic);
    cloud_.frame_id = config.destination_frame;
    status_.frame_id = config.destination_frame;
    set_up();
  }

  OutputId id() const override { return {OutputId::Kind::merged, config_.name}; }
  bool is_of(const MergedScanConfig& entry) const override { return config_ == entry; }
  std::vector<std::string> sources() const override { return config_.laserscan_topics; }
  void add_scan(std::size_t source, const PlanarScan& scan, Stamp now) override {
    Pose pose;
    if (!place_footprint(scan.stamp) ||
        !poses_.find(config_.destination_frame, scan.frame_id, scan.stamp, pose, counters_.why_no_pose)) {
      ++counters_.no_pose;
      why_unplaced_[source] = counters_.why_no_pose;
      return;
    }
    why_unplaced_[source].clear();
    if (!merger_->add(source, scan, pose)) return;
    taken_[source] = 1;
    scheduler_.delivered(source, comparable(merger_->times(source)->last(), now),
                         static_cast<double>(scan.scan_time), now);
    advance(now);
  }
  void advance(Stamp now) override {
    if (!scheduler_.is_due(now)) return due_since_.reset();
    if (lacks_sweeps(now)) return;
    const MergeMoment moment = moment_of(now);
    if (!due_since_) due_since_ = now;
    const bool lacks_poses = config_.on_missing_motion != MissingMotion::stand && !has_poses(moment, now);
    const bool drops = config_.on_missing_motion == MissingMotion::drop;
    if (lacks_poses && !drops && PoseGate::may_wait(*due_since_, scheduler_.deadline(), now)) return;
    due_since_.reset();
    if (!lacks_poses || !drops) return publish(moment, now);
    gate_.left_out("on_missing_motion: drop, and poses of the vehicle are missing");
    scheduler_.done(now);
  }
  std::optional<Stamp> next_event() const override {
    const auto event = scheduler_.next_event();
    if (!due_since_) return event;
    const Stamp given_up = *due_since_ + scheduler_.deadline();
    return event ? std::min(*event, given_up) : given_up;
  }
  bool states_changed(Stamp now) override {
    const Span passed = now - std::exchange(looked_at_, now);
    bool changed = false;
    for (std::size_t s = 0; s < reported_.size(); ++s)
      changed = reported_[s].update(scheduler_.state(s, now), passed) || changed;
    return changed;
  }
  void set_scan(const OutputScanConfig& wanted) override {
    config_.output = wanted;
    set_up();
    overlap_ = MountCheck(config_.laserscan_topics.size());
    due_since_.reset();
    uses_.clear();
    latency_ = skew_ = Span(0);
  }
  void restart() override {
    merger_->reset();
    scheduler_.reset();
    overlap_.reset();
    stamps_.reset();
    due_since_.reset();
  }
  bool publishes(const std::string& topic) const override {
    const auto has = [&](const OutputTopic* own) { return own != nullptr && own->name == topic; };
    return has(cloud_topic_) || has(status_topic_) ||
           std::any_of(scan_topics_.begin(), scan_topics_.end(), has);
  }
  std::string why_missing(const std::string&, const WhySilent& why_silent) const override {
    std::string missing;
    for (std::size_t s = 0; s < taken_.size(); ++s) {
      if (taken_[s] != 0) continue;
      const std::string& name = config_.laserscan_topics[s];
      const std::string why = why_unplaced_[s].empty()
                                  ? "source " + name + " gave no scans" + why_silent(name)
                                  : "no pose for source " + name + ": " + why_unplaced_[s];
      missing += (missing.empty() ? "" : "; ") + why;
    }
    if (counters_.published > 0 || !missing.empty()) return missing;
    if (!gate_.trouble().empty()) return gate_.trouble();
    return std::string("no output was due with policy ") + to_string(config_.schedule.policy);
  }
  DiagnosticItem diagnostics(Stamp now, bool starting) const override {
    DiagnosticItem item = health_of("merged " + config_.name, counters_, now, starting);
    describe_sources(item, now, starting);
    describe_motion(item);
    describe_beams(item);
    describe_overlap(item);
    const bool same_clock = comparable(now - latency_, now) != now || latency_ == Span(0);
    item.add("Latency (ms)",
             same_clock ? fmt::format("{:.1f}", seconds(latency_) * 1000) : "stamps are of another clock");
    item.add("Skew of the sources (ms)", fmt::format("{:.1f}", seconds(skew_) * 1000));
    item.add("Sources waited for in vain", scheduler_.deadlines_missed());
    item.add("Sweeps replaced before use", merger_->superseded());
    item.add("Sweeps out of order", merger_->out_of_order());
    item.add("Sweeps with impossible times", merger_->bad_times());
    return item;
  }

 private:
  /// Makes what depends on the grid and the profiles.
  void set_up() {
    merger_.emplace(grid_of(config_.output.grid), band_of(config_.output), config_.laserscan_topics.size(),
                    settings_of(config_));
    footprint_placed_.reset();
    scans_.assign(1 + config_.also.size(), PlanarScan());
    set_encoding(config_.output, scans_[0]);
    for (PlanarScan& scan : scans_) scan.frame_id = config_.destination_frame;
    merged_ = {{config_.output.profile, &scans_[0]}};
    for (std::size_t i = 0; i < config_.also.size(); ++i)
      merged_.push_back({config_.also[i].profile, &scans_[i + 1]});
  }
  bool place_footprint(Stamp stamp) {
    if (footprint_.empty()) return true;
    Pose pose;
    if (!poses_.find(config_.destination_frame, context_.vehicle.base_frame, stamp, pose,
                     counters_.why_no_pose))
      return false;
    if (footprint_placed_ && footprint_placed_->matrix() == pose.matrix()) return true;
    footprint_placed_ = pose;
    merger_->set_footprint(footprint_.transformed(pose));
    return true;
  }
  /// The instant that the beams are brought to.
  MergeMoment moment_of(Stamp now) {
    MergeMoment moment;
    const std::vector<char>& use = scheduler_.usable(now);
    std::optional<Stamp> first, oldest, newest;
    for (std::size_t s = 0; s < use.size(); ++s) {
      const auto times = merger_->times(s);
      if (use[s] == 0 || !times) continue;
      first = std::max(first.value_or(times->first), times->first);
      oldest = std::min(oldest.value_or(times->last()), times->last());
      newest = std::max(newest.value_or(times->last()), times->last());
    }
    skew_ = newest ? *newest - *oldest : Span(0);
    const PoseTrack* const track = poses_.track();
    moment.at = first.value_or(now);
    if (newest && track != nullptr && !track->empty()) {
      // A transform to the odometry frame exists for stamps up to the newest pose.
      moment.at = config_.schedule.policy == Policy::rate ? now : *newest;
      moment.at = std::max(*first, std::min(moment.at, track->newest()));
      moment.track = track;
    }
    if (moment.track != nullptr && !poses_.find(config_.destination_frame, context_.vehicle.base_frame,
                                                moment.at, moment.output_from_base, counters_.why_no_pose))
      moment.track = nullptr;
    return moment;
  }
  /// After a change of the grid the sources that are well have to deliver again, lest what they see be
  /// missing.
  bool lacks_sweeps(Stamp now) const {
    for (std::size_t s = 0; s < config_.laserscan_topics.size(); ++s) {
      if (scheduler_.state(s, now) == SourceState::ok && !merger_->times(s)) return true;
    }
    return false;
  }
  /// True if the way of the vehicle is known for all sweeps of an output, or nobody knows how it moves.
  bool has_poses(const MergeMoment& moment, Stamp now) {
    const std::vector<char>& use = scheduler_.usable(now);
    bool known = true;
    for (std::size_t s = 0; s < use.size(); ++s)
      known = known && (use[s] == 0 || merger_->poses_cover(s, moment));
    return known || poses_.track() == nullptr;
  }
  void publish(MergeMoment moment, Stamp now) {
    moment.at = stamps_.next(moment.at);
    const MergeReport& report =
        merger_->merge(moment, scheduler_.usable(now), merged_, cloud_topic_ != nullptr ? &cloud_ : nullptr);
    scheduler_.done(now);
    uses_ = report.sources;
    const bool stands = std::count(uses_.begin(), uses_.end(), SourceUse::static_poses) > 0;
    gate_.published(poses_.track() == nullptr || !stands);
    latency_ = now - moment.at;
    ++counters_.published;
    counters_.last_published = now;
    compare_sources(moment.at);
    for (std::size_t i = 0; i < scans_.size(); ++i) context_.outlet.publish(*scan_topics_[i], scans_[i], now);
    if (cloud_topic_ != nullptr) context_.outlet.publish(*cloud_topic_, cloud_, now);
    if (status_topic_ == nullptr) return;
    fill_status();
    context_.outlet.publish(*status_topic_, status_, now);
  }
  void fill_status() {
    const Visibility& visibility = *merger_->visibility();
    const PlanarScan& scan = scans_[0];
    status_.reset(scan.beams);
    status_.set_angles(scan.angle_min, scan.angle_increment);
    status_.stamp = scan.stamp;
    status_.scan_time = scan.scan_time;
    status_.range_max = scan.range_max;
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      status_.set_hit(beam, std::min(visibility.covered(beam), scan.range_max));
      status_.intensities[beam] = static_cast<float>(visibility.state(beam));
    }
  }
  /// Compares what the sources of the output just made see of the same surfaces.
  void compare_sources(Stamp stamp) {
    if (merger_->visibility() == nullptr || !overlap_.is_due(stamp)) return;
    for (std::size_t s = 0; s < compared_.size(); ++s) {
      compared_[s] = merger_->sweep(s);
      places_[s] = merger_->looks_from(s);
    }
    const auto moved = [](SourceUse use) { return use == SourceUse::static_poses; };
    overlap_.look(stamp, compared_, places_,
                  poses_.track() != nullptr && std::none_of(uses_.begin(), uses_.end(), moved));
  }
  void describe_motion(DiagnosticItem& item) const {
    if (poses_.track() == nullptr) return;
    const auto has = [this](SourceUse use) { return std::count(uses_.begin(), uses_.end(), use) > 0; };
    item.add("Motion", poses_.track()->empty()        ? "no poses yet"
                       : has(SourceUse::static_poses) ? "not deskewed: poses of the sweeps' time are missing"
                       : has(SourceUse::extrapolated) ? "deskewed, partly beyond the newest pose"
                                                      : "deskewed");
    gate_.describe(item);
  }
  void describe_sources(DiagnosticItem& item, Stamp now, bool starting) const {
    std::string silent, lost;
    // Whether any source delivers, and whether all that are lost have never come.
    bool delivers = false, awaited = true;
    for (std::size_t s = 0; s < config_.laserscan_topics.size(); ++s) {
      const std::string& name = config_.laserscan_topics[s];
      const SourceState state = scheduler_.state(s, now);
      std::string text = to_string(state);
      const double period = scheduler_.period(s), age_ms = seconds(scheduler_.age(s, now)) * 1000;
      if (state != SourceState::never)
        text += fmt::format(", {:.1f} Hz, age {:.0f} ms", period > 0 ? 1 / period : 0, age_ms);
      item.add("Source " + name, text);
      const SourceState seen = reported_[s].state();
      std::string& list = seen == SourceState::stale ? silent : lost;
      if (seen != SourceState::ok) list += (list.empty() ? "" : ", ") + name;
      delivers = delivers || seen == SourceState::ok;
      awaited = awaited && seen != SourceState::lost;
    }
    item.add("Sources lost", lost);
    if (starting || item.health != Health::ok || (lost.empty() && silent.empty())) return;
    item.set(lost.empty() ? Health::warn : Health::error,
             "publishing without " + (lost.empty() ? silent + ", whose sweeps are too old" : lost));
    if (!delivers) item.message = "no output, since no source delivers: see the state of its sensors";
    item.awaited = awaited;
    if (counters_.no_pose > 0 && !counters_.why_no_pose.empty()) item.message += ": " + counters_.why_no_pose;
  }
  void describe_beams(DiagnosticItem& item) const {
    const PlanarScan& scan = scans_[0];
    if (scan.beams == 0) return;
    const auto share = [&](BeamStatus status) {
      const auto n = std::count(scan.statuses.begin(), scan.statuses.end(), status);
      return fmt::format("{:.1f} %", 100.0 * static_cast<double>(n) / static_cast<double>(scan.beams));
    };
    item.add("Beams with a hit", share(BeamStatus::hit));
    item.add("Beams free", share(BeamStatus::none));
    item.add("Beams unobserved", share(BeamStatus::invalid));
  }
  void describe_overlap(DiagnosticItem& item) const {
    for (const OverlapState& pair : overlap_.pairs()) {
      const std::string& first = config_.laserscan_topics[pair.first];
      const std::string& second = config_.laserscan_topics[pair.second];
      if (pair.beams <= 0) continue;
      const std::string correction = correction_of(pair);
      item.add(fmt::format("MountCheck {}/{}", first, second),
               fmt::format("median {:+.1f} mm, MAD {:.1f} mm, {:.0f} beams; mount of {}: {}",
                           pair.median * 1000, pair.mad * 1000, pair.beams, second, correction));
      if (!pair.misaligned || item.health != Health::ok) continue;
      const std::time_t since = pair.since ? pair.since->ns / 1'000'000'000 : 0;
      item.set(
          Health::warn,
          fmt::format(
              "{0} and {1} do not agree on where surfaces are; correct a mount, e.g. that of {1} by {2} "
              "(since {3:%H:%M:%S} UTC; `lidard calibrate -c FILE CAPTURE` of the parked vehicle finds it)",
              first, second, correction, fmt::gmtime(since)));
    }
  }

  MergedScanConfig config_;
  const OutputContext& context_;
  const FrameTree& poses_;
  Footprint footprint_;                   // in base_frame
  std::optional<Pose> footprint_placed_;  // base_frame in the output frame when it was last set
  std::optional<Merger> merger_;
  Scheduler scheduler_;
  MountCheck overlap_;
  std::vector<const PlacedScan*> compared_;
  std::vector<Eigen::Vector2d> places_;
  std::vector<ReportedState> reported_;
  Stamp looked_at_{};
  std::vector<std::string> why_unplaced_;  // why the newest scan of a source had no place; empty: it had one
  std::vector<char> taken_;                // sources of which a scan was ever used
  std::vector<PlanarScan> scans_;          // the first is the entry's own, then those of `also`
  std::vector<const OutputTopic*> scan_topics_;  // theirs
  const OutputTopic* cloud_topic_ = nullptr;     // nullptr, as below: none
  const OutputTopic* status_topic_ = nullptr;
  std::vector<MergedScan> merged_;
  PlanarScan status_;
  Cloud cloud_;
  OutputCounters counters_;
  SteadyStamps stamps_;
  PoseGate gate_;
  std::optional<Stamp> due_since_;  // an output that waits for poses
  std::vector<SourceUse> uses_;     // of the last output
  Span latency_{};                  // of the last output: from its instant to its publication
  Span skew_{};                     // between the last rays of the sweeps that it was made of
};

}  // namespace

std::unique_ptr<Output> make_output(const MergedScanConfig& config, const OutputContext& context) {
  return std::make_unique<MergedOutput>(config, context);
}

}  // namespace lidard
