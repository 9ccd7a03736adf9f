// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <ostream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/commands/progress.h"
#include "daemon/config/calibration_file.h"
#include "daemon/files/numbered_path.h"
#include "daemon/pipeline/report.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/flow.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/nearest_models.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// The packets of one sensor in a capture.
struct SensorStream {
  Flow data;
  const Model* model = nullptr;
  std::string remark;

  /// The flows of the data, telemetry and dialogue.
  FlowTable<const Model*> flows() const {
    FlowTable<const Model*> all;
    for (const Flow& flow : flows_of(*model, data.address, data.port)) all.add(flow, model);
    return all;
  }
  std::string to_string() const { return std::string(model->name) + " " + data.to_string(); }
};

/// Number of datagrams to search after the first sensor; a sensor that starts later counts as another sender.
constexpr std::uint64_t enough_datagrams = 5000;
/// Limit for address scans and peer-to-peer programs, which make a flow per packet; a vehicle has some
/// dozens.
constexpr std::size_t max_candidates = 1000;

class NoOutput final : public DriverOutput {
 public:
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& /*cloud*/) override {}
};

/// Evidence that a stream belongs to a sensor.
struct Candidate {
  Identifier identifier;
  std::unique_ptr<Driver> probe;
  ConnectionPicker connection;

  void add(Packet packet, const Model* model) {
    if (packet.transport == Transport::tcp && !connection.pick(packet)) return;
    identifier.add(packet);
    if (model == nullptr || model->transport != packet.transport) return;
    if (!probe) {
      DriverConfig config;
      config.model = model;
      probe = model->make(config);
    }
    NoOutput nowhere;
    probe->receive(packet, nowhere);
  }
  const Model* verdict(const Model* model) const {
    if (model == nullptr) return identifier.verdict();
    if (!probe) return nullptr;
    const Counters& c = probe->counters();
    // Requests to a device may look like packets, but never make frames.
    const bool some = model->transport == Transport::tcp ? c.frames > 0 : c.packets > c.rejected_total();
    return some ? model : nullptr;
  }
};

/// True if the packet is of the requested sender and port; the port of a connection is the device's.
bool is_wanted(const Packet& packet, const DecodeOptions& options) {
  if (options.source && packet.from.address != *options.source) return false;
  if (options.source_port != 0 && packet.from.port != options.source_port) return false;
  return options.port == 0 || flow_of(packet).port == options.port;
}

/// The streams of a capture that can be decoded, as `model` or, if it is nullptr, as the recognized model.
/// Throws CaptureError if the file cannot be opened. `unreadable` gets a line for every stream of an
/// unsupported sensor.
std::vector<SensorStream> find_streams(const DecodeOptions& options, const Model* model,
                                       std::string& unreadable) {
  PcapSource source(options.capture);
  std::map<Flow, Candidate> candidates;
  bool found = false;
  Packet packet;
  for (std::uint64_t n = 0; (n < enough_datagrams || !found) && source.next(packet); ++n) {
    if (!is_wanted(packet, options)) continue;
    const Flow flow = flow_of(packet);
    if (candidates.size() >= max_candidates && candidates.find(flow) == candidates.end()) continue;
    Candidate& candidate = candidates[flow];
    candidate.add(packet, model);
    found = found || candidate.verdict(model) != nullptr;
  }
  std::vector<SensorStream> streams;
  for (const auto& [flow, candidate] : candidates) {
    const Model* verdict = candidate.verdict(model);
    const std::string remark = candidate.identifier.remark();
    if (verdict != nullptr)
      streams.push_back({flow, verdict, remark});
    else if (!remark.empty())
      unreadable += options.capture + ": " + flow.to_string() + ": " + remark + '\n';
  }
  return streams;
}

class WriterOutput final : public DriverOutput {
 public:
  WriterOutput(FrameWriter& writer, std::optional<std::uint64_t> only) : writer_(writer), only_(only) {}
  void scan(PlanarScan& scan) override {
    if (wanted()) writer_.scan(frames_, scan), report_.count(scan.stamp);
    returns_ +=
        static_cast<std::uint64_t>(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit));
    ++frames_;
  }
  void cloud(Cloud& cloud) override {
    if (wanted()) writer_.cloud(frames_, cloud), report_.count(cloud.stamp);
    returns_ += cloud.size();
    ++frames_;
  }
  void extra_scan(std::string_view topic, PlanarScan& scan) override {
    if (wanted() && topic == beam_status_scan) writer_.beam_flags(scan.intensities);
  }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t returns() const { return returns_; }
  const OutputReport& report() const { return report_; }

 private:
  bool wanted() const { return !only_ || *only_ == frames_; }
  FrameWriter& writer_;
  std::optional<std::uint64_t> only_;
  std::uint64_t frames_ = 0;
  std::uint64_t returns_ = 0;
  OutputReport report_;
};

