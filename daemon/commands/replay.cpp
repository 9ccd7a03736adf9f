// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <thread>
#include <utility>

#include "daemon/commands/commands.h"
#include "daemon/commands/stop_signal.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/health/report.h"
#include "daemon/offline/player.h"
#include "daemon/offline/remarks.h"
#include "daemon/offline/survey.h"
#include "daemon/ros/in/bag_topics.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/out/bag_sink.h"
#include "daemon/ros/session.h"

namespace lidard {
namespace {

/// A replay of captures through a pipeline to a sink.
struct Replay {
  Replay(const ReplayOptions& how, const Config& what, MergedCapture& from, DiagnosticSink& to,
         TransformSource& poses)
      : capture(from),
        topics(how.bags.empty() ? nullptr : std::make_unique<BagTopics>(how.bags, what)),
        alone(how.captures.empty()),
        sink(to),
        pipeline(what, poses, sink),
        player(how, capture, pipeline) {}

  MergedCapture& capture;
  const std::unique_ptr<BagTopics> topics;
  const bool alone;  // no captures beside the bags
  DiagnosticSink& sink;
  Pipeline pipeline;
  HealthReporter reporter{pipeline, sink};
  Player player;

  /// Plays and prints the outputs; `on_time` is called before every packet. False if an output never came, or
  /// a bag is damaged.
  bool play(const std::function<void(Stamp)>& on_time, std::ostream& out, std::ostream& err) {
    bool first = true;
    player.on_time = [&](Stamp stamp) {
      if (first) sink.transforms(pipeline.static_transforms(), stamp);
      first = false;
      on_time(stamp);
      if (topics && !alone) topics->feed(&pipeline, stamp);
    };
    if (topics && alone)
      player.play(*topics, stopped);
    else
      player.play(stopped);
    if (const std::string why = player.why_nothing(); !why.empty()) throw std::runtime_error(why);
    report(out, err);
    const bool is_damaged = topics && !topics->damage().empty();
    if (is_damaged) err << topics->damage() << "; the messages up to there were played\n";
    const auto outputs = topic_totals(pipeline);
    print_outputs("output", outputs, out);
    // A replay that was stopped early may lack outputs.
    return !is_damaged && (stopped() || all_came(outputs));
  }

