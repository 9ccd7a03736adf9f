// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "test/sim/devices/hdl64_status.h"
#include "test/sim/devices/velodyne_head.h"
#include "test/sim/devices/velodyne_telemetry.h"
#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

using Content = BlockPlan::Content;

// Velodyne 63-9243 (VLP-16 User Manual) ch. 9.3: 12 blocks of 100 bytes, then stamp, mode, product.
constexpr std::size_t block_slots = 32;
constexpr std::size_t block_bytes = 100;
constexpr std::size_t stamp_at = 1200;
constexpr std::size_t mode_at = 1204;
constexpr std::size_t product_at = 1205;
constexpr std::size_t data_bytes = 1206;
constexpr std::int64_t ns_per_hour = 3'600'000'000'000;

// 0x3B: VeloView and UniBwTAS/velodyne.
std::uint8_t mode_byte(ReturnMode mode) {
  constexpr std::uint8_t bytes[] = {0x37, 0x38, 0x39, 0x3b};
  return bytes[static_cast<std::size_t>(mode)];
}

// 0..110: diffuse surfaces of 0..100 %, above: retro-reflectors (Velodyne 63-9243 ch. 6.1).
std::uint8_t reflectivity_byte(double reflectivity) {
  if (reflectivity <= 1) return static_cast<std::uint8_t>(std::lround(110 * std::max(0.0, reflectivity)));
  return static_cast<std::uint8_t>(110 + std::lround(145 * std::min(reflectivity - 1, 1.0)));
}

Answer::Echo chosen(const Answer& answer, Content content) {
  if (content == Content::last) return answer.far();
  // Of two echoes one is the last, so the other block of a pair always holds the near one.
  if (content == Content::second || answer.count < 2) return answer.near();
  const auto power = [](const Answer::Echo& echo) { return echo.reflectivity / (echo.exact * echo.exact); };
  return power(answer.near()) >= power(answer.far()) ? answer.near() : answer.far();
}

Hdl64State hdl64_state(const VelodyneTable& table, const VelodyneTiming& timing,
                       const VelodyneOptions& options) {
  Hdl64State state;
  state.s3 = std::string(table.name) == "velodyne_hdl64e_s3";
  state.dual = options.mode == ReturnMode::dual;
  state.last = options.mode == ReturnMode::last;
  state.synchronised = options.pps_locked;
  state.rpm = options.turn_deg.value_or(timing.turn_deg) / 6 * 1e9 / static_cast<double>(timing.period_ns());
  return state;
}

class Velodyne : public SensorModel {
 public:
  Velodyne(const VelodyneTable& table, const VelodyneOptions& options, const SensorEntry& entry, Stamp start)
      : table_(table),
        timing_(velodyne_timing(table, options.timing)),
        options_(options),
        clock_offset_(entry.clock_offset),
        start_(start),
        group_(sequences_per_azimuth(table.lasers.size())),
        head_(timing_, options, group_, table.bank_by_bank ? encoder_step_deg : 0, start),
        plan_(table.bank_by_bank ? plan_bank_by_bank(options.mode)
                                 : plan_packet(table.lasers.size(), options.mode)),
        status_(table.lasers, hdl64_state(table, timing_, options)) {
    if (options_.telemetry_hz > 0) telemetry_period_ = span_from_seconds(1 / options_.telemetry_hz);
    has_status_ = table.has_status() && options.status_stream;
  }

  const std::vector<Beam>& next() override {
    beams_.clear();
    azimuths_.clear();
    std::size_t last_beam = 0;
    for (const BlockPlan& block : plan_) last_beam = std::max(last_beam, block.first_beam);
    while (beams_.size() <= last_beam) add_group();
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings& /*around*/,
              std::vector<Datagram>& datagrams, std::vector<SlotTruth>& slots) override {
    Wire wire(data_bytes);
    for (std::size_t i = 0; i < plan_.size(); ++i) put_block(wire, i, answers, slots);
    put_end(wire);
    ++packets_;
    const Stamp ready = beams_.back().time;
    put_telemetry(ready, datagrams);
    datagrams.push_back({ready, 0, wire.take()});
  }

