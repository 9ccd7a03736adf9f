// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_dialogue.h"

#include <boost/asio/yield.hpp>
#include <cstdio>
#include <cstdlib>

#include "drivers/model.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {
namespace {

/// Recorded devices answer within 20 ms. After that people learn that an answer is missing; it may still
/// come.
constexpr Span patience = std::chrono::seconds(2);
/// For the first answer, which tells the dialect that the device speaks.
constexpr Span probe_patience = std::chrono::milliseconds(600);
/// The mirror may have to reach its speed first.
constexpr Span first_scan_patience = std::chrono::seconds(4);

/// What is asked in each step, by Step; arguments follow.
constexpr std::array<std::string_view, 14> commands = {"",
                                                       "sRN DeviceIdent",
                                                       "sRN LMPoutputRange",
                                                       "sRN LMDscandatacfg",
                                                       "sMN SetAccessMode",
                                                       "sWN LMDscandatacfg",
                                                       "sMN Run",
                                                       "sEN LFErec",
                                                       "sEN LIDoutputstate",
                                                       "sEN LIDinputstate",
                                                       "sEN InertialMeasurementUnit",
                                                       "sEN LMDscandata",
                                                       "",
                                                       ""};

constexpr const char* no_scans =
    "the device accepts 'sEN LMDscandata 1' but sends no scans: its measurement is switched off, or somebody "
    "else "
    "is logged in; look at it with SOPAS ET";

template <class Step>
std::string_view command_of(Step step) {
  return commands.at(static_cast<std::size_t>(step));
}

std::string_view variable_of(std::string_view command) { return command.substr(4); }

template <class Reader>
bool read_settings(Reader in, ColaOutputs& s) {
  for (std::uint8_t& byte : s.channels) byte = in.u8();
  s.rssi = in.u8();
  s.wide_rssi = in.u8();
  s.unit = in.u8();
  for (std::uint8_t& byte : s.encoders) byte = in.u8();
  s.position = in.u8();
  s.name = in.u8();
  s.comment = in.u8();
  s.time = in.u8();
  s.interval = in.u16();
  return in.ok();
}

void write_settings(ColaWriter& out, const ColaOutputs& s) {
  out.u8(s.channels[0]).u8(s.channels[1]).u8(s.rssi).u8(s.wide_rssi).u8(s.unit);
  out.u8(s.encoders[0]).u8(s.encoders[1]).u8(s.position).u8(s.name).u8(s.comment).u8(s.time);
  out.u16(s.interval);
}

/// The echoes that come, "1+2", or "none".
std::string echoes_of(const ColaOutputs& s) {
  std::string text;
  for (unsigned bit = 0; bit < 5; ++bit) {
    if ((s.channels[0] >> bit & 1U) != 0) text += (text.empty() ? "" : "+") + std::to_string(bit + 1);
  }
  return text.empty() ? "none" : text;
}

/// What differs, for people: "echoes 1 -> 1+2, output interval 1 -> 2".
std::string changes(const ColaOutputs& before, const ColaOutputs& now) {
  std::string text;
  const auto append = [&text](const char* what, const std::string& was, const std::string& is) {
    if (was == is) return;
    text += (text.empty() ? "" : ", ") + std::string(what) + " " + was + " -> " + is;
  };
  const auto on_off = [](bool on) { return std::string(on ? "on" : "off"); };
  append("echoes", echoes_of(before), echoes_of(now));
  append("intensity", on_off(before.rssi != 0), on_off(now.rssi != 0));
  append("output interval", std::to_string(before.interval), std::to_string(now.interval));
  return text;
}

template <class Reader>
std::string read_identity(Reader in) {
  const std::string type(in.text(in.u16()));
  const std::string version(in.text(in.u16()));
  return in.ok() ? type + ", " + version : type;
}

template <class Reader>
std::string read_range(Reader in) {
  in.u16();  // number of sectors
  const double step = in.u32() / 10000.0;
  const double start = in.i32() / 10000.0;
  const double stop = in.i32() / 10000.0;
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%.4f to %.4f deg in steps of %.4f deg", start, stop, step);
  return in.ok() ? text.data() : std::string();
}

/// The answer of methods and subscriptions: one number, 1 (or 0 for methods that report errors).
unsigned first_number(const ColaTelegram& telegram) {
  return read_arguments(telegram, [](auto in) -> unsigned { return in.u8(); });
}

}  // namespace

void ColaDialogue::start(Stamp now, DriverOutput& out) {
  now_ = now;
  patience_ = {};
  answered_ = scans_ = logged_in_ = false;
  settings_.reset();
  wanted_.reset();
  found_.clear();
  script_ = {};
  script(out);
}

