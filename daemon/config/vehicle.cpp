// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Boost.Geometry includes a header that Boost itself calls deprecated.
#define BOOST_ALLOW_DEPRECATED_HEADERS
#include "daemon/config/vehicle.h"

#include <boost/geometry.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>

#include "daemon/config/reading.h"
#include "daemon/config/rows.h"

namespace lidard {
namespace {

constexpr double largest_vehicle_m = 1000;
constexpr double smallest_area_m2 = 1e-4;

namespace geometry = boost::geometry;
using Point = Eigen::Vector2d;
using Outline = geometry::model::polygon<geometry::model::d2::point_xy<double>, false, false>;

std::vector<Point> read_footprint(const Value& value) {
  const std::string expected = "a list of 3 to 1000 vertices [x, y] in m";
  const std::vector<Value> vertices = value.items(expected);
  if (vertices.empty()) return {};
  if (vertices.size() < 3 || vertices.size() > 1000)
    value.fail("has " + std::to_string(vertices.size()) + " vertices", expected);
  std::vector<Point> polygon;
  Outline outline;
  for (const Value& vertex : vertices) {
    const std::vector<double> xy = vertex.numbers(2, largest_vehicle_m, "m");
    polygon.emplace_back(xy[0], xy[1]);
    geometry::append(outline, Outline::point_type(xy[0], xy[1]));
  }
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    if ((polygon[i] - polygon[(i + 1) % polygon.size()]).norm() < 1e-6)
      vertices[(i + 1) % polygon.size()].fail("is the same point as its neighbour", "each vertex once");
  }
  geometry::correct(outline);
  std::string why;
  if (!geometry::is_valid(outline, why)) {
    const std::size_t at = why.find(" at (");
    value.fail("crosses itself or has no area" +
                   (at == std::string::npos ? "" : why.substr(at, why.find(')', at) + 1 - at)),
               "vertices in order around the vehicle, each once");
  }
  if (geometry::area(outline) < smallest_area_m2) value.fail("has no area", expected);
  return polygon;
}

KeyValue footprint_of(const VehicleConfig& vehicle) {
  KeyList vertices;
  for (const Point& vertex : vehicle.footprint) vertices.push_back(KeyList{vertex.x(), vertex.y()});
  return vertices;
}

/// Checks the source of the vehicle's motion, and claims what the section gives away.
void check_vehicle(const Mapping& yaml, const VehicleConfig& vehicle, ConfigClaims& claims) {
  // The outline is published: Outline in daemon/ros/session.cpp.
  if (!vehicle.footprint.empty()) claims.publishes("footprint", "vehicle.footprint", yaml.where("footprint"));
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
  if (odometry)
    claims.holds_frame(vehicle.base_frame, vehicle.odometry_frame, Pose::Identity(), "vehicle.odometry_frame",
                       yaml.where("odometry_frame"));
}

}  // namespace

Keys vehicle_keys(VehicleConfig& vehicle) {
  using namespace keys;
  return {
      {"base_frame", vehicle.base_frame, frame, "the frame of the vehicle"},
      {"footprint", footprint_of(vehicle),
       [&](const Value& value) { vehicle.footprint = read_footprint(value); }, special("[[x, y], …], m"),
       "polygon in base_frame; returns from inside are left out; published on the topic footprint"},
      {"odometry_frame", vehicle.odometry_frame, frame,
       "poses of base_frame in it come from tf; scans are deskewed by them; empty: none", or_none},
      {"odometry_topic", vehicle.odometry_topic, topic, "or from a nav_msgs/Odometry; empty: none", or_none},
      {"imu_topic", vehicle.imu_topic, topic,
       "or from the turn rates of a sensor_msgs/Imu and a speed ahead; empty: none", or_none},
      {"speed_topic", vehicle.speed_topic, topic, "that speed, a geometry_msgs/TwistStamped", or_none}};
}

void read_vehicle(const Mapping& root, Reading& reading) {
  const auto section = root.find("vehicle");
  if (!section) return;
  VehicleConfig& vehicle = reading.vehicle;
  check_vehicle(read_section(*section, vehicle_keys(vehicle)), vehicle, reading.claims);
}

}  // namespace lidard
