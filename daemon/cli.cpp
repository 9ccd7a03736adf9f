// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/cli.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <deque>
#include <filesystem>
#include <functional>
#include <iostream>

#include "core/base/nearest.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/discover.h"
#include "daemon/commands/status.h"
#include "daemon/dropin/dropin.h"
#include "daemon/dropin/import.h"
#include "daemon/live/service.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

constexpr const char* default_config = "/etc/lidard/lidard.yaml";
constexpr const char* capture_help = "pcap or pcapng, also packed (gzip, zstd); - is standard input";

/// IP[:PORT], IPv4 only.
std::optional<Endpoint> read_endpoint(const std::string& text, std::uint16_t port) {
  const std::size_t colon = text.find(':');
  const auto address = IpAddress::parse(text.substr(0, colon));
  if (!address || address->v6) return std::nullopt;
  if (colon != std::string::npos && !CLI::detail::lexical_cast(text.substr(colon + 1), port))
    return std::nullopt;
  return Endpoint{*address, port};
}

/// The commands; each fills in what to do once the line was read.
struct Commands {
  CLI::App app{
      "Lidar daemon: SICK, Hokuyo and Velodyne packets in, merged and virtual LaserScans on ROS topics out.",
      "lidard"};
  std::function<int()> action;
  std::vector<std::string> ros_arguments;

  std::string config = default_config;
  std::vector<std::string> captures;
  bool json = false, ports = false;
  KeysFormat keys = KeysFormat::table;
  std::string rate = "1";
  std::string source;
  std::string clock = "arrival";
  std::string time = "host";
  ReplayOptions replay;
  DecodeOptions decode;
  DiscoverOptions discover;
  std::deque<std::pair<const Discovery*, std::vector<std::string>>> asked;  ///< the addresses for `discover`
  RecordOptions record;
  SnapshotOptions snapshot;
  StatusOptions ask;
  ImportOptions import;
  CalibrateOptions calibrate;

  Commands() {
    app.set_version_flag("--version", "lidard " LIDARD_VERSION);
    app.require_subcommand(1);
    app.footer("Exit codes: 0 ok, 1 failed, 2 usage, 78 configuration. See lidard(8).");
    add_run();
    add_replay();
    add_decode();
    add_inspect();
    add_check();
    add_models();
    add_keys();
    add_discover();
    add_record();
    add_snapshot();
    add_status();
    add_import();
    add_calibrate();
  }

