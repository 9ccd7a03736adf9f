// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <boost/asio/yield.hpp>
#include <string>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/model.h"
#include "drivers/sick/safety/cola2_frame.h"
#include "drivers/sick/safety/safety_models.h"

namespace lidard::sick {
namespace {

namespace idx = safety_index;

/// Asked for in this order; the present output comes last, since the next steps depend on it.
constexpr std::array<std::uint16_t, 9> variables = {
    idx::type_code,        idx::serial_number,   idx::firmware,    idx::device_name,   idx::project_name,
    idx::application_name, idx::status_overview, idx::user_action, idx::current_output};
/// Changes are made on the first data output channel; microScan3 has but one.
constexpr std::uint8_t channel = 0;
constexpr Span patience = std::chrono::seconds(2);
/// The session ends after so many seconds without a telegram (SICK 8022708 p. 30 advises 30).
constexpr std::uint8_t session_timeout_s = 30;

std::array<std::uint8_t, 2> le16(std::uint16_t value) {
  return {static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U)};
}

const char* label_of(std::uint16_t index) {
  if (index == idx::firmware) return "Firmware Version";
  if (index == idx::device_name) return "Device Name";
  if (index == idx::project_name) return "Project Name";
  return index == idx::application_name ? "Application Name" : nullptr;
}

/// The dialogue with a safety scanner over CoLa 2 (TCP 2122): reads identity and data output, compares the
/// output with the configuration and, if allowed, changes it and reads it again. Then it hangs up: some
/// firmware stalls the stream during a dialogue (SICKAG/sick_safetyscanners issue 15).
///
/// It runs only if the configuration has a request (`DeviceRequests::host_address`, `skip` or `allow_write`).
/// Written settings are volatile; they are written again when the stream stopped, as after switching the
/// scanner off (same project, issue 98).
class SafetyDialogue final : public SideDialogue {
 public:
  explicit SafetyDialogue(const DriverConfig& config)
      : SideDialogue(!config.requests.listen_only && (config.requests.host_address || config.requests.skip ||
                                                      config.requests.allow_write),
                     config.requests.allow_write, patience),
        requests_(config.requests),
        product_(config.model->product),
        range_max_(config.model->range_max) {}

  void receive(const Packet& packet, FrameReceiver& out) override {
    if (!is_talking()) return;
    now_ = packet.arrival;
    stream_.add(packet.payload);
    while (is_talking() && stream_.next(answer_)) {
      if (answer_.request != request_) continue;  // late, of a request given up
      // Answers repeat the index; a refusal does not.
      value_ = answer_.type != 'F' && answer_.data.has(0, 2) ? answer_.data.from(2) : ByteView();
      script(out);
    }
  }

 private:
  void begin() override {
    stream_.clear();
    session_ = 0;
  }

  // NOLINTNEXTLINE(readability-function-size): the steps of one dialogue are one coroutine.
  void script(FrameReceiver& out) override {
    reenter(script_) {
      yield open(out);
      if (!answer_.is('O', 'A'))
        return fail("refuses the CoLa 2 session; is another program connected?", out);
      session_ = answer_.session;
      info_.details.clear();
      info_.warnings.clear();
      changed_ = true;
      for (variable_ = 0; variable_ < variables.size(); ++variable_) {
        yield read(variables[variable_], out);
        store_variable(variables[variable_]);
      }
      if (is_to_be_changed()) {
        yield change_output(out);
        if (was_changed(out)) {
          yield read(idx::current_output, out);
          verify();
        }
      }
      yield ask_in_mode('C', 'X', {}, out);
      hang_up(End::complete, out);
    }
  }

  void silent(FrameReceiver& out) override { fail("does not answer on its TCP port", out); }
  End cut_off() override {
    warn("the scanner closes the connection before it answers; is another program connected?");
    return End::failed;
  }

  void ask_in_mode(char type, char mode, ByteView data, FrameReceiver& out) {
    Cola2Telegram telegram;
    telegram.session = session_;
    telegram.request = ++request_;
    telegram.type = type;
    telegram.mode = mode;
    telegram.data = data;
    const auto bytes = encode_cola2(telegram);
    ask({bytes.data(), bytes.size()}, out);
  }

  void open(FrameReceiver& out) {
    // Time-out and the client's identity, which appears only in the scanner's log.
    const std::array<std::uint8_t, 5> open = {session_timeout_s, 'l', 'd', 'r', 'd'};
    ask_in_mode('O', 'X', ByteView(open.data(), open.size()), out);
  }

  void read(std::uint16_t index, FrameReceiver& out) { ask_index('R', index, {}, out); }

  void ask_index(char type, std::uint16_t index, ByteView arguments, FrameReceiver& out) {
    const auto prefix = le16(index);
    std::vector<std::uint8_t> data(prefix.begin(), prefix.end());
    data.insert(data.end(), arguments.begin(), arguments.end());
    ask_in_mode(type, 'I', ByteView(data.data(), data.size()), out);
  }

