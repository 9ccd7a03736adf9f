// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/telemetry.h"

#include <algorithm>
#include <cstdio>

#include "core/base/angle.h"
#include "drivers/model.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {
namespace {

// Offsets: 63-9325 Rev B, p. 60; from 0xC6 on for every model (measured on VLP-16 and HDL-32E).
constexpr std::size_t health_offset = 0xBB;
constexpr std::size_t calibration_end = 0xC6;
constexpr std::size_t toh_offset = 0xC6;
constexpr std::size_t pps_offset = 0xCA;
constexpr std::size_t thermal_offset = 0xCB;
constexpr std::size_t nmea_offset = 0xCE;
constexpr std::size_t nmea_size = 128;

// HDL-32E user manual, appendix B, and VeloView's vtkVelodyneHDLPositionReader.
constexpr std::size_t imu_offset = 14;
constexpr double gyro_step = 0.09766 / 180 * pi_d;  // rad/s
constexpr double temperature_step_c = 0.1453;
constexpr double temperature_at_zero_c = 25;
constexpr double accel_step = 0.001221 * 9.80665;  // m/s²

int signed8(std::uint8_t byte) { return static_cast<std::int8_t>(byte); }
int signed16(std::uint16_t word) { return static_cast<std::int16_t>(word); }
int signed12(std::uint16_t word) { return signed16(static_cast<std::uint16_t>(word << 4U)) / 16; }

std::optional<SensorHealth> read_health(ByteView p) {
  const auto has_data = [&p](std::size_t begin, std::size_t end) {
    return std::any_of(p.begin() + begin, p.begin() + end, [](std::uint8_t b) { return b != 0; });
  };
  if (!has_data(health_offset, calibration_end) && !has_data(thermal_offset, nmea_offset))
    return std::nullopt;
  SensorHealth health;
  health.top_board_c = signed8(p.u8(0xBB));
  health.bottom_board_c = signed8(p.u8(0xBC));
  health.since_calibration_k = signed16(p.le16(0xBE));
  health.calibration_age_s = p.le32(0xC0);
  health.shut_down = p.u8(thermal_offset) != 0;
  return health;
}

std::optional<RawImu> read_imu(ByteView p) {
  RawImu imu;
  for (std::size_t unit = 0; unit < 3; ++unit) {
    std::array<int, 4> value{};
    for (unsigned kind = 0; kind < 4; ++kind) {
      const std::uint16_t word = p.le16(imu_offset + unit * 8 + std::size_t{2} * kind);
      if (word >> 12U != kind) return std::nullopt;
      value[kind] = signed12(word);
    }
    imu.gyro_rad_s[unit] = value[0] * gyro_step;
    imu.temperature_c[unit] = temperature_at_zero_c + value[1] * temperature_step_c;
    imu.accel_x[unit] = value[2] * accel_step;
    imu.accel_y[unit] = value[3] * accel_step;
  }
  return imu;
}

}  // namespace

std::optional<Telemetry> read_telemetry(ByteView packet) {
  if (packet.size() != telemetry_size) return std::nullopt;
  Telemetry telemetry;
  telemetry.toh_us = packet.le32(toh_offset);
  telemetry.pps = packet.u8(pps_offset);
  telemetry.health = read_health(packet);
  telemetry.imu = read_imu(packet);
  const std::string_view field = packet.sub(nmea_offset, nmea_size).text();
  telemetry.nmea = field.substr(0, field.find('\0'));
  return telemetry;
}

