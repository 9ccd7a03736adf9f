// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/safety_dialogue.h"

#include <algorithm>
#include <array>

#include "drivers/model.h"

namespace lidard::sick {
namespace {

namespace idx = safety_index;

/// Asked for in this order; the present output comes last, since what follows depends on it.
constexpr std::array<std::uint16_t, 9> variables = {
    idx::type_code,        idx::serial_number,   idx::firmware,    idx::device_name,   idx::project_name,
    idx::application_name, idx::status_overview, idx::user_action, idx::current_output};
/// Changes are made on the first data output channel; microScan3 has but one.
constexpr std::uint8_t channel = 0;
constexpr Span patience = std::chrono::seconds(2);
/// A stream that stopped for so long has lost its volatile settings, or never had them.
constexpr Span silence = std::chrono::seconds(1);
constexpr Span dial_pause = std::chrono::milliseconds(500);
/// The same after a whole dialogue that did not bring the stream back.
constexpr Span fruitless_pause = std::chrono::seconds(5);
constexpr std::uint16_t most_fields = 128;  // indices up to the first geometry, 0x2810
constexpr std::uint16_t most_cases = 254;
/// The session ends by itself after so many seconds without a telegram (SICK 8022708 p. 30 advises 30).
constexpr std::uint8_t session_timeout_s = 30;

std::array<std::uint8_t, 2> le16(std::uint16_t value) {
  return {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U)};
}

const char* label_of(std::uint16_t index) {
  switch (index) {
    case idx::firmware:
      return "Firmware Version";
    case idx::device_name:
      return "Device Name";
    case idx::project_name:
      return "Project Name";
    case idx::application_name:
      return "Application Name";
    default:
      return nullptr;
  }
}

void add_to_list(std::string& list, const std::string& entry) { list += (list.empty() ? "" : "; ") + entry; }

}  // namespace

SafetyDialogue::SafetyDialogue(const DriverConfig& config)
    : requests_(config.requests),
      wanted_(!requests_.listen_only && (requests_.host_address || requests_.skip || requests_.allow_write)),
      product_(config.model->product),
      range_max_(config.model->range_max) {}

void SafetyDialogue::tick(Stamp now, std::optional<Stamp> last_data, DriverOutput& out) {
  now_ = now;
  if (!wanted_) return;
  if (phase_ != Phase::idle) {
    if (phase_ != Phase::dialling && now - phase_since_ > patience)
      fail("does not answer on its TCP port", out);
    return;
  }
  const bool silent = !last_data || now - *last_data > silence;
  const bool due = !complete_ || (requests_.allow_write && silent);
  const bool fruitless = complete_ && (!last_data || *last_data < last_dial_);
  if (!due || (dialled_ && now - last_dial_ < (fruitless ? fruitless_pause : dial_pause))) return;
  dialled_ = true;
  last_dial_ = phase_since_ = now;
  phase_ = Phase::dialling;
  out.connect();
}

void SafetyDialogue::connected(Stamp now, DriverOutput& out) {
  now_ = now;
  stream_.clear();
  session_ = 0;
  step_ = 0;
  phase_ = Phase::opening;
  // Time-out and an identity of the client, which the scanner only repeats in its log.
  const std::array<std::uint8_t, 5> open = {session_timeout_s, 'l', 'd', 'r', 'd'};
  ask('O', 'X', ByteView(open.data(), open.size()), out);
}

void SafetyDialogue::disconnected() {
  stream_.clear();
  phase_ = Phase::idle;
}

void SafetyDialogue::receive(const Packet& packet, DriverOutput& out) {
  now_ = packet.arrival;
  stream_.add(packet.payload);
  Cola2Telegram telegram;
  while (phase_ != Phase::idle && stream_.next(telegram)) answer(telegram, out);
}

void SafetyDialogue::ask(char type, char mode, ByteView data, DriverOutput& out) {
  phase_since_ = now_;
  Cola2Telegram telegram;
  telegram.session = session_;
  telegram.request = ++request_;
  telegram.type = type;
  telegram.mode = mode;
  telegram.data = data;
  const auto bytes = encode_cola2(telegram);
  out.request(ByteView(bytes.data(), bytes.size()));
}

void SafetyDialogue::ask_index(char type, std::uint16_t index, ByteView arguments, DriverOutput& out) {
  index_ = index;
  const auto prefix = le16(index);
  std::vector<std::uint8_t> data(prefix.begin(), prefix.end());
  data.insert(data.end(), arguments.begin(), arguments.end());
  ask(type, 'I', ByteView(data.data(), data.size()), out);
}

void SafetyDialogue::answer(const Cola2Telegram& t, DriverOutput& out) {
  if (t.request != request_) return;  // late, of a request given up
  if (phase_ == Phase::opening) {
    if (!t.is('O', 'A')) return fail("refuses the CoLa 2 session; is another program connected?", out);
    session_ = t.session;
    phase_ = Phase::reading;
    return read_next(out);
  }
  if (phase_ == Phase::closing) {
    complete_ = true;
    phase_ = Phase::idle;
    return out.disconnect(false);
  }
  // Both kinds of answers repeat the index; a refusal does not.
  const bool refused = t.type == 'F';
  const ByteView value = !refused && t.data.has(0, 2) ? t.data.from(2) : ByteView();
  switch (phase_) {
    case Phase::reading:
      take_variable(index_, value);
      if (index_ == idx::current_output) return compare(out);
      return read_next(out);
    case Phase::changing:
      return changed(value, out);
    case Phase::verifying:
      return verify(value, out);
    default:
      return browse(value, out);
  }
}

