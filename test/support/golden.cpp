// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/golden.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "test/support/captures.h"

namespace lidard::test {
namespace {

bool is_same_number(const std::string& a, const std::string& b) {
  if (a.find('.') == std::string::npos || b.find('.') == std::string::npos) return false;
  char *end_a = nullptr, *end_b = nullptr;
  const double x = std::strtod(a.c_str(), &end_a), y = std::strtod(b.c_str(), &end_b);
  if (end_a == a.c_str() || std::string(end_a) != std::string(end_b)) return false;
  return std::abs(x - y) <= 1e-3 + 1e-6 * std::max(std::abs(x), std::abs(y));
}

bool is_same_line(const std::string& a, const std::string& b) {
  if (a == b) return true;
  std::istringstream words_a(a), words_b(b);
  std::string word_a, word_b;
  while (words_a >> word_a) {
    if (!(words_b >> word_b) || !(word_a == word_b || is_same_number(word_a, word_b))) return false;
  }
  return !(words_b >> word_b);
}

std::vector<std::string> lines_of(std::istream& in) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::uint64_t hash_of(std::string_view text) {
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  return hash;
}

/// What a checksum in a golden file stands for goes to the file that LIDARD_GOLDEN_DETAILS names.
void note_details(std::string_view text) {
  if (const char* const details = std::getenv("LIDARD_GOLDEN_DETAILS"))
    std::ofstream(details, std::ios::app) << text << '\n';
}

}  // namespace

void expect_golden(const std::string& name, const std::string& text) {
  const std::string path = project_file("test/golden/" + name);
  if (std::getenv("LIDARD_WRITE_GOLDEN") != nullptr) {
    std::ofstream(path) << text;
    ADD_FAILURE() << path << " was written; look at what changed";
    return;
  }
  std::ifstream file(path);
  ASSERT_TRUE(file) << path << " cannot be read";
  std::istringstream now(text);
  const auto wanted = lines_of(file), got = lines_of(now);
  int shown = 0;
  for (std::size_t i = 0; i < std::max(wanted.size(), got.size()) && shown < 5; ++i) {
    const std::string was = i < wanted.size() ? wanted[i] : "nothing",
                      is = i < got.size() ? got[i] : "nothing";
    if (is_same_line(was, is)) continue;
    ADD_FAILURE() << path << ':' << i + 1 << "\n  was " << was << "\n  is  " << is;
    ++shown;
  }
}

void Sums::Sum::add(double value) {
  ++count;
  if (std::isnan(value)) {
    not_a_number += count;
  } else if (std::isinf(value)) {
    infinite += value > 0 ? count : 3 * count;
  } else {
    plain += value;
    by_place += value * static_cast<double>(1 + count % 97);
  }
}

void Sums::Sum::add_exact(std::int64_t value) {
  ++count;
  exact = exact * 31 + static_cast<std::uint64_t>(value);
}

void Sums::add(const std::string& name, double value) { sums_[name].add(value); }

void Sums::add_exact(const std::string& name, std::int64_t value) { sums_[name].add_exact(value); }

void Sums::add_text(const std::string& name, std::string_view value) {
  add_exact(name, static_cast<std::int64_t>(hash_of(value)));
}

void Sums::add_all(const std::string& name, const std::vector<float>& values) {
  if (values.empty()) return;
  Sum& sum = sums_[name];
  for (const float value : values) sum.add(static_cast<double>(value));
}

void Sums::scan(const std::string& name, const PlanarScan& scan) {
  EXPECT_EQ(violation(scan), nullptr) << name;
  add_exact(name + " stamp", scan.stamp.ns);
  add_exact(name + " beams", static_cast<std::int64_t>(scan.beams * 10 + scan.echoes));
  add_text(name + " frame", scan.frame_id);
  for (const float value : {scan.angle_min, scan.angle_max, scan.angle_increment})
    add(name + " angles", static_cast<double>(value) * 1000);
  for (const float value : {scan.time_increment, scan.scan_time})
    add(name + " times", static_cast<double>(value) * 1e6);
  add_all(name + " limits", {scan.range_min, scan.range_max, scan.none_as, scan.invalid_as});
  Sum& statuses = sums_[name + " statuses"];
  for (const BeamStatus status : scan.statuses) statuses.add_exact(static_cast<int>(status));
  add_all(name + " ranges", scan.ranges);
  add_all(name + " intensities", scan.intensities);
  add_all(name + " free_from", scan.free_from);
}

void Sums::cloud(const std::string& name, const Cloud& cloud) {
  add_exact(name + " stamp", cloud.stamp.ns);
  add_exact(name + " length", (cloud.end - cloud.stamp).count());
  add_exact(name + " size", static_cast<std::int64_t>(cloud.size()));
  add_exact(name + " columns", static_cast<std::int64_t>(cloud.columns.size()));
  add_exact(name + " expected", static_cast<std::int64_t>(cloud.expected_columns));
  add_exact(name + " rings", cloud.rings * 2 + (cloud.complete ? 1 : 0));
  add_exact(name + " format", static_cast<std::int64_t>(sizeof(CloudPoint)) + 1000 * cloud.height);
  add_text(name + " frame", cloud.frame_id);
  for (const CloudColumn& c : cloud.columns) {
    add_exact(name + " column", c.first_point + 7LL * c.packet + 1000LL * c.block + 100000LL * c.echo);
    add_exact(name + " column stamp", c.stamp.ns);
    add(name + " azimuth", static_cast<double>(c.azimuth));
  }
  Sum &xs = sums_[name + " x"], &ys = sums_[name + " y"], &zs = sums_[name + " z"],
      &intensities = sums_[name + " intensity"], &rings = sums_[name + " ring"],
      &times = sums_[name + " time"];
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    CloudPoint p;
    std::memcpy(&p, cloud.points_bytes.data() + i * sizeof p, sizeof p);
    const float x = p.x, y = p.y, z = p.z, intensity = p.intensity, time = p.time;
    xs.add(static_cast<double>(x)), ys.add(static_cast<double>(y)), zs.add(static_cast<double>(z));
    intensities.add(static_cast<double>(intensity));
    rings.add_exact(p.ring);
    times.add(static_cast<double>(time) * 1e3);
  }
  for (const ReturnOrigin& o : cloud.origins) {
    add_exact(name + " origin", o.column + 1000LL * o.laser + 1000000LL * o.block);
    add_exact(name + " origin time", o.offset_ns + 3 * o.stamp.ns);
    add(name + " origin azimuth", o.azimuth_deg);
    add(name + " origin distance", o.distance_m);
  }
  for (const NearReturn& n : cloud.too_near) add_exact(name + " too_near", n.column * 1000LL + n.ring);
}

