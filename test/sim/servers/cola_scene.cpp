// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <utility>

#include "test/sim/devices/cola_device.h"
#include "test/sim/servers/scene_device.h"
#include "test/sim/servers/scene_models.h"

namespace lidard::sim {
namespace {

/// Sensors of a scene were switched on so many telegrams before it began or the server started.
constexpr std::int64_t telegrams_before = 1500;

/// A product as SICK 8014631 and the data sheets describe it. Angles and rates of LMS111, LMS511, TiM781S and
/// MRS1104, and the name "MRS1xxxx", are those of recordings.
struct Product {
  const char* name;
  const char* type;  ///< how it calls itself
  double hz;
  double start_deg, end_deg, step_deg;
  double ahead_deg;  ///< device angle of what is ahead
  bool clockwise;
  bool stamps_last_beam;
  double range_min, range_max;  ///< m
};
constexpr Product products[] = {
    {"sick_lms1xx", "LMS111", 50, -45, 225, 0.5, 90, false, true, 0.05, 50},
    {"sick_lms5xx", "LMS511", 25, -5, 185, 1.0 / 6, 90, false, false, 0.05, 65},
    {"sick_lms1000", "LMS1xxx", 150, -48, 228, 0.75, 90, false, false, 0.05, 64},
    {"sick_lms4000", "LMS4xxx", 600, 55, 125, 1.0 / 12, 90, false, false, 0.5, 3.5},
    {"sick_tim240", "TiM240", 14.5, -120, 120, 1, 0, false, true, 0.05, 10},
    {"sick_tim4xx", "TiM433", 15, -30, 210, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim5xx", "TiM571", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim7xx", "TiM781", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim7xxs", "TiM781S", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_lrs36x0", "LRS3600", 8, 0, 359.75, 0.25, 180, true, false, 0.5, 65},
    {"sick_lrs36x1", "LRS3601", 15, 0, 359.5, 0.5, 180, false, false, 0.5, 65},
    {"sick_nav2xx", "NAV245", 25, -135, 135, 0.5, 0, false, false, 0.1, 50},
    {"sick_nav31x", "NAV310", 8, 0, 359.75, 0.25, 180, true, false, 0.5, 65},
    {"sick_oem15xx", "OEM1501", 8, 0, 359.75, 0.25, 180, true, false, 0.5, 65},
    {"sick_mrs1000", "MRS1xxxx", 50, -47.5, 227.5, 0.25, 90, false, false, 0.05, 64},
};

std::int64_t turn_of(const ColaDeviceOptions& device, Span since) {
  return std::llround(seconds(since) * device.hz);
}
Span beam_period(const ColaDeviceOptions& device) {
  return span_from_seconds(device.scans_per_turn / device.hz * device.exact_step_deg / 360);
}

/// Where a NAV's beam points whose angle it sends: the formulas of sick_scan_xd (angle_compensator.cpp).
double true_angle(const ColaDeviceOptions& device, double sent_deg) {
  if (!device.compensation) return sent_deg;
  const auto [a, p, o] = *device.compensation;
  const double sign = device.wide_compensation ? -1 : 1;
  return sent_deg + sign * a * 1e-4 * std::sin((sent_deg - sign * p * 1e-4) * rad_per_deg) + sign * o * 1e-4;
}

std::vector<Beam> beams_of(const Product& product, const ColaDeviceOptions& device, Stamp begin, Span since,
                           std::size_t count) {
  const auto turn = static_cast<std::size_t>(turn_of(device, since));
  const std::int16_t layer = device.layers[turn % device.layers.size()];
  // Positive is downwards: so the clouds that SICK's driver published of a recorded MRS1104 have it
  // (sick_scan_xd, test01 of the MRS1000).
  const double elevation = -layer / 100.0 * rad_per_deg;
  std::vector<Beam> all(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double sent_deg = device.start / 1e4 + device.exact_step_deg * static_cast<double>(i);
    const double device_deg = true_angle(device, sent_deg);
    Beam& beam = all[i];
    beam.time = begin + beam_period(device) * static_cast<std::int64_t>(i);
    beam.azimuth = (product.clockwise ? -1 : 1) * (device_deg - product.ahead_deg) * rad_per_deg;
    beam.laser = static_cast<std::uint16_t>(1 - layer / 250);  // 0 is the lowest
    beam.ray.direction = {std::cos(elevation) * std::cos(beam.azimuth),
                          std::cos(elevation) * std::sin(beam.azimuth), std::sin(elevation)};
  }
  return all;
}

ColaBeam wire_of(const Answer& answer) {
  ColaBeam beam;
  beam.rssi = static_cast<std::uint8_t>(std::lround(200 * std::min(answer.near().reflectivity, 1.2)));
  for (std::size_t i = 0; i < answer.count; ++i) {
    // The codes below 16 are no distances, nor does a longer one fit.
    const double mm = std::clamp(1000 * answer.echoes[i].distance, 16.0, 65535.0);
    beam.mm[i] = static_cast<std::uint16_t>(std::lround(mm));
  }
  return beam;
}

ColaDeviceOptions options_of(const Product& product) {
  const std::string model = product.name;
  ColaDeviceOptions device;
  device.type = product.type;
  device.hz = product.hz;
  device.stamps_last_beam = product.stamps_last_beam;
  if (model == "sick_mrs1000" || model == "sick_lms1000") device.scans_per_turn = 4;
  // In the order of two recorded MRS1104.
  if (model == "sick_mrs1000") device.layers = {250, -500, 0, -250};
  if (model == "sick_lms1xx" || model == "sick_lms5xx") device.contamination = 0;
  if (model == "sick_nav2xx" || model == "sick_nav31x") device.compensation.emplace();
  device.wide_compensation = model == "sick_nav2xx";
  device.password = model == "sick_tim7xxs" ? 0x6FD62C05 : 0xF4724744;
  // What is left of the period behind the sweep of a fast device is shorter than the others' processing.
  device.processing = std::min<Span>(device.processing, span_from_seconds(1 / device.hz / 6));
  device.answer_time = std::min<Span>(device.answer_time, span_from_seconds(1 / device.hz / 6));
  return device;
}

void set_angles(ColaDeviceOptions& device, double start_deg, double end_deg, double step_deg) {
  device.start = static_cast<std::int32_t>(std::lround(start_deg * 1e4));
  device.step = static_cast<std::uint16_t>(std::lround(step_deg * 1e4));
  device.exact_step_deg = step_deg;
  device.beams = static_cast<std::size_t>(std::lround((end_deg - start_deg) / step_deg)) + 1;
}

std::vector<std::string> requests_of(Cola dialect, bool compensated) {
  std::vector<std::string> requests;
  for (const char* command : {"sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg",
                              "sRN MCAngleCompSin", "sEN LMDscandata"}) {
    if (!compensated && std::string_view(command) == "sRN MCAngleCompSin") continue;
    ColaWords words(dialect, command);
    if (command[1] == 'E') words.number(1, 1);
    const std::vector<std::uint8_t> bytes = words.bytes();
    requests.emplace_back(bytes.begin(), bytes.end());
  }
  return requests;
}

SceneDevice scene_device(const Product& product, const ColaDeviceOptions& options, bool joined) {
  SceneDevice device;
  device.time_of = [hz = options.hz](std::int64_t turn) {
    return span_from_seconds(static_cast<double>(turn) / hz);
  };
  device.turns_before = telegrams_before;
  device.beam_count = options.beams;
  device.beams = [&product, options](Stamp begin, Span since, std::size_t count) {
    return beams_of(product, options, begin, since, count);
  };
  device.wire = [](const Answer& answer) { return wire_distance(wire_of(answer).mm[0], 1); };
  device.sent_within =
      beam_period(options) * static_cast<std::int64_t>(options.beams - 1) + options.processing;
  device.requests = requests_of(options.dialect, options.compensation.has_value());
  device.next_request = options.answer_time;
  device.joined = joined;
  device.make = [options](Transit transit, const SceneDevice::View& view, Stamp power_on) {
    ColaDeviceOptions own = options;
    own.transit = transit;
    const auto see = [view](Stamp begin, std::size_t beams) {
      std::vector<ColaBeam> seen;
      for (const Answer& answer : view(begin, beams)) seen.push_back(wire_of(answer));
      return seen;
    };
    return std::make_unique<ColaDevice>(own, see, power_on);
  };
  return device;
}

void parse_cola(const Product& product, const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"dialect", "serial", "start_deg", "end_deg", "step_deg", "clock_ppm", "clock_us", "boot",
              "echoes", "rssi", "joined", "status", "contamination", "compensation_deg"});
  ColaDeviceOptions device = options_of(product);
  if (yaml.has("dialect")) {
    const std::string dialect = yaml.at("dialect").text();
    if (dialect != "a" && dialect != "b") yaml.at("dialect").fail("a or b");
    device.dialect = dialect == "a" ? Cola::text : Cola::binary;
  }
  if (yaml.has("serial")) device.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  const double start_deg = yaml.number("start_deg", product.start_deg);
  const double end_deg = yaml.number("end_deg", product.end_deg);
  const double step_deg = yaml.positive("step_deg", product.step_deg);
  if (!(end_deg > start_deg && end_deg - start_deg < 360))
    yaml.fail("start_deg must be below end_deg, by less than 360");
  set_angles(device, start_deg, end_deg, step_deg);
  device.clock_ppm = yaml.number("clock_ppm", 0);
  device.clock_us = static_cast<std::uint32_t>(static_cast<std::int64_t>(yaml.not_negative("clock_us", 0)));
  device.boot = span_from_seconds(yaml.not_negative("boot", 0));
  device.channels = static_cast<std::uint8_t>((1U << static_cast<unsigned>(yaml.positive("echoes", 1))) - 1);
  device.rssi = yaml.flag("rssi") ? 1 : 0;
  if (yaml.has("status")) {
    const std::int64_t status = yaml.at("status").integer();
    device.status = {static_cast<std::uint8_t>(status >> 8), static_cast<std::uint8_t>(status)};
  }
  if (yaml.has("contamination"))
    device.contamination = static_cast<std::uint8_t>(yaml.at("contamination").integer());
  if (device.compensation && yaml.has("compensation_deg")) {
    const Eigen::Vector3d given = yaml.at("compensation_deg").vector3();
    for (std::size_t i = 0; i < 3; ++i)
      device.compensation->at(i) =
          static_cast<std::int32_t>(std::lround(given[static_cast<Eigen::Index>(i)] * 1e4));
  }
  set_device(scene_device(product, device, yaml.flag("joined")), entry);
}

}  // namespace

std::vector<SceneModel> cola_models() {
  std::vector<SceneModel> models;
  for (const Product& product : products) {
    models.push_back(
        {product.name, product.range_min, product.range_max,
         [&product](const YamlReader& options, SensorEntry& entry) { parse_cola(product, options, entry); }});
  }
  return models;
}

}  // namespace lidard::sim
