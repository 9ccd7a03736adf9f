// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "daemon/config/config_parts.h"

namespace lidard {
namespace {

constexpr double farthest_m = 1000;
constexpr double full_turn = 2 * M_PI;

/// What `word` stands for among `words`; fails at `value` otherwise.
template <class Meaning, std::size_t n>
Meaning one_of(const Value& value, const std::pair<const char*, Meaning> (&words)[n]) {
  std::string expected;
  for (const auto& [word, meaning] : words) expected.append(expected.empty() ? "" : ", ").append(word);
  const std::string text = value.text("one of " + expected);
  for (const auto& [word, meaning] : words) {
    if (text == word) return meaning;
  }
  value.fail("is " + value.quoted(), "one of " + expected);
}

const Value& where_angle(const Mapping& yaml, const std::string& key) {
  return yaml.where(yaml.has(key) ? key : key + "_deg");
}

void read_frame_cut(Mapping& yaml, DriverConfig& driver) {
  if (const auto cut = yaml.find("frame_cut"))
    driver.frame_cut = one_of<FrameCut>(
        *cut, {{"angle", FrameCut::angle}, {"view", FrameCut::view}, {"time", FrameCut::time}});
  const bool by_time = driver.frame_cut == FrameCut::time;
  if (const auto duration = yaml.find("frame_duration")) {
    if (!by_time)
      duration->fail_at_key("is given without frame_cut: time",
                            "both, or neither: a revolution lasts as long as it lasts");
    driver.frame_duration = duration->duration(0.001, 10);
  }
  const auto angle = yaml.angle("cut_angle");
  if (angle && by_time)
    where_angle(yaml, "cut_angle")
        .fail_at_key("is given with frame_cut: time", "one of them: frames are cut by time or by angle");
  driver.cut_angle = angle.value_or(0);
}

void read_ranges(Mapping& yaml, DriverConfig& driver) {
  if (const auto least = yaml.find("min_range")) driver.min_range = least->number(0, farthest_m, "m");
  const auto most = yaml.find("max_range");
  if (!most) return;
  driver.max_range = most->number(0, farthest_m, "m");
  if (driver.max_range != 0 && driver.max_range <= driver.min_range)
    most->fail("is not above min_range", "min_range < max_range, or 0 for no limit");
}

void read_view(Mapping& yaml, DriverConfig& driver) {
  const auto direction = yaml.angle("view_direction");
  if (direction && std::abs(*direction) > full_turn)
    where_angle(yaml, "view_direction").fail("is more than a turn", "an angle in [-pi, pi], 0 ahead");
  const auto width = yaml.angle("view_width");
  if (width && (*width <= 0 || *width > full_turn + 1e-6))
    where_angle(yaml, "view_width").fail("is no width of a sector", "an angle in (0, 2 pi]");
  driver.view_direction = direction.value_or(0);
  driver.view_width = std::min(width.value_or(full_turn), full_turn);
}

CloudOrder read_order(const Value& value) {
  const std::string word = value.text("true, false, rings or firings");
  if (word == "rings") return CloudOrder::ring_rows;
  if (word == "firings") return CloudOrder::firing_rows;
  return value.boolean() ? CloudOrder::ring_rows : CloudOrder::list;
}

void read_frame_stamp(Mapping& yaml, CloudLayout& layout) {
  if (const auto stamp = yaml.find("frame_stamp"))
    layout.stamp = one_of<FrameStamp>(*stamp, {{"first", FrameStamp::first}, {"last", FrameStamp::last}});
}

void read_layout(Mapping& yaml, SensorConfig& sensor) {
  CloudLayout& layout = sensor.layout;
  if (const auto order = yaml.find("organize_cloud")) layout.order = read_order(*order);
  read_frame_stamp(yaml, layout);
  if (const auto echo = yaml.find("publish_echo")) layout.echo = echo->boolean();
  if (!sensor.model->has(Trait::confidence)) return;
  if (const auto confidence = yaml.find("publish_confidence")) layout.confidence = confidence->boolean();
  sensor.driver.keep_confidence = layout.confidence;
}

/// The ring asked for, or nothing.
std::optional<std::uint16_t> read_ring(const std::optional<Value>& value, const SensorConfig& sensor) {
  if (!value || value->text("auto, or a ring counted from 0") == "-1") return std::nullopt;
  const Model& model = *sensor.model;
  if (value->text() != "auto")
    return static_cast<std::uint16_t>(value->integer(0, static_cast<long>(model.beams) - 1));
  if (model.level_ring == nullptr)
    value->fail("is auto, but it is not known which ring of this model is level", "a ring counted from 0");
  return model.level_ring(sensor.driver);
}

void read_ring_scan(Mapping& yaml, SensorConfig& sensor) {
  const auto asked = yaml.find("scan_ring");
  const auto ring = read_ring(asked, sensor);
  const auto resolution = yaml.angle("scan_resolution");
  const auto topic = yaml.find("scan_topic");
  sensor.scan_topic = topic ? read_topic(*topic) : sensor.name + "/scan";
  if (!ring) {
    if (resolution)
      where_angle(yaml, "scan_resolution").fail_at_key("is given without scan_ring", "both, or neither");
    if (topic) topic->fail_at_key("is given without scan_ring", "both, or neither");
    return;
  }
  if (sensor.driver.frame_cut == FrameCut::time)
    asked->fail_at_key("is given with frame_cut: time", "another frame_cut: a scan is a revolution");
  RingScanSpec spec;
  spec.ring = *ring;
  if (resolution) spec.resolution = *resolution;
  if (!(spec.resolution >= 0.0005 && spec.resolution <= 0.2))
    where_angle(yaml, "scan_resolution").fail("is out of range", "0.0005 to 0.2 rad");
  const DriverConfig& driver = sensor.driver;
  spec.range_min = driver.min_range > 0 ? driver.min_range : sensor.model->range_min;
  spec.range_max = driver.max_range > 0 ? driver.max_range : sensor.model->range_max;
  sensor.ring_scan = spec;
  sensor.driver.keep_too_near = true;
}

}  // namespace

void read_cloud_keys(Mapping& yaml, SensorConfig& sensor) {
  const auto topic = yaml.find("points_topic");
  sensor.points_topic = topic ? read_topic(*topic) : sensor.name + "/points";
  if (!sensor.model->has(Trait::revolutions)) {
    read_frame_stamp(yaml, sensor.layout);
    return;  // the other keys stay unread, which is refused
  }
  read_frame_cut(yaml, sensor.driver);
  read_ranges(yaml, sensor.driver);
  read_view(yaml, sensor.driver);
  read_layout(yaml, sensor);
  read_ring_scan(yaml, sensor);
}

}  // namespace lidard