/// Checks whether a stream contains a complete frame, as a replay would publish it.
class WholeFrame final : public DriverOutput {
 public:
  explicit WholeFrame(DriverConfig config) {
    config.keep_partial = false;
    config.keep_origins = false;
    driver_ = config.model->make(config);
  }
  void receive(const Packet& packet) {
    if (!seen_) first_ = packet.arrival;
    seen_ = true;
    last_ = packet.arrival;
    if (!found_) driver_->receive(packet, *this);
    if (found_) driver_.reset();  // frees its memory
  }
  void finish() {
    if (!found_) driver_->finish(*this);
  }
  void scan(PlanarScan& scan) override { static_cast<void>(scan), found_ = true; }
  void cloud(Cloud& cloud) override { static_cast<void>(cloud), found_ = true; }
  bool found() const { return found_; }
  /// From the first to the last packet.
  Span span() const { return last_ - first_; }
  /// Valid only while no frame was found.
  const Counters& counters() const { return driver_->counters(); }

 private:
  std::unique_ptr<Driver> driver_;
  bool seen_ = false;
  bool found_ = false;
  Stamp first_{}, last_{};
};

std::unique_ptr<FrameWriter> make_writer(const DecodeOptions& options) {
  if (options.format == "pcd") return make_pcd_writer(options.output);
  if (options.format == "json") return make_json_writer(options.output, options.stamps);
  return make_csv_writer(options.output, options.stamps);
}

/// The stream to decode, or nothing after an error message.
std::optional<SensorStream> choose_stream(const DecodeOptions& options, const Model* model,
                                          std::ostream& err) {
  std::string unreadable;
  const auto streams = find_streams(options, model, unreadable);
  if (streams.size() == 1) return streams.front();
  if (streams.empty() && !unreadable.empty()) {
    err << unreadable;
  } else if (streams.empty()) {
    err << options.capture << ": no packets of "
        << (model == nullptr ? "a supported lidar" : std::string(model->name))
        << " found; `lidard inspect` shows what is in it, `lidard models` what is supported\n";
  } else {
    err << options.capture << ": " << streams.size()
        << " sensors found; choose one with --source and --port:\n";
    for (const auto& stream : streams) err << "  " << stream.to_string() << '\n';
  }
  return std::nullopt;
}

using CalibrationPtr = std::shared_ptr<const Calibration>;

/// The requested calibration, if any; throws ConfigError.
CalibrationPtr read_calibration(const DecodeOptions& options, std::ostream& err) {
  if (options.calibration.empty()) return nullptr;
  std::vector<std::string> warnings;
  auto calibration = std::make_shared<Calibration>(load_calibration(options.calibration, warnings));
  for (const std::string& warning : warnings) err << "note: " << warning << '\n';
  return calibration;
}

/// The model's table with the requested equations, if no file is given; nullptr: the driver's default.
CalibrationPtr table_calibration(const DecodeOptions& options, const Model& model) {
  if (options.calibration_model != "ros_drivers") return nullptr;
  if (!model.has(Trait::calibration) || needs_own_calibration(model))
    throw ConfigError("--calibration-model ros_drivers: " + std::string(model.product) +
                      " has no table of its own for it; expected --calibration FILE");
  return std::make_shared<Calibration>(table_calibration(model));
}

/// The calibration with the requested or default equations; throws ConfigError if it does not fit the model.
CalibrationPtr settle_calibration(const DecodeOptions& options, const Calibration& calibration,
                                  const Model& model, std::ostream& err) {
  const std::string rejection = calibration_rejection(calibration, model);
  if (!rejection.empty())
    throw ConfigError(options.calibration + ": " + rejection + "; expected the calibration of this sensor");
  const std::string warning = calibration_warning(calibration, model);
  if (!warning.empty()) err << "note: " << options.calibration << ": " << warning << '\n';
  auto settled = std::make_shared<Calibration>(calibration);
  settled->model =
      calibration_model_of(options.calibration_model).value_or(usual_equations(calibration, model));
  return settled;
}

