// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/coroutine.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/driver.h"
#include "drivers/velodyne/web/velodyne_settings.h"

namespace lidard::velodyne {

/// What came back on a request. A small device's server may break off in the middle: then there is a status,
/// some of the body and an error, and the caller knows whether that is enough.
struct HttpAnswer {
  unsigned status = 0;    ///< 0: no header came
  std::string body;       ///< as much as came
  bool complete = false;  ///< nothing more belongs to it
  std::string error;      ///< why it is not whole; empty: it is, or more may come
};

/// A request of HTTP/1.1 after which the connection is closed. `host` as Endpoint::to_string() has it. An
/// empty `form`: GET, else POST of that form.
std::string http_request(const std::string& host, const std::string& path, const std::string& form);

/// Reads what came on a connection so far; `ended`: the device closed it. Accepts HTTP/1.0, answers without a
/// length, and lengths that are too large.
HttpAnswer read_http_answer(std::string_view bytes, bool ended);

/// Pauses and time limits of the dialogue. The web servers of these sensors are slow, and lose requests that
/// come faster than one per second.
struct WebTiming {
  Span pace = std::chrono::seconds(1);   ///< between the end of a request and the begin of the next
  Span limit = std::chrono::seconds(5);  ///< for one request
  Span settle = std::chrono::seconds(2);  ///< between writing and reading the setting back
  /// Between two readings: a sensor that was replaced, restarted or set by hand is noticed by them.
  Span period = std::chrono::seconds(10);
  Span first_retry = std::chrono::seconds(1);  ///< doubled after each failure in a row
  Span last_retry = std::chrono::seconds(60);
  Span spin_up = std::chrono::seconds(30);  ///< after a change of the speed
};

/// What is known of a sensor through its web interface.
struct WebState {
  VelodyneTree tree;                 ///< as last reported; empty while the sensor does not answer
  std::string serial;                ///< kept while it does not answer
  std::string trouble;               ///< what is wrong with asking and the remedy; empty: all is answered
  bool answered = false;             ///< anything usable so far
  std::string local_address;         ///< ours, as the sensor sees it
  std::vector<std::string> refused;  ///< changes that the sensor did not take, "rpm: 600 -> 1200"
  std::vector<std::string> unknown;  ///< wanted settings that it does not report
  bool settling = false;             ///< a change was written lately: the motor may still follow
  std::uint64_t requests = 0, failures = 0, writes = 0;
};

/// The dialogue with a Velodyne's web interface (TCP 80): reads its settings and state every
/// WebTiming::period and, where the configuration allows it, writes the settings that differ. Never gives up,
/// and never makes more than one request at a time; each has a connection of its own, since the sensor closes
/// it.
class WebDialogue {
 public:
  explicit WebDialogue(const VelodyneControl& control, const WebTiming& timing = {});

  void connected(Stamp now, DriverOutput& out);
  /// The connection ended, or was not taken.
  void disconnected();
  /// Bytes from the sensor.
  void receive(const Packet& packet, DriverOutput& out);
  void tick(Stamp now, DriverOutput& out);

  WebState state() const;

 private:
  enum class Phase : std::uint8_t { pausing, waiting, dialling, talking, answered };

  void script(DriverOutput& out);
  void request(const std::string& path, const std::string& form = {});
  void dial(DriverOutput& out);
  void pause(Span time) { phase_ = Phase::pausing, patience_.start(now_, time); }
  Span next_pause();
  bool parse_answer(const std::string& path, const std::string& prefix);
  void finish_reading();
  void finish_write(DriverOutput& out);
  void report_verified(DriverOutput& out);

  const VelodyneControl control_;
  const WebTiming timing_;
  const std::string where_;
  boost::asio::coroutine script_;
  Phase phase_ = Phase::pausing;
  Patience patience_;  // of the pause, or of the request
  Patience pace_;
  Stamp now_{};
  std::string request_;
  bool present_ = true;  // the last connection was accepted
  std::string received_;
  HttpAnswer answer_;
  WebState state_;
  VelodyneTree tree_;  // of this round of questions
  bool snapshot_is_new_ = false;
  bool complete_ = false;  // everything was answered in this round
  std::vector<VelodyneChange> changes_;
  std::size_t change_ = 0;               // of those the one that is written
  std::map<std::string, int> attempts_;  // by request
  bool unverified_ = false;              // something was written and not seen in a snapshot yet
  Span retry_;
  Stamp last_write_{};
};

}  // namespace lidard::velodyne
