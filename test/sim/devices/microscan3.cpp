// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/microscan3.h"

#include <algorithm>
#include <cmath>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

// SICK 8022708 p. 14-15: header of each datagram, at most 1460 bytes in all.
constexpr std::size_t datagram_header_bytes = 24;
constexpr std::size_t datagram_data_bytes = 1436;
// SICK 8022708 p. 16-19: the data header and the blocks it points to.
constexpr std::size_t data_header_bytes = 76;
constexpr std::size_t state_bytes = 16;
constexpr std::size_t derived_bytes = 24;
constexpr std::size_t application_bytes = 264;
constexpr std::size_t cut_off_paths = 24;
constexpr double angle_unit = 4194304;  // 1/deg, SICK 8022708 p. 19
// Status bits of a beam, SICK 8022708 p. 20-21.
constexpr unsigned status_valid = 1U << 0U;
constexpr unsigned status_infinite = 1U << 1U;
constexpr unsigned status_reflector = 1U << 3U;
constexpr unsigned status_contamination = 1U << 4U;
// Fragments of one instance follow each other on a 100 Mbit/s line with a pause of the device's own.
constexpr Span fragment_pause{20'000};
constexpr std::int64_t epoch_days = 730;  // from 1970-01-01 to 1972-01-01
constexpr std::int64_t ms_per_day = 86'400'000;

class MicroScan3 : public SensorModel {
 public:
  MicroScan3(const MicroScan3Options& options, const SensorEntry& entry, Stamp start)
      : options_(options),
        clock_offset_(entry.clock_offset),
        no_echo_mm_(static_cast<std::uint32_t>(std::lround(entry.range_max * 1000))),
        start_(start),
        first_angle_(std::llround(options.start_deg * angle_unit)),
        step_(std::llround(options.resolution_deg * angle_unit)),
        count_(static_cast<std::size_t>((options.end_deg * angle_unit - static_cast<double>(first_angle_)) /
                                        static_cast<double>(step_)) +
               1) {}

  const std::vector<Beam>& next() override {
    const Stamp begin = start_ + scan_ * options_.scan_time;
    beams_.clear();
    for (std::size_t i = 0; i < count_; ++i) beams_.push_back(beam(begin, i));
    ++scan_;
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings& around,
              std::vector<Datagram>& datagrams, std::vector<SlotTruth>& slots) override {
    for (std::size_t i = 0; i < count_; ++i) slots.push_back(truth(i, answers[i].near()));
    Wire instance(data_header_bytes);
    put_header(instance);
    put_block(instance, 32, state());
    put_block(instance, 36, derived_values());
    put_block(instance, 40, measurement(answers));
    put_block(instance, 44, intrusion(answers));
    put_block(instance, 48, application(around));
    split(instance.bytes(), datagrams);
  }

 private:
  double angle_deg(std::size_t i) const {
    return static_cast<double>(first_angle_ + static_cast<std::int64_t>(i) * step_) / angle_unit;
  }
  /// ns from one beam to the next: a turn takes the scan time.
  double beam_period() const {
    return static_cast<double>(options_.scan_time.count()) * (static_cast<double>(step_) / angle_unit) / 360;
  }

  Beam beam(Stamp begin, std::size_t i) const {
    Beam beam;
    beam.time = begin + Span(std::llround(static_cast<double>(i) * beam_period()));
    beam.azimuth = angle_deg(i) * rad_per_deg;
    const double ros = (angle_deg(i) - 90) * rad_per_deg;
    beam.ray.direction = {std::cos(ros), std::sin(ros), 0};
    return beam;
  }

  static std::uint32_t millimetres(const Answer::Echo& echo) {
    return static_cast<std::uint32_t>(std::lround(echo.distance * 1000));
  }

  static std::uint64_t percent(double reflectivity) {
    return static_cast<std::uint64_t>(std::min(255L, std::lround(100 * reflectivity)));
  }

  bool dirty(std::size_t i) const {
    return std::any_of(options_.dirty_deg.begin(), options_.dirty_deg.end(), [&](const auto& sector) {
      return angle_deg(i) >= sector.first && angle_deg(i) <= sector.second;
    });
  }
  bool any_dirty() const { return !options_.dirty_deg.empty(); }

  SlotTruth truth(std::size_t i, const Answer::Echo& echo) const {
    SlotTruth slot;
    slot.time = beams_[i].time;
    slot.azimuth = beams_[i].azimuth;
    slot.exact = echo.exact;
    if (dirty(i)) {
      slot.wire = std::nan("");
    } else if (echo.distance < no_hit) {
      slot.wire = wire_distance(millimetres(echo), 1);
    }
    slot.reflectivity = echo.reflectivity;
    slot.xyz = echo.exact * beams_[i].ray.direction;
    return slot;
  }

  // SICK 8022708 p. 16-19. The stamp is the time when the data set was made.
  void put_header(Wire& wire) const {
    const Stamp made = beams_.back().time + clock_offset_;
    const std::int64_t ms = made.ns / 1'000'000;
    const auto scan = static_cast<std::uint64_t>(scan_ - 1);
    wire.put8(0, 'R');
    wire.put8(1, 2);
    wire.put8(2, 1);
    wire.put32(4, options_.serial);
    wire.put32(8, options_.serial + 1);
    wire.put32(16, scan);
    wire.put32(20, options_.first_scan + scan);
    wire.put16(24, static_cast<std::uint64_t>(ms / ms_per_day - epoch_days));
    wire.put32(28, static_cast<std::uint64_t>(ms % ms_per_day));
  }

  static void put_block(Wire& instance, std::size_t entry, const Wire& block) {
    instance.put16(entry, instance.size());
    instance.put16(entry + 2, block.size());
    instance.copy(instance.size(), block.bytes().data(), block.size());
  }

  // SICK 8022708 p. 18-19.
  Wire state() const {
    Wire wire(state_bytes);
    constexpr unsigned run_mode = 1U << 0U;
    constexpr unsigned contamination_warning = 1U << 2U;
    wire.put8(0, run_mode | (any_dirty() ? contamination_warning : 0U));
    wire.put8(10, 1);
    return wire;
  }

  // SICK 8022708 p. 19 and 53; the time between beams is in us, as the telegram on p. 53 proves.
  Wire derived_values() const {
    Wire wire(derived_bytes);
    wire.put16(0, 1);
    wire.put16(2, count_);
    wire.put16(4, static_cast<std::uint64_t>(options_.scan_time.count() / 1'000'000));
    wire.put32(8, static_cast<std::uint64_t>(first_angle_));
    wire.put32(12, static_cast<std::uint64_t>(step_));
    wire.put32(16, static_cast<std::uint64_t>(std::llround(beam_period() / 1000)));
    return wire;
  }

  // SICK 8022708 p. 20-21. A beam without echo is valid, infinite and as far as the largest range, as the
  // recorded microScan3 tells it (microscan3_398: 40000 mm, flags 0x03).
  Wire measurement(const std::vector<Answer>& answers) const {
    Wire wire(4 + 4 * count_);
    wire.put32(0, count_);
    for (std::size_t i = 0; i < count_; ++i) {
      const std::size_t at = 4 + 4 * i;
      const Answer::Echo& echo = answers[i].near();
      const bool hit = answers[i].count > 0;
      wire.put16(at, dirty(i) ? 0 : hit ? std::min(millimetres(echo), 65535U) : no_echo_mm_);
      wire.put8(at + 2, hit ? percent(echo.reflectivity) : 0U);
      unsigned status = hit ? status_valid : status_valid | status_infinite;
      if (hit && echo.reflectivity > 1) status |= status_reflector;
      if (dirty(i)) status = status_contamination;
      wire.put8(at + 3, status);
    }
    return wire;
  }

  // SICK 8022708 p. 22: each cut-off path has a length in bytes and one bit per beam, or the length 0.
  Wire intrusion(const std::vector<Answer>& answers) const {
    const std::size_t flags = options_.protective_field > 0 ? (count_ + 7) / 8 : 0;
    Wire wire(4 * cut_off_paths + flags);
    if (flags == 0) return wire;
    wire.put32(0, flags);
    std::vector<std::uint8_t> bits(flags);
    for (std::size_t i = 0; i < count_; ++i) {
      const bool inside = answers[i].count > 0 && answers[i].near().distance < options_.protective_field;
      if (inside) bits[i / 8] = static_cast<std::uint8_t>(bits[i / 8] | 1U << i % 8);
    }
    wire.copy(4, bits.data(), bits.size());
    return wire;
  }

  // SICK 8022708 p. 23-27: monitoring case 1 of table 1 is in use; both velocities are the vehicle's, in
  // mm/s.
  static Wire application(const Surroundings& around) {
    Wire wire(application_bytes);
    const auto velocity = static_cast<std::uint64_t>(std::lround(around.speed * 1000));
    constexpr unsigned both_valid = 3;
    wire.put16(12, 1);
    wire.put32(52, 1);
    wire.put16(56, velocity);
    wire.put16(58, velocity);
    wire.put8(60, both_valid);
    wire.put16(152, 1);
    wire.put32(192, 1);
    wire.put8(196, 2);  // not in standby (p. 26; unverified against a device)
    wire.put16(200, velocity);
    wire.put16(202, velocity);
    wire.put8(204, both_valid);
    return wire;
  }

  void split(const std::vector<std::uint8_t>& instance, std::vector<Datagram>& datagrams) const {
    Stamp ready = beams_.back().time;
    for (std::size_t at = 0; at < instance.size(); at += datagram_data_bytes) {
      const std::size_t length = std::min(datagram_data_bytes, instance.size() - at);
      Wire wire(datagram_header_bytes);
      wire.copy(0, "MS3 MD", 6);
      wire.put8(6, 1);
      wire.put32(8, instance.size());
      wire.put32(12, static_cast<std::uint64_t>(scan_ - 1));
      wire.put32(16, at);
      wire.copy(datagram_header_bytes, instance.data() + at, length);
      datagrams.push_back({ready, 0, wire.take()});
      ready = ready + fragment_pause;
    }
  }

  MicroScan3Options options_;
  Span clock_offset_;
  std::uint32_t no_echo_mm_;
  Stamp start_;
  std::int64_t first_angle_;  // 1/4194304 deg
  std::int64_t step_;
  std::size_t count_;
  std::int64_t scan_ = 0;
  std::vector<Beam> beams_;
};

}  // namespace

