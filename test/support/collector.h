// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drivers/driver.h"

namespace lidard::test {

/// One return with all that is known of it.
struct Row {
  std::size_t frame;
  std::uint32_t packet;
  int block, laser, ring, echo;
  std::int64_t offset_ns, stamp_ns;
  double azimuth_deg, distance_m;
  double x, y, z, intensity, time;
};

/// Keeps everything a driver hands on; a scan that contradicts itself fails the test.
class Collector : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  void message(const DeviceMessage& message) override;
  void extra_scan(std::string_view topic, PlanarScan& scan) override;
  void note(std::string_view sentence) override { notes.emplace_back(sentence); }
  void disconnect(bool again) override { ++(again ? reconnects : closes); }

  std::vector<PlanarScan> scans;
  std::vector<Cloud> clouds;
  std::vector<Row> rows;  ///< of clouds with origins
  std::vector<DeviceState> states;
  std::vector<ImuSample> imus;
  std::map<std::string, std::vector<PlanarScan>> extra_scans;  ///< by topic
  std::vector<std::string> notes;
  int reconnects = 0, closes = 0;
};

/// Keeps nothing, so that it allocates nothing: counts.
class Counted final : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override { ++scans, points += scan.beams; }
  void cloud(Cloud& cloud) override { ++clouds, points += cloud.size(); }
  void message(const DeviceMessage& message) override {
    fixes += std::holds_alternative<GnssFix>(message) ? 1 : 0;
  }
  std::size_t scans = 0, clouds = 0, points = 0, fixes = 0;
};

/// The value of a detail; "(missing)" if there is none.
std::string detail_of(const DeviceInfo& info, const std::string& key);

/// A driver on the desk, and what came of what it received. Its frames are those of its model's kind.
class DriverBench : public Collector {
 public:
  explicit DriverBench(const std::string& model, DriverConfig config = {});

  void scan(PlanarScan& scan) override;
  void cloud(Cloud& cloud) override;
  /// Gives it bytes of the TCP connection that arrive now.
  Verdict feed(ByteView bytes, bool stream_start = false, std::uint64_t missing = 0);
  /// Gives it bytes of the TCP connection in chunks that arrive now, while `open`.
  void feed_in_pieces(std::string_view bytes, std::size_t piece, const bool& open);

  bool has_warning(const std::string& part) const;
  std::string detail(const std::string& key) const { return detail_of(driver->info(), key); }
  const Counters& counters() const { return driver->counters(); }

  const Model* model;
  std::unique_ptr<Driver> driver;
  Stamp now{1'767'225'600'000'000'000};
};

/// Whether the packet comes from a device that listens on the model's TCP port, or goes to a UDP port of the
/// model.
bool is_for(const Model& model, const Packet& packet);

/// What came of decoding a capture as one model.
struct Decoded {
  Collector output;
  Counters counters;
  DeviceInfo info;
  std::string capture_error;
};

/// Decodes all packets of a capture that are for the model. Fails the test if the capture cannot be opened.
Decoded decode_capture(const std::string& path, const std::string& model, DriverConfig config = {});

}  // namespace lidard::test
