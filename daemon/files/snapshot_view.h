// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/motion/frame_tree.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// Keeps the newest scan of each topic and frame, and the newest cloud of each topic.
class FrameKeeper : public FrameSink {
 public:
  /// By topic and frame: several virtual scans may share a topic.
  using Key = std::pair<std::string, std::string>;

  /// Frames after this call are not kept.
  void freeze() { frozen_ = true; }

  void publish(const OutputTopic& topic, const Frame& frame, Stamp /*released*/) override {
    if (frozen_) return;
    if (const PlanarScan* const scan = frame.scan()) {
      scans_[{topic.name, scan->frame_id}] = *scan;
      newest_ = std::max(newest_, scan->stamp);
    } else if (const Cloud* const cloud = frame.cloud()) {
      clouds_[topic.name] = *cloud;
      newest_ = std::max(newest_, cloud->stamp);
    } else if (const MergedCloud* const merged = frame.merged_cloud()) {
      keep(*merged, clouds_[topic.name]);
      newest_ = std::max(newest_, merged->stamp);
    }
  }

  /// The newest of them, or nullptr.
  const PlanarScan* find_scan(const std::string& topic, const std::string& frame) const {
    const auto found = scans_.find({topic, frame});
    return found == scans_.end() ? nullptr : &found->second;
  }
  const Cloud* find_cloud(const std::string& topic) const {
    const auto found = clouds_.find(topic);
    return found == clouds_.end() ? nullptr : &found->second;
  }
  /// True if a frame came on a topic.
  bool has(const std::string& topic) const {
    const auto scan = scans_.lower_bound({topic, ""});
    return clouds_.count(topic) != 0 || (scan != scans_.end() && scan->first.first == topic);
  }
  bool empty() const { return scans_.empty() && clouds_.empty(); }
  /// Stamp of the newest frame of all.
  Stamp newest() const { return newest_; }

 private:
  /// Its points without their sensor.
  static void keep(const MergedCloud& merged, Cloud& cloud) {
    cloud.frame_id = merged.frame_id;
    cloud.stamp = merged.stamp;
    cloud.points_bytes.resize(merged.size() * sizeof(CloudPoint));
    for (std::size_t i = 0; i < merged.size(); ++i) cloud.points()[i] = merged.points()[i].point;
  }

  std::map<Key, PlanarScan> scans_;
  std::map<std::string, Cloud> clouds_;
  Stamp newest_{};
  bool frozen_ = false;
};

/// The content of a picture, in base_frame seen from above, m. Drawing needs nothing else.
struct SnapshotView {
  enum class Role : std::uint8_t { input, merged, virtual_scan, cloud };

  /// One scan or cloud.
  struct Layer {
    Role role = Role::input;
    std::size_t number = 0;  ///< among those of its role; chooses the colour
    std::string name;
    std::string note;  ///< its explanation in the legend
    std::vector<Eigen::Vector2f> points;
    std::vector<char> joined;   ///< point i and i + 1 are neighbouring beams on one surface; empty: none are
    std::vector<float> values;  ///< of the points, shown as colours; empty: they have the colour of the layer
    double dot = 6;             ///< pixels, of points that are no line
    std::pair<double, double> scale{0, 1};  ///< values at the ends of the colours
  };

  /// The area that the picture shows.
  struct Framing {
    Eigen::Vector2d center{0, 0};
    Eigen::Vector2d half{10, 10};  ///< m that are shown at least from the center, ahead and to the left
    int width = 0;                 ///< pixels of the page; 0: as needed
  };

  struct Sensor {
    std::string name;
    Eigen::Vector2d at;
    Role role = Role::input;  ///< of its layer
    std::size_t number = 0;
  };

  /// The border of a sensor's field of view, or of the zone where it is blind.
  struct Field {
    std::vector<Eigen::Vector2d> border;
    std::size_t sensor;  ///< index in `sensors`
    bool is_blind;
  };

  /// The width of a beam up to its end.
  struct Wedge {
    Eigen::Vector2f corner[3];  ///< the first one is the origin of the scan
    bool observed;              ///< free if true
  };

  std::string title;
  std::string subtitle;
  std::string base_frame;
  std::vector<Eigen::Vector2d> footprint;
  std::vector<Sensor> sensors;
  std::vector<Layer> layers;  ///< in the order of the legend
  std::vector<Field> fields;  ///< as lines, those of blind zones dashed
  std::vector<Wedge> wedges;  ///< by angle
  std::string free_note;      ///< legend of the areas; empty: none is shown
  std::string unobserved_note;
  std::string colors_note;           ///< legend of the values; empty: there are none
  std::vector<std::string> notes;    ///< one sentence each: remarks on the picture
  std::vector<std::string> missing;  ///< one sentence each: objects not drawn, and why
  Framing framing;
};

/// What a view shows.
struct ViewChoice {
  /// Topic whose free and unobserved areas are shaded; empty: the first merged or virtual scan in profile
  /// strict, else safety, else the first scan of all; flatten proves no free space, so nothing is shaded for
  /// it.
  std::string areas{};
  std::vector<std::string> only{};  ///< topics drawn beside `areas`; empty: all
  bool intensities = false;         ///< of all returns are the values; else heights, of clouds alone
};

/// Builds the view of `frames`. Throws std::runtime_error without a frame of the areas, or for a topic that
/// is never drawn.
SnapshotView make_view(const Config& config, const FrameTree& poses, const FrameKeeper& frames,
                       const ViewChoice& choice);

/// The framing that shows 95 % of the returns.
SnapshotView::Framing fit_to_points(const SnapshotView& view);
/// Fits the scales of the colours to the returns in the framing: one of all heights, or one of the
/// intensities of each layer, since devices count differently. Adds them to the legend.
void fit_colors(SnapshotView& view, bool intensities);

enum class PictureFormat : std::uint8_t { png, svg };
/// The format by the end of a file's name; nothing: neither .png nor .svg.
std::optional<PictureFormat> picture_format(const std::string& path);
/// The picture as the bytes of a file: views side by side, the last one with its legend.
std::string draw_snapshot(const std::vector<SnapshotView>& views, PictureFormat format);

}  // namespace lidard

/// draw_snapshot() itself; not linked, but found by name in the module for pictures.
extern "C" void lidard_draw_snapshot(const std::vector<lidard::SnapshotView>& views,
                                     lidard::PictureFormat format, std::string& bytes);
