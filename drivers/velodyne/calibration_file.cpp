// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration_file.h"

#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include "core/base/angle.h"
#include "core/base/nearest.h"
#include "core/base/number_text.h"

namespace lidard {
namespace {

using tinyxml2::XMLElement;

constexpr long most_lasers = 128;
constexpr double finest_step_m = 0.001;  // limits of a distance step; 0.2 is a step in cm
constexpr double coarsest_step_m = 0.02;
constexpr double m_per_cm = 0.01;
constexpr double usual_step_cm = 0.2;  // of old files without distLSB_: HDL-64E and HDL-32E

/// A number per laser, in YAML and in XML. The limits detect wrong units: degrees, mm.
struct LaserNumber {
  double LaserCalibration::*member;
  std::string_view key;
  double limit;
  const char* unit;
  const char* element;
  double element_limit;  // in the unit of the db.xml
  double factor;         // from that unit to the YAML's
};
using L = LaserCalibration;
constexpr LaserNumber laser_numbers[] = {
    {&L::rot_correction, "rot_correction", 6.2832, "rad", "rotCorrection_", 360, rad_per_deg},
    {&L::vert_correction, "vert_correction", 1.5708, "rad", "vertCorrection_", 90, rad_per_deg},
    {&L::dist_correction, "dist_correction", 10, "m", "distCorrection_", 1000, m_per_cm},
    {&L::dist_correction_x, "dist_correction_x", 10, "m", "distCorrectionX_", 1000, m_per_cm},
    {&L::dist_correction_y, "dist_correction_y", 10, "m", "distCorrectionY_", 1000, m_per_cm},
    {&L::vert_offset, "vert_offset_correction", 10, "m", "vertOffsetCorrection_", 1000, m_per_cm},
    {&L::horiz_offset, "horiz_offset_correction", 10, "m", "horizOffsetCorrection_", 1000, m_per_cm},
    {&L::focal_distance, "focal_distance", 1e5, "m", "focalDistance_", 1e7, m_per_cm},
    {&L::focal_slope, "focal_slope", 1e4, "", "focalSlope_", 1e4, 1}};

std::vector<std::string_view> keys_of_laser() {
  std::vector<std::string_view> keys{"laser_id"};
  for (const LaserNumber& number : laser_numbers) keys.push_back(number.key);
  for (const char* key : {"two_pt_correction_available", "min_intensity", "max_intensity"})
    keys.emplace_back(key);
  return keys;
}
const std::vector<std::string_view> known_of_laser = keys_of_laser();
const std::vector<std::string_view> known_of_file = {"num_lasers", "distance_resolution", "lasers"};

/// The distance step to use, with a warning: common VLS-128 files have 7 mm, but the sensor counts in 4 mm.
double guarded_step(double step_m, std::size_t lasers, const std::string& where,
                    std::vector<std::string>& warnings) {
  constexpr double wrong_step_m = 0.007;
  constexpr double right_step_m = 0.004;  // VLS-128 user manual 63-9483
  if (lasers != static_cast<std::size_t>(most_lasers) || std::abs(step_m - wrong_step_m) > 1e-6)
    return step_m;
  warnings.push_back(where + ": a distance step of 7 mm is a known mistake of VLS-128 files; 4 mm is used");
  return right_step_m;
}

/// Reads one YAML file.
class YamlCalibration {
 public:
  explicit YamlCalibration(std::vector<std::string>& warnings) : warnings_(warnings) {}

  Calibration read(const Value& file) {
    const Mapping entries = entries_of(file, known_of_file);
    const auto lasers = entries.find("lasers");
    const auto step = entries.find("distance_resolution");
    if (!lasers) file.fail("has no lasers", calibration_files);
    if (!step)
      file.fail("has no distance_resolution", "it in m: 0.002, or 0.004 for VLP-32A/B/C and VLS-128");
    Calibration calibration;
    calibration.model = CalibrationModel::ros_drivers;
    read_lasers(*lasers, entries.find("num_lasers"), calibration.lasers);
    const double step_m = step->number(finest_step_m, coarsest_step_m, "m");
    calibration.distance_step_m =
        guarded_step(step_m, calibration.lasers.size(), step->place().to_string(), warnings_);
    warn_of_two_point(*lasers, calibration);
    return calibration;
  }