/// Goes on after each `yield` with the answer, or without one where the device sends scans anyway.
void ColaDialogue::script(DriverOutput& out) {
  reenter(script_) {
    yield ask(Step::identity, out);
    if (was_done()) take_identity();
    yield ask(Step::range, out);
    if (was_done()) detail("Output range", read_arguments(*answer_, [](auto in) { return read_range(in); }));
    yield ask(Step::settings, out);
    if (was_done()) take_settings();
    if (wanted_) {
      yield ask(Step::login, out);
      take_login();
    }
    if (logged_in_) {
      yield ask(Step::write, out);
      if (was_done()) settings_written(out);
      yield ask(Step::run, out);  // logs out
      if (was_done()) logged_in_ = false;
    }
    if (config_.requests.device_states) {
      yield ask(Step::fields, out);
      yield ask(Step::outputs, out);
      yield ask(Step::inputs, out);
    }
    if (config_.model->tells<ImuSample>() && dialect_ == ColaDialect::b) {
      yield ask(Step::imu, out);
    }
    yield ask(Step::subscribe, out);
    if (refused_ && !can_login()) return give_up({}, out);
    if (refused_) {
      yield ask(Step::login, out);
      take_login();
      if (refused_) return give_up({}, out);
      if (logged_in_) {
        yield ask(Step::subscribe, out);
        if (refused_) return give_up({}, out);
        yield ask(Step::run, out);
      }
    }
    ask(Step::waiting, out);
  }
}

/// Without permission to write nobody logs in to subscribe, unless the configuration names a user level.
bool ColaDialogue::can_login() const {
  return (config_.requests.allow_write || !config_.requests.user_level.empty()) && !logged_in_;
}

void ColaDialogue::change_dialect() {
  dialect_ = dialect_ == ColaDialect::b ? ColaDialect::a : ColaDialect::b;
}

/// Somebody who takes silence for a dead connection may have been quicker than our patience.
void ColaDialogue::stop() {
  if (step_ == Step::idle) return;
  if (step_ == Step::waiting) warn(no_scans);
  if (step_ != Step::streaming) show_warnings();
  const bool unanswered = step_ < Step::waiting && !dialect_known_;
  if (unanswered) change_dialect();
  step_ = Step::idle;
}

void ColaDialogue::ask(Step step, DriverOutput& out) {
  step_ = step;
  refused_.reset();
  patience_.start_answer(now_, step == Step::waiting ? first_scan_patience
                               : answered_           ? patience
                                                     : probe_patience);
  send_request(out);
}

void ColaDialogue::send_request(DriverOutput& out) const {
  const std::vector<std::uint8_t> bytes = request(step_);
  if (!bytes.empty()) out.request({bytes.data(), bytes.size()});
}

std::vector<std::uint8_t> ColaDialogue::login_request() const {
  const DeviceRequests& requests = config_.requests;
  const unsigned long level =
      requests.user_level.empty() ? row_.login : std::strtoul(requests.user_level.c_str(), nullptr, 10);
  const unsigned long hash = requests.password_hash.empty()
                                 ? row_.password
                                 : std::strtoul(requests.password_hash.c_str(), nullptr, 16);
  ColaWriter writer(dialect_, command_of(Step::login));
  return writer.u8(static_cast<std::uint8_t>(level)).hash(static_cast<std::uint32_t>(hash)).finish();
}

std::vector<std::uint8_t> ColaDialogue::request(Step step) const {
  const std::string_view command = command_of(step);
  if (command.empty()) return {};
  if (step == Step::login) return login_request();
  ColaWriter writer(dialect_, command);
  if (step == Step::write) write_settings(writer, *wanted_);
  if (command.substr(0, 3) == "sEN") writer.u8(1);
  return writer.finish();
}

void ColaDialogue::answer(const ColaTelegram& telegram, Stamp now, DriverOutput& out) {
  if (!is_asked()) return;
  now_ = now;
  if (patience_.is_slow()) patience_.start_answer(now, patience);
  const bool error = telegram.kind() == "sFA";
  if (!error && telegram.name() != variable_of(command_of(step_))) return;
  answered_ = true;
  // Whoever set the device to the other dialect wanted it so: we speak it too.
  const bool misunderstood = error && telegram.dialect != dialect_ && !dialect_known_;
  dialect_ = telegram.dialect;
  dialect_known_ = true;
  if (misunderstood) return ask(step_, out);
  if (error)
    refused_ = cola_error_code(telegram);
  else if (step_ == Step::subscribe && first_number(telegram) != 1)
    refused_ = 0xff;
  if (refused_) take_refusal();
  answer_ = &telegram;
  script(out);
  answer_ = nullptr;
}

void ColaDialogue::take_refusal() {
  if (step_ == Step::subscribe && can_login()) return;  // that may help
  const std::string command(command_of(step_));
  std::string words = "(sFA " + std::to_string(*refused_) + "): " + cola_error_words(*refused_);
  if (is_dispensable())
    detail("Refused " + command, words);
  else
    warn("the device refused '" + command + "' " + words);
}

/// True if nothing that the configuration asks for depends on the answer to the last question.
bool ColaDialogue::is_dispensable() const {
  const DeviceRequests& requests = config_.requests;
  const bool compares = requests.allow_write || requests.skip || config_.publish_multiecho;
  return step_ == Step::identity || step_ == Step::range || (step_ == Step::settings && !compares) ||
         step_ == Step::imu;
}

