// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <ostream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "daemon/health/report.h"
#include "daemon/offline/choice.h"
#include "daemon/offline/progress.h"
#include "drivers/capture/pcap_source.h"
#include "drivers/flow.h"

namespace lidard {
namespace {

class FrameRecorder final : public FrameReceiver {
 public:
  FrameRecorder(FrameWriter& writer, std::optional<std::uint64_t> only) : writer_(writer), only_(only) {}
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
  const TopicTotals& report() const { return report_; }

 private:
  bool wanted() const { return !only_ || *only_ == frames_; }
  FrameWriter& writer_;
  std::optional<std::uint64_t> only_;
  std::uint64_t frames_ = 0;
  std::uint64_t returns_ = 0;
  TopicTotals report_;
};

std::unique_ptr<FrameWriter> make_writer(const DecodeOptions& options) {
  if (options.format == "pcd") return make_pcd_writer(options.output);
  if (options.format == "json") return make_json_writer(options.output, options.stamps);
  return make_csv_writer(options.output, options.stamps);
}

/// Prints the table at the end; false if there was no return or not the requested frame.
bool print_report(const DecodeOptions& options, const FrameRecorder& output, const FoundSensor& sensor,
                  std::ostream& err) {
  TopicTotals report = output.report();
  report.name = options.output == "-" ? "standard output" : options.output;
  const bool beyond = options.frame && *options.frame >= output.frames();
  if (output.returns() == 0) report.remark = "no return in any frame";
  if (sensor.frames == 0)
    report.remark = why_no_frame(*sensor.model, sensor.counters, sensor.data.last - sensor.data.first);
  if (beyond)
    report.remark = "--frame " + std::to_string(*options.frame) + " is beyond the end: the capture holds " +
                    std::to_string(output.frames()) + " frames, counted from 0";
  print_outputs("output", {report}, err);
  return output.returns() > 0 && !beyond;
}

void show(Progress& progress, const PcapSource& source, const FrameRecorder& output) {
  const double rate = static_cast<double>(output.returns()) / progress.elapsed() / 1e6;
  progress.show(
      static_cast<double>(source.position()) / static_cast<double>(source.size()),
      printed("%llu frames  %.1f M returns/s", static_cast<unsigned long long>(output.frames()), rate));
}

int decode_sensor(const DecodeOptions& options, const FoundSensor& sensor, CalibrationPtr calibration,
                  std::ostream& err) {
  const Model& model = *sensor.model;
  calibration = calibration_for(options, calibration, model, err);
  if (!sensor.data.remark.empty()) err << options.capture << ": note: " << sensor.data.remark << '\n';
  DriverConfig config;
  config.model = &model;
  config.frame_id = model.name;
  config.clock = options.clock;
  config.keep_partial = true;
  config.keep_origins = options.format != "pcd";  // no PCD file has them
  config.publish_multiecho = model.has(Trait::echoes);
  config.calibration = std::move(calibration);
  const auto driver = model.make(config);
  const auto writer = make_writer(options);
  FrameRecorder output(*writer, options.frame);
  PcapSource source(options.capture);
  Packet packet;
  FlowTable<const Model*> flows;
  for (const Flow& flow : flows_of(model, sensor.data.address, sensor.data.port)) flows.add(flow, &model);
  ConnectionPicker connection;
  std::uint64_t others = 0;
  Progress progress(true);
  while (source.next(packet)) {
    if (progress.is_due()) show(progress, source, output);
    if (flows.find(packet) == nullptr) {
      others += packet.transport == Transport::udp ? 1U : 0U;
    } else if (packet.transport == Transport::udp || connection.pick(packet)) {
      driver->receive(packet, output);
    }
  }
  driver->finish(output);
  writer->finish();
  progress.clear();
  err << text_of(sensor) << ": " << output.frames() << " frames, " << output.returns() << " returns\n";
  print_counters(driver->counters(), err);
  print_capture_counters(source.counters(), others, err);
  for (const auto& warning : info_of(*driver).warnings) err << "note: " << warning << '\n';
  const bool came = print_report(options, output, sensor, err);
  return came && !source.is_damaged() ? exit_ok : exit_failed;
}

}  // namespace

int run_decode(const DecodeOptions& options, std::ostream& err) {
  if (options.format != "pcd" && numbered_path(options.output, 0)) {
    err << "--output: '" << options.output
        << "' is a pattern for a file per frame, which --format pcd alone has\n";
    return exit_usage;
  }
  return guarded(err, [&] {
    model_of(options);
    auto calibration = read_calibration(options, err);
    const Survey found = survey_of_choice({options.capture}, options, err);
    check_single({options.capture}, found.sensors);
    return decode_sensor(options, found.sensors.front(), std::move(calibration), err);
  });
}

}  // namespace lidard
