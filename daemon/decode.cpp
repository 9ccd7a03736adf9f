// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/decode.h"

#include <ostream>

#include "daemon/calibration_file.h"
#include "daemon/cli.h"
#include "daemon/config.h"
#include "daemon/report.h"
#include "daemon/stream_finder.h"
#include "drivers/connection_picker.h"
#include "drivers/pcap_source.h"
#include "drivers/velodyne/table_calibration.h"

namespace lidard {
namespace {

class WriterOutput final : public DriverOutput {
 public:
  WriterOutput(FrameWriter& writer, std::optional<std::uint64_t> only) : writer_(writer), only_(only) {}
  void scan(PlanarScan& scan) override {
    if (wanted()) writer_.scan(frames_, scan);
    returns_ += scan.beams * scan.echoes;
    ++frames_;
  }
  void cloud(Cloud& cloud) override {
    if (wanted()) writer_.cloud(frames_, cloud);
    returns_ += cloud.size();
    ++frames_;
  }
  std::uint64_t frames() const { return frames_; }
  std::uint64_t returns() const { return returns_; }

 private:
  bool wanted() const { return !only_ || *only_ == frames_; }
  FrameWriter& writer_;
  std::optional<std::uint64_t> only_;
  std::uint64_t frames_ = 0;
  std::uint64_t returns_ = 0;
};

std::unique_ptr<FrameWriter> make_writer(const DecodeOptions& options) {
  if (options.format == "pcd") return make_pcd_writer(options.output);
  if (options.format == "json") return make_json_writer(options.output, options.stamps);
  return make_csv_writer(options.output, options.stamps);
}

/// The one stream to decode, or nothing after saying why.
std::optional<SensorStream> choose_stream(const DecodeOptions& options, const Model* model,
                                          std::ostream& err) {
  const auto streams = find_streams(options, model);
  if (streams.size() == 1) return streams.front();
  if (streams.empty()) {
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

using CalibrationPtr = std::shared_ptr<const velodyne::Calibration>;

/// The calibration asked for, if any; throws ConfigError.
CalibrationPtr read_calibration(const DecodeOptions& options, std::ostream& err) {
  if (options.calibration.empty()) return nullptr;
  std::vector<std::string> warnings;
  auto calibration = std::make_shared<velodyne::Calibration>(load_calibration(options.calibration, warnings));
  for (const std::string& warning : warnings) err << "note: " << warning << '\n';
  return calibration;
}

/// The model's table with the equations asked for, where no file was given; nullptr: as the driver does it.
CalibrationPtr table_calibration(const DecodeOptions& options, const Model& model) {
  if (options.calibration_model != "ros_drivers") return nullptr;
  if (!takes_calibration(model) || velodyne::needs_own_calibration(model))
    throw ConfigError("--calibration-model ros_drivers: " + std::string(model.product) +
                      " has no table of its own for it; expected --calibration FILE");
  return std::make_shared<velodyne::Calibration>(velodyne::table_calibration(model));
}

/// With the equations asked for, or those that suit it; throws ConfigError if the calibration cannot be that
/// of the model.
CalibrationPtr settle_calibration(const DecodeOptions& options, const velodyne::Calibration& calibration,
                                  const Model& model, std::ostream& err) {
  const std::string misfit = calibration_misfit(calibration, model);
  if (!misfit.empty())
    throw ConfigError(options.calibration + ": " + misfit + "; expected the calibration of this sensor");
  const std::string doubt = calibration_doubt(calibration, model);
  if (!doubt.empty()) err << "note: " << options.calibration << ": " << doubt << '\n';
  auto settled = std::make_shared<velodyne::Calibration>(calibration);
  settled->model =
      calibration_model_of(options.calibration_model).value_or(usual_equations(calibration, model));
  return settled;
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
  config.keep_origins = true;
  config.calibration = std::move(calibration);
  const auto driver = stream.model->make(config);
  const auto writer = make_writer(options);
  WriterOutput output(*writer, options.frame);
  PcapSource source(options.capture);
  Packet packet;
  ConnectionPicker connection;
  std::uint64_t others = 0;
  while (source.next(packet)) {
    if (!stream.owns(packet)) {
      others += packet.transport == Transport::udp ? 1U : 0U;
    } else if (packet.transport == Transport::udp || connection.pick(packet)) {
      driver->receive(packet, output);
    }
  }
  driver->finish(output);
  writer->finish();
  err << stream.to_string() << ": " << output.frames() << " frames, " << output.returns() << " returns\n";
  print_counters(driver->counters(), err);
  print_capture_counters(source.counters(), others, err);
  for (const auto& warning : driver->info().warnings) err << "note: " << warning << '\n';
  if (source.error().empty()) return 0;
  err << source.error() << '\n';
  return 1;
}

}  // namespace

int run_decode(const DecodeOptions& options, std::ostream& err) {
  const Model* model = nullptr;
  if (!options.model.empty()) {
    model = find_model(options.model);
    if (model == nullptr) {
      err << "unknown model '" << options.model << "'; expected one of `lidard models`";
      const auto near = nearest_models(options.model);
      if (!near.empty()) err << ", perhaps " << near.front();
      err << '\n';
      return 2;
    }
  }
  try {
    auto calibration = read_calibration(options, err);
    const auto stream = choose_stream(options, model, err);
    return stream ? decode_stream(options, *stream, std::move(calibration), err) : 1;
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  } catch (const std::exception& e) {
    err << e.what() << '\n';
    return 1;
  }
}

}  // namespace lidard
