// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/calibration_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <set>

#include "core/base/nearest.h"
#include "daemon/config/calibration_parts.h"
#include "daemon/config/read_file.h"
#include "daemon/config/yaml_reader.h"
#include "drivers/velodyne/models.h"

namespace lidard {
namespace {

using velodyne::Calibration;
using velodyne::CalibrationModel;
using velodyne::LaserCalibration;
using velodyne::TwoPoint;

constexpr const char* expected_file = "a calibration of velodyne_pointcloud (YAML) or a db.xml";

/// A number of each laser. The limits catch other units: degrees, mm.
struct LaserKey {
  std::string_view name;
  double LaserCalibration::*member;
  double limit;
  const char* unit;
};
constexpr LaserKey laser_keys[] = {{"rot_correction", &LaserCalibration::rot_correction, 6.2832, "rad"},
                                   {"vert_correction", &LaserCalibration::vert_correction, 1.5708, "rad"},
                                   {"dist_correction", &LaserCalibration::dist_correction, 10, "m"},
                                   {"dist_correction_x", &LaserCalibration::dist_correction_x, 10, "m"},
                                   {"dist_correction_y", &LaserCalibration::dist_correction_y, 10, "m"},
                                   {"vert_offset_correction", &LaserCalibration::vert_offset, 10, "m"},
                                   {"horiz_offset_correction", &LaserCalibration::horiz_offset, 10, "m"},
                                   {"focal_distance", &LaserCalibration::focal_distance, 1e5, "m"},
                                   {"focal_slope", &LaserCalibration::focal_slope, 1e4, ""}};
const std::vector<std::string_view> known_of_laser = {"laser_id",
                                                      "rot_correction",
                                                      "vert_correction",
                                                      "dist_correction",
                                                      "dist_correction_x",
                                                      "dist_correction_y",
                                                      "vert_offset_correction",
                                                      "horiz_offset_correction",
                                                      "focal_distance",
                                                      "focal_slope",
                                                      "two_pt_correction_available",
                                                      "min_intensity",
                                                      "max_intensity"};
const std::vector<std::string_view> known_of_file = {"num_lasers", "distance_resolution", "lasers"};

/// Reads one YAML file.
class YamlCalibration {
 public:
  explicit YamlCalibration(std::vector<std::string>& warnings) : warnings_(warnings) {}

  Calibration read(const Value& file) {
    const Entries entries = entries_of(file, known_of_file);
    const Value* lasers = find(entries, "lasers");
    const Value* step = find(entries, "distance_resolution");
    if (lasers == nullptr) file.fail("has no lasers", expected_file);
    if (step == nullptr)
      file.fail("has no distance_resolution", "it in m: 0.002, or 0.004 for VLP-32A/B/C and VLS-128");
    Calibration calibration;
    calibration.model = CalibrationModel::ros_drivers;
    read_lasers(*lasers, find(entries, "num_lasers"), calibration.lasers);
    const double step_m = step->number(finest_step_m, coarsest_step_m, "m");
    calibration.distance_step_m =
        guarded_step(step_m, calibration.lasers.size(), step->place().to_string(), warnings_);
    warn_of_two_point(*lasers, calibration);
    return calibration;
  }

 private:
  using Entries = std::vector<std::pair<std::string, Value>>;
  struct NumberedLaser {
    std::size_t id;
    LaserCalibration laser;
  };

  static const Value* find(const Entries& entries, std::string_view key) {
    for (const auto& [name, value] : entries) {
      if (name == key) return &value;
    }
    return nullptr;
  }

  /// The entries; keys that nobody knows are told once, not once per laser.
  Entries entries_of(const Value& value, const std::vector<std::string_view>& known) {
    Entries entries = named_entries(value);
    for (const auto& [key, entry] : entries) {
      if (std::find(known.begin(), known.end(), key) != known.end() || !told_.insert(key).second) continue;
      const std::string_view near = nearest_word(key, known);
      warnings_.push_back(entry.key_place().to_string() + ": unknown key " + entry.path() + " is ignored" +
                          (near.empty() ? "" : "; perhaps " + std::string(near)));
    }
    return entries;
  }

  void read_lasers(const Value& list, const Value* number, std::vector<LaserCalibration>& lasers) {
    const std::vector<Value> items = list.items("a list with one entry per laser");
    if (items.empty() || items.size() > static_cast<std::size_t>(most_lasers))
      list.fail("has " + std::to_string(items.size()) + " entries", "1 to 128 lasers");
    const std::string count = std::to_string(items.size());
    if (number != nullptr && number->integer(1, most_lasers) != static_cast<long>(items.size()))
      number->fail("is " + number->quoted() + ", but lasers has " + count + " entries", count);
    std::vector<bool> is_there(items.size());
    lasers.resize(items.size());
    for (const Value& item : items) {
      const NumberedLaser read = read_laser(item, items.size());
      if (is_there[read.id])
        item.fail("is laser " + std::to_string(read.id) + " again",
                  "each laser_id from 0 to " + std::to_string(items.size() - 1) + " once");
      is_there[read.id] = true;
      lasers[read.id] = read.laser;
    }
  }