namespace {

constexpr Span describe_period = std::chrono::seconds(1);
constexpr Span silent_after = std::chrono::seconds(3);
/// A receiver needs time after it was switched on or lost its satellites.
constexpr Span patience_for_pps = std::chrono::seconds(10);
constexpr std::string_view unsynchronised =
    "the sensor's clock does not follow a receiver's PPS and NMEA as expect_pps requires (see the values "
    "PPS and NMEA); check the receiver's power, antenna and wiring, and that it sends GPRMC, or remove "
    "expect_pps. Stamps are not affected: they follow the arrivals";
/// A sentence comes up to a second after its instant and is repeated until the next one (measured: 0.85 to
/// 1.48 s on an HDL-32E). The negative limit is for receivers that round.
constexpr Span youngest_sentence = std::chrono::milliseconds(-100);
constexpr Span oldest_sentence = std::chrono::milliseconds(2500);

struct ClaimText {
  std::string_view state;    // for the list of details
  std::string_view warning;  // empty: nothing is wrong
};

const ClaimText& text_of(ClockClaim claim) {
  static constexpr std::array<ClaimText, 9> texts = {{
      {"free-running", ""},
      {"agrees with the receiver's time, but no PPS", ""},
      {"synchronising", ""},
      {"synchronised (PPS and NMEA agree)", ""},
      {"not synchronised: PPS error",
       "the sensor reports a PPS error; check the wiring and the pulse length of the GPS receiver"},
      {"not synchronised: PPS without a valid NMEA time",
       "the sensor reports PPS as locked but has no valid NMEA time, so its clock is not UTC; check the "
       "receiver's serial line, its antenna and that it sends GPRMC"},
      {"not synchronised: differs from the NMEA time",
       "the sensor reports PPS as locked but its clock differs from the NMEA time; check that the receiver "
       "sends the sentence of the last pulse, and the sensor's GPS settings"},
      {"unknown PPS state", ""},
      {"unknown: no telemetry for 3 s", ""},
  }};
  return texts[static_cast<std::size_t>(claim)];
}

std::string_view text_of(const NmeaReading& nmea) {
  static constexpr std::array<std::string_view, static_cast<std::size_t>(NmeaVerdict::count_)> texts = {
      "none",
      "malformed",
      "checksum wrong",
      "neither RMC nor GGA",
      "receiver has no fix",
      "date of 2000 or before: not from a satellite",
      "valid"};
  if (nmea.verdict == NmeaVerdict::valid) return nmea.kind == NmeaKind::rmc ? "valid RMC" : "valid GGA";
  return texts[static_cast<std::size_t>(nmea.verdict)];
}

std::string_view text_of_pps(std::uint8_t pps) {
  static constexpr std::array<std::string_view, 4> texts = {"absent", "synchronising", "locked", "error"};
  return pps < texts.size() ? texts[pps] : "unknown";
}

/// Formats without allocations, since details change while packets arrive.
template <typename... Values>
void set(DeviceInfo& info, std::string_view key, const char* format, Values... values) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), format, values...);
  info.set(key, text.data());
}

bool is_junk(NmeaVerdict verdict) {
  return verdict == NmeaVerdict::malformed || verdict == NmeaVerdict::bad_checksum ||
         verdict == NmeaVerdict::other_sentence;
}

void describe_health(const SensorHealth& health, DeviceInfo& info) {
  set(info, "Temperature top board (C)", "%d", health.top_board_c);
  set(info, "Temperature bottom board (C)", "%d", health.bottom_board_c);
  set(info, "Temperature change since calibration (K)", "%d", health.since_calibration_k);
  set(info, "Calibration age (s)", "%u", static_cast<unsigned>(health.calibration_age_s));
  info.set("Thermal state", health.shut_down ? "shut down" : "ok");
}

}  // namespace

TelemetryReceiver::TelemetryReceiver(const DriverConfig& config)
    : has_imu_(config.model != nullptr && config.model->sends<ImuSample>()),
      time_offset_(config.time_offset),
      clock_(config.clock),
      expects_pps_(config.expect_pps) {
  fix_->frame_id = imu_->frame_id = config.frame_id;
}

void TelemetryReceiver::restart() {
  in_stream_ = false;
  clock_.reset();
  text_size_ = 0;
  sentences_ = 0;
  nmea_ = {};
}

Reject TelemetryReceiver::receive(const Packet& packet, FrameReceiver& out, DeviceInfo& info) {
  const auto telemetry = read_telemetry(packet.payload);
  if (!telemetry) return Reject::size;
  const Stamp arrival = packet.arrival;
  advance_clock(telemetry->toh_us, arrival);
  const bool fresh = store_sentence(telemetry->nmea);
  if (fresh) {
    sentence_arrival_ = arrival;
    sentence_age_ = hour_difference(toh_, nmea_.time_of_day);
  }
  const ClockClaim claim = judge(*telemetry);
  const bool changed = fresh || claim != claim_ || telemetry->pps != described_pps_;
  set_claim(claim, info);
  // The age of the first sentence of a stream is unknown, since it is repeated.
  if (fresh) send_sentence(out, sentences_ > 1);
  if (has_imu_ && telemetry->imu) send_imu(*telemetry->imu, out);
  const Span since = arrival - last_described_;
  if (changed || since >= describe_period || since < Span(0)) describe(*telemetry, packet, info);
  return Reject::none;
}

void TelemetryReceiver::tick(Stamp now, DeviceInfo& info) {
  if (in_stream_ && claim_ != ClockClaim::silent && now - last_arrival_ >= silent_after) {
    info.set("PPS", "unknown");
    set_claim(ClockClaim::silent, info);
  }
  if (expects_pps_) judge_expectation(now, info);
}

/// Warns of a clock that does not follow the receiver, unless another warning covers it.
void TelemetryReceiver::judge_expectation(Stamp now, DeviceInfo& info) {
  const bool synchronised = claim_ == ClockClaim::synchronised;
  if (synchronised) unsynchronised_since_.reset();
  if (!synchronised && !unsynchronised_since_) unsynchronised_since_ = now;
  const bool warn =
      !synchronised && text_of(claim_).warning.empty() && now - *unsynchronised_since_ >= patience_for_pps;
  if (warn == warned_unsynchronised_) return;
  warned_unsynchronised_ = warn;
  info.replace_warning(warn ? "" : unsynchronised, warn ? unsynchronised : "");
}

