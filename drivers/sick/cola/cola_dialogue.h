// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

/// LMDscandatacfg: what the device puts into its scans (SICK 8014631 chapter 4.3.1).
struct ColaOutputs {
  std::array<std::uint8_t, 2> channels{};  ///< bit by echo
  std::uint8_t rssi = 0, wide_rssi = 0, unit = 0;
  std::array<std::uint8_t, 2> encoders{};
  std::uint8_t position = 0, name = 0, comment = 0, time = 0;
  std::uint16_t interval = 1;  ///< every n-th scan

  friend bool operator==(const ColaOutputs& a, const ColaOutputs& b) {
    return a.channels == b.channels && a.rssi == b.rssi && a.wide_rssi == b.wide_rssi && a.unit == b.unit &&
           a.encoders == b.encoders && a.position == b.position && a.name == b.name &&
           a.comment == b.comment && a.time == b.time && a.interval == b.interval;
  }
};

/// Starts the stream of scans on a device that was just connected: asks what it is and what it is set to,
/// subscribes, and writes a setting only where the configuration asks for another one and allows it.
/// Without that the requests are DeviceIdent, LMPoutputRange and LMDscandatacfg to read and LMDscandata to
/// subscribe to, in this order; before the last of them InertialMeasurementUnit, of models that have one.
class ColaDialogue {
 public:
  ColaDialogue(const DriverConfig& config, const ColaRow& row) : config_(config), row_(row) {}

  void start(Stamp now, DriverOutput& out);
  void stop();
  /// Something that the device said and that is no event.
  void answer(const ColaTelegram& telegram, Stamp now, DriverOutput& out);
  /// A scan came, in this dialect.
  void scan_came(ColaDialect dialect);
  void tick(Stamp now, DriverOutput& out);

  /// True once after what follows changed.
  bool changed();
  const DeviceInfo& info() const { return info_; }

 private:
  enum class Step : std::uint8_t {
    idle,
    identity,
    range,
    settings,
    login,
    write,
    run,
    fields,
    outputs,
    inputs,
    imu,
    subscribe,
    waiting,  // for the first scan
    streaming
  };
  void script(DriverOutput& out);
  void ask(Step step, DriverOutput& out);
  void send_request(DriverOutput& out) const;
  /// A device that is asked does not stream yet.
  bool is_asked() const { return step_ != Step::idle && step_ < Step::waiting; }
  std::vector<std::uint8_t> request(Step step) const;
  std::vector<std::uint8_t> login_request() const;
  bool can_login() const;
  /// The last question was answered and not refused.
  bool was_done() const { return answer_ != nullptr && !refused_; }
  bool is_dispensable() const;
  void take_refusal();
  void take_login();
  void take_identity();
  void take_settings();
  void compare_settings();
  void settings_written(DriverOutput& out);
  void give_up(std::string why, DriverOutput& out);
  void detail(std::string_view key, std::string_view value) { changed_ = true, info_.set(key, value); }
  void warn(std::string sentence) { found_.push_back(std::move(sentence)); }
  void show_warnings();
  void change_dialect();

  const DriverConfig config_;
  const ColaRow& row_;
  boost::asio::coroutine script_;
  ColaDialect dialect_ = ColaDialect::b;
  bool dialect_known_ = false;
  bool answered_ = false;  // in this connection
  bool scans_ = false;     // likewise: they come although not everything was asked yet
  Step step_ = Step::idle;
  Stamp now_;
  Patience patience_;
  const ColaTelegram* answer_ = nullptr;  // to the last question; nullptr: none came
  std::optional<std::uint8_t> refused_;   // error code of that answer
  bool logged_in_ = false;
  std::optional<ColaOutputs> settings_, wanted_;
  bool changed_ = false;
  DeviceInfo info_;
  std::vector<std::string> found_;  // in this attempt
};

}  // namespace lidard::sick
