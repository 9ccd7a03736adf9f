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

/// The answer to a request. If the server of a small device breaks off, there is a status, a part of the body
/// and an error; the caller decides whether the part is enough.
struct HttpAnswer {
  unsigned status = 0;    ///< 0: no header was received
  std::string body;       ///< as received
  bool complete = false;  ///< the answer has ended
  std::string error;      ///< why it is incomplete; empty: complete, or more may arrive
};

/// A request of HTTP/1.1 after which the connection is closed. `host` as from Endpoint::to_string(). An empty
/// `form` means GET, otherwise POST of the form.
std::string http_request(const std::string& host, const std::string& path, const std::string& form);

/// Parses the bytes received so far; `ended`: the device closed the connection. Accepts HTTP/1.0, answers
/// without a length, and lengths that are too large.
HttpAnswer read_http_answer(std::string_view bytes, bool ended);

/// Pauses and time limits of the dialogue. The web servers of these sensors are slow and lose requests that
/// come faster than one per second.
struct WebTiming {
  Span pace = std::chrono::seconds(1);    ///< between the end of a request and the next one
  Span limit = std::chrono::seconds(5);   ///< for one request
  Span settle = std::chrono::seconds(2);  ///< between writing and reading back
  /// Between two readings, which find that a sensor was replaced, restarted or set by hand.
  Span period = std::chrono::seconds(10);
};

/// The state of a sensor according to its web interface.
struct WebState {
  VelodyneTree tree;                 ///< last report; empty while the sensor does not answer
  std::string serial;                ///< kept while it does not answer
  std::string trouble;               ///< failure of the requests with the remedy; empty: none
  bool answered = false;             ///< a usable answer was received
  std::string local_address;         ///< this host's address on the connection
  std::vector<std::string> refused;  ///< changes that the sensor did not apply, "rpm: 600 -> 1200"
  std::vector<std::string> unknown;  ///< wanted settings that the sensor does not report
  std::uint64_t requests = 0, failures = 0, writes = 0;
};

/// The dialogue with a Velodyne's web interface (TCP 80): reads settings and state every WebTiming::period
/// and, if allowed, writes different settings. It never gives up and makes one request at a time, each with
/// its own connection, since the sensor closes it.
class WebDialogue {
 public:
  explicit WebDialogue(const VelodyneControl& control, const WebTiming& timing = {});

  void connected(Stamp now, FrameReceiver& out);
  /// The connection ended or was refused.
  void disconnected();
  /// Bytes from the sensor.
  void receive(const Packet& packet, FrameReceiver& out);
  void tick(Stamp now, FrameReceiver& out);

  const WebState& state() const { return state_; }

 private:
  enum class Phase : std::uint8_t { pausing, waiting, dialling, talking, answered };

  void script(FrameReceiver& out);
  void request(const std::string& path, const std::string& form = {});
  void dial(FrameReceiver& out);
  void pause(Span time) { phase_ = Phase::pausing, patience_.start(now_, time); }
  bool parse_answer(const std::string& path, const std::string& prefix);
  void finish_reading();
  void finish_write(FrameReceiver& out);

  const VelodyneControl control_;
  const WebTiming timing_;
  const std::string where_;
  boost::asio::coroutine script_;
  Phase phase_ = Phase::pausing;
  Patience patience_;  // of the pause, or of the request
  Patience pace_;
  Stamp now_{};
  std::string request_;
  bool present_ = true;  // the last connection succeeded
  std::string received_;
  HttpAnswer answer_;
  WebState state_;
  VelodyneTree tree_;             // of the current round of requests
  bool snapshot_is_new_ = false;  // the snapshot of this round was answered
  bool complete_ = false;         // all requests of this round were
  std::vector<VelodyneChange> changes_;
  std::size_t change_ = 0;               // index of the change being written
  std::map<std::string, int> attempts_;  // by request
};

}  // namespace lidard::velodyne
