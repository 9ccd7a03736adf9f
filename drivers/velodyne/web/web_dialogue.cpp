// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/web_dialogue.h"

#include <algorithm>
#include <utility>

namespace lidard::velodyne {
namespace {

constexpr const char* snapshot = "/cgi/snapshot.hdl";
/// More than any answer with its header.
constexpr std::size_t most_received = 128 * 1024UL;

constexpr Span answer_limit = std::chrono::seconds(5);
/// Between the end of a request and the next one: these web servers are slow and lose faster requests.
constexpr Span pace = std::chrono::seconds(1);
/// Between writing and reading back.
constexpr Span settling = std::chrono::seconds(2);

std::string list_of(const std::vector<std::string>& items) {
  std::string list;
  for (const std::string& item : items) list += (list.empty() ? "" : ", ") + item;
  return list;
}

/// Why an answer has no settings, with the remedy.
std::string trouble_of(const std::string& asked, const HttpAnswer& answer) {
  if (answer.status != 0 && answer.status != 200)
    return asked + " answers with HTTP status " + std::to_string(answer.status) +
           "; is this the configured sensor?";
  if (!answer.error.empty()) return asked + ": " + answer.error + "; the sensor may be busy or restarting";
  return asked + " does not answer with a JSON object; is this the configured sensor?";
}

}  // namespace

/// It is repeated while there is no data, since a sensor that restarted may send them elsewhere.
WebDialogue::WebDialogue(const VelodyneControl& control)
    : SideDialogue(true, true, answer_limit),
      control_(control),
      where_(Endpoint{control.address, control.port}.to_string()) {
  pause_ = pace;
}

/// One request: the next change, or the settings.
void WebDialogue::script(FrameReceiver& out) {
  if (changes_.empty()) return ask(ByteView(http_request(where_, snapshot, {})), out);
  const VelodyneChange& change = changes_.front();
  if (!refused_) out.note("writes " + change.text + " to " + where_);
  ask(ByteView(http_request(where_, change.path, change.body)), out);
}

void WebDialogue::receive(const Packet& packet, FrameReceiver& out) {
  if (!is_talking()) return;
  now_ = packet.arrival;
  const std::size_t room = most_received - received_.size();
  received_.append(packet.payload.text().substr(0, room));
  const HttpAnswer answer = read_http_answer(received_, received_.size() == most_received);
  if (answer.complete) hang_up(accept(answer), out);
}

void WebDialogue::silent(FrameReceiver& out) {
  HttpAnswer none;
  none.error = "no answer in time";
  hang_up(accept(none), out);
}

/// Whatever the answer to a change, the next comparison shows whether the sensor applied it.
SideDialogue::End WebDialogue::accept(const HttpAnswer& answer) {
  if (changes_.empty()) return compare(answer);
  changes_.erase(changes_.begin());
  wrote_ = true;
  pause_ = changes_.empty() ? settling : pace;
  return End::goes_on;
}

SideDialogue::End WebDialogue::compare(const HttpAnswer& answer) {
  // An answer with a wrong length is accepted if its JSON is complete.
  auto found = answer.status == 200 ? plan(answer.body, control_.wanted) : std::nullopt;
  if (!found) {
    set_warnings({trouble_of(where_ + snapshot, answer)});
    return End::failed;
  }
  info_.serial = found->serial;
  const bool wrote = std::exchange(wrote_, false);
  if (found->changes.empty()) {
    refused_ = false;
    std::vector<std::string> warnings;
    if (!found->unknown.empty())
      warnings.push_back("the sensor does not report " + list_of(found->unknown) +
                         ", so it is not written; remove it from control");
    set_warnings(std::move(warnings));
    detail("Settings", "compared with control");
    return End::complete;
  }
  if (!wrote) {
    changes_ = std::move(found->changes);
    pause_ = pace;
    return End::goes_on;
  }
  refused_ = true;
  std::vector<std::string> refused;
  for (const VelodyneChange& change : found->changes) refused.push_back(change.text);
  set_warnings({"the sensor did not apply " + list_of(refused) +
                "; set it in the sensor's web page, or remove it from control"});
  return End::failed;
}

}  // namespace lidard::velodyne
