// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "drivers/driver_base.h"
#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard::sick {

/// Status of a safety scanner, small enough to be compared with each telegram: texts are made only after a
/// change.
struct SafetyStatus {
  std::uint32_t serial = 0, plug_serial = 0;
  std::uint8_t channel = 0, version_major = 0, version_minor = 0, version_release = 0;
  std::optional<Ms3State> state;
  std::uint32_t intruded_paths = 0;
  std::uint8_t standby_state = 0;  ///< of the application outputs: 1 standby, 2 not, 0 not sent

  /// True if the mirror does not turn.
  bool in_standby() const;
  friend bool operator==(const SafetyStatus& a, const SafetyStatus& b);
};

SafetyStatus read_status(const Ms3Telegram& telegram);

/// What the scanner reports of itself (SICK 8022708 p. 18-19).
SelfReport troubles(const SafetyStatus& status);

/// Key and text of all values, for diagnostics.
std::vector<std::pair<std::string, std::string>> describe(const SafetyStatus& status);

/// Names of the topics below a safety scanner's.
namespace safety_topic {
constexpr std::string_view system_state = "system_state";
constexpr std::string_view intrusion = "intrusion";
}  // namespace safety_topic

/// Publishes a telegram's other data with the stamp of `scan`. Blocks that are switched off are left out.
class SafetyTopics {
 public:
  /// The general system state and the output paths (application data), which come in standby too.
  void publish_states(const Ms3Telegram& telegram, const PlanarScan& scan, FrameReceiver& out);
  /// Interrupted beams and the flags of each beam. `scan` is the one of this telegram; its beam 0 is the
  /// telegram's beam `window.first`.
  void publish_beams(const Ms3Telegram& telegram, const PlanarScan& scan, const BeamWindow& window,
                     FrameReceiver& out);

 private:
  void publish_state(const Ms3State& state, FrameReceiver& out);
  void publish_paths(const Ms3Application& application, FrameReceiver& out);
  void publish_intrusion(const Ms3Telegram& telegram, const PlanarScan& scan, const BeamWindow& window,
                         FrameReceiver& out);
  /// The scan again, with its flags as intensities.
  void publish_beam_status(const PlanarScan& scan, FrameReceiver& out);
  void begin(std::string_view topic, const PlanarScan& scan);
  void add(std::string_view name, double value) { state_->values.push_back({name, value}); }

  ReusedMessage<DeviceState> state_;
  PlanarScan intrusion_, beam_status_;
};

}  // namespace lidard::sick
