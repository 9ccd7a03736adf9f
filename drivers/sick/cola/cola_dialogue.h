// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/driver.h"
#include "drivers/sick/cola/cola_command.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_outputs.h"

namespace lidard::sick {

/// Starts the stream of scans on a device that was just connected: asks what it is and what it is set to,
/// subscribes, and writes a setting only where the configuration asks for another one and allows it.
/// Without that the requests are DeviceIdent, LMPoutputRange and LMDscandatacfg to read and LMDscandata to
/// subscribe to, in this order.
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
  const std::vector<std::pair<std::string, std::string>>& details() const { return details_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

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
    subscribe,
    waiting,  // for the first scan
    streaming
  };
  void ask(Step step, Stamp now, DriverOutput& out);
  std::vector<std::uint8_t> request(Step step) const;
  std::vector<std::uint8_t> login_request() const;
  Step after(Step step) const;
  void proceed(Stamp now, DriverOutput& out) { ask(after(step_), now, out); }
  void refused(std::uint8_t code, Stamp now, DriverOutput& out);
  void accept(const ColaTelegram& telegram, Stamp now, DriverOutput& out);
  void take_identity(const ColaTelegram& telegram);
  void take_settings(const ColaTelegram& telegram);
  void compare_settings();
  void settings_written(DriverOutput& out);
  void give_up(std::string why, DriverOutput& out);
  void detail(const char* key, std::string value);
  void warn(std::string sentence);
  void show_warnings();
  void change_dialect();

  const DriverConfig config_;
  const ColaRow& row_;
  ColaDialect dialect_ = ColaDialect::b;
  bool dialect_known_ = false;
  bool answered_ = false;  // in this connection
  bool scans_ = false;     // likewise: they come although not everything was asked yet
  Step step_ = Step::idle;
  Stamp asked_;
  bool logged_in_ = false;
  bool want_login_ = false;  // the subscription was refused without
  std::optional<ColaOutputs> settings_, wanted_;
  bool changed_ = false;
  std::vector<std::pair<std::string, std::string>> details_;
  std::vector<std::string> warnings_;
  std::vector<std::string> found_;  // in this attempt
};

}  // namespace lidard::sick
