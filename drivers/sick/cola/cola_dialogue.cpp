// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_dialogue.h"

#include <boost/asio/yield.hpp>

#include "core/base/number_text.h"
#include "drivers/model.h"

namespace lidard::sick {
namespace {

/// Recorded devices answer within 20 ms. After this time a missing answer is reported; it may still come.
constexpr Span patience = std::chrono::seconds(2);
/// For the first answer, which shows the dialect of the device.
constexpr Span probe_patience = std::chrono::milliseconds(600);
/// The mirror may still be accelerating.
constexpr Span first_scan_patience = std::chrono::seconds(4);
constexpr Span least_stream_patience = std::chrono::seconds(1);

constexpr std::string_view settings_read = "sRN LMDscandatacfg", settings_write = "sWN LMDscandatacfg",
                           subscription = "sEN LMDscandata", contamination_read = "sRN LCMstate";
/// Between two questions beside the stream.
constexpr Span contamination_period = std::chrono::seconds(10);

constexpr const char* no_scans =
    "the device accepts 'sEN LMDscandata 1' but sends no scans: its measurement is switched off, or another "
    "client is logged in; check it with SOPAS ET";

constexpr const char* scans_stopped =
    "the device sends no scans any more: its measurement was switched off, or another client changed its "
    "settings; it is asked again, check it with SOPAS ET";

template <class Reader>
bool read_outputs(Reader in, ColaContents& outputs) {
  for (std::uint8_t& byte : outputs.contents) byte = in.u8();
  outputs.interval = in.u16();
  return in.ok();
}

/// The echoes that the device sends, "1+2", or "none".
std::string echoes_of(const ColaContents& s) {
  std::string text;
  for (unsigned bit = 0; bit < 5; ++bit) {
    if ((s.contents[ColaContents::echoes] >> bit & 1U) != 0)
      text += (text.empty() ? "" : "+") + std::to_string(bit + 1);
  }
  return text.empty() ? "none" : text;
}

/// The differences, for people: "echoes 1 -> 1+2, output interval 1 -> 2".
std::string changes(const ColaContents& before, const ColaContents& now) {
  std::string text;
  const auto append = [&text](const char* what, const std::string& was, const std::string& is) {
    if (was == is) return;
    text += (text.empty() ? "" : ", ") + std::string(what) + " " + was + " -> " + is;
  };
  const auto intensity = [](const ColaContents& s) {
    return std::string((s.contents[ColaContents::intensity] & ColaContents::with_intensity) != 0 ? "on"
                                                                                                 : "off");
  };
  append("echoes", echoes_of(before), echoes_of(now));
  append("intensity", intensity(before), intensity(now));
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
  return in.ok() ? printed("%.4f to %.4f deg in steps of %.4f deg", start, stop, step) : std::string();
}

/// The answer of methods and subscriptions: one number, 1 (or 0 for methods that report errors).
unsigned first_number(const ColaTelegram& telegram) {
  return read_arguments(telegram, [](auto in) -> unsigned { return in.u8(); });
}

}  // namespace

void ColaDialogue::connected(Stamp now, FrameReceiver& out) {
  patience_ = {};
  answered_ = scans_ = logged_in_ = contamination_refused_ = false;
  contamination_asked_ = {};
  settings_.reset();
  wanted_.reset();
  found_.clear();
  begin_script(now, out);
}

/// Continues after a `yield` with the answer, or without one if the device already sends scans.
// NOLINTNEXTLINE(readability-function-size): the steps of one dialogue are one coroutine.
void ColaDialogue::script(FrameReceiver& out) {
  const DeviceRequests& requests = config_.requests;
  const bool compares = requests.allow_write || requests.skip || config_.publish_multiecho;
  reenter(script_) {
    yield ask("sRN DeviceIdent", Answer::dispensable, out);
    if (was_done()) note_identity();
    yield ask("sRN LMPoutputRange", Answer::dispensable, out);
    if (was_done()) detail("Output range", read_arguments(*answer_, [](auto in) { return read_range(in); }));
    yield ask(settings_read, compares ? Answer::needed : Answer::dispensable, out);
    if (was_done()) read_settings();
    if (wanted_) {
      yield ask(sopas_login, out);
      note_login();
    }
    if (logged_in_) {
      yield ask(settings_write, out);
      if (was_done()) note_written(out);
      yield ask(sopas_run, out);
      if (was_done()) logged_in_ = false;
    }
    if (row_.compensation != AngleCompensation::none) {
      yield ask("sRN MCAngleCompSin", Answer::dispensable, out);
    }
    if (requests.device_states) {
      yield ask("sEN LFErec", out);
      yield ask("sEN LIDoutputstate", out);
      yield ask("sEN LIDinputstate", out);
    }
    if (config_.model->sends<ImuSample>() && session_.dialect == ColaDialect::b) {
      yield ask("sEN InertialMeasurementUnit", Answer::dispensable, out);
    }
    yield ask(subscription, out);
    if (refused_ && !can_login()) return give_up(out);
    if (refused_) {
      yield ask(sopas_login, out);
      note_login();
      if (refused_) return give_up(out);
      if (logged_in_) {
        yield ask(subscription, out);
        if (refused_) return give_up(out);
        yield ask(sopas_run, out);
      }
    }
    phase_ = Phase::waiting_for_scan;
    patience_.start_answer(now_, std::max(first_scan_patience, stream_patience()));
  }
}

/// Without permission to write there is no login for a subscription, unless the configuration names a user
/// level.
bool ColaDialogue::can_login() const {
  return (config_.requests.allow_write || !config_.requests.user_level.empty()) && !logged_in_;
}

void ColaDialogue::change_dialect() {
  session_.dialect = session_.dialect == ColaDialect::b ? ColaDialect::a : ColaDialect::b;
}

/// The connection may have been closed because of the device's silence, before the time limit of the answer.
void ColaDialogue::disconnected() {
  if (phase_ == Phase::idle) return;
  if (phase_ == Phase::waiting_for_scan) warn(no_scans);
  if (phase_ != Phase::streaming) show_warnings();
  if (phase_ == Phase::asking && !dialect_known_) change_dialect();
  phase_ = Phase::idle;
}

void ColaDialogue::ask(std::string_view command, Answer answer, FrameReceiver& out) {
  phase_ = Phase::asking;
  expected_ = answer;
  refused_ = false;
  question_ = command;
  patience_.start_answer(now_, answered_ ? patience : probe_patience);
  send_question(out);
}

void ColaDialogue::send_question(FrameReceiver& out) {
  ColaWriter question = session_.ask(question_);
  if (question_ == settings_write) {
    for (const std::uint8_t byte : wanted_->contents) question.u8(byte);
    question.u16(wanted_->interval);
  }
  if (question_.substr(0, 3) == "sEN") question.u8(1);
  send(question.finish(), out);
}

void ColaDialogue::receive(const ColaTelegram& telegram, Stamp now, FrameReceiver& out) {
  contamination_refused_ = contamination_refused_ || (phase_ == Phase::streaming && telegram.kind() == "sFA");
  if (phase_ != Phase::asking) return;  // the device stops streaming during the questions
  now_ = now;
  if (patience_.is_slow()) patience_.start_answer(now, patience);
  if (!session_.accept(telegram)) return;
  answered_ = true;
  // The device is set to the other dialect: use that one.
  const bool misunderstood = session_.refusal() && telegram.dialect != session_.dialect && !dialect_known_;
  session_.dialect = telegram.dialect;
  dialect_known_ = true;
  if (misunderstood) return ask(question_, expected_, out);
  const bool declined = question_ == subscription && first_number(telegram) != 1;
  refused_ = session_.refusal() || declined;
  if (refused_) note_refusal(session_.refusal().value_or(0xff));
  answer_ = &telegram;
  script(out);
  answer_ = nullptr;
}

void ColaDialogue::note_refusal(std::uint8_t code) {
  if (question_ == subscription && can_login()) return;  // a login may help
  const std::string words = "(sFA " + std::to_string(code) + "): " + cola_error_words(code);
  note_missing("the device refused '" + session_.command() + "' " + words, words);
}

/// Records that the last question was refused or not answered.
void ColaDialogue::note_missing(std::string warning, const std::string& remark) {
  if (expected_ == Answer::dispensable)
    detail("Refused " + session_.command(), remark);
  else
    warn(std::move(warning));
}

void ColaDialogue::note_login() {
  logged_in_ = was_done() && first_number(*answer_) == 1;
  if (!was_done() || logged_in_) return;
  refused_ = true;
  warn(
      "the device refused the login: the password of that user level was changed, or the level does "
      "not exist; set user_level and user_level_password");
}

void ColaDialogue::give_up(FrameReceiver& out) {
  show_warnings();
  phase_ = Phase::idle;
  out.disconnect(true);
}

/// A TiM7xxS reports the name of a TiM7xx, so only the beginning of the configured name is compared.
void ColaDialogue::note_identity() {
  const std::string identity = read_arguments(*answer_, [](auto in) { return read_identity(in); });
  detail("Device", identity);
  const std::string_view named = cola_model_named(identity);
  const std::string_view configured = config_.model->name;
  if (identity.empty() || (!named.empty() && configured.substr(0, named.size()) == named)) return;
  // LRS36x0 and LRS36x1 (sick_scan_xd, sick_scan_common.cpp).
  if (identity.find("LD-LRS") != std::string::npos && configured.substr(0, 10) == "sick_lrs36") return;
  const std::string both = "the device reports the name " + identity + ", which is " +
                           (named.empty() ? "not a supported model" : "a " + std::string(named)) + ", but " +
                           std::string(configured) + " is configured; ";
  warn(both + (named.empty() ? "its angles and ranges may be wrong: check ip_address and model"
                             : "set model: " + std::string(named)));
}

void ColaDialogue::read_settings() {
  ColaContents read;
  if (!read_arguments(*answer_, [&](auto in) { return read_outputs(in, read); })) {
    warn(
        "the answer to 'sRN LMDscandatacfg' does not match SICK 8014631, so settings are neither "
        "compared nor written; report the firmware version");
    return;
  }
  settings_ = read;
  const bool intensities = (read.contents[ColaContents::intensity] & ColaContents::with_intensity) != 0;
  detail("Echoes sent", echoes_of(read));
  detail("Intensities sent", !intensities                                       ? "no"
                             : read.contents[ColaContents::wide_intensity] == 0 ? "8 bits"
                                                                                : "16 bits");
  detail("Output interval", std::to_string(read.interval));
  compare_settings();
}

/// Compares the configuration with the device's settings.
void ColaDialogue::compare_settings() {
  ColaContents wanted = *settings_;
  if (config_.requests.skip) wanted.interval = static_cast<std::uint16_t>(*config_.requests.skip + 1);
  if (config_.publish_multiecho && config_.model->has(Trait::echoes))
    wanted.contents[ColaContents::echoes] = row_.echoes;
  const bool differs = !(wanted == *settings_);
  // Intensities are requested only if writing is allowed, since publish_intensity is the default.
  if (config_.publish_intensity && config_.requests.allow_write)
    wanted.contents[ColaContents::intensity] |= ColaContents::with_intensity;
  if (config_.requests.allow_write) {
    if (!(wanted == *settings_)) wanted_ = wanted;
  } else if (differs) {
    warn("the device's settings differ from the configuration (" + changes(*settings_, wanted) +
         "); set allow_write: true, or change them with SOPAS ET");
  }
}

void ColaDialogue::note_written(FrameReceiver& out) {
  const std::string text = "LMDscandatacfg: " + changes(*settings_, *wanted_);
  out.note(text);
  detail("Setting written", text);
  settings_ = wanted_;
}

/// Three scans of the output interval; a scanner may turn four times slower than the fastest of its model.
Span ColaDialogue::stream_patience() const {
  const int interval = settings_ ? settings_->interval : 1 + config_.requests.skip.value_or(0);
  return std::max(least_stream_patience, span_from_seconds(12 * interval * config_.model->frame_period));
}

void ColaDialogue::scan_came(ColaDialect dialect, Stamp now) {
  if (!scans_) session_.dialect = dialect;
  scans_ = dialect_known_ = true;
  if (phase_ == Phase::streaming) patience_.start(now, stream_patience());
  const bool subscribing = phase_ == Phase::asking && question_ == subscription;
  if (phase_ != Phase::waiting_for_scan && !subscribing) return;
  phase_ = Phase::streaming;
  patience_.start(now, stream_patience());
  show_warnings();
}

void ColaDialogue::tick(Stamp now, FrameReceiver& out) {
  now_ = now;
  if (phase_ == Phase::streaming && row_.reports_contamination && !contamination_refused_ &&
      std::chrono::abs(now - contamination_asked_) >= contamination_period) {
    contamination_asked_ = now;
    send(session_.ask(contamination_read).finish(), out);
  }
  if (phase_ == Phase::idle || !patience_.is_over(now)) return;
  if (phase_ == Phase::waiting_for_scan || phase_ == Phase::streaming) {
    warn(phase_ == Phase::streaming ? scans_stopped : no_scans);
    return give_up(out);
  }
  if (!dialect_known_) {
    // No answer in this dialect: try the other one.
    dialect_known_ = true;
    change_dialect();
    return ask(question_, expected_, out);
  }
  const std::string unanswered = "the device did not answer '" + session_.command() + "'";
  if (scans_) {
    note_missing(unanswered + "; its scans are not affected", "no answer");
    return script(out);
  }
  const std::string why =
      unanswered +
      " in time; check that ip_port is its port for CoLa (2112, or 2111) and that no other client is "
      "connected to it";
  if (!answered_) change_dialect();
  if (!patience_.extend(now)) {
    dialect_known_ = false;
    warn(why);
    return give_up(out);
  }
  set_warnings({why});
  send_question(out);
}

}  // namespace lidard::sick
