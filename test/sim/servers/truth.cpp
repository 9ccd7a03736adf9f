// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/truth.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>

#include "test/sim/devices/wire.h"

namespace lidard::sim {
namespace {

constexpr char magic[] = "LIDTRUTH";
constexpr std::size_t head_bytes = 16;    // magic, version, number of sensors
constexpr std::size_t sensor_bytes = 80;  // name[32], model[32], records, slots, offset
constexpr std::size_t name_bytes = 32;
constexpr std::size_t record_bytes = 48;  // before the ranges
constexpr std::uint32_t version = 1;

void put_double(Wire& wire, std::size_t at, double value) { wire.copy(at, &value, sizeof value); }

double get_double(ByteView bytes, std::size_t at) {
  const std::uint64_t bits = bytes.le64(at);
  double value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

float get_float(ByteView bytes, std::size_t at) {
  const std::uint32_t bits = bytes.le32(at);
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

void put_name(Wire& wire, std::size_t at, const std::string& name) {
  wire.copy(at, name.data(), std::min(name.size(), name_bytes - 1));
}

std::string get_name(ByteView bytes, std::size_t at) {
  const std::string_view field = bytes.sub(at, name_bytes).text();
  return std::string(field.substr(0, field.find('\0')));
}

void put_record(Wire& wire, const TruthRecord& record) {
  const std::size_t at = wire.size();
  wire.put64(at, static_cast<std::uint64_t>(record.begin.ns));
  wire.put32(at + 8, static_cast<std::uint64_t>((record.end - record.begin).count()));
  wire.put32(at + 12, record.record);
  wire.put32(at + 16, record.number);
  wire.put32(at + 20, 0);
  put_double(wire, at + 24, record.vehicle.x);
  put_double(wire, at + 32, record.vehicle.y);
  put_double(wire, at + 40, record.vehicle.yaw);
  wire.copy(at + record_bytes, record.ranges.data(), record.ranges.size() * sizeof(float));
}

TruthRecord get_record(ByteView bytes, std::size_t slots) {
  TruthRecord record;
  record.begin = {static_cast<std::int64_t>(bytes.le64(0))};
  record.end = record.begin + Span(bytes.le32(8));
  record.record = bytes.le32(12);
  record.number = bytes.le32(16);
  record.vehicle = {get_double(bytes, 24), get_double(bytes, 32), get_double(bytes, 40)};
  for (std::size_t i = 0; i < slots; ++i) record.ranges.push_back(get_float(bytes, record_bytes + 4 * i));
  return record;
}

std::size_t slots_of(const SensorTruth& sensor) {
  return sensor.records.empty() ? 0 : sensor.records.front().ranges.size();
}

SensorTruth get_sensor(ByteView bytes, std::size_t at, const std::string& name) {
  SensorTruth sensor;
  sensor.name = get_name(bytes, at);
  sensor.model = get_name(bytes, at + name_bytes);
  const std::size_t records = bytes.le32(at + 64);
  const std::size_t slots = bytes.le32(at + 68);
  const std::uint64_t offset = bytes.le64(at + 72);
  const std::size_t step = record_bytes + slots * sizeof(float);
  if (offset > bytes.size() || records > (bytes.size() - offset) / step) {
    throw TruthError(name + ": too short for what it announces; make it again with lidard-sim make");
  }
  for (std::size_t i = 0; i < records; ++i) {
    sensor.records.push_back(get_record(bytes.sub(offset + i * step, step), slots));
  }
  return sensor;
}

}  // namespace

TruthWriter::TruthWriter(const Scene& scene) {
  for (const SensorEntry& sensor : scene.sensors) sensors_.push_back({sensor.name, sensor.model, {}});
}

void TruthWriter::add(const Measurement& measurement, std::uint32_t record) {
  TruthRecord truth;
  truth.begin = measurement.begin;
  truth.end = measurement.end;
  truth.record = record;
  truth.number = static_cast<std::uint32_t>(measurement.number);
  truth.vehicle = measurement.vehicle;
  for (const SlotTruth& slot : measurement.slots) truth.ranges.push_back(static_cast<float>(slot.exact));
  sensors_[measurement.sensor].records.push_back(std::move(truth));
}

std::vector<std::uint8_t> TruthWriter::bytes() const {
  Wire wire(head_bytes + sensors_.size() * sensor_bytes);
  wire.copy(0, magic, 8);
  wire.put32(8, version);
  wire.put32(12, sensors_.size());
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const std::size_t at = head_bytes + i * sensor_bytes;
    put_name(wire, at, sensors_[i].name);
    put_name(wire, at + name_bytes, sensors_[i].model);
    wire.put32(at + 64, sensors_[i].records.size());
    wire.put32(at + 68, slots_of(sensors_[i]));
    wire.put64(at + 72, wire.size());
    for (const TruthRecord& record : sensors_[i].records) put_record(wire, record);
  }
  return wire.take();
}

std::vector<SensorTruth> parse_truth(ByteView bytes, const std::string& name) {
  if (bytes.size() < head_bytes || bytes.sub(0, 8).text() != magic || bytes.le32(8) != version) {
    throw TruthError(name + ": not a truth file of version 1; name one that lidard-sim make wrote");
  }
  const std::size_t count = bytes.le32(12);
  if (count > (bytes.size() - head_bytes) / sensor_bytes) {
    throw TruthError(name + ": too short for what it announces; make it again with lidard-sim make");
  }
  std::vector<SensorTruth> sensors;
  for (std::size_t i = 0; i < count; ++i)
    sensors.push_back(get_sensor(bytes, head_bytes + i * sensor_bytes, name));
  return sensors;
}

std::vector<SensorTruth> read_truth(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw TruthError(path + ": cannot be opened; name an existing file");
  const std::string content((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return parse_truth(ByteView(content), path);
}

}  // namespace lidard::sim
