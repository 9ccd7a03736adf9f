// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/driver_base.h"
#include "drivers/hokuyo/scip_clock.h"
#include "drivers/hokuyo/scip_message.h"

namespace lidard::hokuyo {

enum class ScipTrouble : std::uint8_t {
  silent,
  refused,
  fault,
  no_echoes,
  no_intensities,
  parameters,
  model,
  device,
  geometry,
  no_beams,
  values,
  unfit,
  count_
};

/// The dialogue of a connection from the first request to the endless stream, and back to it after trouble.
///
/// By default it sends only what a stream needs: QT (ends the stream of a former client), VV, PP and II
/// (identity), TM0, TM1 and TM2 (clock), and the request itself. It changes no setting of the sensor.
class ScipDialogue final : public Dialogue {
 public:
  /// The driver that knows the sensor.
  class Owner {
   public:
    virtual ~Owner() = default;
    /// The steps, cluster and skip to ask for.
    virtual ScipScanRequest wanted() = 0;
    /// True if the sensor's firmware knows the % extension, as far as is known.
    virtual bool knows_percent() const = 0;
    /// Receives a comparison of the clocks; true if no more are needed.
    virtual bool compared(ScipStamp stamp, Stamp sent, Stamp received) = 0;
  };

  ScipDialogue(Owner& owner, WarningBoard<ScipTrouble>& board, const DriverConfig& config)
      : owner_(owner), board_(board), config_(config) {}

  void connected(Stamp now, FrameReceiver& out);
  void disconnected() { step_ = Step::idle; }
  bool active() const { return step_ != Step::idle; }
  bool streaming() const { return step_ == Step::streaming; }
  /// Every answer, too; `now`: its arrival.
  void receive(const ScipMessage& message, Stamp now, FrameReceiver& out);
  void tick(Stamp now, FrameReceiver& out);
  /// Ends the stream and asks for it again, at most once a second.
  void restart_stream(Stamp now, FrameReceiver& out);
  /// No answer of the stream fits: asks for the identity again, and for a stream without the % extension.
  void reexamine(Stamp now, FrameReceiver& out);
  /// Ends the stream, compares the clocks again and goes on.
  void compare_again(Stamp now, FrameReceiver& out);

 private:
  enum class Step : std::uint8_t { idle, asking, starting, streaming, waiting };

  void script(FrameReceiver& out) override;
  void ask(std::string_view request, FrameReceiver& out, Span patience);
  void ask(std::string_view request, FrameReceiver& out);
  bool expects(const ScipMessage& message) const;
  /// "QT", "TM0", "%TM"
  std::string_view expected() const { return question_.substr(0, question_.size() == 3 ? 2 : 3); }
  bool is_compared();
  void follow_stream(const ScipMessage& message, FrameReceiver& out);
  void ask_for_less(const ScipMessage& message, FrameReceiver& out);
  void wait(Span time) { step_ = Step::waiting, patience_.start(now_, time); }
  void start(FrameReceiver& out);
  void overdue(FrameReceiver& out);
  Span stream_patience() const;

  Owner& owner_;
  WarningBoard<ScipTrouble>& board_;
  const DriverConfig& config_;
  Step step_ = Step::idle;
  std::string_view question_;            // the last one; patience_ is with it, or with the stream
  const ScipMessage* answer_ = nullptr;  // to the last question; nullptr: none came
  bool introduced_ = false;              // VV, PP, II and TM are done
  bool compare_only_ = false;
  bool comparing_ = false;
  bool without_percent_ = false;  // since connected(): no answer fitted with it
  bool percent_ = false, echoes_ = false, intensities_ = false;
  int comparisons_ = 0;
  int stalls_ = 0;
  Stamp restarted_, asked_;
  double turn_s_ = 0;
  std::vector<char> request_;
};

}  // namespace lidard::hokuyo
