// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "test/sim/devices/scip_wire.h"
#include "test/sim/devices/tcp_device.h"

namespace lidard::sim {

/// The texts of an answer to VV and II that differ from product to product.
struct ScipTexts {
  std::string firmware;   ///< FIRM
  std::string idle;       ///< MESM while nobody asked for scans
  std::string streaming;  ///< MESM while it sends scans without end
  std::string status;     ///< STAT of a healthy sensor
};
/// Those of a product. UST: FIRM with a date in brackets, without which urg_c (urg_sensor_firmware_version)
/// reads nothing; the date, and whether real ones have it (UrgNetwork/urg_library PR #4 says no), unverified.
/// Its number and MESM as a public stand-in for a UST-10LX of 2016 repeats them, STAT of a real UST-20LX
/// (ros-drivers/urg_node PR #6); seqsense/urg_stamped src/urg_sim/urg_sim.cpp, handleII, agrees. UTM-30LX-EW:
/// the last of them alone. UXM: unverified, taken to be like UTM.
ScipTexts scip_texts(const std::string& product);

/// A sensor that speaks SCIP 2, as its owner got it.
struct ScipDeviceOptions {
  std::string product = "UST-10LX";
  std::string firmware;  ///< empty: that of scip_texts()
  std::string serial = "H1234567";
  int range_min_mm = 20, range_max_mm = 30000;
  int steps_per_turn = 1440, first_step = 0, last_step = 1080, front_step = 540, rpm = 2400;
  bool knows_percent = false, knows_echoes = false, knows_intensities = true;
  double clock_ppm = 0;        ///< its crystal is that much fast
  double motor_ppm = 0;        ///< its motor turns that much slower than announced, by the true time
  std::uint64_t counter = 0;   ///< what its counter shows at power-up, us
  Span boot{0};                ///< after power-up it refuses (status 10) that long
  Span processing{200'000};    ///< from the last step to the first byte of the answer
  bool sends_on_tick = false;  ///< scans leave when its counter shows the next ms
  int time_tick_ms = 0;        ///< TM1 is read on the next ms, and answered on the next tick of so many
  Transit transit;
  std::map<std::string, std::string>
      refusals;  ///< status by command ("MD", "TM0"); taken off when it is empty
  /// Scans that were asked for with % have no % in their echo, as those of seqsense/urg_stamped's urg_sim.
  bool bare_echo = false;
  int long_stamp = 11;     ///< characters of a stamp in us; any other number is a defect
  int values_missing = 0;  ///< so many values are left out of each scan: a defect
};

/// What the device sees: the steps 0 to last_step of the turn that begins then.
using ScipScene = std::function<std::vector<ScipStep>(Stamp begin)>;

class ScipDevice : public TcpDevice {
 public:
  ScipDevice(ScipDeviceOptions options, ScipScene scene, Stamp power_on);

  void connected(Stamp now) override;
  void disconnected() override;
  void receive(std::string_view bytes, Stamp now) override;

  /// Switched off and on again: the counter starts anew, the client is gone.
  void power_cycle(Stamp now);
  /// A further answer in the stream, with this status and no data.
  void tell_status(std::string_view status, Stamp now);
  ScipDeviceOptions& options() { return options_; }
  /// Everything that clients wrote since power-up.
  const std::string& received() const { return received_; }
  /// Time of the first step of turn `number`.
  Stamp turn(std::int64_t number) const;
  Span period() const;
  Span step() const;

 protected:
  void produce(Stamp until) override;

 private:
  void answer(const std::string& request, Stamp now);
  void answer_order(ScipOrder order, Stamp now);
  void answer_time(const std::string& request, bool percent, Stamp now);
  double device_us(Stamp when) const;
  Stamp next_tick(Stamp when, int tick_ms) const;
  std::string counter(Stamp when, bool percent) const;
  void send_scan(Stamp begin, Stamp leaves);
  std::string version() const;
  std::string parameters() const;
  std::string information(Stamp now) const;

  ScipDeviceOptions options_;
  ScipScene scene_;
  Stamp power_on_;
  std::string line_, received_;
  bool time_mode_ = false;
  std::optional<ScipOrder> order_;
  std::int64_t next_turn_ = 0;
};

/// The order in a request, empty if it is none.
std::optional<ScipOrder> parse_order(const std::string& request);

}  // namespace lidard::sim