void ColaDialogue::take_login() {
  logged_in_ = was_done() && first_number(*answer_) == 1;
  if (!was_done() || logged_in_) return;
  refused_ = 0xff;
  warn(
      "the device refused the login: the password of that user level was changed, or the level does "
      "not exist; set user_level and user_level_password");
}

void ColaDialogue::give_up(std::string why, DriverOutput& out) {
  if (!why.empty()) warn(std::move(why));
  show_warnings();
  step_ = Step::idle;
  out.disconnect(true);
}

/// A TiM7xxS calls itself as a TiM7xx does: only the beginning of the configured name counts.
void ColaDialogue::take_identity() {
  const std::string identity = read_arguments(*answer_, [](auto in) { return read_identity(in); });
  detail("Device", identity);
  const std::string_view named = cola_model_named(identity);
  const std::string_view configured = config_.model->name;
  if (identity.empty() || (!named.empty() && configured.substr(0, named.size()) == named)) return;
  const std::string both = "the device calls itself " + identity + ", which is " +
                           (named.empty() ? "no model that is supported" : "a " + std::string(named)) +
                           ", but " + std::string(configured) + " is configured; ";
  warn(both + (named.empty() ? "its angles and ranges may be wrong: check ip_address and model"
                             : "set model: " + std::string(named)));
}

void ColaDialogue::take_settings() {
  ColaOutputs read;
  if (!read_arguments(*answer_, [&](auto in) { return read_settings(in, read); })) {
    warn(
        "the answer to 'sRN LMDscandatacfg' is not as SICK 8014631 describes it, so nothing is compared or "
        "written; report the firmware version");
    return;
  }
  settings_ = read;
  detail("Echoes sent", echoes_of(read));
  detail("Intensities sent", read.rssi == 0 ? "no" : read.wide_rssi == 0 ? "8 bits" : "16 bits");
  detail("Output interval", std::to_string(read.interval));
  compare_settings();
}

/// What the configuration asks for beyond what the device is set to.
void ColaDialogue::compare_settings() {
  ColaOutputs wanted = *settings_;
  constexpr std::uint8_t all_echoes = 0x1f;  // SICK 8014631: bits of DIST1 to DIST5
  if (config_.requests.skip) wanted.interval = static_cast<std::uint16_t>(*config_.requests.skip + 1);
  if (config_.publish_multiecho && config_.model->has(Trait::echoes)) wanted.channels[0] = all_echoes;
  const bool explicit_wish = !(wanted == *settings_);
  // Intensities are published by default where they are; that alone is no reason to ask for a permission.
  if (config_.publish_intensity && config_.requests.allow_write) wanted.rssi = 1;
  if (config_.requests.allow_write) {
    if (!(wanted == *settings_)) wanted_ = wanted;
  } else if (explicit_wish) {
    warn("the device is set otherwise than configured (" + changes(*settings_, wanted) +
         "); set allow_write: true to have it changed, or change it with SOPAS ET");
  }
}

void ColaDialogue::settings_written(DriverOutput& out) {
  const std::string text = "LMDscandatacfg: " + changes(*settings_, *wanted_);
  out.note(text);
  detail("Setting written", text);
  settings_ = wanted_;
}

void ColaDialogue::scan_came(ColaDialect dialect) {
  if (!scans_) dialect_ = dialect;
  scans_ = dialect_known_ = true;
  if (step_ != Step::waiting && step_ != Step::subscribe) return;
  step_ = Step::streaming;
  show_warnings();
}

void ColaDialogue::tick(Stamp now, DriverOutput& out) {
  now_ = now;
  if (step_ == Step::idle || step_ == Step::streaming || !patience_.is_over(now)) return;
  if (step_ == Step::waiting) return give_up(no_scans, out);
  if (!dialect_known_) {
    // Whatever was not understood was not answered either.
    dialect_known_ = true;
    change_dialect();
    return ask(step_, out);
  }
  const std::string command(command_of(step_));
  const std::string unanswered = "the device did not answer '" + command + "'";
  if (scans_) {
    if (is_dispensable())
      detail("Refused " + command, "no answer");
    else
      warn(unanswered + "; its scans are not affected");
    return script(out);
  }
  const std::string why =
      unanswered +
      " in time; check that ip_port is its port for CoLa (2112, or 2111) and that nobody else is "
      "connected to it";
  if (!answered_) change_dialect();
  if (!patience_.extend(now)) {
    dialect_known_ = false;
    return give_up(why, out);
  }
  info_.warnings = {why};
  changed_ = true;
  send_request(out);
}

bool ColaDialogue::changed() { return std::exchange(changed_, false); }

/// Those of the last attempt stay until this one has come to its end: nothing flickers while it goes on.
void ColaDialogue::show_warnings() {
  if (info_.warnings == found_) return;
  info_.warnings = found_;
  changed_ = true;
}

}  // namespace lidard::sick
