// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "core/base/device_clock.h"
#include "core/base/time.h"
#include "daemon/config/config.h"
#include "daemon/files/frame_writer.h"
#include "daemon/offline/choice.h"
#include "daemon/offline/player.h"
#include "daemon/ros/master/environment.h"
#include "drivers/address.h"

namespace lidard {

/// Exit codes of every command.
constexpr int exit_ok = 0;
constexpr int exit_failed = 1;
constexpr int exit_usage = 2;
constexpr int exit_config = 78;  ///< EX_CONFIG of sysexits.h

/// Runs a command; reports exceptions to `err` and returns the exit code.
template <class Command>
int guarded(std::ostream& err, const Command& command) {
  const auto fail = [&err](const std::exception& why, int code) { return err << why.what() << '\n', code; };
  try {
    return command();
  } catch (const ConfigError& why) {
    return fail(why, exit_config);
  } catch (const RosError& why) {
    return fail(why, exit_usage);
  } catch (const UsageError& why) {
    return fail(why, exit_usage);
  } catch (const std::exception& why) {
    return fail(why, exit_failed);
  }
}

// A command returns its exit code and prints its result to `out`, messages and errors to `err`.

/// `lidard check`: prints the configuration with every default filled in, and what its scans can know.
int run_check(const std::string& file, std::ostream& out, std::ostream& err);
/// `lidard check --ports`: prints the sockets that the daemon opens, for firewalls.
int run_check_ports(const std::string& file, std::ostream& out, std::ostream& err);

/// Options of `lidard decode`.
struct DecodeOptions : CaptureChoice {
  std::string capture;
  std::string format = "csv";  ///< csv, json or pcd
  std::string output = "-";
  std::optional<std::uint64_t> frame;  ///< only this frame
  ClockMode clock = ClockMode::arrival;
  StampColumn stamps = StampColumn::host;
};

/// Decodes one sensor's frames. After a failure the output contains the frames decoded so far.
int run_decode(const DecodeOptions& options, std::ostream& err);

/// `lidard inspect`: reports the sensors in the captures and the quality of the recording. The text output is
/// a configuration that replays the captures, with the report as comments; or JSON. Fails if a capture could
/// not be read to its end.
int run_inspect(const std::vector<std::string>& captures, bool json, std::ostream& out, std::ostream& err);

/// Format of the reference of all configuration keys: for a terminal, config/KEYS.md, the manual page, or
/// programs.
enum class KeysFormat { table, markdown, man, json };

int run_keys(KeysFormat format, std::ostream& out);

/// `lidard models`: the table of supported models and how each was verified, for people or as JSON.
int run_models(bool json, std::ostream& out);

/// Options of `lidard record`.
struct RecordOptions {
  std::string config;  ///< empty: traffic of all supported lidars at their usual ports
  std::string output;
  std::string interface = "any";  ///< of the host
  double duration = 0;            ///< s; 0: until a signal
};

/// The filter (pcap-filter(7)) for the traffic of the configured sensors: all traffic of a known address,
/// else packets to the sensor's ports. Empty: no sensor is on the network.
std::string capture_filter(const Config& config);

/// Records the configured sensors' traffic (UDP and both directions of TCP) without disturbing receivers.
int run_record(const RecordOptions& options, std::ostream& err);

/// Options of `lidard replay`.
struct ReplayOptions : PlayOptions {
  std::string config;                  ///< empty: the sensors that are found in the captures
  std::vector<std::string> captures;   ///< and bags
  std::vector<std::string> bags = {};  ///< taken out of the captures
  double wait = 0;                     ///< s between advertising the topics and the first frame
  RosOptions ros;
  std::string bag;     ///< output file instead of ROS
  std::string motion;  ///< a bag with the vehicle's motion (tf or odometry); empty: see `bags`, or live
};

/// Plays captures through the pipeline of a configuration into ROS or a bag, and prints a table at the end.
int run_replay(const ReplayOptions& options, std::ostream& out, std::ostream& err);
/// The same with a given configuration; `options.config` is ignored.
int run_replay(const ReplayOptions& options, const Config& config, std::ostream& out, std::ostream& err);

/// The daemon: receives the configured sensors and publishes until SIGTERM or SIGINT. `trouble`: why `config`
/// is not the content of its file; empty: it is.
int run_daemon(const Config& config, RosOptions ros, std::ostream& err, const std::string& trouble = {});
/// Runs the daemon with the configuration file.
int run_daemon(const std::string& config_file, const std::vector<std::string>& ros_arguments,
               std::ostream& err);

/// Options of `lidard snapshot`.
struct SnapshotOptions {
  std::string config;  ///< empty: the sensors that are found in the captures, all at the origin
  std::vector<std::string> captures;
  std::optional<double> at;       ///< s into the capture; unset: its middle
  std::optional<double> range;    ///< m from base_frame to the picture's edge; unset: fits the returns
  std::string areas;              ///< topic whose free and unobserved areas are shaded; empty: see ViewChoice
  std::vector<std::string> only;  ///< topics drawn; empty: all
  std::string color = "height";   ///< or "intensity": what the colours of returns mean
  std::string motion;             ///< a bag with the vehicle's motion (tf or odometry); empty: it stood
  int width = 0;                  ///< pixels of the picture; 0: automatic
  std::string output;             ///< .png or .svg
};

/// Plays captures through the pipeline of a configuration up to one moment and draws the frames from above;
/// without captures draws what the configuration's scans can see.
int run_snapshot(const SnapshotOptions& options, std::ostream& err);

/// Options of `lidard calibrate`.
struct CalibrateOptions {
  std::string config;
  std::vector<std::string> captures;  ///< while the vehicle is parked, or drives
  std::string bag;                    ///< with the topics of other drivers; empty: none
  std::string motion;                 ///< bag or table with the odometry; empty: it is parked
  std::string reference;              ///< sensor whose pose stays; empty: the first one
  std::string output;                 ///< configuration with the new poses; empty: none
  std::string picture;                ///< .png or .svg; empty: none
  bool json = false;
};

/// Finds the poses of the sensors from the surfaces that several of them see, and with odometry where they
/// are on the vehicle and how late their stamps are. Fails if nothing was determined.
int run_calibrate(const CalibrateOptions& options, std::ostream& out, std::ostream& err);

}  // namespace lidard
