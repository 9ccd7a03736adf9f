// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <sensor_msgs/PointField.h>
#include <sensor_msgs/point_field_conversion.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

using Field = sensor_msgs::PointField;

/// Bytes of a value; 0: there is no such datatype.
std::size_t size_of(std::uint8_t datatype) {
  constexpr std::size_t sizes[] = {0, 1, 1, 2, 2, 4, 4, 4, 8};
  static_assert(Field::INT8 == 1 && Field::UINT16 == 4 && Field::FLOAT32 == 7 && Field::FLOAT64 == 8);
  return datatype < std::size(sizes) ? sizes[datatype] : 0;
}

/// Reads one field of a point; unset where the message has no such field.
class FieldReader {
 public:
  FieldReader() = default;
  FieldReader(const Field& field, bool swap)
      : offset_(field.offset), datatype_(field.datatype), size_(size_of(field.datatype)), swap_(swap) {}

  bool is_set() const { return size_ > 0; }
  bool is_float() const { return datatype_ == Field::FLOAT32 || datatype_ == Field::FLOAT64; }
  bool fits(std::size_t point_step) const { return offset_ + size_ <= point_step; }

  double operator()(const std::uint8_t* point) const {
    alignas(double) std::uint8_t bytes[sizeof(double)];
    std::memcpy(bytes, point + offset_, size_);
    if (swap_) std::reverse(bytes, bytes + size_);
    return sensor_msgs::readPointCloud2BufferValue<double>(bytes, datatype_);
  }
  /// The value, or 0 where the field is absent or the value is not finite.
  double or_zero(const std::uint8_t* point) const {
    if (!is_set()) return 0;
    const double value = (*this)(point);
    return std::isfinite(value) ? value : 0;
  }

 private:
  std::size_t offset_ = 0;
  std::uint8_t datatype_ = 0;
  std::size_t size_ = 0;
  bool swap_ = false;
};

struct Layout {
  FieldReader x, y, z, intensity, ring, time;
};

const char* find_fields(const sensor_msgs::PointCloud2& m, Layout& layout) {
  const std::pair<const char*, FieldReader*> wanted[] = {
      {"x", &layout.x},       {"y", &layout.y},      {"z", &layout.z}, {"intensity", &layout.intensity},
      {"ring", &layout.ring}, {"time", &layout.time}};
  for (const auto& field : m.fields) {
    for (const auto& [name, reader] : wanted) {
      if (field.name != name) continue;
      // Some publishers set PointField::count 0 for a single value.
      if (field.count > 1) return "a field that should hold one value holds several";
      *reader = FieldReader(field, m.is_bigendian != 0);
      if (!reader->is_set()) return "a field has an unknown datatype";
      if (!reader->fits(m.point_step)) return "a field lies outside point_step";
    }
  }
  if (!layout.x.is_set() || !layout.y.is_set() || !layout.z.is_set()) return "no fields x, y and z";
  // Integers would be ticks of a unit that is not in the message.
  if (!layout.time.is_float()) layout.time = FieldReader();
  return nullptr;
}

const char* check_sizes(const sensor_msgs::PointCloud2& m) {
  const std::uint64_t row = static_cast<std::uint64_t>(m.width) * m.point_step;
  if (m.height == 0 || m.width == 0) return nullptr;
  if (m.height > 1 && m.row_step < row) return "row_step is less than width x point_step";
  const std::uint64_t needed = static_cast<std::uint64_t>(m.height - 1) * m.row_step + row;
  return m.data.size() < needed ? "less data than height, width, point_step and row_step say" : nullptr;
}

float as_float(double value) { return static_cast<float>(value); }

/// True if the coordinates are finite as float, which a double may not be.
bool read_point(const Layout& layout, const std::uint8_t* from, CloudPoint& to) {
  const float x = as_float(layout.x(from));
  const float y = as_float(layout.y(from));
  const float z = as_float(layout.z(from));
  if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) return false;
  const double ring = std::clamp(layout.ring.or_zero(from), 0.0, 65535.0);
  to = {x,
        y,
        z,
        as_float(layout.intensity.or_zero(from)),
        static_cast<std::uint16_t>(ring),
        as_float(layout.time.or_zero(from))};
  return true;
}

/// Makes the stamp that of the earliest point, as Cloud has it: some drivers stamp the last one.
void settle_times(Cloud& cloud) {
  if (cloud.size() == 0) return;
  const auto* begin = cloud.points();
  const auto by_time = [](const CloudPoint& a, const CloudPoint& b) { return a.time < b.time; };
  const auto [first, last] = std::minmax_element(begin, begin + cloud.size(), by_time);
  const float earliest = first->time;
  const float latest = last->time;
  // No frame is longer; a larger time has another origin and is not used.
  constexpr float furthest_s = 60;
  const bool foreign = earliest < -furthest_s || latest > furthest_s;
  const float shift = std::min(earliest, 0.0F);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    CloudPoint& point = cloud.points()[i];
    point.time = foreign ? 0.0F : point.time - shift;
  }
  if (foreign) return;
  cloud.stamp = cloud.stamp + span_from_seconds(static_cast<double>(shift));
  cloud.end = cloud.stamp + span_from_seconds(static_cast<double>(latest - shift));
}

/// Fills `cloud` and returns the number of points left out.
std::size_t read_points(const sensor_msgs::PointCloud2& m, const Layout& layout, Cloud& cloud) {
  const std::size_t total = static_cast<std::size_t>(m.width) * m.height;
  // Not resize(), whose loop over bytes the drivers would share with this room, which is compiled with -O1.
  PointBytes& bytes = cloud.points_bytes;
  if (bytes.size() < total * sizeof(CloudPoint)) bytes.assign(total * sizeof(CloudPoint), 0);
  CloudPoint* to = cloud.points();
  std::size_t used = 0;
  for (std::size_t row = 0; row < m.height; ++row) {
    const std::uint8_t* from = m.data.data() + row * m.row_step;
    for (std::size_t column = 0; column < m.width; ++column, from += m.point_step) {
      if (!read_point(layout, from, to[used])) continue;
      const int rings = std::min(to[used].ring + 1, 65535);
      cloud.rings = std::max(cloud.rings, static_cast<std::uint16_t>(rings));
      ++used;
    }
  }
  bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(used * sizeof(CloudPoint)), bytes.end());
  return total - used;
}

}  // namespace

CloudReading from_ros(const sensor_msgs::PointCloud2& message, Cloud& cloud, const ClockStep& clock) {
  CloudReading reading;
  Layout layout;
  reading.error = find_fields(message, layout);
  if (reading.error == nullptr) reading.error = check_sizes(message);
  if (reading.error != nullptr) return reading;
  cloud.clear();
  cloud.frame_id = ros_frame(message.header.frame_id);
  cloud.stamp = clock.steady(from_ros(message.header.stamp));
  cloud.rings = 0;
  cloud.complete = true;
  cloud.end = cloud.stamp;
  if (message.height > 0 && message.width > 0) reading.dropped = read_points(message, layout, cloud);
  settle_times(cloud);
  return reading;
}

}  // namespace lidard
