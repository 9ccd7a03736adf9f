// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <ctime>
#include <ostream>
#include <stdexcept>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/player.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {
namespace {

std::string fixed(double value, int digits) { return printed("%.*f", digits, value); }

std::string to_utc(Stamp stamp) {
  const std::time_t whole = static_cast<std::time_t>(stamp.ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&whole, &utc);
  char date[32];
  std::strftime(date, sizeof date, "%F %T", &utc);
  return date + printed(".%03d UTC", static_cast<int>(stamp.ns / 1'000'000 % 1000));
}

std::string file_name(const std::string& path) { return path.substr(path.rfind('/') + 1); }

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

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

/// Plays up to `at`, or on to the first frame if `patient`, and keeps what came until then; returns the
/// seconds played. Frames that the end of play would cut off are no frames.
double play_until(double at, bool patient, const Config& config, MergedCapture& capture, BagPoses& motion,
                  FrameKeeper& keeper) {
  Pipeline pipeline(config, motion, keeper);
  ReplayOptions fast;
  fast.rate = 0;
  Player player(fast, capture, pipeline);
  std::optional<Stamp> first;
  double played = 0;
  bool done = false;
  player.on_time = [&](Stamp stamp) {
    if (!first) first = stamp;
    motion.feed(pipeline, stamp);
    const double into = seconds(stamp - *first);
    done = done || (into > at && !(patient && keeper.empty()));
    if (done)
      keeper.freeze();
    else
      played = into;
  };
  player.play([&] { return done; });
  return std::max(at, played);
}

std::string nothing_there(double at, double length) {
  return "no sensor of the configuration had completed a frame after " + fixed(at, 3) +
         " s of the capture, which is " + fixed(length, 3) +
         " s long; give a later --at, or see `lidard inspect` for what it holds";
}

std::string picture(const SnapshotOptions& options, const Config& config, PictureFormat format) {
  MergedCapture capture(options.captures);
  const double length = length_of(capture);
  if (options.at.value_or(0) > length)
    throw std::runtime_error("--at " + fixed(*options.at, 3) + ": the capture is " + fixed(length, 3) +
                             " s long");
  FrameKeeper frames;
  BagPoses motion(options.motion, config.vehicle.odometry_topic);
  const double at = play_until(options.at.value_or(length / 2), !options.at, config, capture, motion, frames);
  if (frames.empty()) throw std::runtime_error(nothing_there(at, length));
  const FrameTree poses(config, motion);
  SnapshotView view = make_view(config, poses, frames, options.areas);
  fit_to_points(view);
  if (options.range) view.center = {0, 0}, view.half = {*options.range, *options.range};
  view.title = "What " + file_name(config.file) + " sees";
  view.subtitle = to_utc(frames.newest()) + ", " + fixed(at, 2) + " s into " +
                  file_name(options.captures.front()) + (options.captures.size() > 1 ? " and others" : "");
  return draw_snapshot(view, format);
}

}  // namespace

int run_snapshot(const SnapshotOptions& options, std::ostream& err) {
  const bool png = ends_with(options.output, ".png");
  if (!png && !ends_with(options.output, ".svg")) {
    err << "--output: '" << options.output << "' is neither a .png nor a .svg file\n";
    return exit_usage;
  }
  return guarded(err, [&] {
    const Config config = load_config(options.config);
    for (const auto& warning : config.warnings) err << warning << '\n';
    const std::string bytes = picture(options, config, png ? PictureFormat::png : PictureFormat::svg);
    TextFile file(options.output);
    file.write(bytes);
    file.close();
    return exit_ok;
  });
}

}  // namespace lidard
