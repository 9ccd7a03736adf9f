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
#include "drivers/sick/cola/sopas_session.h"

namespace lidard::sick {

/// LMDscandatacfg: the contents of the device's scans (SICK 8014631 chapter 4.3.1).
struct ColaContents {
  /// One byte each: echoes (bit by echo; two bytes), intensity, intensity of 16 bits, its unit, encoders (two
  /// bytes), position, name, comment, time.
  std::array<std::uint8_t, 11> contents{};
  std::uint16_t interval = 1;  ///< every n-th scan

  static constexpr std::size_t echoes = 0, intensity = 2, wide_intensity = 3;
  /// Bit of `intensity`; the others switch angles (2) and quality (4) on (SICK 8027168, LMS4000, p. 88).
  static constexpr std::uint8_t with_intensity = 1;

  friend bool operator==(const ColaContents& a, const ColaContents& b) {
    return a.contents == b.contents && a.interval == b.interval;
  }
};

/// Starts a device's stream of scans: reads DeviceIdent, LMPoutputRange, LMDscandatacfg and, from a NAV,
/// MCAngleCompSin, then subscribes to InertialMeasurementUnit (models that have one) and LMDscandata; beside
/// the stream it reads LCMstate (models that have it). Settings are written only if they differ from the
/// configuration and writing is allowed.
class ColaDialogue final : public Dialogue {
 public:
  ColaDialogue(const DriverConfig& config, const ColaRow& row)
      : config_(config), row_(row), session_(ColaDialect::b, config.requests, row.login, row.password) {}

  void connected(Stamp now, FrameReceiver& out);
  void disconnected();
  /// Accepts a telegram that is not an event.
  void receive(const ColaTelegram& telegram, Stamp now, FrameReceiver& out);
  /// Reports the arrival of a scan in this dialect, whether it can be used or not.
  void scan_came(ColaDialect dialect, Stamp now);
  void tick(Stamp now, FrameReceiver& out);

 private:
  enum class Phase : std::uint8_t { idle, asking, waiting_for_scan, streaming };
  /// `needed`: a missing answer means that a configured request failed; `dispensable`: it means nothing.
  enum class Answer : std::uint8_t { needed, dispensable };

  void script(FrameReceiver& out) override;
  void ask(std::string_view command, Answer answer, FrameReceiver& out);
  void ask(std::string_view command, FrameReceiver& out) { ask(command, Answer::needed, out); }
  void send_question(FrameReceiver& out);
  bool can_login() const;
  /// Longest time between two scans of the stream.
  Span stream_patience() const;
  /// True if the last question was answered and not refused.
  bool was_done() const { return answer_ != nullptr && !refused_; }
  void note_refusal(std::uint8_t code);
  void note_missing(std::string warning, const std::string& remark);
  void note_login();
  void note_identity();
  void read_settings();
  void compare_settings();
  void note_written(FrameReceiver& out);
  void give_up(FrameReceiver& out);
  void warn(std::string sentence) { found_.push_back(std::move(sentence)); }
  void show_warnings() { set_warnings(found_); }
  void change_dialect();

  const DriverConfig config_;
  const ColaRow& row_;
  SopasSession session_;
  bool dialect_known_ = false;
  bool answered_ = false;  // in this connection
  bool scans_ = false;     // scans came before the end of the questions, in this connection
  Phase phase_ = Phase::idle;
  std::string_view question_;  // the last command
  Answer expected_ = Answer::needed;
  const ColaTelegram* answer_ = nullptr;  // to the last question; nullptr: no answer
  bool refused_ = false;                  // the last answer was a refusal
  bool logged_in_ = false;
  bool contamination_refused_ = false;
  Stamp contamination_asked_{};
  std::optional<ColaContents> settings_, wanted_;
  std::vector<std::string> found_;  // warnings of this attempt
};

}  // namespace lidard::sick
