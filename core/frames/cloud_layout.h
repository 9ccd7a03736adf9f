// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/frames/cloud.h"

namespace lidard {

/// Order of the points of a cloud message.
enum class CloudOrder : std::uint8_t {
  list,        ///< as they were measured, returns only
  ring_rows,   ///< organised: a row per ring, lowest first, a column per firing sequence
  firing_rows  ///< organised as velodyne_pointcloud does it: a row per firing sequence, a column per ring
};

/// Which firing a cloud message is stamped with; `time` of its points counts from there.
enum class FrameStamp : std::uint8_t {
  first,  ///< the first: times are >= 0
  last    ///< the last one that came back: times are <= 0, as in ros-drivers/velodyne
};

/// Layout of a cloud message; the default is that of drivers' clouds.
struct CloudLayout {
  CloudOrder order = CloudOrder::list;
  FrameStamp stamp = FrameStamp::first;
};

/// Converts a driver's cloud to the layout of a message.
///
/// Organised clouds have one line of points per return of a firing sequence: in dual return mode two lines
/// with the same `time` follow each other, CloudColumn::echo 0 and 1. Without a return x, y, z and intensity
/// are NaN, `ring` is set and `time` is the begin of the firing sequence.
class CloudArranger {
 public:
  explicit CloudArranger(const CloudLayout& layout) : layout_(layout) {}

  /// True if messages have the layout of drivers' clouds, so that nothing needs to be done.
  bool is_plain() const { return layout_.order == CloudOrder::list && layout_.stamp == FrameStamp::first; }
  /// The stamp of the message that the cloud becomes.
  Stamp stamp_of(const Cloud& cloud) const { return cloud.stamp + span_from_seconds(shift_of(cloud)); }
  /// The arranged cloud, valid until the next call; its bytes may be swapped out. `cloud` stays as it is. A
  /// cloud without columns (of another driver) cannot be organised and stays a list.
  Cloud& arrange(const Cloud& cloud);
  /// The cloud as its message holds it: itself where nothing is to do.
  Cloud& message_of(Cloud& cloud) { return is_plain() ? cloud : arrange(cloud); }

 private:
  bool is_organised(const Cloud& cloud) const {
    return layout_.order != CloudOrder::list && !cloud.columns.empty() && cloud.rings > 0;
  }
  double shift_of(const Cloud& cloud) const;
  void fill_missing(const Cloud& cloud);
  std::size_t slot_of(std::size_t column, std::size_t ring, std::size_t columns) const {
    return layout_.order == CloudOrder::ring_rows ? ring * columns + column : column * arranged_.rings + ring;
  }

  CloudLayout layout_;
  Cloud arranged_;
  float shift_ = 0;  // s, subtracted from each time
};

}  // namespace lidard
