// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/cloud_layout.h"

#include <algorithm>
#include <cstring>
#include <limits>

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

CloudFormat format_of(const CloudLayout& layout, bool organised, const Cloud& cloud) {
  CloudFormat format;
  format.confidence = layout.confidence;
  format.echo = layout.echo;
  format.point_step += (format.confidence ? 2U : 0U) + (format.echo ? 1U : 0U);
  if (organised)
    format.height = layout.order == CloudOrder::ring_rows ? cloud.rings
                                                          : static_cast<std::uint32_t>(cloud.columns.size());
  return format;
}

std::uint8_t* write_point(std::uint8_t* to, const CloudPoint& point) {
  std::memcpy(to, &point, sizeof point);
  return to + sizeof point;
}

std::uint8_t* write_confidence(std::uint8_t* to, std::uint16_t confidence) {
  std::memcpy(to, &confidence, sizeof confidence);
  return to + sizeof confidence;
}

}  // namespace

void CloudArranger::put(const Cloud& cloud, std::size_t point, std::size_t column, std::size_t slot) {
  CloudPoint moved = cloud.points()[point];
  moved.time -= shift_;
  std::uint8_t* to = write_point(arranged_.points_bytes.data() + slot * arranged_.format.point_step, moved);
  if (layout_.confidence)
    to = write_confidence(to, point < cloud.confidences.size() ? cloud.confidences[point] : no_confidence);
  if (layout_.echo) *to = column < cloud.columns.size() ? cloud.columns[column].echo : std::uint8_t{0};
}

void CloudArranger::fill_missing(const Cloud& cloud) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const std::size_t columns = cloud.columns.size();
  for (std::size_t c = 0; c < columns; ++c) {
    const CloudColumn& column = cloud.columns[c];
    const float time = begin_of(column, cloud) - shift_;
    for (std::uint16_t ring = 0; ring < cloud.rings; ++ring) {
      std::uint8_t* to =
          arranged_.points_bytes.data() + slot_of(c, ring, columns) * arranged_.format.point_step;
      to = write_point(to, {nan, nan, nan, nan, ring, time});
      if (layout_.confidence) to = write_confidence(to, no_confidence);
      if (layout_.echo) *to = column.echo;
    }
  }
}

double CloudArranger::shift_of(const Cloud& cloud) const {
  return layout_.stamp == FrameStamp::last ? static_cast<double>(last_time(cloud, is_organised(cloud))) : 0;
}

Cloud& CloudArranger::arrange(const Cloud& cloud) {
  const std::size_t columns = cloud.columns.size();
  const bool organised = is_organised(cloud);
  arranged_.format = format_of(layout_, organised, cloud);
  arranged_.frame_id = cloud.frame_id;
  arranged_.rings = cloud.rings;
  arranged_.complete = cloud.complete;
  arranged_.end = cloud.end;
  shift_ = static_cast<float>(shift_of(cloud));
  arranged_.stamp = cloud.stamp + span_from_seconds(static_cast<double>(shift_));
  const std::size_t slots = organised ? columns * cloud.rings : cloud.size();
  arranged_.points_bytes.resize(slots * arranged_.format.point_step);
  if (organised) fill_missing(cloud);
  std::size_t column = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    while (column + 1 < columns && cloud.columns[column + 1].first_point <= i) ++column;
    const std::size_t ring = cloud.points()[i].ring;
    if (!organised) {
      put(cloud, i, column, i);
    } else if (ring < cloud.rings) {
      put(cloud, i, column, slot_of(column, ring, columns));
    }
  }
  return arranged_;
}

}  // namespace lidard
