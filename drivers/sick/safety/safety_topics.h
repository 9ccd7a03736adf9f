// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "drivers/driver.h"
#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard::sick {

/// Names of the topics below a safety scanner's.
namespace safety_topic {
constexpr std::string_view system_state = "system_state";
constexpr std::string_view output_paths = "output_paths";
constexpr std::string_view intrusion = "intrusion";
}  // namespace safety_topic

/// Hands on what a telegram holds beside its scan, with the scan's stamp: general system state, output paths
/// (application data), interrupted beams, and what the device says of each beam. Blocks that are switched off
/// are left out.
class SafetyTopics {
 public:
  /// `scan` is the one of this telegram; its beam 0 is the telegram's beam `first_beam`.
  void publish(const Ms3Telegram& telegram, const PlanarScan& scan, std::size_t first_beam,
               DriverOutput& out);

 private:
  void publish_state(const Ms3State& state, DriverOutput& out);
  void publish_paths(const Ms3Application& application, DriverOutput& out);
  void publish_intrusion(const Ms3Telegram& telegram, const PlanarScan& scan, std::size_t first_beam,
                         DriverOutput& out);
  void publish_beam_status(const Ms3Telegram& telegram, const PlanarScan& scan, std::size_t first_beam,
                           DriverOutput& out);
  void begin(std::string_view topic, const PlanarScan& scan);
  void add(std::string_view name, double value) { state_->values.push_back({name, value}); }

  ReusedMessage<DeviceState> state_;
  PlanarScan intrusion_, beam_status_;
};

}  // namespace lidard::sick
