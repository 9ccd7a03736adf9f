// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `vehicle:` of a configuration.
#include <cmath>

#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;

constexpr double largest_vehicle_m = 1000;
constexpr double smallest_area_m2 = 1e-4;

using Point = Eigen::Vector2d;

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }

/// True if the closed segments a–b and c–d intersect.
bool meet(const Point& a, const Point& b, const Point& c, const Point& d) {
  const auto side = [](const Point& p, const Point& q, const Point& r) {
    const double area = cross(q - p, r - p);
    return area > 0 ? 1 : area < 0 ? -1 : 0;
  };
  const auto within = [](const Point& p, const Point& q, const Point& r) {
    return (r - p).dot(r - q) <= 0;  // r is on the line p–q: is it between them?
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

KeyOf<VehicleConfig> footprint_row() {
  const auto get = [](const VehicleConfig& vehicle) {
    KeyList vertices;
    for (const Point& vertex : vehicle.footprint) vertices.push_back(KeyList{vertex.x(), vertex.y()});
    return vertices;
  };
  return special<VehicleConfig>(
      "footprint", "[[x, y], …], m", get,
      "polygon in base_frame; returns from inside are left out; published on the topic footprint");
}

/// Checks the source of the vehicle's motion.
void check_motion(const Mapping& yaml, const VehicleConfig& vehicle) {
  const bool odometry = !vehicle.odometry_frame.empty();
  const bool topic = !vehicle.odometry_topic.empty();
  const bool imu = !vehicle.imu_topic.empty();
  if (odometry && vehicle.odometry_frame == vehicle.base_frame)
    yaml.where("odometry_frame").fail("is base_frame too", "the frame that stands still, usually odom");
  if (imu == vehicle.speed_topic.empty())
    yaml.where(imu ? "imu_topic" : "speed_topic")
        .fail_at_key("stands alone", "imu_topic (turn rates) and speed_topic together");
  if ((topic && odometry) || (imu && (topic || odometry)))
    yaml.where(imu ? "imu_topic" : "odometry_topic")
        .fail_at_key("is a second source of motion",
                     "one of odometry_frame, odometry_topic, or imu_topic with speed_topic");
}

}  // namespace

const Keys<VehicleConfig>& vehicle_keys() {
  using V = VehicleConfig;
  static const Keys<V> all{
      frame("base_frame", &V::base_frame, "the frame of the vehicle"),
      footprint_row(),
      frame("odometry_frame", &V::odometry_frame,
            "poses of base_frame in it come from tf; scans are deskewed by them; empty: none")
          .or_empty(),
      topic("odometry_topic", &V::odometry_topic, "or from a nav_msgs/Odometry; empty: none").or_empty(),
      topic("imu_topic", &V::imu_topic,
            "or from the turn rates of a sensor_msgs/Imu and a speed ahead; empty: none")
          .or_empty(),
      topic("speed_topic", &V::speed_topic, "that speed, a geometry_msgs/TwistStamped").or_empty()};
  return all;
}

void read_vehicle(Mapping& root, Reading& reading) {
  const auto section = root.find("vehicle");
  if (!section) return;
  VehicleConfig& vehicle = reading.config.vehicle;
  Mapping yaml = mapping_of(*section, vehicle_keys());
  read_keys(yaml, vehicle_keys(), vehicle);
  if (const auto footprint = yaml.find("footprint")) {
    vehicle.footprint = read_footprint(*footprint);
    // The outline is published: RosOutline.
    if (!vehicle.footprint.empty()) reading.claims.publishes("footprint", "vehicle.footprint", *footprint);
  }
  check_motion(yaml, vehicle);
}

}  // namespace lidard