  void report(std::ostream& out, std::ostream& err) const {
    const auto sensors = pipeline.status(pipeline.now()).sensors;
    print_table(sensors, out);
    print_verdicts(sensors, out);
    print_capture_counters(capture.counters(), 0, out);
    if (topics) {
      for (const SourceReport& topic : topics->report()) {
        out << "  " << topic.topic << ": " << topic.messages << " messages for " << topic.sensor;
        if (topic.rejected > 0) out << ", " << topic.rejected << " of no use: " << topic.last_reason;
        if (topic.points_dropped > 0) out << ", " << topic.points_dropped << " points not finite";
        if (topic.intensities_ignored > 0)
          out << ", intensities of " << topic.intensities_ignored << " left out";
        out << '\n';
      }
    }
    if (player.skipped() > 0) out << "  " << player.skipped() << " datagrams before --start not played\n";
    for (const auto& sender : pipeline.unclaimed_senders())
      out << "  no sensor is configured for " << sender << '\n';
    for (const auto& sensor : sensors) {
      for (const std::string& warning : sensor.info.warnings)
        if (warning != sensor.info.from_configuration) err << sensor.name << ": " << warning << '\n';
    }
  }
};

/// The file that has the vehicle's motion; empty: none.
const std::string& motion_of(const ReplayOptions& options) {
  return options.motion.empty() && !options.bags.empty() ? options.bags.front() : options.motion;
}

int into_bag(const ReplayOptions& options, const Config& config, MergedCapture& capture, std::ostream& out,
             std::ostream& err) {
  if (std::filesystem::is_regular_file(options.bag))
    throw std::runtime_error(options.bag + " is there already; remove it, or name another file");
  BagSink sink(options.bag);
  const auto motion = open_motion(motion_of(options), config.vehicle);
  Replay replay(options, config, capture, sink, *motion);
  bool first = true;
  const auto on_time = [&](Stamp now) {
    if (std::exchange(first, false)) sink.outline(config.vehicle, now);
    motion->feed(replay.pipeline, now);
  };
  const bool complete = replay.play(on_time, out, err);
  sink.close();
  return complete ? exit_ok : exit_failed;
}

void wait_for_subscribers(double limit) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit);
  while (!stopped() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

std::string why_not_connected(const RosSession& session, const RosOptions& ros) {
  const std::string conflict = session.conflict();
  return !conflict.empty() ? conflict
                           : "no ROS master answers at " + choose_master(ros.remappings) +
                                 "; start one (roscore), set ROS_MASTER_URI, or write a bag with --bag";
}

int into_ros(const ReplayOptions& options, const Config& config, MergedCapture& capture, std::ostream& out,
             std::ostream& err) {
  RosOptions ros = options.ros;
  ros.backpressure = Backpressure::block;
  boost::asio::io_context messages;  // for the thread of the pipeline (this one)
  const auto more_may_come = boost::asio::make_work_guard(messages);
  RosSession session(config, ros);
  // What was recorded, recorded poses belong to; live ones are of another time.
  std::unique_ptr<RecordedMotion> recorded;
  if (!motion_of(options).empty()) recorded = open_motion(motion_of(options), config.vehicle);
  Replay replay(options, config, capture, session.sink(),
                recorded ? static_cast<TransformSource&>(*recorded) : session.poses());
  session.feed(config, [&](const std::string&, auto task) {
    boost::asio::post(messages,
                      [&replay, task = std::move(task)] { task(replay.pipeline, replay.player.now()); });
  });
  replay.player.rest = [&messages](auto until) {
    messages.poll();
    messages.run_one_until(until);
  };
  session.start();
  constexpr Span patience = std::chrono::seconds(5);
  if (!session.wait_for_master(patience)) {
    err << why_not_connected(session, ros) << '\n';
    if (!session.stop()) std::quick_exit(exit_failed);
    return exit_failed;
  }
  // roscpp installs signal handlers when it starts, so these are installed after it.
  stop_on_signals();
  wait_for_subscribers(options.wait);
  const auto clock = [&](Stamp now) {
    if (ros.clock) session.publisher().publish_clock(now);
    if (recorded) recorded->feed(replay.pipeline, now, replay.player.shift());
  };
  const bool complete = replay.play(clock, out, err);
  const bool flushed = session.flush(patience);
  if (!flushed) err << "some frames were not taken by their subscribers within 5 s\n";
  const int code = flushed && complete ? exit_ok : exit_failed;
  out.flush();  // std::quick_exit() does not flush
  if (!session.stop()) std::quick_exit(code);
  return code;
}

}  // namespace

int run_replay(const ReplayOptions& given, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    ReplayOptions options = given;
    options.bags = split_bags(options.captures);
    if (!options.config.empty()) return run_replay(options, load_config(options.config), out, err);
    const std::string found = options.captures.empty() ? config_of_bags(options.bags)
                                                       : config_of(survey_of_sensors(options.captures, err));
    return run_replay(options, parse_config(found, "the sensors found"), out, err);
  });
}

int run_replay(const ReplayOptions& options, const Config& config, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    if (!options.bags.empty() && (options.loop || options.restamp))
      throw std::runtime_error("--loop and --restamp are for captures; play " + options.bags.front() +
                               " with `rosbag play --loop`");
    for (const auto& warning : remarks_on(config)) err << warning << '\n';
    MergedCapture capture(options.captures);
    stop_on_signals();
    const auto play = options.bag.empty() ? into_ros : into_bag;
    const int code = play(options, config, capture, out, err);
    for (const auto& error : capture.errors()) err << error << '\n';
    return capture.is_damaged() ? exit_failed : code;
  });
}

}  // namespace lidard
