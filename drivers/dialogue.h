// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <boost/asio/coroutine.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "drivers/driver.h"

namespace lidard {

/// A time limit for the answer to a question or for a pause.
class Patience {
 public:
  /// The longest time for an answer, for slow devices.
  static constexpr Span most = std::chrono::seconds(10);

  void start(Stamp now, Span limit) { since_ = now, limit_ = limit; }
  /// Starts the limit of an answer that usually comes within `limit`.
  void start_answer(Stamp now, Span limit) { start(asked_ = now, slow_ ? most : limit); }
  /// True if the limit has passed. A clock that was set back restarts the limit.
  bool is_over(Stamp now) {
    since_ = std::min(since_, now);
    return now - since_ > limit_;
  }
  /// Extends the limit of this and all further answers to `most`, for a slow device, so that the question can
  /// be repeated. False: the limit was `most` already.
  bool extend(Stamp now) {
    if (now - asked_ >= most) return false;
    start(now, std::min(2 * limit_, asked_ + most - now));
    return slow_ = true;
  }
  bool is_slow() const { return slow_; }

 private:
  Stamp since_{}, asked_{};
  Span limit_{0};
  bool slow_ = false;
};

/// A dialogue with a device: a script that asks one question at a time and continues with its answer.
class Dialogue {
 public:
  virtual ~Dialogue() = default;
  /// The data read from the device, with warnings.
  const DeviceInfo& info() const { return info_; }
  /// True once after info() changed.
  bool changed() { return std::exchange(changed_, false); }

 protected:
  virtual void script(FrameReceiver& out) = 0;

  void begin_script(Stamp now, FrameReceiver& out) {
    now_ = now;
    script_ = {};
    script(out);
  }
  static void send(const std::vector<std::uint8_t>& question, FrameReceiver& out) {
    out.request(ByteView(question.data(), question.size()));
  }
  void detail(std::string_view key, std::string_view value) {
    info_.set(key, value);
    changed_ = true;
  }
  void set_warnings(std::vector<std::string> sentences) {
    changed_ = changed_ || sentences != info_.warnings;
    info_.warnings = std::move(sentences);
  }

  boost::asio::coroutine script_;
  Stamp now_{};
  Patience patience_;  ///< with the last question
  DeviceInfo info_;
  bool changed_ = false;
};

/// A dialogue over a TCP connection beside a stream of datagrams: reads, compares and writes allowed
/// settings, then disconnects. It runs once, and again after the stream stopped, since the device may have
/// lost its settings, or may be another one.
class SideDialogue : public Dialogue {
 public:
  /// `wanted`: the dialogue runs. `restores`: it can start the stream, so it is repeated while there is none.
  SideDialogue(bool wanted, bool restores, Span patience)
      : wanted_(wanted), restores_(restores), patience_limit_(patience) {}

  void connected(Stamp now, FrameReceiver& out) {
    phase_ = Phase::talking;
    talked_ = true;
    begin();
    begin_script(now, out);
  }
  /// Bytes from the device.
  virtual void receive(const Packet& packet, FrameReceiver& out) = 0;
  /// The connection ended, or was refused.
  void disconnected() {
    if (phase_ == Phase::talking) end(cut_off());
    phase_ = Phase::idle;
  }
  /// `last_data`: when the device last sent a datagram of its data; empty: never.
  void tick(Stamp now, std::optional<Stamp> last_data, FrameReceiver& out) {
    now_ = now;
    if (phase_ == Phase::talking && patience_.is_over(now)) {
      // The device may be slow: the next dialogue waits longer.
      patience_limit_ = std::min(2 * patience_limit_, Patience::most);
      return silent(out);
    }
    if (last_data && last_data_ && *last_data > *last_data_) interval_ = *last_data - *last_data_;
    last_data_ = last_data;
    if (phase_ != Phase::idle || !is_due()) return;
    last_dial_ = now;
    talked_ = false;
    phase_ = Phase::dialling;
    out.connect();
  }

 protected:
  /// How a connection ended: every possible step was done; the dialogue is repeated after a growing pause; or
  /// the next connection continues it.
  enum class End : std::uint8_t { complete, failed, goes_on };

  /// A connection was made: drops the state of a former one.
  virtual void begin() = 0;
  /// The last question was not answered.
  virtual void silent(FrameReceiver& out) = 0;
  /// The device closed the connection in the middle of the dialogue.
  virtual End cut_off() = 0;

  bool is_talking() const { return phase_ == Phase::talking; }
  void ask(ByteView question, FrameReceiver& out) {
    patience_.start(now_, patience_limit_);
    out.request(question);
  }
  void hang_up(End how, FrameReceiver& out) {
    end(how);
    out.disconnect(false);
  }

  Span pause_ = std::chrono::milliseconds(500);  ///< before another connection if none has failed

 private:
  enum class Phase : std::uint8_t { idle, dialling, talking };

  void end(End how) {
    end_ = how;
    ended_ = now_;
    phase_ = Phase::idle;
  }
  bool is_due() {
    /// After this silence the device may have lost its settings.
    const Span silence = std::max<Span>(std::chrono::seconds(1), 3 * interval_);
    const bool stopped = !last_data_ || now_ - *last_data_ > silence;
    if (stopped && last_data_ && *last_data_ > ended_) end_.reset();
    const bool complete = end_ == End::complete;
    if (!wanted_ || (complete && !(restores_ && stopped))) return false;
    const bool in_vain = complete && (!last_data_ || *last_data_ < last_dial_);
    if (!talked_ || !(end_ == End::failed || in_vain)) {
      if (end_ != End::goes_on) fruitless_pause_ = first_fruitless_pause;
      return !last_dial_ || now_ - std::max(*last_dial_, ended_) >= pause_;
    }
    if (now_ - ended_ < fruitless_pause_) return false;
    fruitless_pause_ = std::min<Span>(2 * fruitless_pause_, std::chrono::seconds(60));
    return true;
  }

  /// After a dialogue that failed or did not restart the stream; twice as long after each further one, since
  /// another client may wait for the connection, and wrong passwords may lock the device.
  static constexpr Span first_fruitless_pause = std::chrono::seconds(5);
  const bool wanted_, restores_;
  Span patience_limit_;
  Phase phase_ = Phase::idle;
  std::optional<Stamp> last_dial_, last_data_;
  Span interval_{0};  // between data, when last there were any
  Span fruitless_pause_ = first_fruitless_pause;
  bool talked_ = false;     // the last attempt to connect succeeded
  std::optional<End> end_;  // of the last connection; empty: none since the stream stopped
  Stamp ended_{};           // when it ended
};

}  // namespace lidard
