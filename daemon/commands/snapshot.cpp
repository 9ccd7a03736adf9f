// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <ctime>
#include <ostream>
#include <stdexcept>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/inspect_survey.h"
#include "daemon/commands/player.h"
#include "daemon/files/animation.h"
#include "daemon/files/numbered_path.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"
#include "daemon/pipeline/report.h"
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

/// What is played, and what is to be said of it.
struct Scene {
  Config config;
  std::string title;
  std::vector<std::string> notes;
  std::vector<std::string> awaited;  ///< topics; empty: any will do
  std::string why_no_frame;
};

/// A sensor that has no whole frame is shown with what there is of one.
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
  for (const auto& warning : scene.config.warnings) err << warning << '\n';
  scene.title = "What " + file_name(scene.config.file) + " sees";
  return scene;
}

/// The moments that are drawn, in s into the capture.
struct Moments {
  double first;
  double every;
  int count;
  bool patient;  ///< the first one comes when every sensor has given a frame
};

/// Plays up to the last moment and calls `take` at each with the seconds played; the frames that came until
/// then are in the keeper. Frames that the end of play would cut off are no frames, unless they are asked
/// for.
void play(const Moments& moments, const Scene& scene, MergedCapture& capture, BagPoses& motion,
          FrameKeeper& keeper, const std::function<void(double)>& take) {
  Pipeline pipeline(scene.config, motion, keeper);
  ReplayOptions fast;
  fast.rate = 0;
  Player player(fast, capture, pipeline);
  std::optional<Stamp> first;
  double played = 0;
  double due = moments.first;
  int taken = 0;
  const auto waits = [&] {
    const auto& awaited = scene.awaited;
    return moments.patient && taken == 0 &&
           (keeper.empty() || !std::all_of(awaited.begin(), awaited.end(),
                                           [&](const std::string& topic) { return keeper.has(topic); }));
  };
  const auto take_one = [&] {
    const double now = std::max(due, played);
    take(now);
    due = now + moments.every;
    ++taken;
  };
  player.on_time = [&](Stamp stamp) {
    if (!first) first = stamp;
    motion.feed(pipeline, stamp);
    const double into = seconds(stamp - *first);
    while (taken < moments.count && into > due && !waits()) take_one();
    if (taken == moments.count)
      keeper.freeze();
    else
      played = into;
  };
  player.play([&] { return taken == moments.count; });
  if (taken == 0) take_one();
}

std::string nothing_there(const Scene& scene, double at, double length) {
  if (!scene.why_no_frame.empty()) return scene.why_no_frame;
  return "no sensor of the configuration had completed a frame after " + fixed(at, 3) +
         " s of the capture, which is " + fixed(length, 3) +
         " s long; give a later --at, or see `lidard inspect` for what it holds";
}

/// Why a view shows no return at all.
std::string why_empty(const SnapshotView& view) {
  std::string all;
  for (const auto& sentence : view.missing) all += (all.empty() ? "" : "; ") + sentence;
  for (const auto& layer : view.layers) all += (all.empty() ? "" : "; ") + layer.name + " saw nothing";
  return all;
}

CloudColor color_named(const std::string& name) {
  return name == "ring" ? CloudColor::ring : name == "intensity" ? CloudColor::intensity : CloudColor::height;
}

void write_file(const std::string& path, const std::string& bytes) {
  TextFile file(path);
  file.write(bytes);
  file.close();
}

/// Draws one moment, or a series that shares the framing of its first picture.
class Photographer {
 public:
  Photographer(const SnapshotOptions& options, const Scene& scene) : options_(options), scene_(scene) {}

  /// Throws std::runtime_error if nothing can be drawn.
  void run() {
    MergedCapture capture(options_.captures);
    length_ = length_of(capture);
    if (options_.at.value_or(0) > length_)
      throw std::runtime_error("--at " + fixed(*options_.at, 3) + ": the capture is " + fixed(length_, 3) +
                               " s long");
    const bool series = options_.frames > 0;
    motion_ = std::make_unique<BagPoses>(options_.motion, scene_.config.vehicle.odometry_topic);
    const Moments moments{options_.at.value_or(series ? 0 : length_ / 2), options_.every,
                          std::max(1, options_.frames), !options_.at};
    play(moments, scene_, capture, *motion_, frames_, [this](double at) { take(at); });
    if (animation_) animation_->finish();
  }

