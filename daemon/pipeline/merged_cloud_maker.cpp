// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <string>
#include <vector>

#include "core/merge/cloud_merger.h"
#include "daemon/pipeline/merging_maker.h"

namespace lidard {
namespace {

SweepTimes times_of(const Cloud& cloud) {
  return {cloud.stamp, seconds(std::max(cloud.stamp, cloud.end) - cloud.stamp), 2};
}

/// A merged cloud: of the clouds and scans of its sources, published when one is due. While nobody wants it
/// no return is kept, and what would be published is counted alone.
class MergedCloudMaker final : public MergingMaker {
 public:
  MergedCloudMaker(const MergedCloudConfig& config, const PipelineContext& context)
      : MergingMaker({MakerId::Kind::merged_cloud, config.name}, config.sources,
                     {config.schedule, config.on_missing_motion, config.destination_frame}, context),
        config_(config),
        topic_(*topic(config.destination_topic)),
        merger_(config.sources.size(), config.organized) {
    merged_.frame_id = config.destination_frame;
  }

  bool is_of(const MergedCloudConfig& entry) const override { return config_ == entry; }
  bool is_wanted() const override { return topic_.is_wanted(); }
  void add(std::size_t source, const Frame& frame, Stamp now) override {
    if (const PlanarScan* const scan = frame.scan()) {
      // The ring that a lidar publishes as a scan too (scan_ring).
      if (cloud_at_[source] && now - *cloud_at_[source] < std::chrono::seconds(2)) return;
      add(source, *scan, static_cast<double>(scan->scan_time), now);
    } else if (const Cloud* const cloud = frame.cloud()) {
      cloud_at_[source] = now;
      if (frame.has_points) return add(source, *cloud, 0, now);
      note_wanted();
      // If it is wanted by now, the next one has points.
      delivered(source, times_of(*cloud), 0, now, !wanted_);
    }
  }
  void restart() override {
    merger_.reset();
    MergingMaker::restart();
  }
  MakerStatus status(Stamp now) const override {
    MakerStatus status = MergingMaker::status(now);
    status.figures = {{"Returns", merged_size_},
                      {"Clouds replaced before use", merger_.superseded()},
                      {"Clouds out of order", merger_.out_of_order()}};
    return status;
  }

 private:
  /// What came while nobody wanted it has no points.
  void note_wanted() {
    const bool wanted = is_wanted();
    if (wanted && !wanted_) {
      merger_.reset();
      forget();
    }
    wanted_ = wanted;
  }
  template <class Measured>
  void add(std::size_t source, const Measured& frame, double period, Stamp now) {
    note_wanted();
    Pose pose;
    if (!find_pose(context_.vehicle.base_frame, frame.frame_id, frame.stamp, pose))
      return counters_.count_no_pose(now);
    if (merger_.add(source, frame, pose, wanted_)) delivered(source, times_of(frame), period, now);
  }
  void publish(MergeMoment moment, Stamp now) override {
    if (!wanted_) {
      skipped(now);
      return topic_.deliver({merged_, merger_.placed(), false}, now);
    }
    // The last look was at the instant too, but only where the vehicle moves.
    if (moment.track == nullptr && !find_pose(config_.destination_frame, context_.vehicle.base_frame,
                                              moment.at, moment.output_from_base)) {
      counters_.count_no_pose(now);
      return not_published(now);
    }
    published(merger_.merge(moment, usable(now), merged_), now);
    merged_size_ = merged_.size();
    topic_.deliver({merged_, merger_.placed()}, now);
  }

  MergedCloudConfig config_;
  Route& topic_;
  CloudMerger merger_;
  // Arrivals of the sources' newest clouds.
  std::vector<std::optional<Stamp>> cloud_at_ = std::vector<std::optional<Stamp>>(sources.size());
  MergedCloud merged_;
  std::uint64_t merged_size_ = 0;  // points of the newest one
  bool wanted_ = true;             // when the newest frame came
};

}  // namespace

std::unique_ptr<Maker> make_maker(const MergedCloudConfig& config, const PipelineContext& context) {
  return std::make_unique<MergedCloudMaker>(config, context);
}

}  // namespace lidard
