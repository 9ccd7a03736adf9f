// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "core/base/time.h"
#include "drivers/dialogue.h"
#include "drivers/driver_base.h"
#include "drivers/hokuyo/models.h"
#include "drivers/hokuyo/scip_clock.h"
#include "drivers/hokuyo/uam_frame.h"

namespace lidard::hokuyo {
namespace {

/// A request for distances.
struct UamRow {
  std::string_view start;   ///< command of the endless stream
  std::string_view answer;  ///< sub-header of its frames
  std::size_t beams;
  double step_deg;
  bool intensities;  ///< a block of as many intensities follows the distances; unverified
};

// Distances are 16 bits; from 40 000 on they are codes (UAM-05LP driver of locusrobotics).
constexpr std::uint32_t first_code = 40'000;
constexpr std::uint32_t no_object = 0xfffe, too_near = 0xfffd;
constexpr double first_deg = -135;
constexpr double turn_s = 0.03;
constexpr Span answer_patience = std::chrono::milliseconds(1200);
constexpr Span stream_patience = std::chrono::milliseconds(600);
constexpr Span retry_after = std::chrono::seconds(1);
/// The clock of the SCIP sensors unwraps the low 24 bits of a counter.
constexpr std::uint32_t shown_by_clock = (1U << 24U) - 1;
constexpr std::int64_t longest_loss = 10'000;

enum class Trouble : std::uint8_t {
  silent,
  refused,
  error,
  lockout,
  laser_off,
  contaminated,
  device,
  count_
};

/// The state in an answer with distances. Flags are 0 or 1 as the sensor sends them.
struct UamStatus {
  std::uint32_t operating_mode, area, error_state, error_code, lockout, ossd1, ossd2, ossd3, ossd4, warning1,
      warning2, muting1, muting2, reset_request1, reset_request2, encoder_speed, time_ms, laser_off,
      contaminated;
};

/// Offsets from STX as urg_node and the UAM-05LP driver of locusrobotics have them.
constexpr struct {
  const char* name;  ///< in the topic; null: not there
  std::uint32_t UamStatus::*value;
  std::size_t at, digits;
} status_fields[] = {
    {"operating_mode", &UamStatus::operating_mode, 11, 1},
    {"area", &UamStatus::area, 12, 2},
    {"error_state", &UamStatus::error_state, 14, 1},
    {"error_code", &UamStatus::error_code, 15, 2},
    {"lockout", &UamStatus::lockout, 17, 1},
    {"ossd1", &UamStatus::ossd1, 18, 1},
    {"ossd2", &UamStatus::ossd2, 19, 1},
    {"ossd3", &UamStatus::ossd3, 22, 1},
    {"ossd4", &UamStatus::ossd4, 23, 1},
    {"warning1", &UamStatus::warning1, 20, 1},
    {"warning2", &UamStatus::warning2, 21, 1},
    {"muting1", &UamStatus::muting1, 26, 1},
    {"muting2", &UamStatus::muting2, 27, 1},
    {"reset_request1", &UamStatus::reset_request1, 28, 1},
    {"reset_request2", &UamStatus::reset_request2, 29, 1},
    {"encoder_speed", &UamStatus::encoder_speed, 30, 4},
    {nullptr, &UamStatus::time_ms, 34, 8},
    {"laser_off", &UamStatus::laser_off, 42, 1},
    {"window_contaminated", &UamStatus::contaminated, 43, 1},
};

/// False if a field is no hexadecimal number.
bool parse_status(std::string_view frame, UamStatus& s) {
  for (const auto& field : status_fields) {
    const auto value = uam_number(frame, field.at, field.digits);
    if (!value) return false;
    s.*field.value = *value;
  }
  ++s.area;                                     // areas count from 1
  if (s.error_code != 0) s.error_code += 0x40;  // as the sensor's own display has it
  return true;
}

class UamDriver final : public DriverBase {
 public:
  explicit UamDriver(const DriverConfig& config)
      : DriverBase(config),
        row_(*static_cast<const UamRow*>(config.model->row)),
        clock_(config.clock, false) {
    prepare_scan(config, scan_);
    scan_.scan_time = static_cast<float>(turn_s);
    scan_.time_increment = static_cast<float>(turn_s * row_.step_deg / 360);
    state_->topic = "status";
    state_->frame_id = config.frame_id;
    window_ = choose_beams(config_, first_deg * rad_per_deg, row_.step_deg * rad_per_deg, row_.beams, scan_);
  }

  Verdict receive(const Packet& packet, FrameReceiver& out) override {
    if (!clock_.ready()) find_newest(packet);
    return read_stream<UamFrame>(packet, reader_, [&](const UamFrame& frame) {
      if (frame.reject == Reject::none) return handle(frame.text, packet.arrival, out);
      ++counters_.packets;
      return Verdict{true, frame.reject};
    });
  }

  void connected(Stamp now, FrameReceiver& out) override {
    reader_.interrupt();
    patience_ = {};
    ask(Step::version, now, out);
  }

  void disconnected() override {
    reader_.interrupt();
    step_ = Step::idle;
  }

