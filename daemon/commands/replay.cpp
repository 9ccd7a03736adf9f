// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/replay.h"

#include <csignal>
#include <memory>
#include <ostream>
#include <thread>

#include "daemon/commands/player.h"
#include "daemon/config/exit_codes.h"
#include "daemon/config/output_topics.h"
#include "daemon/pipeline/report.h"
#include "daemon/pipeline/transform_source.h"
#include "daemon/ros/bag_poses.h"
#include "daemon/ros/bag_sink.h"
#include "daemon/ros/ros_link.h"
#include "daemon/ros/tf_poses.h"

namespace lidard {
namespace {

volatile std::sig_atomic_t stop_signal = 0;

bool stopped() { return stop_signal != 0; }

void stop_on_signals() {
  stop_signal = 0;
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int number) { stop_signal = number; });
}

/// The parts that a replay needs whatever it writes to.
struct Replay {
  const ReplayOptions& options;
  const Config& config;
  MergedCapture& capture;
  std::ostream& out;
  std::ostream& err;

  /// `motion` is called before each packet, for poses that come by message. False if an output never came.
  bool play(FrameSink& sink, TransformSource& poses, std::function<void(Stamp)> on_time,
            const std::function<void(Pipeline&, Stamp)>& motion = nullptr) {
    Pipeline pipeline(config, poses, sink);
    Player player(options, capture, pipeline);
    bool first = true;
    player.on_time = [&, on_time = std::move(on_time)](Stamp stamp) {
      if (first) sink.transforms(pipeline.static_transforms(), stamp);
      first = false;
      if (motion) motion(pipeline, stamp);
      if (on_time) on_time(stamp);
    };
    player.play(stopped);
    report(pipeline, player);
    const auto outputs = pipeline.output_report();
    print_outputs("output", outputs, out);
    // Who stops a replay early knows that not everything has come.
    return stopped() || all_came(outputs);
  }

  void report(const Pipeline& pipeline, const Player& player) const {
    const auto sensors = pipeline.report();
    print_table(sensors, out);
    print_verdicts(config, sensors, out);
    print_capture_counters(capture.counters(), 0, out);
    if (player.skipped() > 0) out << "  " << player.skipped() << " datagrams before --start not played\n";
    for (const auto& sender : pipeline.unclaimed_senders())
      out << "  no sensor is configured for " << sender << '\n';
    for (const auto& sensor : sensors) {
      for (const auto& warning : sensor.info.warnings) err << sensor.name << ": " << warning << '\n';
    }
  }

  void wait_for_subscribers() const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.wait);
    while (!stopped() && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  int into_bag() {
    BagSink sink(options.bag);
    bool complete = false;
    if (options.motion.empty()) {
      NoTransforms poses;
      complete = play(sink, poses, nullptr);
    } else {
      BagPoses poses(options.motion, config.vehicle.odometry_topic);
      complete = play(sink, poses, nullptr, [&poses](Pipeline& pipeline, Stamp now) {
        poses.odometry_until(now, [&](Stamp stamp, const Pose& pose, const std::string& child) {
          pipeline.pose_message(stamp, pose, child, stamp);
        });
      });
    }
    sink.close();
    return complete ? exit_ok : exit_failed;
  }

  int into_ros() {
    stop_on_signals();
    if (!config.vehicle.odometry_topic.empty() || !config.vehicle.imu_topic.empty())
      err << "a replay to ROS listens to no odometry_topic and no imu_topic, so scans are not deskewed; use "
             "odometry_frame (tf), or --bag with --motion\n";
    RosOptions ros;
    ros.node_name = options.node_name;
    ros.remappings = options.ros_arguments;
    ros.topics = output_topics(config);
    ros.backpressure = Backpressure::block;
    ros.clock = options.clock;
    RosLink link(ros);
    const auto poses = std::make_shared<TfPoses>();
    link.add_client(poses);
    // roscpp installs handlers of its own when it starts; ours must come last.
    link.start();
    constexpr Span master_patience = std::chrono::seconds(5);
    if (!link.wait_for_master(master_patience)) {
      const std::string conflict = link.conflict();
      if (!conflict.empty())
        err << conflict << '\n';
      else
        err << "no ROS master answers at " << choose_master(options.ros_arguments)
            << "; start one (roscore), set ROS_MASTER_URI, or write a bag with --bag\n";
      link.stop();
      return exit_failed;
    }
    stop_on_signals();
    wait_for_subscribers();
    const auto clock =
        options.clock ? [&link](Stamp stamp) { link.publish_clock(stamp); } : std::function<void(Stamp)>();
    const bool complete = play(link, *poses, clock);
    constexpr Span flush_patience = std::chrono::seconds(5);
    const bool flushed = link.flush(flush_patience);
    if (!flushed) err << "some frames were not taken by their subscribers within 5 s\n";
    const int code = flushed && complete ? exit_ok : exit_failed;
    if (!link.stop()) std::quick_exit(code);
    return code;
  }
};

}  // namespace

int run_replay(const ReplayOptions& options, std::ostream& out, std::ostream& err) {
  try {
    return run_replay(options, load_config(options.config), out, err);
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  }
}

int run_replay(const ReplayOptions& options, const Config& config, std::ostream& out, std::ostream& err) {
  try {
    for (const auto& warning : config.warnings) err << warning << '\n';
    MergedCapture capture(options.captures);
    stop_on_signals();
    Replay replay{options, config, capture, out, err};
    const int code = options.bag.empty() ? replay.into_ros() : replay.into_bag();
    for (const auto& error : capture.errors()) err << error << '\n';
    return capture.is_damaged() ? exit_failed : code;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  } catch (const std::exception& e) {
    err << e.what() << '\n';
    return exit_failed;
  }
}

}  // namespace lidard