void TelemetryReceiver::advance_clock(std::uint32_t toh_us, Stamp arrival) {
  const Span toh = std::chrono::microseconds(toh_us);
  device_ = in_stream_ ? device_ + hour_difference(toh, toh_) : toh;
  toh_ = toh;
  in_stream_ = true;
  last_arrival_ = arrival;
  clock_.observe(device_, arrival);
}

/// Stores and parses a sentence; true if it differs from the last one.
bool TelemetryReceiver::store_sentence(std::string_view text) {
  if (text == std::string_view(text_.data(), text_size_)) return false;
  text_size_ = std::min(text.size(), text_.size());
  std::copy_n(text.data(), text_size_, text_.data());
  nmea_ = read_nmea(text);
  if (is_junk(nmea_.verdict)) ++bad_sentences_;
  ++sentences_;
  return true;
}

ClockClaim TelemetryReceiver::judge(const Telemetry& telemetry) const {
  const bool has_time = nmea_.verdict == NmeaVerdict::valid;
  const bool agrees = has_time && sentence_age_ >= youngest_sentence && sentence_age_ <= oldest_sentence;
  if (telemetry.is(Pps::absent)) return agrees ? ClockClaim::agrees : ClockClaim::none;
  if (telemetry.is(Pps::synchronising)) return ClockClaim::synchronising;
  if (telemetry.is(Pps::error)) return ClockClaim::pps_error;
  if (!telemetry.is(Pps::locked)) return ClockClaim::unknown;
  if (agrees) return ClockClaim::synchronised;
  return has_time ? ClockClaim::other_time : ClockClaim::no_time;
}

void TelemetryReceiver::send_sentence(FrameReceiver& out, bool age_known) {
  if (nmea_.verdict == NmeaVerdict::absent || is_junk(nmea_.verdict)) return;
  const bool valid = nmea_.verdict == NmeaVerdict::valid;
  const bool synchronised = claim_ == ClockClaim::synchronised;
  const NmeaReading nowhere;
  const NmeaReading& position = valid ? nmea_ : nowhere;
  fix_->stamp = host_time(synchronised ? device_ - sentence_age_ : device_);
  fix_->status = position.status;
  fix_->latitude_deg = position.latitude_deg;
  fix_->longitude_deg = position.longitude_deg;
  fix_->altitude_m = position.altitude_m;
  fix_->source_time = position.utc;
  out.message(fix_);
  if (!position.utc || !(synchronised || age_known)) return;
  reference_->stamp = host_time(device_);
  reference_->reference = *position.utc + (synchronised ? sentence_age_ : Span(0));
  reference_->source = synchronised ? "gps_pps" : "gps_nmea";
  out.message(reference_);
}

void TelemetryReceiver::send_imu(const RawImu& raw, FrameReceiver& out) {
  const auto turn = raw.angular_velocity();
  const auto push = raw.linear_acceleration();
  imu_->stamp = host_time(device_);
  imu_->angular_velocity = {turn[0], turn[1], turn[2]};
  imu_->linear_acceleration = {push[0], push[1], push[2]};
  out.message(imu_);
}

void TelemetryReceiver::set_claim(ClockClaim claim, DeviceInfo& info) {
  info.replace_warning(text_of(claim_).warning, text_of(claim).warning);
  claim_ = claim;
  if (claim == ClockClaim::silent) info.set("Sensor clock", text_of(claim).state);
}

void TelemetryReceiver::describe(const Telemetry& telemetry, const Packet& packet, DeviceInfo& info) {
  const Stamp arrival = packet.arrival;
  last_described_ = arrival;
  // Live arrivals leave out the steps of the host's clock.
  const Span host(packet.received.ns != 0 ? packet.received.ns : arrival.ns);
  described_pps_ = telemetry.pps;
  info.set("PPS", text_of_pps(telemetry.pps));
  info.set("Sensor clock", text_of(claim_).state);
  set(info, "Clock difference to host (s)", "%.3f", seconds(hour_difference(host, toh_)));
  info.set("NMEA", text_of(nmea_));
  if (nmea_.verdict != NmeaVerdict::absent)
    set(info, "NMEA age (s)", "%.1f", seconds(arrival - sentence_arrival_));
  set(info, "NMEA sentences not understood", "%llu", static_cast<unsigned long long>(bad_sentences_));
  if (telemetry.health) describe_health(*telemetry.health, info);
  if (!has_imu_ || !telemetry.imu) return;
  const auto& t = telemetry.imu->temperature_c;
  set(info, "Temperature gyros (C)", "%.1f", (t[0] + t[1] + t[2]) / 3);
}

}  // namespace lidard::velodyne