SafetySettings safety_settings(const MicroScan3Options& options, const SensorEntry& entry) {
  SafetySettings settings;
  // Type codes of products; that of the nanoScan3 and the outdoorScan3 are unverified.
  if (entry.model == "sick_nanoscan3") settings.type_code = "NANS3-CAAZ40ZA1P01";
  if (entry.model == "sick_outdoorscan3") settings.type_code = "MICS3-CBUZ40IZ1P01";
  settings.serial = std::to_string(options.serial);
  settings.device_name = entry.name;
  settings.fields = {"Front", "Slow"};
  settings.cases = {{1, {1, 2}}};
  const auto step = std::llround(options.resolution_deg * angle_unit);
  const double span_deg = options.end_deg - options.start_deg;
  settings.derived.beams = static_cast<std::uint16_t>(span_deg * angle_unit / static_cast<double>(step) + 1);
  settings.derived.scan_time_ms = static_cast<std::uint16_t>(options.scan_time.count() / 1'000'000);
  settings.derived.start = static_cast<std::int32_t>(std::llround(options.start_deg * angle_unit));
  settings.derived.step = static_cast<std::int32_t>(step);
  settings.derived.beam_period_us = static_cast<std::uint32_t>(
      std::llround(static_cast<double>(options.scan_time.count()) / 1000 * options.resolution_deg / 360));
  settings.persistent.enabled = true;
  settings.persistent.host = entry.to.address;
  settings.persistent.port = entry.to.port;
  settings.current = settings.persistent;
  return settings;
}

ModelMaker make_microscan3(const MicroScan3Options& options) {
  return [options](const SensorEntry& entry, Stamp start) {
    return std::make_unique<MicroScan3>(options, entry, start);
  };
}

}  // namespace lidard::sim
