// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/velodyne.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "test/sim/wire.h"

namespace lidard::sim {
namespace {

// Velodyne 63-9243 (VLP-16 User Manual) ch. 9.3: 12 blocks of 100 bytes, then stamp, mode, product.
constexpr std::size_t blocks = 12;
constexpr std::size_t block_slots = 32;
constexpr std::size_t block_bytes = 100;
constexpr std::size_t stamp_at = 1200;
constexpr std::size_t mode_at = 1204;
constexpr std::size_t product_at = 1205;
constexpr std::size_t data_bytes = 1206;
// Velodyne 63-9243 ch. 9.3.2, and VeloView's vtkVelodyneHDLPositionReader for the offsets.
constexpr std::size_t position_bytes = 512;
constexpr std::size_t position_stamp_at = 0xc6;
constexpr std::size_t position_pps_at = 0xca;
constexpr std::size_t position_nmea_at = 0xce;
constexpr std::uint16_t position_port = 8308;
constexpr std::int64_t ns_per_hour = 3'600'000'000'000;

std::uint8_t mode_byte(ReturnMode mode) {
  return mode == ReturnMode::strongest ? 0x37 : mode == ReturnMode::last ? 0x38 : 0x39;
}

// 0..110: diffuse surfaces of 0..100 %, above: retro-reflectors (Velodyne 63-9243 ch. 6.1).
std::uint8_t reflectivity_byte(double reflectivity) {
  if (reflectivity <= 1) return static_cast<std::uint8_t>(std::lround(110 * std::max(0.0, reflectivity)));
  return static_cast<std::uint8_t>(110 + std::lround(145 * std::min(reflectivity - 1, 1.0)));
}

class Velodyne : public SensorModel {
 public:
  Velodyne(const VelodyneTable& table, const VelodyneOptions& options, const SensorEntry& entry, Stamp start)
      : table_(table), options_(options), clock_offset_(entry.clock_offset), start_(start), begin_(start) {
    if (options_.telemetry_hz > 0) telemetry_period_ = span_from_seconds(1 / options_.telemetry_hz);
  }

  const std::vector<Beam>& next() override {
    begin_ = start_ + Span(packet_++ * static_cast<std::int64_t>(sequences()) * table_.sequence_ns);
    beams_.clear();
    for (std::size_t s = 0; s < sequences(); ++s) {
      for (std::size_t laser = 0; laser < table_.lasers.size(); ++laser) beams_.push_back(beam(s, laser));
    }
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings& /*around*/,
              std::vector<Datagram>& datagrams, std::vector<SlotTruth>& slots) override {
    Wire wire(data_bytes);
    for (std::size_t block = 0; block < blocks; ++block) put_block(wire, block, answers, slots);
    wire.put32(stamp_at, device_us(begin_));
    wire.put8(mode_at, mode_byte(options_.mode));
    wire.put8(product_at, table_.product);
    const Stamp ready = beams_.back().time;
    put_telemetry(ready, datagrams);
    datagrams.push_back({ready, 0, wire.take()});
  }

 private:
  bool dual() const { return options_.mode == ReturnMode::dual; }
  std::size_t sequences() const { return blocks * block_slots / table_.lasers.size() / (dual() ? 2 : 1); }

  double azimuth_deg(Stamp time) const {
    const auto since = static_cast<double>((time - start_).count());
    const double turned = since / static_cast<double>(table_.sequence_ns) * options_.sequence_turn_deg;
    return std::fmod(options_.start_azimuth_deg + turned, 360.0);
  }

  Beam beam(std::size_t sequence, std::size_t index) const {
    const VelodyneLaser& laser = table_.lasers[index];
    Beam beam;
    beam.time = begin_ + Span(static_cast<std::int64_t>(sequence) * table_.sequence_ns + laser.firing_ns);
    beam.azimuth = azimuth_deg(beam.time) * rad_per_deg;
    beam.laser = static_cast<std::uint16_t>(index);
    const double elevation = laser.elevation_deg * rad_per_deg;
    // The azimuth counts clockwise from the sensor's front, which is x in ROS.
    beam.ray.origin = {0, 0, laser.z_offset_mm / 1000};
    beam.ray.direction = {std::cos(elevation) * std::cos(beam.azimuth),
                          -std::cos(elevation) * std::sin(beam.azimuth), std::sin(elevation)};
    return beam;
  }