void SafetyDialogue::read_next(DriverOutput& out) {
  if (step_ == 0) {
    details_.clear();
    warnings_.clear();
    ++version_;
  }
  ask_index('R', variables[step_++], {}, out);
}

void SafetyDialogue::take_variable(std::uint16_t index, ByteView value) {
  if (index == idx::type_code) {
    type_code_ = read_text(value);
    set_detail("Type Code", type_code_);
    const double range = range_of(type_code_);
    if (range > 0 && range != range_max_)
      warn("type code " + type_code_ + " is that of a scanner for " +
           std::to_string(static_cast<int>(range)) + " m, but " + product_ +
           " is configured; choose the model with that range");
  } else if (index == idx::serial_number) {
    serial_ = read_text(value);
  } else if (index == idx::status_overview) {
    set_detail("Status", describe_status(value));
  } else if (index == idx::user_action) {
    const std::string action = describe_action(value);
    set_detail("Required User Action", action);
    if (action != "none" && action != "unreadable") warn("the scanner asks its user to " + action);
  } else if (const char* label = label_of(index)) {
    set_detail(label, index == idx::application_name ? read_versioned_text(value) : read_text(value));
  } else if (const auto output = read_output(value)) {
    present_ = *output;
    set_detail("Data Output", describe(present_));
  } else {
    present_ = SafetyOutput();
    set_detail("Data Output", "unreadable");
  }
}

SafetyOutput SafetyDialogue::wanted_output(const SafetyOutput& present) const {
  SafetyOutput target = present;
  if (requests_.skip) target.every = static_cast<std::uint16_t>(*requests_.skip + 1);
  if (!requests_.host_address) return target;
  target.enabled = true;
  target.host = *requests_.host_address;
  target.port = requests_.host_port;
  target.features |= SafetyOutput::needed_features;
  if (target.every == 0) target.every = 1;
  if (!present.enabled) target.interface = interface_of(type_code_).value_or(present.interface);
  return target;
}

void SafetyDialogue::compare(DriverOutput& out) {
  target_ = wanted_output(present_);
  const bool same = encode_output(target_, channel) == encode_output(present_, channel);
  if (same || !requests_.allow_write) {
    if (!same)
      warn("the scanner sends to " + describe(present_) + ", wanted is " + describe(target_) +
           "; set allow_write: true, or change it in Safety Designer");
    phase_ = Phase::browsing;
    fields_.clear();
    cases_.clear();
    return ask_index('R', idx::field_header, {}, out);
  }
  phase_ = Phase::changing;
  const auto argument = encode_output(target_, channel);
  ask_index('M', idx::change_output, ByteView(argument.data(), argument.size()), out);
}

void SafetyDialogue::changed(ByteView result, DriverOutput& out) {
  const std::string refusal =
      result.empty() ? std::string("the command was refused without a reason; is it allowed for this user?")
                     : refusal_text(result.u8(0));
  if (!refusal.empty()) {
    out.note("data output not changed: " + refusal);
    warn("the scanner refuses to send to " + describe(target_) + ": " + refusal);
    return hang_up(out);
  }
  out.note("data output: " + describe(present_) + " -> " + describe(target_));
  set_detail("Setting Written", describe(present_) + " -> " + describe(target_));
  phase_ = Phase::verifying;
  ask_index('R', idx::current_output, {}, out);
}

void SafetyDialogue::verify(ByteView value, DriverOutput& out) {
  take_variable(idx::current_output, value);
  if (encode_output(present_, channel) != encode_output(target_, channel))
    warn("the scanner accepted " + describe(target_) + " but reports " + describe(present_) +
         "; another program may have changed it");
  phase_ = Phase::browsing;
  fields_.clear();
  cases_.clear();
  ask_index('R', idx::field_header, {}, out);
}

/// Fields, then monitoring cases, each up to the first index that holds none.
void SafetyDialogue::browse(ByteView value, DriverOutput& out) {
  const bool of_fields = index_ >= idx::field_header;
  const std::uint16_t next = static_cast<std::uint16_t>(index_ + 1);
  if (of_fields) {
    const auto field = read_field(value);
    if (field && field->defined) add_to_list(fields_, field->describe());
    // The first index may be empty, it is reserved (sick_safetyscanners_base, src/SickSafetyscanners.cpp,
    // requestFieldData).
    const bool goes_on = field || index_ == idx::field_header;
    if (goes_on && next < idx::field_header + most_fields) return ask_index('R', next, {}, out);
    if (!fields_.empty()) set_detail("Fields", fields_);
    return ask_index('R', idx::monitoring_case, {}, out);
  }
  const std::string text = describe_case(value);
  if (!text.empty()) {
    add_to_list(cases_, text);
    if (next < idx::monitoring_case + most_cases) return ask_index('R', next, {}, out);
  }
  if (!cases_.empty()) set_detail("Configured Monitoring Cases", cases_);
  hang_up(out);
}

void SafetyDialogue::hang_up(DriverOutput& out) {
  phase_ = Phase::closing;
  ask('C', 'X', {}, out);
}

void SafetyDialogue::fail(const std::string& why, DriverOutput& out) {
  warn("the scanner " + why + "; its settings were not " + (requests_.allow_write ? "written" : "read"));
  phase_ = Phase::idle;
  out.disconnect(false);
}

void SafetyDialogue::set_detail(const std::string& key, const std::string& text) {
  ++version_;
  for (auto& detail : details_) {
    if (detail.first != key) continue;
    detail.second = text;
    return;
  }
  details_.emplace_back(key, text);
}

void SafetyDialogue::warn(const std::string& text) {
  ++version_;
  if (std::find(warnings_.begin(), warnings_.end(), text) == warnings_.end()) warnings_.push_back(text);
}

}  // namespace lidard::sick