void Sums::message(const std::string& name, const DeviceMessage& message) {
  if (const auto* fix = std::get_if<GnssFix>(&message)) {
    add_exact(name + " stamp", fix->stamp.ns);
    add_exact(name + " source", fix->source_time ? fix->source_time->ns : -1);
    add_exact(name + " status", static_cast<int>(fix->status));
    add(name + " place", fix->latitude_deg), add(name + " place", fix->longitude_deg);
    add(name + " altitude", fix->altitude_m);
  } else if (const auto* time = std::get_if<TimeReference>(&message)) {
    add_exact(name + " stamp", time->stamp.ns);
    add_exact(name + " reference", time->reference.ns);
    add_text(name + " source", time->source);
  } else if (const auto* imu = std::get_if<ImuSample>(&message)) {
    add_exact(name + " stamp", imu->stamp.ns);
    add_text(name + " frame", imu->frame_id);
    for (const double value : imu->angular_velocity) add(name + " turning", 1000 * value);
    for (const double value : imu->linear_acceleration) add(name + " acceleration", value);
    if (imu->orientation) {
      for (const double value : imu->orientation->coeffs()) add(name + " orientation", value);
    }
  } else if (const auto* state = std::get_if<DeviceState>(&message)) {
    add_exact(name + " stamp", state->stamp.ns);
    add_text(name + " frame", state->frame_id);
    for (const DeviceValue& value : state->values) {
      add_text(name + " names", value.name);
      add(name + " values", value.value);
    }
  } else if (const auto* raw = std::get_if<RawPackets>(&message)) {
    add_exact(name + " stamp", raw->stamp.ns);
    add_text(name + " frame", raw->frame_id);
    for (const Span arrival : raw->arrivals) add_exact(name + " arrivals", arrival.count());
    for (const std::uint8_t byte : raw->bytes) add_exact(name + " bytes", byte);
  } else {
    ADD_FAILURE() << name << " is a message of a kind whose contents are not summed up";
  }
}