/// Prints the table at the end; false if there was no return or not the requested frame.
bool print_report(const DecodeOptions& options, const WriterOutput& output, const WholeFrame& whole,
                  const Model& model, std::ostream& err) {
  OutputReport report = output.report();
  report.name = options.output == "-" ? "standard output" : options.output;
  const bool beyond = options.frame && *options.frame >= output.frames();
  if (!whole.found()) report.remark = why_no_frame(model, whole.counters(), whole.span());
  if (whole.found() && output.returns() == 0) report.remark = "no return in any frame";
  if (beyond)
    report.remark = "--frame " + std::to_string(*options.frame) + " is beyond the end: the capture holds " +
                    std::to_string(output.frames()) + " frames, counted from 0";
  print_outputs("output", {report}, err);
  return output.returns() > 0 && !beyond;
}

void show(Progress& progress, const PcapSource& source, const WriterOutput& output) {
  const double rate = static_cast<double>(output.returns()) / progress.elapsed() / 1e6;
  progress.show(
      static_cast<double>(source.position()) / static_cast<double>(source.size()),
      printed("%llu frames  %.1f M returns/s", static_cast<unsigned long long>(output.frames()), rate));
}

int decode_stream(const DecodeOptions& options, const SensorStream& stream, CalibrationPtr calibration,
                  std::ostream& err) {
  if (calibration != nullptr)
    calibration = settle_calibration(options, *calibration, *stream.model, err);
  else
    calibration = table_calibration(options, *stream.model);
  if (!stream.remark.empty()) err << options.capture << ": note: " << stream.remark << '\n';
  DriverConfig config;
  config.model = stream.model;
  config.frame_id = stream.model->name;
  config.clock = options.clock;
  config.keep_partial = true;
  config.keep_origins = options.format != "pcd";  // no PCD file has them
  config.publish_multiecho = stream.model->has(Trait::echoes);
  config.calibration = std::move(calibration);
  const auto driver = stream.model->make(config);
  WholeFrame whole(config);
  const auto writer = make_writer(options);
  WriterOutput output(*writer, options.frame);
  PcapSource source(options.capture);
  Packet packet;
  const auto flows = stream.flows();
  ConnectionPicker connection;
  std::uint64_t others = 0;
  Progress progress(true);
  while (source.next(packet)) {
    if (progress.is_due()) show(progress, source, output);
    if (flows.find(packet) == nullptr) {
      others += packet.transport == Transport::udp ? 1U : 0U;
    } else if (packet.transport == Transport::udp || connection.pick(packet)) {
      driver->receive(packet, output);
      whole.receive(packet);
    }
  }
  driver->finish(output);
  whole.finish();
  writer->finish();
  progress.clear();
  err << stream.to_string() << ": " << output.frames() << " frames, " << output.returns() << " returns\n";
  print_counters(driver->counters(), err);
  print_capture_counters(source.counters(), others, err);
  for (const auto& warning : driver->info().warnings) err << "note: " << warning << '\n';
  const bool came = print_report(options, output, whole, *stream.model, err);
  if (!source.error().empty()) err << source.error() << '\n';
  return came && !source.is_damaged() ? exit_ok : exit_failed;
}

}  // namespace

int run_decode(const DecodeOptions& options, std::ostream& err) {
  if (options.format != "pcd" && NumberedPath::parse(options.output)) {
    err << "--output: '" << options.output
        << "' is a pattern for a file per frame, which --format pcd alone has\n";
    return exit_usage;
  }
  const Model* model = nullptr;
  if (!options.model.empty()) {
    model = find_model(options.model);
    if (model == nullptr) {
      err << "--model: unknown model '" << options.model << "'; expected one of `lidard models`";
      const auto near = nearest_models(options.model);
      if (!near.empty()) err << ", perhaps " << near.front();
      err << '\n';
      return exit_usage;
    }
  }
  return guarded(err, [&] {
    auto calibration = read_calibration(options, err);
    const auto stream = choose_stream(options, model, err);
    return stream ? decode_stream(options, *stream, std::move(calibration), err) : exit_failed;
  });
}

}  // namespace lidard