  const DeviceClock* clock() const override { return &clock_.clock(); }
  void tick(Stamp now, FrameReceiver& out) override {
    describe_clock(clock_.clock(), clock_.wraps(), now);
    if (step_ == Step::idle || !patience_.is_over(now)) return;
    if (step_ == Step::waiting) return ask(Step::start, now, out);
    board_.set(
        Trouble::silent,
        "the sensor takes the connection but sends nothing; end other programs that are connected to it, "
        "or switch its power off and on");
    if (step_ != Step::streaming && patience_.extend(now)) return send_request(out);
    step_ = Step::idle;
    out.disconnect(true);
  }

  void restart() override {
    reader_.interrupt();
    clock_.reset();
    stamps_.reset();
    forget_repeated();
  }

 private:
  enum class Step : std::uint8_t { idle, version, start, streaming, waiting };

  /// The clock begins with the newest frame of the first read.
  void find_newest(const Packet& packet) {
    bool found = false;
    look_ahead<UamFrame>(packet, reader_, [&](const UamFrame& frame) {
      found = frame.reject == Reject::none && frame.text.size() > uam_distances_at &&
              frame.text.substr(5, 4) == row_.answer && parse_status(frame.text, status_);
    });
    if (found) clock_.begin_with(sweep_of(packet.arrival));
  }

  /// The frame's counter in ms; unverified: used as the first beam's time.
  ScipClock::Sweep sweep_of(Stamp arrival) const {
    ScipClock::Sweep sweep;
    sweep.stamp = {status_.time_ms & shown_by_clock, false};
    sweep.period = span_from_seconds(turn_s);
    sweep.until_sent = span_from_seconds(turn_s * row_.step_deg / 360 * static_cast<double>(row_.beams - 1));
    sweep.arrival = arrival;
    return sweep;
  }

  Verdict handle(std::string_view frame, Stamp arrival, FrameReceiver& out) {
    const std::string_view command = frame.substr(5, 4);
    const std::size_t blocks = row_.intensities ? 2 : 1;
    const bool has_distances = command == row_.answer;
    if (has_distances) {
      ++counters_.packets;
      if (frame.size() != uam_distances_at + 4 * row_.beams * blocks + uam_tail) return {true, Reject::size};
      if (step_ != Step::idle) {
        step_ = Step::streaming;
        patience_.start(arrival, stream_patience);
        board_.clear(Trouble::silent);
        board_.clear(Trouble::refused);
      }
      return {true, is_repeated(ByteView(frame)) ? Reject::duplicate : publish(frame, arrival, out)};
    }
    ++counters_.other_packets;
    if (command == "VR00") read_version(frame);
    if (step_ == Step::version && command == "VR00") ask(Step::start, arrival, out);
    if (step_ == Step::start && command == row_.start) answer_to_start(frame, arrival);
    return {};
  }

  /// Model, firmware, a reserved field and the serial number, separated by commas.
  void read_version(std::string_view frame) {
    if (frame.size() < 11 + uam_tail) return;
    std::string_view text = frame.substr(11, frame.size() - 11 - uam_tail);
    constexpr std::array<const char*, 4> keys = {"Product Name", "Firmware Version", "", "Device ID"};
    for (const char* key : keys) {
      std::string_view field = text.substr(0, text.find(','));
      text.remove_prefix(std::min(field.size() + 1, text.size()));
      while (!field.empty() && (field.back() == ' ' || field.back() == '\0')) field.remove_suffix(1);
      while (!field.empty() && field.front() == ' ') field.remove_prefix(1);
      if (*key == '\0' || field.empty()) continue;
      if (std::string_view(key) == "Device ID") {
        if (!info_.serial.empty() && info_.serial != field)
          board_.set(Trouble::device, "sensor " + info_.serial + " was replaced by sensor " +
                                          std::string(field) + "; check its pose and its areas");
        info_.serial = field;
      }
      info_.set(key, field);
    }
  }

  void answer_to_start(std::string_view frame, Stamp now) {
    const std::string_view status = frame.size() >= 16 ? frame.substr(9, 2) : std::string_view("00");
    if (status == "00") {
      step_ = Step::streaming;
      patience_.start(now, answer_patience);
      return;
    }
    board_.set(Trouble::refused, "the sensor refuses to send (" + std::string(row_.start) + ", status " +
                                     std::string(status) +
                                     "); it is asked again every second: look at its display and end the "
                                     "setting mode of the maker's tool");
    step_ = Step::waiting;
    patience_.start(now, retry_after);
  }

  Reject publish(std::string_view frame, Stamp arrival, FrameReceiver& out) {
    if (frame.substr(9, 2) != "00" || !parse_status(frame, status_)) return Reject::field;
    const Reject reason = fill(frame);
    if (reason != Reject::none) return reason;
    note_troubles();
    scan_.stamp = first_ray(arrival);
    send_state(out);
    if (scan_.beams == 0) return Reject::none;
    ++counters_.frames;
    out.scan(scan_);
    return Reject::none;
  }

  void ask(Step step, Stamp now, FrameReceiver& out) {
    step_ = step;
    patience_.start_answer(now, answer_patience);
    send_request(out);
  }

