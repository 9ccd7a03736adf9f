// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/scene_file.h"

#include <fstream>
#include <sstream>

namespace lidard::sim {
namespace {

double reflectivity(const YamlReader& yaml) { return yaml.not_negative("reflectivity", 0.5); }

// [low, high] in m.
std::pair<double, double> heights(const YamlReader& yaml) {
  const Eigen::Vector2d z = yaml.vector2();
  if (z.x() >= z.y()) yaml.fail("expected two heights, the lower one first");
  return {z.x(), z.y()};
}

std::vector<Waypoint> parse_waypoints(const YamlReader& yaml, double yaw) {
  std::vector<Waypoint> waypoints;
  for (std::size_t i = 0; i < yaml.list(); ++i) {
    const YamlReader point = yaml.at(i);
    point.allow({"at", "center", "yaw_deg"});
    waypoints.push_back({point.at("at").number(), point.at("center").vector3(),
                         point.has("yaw_deg") ? point.at("yaw_deg").number() * rad_per_deg : yaw});
    if (i > 0 && waypoints[i].time <= waypoints[i - 1].time)
      point.fail("the times must ascend; sort the waypoints");
  }
  if (waypoints.empty()) yaml.fail("expected at least one waypoint");
  return waypoints;
}

// A constant velocity is a line through two waypoints far apart.
std::vector<Waypoint> steady(const Waypoint& now, const Eigen::Vector3d& velocity, double yaw_rate) {
  constexpr double long_time = 3600;
  const Eigen::Vector3d way = velocity * long_time;
  const double turn = yaw_rate * long_time;
  return {{-long_time, now.position - way, now.yaw - turn}, {long_time, now.position + way, now.yaw + turn}};
}

void place(const YamlReader& yaml, Object& object) {
  const Eigen::Vector3d rpy = yaml.has("rpy_deg")
                                  ? Eigen::Vector3d(yaml.at("rpy_deg").vector3() * rad_per_deg)
                                  : Eigen::Vector3d(0, 0, yaml.number("yaw_deg", 0) * rad_per_deg);
  if (yaml.has("waypoints")) {
    object.waypoints = parse_waypoints(yaml.at("waypoints"), rpy.z());
    object.pose = make_pose({0, 0, 0}, {rpy.x(), rpy.y(), 0});
    return;
  }
  const Eigen::Vector3d center = yaml.at("center").vector3();
  if (yaml.has("velocity") || yaml.has("yaw_rate_deg")) {
    const Eigen::Vector3d velocity =
        yaml.has("velocity") ? yaml.at("velocity").vector3() : Eigen::Vector3d(0, 0, 0);
    object.waypoints = steady({0, center, rpy.z()}, velocity, yaml.number("yaw_rate_deg", 0) * rad_per_deg);
    object.pose = make_pose({0, 0, 0}, {rpy.x(), rpy.y(), 0});
    return;
  }
  object.pose = make_pose(center, rpy);
}

Object parse_wall(const YamlReader& yaml) {
  yaml.allow({"from", "to", "z", "reflectivity"});
  const auto z = heights(yaml.at("z"));
  Object object;
  object.shape = Wall{yaml.at("from").vector2(), yaml.at("to").vector2(), z.first, z.second};
  object.reflectivity = reflectivity(yaml);
  return object;
}

Object parse_box(const YamlReader& yaml) {
  yaml.allow(
      {"center", "size", "yaw_deg", "rpy_deg", "velocity", "yaw_rate_deg", "waypoints", "reflectivity"});
  Object object;
  const Eigen::Vector3d size = yaml.at("size").vector3();
  if (size.minCoeff() <= 0) yaml.at("size").fail("every edge must be longer than 0");
  object.shape = Box{size};
  object.reflectivity = reflectivity(yaml);
  place(yaml, object);
  return object;
}

Object parse_cylinder(const YamlReader& yaml) {
  yaml.allow({"center", "radius", "height", "velocity", "waypoints", "reflectivity"});
  Object object;
  object.shape = Cylinder{yaml.positive("radius"), yaml.positive("height")};
  object.reflectivity = reflectivity(yaml);
  place(yaml, object);
  return object;
}

Object parse_object(const YamlReader& yaml) {
  yaml.allow({"wall", "box", "cylinder"});
  if (yaml.has("wall")) return parse_wall(yaml.at("wall"));
  if (yaml.has("box")) return parse_box(yaml.at("box"));
  return parse_cylinder(yaml.at("cylinder"));
}

std::vector<Object> parse_objects(const YamlReader& yaml) {
  std::vector<Object> objects;
  for (std::size_t i = 0; i < yaml.list(); ++i) objects.push_back(parse_object(yaml.at(i)));
  return objects;
}

Trajectory parse_trajectory(const YamlReader& yaml) {
  Pose2 start;
  if (yaml.has("start")) {
    yaml.at("start").allow({"xy", "yaw_deg"});
    const Eigen::Vector2d xy = yaml.at("start").at("xy").vector2();
    start = {xy.x(), xy.y(), yaml.at("start").number("yaw_deg", 0) * rad_per_deg};
  }
  std::vector<Twist> twists;
  const std::size_t legs = yaml.has("path") ? yaml.at("path").list() : 0;
  for (std::size_t i = 0; i < legs; ++i) {
    const YamlReader leg = yaml.at("path").at(i);
    leg.allow({"duration", "speed", "yaw_rate_deg"});
    twists.push_back(
        {leg.positive("duration"), leg.at("speed").number(), leg.number("yaw_rate_deg", 0) * rad_per_deg});
  }
  return {start, twists};
}

OdometrySettings parse_odometry(const YamlReader& yaml) {
  yaml.allow({"rate", "scale", "turn_scale", "noise", "turn_noise_deg"});
  OdometrySettings odometry;
  odometry.rate = yaml.positive("rate", odometry.rate);
  odometry.scale = yaml.positive("scale", 1), odometry.turn_scale = yaml.positive("turn_scale", 1);
  odometry.way_noise = yaml.not_negative("noise", 0);
  odometry.turn_noise = yaml.not_negative("turn_noise_deg", 0) * rad_per_deg;
  return odometry;
}

void parse_vehicle(const YamlReader& yaml, Scene& scene) {
  yaml.allow({"start", "path", "body", "odometry"});
  if (yaml.has("odometry")) scene.odometry = parse_odometry(yaml.at("odometry"));
  scene.trajectory = parse_trajectory(yaml);
  if (yaml.has("body")) scene.body = parse_objects(yaml.at("body"));
}

Scene parse_root(const YamlReader& yaml) {
  yaml.allow({"start", "duration", "seed", "ground", "vehicle", "sensors", "objects"});
  Scene scene;
  scene.start = yaml.at("start").stamp();
  scene.duration = span_from_seconds(yaml.positive("duration"));
  if (yaml.has("seed")) scene.seed = static_cast<std::uint64_t>(yaml.at("seed").integer());
  if (yaml.has("ground")) {
    const YamlReader ground = yaml.at("ground");
    ground.allow({"z", "reflectivity"});
    scene.ground = GroundCover{{ground.number("z", 0)}, reflectivity(ground)};
  }
  if (yaml.has("vehicle")) parse_vehicle(yaml.at("vehicle"), scene);
  if (yaml.has("objects")) scene.objects = parse_objects(yaml.at("objects"));
  const YamlReader sensors = yaml.at("sensors");
  if (!sensors.node().IsMap() || sensors.node().size() == 0)
    sensors.fail("expected a map of at least one sensor");
  for (const auto& entry : sensors.node()) {
    scene.sensors.push_back(
        parse_sensor(YamlReader(yaml.file(), entry.first).text(), YamlReader(yaml.file(), entry.second)));
  }
  return scene;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::string& name) {
  try {
    return parse_root(YamlReader(name, YAML::Load(text)));
  } catch (const YAML::Exception& error) {
    throw SceneError(name + ":" + std::to_string(error.mark.line + 1) + ":" +
                     std::to_string(error.mark.column + 1) + ": " + error.msg + "; expected YAML");
  }
}

Scene load_scene(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf()))
    throw SceneError(path + ": cannot be read; name an existing scene file");
  return parse_scene(text.str(), path);
}

}  // namespace lidard::sim
