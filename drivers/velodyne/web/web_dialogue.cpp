// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/web_dialogue.h"

#include <algorithm>
#include <boost/asio/yield.hpp>
#include <utility>

namespace lidard::velodyne {
namespace {

/// After this number of writes a setting counts as refused; reset when the sensor was unreachable or has all
/// settings. Without an answer to a write the next snapshot shows whether the sensor applied the change.
constexpr int most_attempts = 3;
/// More than any answer with its header.
constexpr std::size_t most_received = 128 * 1024UL;

void replace_section(VelodyneTree& tree, const std::string& prefix, const VelodyneTree& section) {
  const auto begin = tree.lower_bound(prefix);
  auto end = begin;
  while (end != tree.end() && end->first.compare(0, prefix.size(), prefix) == 0) ++end;
  tree.erase(begin, end);
  for (const auto& [key, value] : section) tree.emplace(prefix + key, value);
}

}  // namespace

WebDialogue::WebDialogue(const VelodyneControl& control, const WebTiming& timing)
    : control_(control), timing_(timing), where_(Endpoint{control.address, control.port}.to_string()) {}

/// The dialogue. It continues after a `yield` when the request was answered or has failed, or when the pause
/// is over.
void WebDialogue::script(FrameReceiver& out) {
  reenter(script_) {
    for (;;) {
      yield request("/cgi/snapshot.hdl");
      tree_.clear();
      complete_ = snapshot_is_new_ = parse_answer("/cgi/snapshot.hdl", "");
      if (present_) {
        yield request("/cgi/status.json");
        complete_ = parse_answer("/cgi/status.json", "status.") && complete_;
      }
      finish_reading();
      for (change_ = 0; change_ < changes_.size(); ++change_) {
        yield request(changes_[change_].path, changes_[change_].body);
        finish_write(out);
      }
      yield pause(changes_.empty() ? timing_.period : timing_.settle);
    }
  }
}

/// Connects as soon as the pace allows it. An empty form means GET.
void WebDialogue::request(const std::string& path, const std::string& form) {
  request_ = http_request(where_, path, form);
  phase_ = Phase::waiting;
}

void WebDialogue::tick(Stamp now, FrameReceiver& out) {
  now_ = now;
  switch (phase_) {
    case Phase::pausing:
      if (patience_.is_over(now)) script(out);
      return;
    case Phase::waiting:
      if (pace_.is_over(now)) dial(out);
      return;
    case Phase::dialling:
    case Phase::talking:
      if (!patience_.is_over(now)) return;
      answer_.error = "no answer in time";
      out.disconnect(false);
      break;
    case Phase::answered:
      break;
  }
  pace_.start(now, timing_.pace);
  ++state_.requests;
  script(out);
}

void WebDialogue::dial(FrameReceiver& out) {
  phase_ = Phase::dialling;
  patience_.start(now_, timing_.limit);
  answer_ = {};
  received_.clear();
  present_ = false;
  out.connect();
}

void WebDialogue::connected(Stamp now, FrameReceiver& out) {
  now_ = now;
  if (phase_ != Phase::dialling) return out.disconnect(false);
  phase_ = Phase::talking;
  present_ = true;
  out.request(ByteView(request_));
}

void WebDialogue::disconnected() {
  if (phase_ == Phase::talking) answer_ = read_http_answer(received_, true);
  if (phase_ == Phase::dialling) answer_.error = "the connection is refused";
  if (phase_ == Phase::talking || phase_ == Phase::dialling) phase_ = Phase::answered;
}

void WebDialogue::receive(const Packet& packet, FrameReceiver& out) {
  if (phase_ != Phase::talking) return;
  state_.local_address = packet.to.address.to_string();
  const std::size_t room = most_received - received_.size();
  received_.append(reinterpret_cast<const char*>(packet.payload.data()),
                   std::min(packet.payload.size(), room));
  answer_ = read_http_answer(received_, received_.size() == most_received);
  if (!answer_.complete) return;
  phase_ = Phase::answered;
  out.disconnect(false);
}

/// False if the answer is missing or invalid; state_ has the reason.
bool WebDialogue::parse_answer(const std::string& path, const std::string& prefix) {
  // An answer with a wrong length is accepted if its JSON is complete.
  const auto section = answer_.status == 200 ? read_velodyne_json(answer_.body) : std::nullopt;
  if (section) {
    replace_section(tree_, prefix, *section);
    return true;
  }
  ++state_.failures;
  if (!present_)
    state_.trouble =
        "no web interface at " + where_ + ": " + answer_.error + "; check control.port and the network";
  else if (answer_.status != 0 && answer_.status != 200)
    state_.trouble = where_ + path + " answers with HTTP status " + std::to_string(answer_.status) +
                     "; is this the configured sensor?";
  else if (!answer_.error.empty())
    state_.trouble = where_ + path + ": " + answer_.error + "; the sensor may be busy or restarting";
  else
    state_.trouble = where_ + path + " does not answer with a JSON object; is this the configured sensor?";
  return false;
}

void WebDialogue::finish_reading() {
  if (!present_) attempts_.clear();  // it may return with other settings or be another sensor
  state_.tree = tree_;
  if (complete_) state_.trouble.clear();
  state_.answered = state_.answered || !tree_.empty();
  const auto serial = tree_.find("info.serial");
  if (serial != tree_.end()) state_.serial = serial->second;
  changes_.clear();
  if (!snapshot_is_new_ || !control_.allow_write) return;
  VelodynePlan todo = plan(tree_, control_.wanted);
  state_.refused.clear();
  state_.unknown = std::move(todo.unknown);
  if (todo.changes.empty()) attempts_.clear();
  for (VelodyneChange& change : todo.changes) {
    if (attempts_[change.path + change.body] >= most_attempts)
      state_.refused.push_back(change.text);
    else
      changes_.push_back(std::move(change));
  }
}

void WebDialogue::finish_write(FrameReceiver& out) {
  const VelodyneChange& change = changes_[change_];
  ++attempts_[change.path + change.body];
  if (answer_.status >= 200 && answer_.status <= 206)
    out.note("wrote " + change.text + " to " + where_);
  else
    out.note("could not write " + change.text + " to " + where_ + ": " +
             (answer_.status == 0 ? answer_.error : "HTTP status " + std::to_string(answer_.status)));
  ++state_.writes;
}

}  // namespace lidard::velodyne
