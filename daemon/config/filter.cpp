// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `filter:` of a sensor: returns that are removed from the messages of its own topics.
#include "core/frames/frame_filter.h"
#include "daemon/config/module.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;
using F = FrameFilterSettings;

constexpr double furthest_m = 1000;
constexpr double highest_intensity = 65535;
constexpr const char* box_form = "two opposite corners [[x, y, z], [x, y, z]], m";

/// Two opposite corners.
KeyOf<F> box_row(std::string_view name, std::optional<FilterBox> F::*member, std::string_view meaning) {
  const auto corner = [](const Eigen::Vector3d& at) { return KeyList{at.x(), at.y(), at.z()}; };
  const auto get = [member, corner](const F& filter) {
    const auto& box = filter.*member;
    return box ? KeyValue(KeyList{corner(box->min()), corner(box->max())}) : KeyValue();
  };
  return special<F>(name, box_form, get, meaning);
}

Keys<F> rows() {
  const auto wanted = [](const F& filter) { return filter.outlier_radius > 0; };
  return {number("intensity_min", &F::intensity_min, 0, highest_intensity, "", "weaker returns are removed")
              .by_default("no limit"),
          box_row("box", &F::box, "returns outside are removed; in frame_id of the sensor"),
          box_row("cut_out", &F::cut_out, "returns inside are removed: the vehicle itself"),
          number("voxel_size", &F::voxel_size, 0, 100, "m",
                 "clouds: of the returns in such a cube the one nearest to its centre stays; 0: all")
              .shown_if([](const F& filter) { return filter.voxel_size > 0; }),
          number("outlier_radius", &F::outlier_radius, 0, 100, "m",
                 "where others are looked for; 0: outliers stay; needs the package lidard-pcl")
              .shown_if(wanted),
          whole("outlier_neighbours", &F::outlier_neighbours, 1, 1000,
                "a return with fewer others in that radius is an outlier")
              .shown_if(wanted)};
}

void read_box(const Mapping& filter, const char* name, std::optional<FilterBox>& box) {
  const auto value = filter.find(name);
  if (!value) return;
  const std::vector<Value> corners = value->items(box_form);
  if (corners.size() != 2) value->fail("has " + std::to_string(corners.size()) + " corners", box_form);
  box.emplace();
  for (const Value& corner : corners) {
    const std::vector<double> xyz = corner.numbers(3, furthest_m, "m");
    box->extend(Eigen::Vector3d(xyz[0], xyz[1], xyz[2]));
  }
  if (!(box->volume() > 0)) value->fail("has no volume", box_form);
}

/// A scan, also that of a ring, lies at z 0 of its frame.
void check_height(const Mapping& yaml, const F& filter) {
  if (filter.box && (filter.box->min().z() > 0 || filter.box->max().z() < 0))
    yaml.where("box").fail("leaves out the whole scan, which lies at z 0", "a box from z <= 0 to z >= 0");
}

void check_intensity(const Mapping& yaml, const SensorConfig& sensor) {
  if (!sensor.filter.intensity_min || sensor.model->kind == FrameKind::cloud ||
      sensor.driver.publish_intensity)
    return;
  yaml.where("intensity_min")
      .fail_at_key("has nothing to go by: publish_intensity is false",
                   "publish_intensity: true, or no such key");
}

void load_outliers(const Mapping& yaml, F& filter) {
  if (filter.outlier_radius <= 0) {
    if (yaml.has("outlier_neighbours"))
      yaml.where("outlier_neighbours").fail_at_key("is given without outlier_radius", "both, or neither");
    return;
  }
  try {
    filter.find_inliers = reinterpret_cast<FindInliers>(
        module_function("lidard_outliers", "lidard_find_inliers", "it needs the package lidard-pcl"));
  } catch (const std::runtime_error& e) {
    yaml.where("outlier_radius")
        .fail_at_key(std::string("cannot be applied: ") + e.what(), "the package lidard-pcl, or no such key");
  }
}

void check_voxels(const Mapping& yaml, const SensorConfig& sensor) {
  if (sensor.filter.voxel_size > 0 && sensor.model->kind == FrameKind::scan)
    yaml.where("voxel_size")
        .fail_at_key("is not available for " + std::string(sensor.model->name) + ", which gives no clouds",
                     "no such key: every beam of a scan has its place");
}

}  // namespace

Keys<SensorConfig> filter_rows() {
  const auto wanted = [](const SensorConfig& sensor) { return sensor.filter.any(); };
  return {section("filter", within(&SensorConfig::filter, rows()),
                  "what is left out of its messages; merged and virtual scans see all of it")
              .shown_if(wanted)};
}

void check_filter(Mapping& parent, SensorConfig& sensor) {
  if (!parent.has("filter")) return;
  const Mapping yaml = parent.inside("filter");
  check_intensity(yaml, sensor);
  read_box(yaml, "box", sensor.filter.box);
  read_box(yaml, "cut_out", sensor.filter.cut_out);
  const bool gives_scan = sensor.model->kind == FrameKind::scan || parent.has("scan_ring");
  if (gives_scan) check_height(yaml, sensor.filter);
  check_voxels(yaml, sensor);
  load_outliers(yaml, sensor.filter);
}

}  // namespace lidard