  void send_request(FrameReceiver& out) const {
    const std::string request = uam_request(step_ == Step::version ? "VR00" : row_.start);
    out.request(ByteView(request));
  }

  Reject fill(std::string_view frame) {
    const bool with_intensities = row_.intensities && config_.publish_intensity;
    scan_.reset(scan_.beams, 1, with_intensities);
    for (std::size_t i = 0; i < scan_.beams; ++i) {
      const std::size_t at = uam_distances_at + 4 * (window_.first + i);
      const auto value = uam_number(frame, at, 4);
      if (!value) return Reject::field;
      if (*value == no_object) {
        scan_.set_without_hit(i, BeamStatus::none);
      } else if (*value == too_near) {
        scan_.set_without_hit(i, BeamStatus::near);
      } else if (*value >= first_code) {
        scan_.set_without_hit(i, BeamStatus::invalid);
      } else {
        scan_.set_measured(i, static_cast<float>(*value * 1e-3));
      }
      if (!with_intensities) continue;
      const auto intensity = uam_number(frame, at + 4 * row_.beams, 4);
      if (!intensity) return Reject::field;
      scan_.intensities[i] = static_cast<float>(*intensity);
    }
    scan_.hide_gap(window_);
    return Reject::none;
  }

  Stamp first_ray(Stamp arrival) {
    std::int64_t skipped = 0;
    const Stamp begin = clock_.begin_of(sweep_of(arrival), skipped);
    if (skipped < longest_loss) counters_.lost_packets += static_cast<std::uint64_t>(skipped);
    counters_.clock_steps = clock_.steps();
    const Span before = span_from_seconds(turn_s * row_.step_deg / 360 * static_cast<double>(window_.first));
    return stamps_.next(begin + before + config_.time_offset);
  }

  void note_troubles() {
    const auto update = [this](Trouble trouble, bool active, const char* text,
                               Severity severity = Severity::warning) {
      board_.update(
          trouble, active, [text] { return text; }, severity);
    };
    update(Trouble::error, status_.error_state != 0 || status_.error_code != 0,
           "the scanner reports an error and switches its outputs off; its display shows the number (topic "
           "status, error_code): look it up in the manual",
           Severity::fault);
    update(Trouble::lockout, status_.lockout != 0,
           "the scanner is locked out; remove the cause shown on its display and switch its power off and on",
           Severity::fault);
    update(Trouble::laser_off, status_.laser_off != 0,
           "the scanner's laser is off, beams are invalid; wait until it has started, or wake it up");
    update(Trouble::contaminated, status_.contaminated != 0, "the scanner's window is dirty; clean it");
  }

  void send_state(FrameReceiver& out) {
    state_->values.clear();
    for (const auto& field : status_fields) {
      if (field.name != nullptr)
        state_->values.push_back({field.name, static_cast<double>(status_.*field.value)});
    }
    state_->stamp = scan_.stamp;
    out.message(state_);
  }

  const UamRow& row_;
  WarningBoard<Trouble> board_{info_};
  UamReader reader_{counters_};
  Step step_ = Step::idle;
  Patience patience_;

  ScipClock clock_;
  SteadyStamps stamps_;
  UamStatus status_{};
  BeamWindow window_;
  PlanarScan scan_;
  ReusedMessage<DeviceState> state_;
};

// AR02 streams frames AR00, AR04 frames AR01, AR07 frames AR06.
constexpr UamRow plain = {"AR02", "AR00", 1081, 0.25, false};
constexpr UamRow with_intensity = {"AR04", "AR01", 1081, 0.25, true};
constexpr UamRow fine = {"AR07", "AR06", 2161, 0.125, false};

Model scanner(const char* name, const char* product, const UamRow& row, const char* verified) {
  Model model{name, "Hokuyo", product, "UAM AR", verified};
  model.transport = Transport::tcp;
  model.port = 10940;
  model.packets_per_s = 1 / turn_s;
  model.frame_period = turn_s;
  model.range_min = 0.05;                     // unverified
  model.range_max = (first_code - 1) * 1e-3;  // what the wire can say
  model.beams = row.beams;
  model.field = {first_deg, row.step_deg, row.beams};
  model.messages = {message_topic<DeviceState>("status")};
  model.row = &row;
  model.make = make_uam_driver;
  return model;
}

}  // namespace

void append_uam_models(std::vector<Model>& list) {
  list.push_back(scanner("hokuyo_uam_05lp", "UAM-05LP", plain,
                         "own simulator; layout as two drivers have it, no capture of a device"));
  list.push_back(scanner("hokuyo_uam_05lp_intensity", "UAM-05LP with intensities", with_intensity,
                         "own simulator; place of the intensities unverified"));
  list.push_back(scanner("hokuyo_uam_05lp_fine", "UAM-05LP in steps of 0.125 deg", fine,
                         "own simulator; meaning of the 2161 values unverified"));
}

std::unique_ptr<Driver> make_uam_driver(const DriverConfig& config) {
  return std::make_unique<UamDriver>(config);
}

}  // namespace lidard::hokuyo
