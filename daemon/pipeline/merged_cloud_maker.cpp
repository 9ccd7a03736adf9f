// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include "core/merge/cloud_merger.h"
#include "daemon/pipeline/maker.h"
#include "daemon/pipeline/merge_sources.h"
#include "daemon/pipeline/router.h"

namespace lidard {
namespace {

/// A merged cloud: takes the clouds and scans of its sources, publishes when one is due. While nobody wants
/// it no return is kept, and what would be published is counted alone.
class MergedCloudMaker final : public Maker {
 public:
  MergedCloudMaker(const MergedCloudConfig& config, const MakerContext& context)
      : config_(config),
        context_(context),
        topic_(context.router.topic(config.destination_topic)),
        merger_(config.sources.size(), config.organized),
        sources_({config.sources, config.schedule, config.on_missing_motion, config.destination_frame},
                 context) {
    merged_.frame_id = config.destination_frame;
  }

  MakerId id() const override { return {MakerId::Kind::merged_cloud, config_.name}; }
  bool is_of(const MergedCloudConfig& entry) const override { return config_ == entry; }
  std::vector<std::string> sources() const override { return config_.sources; }
  bool is_wanted() const override { return context_.router.wants(topic_) || context_.router.feeds(topic_); }
  void add_scan(std::size_t source, const PlanarScan& scan, Stamp now) override {
    // The ring that a lidar publishes as a scan too (scan_ring).
    if (cloud_at_[source] && now - *cloud_at_[source] < std::chrono::seconds(2)) return;
    add(source, scan, times_of(scan), static_cast<double>(scan.scan_time), now);
  }
  void add_cloud(std::size_t source, const Cloud& cloud, Stamp now) override {
    cloud_at_[source] = now;
    add(source, cloud, times_of(cloud), 0, now);
  }
  void pass_by(std::size_t source, const Cloud& cloud, Stamp now) override {
    cloud_at_[source] = now;
    note_wanted();
    // If it is wanted by now, the next one has points.
    sources_.delivered(source, times_of(cloud), 0, now, !wanted_);
    advance(now);
  }
  void advance(Stamp now) override {
    if (const auto moment = sources_.due(now)) publish(*moment, now);
  }
  std::optional<Stamp> next_event() const override { return sources_.next_event(); }
  bool states_changed(Stamp now) override { return sources_.states_changed(now); }
  void restart() override {
    merger_.reset();
    sources_.restart();
  }
  MakerStatus status(Stamp now) const override {
    MakerStatus status;
    status.topics = {topic_.name};
    status.counters = sources_.counters;
    status.merge = sources_.status(now);
    status.figures = {{"Returns", merged_size_},
                      {"Clouds replaced before use", merger_.superseded()},
                      {"Clouds out of order", merger_.out_of_order()}};
    return status;
  }

 private:
  static SweepTimes times_of(const PlanarScan& scan) { return lidard::times_of(scan); }
  static SweepTimes times_of(const Cloud& cloud) {
    return {cloud.stamp, seconds(std::max(cloud.stamp, cloud.end) - cloud.stamp), 2};
  }
  /// What came while nobody wanted it has no points.
  void note_wanted() {
    const bool wanted = is_wanted();
    if (wanted && !wanted_) {
      merger_.reset();
      sources_.forget();
    }
    wanted_ = wanted;
  }
  template <class Frame>
  void add(std::size_t source, const Frame& frame, const SweepTimes& times, double period, Stamp now) {
    note_wanted();
    Pose pose;
    if (!context_.poses.find(context_.vehicle.base_frame, frame.frame_id, frame.stamp, pose,
                             sources_.counters.why_no_pose)) {
      ++sources_.counters.no_pose;
      return;
    }
    if (!merger_.add(source, frame, pose, wanted_)) return;
    sources_.delivered(source, times, period, now);
    advance(now);
  }
  void publish(MergeMoment moment, Stamp now) {
    if (!wanted_) {
      sources_.skipped(now);
      return context_.router.skip(topic_, now);
    }
    // The last look was at the instant too, but only where the vehicle moves.
    if (moment.track == nullptr &&
        !context_.poses.find(config_.destination_frame, context_.vehicle.base_frame, moment.at,
                             moment.output_from_base, sources_.counters.why_no_pose)) {
      ++sources_.counters.no_pose;
      return sources_.not_published(now);
    }
    sources_.published(merger_.merge(moment, sources_.usable(now), merged_), now);
    merged_size_ = merged_.size();
    context_.router.publish(topic_, merged_, now);
    context_.router.feed(topic_, merger_.placed(), moment.at, now);
  }

  MergedCloudConfig config_;
  const MakerContext& context_;
  const OutputTopic& topic_;
  CloudMerger merger_;
  MergeSources sources_;
  // Arrivals of the sources' newest clouds.
  std::vector<std::optional<Stamp>> cloud_at_ = std::vector<std::optional<Stamp>>(config_.sources.size());
  MergedCloud merged_;
  std::uint64_t merged_size_ = 0;  // points of the newest one
  bool wanted_ = true;             // when the newest frame came
};

}  // namespace

std::unique_ptr<Maker> make_maker(const MergedCloudConfig& config, const MakerContext& context) {
  return std::make_unique<MergedCloudMaker>(config, context);
}

}  // namespace lidard
