// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drivers/driver.h"
#include "test/sim/devices/velodyne.h"

namespace lidard::test {

/// A data packet as a Velodyne sends it.
struct WirePacket {
  std::vector<std::uint8_t> bytes;
  Stamp arrival;
};

/// A product in one of its return modes and, where it has several, with one of its timings.
struct ModelMode {
  std::string model;
  sim::ReturnMode mode;
  std::string timing;

  std::string name() const;
  const sim::VelodyneTable& table() const { return sim::velodyne_table(model); }
  bool is_dual() const { return mode >= sim::ReturnMode::dual; }
  /// Firing sequences of a packet.
  std::size_t sequences() const;
  /// Sets of blocks with the same azimuth, and the blocks of each.
  std::size_t groups() const;
  std::size_t blocks_per_group() const { return 12 / groups(); }
  /// deg from sequence to sequence, and the time of a turn, as the simulator's default has them.
  double turn_deg() const;
  Span turn_time() const;
};

/// Every product in every mode and timing; products that send the same packets once.
const std::vector<ModelMode>& model_modes();

/// What the product sends while it turns that often. Nothing is seen, that is what makes it fast: all
/// distances are 8 m and 12 m (the far return). `options.mode` and `.timing` are those of `which`.
std::vector<WirePacket> spin(const ModelMode& which, double turns, sim::VelodyneOptions options = {});

/// Gives the packet to a driver as coming from a sensor.
Reject give(Driver& driver, const WirePacket& packet, FrameReceiver& out);

/// Keeps the columns of the frames and counts their points.
class Columns final : public FrameReceiver {
 public:
  void scan(PlanarScan& scan) override { static_cast<void>(scan); }
  void cloud(Cloud& cloud) override {
    frames.push_back({cloud.columns, cloud.complete, cloud.stamp, cloud.end});
    points += cloud.size();
  }
  struct Frame {
    std::vector<CloudColumn> columns;
    bool complete;
    Stamp stamp, end;
  };
  std::vector<Frame> frames;
  std::size_t points = 0;
};

}  // namespace lidard::test
