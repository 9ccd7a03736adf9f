// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <tinyxml2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/calibration_parts.h"
#include "daemon/config/config.h"

namespace lidard {
namespace {

using tinyxml2::XMLElement;
using velodyne::Calibration;
using velodyne::CalibrationModel;
using velodyne::LaserCalibration;
using velodyne::TwoPoint;

constexpr double m_per_cm = 0.01;
constexpr double usual_step_cm = 0.2;  // of files from before distLSB_: all of them HDL-64E and HDL-32E

/// An element of each laser.
struct LaserElement {
  const char* name;
  double LaserCalibration::*member;
  double factor;
  double limit;  // in the unit of the file
};
constexpr LaserElement laser_elements[] = {
    {"rotCorrection_", &LaserCalibration::rot_correction, rad_per_deg, 360},
    {"vertCorrection_", &LaserCalibration::vert_correction, rad_per_deg, 90},
    {"distCorrection_", &LaserCalibration::dist_correction, m_per_cm, 1000},
    {"distCorrectionX_", &LaserCalibration::dist_correction_x, m_per_cm, 1000},
    {"distCorrectionY_", &LaserCalibration::dist_correction_y, m_per_cm, 1000},
    {"vertOffsetCorrection_", &LaserCalibration::vert_offset, m_per_cm, 1000},
    {"horizOffsetCorrection_", &LaserCalibration::horiz_offset, m_per_cm, 1000},
    {"focalDistance_", &LaserCalibration::focal_distance, m_per_cm, 1e7},
    {"focalSlope_", &LaserCalibration::focal_slope, 1, 1e4}};

/// Reads one db.xml: what boost::serialization wrote, its attributes are of no interest.
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
    calibration.distance_step_m = guarded_step(step_m, calibration.lasers.size(), place(line), warnings_);
    return calibration;
  }

 private:
  std::string place(int line) const { return name_ + ":" + std::to_string(line); }
  [[noreturn]] void fail(int line, const std::string& what, const std::string& expected) const {
    throw ConfigError(place(std::max(line, 1)) + ": " + what + "; expected " + expected);
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
      fail(element.GetLineNum(), std::string(element.Name()) + " is " + quoted(text),
           "a number from " + number_text(lowest) + " to " + number_text(highest));
    return value;
  }
  static std::string quoted(std::string_view text) {
    std::string quote(text.substr(0, 40));
    for (char& c : quote) c = static_cast<unsigned char>(c) < 0x20 ? '?' : c;
    return '"' + quote + '"';
  }

  /// The numbers of `DB/name/item`; empty where the element is not there.
  std::vector<double> items(const XMLElement& db, const char* name, double highest) const {
    std::vector<double> list;
    const XMLElement* parent = db.FirstChildElement(name);
    const XMLElement* item = parent == nullptr ? nullptr : parent->FirstChildElement("item");
    for (; item != nullptr; item = item->NextSiblingElement("item"))
      list.push_back(number(*item, 0, highest));
    return list;
  }

  /// Many files have 64 points whatever the sensor; enabled_ says which of them it has.
  void read_points(const XMLElement& db, std::vector<LaserCalibration>& lasers) {
    const std::vector<double> enabled = items(db, "enabled_", 1);
    const XMLElement* points = db.FirstChildElement("points_");
    if (points == nullptr) fail(db.GetLineNum(), "DB has no points_", "points_ with an item per laser");
    std::vector<int> lines;  // where each laser stands, 0: nowhere
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
    for (const LaserElement& known : laser_elements) {
      const XMLElement* element = px.FirstChildElement(known.name);
      if (element != nullptr)
        laser.*known.member = number(*element, -known.limit, known.limit) * known.factor;
    }
    // As the script gen_calibration.py of velodyne_pointcloud converts it.
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

}  // namespace

Calibration parse_calibration_xml(const std::string& text, const std::string& name,
                                  std::vector<std::string>& warnings) {
  return XmlCalibration(name, warnings).read(text);
}

}  // namespace lidard