 private:
  std::size_t beams_per_azimuth() const { return group_ * table_.lasers_per_sequence(); }

  void add_group() {
    const Stamp begin = head_.next_group();
    const std::size_t first = table_.bank_by_bank ? 32 * bank_of_sequence(azimuths_.size()) : 0;
    azimuths_.push_back(head_.wire_azimuth(begin));
    for (std::size_t s = 0; s < group_; ++s) {
      const Stamp sequence = begin + Span(static_cast<std::int64_t>(s) * timing_.sequence_ns);
      for (std::size_t k = 0; k < table_.lasers_per_sequence(); ++k) {
        const std::size_t laser = first + k;
        beams_.push_back(beam(sequence + Span(timing_.firing_ns[laser]), laser));
      }
    }
  }

  Beam beam(Stamp time, std::size_t index) const {
    const VelodyneLaser& laser = table_.lasers[index];
    Beam beam;
    beam.time = time;
    // The rot_correction of an S1 counts from the azimuth of the block: it holds the turn until the laser
    // fires.
    const double head_deg = table_.bank_by_bank ? azimuths_.back() * 0.01 : head_.azimuth_deg(time);
    beam.azimuth = std::fmod(head_deg - laser.rot_correction_deg + 360, 360.0) * rad_per_deg;
    beam.laser = static_cast<std::uint16_t>(index);
    const double elevation = laser.elevation_deg * rad_per_deg;
    // The azimuth counts clockwise from the sensor's front, which is x in ROS.
    beam.ray.origin = {0, 0, laser.z_offset_mm / 1000};
    beam.ray.direction = {std::cos(elevation) * std::cos(beam.azimuth),
                          -std::cos(elevation) * std::sin(beam.azimuth), std::sin(elevation)};
    return beam;
  }

  void put_block(Wire& wire, std::size_t index, const std::vector<Answer>& answers,
                 std::vector<SlotTruth>& slots) const {
    const BlockPlan& block = plan_[index];
    const std::size_t at = index * block_bytes;
    const bool dummy = block.content == Content::dummy;
    wire.put16(at, block.flag);
    wire.put16(at + 2, dummy ? 0xffffU : azimuths_[block.first_beam / beams_per_azimuth()]);
    for (std::size_t k = 0; k < block_slots; ++k) {
      const Beam& beam = beams_[block.first_beam + k];
      const Answer& answer = answers[block.first_beam + k];
      const std::size_t slot_at = at + 4 + 3 * k;
      if (dummy || block.content == Content::confidence) {
        put_word(wire, slot_at, dummy ? 0xffffffU : confidence_word(answer));
        slots.push_back(no_truth(beam));
      } else {
        slots.push_back(put_return(wire, slot_at, beam, chosen(answer, block.content)));
      }
      slots.back().echo = block.echo;
    }
  }

  SlotTruth put_return(Wire& wire, std::size_t at, const Beam& beam, const Answer::Echo& echo) const {
    const std::uint32_t count = distance_count(echo.distance);
    wire.put16(at, count);
    wire.put8(at + 2, count == 0 ? 0U : reflectivity_byte(echo.reflectivity));
    return truth(beam, echo, count);
  }

  // 24 bits: the place of the distance holds the upper 16, that of the reflectivity the lower 8
  // (UniBwTAS/velodyne). Return 2 has the upper half.
  static void put_word(Wire& wire, std::size_t at, std::uint32_t word) {
    wire.put16(at, word >> 8U);
    wire.put8(at + 2, word & 0xffU);
  }

  static std::uint32_t confidence_word(const Answer& answer) {
    const Answer::Echo first = chosen(answer, Content::last);
    const Answer::Echo second = chosen(answer, Content::second);
    return confidence_bits(second.exact, second.reflectivity) << 12U |
           confidence_bits(first.exact, first.reflectivity);
  }

