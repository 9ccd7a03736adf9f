// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/web/velodyne_readings.h"

#include <charconv>
#include <cmath>

namespace lidard {
namespace {

constexpr double full_scale_v = 5;
constexpr double counts = 4096;

// Conversions: VLP-16 user manual 63-9243 Rev D, section 10.2, as tier4/nebula and UniBwTAS/velodyne agree.
double volts(double v) { return v; }
double half_volts(double v) { return 2 * v; }
double supply_volts(double v) { return 11 * v; }
double high_volts(double v) { return 101 * (v - 5); }
double amperes(double v) { return 10 * (v - 2.5); }
/// The sensor chip LM20's transfer function.
double celsius(double v) { return -1481.96 + std::sqrt(2.1962e6 + (1.8639 - v) / 3.88e-6); }

struct Row {
  const char* key;  // below diag.volt_temp
  const char* name;
  const char* unit;
  double (*convert)(double volts);
  double lowest, highest;
  bool needs_laser;  // inferred: what feeds the laser diodes falls when they are off
};

// Limits: as the conversions. nebula tests pwr_5v_raw against the limits of 2.5 V; UniBwTAS prints +25 for
// the lowest temperature of the top board.
constexpr Row rows[] = {
    {"top.hv", "Top high voltage", "V", high_volts, -150, -132, true},
    {"top.lm20_temp", "Top temperature", "C", celsius, -25, 90, false},
    {"top.pwr_5v", "Top 5 V", "V", half_volts, 4.8, 5.2, false},
    {"top.pwr_2_5v", "Top 2.5 V", "V", volts, 2.3, 2.7, false},
    {"top.pwr_3_3v", "Top 3.3 V", "V", volts, 3.1, 3.5, false},
    {"top.pwr_5v_raw", "Top 5 V raw", "V", half_volts, 4.8, 5.2, false},
    {"top.pwr_raw", "Top raw", "V", volts, 1.6, 1.9, false},
    {"top.pwr_vccint", "Top VCCINT", "V", volts, 1.0, 1.4, false},
    {"bot.i_out", "Bottom output current", "A", amperes, 0.3, 1.0, true},
    {"bot.lm20_temp", "Bottom temperature", "C", celsius, -25, 90, false},
    {"bot.pwr_1_2v", "Bottom 1.2 V", "V", volts, 1.0, 1.4, false},
    {"bot.pwr_1_25v", "Bottom 1.25 V", "V", volts, 1.0, 1.4, false},
    {"bot.pwr_2_5v", "Bottom 2.5 V", "V", volts, 2.3, 2.7, false},
    {"bot.pwr_3_3v", "Bottom 3.3 V", "V", volts, 3.1, 3.5, false},
    {"bot.pwr_5v", "Bottom 5 V", "V", half_volts, 4.8, 5.2, false},
    {"bot.pwr_v_in", "Supply voltage", "V", supply_volts, 8, 19, false},
};

/// A count of the 12-bit converter.
bool read_count(const VelodyneTree& tree, const std::string& key, double& count) {
  const auto found = tree.find(key);
  if (found == tree.end()) return false;
  const std::string& text = found->second;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  return error == std::errc() && end == text.data() + text.size() && count >= 0 && count < counts;
}

bool laser_is_off(const VelodyneTree& tree) {
  const auto found = tree.find("status.laser.state");
  return found != tree.end() && (found->second == "Off" || found->second == "off");
}

}  // namespace

std::vector<VelodyneReading> velodyne_readings(const VelodyneTree& tree) {
  std::vector<VelodyneReading> readings;
  const bool dark = laser_is_off(tree);
  for (const Row& row : rows) {
    double count = 0;
    if (!read_count(tree, std::string("diag.volt_temp.") + row.key, count)) continue;
    readings.push_back({row.name, row.unit, row.convert(count * full_scale_v / counts), row.lowest,
                        row.highest, !(dark && row.needs_laser)});
  }
  return readings;
}

}  // namespace lidard