  NumberedLaser read_laser(const Value& item, std::size_t lasers) {
    const Entries entries = entries_of(item, known_of_laser);
    for (const char* key : {"laser_id", "rot_correction", "vert_correction"}) {
      if (find(entries, key) == nullptr) item.fail(std::string("has no ") + key, "it for each laser");
    }
    NumberedLaser read{};
    read.id = static_cast<std::size_t>(find(entries, "laser_id")->integer(0, static_cast<long>(lasers) - 1));
    for (const LaserKey& key : laser_keys) {
      if (const Value* value = find(entries, key.name))
        read.laser.*key.member = value->number(-key.limit, key.limit, key.unit);
    }
    read_intensities(entries, read.laser);
    const bool has_near = read.laser.dist_correction_x != 0 || read.laser.dist_correction_y != 0;
    read.laser.two_point = has_near ? TwoPoint::unstated : TwoPoint::off;
    if (const Value* value = find(entries, "two_pt_correction_available"))
      read.laser.two_point = value->boolean() ? TwoPoint::on : TwoPoint::off;
    return read;
  }

  /// velodyne_pointcloud floors them.
  void read_intensities(const Entries& entries, LaserCalibration& laser) {
    constexpr double limit = 65535;
    const Value* lowest = find(entries, "min_intensity");
    const Value* highest = find(entries, "max_intensity");
    if (lowest != nullptr) laser.min_intensity = static_cast<int>(std::floor(lowest->number(0, limit, "")));
    if (highest != nullptr) laser.max_intensity = static_cast<int>(std::floor(highest->number(0, limit, "")));
    if (laser.min_intensity > laser.max_intensity)
      warnings_.push_back((highest != nullptr ? *highest : *lowest).place().to_string() +
                          ": min_intensity is above max_intensity, so all intensities become " +
                          std::to_string(laser.max_intensity));
  }

  void warn_of_two_point(const Value& list, const Calibration& calibration) {
    const auto count =
        std::count_if(calibration.lasers.begin(), calibration.lasers.end(),
                      [](const LaserCalibration& laser) { return laser.two_point == TwoPoint::unstated; });
    if (count == 0) return;
    warnings_.push_back(list.key_place().to_string() + ": " + std::to_string(count) +
                        " lasers have near corrections but no two_pt_correction_available: calibration_model "
                        "ros_drivers leaves them out, as velodyne_pointcloud does, exact uses them");
  }

  std::vector<std::string>& warnings_;
  std::set<std::string> told_;
};

bool is_xml(const std::string& text) {
  const std::size_t begin = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  const std::size_t first = text.find_first_not_of(" \t\r\n", begin);
  return first != std::string::npos && text[first] == '<';
}

}  // namespace

double guarded_step(double step_m, std::size_t lasers, const std::string& place,
                    std::vector<std::string>& warnings) {
  constexpr double wrong_step_m = 0.007;
  constexpr double right_step_m = 0.004;  // VLS-128 user manual 63-9483
  if (lasers != static_cast<std::size_t>(most_lasers) || std::abs(step_m - wrong_step_m) > 1e-6)
    return step_m;
  warnings.push_back(place + ": a distance step of 7 mm is a known mistake of VLS-128 files; 4 mm is used");
  return right_step_m;
}

Calibration parse_calibration(const std::string& text, const std::string& name,
                              std::vector<std::string>& warnings) {
  if (is_xml(text)) return parse_calibration_xml(text, name, warnings);
  return YamlCalibration(warnings).read(parse_yaml(text, name));
}

Calibration load_calibration(const std::string& path, std::vector<std::string>& warnings) {
  return parse_calibration(read_file(path, expected_file), path, warnings);
}

bool takes_calibration(const Model& model) { return model.has(Trait::calibration); }

std::string calibration_misfit(const Calibration& calibration, const Model& model) {
  const std::string product(model.product);
  if (!takes_calibration(model)) return "is for a Velodyne, " + product + " takes none";
  if (model.beams == 0 || model.beams == calibration.lasers.size()) return {};
  return "has " + std::to_string(calibration.lasers.size()) + " lasers, " + product + " has " +
         std::to_string(model.beams);
}

std::optional<CalibrationModel> calibration_model_of(std::string_view name) {
  for (const auto& [known, equations] : calibration_models) {
    if (known == name) return equations;
  }
  return std::nullopt;
}

std::string_view name_of(CalibrationModel equations) {
  for (const auto& [name, known] : calibration_models) {
    if (known == equations) return name;
  }
  return {};
}

CalibrationModel usual_equations(const Calibration& calibration, const Model& model) {
  const bool s1 = static_cast<const velodyne::ModelRow*>(model.row)->bank_by_bank;
  return s1 && calibration.is_db_xml ? CalibrationModel::veloview : CalibrationModel::ros_drivers;
}

std::string calibration_doubt(const Calibration& calibration, const Model& model) {
  if (!takes_calibration(model)) return {};
  const double usual = static_cast<const velodyne::ModelRow*>(model.row)->distance_step_m;
  if (std::abs(calibration.distance_step_m - usual) < 1e-6) return {};
  const auto mm = [](double m) {
    char text[32];
    std::snprintf(text, sizeof text, "%g mm", std::round(m * 1e6) / 1e3);
    return std::string(text);
  };
  return "has a distance step of " + mm(calibration.distance_step_m) + ", but " + std::string(model.product) +
         " counts in " + mm(usual) + ": is it the right file?";
}

}  // namespace lidard
