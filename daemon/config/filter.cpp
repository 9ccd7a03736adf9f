// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `filter:` of a sensor: what is left out of the messages of its own topics.
#include "core/frames/frame_filter.h"
#include "daemon/config/module.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;
using F = FrameFilterSettings;

constexpr double furthest_m = 1000;
constexpr double highest_intensity = 65535;

Keys<FilterBox> box_rows() {
  using B = FilterBox;
  const auto side = [](std::string_view name, std::optional<double> B::*member, std::string_view meaning) {
    return number(name, member, -furthest_m, furthest_m, "m", meaning).by_default("no limit");
  };
  return {side("x_min", &B::x_min, "ahead of the sensor"),
          side("x_max", &B::x_max, "ahead of the sensor"),
          side("y_min", &B::y_min, "to the left of the sensor"),
          side("y_max", &B::y_max, "to the left of the sensor"),
          side("z_min", &B::z_min, "above the sensor; a scan lies at 0"),
          side("z_max", &B::z_max, "above the sensor")};
}

KeyOf<F> box_row(std::string_view name, FilterBox F::*member, std::string_view meaning) {
  return section(name, within(member, box_rows()), meaning)
      .shown_if([member](const F& filter) { return (filter.*member).any(); })
      .in_one_line();
}

Keys<F> rows() {
  const auto wanted = [](const F& filter) { return filter.outlier_radius > 0; };
  return {number("intensity_min", &F::intensity_min, 0, highest_intensity, "", "weaker returns are removed")
              .by_default("no limit"),
          number("intensity_max", &F::intensity_max, 0, highest_intensity, "", "stronger returns are removed")
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

/// Refuses sides of which nothing can lie between.
void check_box(const Mapping& filter, const char* name, const FilterBox& box) {
  if (!filter.has(name)) return;
  const Mapping yaml = filter.inside(name);
  const auto check = [&](const char* key, const auto& lowest, const auto& highest, const std::string& axis) {
    if (lowest && highest && *highest <= *lowest)
      yaml.where(key).fail("is not above " + axis + "_min", axis + "_min < " + axis + "_max");
  };
  check("x_max", box.x_min, box.x_max, "x");
  check("y_max", box.y_min, box.y_max, "y");
  check("z_max", box.z_min, box.z_max, "z");
}

/// A scan lies at z 0 of its frame, that of a ring too.
void check_height(const Mapping& filter, const FilterBox& box) {
  if (!filter.has("box") || (box.z_min.value_or(0) <= 0 && box.z_max.value_or(0) >= 0)) return;
  filter.inside("box")
      .where(box.z_min.value_or(0) > 0 ? "z_min" : "z_max")
      .fail("leaves out the whole scan, which lies at 0", "z_min <= 0 <= z_max, or no such keys");
}

void check_intensity(const Mapping& yaml, const SensorConfig& sensor) {
  const F& filter = sensor.filter;
  if (filter.intensity_min && filter.intensity_max && *filter.intensity_max < *filter.intensity_min)
    yaml.where("intensity_max").fail("is below intensity_min", "intensity_min <= intensity_max");
  if (!filter.by_intensity() || sensor.model->kind == FrameKind::cloud || sensor.driver.publish_intensity)
    return;
  yaml.where(filter.intensity_min ? "intensity_min" : "intensity_max")
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
    filter.find_inliers =
        reinterpret_cast<FindInliers>(module_function("lidard_outliers", "lidard_find_inliers", "it needs"));
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
  yaml.attempt_rule([&] { check_intensity(yaml, sensor); });
  yaml.attempt_rule([&] { check_box(yaml, "box", sensor.filter.box); });
  yaml.attempt_rule([&] { check_box(yaml, "cut_out", sensor.filter.cut_out); });
  const bool gives_scan = sensor.model->kind == FrameKind::scan || parent.has("scan_ring");
  if (gives_scan) yaml.attempt_rule([&] { check_height(yaml, sensor.filter.box); });
  yaml.attempt_rule([&] { check_voxels(yaml, sensor); });
  yaml.attempt_rule([&] { load_outliers(yaml, sensor.filter); });
}

}  // namespace lidard
