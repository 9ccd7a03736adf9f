// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_dialogue.h"

#include <cstdio>
#include <cstdlib>

#include "drivers/model.h"
#include "drivers/sick/cola/cola_reader.h"
#include "drivers/sick/cola/cola_recognizer.h"

namespace lidard::sick {
namespace {

/// Recorded devices answer within 20 ms; one that starts up takes longer, but then it is asked again.
constexpr Span patience = std::chrono::seconds(2);
/// For the first answer, which tells the dialect that the device speaks. Twice that is less than what the
/// connection waits for a first byte, so that our words are the ones that are shown.
constexpr Span probe_patience = std::chrono::milliseconds(600);
/// The mirror may have to reach its speed first. Shorter than what the connection waits for a first scan.
constexpr Span first_scan_patience = std::chrono::seconds(4);

/// What is asked in each step, by Step; arguments follow.
constexpr std::array<const char*, 13> commands = {"",
                                                  "sRN DeviceIdent",
                                                  "sRN LMPoutputRange",
                                                  "sRN LMDscandatacfg",
                                                  "sMN SetAccessMode",
                                                  "sWN LMDscandatacfg",
                                                  "sMN Run",
                                                  "sEN LFErec",
                                                  "sEN LIDoutputstate",
                                                  "sEN LIDinputstate",
                                                  "sEN LMDscandata",
                                                  "",
                                                  ""};

constexpr const char* no_scans =
    "the device accepts 'sEN LMDscandata 1' but sends no scans: its measurement is switched off, or somebody "
    "else "
    "is logged in; look at it with SOPAS ET";

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

template <class Read>
auto in_dialect(const ColaTelegram& telegram, Read&& read) {
  return telegram.dialect == ColaDialect::b ? read(ColaBinaryReader(telegram.arguments()))
                                            : read(ColaTextReader(telegram.arguments()));
}

/// The answer of methods and subscriptions: one number, 1 (or 0 for methods that report errors).
unsigned first_number(const ColaTelegram& telegram) {
  return in_dialect(telegram, [](auto in) -> unsigned { return in.u8(); });
}

}  // namespace

void ColaDialogue::start(Stamp now, DriverOutput& out) {
  answered_ = scans_ = false;
  logged_in_ = false;
  want_login_ = false;
  settings_.reset();
  wanted_.reset();
  found_.clear();
  ask(Step::identity, now, out);
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

void ColaDialogue::ask(Step step, Stamp now, DriverOutput& out) {
  step_ = step;
  asked_ = now;
  const std::vector<std::uint8_t> bytes = request(step);
  if (!bytes.empty()) out.request({bytes.data(), bytes.size()});
}

std::vector<std::uint8_t> ColaDialogue::login_request() const {
  const DeviceRequests& requests = config_.requests;
  const unsigned long level =
      requests.user_level.empty() ? row_.login : std::strtoul(requests.user_level.c_str(), nullptr, 10);
  const unsigned long hash = requests.password_hash.empty()
                                 ? row_.password
                                 : std::strtoul(requests.password_hash.c_str(), nullptr, 16);
  ColaWriter writer(dialect_, commands[static_cast<std::size_t>(Step::login)]);
  return writer.u8(static_cast<std::uint8_t>(level)).hash(static_cast<std::uint32_t>(hash)).finish();
}

std::vector<std::uint8_t> ColaDialogue::request(Step step) const {
  ColaWriter writer(dialect_, commands[static_cast<std::size_t>(step)]);
  switch (step) {
    case Step::idle:
    case Step::waiting:
    case Step::streaming:
      return {};
    case Step::login:
      return login_request();
    case Step::write:
      write_settings(writer, *wanted_);
      return writer.finish();
    case Step::fields:
    case Step::outputs:
    case Step::inputs:
    case Step::subscribe:
      return writer.u8(1).finish();
    case Step::identity:
    case Step::range:
    case Step::settings:
    case Step::run:
      break;
  }
  return writer.finish();
}

ColaDialogue::Step ColaDialogue::after(Step step) const {
  const Step stream = config_.requests.device_states ? Step::fields : Step::subscribe;
  switch (step) {
    case Step::identity:
      return Step::range;
    case Step::range:
      return Step::settings;
    case Step::settings:
      return wanted_ ? Step::login : stream;
    case Step::login:
      if (!logged_in_) return want_login_ ? Step::waiting : stream;
      return want_login_ ? Step::subscribe : Step::write;
    case Step::write:
      return Step::run;
    case Step::run:
      return want_login_ ? Step::waiting : stream;
    case Step::fields:
      return Step::outputs;
    case Step::outputs:
      return Step::inputs;
    case Step::inputs:
      return Step::subscribe;
    case Step::subscribe:
      return want_login_ ? Step::run : Step::waiting;
    case Step::idle:
    case Step::waiting:
    case Step::streaming:
      break;
  }
  return step;
}

void ColaDialogue::answer(const ColaTelegram& telegram, Stamp now, DriverOutput& out) {
  if (step_ == Step::idle || step_ == Step::waiting || step_ == Step::streaming) return;
  const std::string_view command = commands[static_cast<std::size_t>(step_)];
  const bool error = telegram.kind() == "sFA";
  if (!error && telegram.name() != variable_of(command)) return;
  answered_ = true;
  if (telegram.dialect != dialect_) {
    // Whoever set the device to the other dialect wanted it so: we speak it too.
    dialect_ = telegram.dialect;
    if (error && !dialect_known_) {
      dialect_known_ = true;
      ask(step_, now, out);
      return;
    }
  }
  dialect_known_ = true;
  if (error) {
    refused(cola_error_code(telegram), now, out);
  } else {
    accept(telegram, now, out);
  }
}

void ColaDialogue::accept(const ColaTelegram& telegram, Stamp now, DriverOutput& out) {
  switch (step_) {
    case Step::identity:
      take_identity(telegram);
      break;
    case Step::range:
      detail("Output range", in_dialect(telegram, [](auto in) { return read_range(in); }));
      break;
    case Step::settings:
      take_settings(telegram);
      break;
    case Step::login:
      logged_in_ = first_number(telegram) == 1;
      if (!logged_in_)
        warn(
            "the device refused the login: the password of that user level was changed, or the level does "
            "not exist; set user_level and user_level_password");
      if (!logged_in_ && want_login_) return give_up({}, out);
      break;
    case Step::write:
      settings_written(out);
      break;
    case Step::run:
      logged_in_ = false;
      break;
    case Step::subscribe:
      if (first_number(telegram) != 1) return refused(0xff, now, out);
      break;
    default:
      break;
  }
  proceed(now, out);
}

void ColaDialogue::refused(std::uint8_t code, Stamp now, DriverOutput& out) {
  const std::string command = commands[static_cast<std::size_t>(step_)];
  const bool can_login = config_.requests.allow_write || !config_.requests.user_level.empty();
  if (step_ == Step::subscribe && can_login && !logged_in_ && !want_login_) {
    want_login_ = true;
    ask(Step::login, now, out);
    return;
  }
  std::string sentence =
      "the device refused '" + command + "' (sFA " + std::to_string(code) + "): " + cola_error_words(code);
  if (step_ == Step::subscribe || (step_ == Step::login && want_login_)) return give_up(sentence, out);
  if (step_ == Step::identity || step_ == Step::range || step_ == Step::settings)
    sentence += "; its scans are not affected";
  warn(sentence);
  if (step_ == Step::login) logged_in_ = false;
  proceed(now, out);
}

void ColaDialogue::give_up(std::string why, DriverOutput& out) {
  if (!why.empty()) warn(std::move(why));
  show_warnings();
  step_ = Step::idle;
  out.disconnect(true);
}

/// Variants of a product differ in the last letter of the model's name; what they call themselves does not
/// tell them apart.
void ColaDialogue::take_identity(const ColaTelegram& telegram) {
  const std::string identity = in_dialect(telegram, [](auto in) { return read_identity(in); });
  detail("Device", identity);
  const std::string_view named = cola_model_named(identity);
  const std::string_view configured = config_.model->name;
  if (named.empty() || configured.substr(0, named.size() - 1) == named.substr(0, named.size() - 1)) return;
  warn("the device calls itself " + identity + ", which is a " + std::string(named) + ", but " +
       std::string(configured) + " is configured; correct `model`");
}

void ColaDialogue::take_settings(const ColaTelegram& telegram) {
  ColaOutputs read;
  if (!in_dialect(telegram, [&](auto in) { return read_settings(in, read); })) {
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
  if (step_ == Step::idle || step_ == Step::streaming) return;
  if (step_ == Step::waiting) {
    if (now - asked_ <= first_scan_patience) return;
    return give_up(no_scans, out);
  }
  if (now - asked_ <= (answered_ ? patience : probe_patience)) return;
  if (!dialect_known_) {
    // Whatever was not understood was not answered either.
    dialect_known_ = true;
    change_dialect();
    ask(step_, now, out);
    return;
  }
  const std::string command = commands[static_cast<std::size_t>(step_)];
  if (scans_) {
    warn("the device did not answer '" + command + "'; its scans are not affected");
    return proceed(now, out);
  }
  dialect_known_ = false;
  give_up("the device did not answer '" + command +
              "' in time; check that ip_port is its port for CoLa (2112, or 2111) and that nobody else is "
              "connected to it",
          out);
}

bool ColaDialogue::changed() { return std::exchange(changed_, false); }

void ColaDialogue::detail(const char* key, std::string value) {
  changed_ = true;
  for (auto& each : details_) {
    if (each.first != key) continue;
    each.second = std::move(value);
    return;
  }
  details_.emplace_back(key, std::move(value));
}

void ColaDialogue::warn(std::string sentence) { found_.push_back(std::move(sentence)); }

/// Those of the last attempt stay until this one has come to its end: nothing flickers while it goes on.
void ColaDialogue::show_warnings() {
  if (warnings_ == found_) return;
  warnings_ = found_;
  changed_ = true;
}

}  // namespace lidard::sick