  void change_output(FrameReceiver& out) {
    const auto argument = encode_output(target_, channel);
    ask_index('M', idx::change_output, ByteView(argument.data(), argument.size()), out);
  }

  void store_variable(std::uint16_t index) {
    const ByteView value = value_;
    if (index == idx::type_code) {
      type_code_ = read_text(value);
      detail("Type Code", type_code_);
      const double range = range_of(type_code_);
      if (range > 0 && range != range_max_)
        warn("type code " + type_code_ + " is that of a scanner for " +
             std::to_string(static_cast<int>(range)) + " m, but " + product_ +
             " is configured; choose the model with that range");
      // As in SICK's catalogue: NANS3-CAAZ30AN1 is a nanoScan3, the others are MICS3-...
      const bool is_nanoscan = type_code_.compare(0, 5, "NANS3") == 0;
      if (!type_code_.empty() && is_nanoscan != (product_ == "nanoScan3"))
        warn("type code " + type_code_ + " is that of a " + (is_nanoscan ? "nanoScan3" : "microScan3") +
             ", but " + product_ +
             " is configured; set model: " + (is_nanoscan ? "sick_nanoscan3" : "sick_microscan3"));
    } else if (index == idx::serial_number) {
      info_.serial = read_text(value);
    } else if (index == idx::status_overview) {
      detail("Status", describe_status(value));
    } else if (index == idx::user_action) {
      const std::string action = describe_action(value);
      detail("Required User Action", action);
      if (action != "none" && action != "unreadable") warn("the scanner asks its user to " + action);
    } else if (const char* label = label_of(index)) {
      detail(label, index == idx::application_name ? read_versioned_text(value) : read_text(value));
    } else if (const auto output = read_output(value)) {
      present_ = *output;
      has_output_ = true;
      detail("Data Output", describe(present_));
    } else {
      has_output_ = false;
      detail("Data Output", "unreadable");
      warn(
          "the scanner does not tell its data output as known firmware does, so it is neither compared nor "
          "written; set it in Safety Designer");
    }
  }

  bool is_to_be_changed() {
    if (!has_output_) return false;
    target_ = wanted_output(present_);
    if (encode_output(target_, channel) == encode_output(present_, channel)) return false;
    if (!requests_.allow_write)
      warn("the scanner sends to " + describe(present_) + ", wanted is " + describe(target_) +
           "; set allow_write: true, or change it in Safety Designer");
    return requests_.allow_write;
  }

  bool was_changed(FrameReceiver& out) {
    const std::string refusal =
        value_.empty() ? std::string("the command was refused without a reason; is it allowed for this user?")
                       : refusal_text(value_.u8(0));
    if (!refusal.empty()) {
      out.note("data output not changed: " + refusal);
      warn("the scanner refuses to send to " + describe(target_) + ": " + refusal);
      return false;
    }
    out.note("data output: " + describe(present_) + " -> " + describe(target_));
    detail("Setting Written", describe(present_) + " -> " + describe(target_));
    return true;
  }

  void verify() {
    store_variable(idx::current_output);
    if (has_output_ && encode_output(present_, channel) != encode_output(target_, channel))
      warn("the scanner accepted " + describe(target_) + " but reports " + describe(present_) +
           "; another program may have changed it");
  }

  void fail(const std::string& why, FrameReceiver& out) {
    warn("the scanner " + why + "; its settings were not " + (requests_.allow_write ? "written" : "read"));
    hang_up(End::failed, out);
  }

  void warn(const std::string& text) {
    std::vector<std::string> known = info_.warnings;
    if (std::find(known.begin(), known.end(), text) == known.end()) known.push_back(text);
    set_warnings(std::move(known));
  }

  DataOutput wanted_output(const DataOutput& present) const {
    DataOutput target = present;
    if (requests_.skip) target.every = static_cast<std::uint16_t>(*requests_.skip + 1);
    if (!requests_.host_address) return target;
    target.enabled = true;
    target.host = *requests_.host_address;
    target.port = requests_.host_port;
    target.features |= DataOutput::needed_features;
    if (target.every == 0) target.every = 1;
    if (!present.enabled) target.interface = interface_of(type_code_).value_or(present.interface);
    return target;
  }

  DeviceRequests requests_;
  std::string product_;
  double range_max_;
  Cola2Stream stream_;
  Cola2Telegram answer_;
  ByteView value_;  // of the answer
  std::uint32_t session_ = 0;
  std::uint16_t request_ = 0;
  std::size_t variable_ = 0;
  std::string type_code_;
  bool has_output_ = false;  // present_ was read
  DataOutput present_, target_;
};

}  // namespace

std::unique_ptr<SideDialogue> make_safety_dialogue(const DriverConfig& config) {
  return std::make_unique<SafetyDialogue>(config);
}

}  // namespace lidard::sick