 private:
  void take(double at) {
    const SnapshotView view = view_at(at);
    if (!options_.output.empty()) {
      const bool png = ends_with(options_.output, ".png");
      const auto numbered = NumberedPath::parse(options_.output);
      write_file(options_.frames > 0 && numbered ? numbered->of(number_) : options_.output,
                 draw_snapshot(view, png ? PictureFormat::png : PictureFormat::svg));
    }
    if (!options_.animation.empty()) {
      if (!animation_) {
        animation_ = make_animation(options_.animation, options_.every);
        page_height_ = page_height(view);
      }
      animation_->add(draw_pixels(view, page_height_));
    }
    ++number_;
  }
  SnapshotView view_at(double at) {
    if (frames_.empty()) throw std::runtime_error(nothing_there(scene_, at, length_));
    const FrameTree poses(scene_.config, *motion_);
    SnapshotView view = make_view(scene_.config, poses, frames_, options_.areas, color_named(options_.color));
    if (std::all_of(view.layers.begin(), view.layers.end(), [](const auto& l) { return l.points.empty(); }))
      throw std::runtime_error("there is nothing to draw: " + why_empty(view));
    // What one sensor calls free says nothing where the others stand in a wrong place.
    if (scene_.awaited.size() > 1) view.wedges.clear(), view.free_note.clear();
    if (!framing_) framing_ = fit_to_points(view);
    view.framing = *framing_;
    view.framing.width = options_.width;
    if (options_.range) view.framing.center = {0, 0}, view.framing.half = {*options_.range, *options_.range};
    view.title = scene_.title;
    view.notes.insert(view.notes.end(), scene_.notes.begin(), scene_.notes.end());
    view.subtitle = to_utc(frames_.newest()) + ", " + fixed(at, 2) + " s into " +
                    file_name(options_.captures.front()) +
                    (options_.captures.size() > 1 ? " and others" : "");
    return view;
  }

  const SnapshotOptions& options_;
  const Scene& scene_;
  double length_ = 0;
  FrameKeeper frames_;
  std::unique_ptr<BagPoses> motion_;
  std::optional<SnapshotView::Framing> framing_;
  std::unique_ptr<Animation> animation_;
  double page_height_ = 0;
  std::uint64_t number_ = 0;
};

/// What is wrong with the output asked for; empty: nothing.
std::string output_mistake(const SnapshotOptions& options) {
  const std::string& out = options.output;
  const std::string& loop = options.animation;
  const bool numbered = NumberedPath::parse(out).has_value();
  if (!out.empty() && !ends_with(out, ".png") && !ends_with(out, ".svg"))
    return "--output: '" + out + "' is neither a .png nor a .svg file";
  if (!loop.empty() && !ends_with(loop, ".gif") && !ends_with(loop, ".webp"))
    return "--animate: '" + loop + "' is neither a .gif nor a .webp file";
  if (options.frames > 0 && !out.empty() && !numbered)
    return "--output: '" + out +
           "' names one file for several frames; expected a pattern, e.g. frame-%03d.png";
  if (options.frames == 0 && numbered)
    return "--output: '" + out + "' is a pattern for several frames; say how many with --frames";
  return {};
}

}  // namespace

int run_snapshot(const SnapshotOptions& options, std::ostream& err) {
  constexpr int usual_loop = 20;
  SnapshotOptions settled = options;
  if (!options.animation.empty() && options.frames == 0) settled.frames = usual_loop;
  const std::string mistake = output_mistake(settled);
  if (!mistake.empty()) {
    err << mistake << '\n';
    return exit_usage;
  }
  return guarded(err, [&] {
    const Scene scene =
        options.config.empty() ? scene_of(options.captures, err) : configured(options.config, err);
    Photographer(settled, scene).run();
    return exit_ok;
  });
}

}  // namespace lidard
