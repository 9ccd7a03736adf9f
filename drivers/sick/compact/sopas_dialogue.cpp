// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <boost/asio/yield.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/dialogue.h"
#include "drivers/model.h"
#include "drivers/sick/cola/sopas_session.h"
#include "drivers/sick/compact/compact_models.h"

namespace lidard::sick {
namespace {

// Names, arguments and order: SICK developer guide, "CoLa telegram listing" of picoScan100, and
// sick_scan_services.cpp of SICKAG/sick_scan_xd. Unverified against a device.
constexpr std::uint8_t udp = 1;
constexpr std::uint32_t format_msgpack = 1, format_compact = 2;
constexpr std::uint8_t authorized_client = 3;
constexpr std::uint32_t authorized_client_hash = 0xf4724744;

constexpr Span patience = std::chrono::seconds(5);  // Run needs some time
constexpr std::string_view scan_target = "ScanDataEthSettings", scan_format = "ScanDataFormat",
                           scan_enable = "ScanDataEnable", imu_target = "ImuDataEthSettings",
                           imu_enable = "ImuDataEnable";
/// Read in this order. A device without inertial unit refuses all but the first three.
constexpr std::array variables = {scan_target, scan_format, scan_enable, imu_target, imu_enable};
constexpr std::size_t needed = 3;
constexpr std::string_view start_measuring = "sMN LMCstartmeas";

/// Receiver of a picoScan100's or multiScan100's datagrams (ScanDataEthSettings, ImuDataEthSettings).
struct SopasTarget {
  std::uint8_t protocol = 0;  ///< 1 UDP, 2 TCP
  std::array<std::uint8_t, 4> host{};
  std::uint16_t port = 0;

  std::string describe() const {
    std::string text;
    for (const std::uint8_t byte : host) text += (text.empty() ? "" : ".") + std::to_string(byte);
    return text + ":" + std::to_string(port) + (protocol == udp ? "" : " over TCP");
  }

  friend bool operator==(const SopasTarget& a, const SopasTarget& b) {
    return a.protocol == b.protocol && a.host == b.host && a.port == b.port;
  }
};

std::string decimal(unsigned value) { return "+" + std::to_string(value); }

/// In the guide's notation: "1 +192 +168 +0 +100 +2115".
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

/// The dialogue with a picoScan100 or multiScan100 in SICK's command language, dialect A (TCP 2111). It runs
/// only if the configuration has a host address and not `listen_only`. The dialogue reads and compares the
/// receiver, the format and the state of the stream. It starts a stream that is only switched off, and writes
/// different settings if `allow_write` is set, with a note old -> new; they are lost when the device is
/// switched off, after which the dialogue runs again.
class SopasDialogue final : public SideDialogue {
 public:
  explicit SopasDialogue(const DriverConfig& config)
      : SideDialogue(!config.requests.listen_only && config.requests.host_address, true, patience),
        requests_(config.requests),
        session_(ColaDialect::a, config.requests, authorized_client, authorized_client_hash) {
    if (!requests_.host_address) return;
    const std::uint16_t port = requests_.host_port != 0 ? requests_.host_port : config.model->port;
    scan_wanted_ = target_at(*requests_.host_address, port);
    imu_wanted_ = target_at(*requests_.host_address, config.model->telemetry_port);
  }

  void receive(const Packet& packet, FrameReceiver& out) override {
    if (!is_talking()) return;
    now_ = packet.arrival;
    stream_.add(packet.payload);
    while (is_talking() && stream_.next(answer_)) {
      if (session_.accept(answer_)) script(out);
    }
  }

 private:
  /// One command of the second half, after the comparison.
  struct Step {
    std::string command, arguments;
    std::string what;  ///< for people: "ScanDataFormat: 1 -> 2"
    bool may_fail = false;
    /// All methods but one return 1 after success.
    bool answers_one() const { return command[1] == 'M' && command != start_measuring; }
    bool is_write() const { return command[1] == 'W'; }
  };

  void begin() override {
    stream_.interrupt();
    scan_target_.reset();
    imu_target_.reset();
    scan_format_.reset();
    scan_enable_.reset();
    imu_enable_.reset();
    steps_.clear();
  }

  void script(FrameReceiver& out) override {
    reenter(script_) {
      for (variable_ = 0; variable_ < variables.size(); ++variable_) {
        yield question("sRN " + std::string(variables[variable_]), {}, out);
        if (!read_variable(variables[variable_], out)) return;
      }
      if (!plan(out)) return;
      for (step_ = 0; step_ < steps_.size(); ++step_) {
        yield question(steps_[step_].command, steps_[step_].arguments, out);
        if (!note_step(out)) return;
      }
      if (!steps_.empty())
        detail("Data Output", (requests_.allow_write ? scan_wanted_ : *scan_target_).describe());
      hang_up(End::complete, out);
    }
  }

  void silent(FrameReceiver& out) override {
    const bool reads = variable_ < variables.size();
    warn("the device accepts the connection but does not answer '" +
         (reads ? session_.command() : steps_.at(step_).what) +
         "'; check that it speaks CoLa A on that port and that no other client is connected to it");
    hang_up(End::failed, out);
  }

  End cut_off() override {
    warn("the device closes the connection before it answers; check that no other client is connected to it");
    return End::failed;
  }

