// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "test/sim/devices/tcp_device.h"
#include "test/sim/world/sensor_model.h"

namespace lidard::sim {

/// A sensor of a scene that serves a TCP client: in a capture, which holds what its client wrote, or behind a
/// socket. It measures in turns, counted from power-up.
struct SceneDevice {
  /// What the beams of the turn that begins then bring back.
  using View = std::function<std::vector<Answer>(Stamp begin, std::size_t beams)>;
  std::function<std::unique_ptr<TcpDevice>(Transit transit, View view, Stamp power_on)> make;

  std::function<Span(std::int64_t turn)> time_of;  ///< from power-up to the first beam of a turn
  std::int64_t turns_before = 0;                   ///< when the scene begins or the server starts
  /// The beams of the turn that begins then, `since` power-up.
  std::function<std::vector<Beam>(Stamp begin, Span since, std::size_t beams)> beams;
  std::size_t beam_count = 0;
  std::function<double(const Answer& answer)> wire;  ///< m, the distance that the device sends
  Span sent_within{0};                               ///< a turn's bytes, after its first beam

  std::vector<std::string> requests;       ///< what the client of a capture writes
  Span first_request{0}, next_request{0};  ///< after the begin of the scene, after the request before
  bool joined = false;                     ///< the capture begins in the middle of the stream
};

/// Makes a sensor of the scene such a device.
void set_device(const SceneDevice& device, SensorEntry& entry);

}  // namespace lidard::sim
