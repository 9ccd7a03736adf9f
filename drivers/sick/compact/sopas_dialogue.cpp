// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/sopas_dialogue.h"

#include <cstdlib>

#include "drivers/model.h"

namespace lidard::sick {
namespace {

// Names, arguments and order: SICK developer guide, "CoLa telegram listing" of picoScan100, and
// sick_scan_services.cpp of SICKAG/sick_scan_xd. Unverified against a device.
constexpr std::uint8_t udp = 1;
constexpr std::uint32_t format_msgpack = 1, format_compact = 2;
constexpr const char* authorized_client = "3";
constexpr std::uint32_t authorized_client_hash = 0xf4724744;

constexpr Span patience = std::chrono::seconds(5);  // Run takes its time
/// A stream that stopped for so long may have lost its settings, or never had them.
constexpr Span silence = std::chrono::seconds(1);
constexpr Span dial_pause = std::chrono::milliseconds(500);
/// The same after a whole dialogue that did not bring the stream back.
constexpr Span fruitless_pause = std::chrono::seconds(5);

std::string decimal(unsigned value) { return "+" + std::to_string(value); }

/// As the guide writes it: "1 +192 +168 +0 +100 +2115".
std::string arguments_of(const SopasTarget& target) {
  std::string text = std::to_string(target.protocol);
  for (const std::uint8_t byte : target.host) text += " " + decimal(byte);
  return text + " " + decimal(target.port);
}

SopasTarget target_at(const IpAddress& host, std::uint16_t port) {
  SopasTarget target;
  target.protocol = udp;
  target.port = port;
  for (std::size_t i = 0; i < target.host.size(); ++i) target.host[i] = host.bytes.at(i);
  return target;
}

std::optional<SopasTarget> read_target(const ColaTelegram& telegram) {
  ColaTextReader reader(telegram.arguments());
  SopasTarget target;
  target.protocol = reader.u8();
  for (std::uint8_t& byte : target.host) byte = reader.u8();
  target.port = reader.u16();
  if (!reader.ok()) return std::nullopt;
  return target;
}

std::optional<std::uint32_t> read_number(const ColaTelegram& telegram) {
  ColaTextReader reader(telegram.arguments());
  const std::uint32_t value = reader.u32();
  if (!reader.ok()) return std::nullopt;
  return value;
}

}  // namespace

std::string SopasTarget::describe() const {
  std::string text;
  for (const std::uint8_t byte : host) text += (text.empty() ? "" : ".") + std::to_string(byte);
  return text + ":" + std::to_string(port) + (protocol == udp ? "" : " over TCP");
}

SopasDialogue::SopasDialogue(const DriverConfig& config)
    : requests_(config.requests), wanted_(!requests_.listen_only && requests_.host_address.has_value()) {
  if (!wanted_) return;
  const std::uint16_t port = requests_.host_port != 0 ? requests_.host_port : config.model->port;
  scan_wanted_ = target_at(*requests_.host_address, port);
  imu_wanted_ = target_at(*requests_.host_address, config.model->telemetry_port);
}

const char* SopasDialogue::name_of(Variable variable) {
  constexpr std::array<const char*, static_cast<std::size_t>(Variable::count_)> names = {
      "ScanDataEthSettings", "ScanDataFormat", "ScanDataEnable", "ImuDataEthSettings", "ImuDataEnable"};
  return names.at(static_cast<std::size_t>(variable));
}

void SopasDialogue::tick(Stamp now, std::optional<Stamp> last_data, DriverOutput& out) {
  now_ = now;
  if (!wanted_) return;
  if (phase_ != Phase::idle) {
    if (phase_ != Phase::dialling && now - asked_ > patience)
      fail("takes the connection but does not answer '" + asked_what() +
               "'; check that it speaks CoLa A on that port and that nobody else is connected to it",
           out);
    return;
  }
  const bool silent = !last_data || now - *last_data > silence;
  const bool fruitless = complete_ && (!last_data || *last_data < last_dial_);
  if (complete_ && !silent) return;
  if (dialled_ && now - last_dial_ < (fruitless ? fruitless_pause : dial_pause)) return;
  dialled_ = true;
  last_dial_ = now;
  phase_ = Phase::dialling;
  out.connect();
}

void SopasDialogue::connected(Stamp now, DriverOutput& out) {
  now_ = now;
  stream_.reset();
  reading_ = 0;
  scan_target_.reset();
  imu_target_.reset();
  scan_format_.reset();
  scan_enable_.reset();
  imu_enable_.reset();
  steps_.clear();
  step_ = 0;
  phase_ = Phase::reading;
  read_next(out);
}

void SopasDialogue::disconnected() {
  stream_.reset();
  phase_ = Phase::idle;
}

void SopasDialogue::receive(const Packet& packet, DriverOutput& out) {
  now_ = packet.arrival;
  stream_.add(packet.payload);
  for (ColaTelegram telegram; phase_ != Phase::idle && stream_.next(telegram);) answer(telegram, out);
}

void SopasDialogue::ask(const std::vector<std::uint8_t>& telegram, DriverOutput& out) {
  asked_ = now_;
  out.request(ByteView(telegram.data(), telegram.size()));
}

std::string SopasDialogue::asked_what() const {
  return phase_ == Phase::working ? steps_.at(step_).what
                                  : std::string("sRN ") + name_of(static_cast<Variable>(reading_));
}

void SopasDialogue::read_next(DriverOutput& out) {
  ask(ColaWriter(ColaDialect::a, asked_what()).finish(), out);
}

void SopasDialogue::answer(const ColaTelegram& telegram, DriverOutput& out) {
  if (phase_ == Phase::working) return answer_step(telegram, out);
  if (phase_ != Phase::reading) return;
  const auto variable = static_cast<Variable>(reading_);
  const bool refused = telegram.kind() == "sFA";
  if (!refused && (telegram.kind() != "sRA" || telegram.name() != name_of(variable))) return;
  const bool needed = variable < Variable::imu_target;  // a device without inertial unit refuses the others
  if (refused && needed)
    return fail(std::string("refuses to tell ") + name_of(variable) + ": " +
                    cola_error_words(cola_error_code(telegram)),
                out);
  if (!refused) take(variable, telegram);
  if (++reading_ < static_cast<std::size_t>(Variable::count_)) return read_next(out);
  compare(out);
}

void SopasDialogue::take(Variable variable, const ColaTelegram& telegram) {
  switch (variable) {
    case Variable::scan_target:
      scan_target_ = read_target(telegram);
      break;
    case Variable::scan_format:
      scan_format_ = read_number(telegram);
      break;
    case Variable::scan_enable:
      scan_enable_ = read_number(telegram);
      break;
    case Variable::imu_target:
      imu_target_ = read_target(telegram);
      break;
    case Variable::imu_enable:
      imu_enable_ = read_number(telegram);
      break;
    case Variable::count_:
      break;
  }
}

void SopasDialogue::add_login() {
  const std::string level = requests_.user_level.empty() ? authorized_client : requests_.user_level;
  const std::uint32_t hash =
      requests_.password_hash.empty()
          ? authorized_client_hash
          : static_cast<std::uint32_t>(std::strtoul(requests_.password_hash.c_str(), nullptr, 16));
  ColaWriter writer(ColaDialect::a, "sMN SetAccessMode");
  steps_.push_back(
      {writer.letters(level).hash(hash).finish(), "login at level " + level, true, false, false});
}

void SopasDialogue::add_method(std::string_view name) {
  const std::string command = "sMN " + std::string(name);
  steps_.push_back({ColaWriter(ColaDialect::a, command).finish(), std::string(name), true, false, false});
}

void SopasDialogue::add_write(Variable variable, std::string_view arguments, std::string what,
                              bool may_fail) {
  const std::string command = std::string("sWN ") + name_of(variable);
  steps_.push_back({ColaWriter(ColaDialect::a, command).letters(arguments).finish(),
                    std::string(name_of(variable)) + ": " + std::move(what), false, may_fail, true});
}

/// Where the device sends and in which format.
void SopasDialogue::plan_targets() {
  if (!(*scan_target_ == scan_wanted_))
    add_write(Variable::scan_target, arguments_of(scan_wanted_),
              scan_target_->describe() + " -> " + scan_wanted_.describe(), false);
  if (*scan_format_ != format_msgpack && *scan_format_ != format_compact)
    add_write(Variable::scan_format, std::to_string(format_compact),
              std::to_string(*scan_format_) + " -> " + std::to_string(format_compact), false);
  if (imu_target_ && imu_wanted_.port != 0 && !(*imu_target_ == imu_wanted_))
    add_write(Variable::imu_target, arguments_of(imu_wanted_),
              imu_target_->describe() + " -> " + imu_wanted_.describe(), true);
}

/// What switches the stream on.
void SopasDialogue::plan_start() {
  if (*scan_enable_ == 0) add_write(Variable::scan_enable, "1", "0 -> 1", false);
  if (requests_.allow_write && imu_enable_ && *imu_enable_ == 0)
    add_write(Variable::imu_enable, "1", "0 -> 1", true);
}

void SopasDialogue::compare(DriverOutput& out) {
  if (!scan_target_ || !scan_format_ || !scan_enable_)
    return fail("answers in a way that is not known; report its firmware version", out);
  data_output_ = scan_target_->describe() + (*scan_enable_ == 0 ? ", switched off" : "");
  warning_.clear();
  plan_targets();
  if (!steps_.empty() && !requests_.allow_write) {
    std::string wanted;
    for (const Step& step : steps_) wanted += (wanted.empty() ? "" : ", ") + step.what;
    warning_ = "the device is set up otherwise than wanted (" + wanted +
               "); set allow_write: true, or change it on the device's web page";
    if (!(*scan_target_ == scan_wanted_))
      return hang_up(out);  // a stream to somebody else is not ours to start
    steps_.clear();
  }
  std::vector<Step> settings = std::move(steps_);
  steps_.clear();
  plan_start();
  std::vector<Step> start = std::move(steps_);
  steps_.clear();
  if (settings.empty() && start.empty()) return hang_up(out);
  const auto append = [this](std::vector<Step>& from) {
    if (from.empty()) return;
    add_login();
    for (Step& step : from) steps_.push_back(std::move(step));
    add_method("Run");  // makes what was written valid, and logs out
  };
  append(settings);
  append(start);
  add_login();
  add_method("LMCstartmeas");
  phase_ = Phase::working;
  step_ = 0;
  ask(steps_.front().telegram, out);
}

void SopasDialogue::answer_step(const ColaTelegram& telegram, DriverOutput& out) {
  const Step& step = steps_.at(step_);
  const std::string_view kind = telegram.kind();
  if (kind != "sFA" && kind != "sAN" && kind != "sWA") return;
  if (kind == "sFA") {
    const std::string words = cola_error_words(cola_error_code(telegram));
    if (!step.may_fail) return fail("refuses " + step.what + ": " + words, out);
    warning_ = "the device refuses " + step.what + ": " + words +
               "; without a licence for its inertial unit that is to be expected";
    return next_step(out);
  }
  if (step.method && step.what != "LMCstartmeas") {
    const auto done = read_number(telegram);
    if (done && *done != 1)
      return fail("refuses " + step.what + "; correct user_level and user_level_password", out);
  }
  if (step.is_write) out.note(step.what);
  next_step(out);
}

void SopasDialogue::next_step(DriverOutput& out) {
  if (++step_ < steps_.size()) return ask(steps_[step_].telegram, out);
  if (scan_target_ && !steps_.empty())
    data_output_ = (requests_.allow_write ? scan_wanted_ : *scan_target_).describe();
  hang_up(out);
}

void SopasDialogue::hang_up(DriverOutput& out) {
  complete_ = true;
  phase_ = Phase::idle;
  out.disconnect(false);
}

void SopasDialogue::fail(std::string why, DriverOutput& out) {
  warning_ = "the device " + std::move(why);
  complete_ = true;  // it is tried again, but not so soon
  phase_ = Phase::idle;
  out.disconnect(false);
}

}  // namespace lidard::sick