  void question(const std::string& command, const std::string& arguments, FrameReceiver& out) {
    ColaWriter writer = session_.ask(command);
    if (!arguments.empty()) writer.letters(arguments);
    const auto bytes = writer.finish();
    ask({bytes.data(), bytes.size()}, out);
  }

  /// False if the dialogue cannot continue.
  bool read_variable(std::string_view variable, FrameReceiver& out) {
    if (session_.refusal()) {
      if (variable_ >= needed) return true;
      fail("refuses to report " + std::string(variable) + ": " + cola_error_words(*session_.refusal()), out);
      return false;
    }
    if (variable == scan_target) scan_target_ = read_target(answer_);
    if (variable == scan_format) scan_format_ = read_number(answer_);
    if (variable == scan_enable) scan_enable_ = read_number(answer_);
    if (variable == imu_target) imu_target_ = read_target(answer_);
    if (variable == imu_enable) imu_enable_ = read_number(answer_);
    return true;
  }

  /// Plans the steps after the comparison. False if the dialogue cannot continue.
  bool plan(FrameReceiver& out) {
    if (!scan_target_ || !scan_format_ || !scan_enable_) {
      fail("sends an unknown answer; report its firmware version", out);
      return false;
    }
    detail("Data Output", scan_target_->describe() + (*scan_enable_ == 0 ? ", switched off" : ""));
    set_warnings({});
    plan_targets();
    std::vector<Step> settings = std::exchange(steps_, {});
    const bool ours = *scan_target_ == scan_wanted_;
    if (!settings.empty() && !requests_.allow_write) {
      std::string wanted;
      for (const Step& step : settings) wanted += (wanted.empty() ? "" : ", ") + step.what;
      warn("the device's settings differ from the configuration (" + wanted +
           "); set allow_write: true, or change it on the device's web page");
      settings.clear();
    }
    // A stream to another receiver is not started.
    if (ours || requests_.allow_write) plan_start();
    std::vector<Step> start = std::exchange(steps_, {});
    for (std::vector<Step>* part : {&settings, &start}) {
      if (part->empty()) continue;
      add_login();
      for (Step& step : *part) steps_.push_back(std::move(step));
      add_method(sopas_run);
    }
    if (steps_.empty()) return true;
    add_login();
    add_method(start_measuring);
    return true;
  }

  void add_write(std::string_view variable, std::string arguments, const std::string& what, bool may_fail) {
    const std::string name(variable);
    steps_.push_back({"sWN " + name, std::move(arguments), name + ": " + what, may_fail});
  }

  void add_login() {
    steps_.push_back(
        {std::string(sopas_login), {}, "login at level " + std::to_string(session_.level()), false});
  }

  void add_method(std::string_view command) {
    steps_.push_back({std::string(command), {}, std::string(command.substr(4)), false});
  }

  /// Plans the receiver and the format.
  void plan_targets() {
    if (!(*scan_target_ == scan_wanted_))
      add_write(scan_target, arguments_of(scan_wanted_),
                scan_target_->describe() + " -> " + scan_wanted_.describe(), false);
    if (*scan_format_ != format_msgpack && *scan_format_ != format_compact)
      add_write(scan_format, std::to_string(format_compact),
                std::to_string(*scan_format_) + " -> " + std::to_string(format_compact), false);
    if (imu_target_ && imu_wanted_.port != 0 && !(*imu_target_ == imu_wanted_))
      add_write(imu_target, arguments_of(imu_wanted_),
                imu_target_->describe() + " -> " + imu_wanted_.describe(), true);
  }

  /// Plans the start of the stream.
  void plan_start() {
    if (*scan_enable_ == 0) add_write(scan_enable, "1", "0 -> 1", false);
    if (requests_.allow_write && imu_enable_ && *imu_enable_ == 0) add_write(imu_enable, "1", "0 -> 1", true);
  }

  /// False if the dialogue cannot continue.
  bool note_step(FrameReceiver& out) {
    const Step& step = steps_.at(step_);
    if (session_.refusal()) {
      const std::string words = cola_error_words(*session_.refusal());
      if (!step.may_fail) {
        fail("refuses " + step.what + ": " + words, out);
        return false;
      }
      warn("the device refuses " + step.what + ": " + words +
           "; this is normal without a licence for its inertial unit");
      return true;
    }
    if (step.answers_one() && read_number(answer_).value_or(1) != 1) {
      fail("refuses " + step.what + "; correct user_level and user_level_password", out);
      return false;
    }
    if (step.is_write()) out.note(step.what);
    return true;
  }

  void warn(std::string sentence) { set_warnings({std::move(sentence)}); }

  void fail(std::string why, FrameReceiver& out) {
    warn("the device " + std::move(why));
    hang_up(End::complete, out);  // a refusal is final while the device sends data
  }

  DeviceRequests requests_;
  SopasSession session_;
  SopasTarget scan_wanted_, imu_wanted_;
  Counters stream_counters_;
  ColaStream stream_{stream_counters_};
  ColaTelegram answer_;
  std::size_t variable_ = 0;
  std::optional<SopasTarget> scan_target_, imu_target_;
  std::optional<std::uint32_t> scan_format_, scan_enable_, imu_enable_;
  std::vector<Step> steps_;
  std::size_t step_ = 0;
};

}  // namespace

std::unique_ptr<SideDialogue> make_sopas_dialogue(const DriverConfig& config) {
  return std::make_unique<SopasDialogue>(config);
}

}  // namespace lidard::sick
