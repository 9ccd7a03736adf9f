// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// From packets to finished PointCloud2 bytes, for every Velodyne and return mode, with the model's table of
// lasers, with a calibration of angles and with one of every correction; beside it memcpy of the same bytes
// (x_memcpy: how many times as long). Simulated packets in memory, one thread.
#include <string>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/models.h"
#include "test/bench/yardstick.h"
#include "test/sim/devices/velodyne_tables.h"
#include "test/sim/servers/velodyne_stream.h"

namespace lidard {
namespace {

enum class Calibrated { no, angles, all };

/// Sizes of the frames that came out.
class FrameSizes final : public FrameReceiver {
 public:
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& cloud) override {
    points += cloud.size();
    if (frames.size() < frames.capacity()) frames.push_back(cloud.points_bytes.size());
  }
  std::size_t points = 0;
  std::vector<std::size_t> frames;
};

/// Data packets one after another in memory, as a receive buffer has them.
class Recording {
 public:
  explicit Recording(const std::vector<sim::SimulatedPacket>& packets) {
    for (const auto& packet : packets) {
      bytes_.insert(bytes_.end(), packet.payload.begin(), packet.payload.end());
      arrivals_.push_back(packet.arrival);
    }
  }
  std::size_t size() const { return arrivals_.size(); }
  ByteView payload(std::size_t i) const { return ByteView(bytes_.data(), bytes_.size()).sub(i * each, each); }
  Stamp arrival(std::size_t i) const { return arrivals_[i]; }

 private:
  static constexpr std::size_t each = 1206;
  std::vector<std::uint8_t> bytes_;
  std::vector<Stamp> arrivals_;
};

/// A calibration file's content for a sensor that is exactly as its model's table says, or off by a little
/// everywhere.
std::shared_ptr<Calibration> calibration_of(const Model& model, Calibrated kind) {
  constexpr double rad = 3.14159265358979323846 / 180;
  if (kind == Calibrated::no) return nullptr;
  const auto& row = *static_cast<const velodyne::ModelRow*>(model.row);
  auto calibration = std::make_shared<Calibration>();
  calibration->distance_step_m = row.distance_step_m;
  for (std::size_t k = 0; k < row.lasers; ++k) {
    LaserCalibration laser;
    laser.rot_correction = row.laser[k].rot_correction_deg * rad;
    laser.vert_correction = row.laser[k].elevation_deg * rad;
    laser.vert_offset = row.laser[k].z_offset_mm * 1e-3;
    if (kind == Calibrated::all) {
      laser.dist_correction = 1.2;
      laser.dist_correction_x = 1.25;
      laser.dist_correction_y = 1.22;
      laser.horiz_offset = 0.026;
      laser.vert_offset = 0.21;
      laser.two_point = TwoPoint::on;
      laser.focal_distance = 24;
      laser.focal_slope = 1.1;
    }
    calibration->lasers.push_back(laser);
  }
  return calibration;
}

void decode(benchmark::State& state, const std::string& name, const std::string& mode, Calibrated kind) {
  sim::VelodyneSetup setup;
  setup.model = name;
  setup.mode = mode;
  // Second echoes come from beams that are wide enough to meet two things.
  if (mode != "strongest") setup.divergence_mrad = 3;
  const Recording packets(simulate_velodyne(setup));
  DriverConfig config;
  config.model = find_model(name);
  config.keep_partial = true;
  config.calibration = calibration_of(*config.model, kind);
  const auto driver = config.model->make(config);
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  FrameSizes output;
  output.frames.reserve(100);
  const auto play = [&] {
    for (std::size_t i = 0; i < packets.size(); ++i)
      driver->receive({packets.payload(i), packets.arrival(i), sensor, {{}, 2368}}, output);
    driver->finish(output);
    driver->restart();
  };
  play();
  const std::size_t points = output.points;
  const auto frames = output.frames;
  const auto slots = static_cast<double>(packets.size() * 384);
  bench::against_memcpy(state, points, frames, play);
  state.counters["filled"] = static_cast<double>(points) / slots;
}

void add(const std::string& model, const std::string& mode, Calibrated kind) {
  static const char* const suffix[] = {"", "/angles", "/calibrated"};
  const std::string name = model + "/" + mode + suffix[static_cast<int>(kind)];
  benchmark::RegisterBenchmark(name.c_str(),
                               [=](benchmark::State& state) { decode(state, model, mode, kind); })
      ->UseManualTime()
      ->Unit(benchmark::kMillisecond);
}

void add_all() {
  for (const sim::VelodyneTable& table : sim::velodyne_tables()) {
    for (const Calibrated kind : {Calibrated::no, Calibrated::angles, Calibrated::all}) {
      add(table.name, "strongest", kind);
      if (table.has_dual) add(table.name, "dual", kind);
      if (table.has_confidence()) add(table.name, "dual_confidence", kind);
    }
  }
}

}  // namespace
}  // namespace lidard

int main(int argc, char** argv) {
  lidard::add_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
