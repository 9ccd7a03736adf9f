// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/cloud_layout.h"

#include <algorithm>
#include <limits>

template class std::vector<std::uint8_t, lidard::PointAllocator<std::uint8_t>>;

namespace lidard {
namespace {

/// Begin of a firing sequence, s after the cloud's stamp. Columns have the host's time as it was known when
/// they came: what was learned of the clocks meanwhile must not put one before the frame.
float begin_of(const CloudColumn& column, const Cloud& cloud) {
  return std::max(0.0F, static_cast<float>(seconds(column.stamp - cloud.stamp)));
}

/// Time of the last firing that came back, in an organised cloud at least the begin of the last sequence, s
/// after the cloud's stamp.
float last_time(const Cloud& cloud, bool organised) {
  float last = 0;
  for (std::size_t c = 0; organised && c < cloud.columns.size(); ++c)
    last = std::max(last, begin_of(cloud.columns[c], cloud));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const float time = cloud.points()[i].time;
    last = std::max(last, time);
  }
  return last;
}

}  // namespace

void CloudArranger::fill_missing(const Cloud& cloud) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t columns = cloud.columns.size();
  for (std::size_t c = 0; c < columns; ++c) {
    const float time = begin_of(cloud.columns[c], cloud) - shift_;
    for (std::uint16_t ring = 0; ring < cloud.rings; ++ring)
      arranged_.points()[slot_of(c, ring, columns)] = {nan, nan, nan, nan, ring, time};
  }
}

double CloudArranger::shift_of(const Cloud& cloud) const {
  return layout_.stamp == FrameStamp::last ? static_cast<double>(last_time(cloud, is_organised(cloud))) : 0;
}

Cloud& CloudArranger::arrange(const Cloud& cloud) {
  const std::size_t columns = cloud.columns.size();
  const bool organised = is_organised(cloud);
  arranged_.height = 0;
  if (organised)
    arranged_.height =
        layout_.order == CloudOrder::ring_rows ? cloud.rings : static_cast<std::uint32_t>(columns);
  arranged_.frame_id = cloud.frame_id;
  arranged_.rings = cloud.rings;
  arranged_.complete = cloud.complete;
  arranged_.end = cloud.end;
  shift_ = static_cast<float>(shift_of(cloud));
  arranged_.stamp = cloud.stamp + span_from_seconds(static_cast<double>(shift_));
  const std::size_t slots = organised ? columns * cloud.rings : cloud.size();
  arranged_.points_bytes.resize(slots * sizeof(CloudPoint));
  if (organised) fill_missing(cloud);
  std::size_t column = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    while (column + 1 < columns && cloud.columns[column + 1].first_point <= i) ++column;
    CloudPoint point = cloud.points()[i];
    point.time -= shift_;
    if (!organised) {
      arranged_.points()[i] = point;
    } else if (point.ring < cloud.rings) {
      arranged_.points()[slot_of(column, point.ring, columns)] = point;
    }
  }
  return arranged_;
}

}  // namespace lidard