 private:
  static CLI::Option* add_captures(CLI::App* c, std::vector<std::string>& captures) {
    return c
        ->add_option("captures,--pcap", captures, std::string(capture_help) + "; several are merged by time")
        ->required()
        ->expected(1, 1000)
        ->check([](const std::string& file) {
          const bool is_config = std::filesystem::path(file).extension() == ".yaml";
          return is_config ? file + " is no capture; a configuration is given with -c" : std::string();
        });
  }
  void add_run() {
    auto* c = app.add_subcommand("run", "The daemon: live sensors to ROS");
    c->add_option("file,-c,--config", config, "Configuration file")->capture_default_str();
    c->callback([this] { action = [this] { return run_daemon(config, ros_arguments, std::cerr); }; });
  }
  void add_replay() {
    auto* c = app.add_subcommand("replay", "The same pipeline on captures and bags");
    c->add_option("-c,--config", replay.config, "Configuration file; default: the sensors found");
    add_captures(c, replay.captures);
    c->add_option("--rate", rate, "Of the recorded pace, or max")->capture_default_str();
    c->add_flag("--loop", replay.loop, "Again and again");
    c->add_option("--start", replay.start, "Seconds into the capture")->check(CLI::NonNegativeNumber);
    c->add_option("--duration", replay.duration, "Seconds to play")->check(CLI::NonNegativeNumber);
    c->add_option("--wait", replay.wait, "Seconds from advertising the topics to the first frame")
        ->check(CLI::Range(0.0, 3600.0));
    c->add_option("--motion", replay.motion, "A bag whose tf or odometry says how the vehicle moved");
    c->add_flag("--clock", replay.ros.clock, "Publish /clock");
    c->add_option("--bag", replay.bag, "Write the messages to this new bag instead of ROS");
    c->callback([this] { action = [this] { return start_replay(); }; });
  }
  void add_decode() {
    auto* c = app.add_subcommand("decode", "One sensor's frames of a capture, without a configuration");
    c->add_option("capture,--pcap", decode.capture, capture_help)->required();
    c->add_option("--model", decode.model, "See `lidard models`; may be left out where the packets tell");
    c->add_option("--source", source, "Sender, IP[:PORT]");
    c->add_option("--port", decode.port, "Destination port");
    c->add_option("--calibration", decode.calibration,
                  "Of a Velodyne: YAML of velodyne_pointcloud, or db.xml");
    c->add_option(
         "--calibration-model", decode.calibration_model,
         "Its equations: ros_drivers (velodyne_pointcloud's; default for a file), exact (the manual's) or "
         "veloview (the viewer's; default for the db.xml of an HDL-64E S1)")
        ->check(CLI::IsMember({"ros_drivers", "exact", "veloview"}));
    c->add_option("--format", decode.format, "csv, json or pcd")
        ->check(CLI::IsMember({"csv", "json", "pcd"}))
        ->capture_default_str();
    c->add_option("-o,--output", decode.output,
                  "File, or - for standard output; DIR/%06d.pcd writes a PCD file per frame")
        ->capture_default_str();
    c->add_option("--frame", decode.frame, "Only this frame, counted from 0");
    c->add_option("--clock", clock, "stamps placed by each packet's arrival, or smooth")
        ->check(CLI::IsMember({"arrival", "smooth"}))
        ->capture_default_str();
    c->add_option("--time", time, "host: stamp_ns since the epoch; device: since the packet's own stamp")
        ->check(CLI::IsMember({"host", "device"}))
        ->capture_default_str();
    c->callback([this] { action = [this] { return start_decode(); }; });
  }
  void add_inspect() {
    auto* c = app.add_subcommand("inspect", "Which sensors are in a capture or a bag");
    add_captures(c, captures);
    c->add_flag("--json", json, "For scripts");
    c->callback([this] { action = [this] { return run_inspect(captures, json, std::cout, std::cerr); }; });
  }
  void add_check() {
    auto* c = app.add_subcommand(
        "check", "Validates a configuration and prints it with all defaults, and what its scans can know");
    c->add_option("file,-c,--config", config, "Configuration file")->required();
    c->add_flag("--ports", ports, "Print the sockets that the daemon opens instead, for firewalls");
    c->callback([this] {
      action = [this] { return (ports ? run_check_ports : run_check)(config, std::cout, std::cerr); };
    });
  }
  void add_models() {
    auto* c = app.add_subcommand("models", "The supported models and how each was verified");
    c->add_flag("--json", json, "For scripts");
    c->callback([this] { action = [this] { return run_models(json, std::cout); }; });
  }
  void add_keys() {
    auto* c = app.add_subcommand("keys", "The reference of all configuration keys");
    auto* format = c->add_option_group("format")->require_option(0, 1);
    format->add_flag_callback(
        "--markdown", [this] { keys = KeysFormat::markdown; }, "As in config/KEYS.md");
    format->add_flag_callback(
        "--man", [this] { keys = KeysFormat::man; }, "As in the manual page");
    format->add_flag_callback(
        "--json", [this] { keys = KeysFormat::json; }, "For scripts");
    c->callback([this] { action = [this] { return run_keys(keys, std::cout); }; });
  }
  void add_record() {
    auto* c = app.add_subcommand("record", "Records the configured sensors' traffic to a capture");
    c->add_option("-c,--config", record.config,
                  "Configuration file; default: the usual ports of all supported lidars");
    c->add_option("output,-o,--output", record.output, "pcap file to write")->required();
    c->add_option("--interface", record.interface, "Network interface")->capture_default_str();
    c->add_option("--duration", record.duration, "Seconds; 0: until Ctrl-C")->check(CLI::NonNegativeNumber);
    c->callback([this] { action = [this] { return run_record(record, std::cerr); }; });
  }
  void add_calibrate() {
    auto* c =
        app.add_subcommand("calibrate", "Finds the poses and time offsets of the sensors from what they see");
    c->add_option("-c,--config", calibrate.config, "Configuration file with about the right poses")
        ->required();
    add_captures(c, calibrate.captures)->required(false);
    c->add_option("--bag", calibrate.bag, "Bag with the topics of sensors that have `topic:`");
    c->add_option(
        "--motion", calibrate.motion,
        "Bag with the vehicle's odometry, or a .csv of stamp,x,y,yaw: base poses and time offsets, too");
    c->add_option("--reference", calibrate.reference,
                  "Sensor against which the others are found; default: the first");
    c->add_option("-o,--output", calibrate.output, "Write the configuration with the new poses");
    c->add_option("--picture", calibrate.picture,
                  "Draw what the sensors saw, before and after: .png or .svg");
    c->add_flag("--json", calibrate.json, "For scripts");
    c->callback([this] { action = [this] { return run_calibrate(calibrate, std::cout, std::cerr); }; });
  }
  void add_snapshot() {
    auto* c = app.add_subcommand(
        "snapshot",
        "Draws what the vehicle sees at one moment, from above; without a capture, what it can see");
    c->add_option("-c,--config", snapshot.config, "Configuration; default: the sensors found, at the origin");
    add_captures(c, snapshot.captures)->required(false);
    c->add_option("--at", snapshot.at,
                  "Seconds into the capture; default: its middle, or the first frame after it")
        ->check(CLI::NonNegativeNumber);
    c->add_option("--range", snapshot.range, "Metres from base_frame to the edge; default: fits the scans")
        ->check(CLI::Range(0.5, 10000.0));
    c->add_option("--areas", snapshot.areas,
                  "Topic whose free and unknown areas are shaded; default: a merged one, strict first");
    c->add_option("--only", snapshot.only, "Topic to draw alone; may be repeated")->allow_extra_args(false);
    c->add_option("--color", snapshot.color, "What colours mean: height (of clouds alone) or intensity")
        ->check(CLI::IsMember({"height", "intensity"}));
    c->add_option("--motion", snapshot.motion, "A bag whose tf or odometry says how the vehicle moved");
    c->add_option("--width", snapshot.width, "Pixels of the picture; default: about 1200")
        ->check(CLI::Range(500, 4000));
    c->add_option("-o,--output", snapshot.output, "Picture to write, .png or .svg")->required();
    c->callback([this] { action = [this] { return run_snapshot(snapshot, std::cerr); }; });
  }

