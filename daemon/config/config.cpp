// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config.h"

#include <cmath>
#include <iterator>

#include "daemon/config/config_parts.h"
#include "daemon/config/read_file.h"

namespace lidard {
namespace {

constexpr double largest_vehicle_m = 1000;
constexpr double smallest_area_m2 = 1e-4;

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Do the closed segments a–b and c–d have a point in common?
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto side = [](const Point& p, const Point& q, const Point& r) {
    const double area = cross(q - p, r - p);
    return area > 0 ? 1 : area < 0 ? -1 : 0;
  };
  const auto within = [](const Point& p, const Point& q, const Point& r) {
    return (r - p).dot(r - q) <= 0;  // r on the line p–q lies between them
  };
  const int sides[] = {side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b)};
  if (sides[0] != sides[1] && sides[2] != sides[3]) return true;
  return (sides[0] == 0 && within(a, b, c)) || (sides[1] == 0 && within(a, b, d)) ||
         (sides[2] == 0 && within(c, d, a)) || (sides[3] == 0 && within(c, d, b));
}

double area_of(const std::vector<Point>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return std::abs(twice) / 2;
}

void check_simple(const std::vector<Point>& polygon, const std::vector<Value>& vertices) {
  const std::size_t n = polygon.size();
  const std::string expected = "vertices in order around the vehicle, each once";
  for (std::size_t i = 0; i < n; ++i) {
    if ((polygon[i] - polygon[(i + 1) % n]).norm() < 1e-6)
      vertices[(i + 1) % n].fail("is the same point as its neighbour", expected);
  }
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j == n - 1) continue;
      if (meet(polygon[i], polygon[i + 1], polygon[j], polygon[(j + 1) % n]))
        vertices[j].fail("begins an edge that crosses the one from vertex " + std::to_string(i), expected);
    }
  }
}

std::vector<Point> read_footprint(const Value& value) {
  const std::string expected = "a list of 3 to 1000 vertices [x, y] in m";
  const std::vector<Value> vertices = value.items(expected);
  if (vertices.empty()) return {};
  if (vertices.size() < 3 || vertices.size() > 1000)
    value.fail("has " + std::to_string(vertices.size()) + " vertices", expected);
  std::vector<Point> polygon;
  for (const Value& vertex : vertices) {
    const std::vector<double> xy = vertex.numbers(2, largest_vehicle_m, "m");
    polygon.emplace_back(xy[0], xy[1]);
  }
  check_simple(polygon, vertices);
  if (area_of(polygon) < smallest_area_m2) value.fail("has no area", expected);
  return polygon;
}

std::string optional_topic(Mapping& yaml, const char* key) {
  const auto topic = yaml.find(key);
  return topic && !topic->text_or_empty().empty() ? read_topic(*topic) : std::string();
}

/// Where the poses come from that scans are deskewed with.
void read_motion(Mapping& yaml, VehicleConfig& vehicle) {
  const auto odometry = yaml.find("odometry_frame");
  if (odometry && !odometry->text_or_empty().empty()) {
    vehicle.odometry_frame = read_frame(*odometry);
    if (vehicle.odometry_frame == vehicle.base_frame)
      odometry->fail("is base_frame too", "the frame that stands still, usually odom");
  }
  vehicle.odometry_topic = optional_topic(yaml, "odometry_topic");
  vehicle.imu_topic = optional_topic(yaml, "imu_topic");
  vehicle.speed_topic = optional_topic(yaml, "speed_topic");
  if (vehicle.imu_topic.empty() != vehicle.speed_topic.empty())
    yaml.where(vehicle.imu_topic.empty() ? "speed_topic" : "imu_topic")
        .fail_at_key("stands alone", "imu_topic (turn rates) and speed_topic together");
  const char* second = nullptr;
  if (!vehicle.odometry_topic.empty() && !vehicle.odometry_frame.empty()) second = "odometry_topic";
  if (!vehicle.imu_topic.empty() && (!vehicle.odometry_topic.empty() || !vehicle.odometry_frame.empty()))
    second = "imu_topic";
  if (second != nullptr)
    yaml.where(second).fail_at_key("is a second source of motion",
                                   "one of odometry_frame, odometry_topic, or imu_topic with speed_topic");
}

void read_vehicle(Mapping& root, VehicleConfig& vehicle) {
  const auto section = root.find("vehicle");
  if (!section) return;
  Mapping yaml(*section,
               {"base_frame", "footprint", "odometry_frame", "odometry_topic", "imu_topic", "speed_topic"});
  if (const auto frame = yaml.find("base_frame")) vehicle.base_frame = read_frame(*frame);
  if (const auto footprint = yaml.find("footprint")) vehicle.footprint = read_footprint(*footprint);
  read_motion(yaml, vehicle);
}

void warn_of_unused(Mapping& root, Config& config, const ConfigClaims& claims) {
  Value section = *root.find("sensors");
  for (const auto& [name, entry] : named_entries(section)) {
    const SensorConfig* sensor = config.find_sensor(name);
    if (sensor->model == nullptr && !claims.is_used(name))
      warn(config, entry.key_place(), entry.path() + " is used by no merged and no virtual scan");
  }
}

}  // namespace

const SensorConfig* Config::find_sensor(const std::string& name) const {
  for (const SensorConfig& sensor : sensors) {
    if (sensor.name == name) return &sensor;
  }
  return nullptr;
}

Config parse_config(const std::string& text, const std::string& name) {
  Config config;
  config.file = name;
  Mapping root(parse_yaml(text, name), {"vehicle", "sensors", "merged_scans", "virtual_scans"});
  ConfigClaims claims;
  read_vehicle(root, config.vehicle);
  read_sensors(root, config, claims);
  read_virtual_scans(root, config, claims);
  read_merged_scans(root, config, claims);
  warn_of_unused(root, config, claims);
  return config;
}

Config load_config(const std::string& path) {
  return parse_config(read_file(path, "a readable YAML file"), path);
}

}  // namespace lidard