 private:
  struct NumberedLaser {
    std::size_t id;
    LaserCalibration laser;
  };

  /// The entries; an unknown key is reported once, not once per laser.
  Mapping entries_of(const Value& value, const std::vector<std::string_view>& known) {
    Mapping mapping(value);
    for (const auto& [key, entry] : mapping.entries()) {
      if (std::find(known.begin(), known.end(), key) != known.end() || !reported_.insert(key).second)
        continue;
      const std::string_view near = nearest_word(key, known);
      warnings_.push_back(entry.key_place().to_string() + ": unknown key " + entry.path() + " is ignored" +
                          (near.empty() ? "" : "; perhaps " + std::string(near)));
    }
    return mapping;
  }

  void read_lasers(const Value& list, const std::optional<Value>& number,
                   std::vector<LaserCalibration>& lasers) {
    const std::vector<Value> items = list.items("a list with one entry per laser");
    if (items.empty() || items.size() > static_cast<std::size_t>(most_lasers))
      list.fail("has " + std::to_string(items.size()) + " entries", "1 to 128 lasers");
    const std::string count = std::to_string(items.size());
    if (number && number->integer(1, most_lasers) != static_cast<long>(items.size()))
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
    const Mapping entries = entries_of(item, known_of_laser);
    for (const char* key : {"laser_id", "rot_correction", "vert_correction"}) {
      if (!entries.has(key)) item.fail(std::string("has no ") + key, "it for each laser");
    }
    NumberedLaser read{};
    read.id = static_cast<std::size_t>(entries.find("laser_id")->integer(0, static_cast<long>(lasers) - 1));
    for (const LaserNumber& key : laser_numbers) {
      if (const auto value = entries.find(key.key))
        read.laser.*key.member = value->number(-key.limit, key.limit, key.unit);
    }
    read_intensities(entries, read.laser);
    const bool has_near = read.laser.dist_correction_x != 0 || read.laser.dist_correction_y != 0;
    read.laser.two_point = has_near ? TwoPoint::unstated : TwoPoint::off;
    if (const auto value = entries.find("two_pt_correction_available"))
      read.laser.two_point = value->boolean() ? TwoPoint::on : TwoPoint::off;
    return read;
  }