  void add_status() {
    const auto add = [this](const char* name, const char* what, auto run) {
      auto* c = app.add_subcommand(name, what);
      c->add_option("--socket", ask.socket,
                    "The daemon's socket; default: $LIDARD_SOCKET or where the daemon runs");
      c->callback([this, run] { action = [this, run] { return run(ask, std::cout, std::cerr); }; });
      return c;
    };
    for (auto* c : {add("status", "How the running daemon and its sensors are", run_status),
                    add("events", "What changed since the daemon began, each once", run_events)}) {
      c->add_flag("--json", ask.json, "For scripts");
      c->add_flag("--watch", ask.watch, "Again every second");
    }
    add("metrics", "The state in the text format of Prometheus", run_metrics);
    add("dump", "Lets the running daemon write the last packets to a capture", run_dump);
  }
  void add_import() {
    auto* c = app.add_subcommand(
        "import", "The configuration that does what another driver's launch or parameter file did");
    auto* file = c->add_option(
        "file", import.file, "A launch file, and ARG:=VALUE for its arguments; or a YAML file of parameters");
    c->add_option("-o,--output", import.output, "File, or - for standard output")->capture_default_str();
    auto* tables =
        c->add_flag("--tables", import.tables, "What becomes of every parameter and topic, instead");
    tables->excludes(file);
    c->callback([this] { action = [this] { return start_import(); }; });
  }
  void add_discover() {
    auto* c = app.add_subcommand("discover", "Which SICK and Hokuyo devices answer in the network");
    for (const Family& family : families()) {
      if (family.discovery == nullptr) continue;
      const Discovery& how = *family.discovery;
      auto& addresses = asked.emplace_back(&how, std::vector<std::string>()).second;
      if (!how.usual_address.empty())
        addresses.push_back(std::string(how.usual_address) + ":" + std::to_string(how.port));
      c->add_option("--" + std::string(how.name), addresses,
                    addresses.empty()
                        ? "Where to send the search, IP[:PORT]; else broadcast on all interfaces"
                        : "Addresses to ask, IP[:PORT]")
          ->capture_default_str();
    }
    c->add_option("--wait", discover.wait, "Seconds")->check(CLI::Range(0.1, 60.0))->capture_default_str();
    c->add_flag("--json", discover.json, "For scripts");
    c->callback([this] { action = [this] { return start_discover(); }; });
  }

