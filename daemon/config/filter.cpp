// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/filter.h"

#include "daemon/config/module.h"

namespace lidard {
namespace {

constexpr double furthest_m = 1000;
constexpr double highest_intensity = 65535;
constexpr const char* box_form = "two opposite corners [[x, y, z], [x, y, z]], m";

KeyValue corners_of(const std::optional<FilterBox>& box) {
  const auto corner = [](const Eigen::Vector3d& at) { return KeyList{at.x(), at.y(), at.z()}; };
  return box ? KeyValue(KeyList{corner(box->min()), corner(box->max())}) : KeyValue();
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
void check_height(const Mapping& yaml, const FrameFilterSettings& filter) {
  if (filter.box && (filter.box->min().z() > 0 || filter.box->max().z() < 0))
    yaml.where("box").fail("leaves out the whole scan, which lies at z 0", "a box from z <= 0 to z >= 0");
}

void check_intensity(const Mapping& yaml, const FilteredFrames& frames) {
  if (yaml.has("intensity_min") && frames.model.kind == FrameKind::scan && !frames.have_intensities)
    yaml.where("intensity_min")
        .fail_at_key("has nothing to go by: publish_intensity is false",
                     "publish_intensity: true, or no such key");
}

void load_outliers(const Mapping& yaml, FrameFilterSettings& filter) {
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

void check_voxels(const Mapping& yaml, const Model& model, const FrameFilterSettings& filter) {
  if (filter.voxel_size > 0 && model.kind == FrameKind::scan)
    yaml.where("voxel_size")
        .fail_at_key("is not available for " + std::string(model.name) + ", which gives no clouds",
                     "no such key: every beam of a scan has its place");
}

}  // namespace

Keys filter_keys(FrameFilterSettings& filter) {
  using namespace keys;
  return join(
      {{{"intensity_min", filter.intensity_min, number(0, highest_intensity, ""),
         "weaker returns are removed", preset("no limit")},
        {"box", corners_of(filter.box), special(box_form),
         "returns outside are removed; in frame_id of the sensor"},
        {"cut_out", corners_of(filter.cut_out), special(box_form),
         "returns inside are removed: the vehicle itself"}},
       only_if(filter.voxel_size > 0,
               {{"voxel_size", filter.voxel_size, number(0, 100, "m"),
                 "clouds: of the returns in such a cube the one nearest to its centre stays; 0: all"}}),
       only_if(filter.outlier_radius > 0,
               {{"outlier_radius", filter.outlier_radius, number(0, 100, "m"),
                 "where others are looked for; 0: outliers stay; needs the package lidard-pcl"},
                {"outlier_neighbours", filter.outlier_neighbours, whole(1, 1000),
                 "a return with fewer others in that radius is an outlier"}})});
}

void check_filter(const Mapping& yaml, const FilteredFrames& frames, FrameFilterSettings& filter) {
  check_intensity(yaml, frames);
  read_box(yaml, "box", filter.box);
  read_box(yaml, "cut_out", filter.cut_out);
  if (frames.have_scan) check_height(yaml, filter);
  check_voxels(yaml, frames.model, filter);
  load_outliers(yaml, filter);
}

}  // namespace lidard