  std::uint32_t distance_count(double distance) const {
    const double count = distance * 1000 / table_.step_mm;
    return count < 65535.5 ? static_cast<std::uint32_t>(std::lround(count)) : 0;
  }

  SlotTruth truth(const Beam& beam, const Answer::Echo& echo, std::uint32_t count) const {
    SlotTruth slot;
    slot.time = beam.time;
    slot.azimuth = beam.azimuth;
    slot.exact = echo.exact;
    slot.wire = wire_distance(count, table_.step_mm);
    slot.reflectivity = echo.reflectivity;
    slot.laser = beam.laser;
    slot.xyz = beam.ray.origin + echo.exact * beam.ray.direction;
    return slot;
  }

  SlotTruth no_truth(const Beam& beam) const {
    SlotTruth slot = truth(beam, {}, 0);
    slot.wire = std::numeric_limits<double>::quiet_NaN();
    return slot;
  }

  void put_end(Wire& wire) const {
    if (table_.bank_by_bank) return put_text(wire);
    const Stamp stamp =
        options_.old_stamp ? beams_.back().time : beams_.front().time + Span(timing_.stamp_lag_ns);
    wire.put32(stamp_at, device_us(stamp));
    if (has_status_) {
      const auto status = status_.at(packets_, stamp + clock_offset_);
      wire.put8(mode_at, status[0]);
      wire.put8(product_at, status[1]);
    } else if (table_.product != 0 && !options_.old_stamp) {
      wire.put8(mode_at, mode_byte(options_.mode));
      wire.put8(product_at, table_.product);
    }
  }

  /// What the capture of an S1 has in turn; what its numbers mean is not known.
  void put_text(Wire& wire) const {
    constexpr std::uint8_t texts[2][6] = {{'Q', ' ', 'D', 'e', 'g', 'C'}, {'"', 0x0c, 'v', '2', '5', 'c'}};
    for (std::size_t i = 0; i < 6; ++i) wire.put8(stamp_at + i, texts[packets_ % 2][i]);
  }

  std::uint32_t device_us(Stamp time) const {
    const std::int64_t since_hour = ((time + clock_offset_).ns % ns_per_hour + ns_per_hour) % ns_per_hour;
    return static_cast<std::uint32_t>(since_hour / 1000);
  }

  void put_telemetry(Stamp until, std::vector<Datagram>& datagrams) {
    if (telemetry_period_.count() == 0) return;
    for (Stamp due = start_ + telemetry_count_ * telemetry_period_; due <= until;
         due = start_ + ++telemetry_count_ * telemetry_period_) {
      datagrams.push_back({due, position_port,
                           position_packet({table_.telemetry, device_us(due), options_.pps_locked, due})});
    }
  }

  const VelodyneTable& table_;
  const VelodyneTiming& timing_;
  VelodyneOptions options_;
  Span clock_offset_;
  Stamp start_;
  std::size_t group_;
  VelodyneHead head_;
  std::vector<BlockPlan> plan_;
  Hdl64Status status_;
  bool has_status_ = false;
  std::size_t packets_ = 0;
  Span telemetry_period_{0};
  std::int64_t telemetry_count_ = 0;
  std::vector<Beam> beams_;
  std::vector<std::uint16_t> azimuths_;  ///< on the wire, per group of sequences
};

}  // namespace

const VelodyneTiming& velodyne_timing(const VelodyneTable& table, const std::string& name) {
  for (const VelodyneTiming& timing : table.timings) {
    if (name.empty() || timing.name == name) return timing;
  }
  throw std::invalid_argument(std::string(table.name) + " has no timing '" + name + "'");
}

ModelMaker make_velodyne(const VelodyneTable& table, const VelodyneOptions& options) {
  return [&table, options](const SensorEntry& entry, Stamp start) {
    return std::make_unique<Velodyne>(table, options, entry, start);
  };
}

}  // namespace lidard::sim
