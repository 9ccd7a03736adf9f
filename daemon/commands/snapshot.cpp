// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <stdexcept>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/field_views.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"
#include "daemon/health/report.h"
#include "daemon/offline/player.h"
#include "daemon/offline/remarks.h"
#include "daemon/offline/survey.h"
#include "daemon/ros/in/tf_poses.h"

namespace lidard {
namespace {

std::string to_utc(Stamp stamp) {
  const std::time_t whole = stamp.ns / 1'000'000'000;
  return fmt::format("{:%F %T}.{:03} UTC", fmt::gmtime(whole), stamp.ns / 1'000'000 % 1000);
}

std::string file_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

/// Seconds from the first packet to the last.
double length_of(MergedCapture& capture) {
  Packet packet;
  if (!capture.next(packet)) return 0;
  const Stamp first = packet.arrival;
  Stamp last = first;
  while (capture.next(packet)) last = std::max(last, packet.arrival);
  capture.rewind();
  return seconds(last - first);
}

/// The configuration of the replay, and texts about it.
struct Scene {
  Config config;
  std::string title;
  std::vector<std::string> notes;
  std::vector<std::string> awaited;  ///< topics; empty: any topic
  std::string why_no_frame;
};

/// Shows the incomplete frame of a sensor without complete frames.
void show_incomplete(const FoundSensor& sensor, SensorConfig& config, Scene& scene) {
  config.driver.keep_partial = true;
  const std::string why =
      sensor.name + ": " + why_no_frame(*sensor.model, sensor.counters, sensor.data.last - sensor.data.first);
  scene.why_no_frame += (scene.why_no_frame.empty() ? "" : "\n") + why;
  scene.notes.push_back(why + ". What there is of it is drawn.");
}

/// The sensors of the captures, placed at the origin.
Scene scene_of(const std::vector<std::string>& captures, std::ostream& err) {
  const Survey found = survey_of_sensors(captures, err);
  Scene scene;
  scene.config = parse_config(config_of(found), "the sensors found");
  scene.title = "What " + file_name(captures.front()) + " holds";
  scene.notes.push_back(std::string(found.sensors.size() > 1 ? "All sensors stand" : "The sensor stands") +
                        " at the origin, since no configuration says where it is mounted: `lidard inspect` "
                        "prints one to edit, for -c.");
  for (std::size_t i = 0; i < found.sensors.size(); ++i) {
    SensorConfig& sensor = scene.config.sensors[i];
    for (const auto& warning : found.sensors[i].info.warnings) err << sensor.name << ": " << warning << '\n';
    scene.awaited.push_back(frame_topic(sensor).name);
    if (found.sensors[i].frames == 0) show_incomplete(found.sensors[i], sensor, scene);
  }
  return scene;
}

Scene configured(const std::string& file, std::ostream& err) {
  Scene scene;
  scene.config = load_config(file);
  for (const auto& warning : remarks_on(scene.config)) err << warning << '\n';
  scene.title = "What " + file_name(scene.config.file) + " sees";
  return scene;
}

/// Plays up to `at` (s into the capture), or by default to the first moment after its middle when every
/// sensor has a frame. Returns the seconds played; the keeper has the frames. Frames that the end of play
/// cuts off do not count, unless requested.
double play(std::optional<double> at, double length, const Scene& scene, MergedCapture& capture,
            RecordedMotion& motion, FrameKeeper& keeper) {
  Pipeline pipeline(scene.config, motion, keeper);
  ReplayOptions fast;
  fast.rate = 0;
  Player player(fast, capture, pipeline);
  const double due = at.value_or(length / 2);
  std::optional<Stamp> first;
  double played = 0;
  bool done = false;
  const auto waits = [&] {
    const auto& awaited = scene.awaited;
    return !at &&
           (keeper.empty() || !std::all_of(awaited.begin(), awaited.end(),
                                           [&](const std::string& topic) { return keeper.has(topic); }));
  };
  player.on_time = [&](Stamp stamp) {
    if (!first) first = stamp;
    motion.feed(pipeline, stamp);
    const double into = seconds(stamp - *first);
    done = done || (into > due && !waits());
    if (done)
      keeper.freeze();
    else
      played = into;
  };
  player.play([&] { return done; });
  return std::max(due, played);
}

std::string nothing_there(const Scene& scene, const std::vector<std::string>& captures, double at,
                          double length) {
  if (!scene.why_no_frame.empty()) return scene.why_no_frame;
  const auto& sensors = scene.config.sensors;
  for (const FoundSensor& found : survey(captures).sensors) {
    if (std::none_of(sensors.begin(), sensors.end(),
                     [&](const auto& one) { return one.model == found.model; }))
      return "the packets are of " + std::string(found.model->name) + " " + found.data.to_string() +
             ", which is no sensor of the configuration; correct its model, ip_address or ip_port";
  }
  return "no sensor of the configuration had completed a frame after " + fixed(at, 3) +
         " s of the capture, which is " + fixed(length, 3) +
         " s long; give a later --at, or see `lidard inspect` for what it holds";
}

/// Why a view shows no return.
std::string why_empty(const SnapshotView& view) {
  std::string all;
  for (const auto& sentence : view.missing) all += (all.empty() ? "" : "; ") + sentence;
  for (const auto& layer : view.layers) all += (all.empty() ? "" : "; ") + layer.name + " saw nothing";
  return all;
}

/// The view at one moment. Throws std::runtime_error if nothing can be drawn.
SnapshotView view_of(const SnapshotOptions& options, const Scene& scene) {
  MergedCapture capture(options.captures);
  const double length = length_of(capture);
  if (options.at.value_or(0) > length)
    throw std::runtime_error("--at " + fixed(*options.at, 3) + ": the capture is " + fixed(length, 3) +
                             " s long");
  const auto motion = open_motion(options.motion, scene.config.vehicle);
  FrameKeeper frames;
  const double at = play(options.at, length, scene, capture, *motion, frames);
  if (frames.empty()) throw std::runtime_error(nothing_there(scene, options.captures, at, length));
  const FrameTree poses(scene.config.vehicle.base_frame, fixed_poses(scene.config), *motion);
  const bool intensities = options.color == "intensity";
  SnapshotView view = make_view(scene.config, poses, frames, {options.areas, options.only, intensities});
  if (std::all_of(view.layers.begin(), view.layers.end(), [](const auto& l) { return l.points.empty(); }))
    throw std::runtime_error("there is nothing to draw: " + why_empty(view));
  // The free area of one sensor is meaningless while the other sensors have no poses.
  if (scene.awaited.size() > 1) view.wedges.clear(), view.free_note.clear();
  view.framing = fit_to_points(view);
  view.framing.width = options.width;
  if (options.range) view.framing.center = {0, 0}, view.framing.half = {*options.range, *options.range};
  fit_colors(view, intensities);
  view.title = scene.title;
  view.notes.insert(view.notes.end(), scene.notes.begin(), scene.notes.end());
  view.subtitle = to_utc(frames.newest()) + ", " + fixed(at, 2) + " s into " +
                  file_name(options.captures.front()) + (options.captures.size() > 1 ? " and others" : "");
  return view;
}

}  // namespace

int run_snapshot(const SnapshotOptions& options, std::ostream& err) {
  const auto format = picture_format(options.output);
  if (!format) {
    err << "--output: '" << options.output << "' is neither a .png nor a .svg file\n";
    return exit_usage;
  }
  if (options.captures.empty() && options.config.empty()) {
    err << "lidard snapshot: a capture is required, or a configuration (-c)\n";
    return exit_usage;
  }
  if (options.captures.empty() && options.color != "height") {
    err << "--color " << options.color << ": a capture is required, since a field of view has no returns\n";
    return exit_usage;
  }
  return guarded(err, [&] {
    const Scene scene =
        options.config.empty() ? scene_of(options.captures, err) : configured(options.config, err);
    const std::string picture =
        draw_snapshot(options.captures.empty() ? views_of_field(options, scene.config)
                                               : std::vector<SnapshotView>{view_of(options, scene)},
                      *format);
    TextFile file(options.output);
    file.write(picture);
    file.close();
    return exit_ok;
  });
}

}  // namespace lidard
