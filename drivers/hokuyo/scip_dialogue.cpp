// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/scip_dialogue.h"

#include <algorithm>
#include <boost/asio/yield.hpp>

#include "drivers/model.h"

namespace lidard::hokuyo {
namespace {

/// Sensors answer within some ms; UTM-30LX-EW needs longer for QT while its last scan is on the way.
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

void ScipDialogue::connected(Stamp now, FrameReceiver& out) {
  introduced_ = compare_only_ = without_percent_ = false;
  patience_ = {};
  stalls_ = 0;
  echoes_ = config_.publish_multiecho && config_.model->has(Trait::echoes);
  intensities_ = config_.publish_intensity;
  board_.clear(ScipTrouble::no_echoes);
  board_.clear(ScipTrouble::no_intensities);
  begin_script(now, out);
}

/// From any state of the sensor to its stream. Continues after each `yield` with the answer; a comparison
/// also without one.
// NOLINTNEXTLINE(readability-function-size): the steps of one dialogue are one coroutine.
void ScipDialogue::script(FrameReceiver& out) {
  reenter(script_) {
    comparing_ = false;
    yield ask("QT\n", out);
    if (!introduced_) {
      // In time mode QT is unknown to some firmware.
      if (class_of(answer_->status) == StatusClass::unknown) {
        yield ask("TM2\n", out);
      }
      yield ask("VV\n", out);
      percent_ = owner_.knows_percent() && !without_percent_;
      yield ask("PP\n", out);
      yield ask("II\n", out);
    }
    // Answers that come late say nothing of the clock.
    if (introduced_ ? compare_only_ : config_.requests.calibrate_time && !patience_.is_slow()) {
      yield ask("TM0\n", out);
      // 02: it is in that mode already (Hokuyo C-42-03320B p. 15). Soon after power-up it refuses.
      comparing_ = answer_->status == "00" || answer_->status == "02";
    }
    if (comparing_) {
      comparisons_ = 0;
      do {
        yield ask(percent_ ? "%TM1\n" : "TM1\n", out, time_patience);
      } while (answer_ != nullptr && !is_compared());
      comparing_ = false;
      yield ask("TM2\n", out);
    }
    start(out);
  }
}

void ScipDialogue::ask(std::string_view request, FrameReceiver& out) { ask(request, out, answer_patience); }

void ScipDialogue::ask(std::string_view request, FrameReceiver& out, Span patience) {
  step_ = Step::asking;
  question_ = request;
  patience_.start_answer(now_, patience);
  asked_ = out.leaves(now_);
  out.request(ByteView(request));
}

void ScipDialogue::start(FrameReceiver& out) {
  introduced_ = true;
  compare_only_ = false;
  step_ = Step::starting;
  patience_.start_answer(now_, answer_patience);
  ScipScanRequest request = owner_.wanted();
  request.percent = percent_;
  request.continuous = true;
  request.multi_echo = echoes_;
  request.intensities = intensities_;
  turn_s_ = config_.model->frame_period * (1 + request.skip);
  out.request(ByteView(write_scan_request(request, request_)));
}

Span ScipDialogue::stream_patience() const {
  return std::max(least_stream_patience, span_from_seconds(5 * turn_s_));
}

void ScipDialogue::receive(const ScipMessage& message, Stamp now, FrameReceiver& out) {
  if (step_ == Step::idle) return;
  now_ = now;
  if (parse_scan_request(message.echo)) return follow_stream(message, out);
  if (step_ != Step::asking) return;
  if (patience_.is_slow()) patience_.start_answer(now, answer_patience);
  if (!expects(message)) return;
  answer_ = &message;
  script(out);
  answer_ = nullptr;
}

bool ScipDialogue::expects(const ScipMessage& message) const {
  const std::string_view wanted = unmarked(expected());
  return unmarked(message.echo).substr(0, wanted.size()) == wanted;
}

/// True if no further comparison of the clocks is needed.
bool ScipDialogue::is_compared() {
  if (percent_ && class_of(answer_->status) == StatusClass::unknown) {
    percent_ = false;
    return false;
  }
  const auto stamp = parse_time(*answer_);
  return !stamp || owner_.compared(*stamp, asked_, now_) || ++comparisons_ >= most_comparisons;
}

void ScipDialogue::follow_stream(const ScipMessage& message, FrameReceiver& out) {
  if (step_ != Step::starting && step_ != Step::streaming) return;
  switch (class_of(message.status)) {
    case StatusClass::data:
      stalls_ = 0;
      [[fallthrough]];
    case StatusClass::accepted:
    case StatusClass::resumed:
      step_ = Step::streaming;
      patience_.start(now_, stream_patience());
      for (const auto gone : {ScipTrouble::silent, ScipTrouble::refused, ScipTrouble::fault})
        board_.clear(gone);
      return;
    case StatusClass::verifying:
      board_.set(ScipTrouble::fault, explain_status(message.command(), message.status));
      patience_.start(now_, verifying_patience);
      return;
    case StatusClass::fault:
      board_.set(ScipTrouble::fault, explain_status(message.command(), message.status), Severity::fault);
      return wait(before_next_try);
    case StatusClass::unknown:
      return ask_for_less(message, out);
    case StatusClass::refused:
      board_.set(ScipTrouble::refused, explain_status(message.command(), message.status));
      return wait(before_next_try);
  }
}

/// The sensor does not know this request: asks without the extension, then without echoes, at last without
/// intensities. A warning reports what is missing.
void ScipDialogue::ask_for_less(const ScipMessage& message, FrameReceiver& out) {
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
    return wait(before_next_try);
  }
  start(out);
}

void ScipDialogue::restart_stream(Stamp now, FrameReceiver& out) {
  if (step_ != Step::streaming || now - restarted_ < before_next_try) return;
  restarted_ = now;
  begin_script(now, out);
}

void ScipDialogue::reexamine(Stamp now, FrameReceiver& out) {
  if (step_ != Step::streaming || now - restarted_ < before_next_try) return;
  introduced_ = false;
  without_percent_ = true;
  restart_stream(now, out);
}

void ScipDialogue::compare_again(Stamp now, FrameReceiver& out) {
  if (step_ != Step::streaming) return;
  compare_only_ = true;
  restarted_ = now;
  begin_script(now, out);
}

void ScipDialogue::tick(Stamp now, FrameReceiver& out) {
  now_ = now;
  if (step_ != Step::idle && patience_.is_over(now)) overdue(out);
}

void ScipDialogue::overdue(FrameReceiver& out) {
  if (step_ == Step::waiting) return begin_script(now_, out);
  if (step_ == Step::asking && comparing_) return script(out);
  if (step_ == Step::streaming && stalls_++ == 0) return begin_script(now_, out);
  board_.set(
      ScipTrouble::silent,
      step_ == Step::streaming || introduced_
          ? "the sensor stopped sending; the connection is made again: if it does not come back, switch "
            "its power off and on"
          : "the sensor takes the connection but does not answer " + std::string(expected()) +
                "; end other programs that are connected to it (it serves one at a time), or switch "
                "its power off and on");
  if (stalls_ == 0 && patience_.extend(now_)) {
    if (step_ == Step::asking) out.request(ByteView(question_));
    return;
  }
  step_ = Step::idle;
  out.disconnect(true);
}

}  // namespace lidard::hokuyo