  // In dual mode a pair of blocks holds the same beams: first the last return, then the strongest, or the
  // second strongest where the strongest is the last (Velodyne 63-9243 ch. 9.3, dual return).
  void put_block(Wire& wire, std::size_t block, const std::vector<Answer>& answers,
                 std::vector<SlotTruth>& slots) const {
    const std::size_t at = block * block_bytes;
    const std::size_t first = (dual() ? block / 2 : block) * block_slots;
    const auto azimuth = std::llround(azimuth_deg(beams_[first].time) * 100) % 36000;
    wire.put16(at, 0xeeff);
    wire.put16(at + 2, static_cast<std::uint64_t>(azimuth));
    for (std::size_t k = 0; k < block_slots; ++k) {
      const auto echo = chosen(answers[first + k], block);
      const std::uint32_t count = distance_count(echo.distance);
      wire.put16(at + 4 + 3 * k, count);
      wire.put8(at + 6 + 3 * k, count == 0 ? 0U : reflectivity_byte(echo.reflectivity));
      slots.push_back(truth(beams_[first + k], echo, count));
      slots.back().echo = static_cast<std::uint8_t>(dual() ? block % 2 : 0);
    }
  }

  Answer::Echo chosen(const Answer& answer, std::size_t block) const {
    if (options_.mode == ReturnMode::last || (dual() && block % 2 == 0)) return answer.far();
    // Of two echoes one is the last, so the odd block of a pair always holds the near one.
    if (dual() || answer.count < 2) return answer.near();
    const auto power = [](const Answer::Echo& echo) { return echo.reflectivity / (echo.exact * echo.exact); };
    return power(answer.near()) >= power(answer.far()) ? answer.near() : answer.far();
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

  std::uint64_t device_us(Stamp time) const {
    const std::int64_t since_hour = ((time + clock_offset_).ns % ns_per_hour + ns_per_hour) % ns_per_hour;
    return static_cast<std::uint64_t>(since_hour / 1000);
  }

  void put_telemetry(Stamp until, std::vector<Datagram>& datagrams) {
    if (telemetry_period_.count() == 0) return;
    for (Stamp due = start_ + telemetry_count_ * telemetry_period_; due <= until;
         due = start_ + ++telemetry_count_ * telemetry_period_) {
      Wire wire(position_bytes);
      wire.put32(position_stamp_at, device_us(due));
      wire.put8(position_pps_at, options_.pps_locked ? 2 : 0);
      const std::string sentence = gprmc(due, options_.pps_locked);
      wire.copy(position_nmea_at, sentence.data(), sentence.size());
      datagrams.push_back({due, position_port, wire.take()});
    }
  }

  VelodyneTable table_;
  VelodyneOptions options_;
  Span clock_offset_;
  Stamp start_;
  Stamp begin_;
  std::int64_t packet_ = 0;
  Span telemetry_period_{0};
  std::int64_t telemetry_count_ = 0;
  std::vector<Beam> beams_;
};

VelodyneTable make_vlp16_table() {
  // Elevation and height, Velodyne 63-9243 table 9-1; a laser fires every 2.304 us (ch. 9.4).
  VelodyneTable table{"velodyne_vlp16", 0x22, 2.0, 55'296, {}, 0.1, 100.0};
  const double rows[16][2] = {{-15, 11.2}, {1, -0.7},  {-13, 9.7}, {3, -2.2},  {-11, 8.1}, {5, -3.7},
                              {-9, 6.6},   {7, -5.1},  {-7, 5.1},  {9, -6.6},  {-5, 3.7},  {11, -8.1},
                              {-3, 2.2},   {13, -9.7}, {-1, 0.7},  {15, -11.2}};
  for (const auto& row : rows) {
    table.lasers.push_back({row[0], row[1], static_cast<std::int64_t>(table.lasers.size()) * 2'304});
  }
  return table;
}

}  // namespace

const VelodyneTable& vlp16_table() {
  static const VelodyneTable table = make_vlp16_table();
  return table;
}

ModelMaker make_velodyne(const VelodyneTable& table, const VelodyneOptions& options) {
  return [table, options](const SensorEntry& entry, Stamp start) {
    return std::make_unique<Velodyne>(table, options, entry, start);
  };
}

std::string gprmc(Stamp time, bool valid) {
  const std::time_t second = static_cast<std::time_t>(time.ns / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&second, &utc);
  char when[2][16];
  std::strftime(when[0], sizeof when[0], "%H%M%S", &utc);
  std::strftime(when[1], sizeof when[1], "%d%m%y", &utc);
  const std::string body = std::string("GPRMC,") + when[0] + (valid ? ",A" : ",V") +
                           ",0000.0000,N,00000.0000,E,000.0,000.0," + when[1] + ",000.0,E";
  unsigned sum = 0;
  for (const char c : body) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum & 0xffU);
  return "$" + body + end;
}

}  // namespace lidard::sim