  int start_replay() {
    try {
      replay.rate = rate == "max" ? 0 : CLI::detail::lexical_cast(rate, replay.rate) ? replay.rate : -1;
    } catch (const std::exception&) {
      replay.rate = -1;
    }
    if (!(replay.rate >= 0) || (replay.rate == 0 && rate != "max")) {
      std::cerr << "--rate: '" << rate << "' is neither a positive number nor max\n";
      return exit_usage;
    }
    if (replay.loop && !replay.bag.empty()) {
      std::cerr << "--loop and --bag: a bag of endless replay would never be complete; leave one out\n";
      return exit_usage;
    }
    replay.ros.remappings = ros_arguments;
    return run_replay(replay, std::cout, std::cerr);
  }
  int start_decode() {
    if (!source.empty()) {
      if (!decode.parse_source(source)) {
        std::cerr << "--source: '" << source
                  << "' is not an address; expected IP or IP:PORT, e.g. 192.168.1.201\n";
        return exit_usage;
      }
    }
    decode.clock = clock == "smooth" ? ClockMode::smooth : ClockMode::arrival;
    decode.stamps = time == "device" ? StampColumn::device : StampColumn::host;
    return run_decode(decode, std::cerr);
  }
  int start_import() {
    if (import.file.empty() && !import.tables) {
      std::cerr << "import: no file; expected a launch file, or a YAML file of parameters\n";
      return exit_usage;
    }
    import.arguments = ros_arguments;
    return run_import(import, std::cout, std::cerr);
  }
  int start_discover() {
    for (const auto& [how, texts] : asked) {
      if (texts.empty()) discover.targets.push_back({how, {{}, how->port}});
      for (const std::string& text : texts) {
        const auto endpoint = read_endpoint(text, how->port);
        if (!endpoint) {
          std::cerr << "--" << how->name << ": '" << text
                    << "' is not an address; expected IPv4 or IPv4:PORT, e.g. 192.168.0.10\n";
          return exit_usage;
        }
        discover.targets.push_back({how, *endpoint});
      }
    }
    return run_discover(discover, std::cout, std::cerr);
  }
};

std::string did_you_mean(const std::string& written, const std::vector<std::string>& known) {
  const std::string near(nearest_word(written, {known.begin(), known.end()}));
  return near.empty() ? "" : "; did you mean " + near + "?";
}

/// What is wrong with the line, to be read behind the program's name, where CLI11 says little: an unknown
/// command, or what the command does not know.
std::string mistake_in(const CLI::App& app, const std::vector<std::string>& given,
                       const std::string& otherwise) {
  const auto chosen = app.get_subcommands();
  if (chosen.empty()) {
    const auto word = std::find_if(given.begin(), given.end(), [](const auto& one) { return one[0] != '-'; });
    std::vector<std::string> known{"help"};
    for (const CLI::App* one : app.get_subcommands([](const CLI::App*) { return true; }))
      known.push_back(one->get_name());
    if (word == given.end() && given.empty()) return ": no command";
    const std::string& wrong = word == given.end() ? given.front() : *word;
    return (wrong[0] == '-' ? ": no option " : ": no command ") + wrong + did_you_mean(wrong, known);
  }
  std::vector<std::string> known{"--help"};
  for (const CLI::Option* option : chosen.front()->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const std::string command = " " + chosen.front()->get_name() + ": ";
  for (std::string word : given) {
    word = word.substr(0, word.find('='));
    const bool is_long = word.compare(0, 2, "--") == 0 && word.size() > 2;
    if (is_long && std::find(known.begin(), known.end(), word) == known.end())
      return fmt::format("{}no option {}{}", command, word, did_you_mean(word, known));
  }
  return command + otherwise;
}

/// `lidard help CMD` is `lidard CMD --help`.
std::vector<std::string> without_help_command(std::vector<std::string> given) {
  if (given.empty() || given.front() != "help") return given;
  given.erase(given.begin());
  given.emplace_back("--help");
  return given;
}

}  // namespace

int run_cli(int argc, char** argv) {
  const std::string program = argc > 0 ? argv[0] : "";
  const std::vector<std::string> all(argv + std::min(argc, 1), argv + argc);
  set_up_logging();
  if (const auto code = run_dropin(program.substr(program.rfind('/') + 1), all, std::cout, std::cerr))
    return *code;
  Commands commands;
  std::vector<std::string> given;
  for (const std::string& argument : all) {
    // Remappings as roslaunch appends them.
    const bool is_remapping = argument.find(":=") != std::string::npos;
    (is_remapping ? commands.ros_arguments : given).push_back(argument);
  }
  given = without_help_command(std::move(given));
  given.erase(std::remove(given.begin(), given.end(), ""), given.end());
  try {
    std::vector<std::string> backwards(given.rbegin(), given.rend());  // as CLI11 takes them
    commands.app.parse(backwards);
  } catch (const CLI::ParseError& e) {
    const auto chosen = commands.app.get_subcommands();
    const bool knows_command = !chosen.empty() || given.empty() || given.front()[0] == '-';
    if (e.get_exit_code() == 0 && knows_command) return commands.app.exit(e), exit_ok;
    std::cerr << "lidard" << mistake_in(commands.app, given, e.what()) << "\nsee `lidard "
              << (chosen.empty() ? "" : chosen.front()->get_name() + " ") << "--help`\n";
    return exit_usage;
  }
  return commands.action();
}

}  // namespace lidard
