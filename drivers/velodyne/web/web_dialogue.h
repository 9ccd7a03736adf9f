// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "drivers/dialogue.h"
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

/// The dialogue with a Velodyne's web interface (TCP 80): reads the settings, writes those that differ from
/// the wanted ones, and reads them again. Each request has a connection of its own, since the sensor closes
/// it.
class WebDialogue final : public SideDialogue {
 public:
  explicit WebDialogue(const VelodyneControl& control);

  void receive(const Packet& packet, FrameReceiver& out) override;

 private:
  void begin() override { received_.clear(); }
  void script(FrameReceiver& out) override;
  void silent(FrameReceiver& out) override;
  End cut_off() override { return accept(read_http_answer(received_, true)); }
  End accept(const HttpAnswer& answer);
  End compare(const HttpAnswer& answer);

  const VelodyneControl control_;
  const std::string where_;
  std::string received_;
  std::vector<VelodyneChange> changes_;  // not written yet
  bool wrote_ = false;                   // since the settings were last compared
  bool refused_ = false;                 // settings differed after they were written
};

}  // namespace lidard::velodyne
