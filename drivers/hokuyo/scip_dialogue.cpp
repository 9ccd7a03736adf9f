// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_dialogue.h"

#include <algorithm>

#include "drivers/hokuyo/scip_status.h"
#include "drivers/model.h"

namespace lidard::hokuyo {
namespace {

/// Sensors answer within some ms; UTM-30LX-EW takes longer for QT while its last scan is on the way.
constexpr Span answer_patience = std::chrono::milliseconds(1200);
constexpr Span time_patience = std::chrono::milliseconds(500);
constexpr Span least_stream_patience = std::chrono::milliseconds(600);
constexpr Span verifying_patience = std::chrono::seconds(5);
constexpr Span before_next_try = std::chrono::seconds(1);
constexpr int most_comparisons = 60;

/// Without the mark of the extension, which not every sensor repeats in its echo.
std::string_view unmarked(std::string_view echo) {
  if (!echo.empty() && echo.front() == '%') echo.remove_prefix(1);
  return echo;
}

}  // namespace

void ScipDialogue::connected(Stamp now, DriverOutput& out) {
  introduced_ = compare_only_ = without_percent_ = false;
  stalls_ = 0;
  echoes_ = config_.publish_multiecho && config_.model->has(Trait::echoes);
  intensities_ = config_.publish_intensity;
  board_.clear(ScipTrouble::no_echoes);
  board_.clear(ScipTrouble::no_intensities);
  go(Step::quit, now, out);
}

void ScipDialogue::send(std::string_view request, Stamp now, DriverOutput& out) {
  sent_ = now;
  out.request(ByteView(request));
}

void ScipDialogue::go(Step step, Stamp now, DriverOutput& out) {
  step_ = step;
  patience_ = answer_patience;
  const auto ask = [&](std::string_view request) {
    expected_ = request.substr(0, request.front() == '%' ? 3 : 2);
    if (request.size() == 4) expected_ = request.substr(0, 3);  // TM0, TM1, TM2
    send(request, now, out);
  };
  switch (step) {
    case Step::quit:
      return ask("QT\n");
    case Step::leave_old_time_mode:
    case Step::leave_time_mode:
      return ask("TM2\n");
    case Step::version:
      return ask("VV\n");
    case Step::parameters:
      return ask("PP\n");
    case Step::information:
      return ask("II\n");
    case Step::enter_time_mode:
      comparisons_ = 0;
      return ask("TM0\n");
    case Step::compare:
      patience_ = time_patience;
      return ask(percent_ ? "%TM1\n" : "TM1\n");
    default:
      return start(now, out);
  }
}

void ScipDialogue::start(Stamp now, DriverOutput& out) {
  introduced_ = true;
  compare_only_ = false;
  step_ = Step::start;
  patience_ = answer_patience;
  ScipScanRequest request = owner_.wanted();
  request.percent = percent_;
  request.continuous = true;
  request.multi_echo = echoes_;
  request.intensities = intensities_;
  turn_s_ = config_.model->frame_period * (1 + request.skip);
  send(write_scan_request(request, request_), now, out);
}

Span ScipDialogue::stream_patience() const {
  return std::max(least_stream_patience, span_from_seconds(5 * turn_s_));
}

void ScipDialogue::take(const ScipMessage& message, Stamp now, DriverOutput& out) {
  if (step_ == Step::idle) return;
  if (parse_scan_request(message.echo)) return take_stream(message, now, out);
  if (!expects(message)) return;
  switch (step_) {
    case Step::quit:
      return after_quit(message, now, out);
    case Step::leave_old_time_mode:
      return go(Step::version, now, out);
    case Step::version:
      percent_ = owner_.knows_percent() && !without_percent_;
      return go(Step::parameters, now, out);
    case Step::parameters:
      return go(Step::information, now, out);
    case Step::information:
      return go(config_.requests.calibrate_time ? Step::enter_time_mode : Step::start, now, out);
    case Step::enter_time_mode:
      // 02: it is in that mode already (Hokuyo C-42-03320B p. 15). Soon after power-up it refuses.
      return go(message.status == "00" || message.status == "02" ? Step::compare : Step::start, now, out);
    case Step::compare:
      return after_comparison(message, now, out);
    case Step::leave_time_mode:
      return go(Step::start, now, out);
    default:
      return;
  }
}

bool ScipDialogue::expects(const ScipMessage& message) const {
  const std::string_view wanted = unmarked(expected_);
  return unmarked(message.echo).substr(0, wanted.size()) == wanted;
}

void ScipDialogue::after_quit(const ScipMessage& message, Stamp now, DriverOutput& out) {
  if (compare_only_) return go(Step::enter_time_mode, now, out);
  if (introduced_) return go(Step::start, now, out);
  // In time mode QT is unknown to some firmware.
  if (class_of(message.status) == StatusClass::unknown) return go(Step::leave_old_time_mode, now, out);
  go(Step::version, now, out);
}

void ScipDialogue::after_comparison(const ScipMessage& message, Stamp now, DriverOutput& out) {
  if (percent_ && class_of(message.status) == StatusClass::unknown) {
    percent_ = false;
    return go(Step::compare, now, out);
  }
  std::string_view body = message.body;
  const std::string_view line = take_line(body);
  bool enough = true;
  if (message.status == "00" && has_checksum(line)) {
    if (const auto stamp = parse_stamp(line))
      enough = owner_.compared(*stamp, sent_, now) || ++comparisons_ >= most_comparisons;
  }
  go(enough ? Step::leave_time_mode : Step::compare, now, out);
}

void ScipDialogue::take_stream(const ScipMessage& message, Stamp now, DriverOutput& out) {
  if (step_ != Step::start && step_ != Step::streaming) return;
  switch (class_of(message.status)) {
    case StatusClass::data:
      stalls_ = 0;
      [[fallthrough]];
    case StatusClass::accepted:
    case StatusClass::resumed:
      step_ = Step::streaming;
      sent_ = now;
      patience_ = stream_patience();
      for (const auto gone : {ScipTrouble::silent, ScipTrouble::refused, ScipTrouble::fault})
        board_.clear(gone);
      return;
    case StatusClass::verifying:
      board_.set(ScipTrouble::fault, explain_status(message.command(), message.status));
      sent_ = now;
      patience_ = verifying_patience;
      return;
    case StatusClass::fault:
      board_.set(ScipTrouble::fault, explain_status(message.command(), message.status));
      return wait(before_next_try, now);
    case StatusClass::unknown:
      return ask_for_less(message, now, out);
    case StatusClass::refused:
      board_.set(ScipTrouble::refused, explain_status(message.command(), message.status));
      return wait(before_next_try, now);
  }
}

/// The sensor does not know this request: first without the extension, then without echoes, at last without
/// intensities. The user is told what he does not get.
void ScipDialogue::ask_for_less(const ScipMessage& message, Stamp now, DriverOutput& out) {
  if (percent_) {
    percent_ = false;
  } else if (echoes_) {
    echoes_ = false;
    board_.set(ScipTrouble::no_echoes, "the sensor knows no request for several echoes (status " +
                                           std::string(message.status) +
                                           "), each beam has one; set publish_multiecho: false");
  } else if (intensities_) {
    intensities_ = false;
    board_.set(ScipTrouble::no_intensities, "the sensor knows no request for intensities (status " +
                                                std::string(message.status) +
                                                "), scans come without; set publish_intensity: false");
  } else {
    board_.set(ScipTrouble::refused, explain_status(message.command(), message.status));
    return wait(before_next_try, now);
  }
  start(now, out);
}

void ScipDialogue::restart_stream(Stamp now, DriverOutput& out) {
  if (step_ != Step::streaming || now - restarted_ < before_next_try) return;
  restarted_ = now;
  go(Step::quit, now, out);
}

void ScipDialogue::reexamine(Stamp now, DriverOutput& out) {
  if (step_ != Step::streaming || now - restarted_ < before_next_try) return;
  introduced_ = false;
  without_percent_ = true;
  restart_stream(now, out);
}

void ScipDialogue::compare_again(Stamp now, DriverOutput& out) {
  if (step_ != Step::streaming) return;
  compare_only_ = true;
  restarted_ = now;
  go(Step::quit, now, out);
}

void ScipDialogue::tick(Stamp now, DriverOutput& out) {
  if (step_ == Step::idle) return;
  sent_ = std::min(sent_, now);  // the clock was set back
  if (now - sent_ > patience_) overdue(now, out);
}

void ScipDialogue::overdue(Stamp now, DriverOutput& out) {
  if (step_ == Step::waiting) return go(Step::quit, now, out);
  if (step_ == Step::compare) return go(Step::leave_time_mode, now, out);
  if (step_ == Step::streaming && stalls_++ == 0) return go(Step::quit, now, out);
  board_.set(
      ScipTrouble::silent,
      step_ == Step::streaming || introduced_
          ? "the sensor stopped sending; the connection is made again: if it does not come back, switch "
            "its power off and on"
          : "the sensor takes the connection but does not answer " + std::string(expected_) +
                "; end other programs that are connected to it (it serves one at a time), or switch "
                "its power off and on");
  step_ = Step::idle;
  out.disconnect(true);
}

}  // namespace lidard::hokuyo