  /// velodyne_pointcloud truncates them.
  void read_intensities(const Mapping& entries, LaserCalibration& laser) {
    constexpr double limit = 65535;
    const auto lowest = entries.find("min_intensity");
    const auto highest = entries.find("max_intensity");
    if (lowest) laser.min_intensity = static_cast<int>(std::floor(lowest->number(0, limit, "")));
    if (highest) laser.max_intensity = static_cast<int>(std::floor(highest->number(0, limit, "")));
    const std::optional<Value>& last = highest ? highest : lowest;
    if (last && laser.min_intensity > laser.max_intensity)
      warnings_.push_back(last->place().to_string() +
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
  std::set<std::string> reported_;
};

/// Reads a db.xml of boost::serialization; attributes are ignored.
class XmlCalibration {
 public:
  XmlCalibration(std::string name, std::vector<std::string>& warnings)
      : name_(std::move(name)), warnings_(warnings) {}

  Calibration read(const std::string& text) {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS)
      fail(document.ErrorLineNum(), std::string("not XML: ") + document.ErrorName(),
           "a db.xml as it came with the sensor");
    const XMLElement* root = document.RootElement();
    const XMLElement* db = root == nullptr ? nullptr : root->FirstChildElement("DB");
    if (db == nullptr)
      fail(root == nullptr ? 1 : root->GetLineNum(), "no DB element", "boost_serialization/DB");
    Calibration calibration;
    calibration.model = CalibrationModel::ros_drivers;
    calibration.is_db_xml = true;
    read_points(*db, calibration.lasers);
    read_intensities(*db, calibration.lasers);
    const XMLElement* step = db->FirstChildElement("distLSB_");
    const double step_m =
        step == nullptr ? usual_step_cm * m_per_cm
                        : number(*step, finest_step_m / m_per_cm, coarsest_step_m / m_per_cm) * m_per_cm;
    const int line = step == nullptr ? db->GetLineNum() : step->GetLineNum();
    calibration.distance_step_m = guarded_step(step_m, calibration.lasers.size(), where(line), warnings_);
    return calibration;
  }

 private:
  std::string where(int line) const { return name_ + ":" + std::to_string(line); }
  [[noreturn]] void fail(int line, const std::string& what, const std::string& expected) const {
    throw ConfigError(where(std::max(line, 1)) + ": " + what + "; expected " + expected);
  }

  double number(const XMLElement& element, double lowest, double highest) const {
    const char* content = element.GetText();
    std::string_view text = content == nullptr ? "" : content;
    const char* blanks = " \t\r\n+";
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    text = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_number = error == std::errc() && end == text.data() + text.size();
    if (!is_number || !(value >= lowest && value <= highest))
      fail(element.GetLineNum(),
           std::string(element.Name()) + " is \"" + printable(std::string(text.substr(0, 40))) + "\"",
           "a number from " + number_text(lowest) + " to " + number_text(highest));
    return value;
  }
  /// The numbers of `DB/name/item`; empty if the element is missing.
  std::vector<double> items(const XMLElement& db, const char* name, double highest) const {
    std::vector<double> list;
    const XMLElement* parent = db.FirstChildElement(name);
    const XMLElement* item = parent == nullptr ? nullptr : parent->FirstChildElement("item");
    for (; item != nullptr; item = item->NextSiblingElement("item"))
      list.push_back(number(*item, 0, highest));
    return list;
  }

  /// Many files have 64 points for every sensor; enabled_ marks the valid ones.
  void read_points(const XMLElement& db, std::vector<LaserCalibration>& lasers) {
    const std::vector<double> enabled = items(db, "enabled_", 1);
    const XMLElement* points = db.FirstChildElement("points_");
    if (points == nullptr) fail(db.GetLineNum(), "DB has no points_", "points_ with an item per laser");
    std::vector<int> lines;  // line of each laser, 0: missing
    for (const XMLElement* item = points->FirstChildElement("item"); item != nullptr;
         item = item->NextSiblingElement("item")) {
      const XMLElement* px = item->FirstChildElement("px");
      if (px == nullptr) fail(item->GetLineNum(), "the item has no px", "a px in each item of points_");
      const XMLElement& id_element = child(*px, "id_");
      const auto id = static_cast<std::size_t>(number(id_element, 0, 1e4));
      if (number(id_element, 0, 1e4) != static_cast<double>(id))
        fail(id_element.GetLineNum(), "id_ is a fraction", "the laser's number, from 0");
      if (!enabled.empty() && (id >= enabled.size() || enabled[id] == 0)) continue;
      if (id >= static_cast<std::size_t>(most_lasers))
        fail(px->GetLineNum(), "laser " + std::to_string(id), "at most 128 lasers");
      if (id >= lasers.size()) {
        lasers.resize(id + 1);
        lines.resize(id + 1);
      }
      if (lines[id] != 0)
        fail(px->GetLineNum(),
             "laser " + std::to_string(id) + " again, first in line " + std::to_string(lines[id]),
             "each id_ once");
      lines[id] = px->GetLineNum();
      lasers[id] = read_laser(*px);
    }
    check_complete(*points, enabled, lines);
  }

  void check_complete(const XMLElement& points, const std::vector<double>& enabled,
                      const std::vector<int>& lines) const {
    const auto wanted = static_cast<std::size_t>(std::count(enabled.begin(), enabled.end(), 1.0));
    const auto missing = std::find(lines.begin(), lines.end(), 0);
    if (lines.empty()) fail(points.GetLineNum(), "points_ has no enabled laser", "at least one");
    if (missing != lines.end() || wanted > lines.size()) {
      const auto id = std::to_string(missing - lines.begin());
      fail(points.GetLineNum(), "points_ has no laser " + id,
           "one for each laser, numbered from 0, that enabled_ has");
    }
  }

  const XMLElement& child(const XMLElement& parent, const char* name) const {
    const XMLElement* element = parent.FirstChildElement(name);
    if (element == nullptr)
      fail(parent.GetLineNum(), std::string(parent.Name()) + " has no " + name,
           "it in each " + std::string(parent.Name()));
    return *element;
  }

  LaserCalibration read_laser(const XMLElement& px) const {
    LaserCalibration laser;
    for (const char* required : {"rotCorrection_", "vertCorrection_"}) child(px, required);
    for (const LaserNumber& known : laser_numbers) {
      const XMLElement* element = px.FirstChildElement(known.element);
      if (element != nullptr)
        laser.*known.member = number(*element, -known.element_limit, known.element_limit) * known.factor;
    }
    // As in gen_calibration.py of velodyne_pointcloud.
    const bool has_near = laser.dist_correction_x != 0 && laser.dist_correction_y != 0;
    laser.two_point = has_near ? TwoPoint::on : TwoPoint::off;
    return laser;
  }

  void read_intensities(const XMLElement& db, std::vector<LaserCalibration>& lasers) const {
    const std::vector<double> lowest = items(db, "minIntensity_", 65535);
    const std::vector<double> highest = items(db, "maxIntensity_", 65535);
    for (std::size_t i = 0; i < lasers.size(); ++i) {
      if (i < lowest.size()) lasers[i].min_intensity = static_cast<int>(lowest[i]);
      if (i < highest.size()) lasers[i].max_intensity = static_cast<int>(highest[i]);
    }
  }

  std::string name_;
  std::vector<std::string>& warnings_;
};

bool is_xml(const std::string& text) {
  const std::size_t begin = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  const std::size_t first = text.find_first_not_of(" \t\r\n", begin);
  return first != std::string::npos && text[first] == '<';
}

CalibrationModel read_calibration_model(const Value& value) {
  const std::string expected =
      "ros_drivers (the equations of velodyne_pointcloud), exact (the manual's) or veloview (the viewer's)";
  const auto equations = calibration_model_of(value.text(expected));
  if (equations) return *equations;
  value.fail("is " + value.quoted(), expected);
}

/// `calibration_model:` without a file: the equations for the model's table.
std::shared_ptr<Calibration> table_with(const Value& value, const Model& model) {
  const CalibrationModel equations = read_calibration_model(value);
  if (equations == CalibrationModel::exact) return nullptr;
  if (equations == CalibrationModel::veloview)
    value.fail_at_key("is veloview without calibration", "it with a calibration file");
  if (needs_own_calibration(model))
    value.fail_at_key("is given without calibration", "both: each HDL-64E is calibrated on its own");
  return std::make_shared<Calibration>(table_calibration(model));
}

}  // namespace

Calibration parse_calibration(const std::string& text, const std::string& name, DocumentParser parse_yaml,
                              std::vector<std::string>& warnings) {
  if (is_xml(text)) return XmlCalibration(name, warnings).read(text);
  return YamlCalibration(warnings).read(parse_yaml(text, name));
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

std::shared_ptr<const Calibration> check_calibration(const Mapping& yaml, const Model& model,
                                                     const std::optional<CalibrationFile>& file,
                                                     DocumentParser parse_yaml,
                                                     std::vector<std::string>& warnings) {
  const auto equations = yaml.find("calibration_model");
  if (!file) return equations ? table_with(*equations, model) : nullptr;
  auto calibration =
      std::make_shared<Calibration>(parse_calibration(file->text, file->path, parse_yaml, warnings));
  calibration->model = equations ? read_calibration_model(*equations) : usual_equations(*calibration, model);
  const std::string rejection = calibration_rejection(*calibration, model);
  if (!rejection.empty()) yaml.where("calibration").fail(rejection, "the calibration of this sensor");
  return calibration;
}

}  // namespace lidard