std::string Sums::text() const {
  std::string all;
  for (const auto& [name, sum] : sums_) {
    char line[200];
    std::snprintf(line, sizeof line, ": %llu times", static_cast<unsigned long long>(sum.count));
    all += "  " + name + line;
    std::snprintf(line, sizeof line, ", %016llx", static_cast<unsigned long long>(sum.exact));
    if (sum.exact != 0) all += line;
    if (sum.plain != 0 || sum.by_place != 0) {
      std::snprintf(line, sizeof line, ", sums %.6f and %.6f", sum.plain, sum.by_place);
      all += line;
    }
    std::snprintf(line, sizeof line, ", not finite %llu and %llu",
                  static_cast<unsigned long long>(sum.not_a_number),
                  static_cast<unsigned long long>(sum.infinite));
    if (sum.not_a_number + sum.infinite != 0) all += line;
    all += '\n';
  }
  return all;
}

std::string Sums::digest(const std::string& title) const {
  note_details(title + '\n' + text());
  std::uint64_t count = 0, exact = 0;
  std::string sums;
  char number[40];
  for (const auto& [name, sum] : sums_) {
    count += sum.count;
    for (const std::uint64_t value : {hash_of(name), sum.count, sum.exact, sum.not_a_number, sum.infinite})
      exact = exact * 31 + value;
    if (sum.plain == 0 && sum.by_place == 0) continue;
    std::snprintf(number, sizeof number, " %.3f", sum.plain + sum.by_place);
    sums += number;
  }
  std::snprintf(number, sizeof number, " values, %016llx,", static_cast<unsigned long long>(exact));
  return "  " + std::to_string(count) + number + sums + '\n';
}

std::string checksum(std::string_view text) {
  note_details(text);
  char number[20];
  std::snprintf(number, sizeof number, "%016llx", static_cast<unsigned long long>(hash_of(text)));
  return number;
}

void SummedOutput::request(ByteView bytes) {
  sums.add_text("request", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string reported_by(const Driver& driver) {
  const Counters& c = driver.counters();
  std::string all = "  counters: bytes " + std::to_string(c.bytes);
  for (const auto& counter : usual_counters)
    all += std::string(", ") + counter.key + " " + std::to_string(c.*counter.value);
  for (const auto& counter : trouble_counters)
    all += std::string(", ") + counter.key + " " + std::to_string(c.*counter.value);
  for (std::size_t i = 0; i < reject_reasons; ++i) {
    if (c.rejected[i] > 0)
      all += std::string(", ") + to_string(static_cast<Reject>(i)) + " " + std::to_string(c.rejected[i]);
  }
  all += "\n  serial " + driver.info().serial + "\n";
  for (const auto& [key, value] : driver.info().details) all += "  " + key + ": " + value + "\n";
  for (const std::string& warning : driver.info().warnings) all += "  warning: " + warning + "\n";
  return all;
}

}  // namespace lidard::test
