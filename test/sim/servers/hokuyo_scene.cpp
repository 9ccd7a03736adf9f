// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "test/sim/devices/scip_device.h"
#include "test/sim/devices/uam_device.h"
#include "test/sim/servers/scene_device.h"
#include "test/sim/servers/scene_models.h"

namespace lidard::sim {
namespace {

/// Sensors of a scene were switched on so long before it began or the server started.
constexpr Span uptime = std::chrono::seconds(100);

/// A planar turn: beams in equal steps, the first at step 0.
struct Turn {
  Span period{0};
  std::size_t steps = 1440;  ///< of a whole turn
  double first_angle = 0;    ///< rad, ROS frame

  std::vector<Beam> beams(Stamp begin, std::size_t count) const {
    std::vector<Beam> all(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double angle = first_angle + two_pi / static_cast<double>(steps) * static_cast<double>(i);
      all[i].time =
          begin + Span(period.count() * static_cast<std::int64_t>(i) / static_cast<std::int64_t>(steps));
      all[i].azimuth = angle;
      all[i].ray.direction = {std::cos(angle), std::sin(angle), 0};
    }
    return all;
  }
};

std::uint32_t millimetres(const Answer::Echo& echo, std::uint32_t nothing) {
  return std::isfinite(echo.distance) ? static_cast<std::uint32_t>(std::lround(1000 * echo.distance))
                                      : nothing;
}
std::uint32_t brightness(const Answer::Echo& echo) {
  return static_cast<std::uint32_t>(std::lround(4000 * std::min(echo.reflectivity, 10.0)));
}

/// What is the same for both protocols.
SceneDevice turning(Span period) {
  SceneDevice device;
  device.time_of = [period](std::int64_t turn) { return period * turn; };
  device.turns_before = uptime / period;
  device.wire = [](const Answer& answer) {
    const double distance = answer.near().distance;
    return std::isfinite(distance) ? std::round(1000 * distance) / 1000 : no_hit;
  };
  device.sent_within = period;
  device.first_request = period / 10;
  device.next_request = std::chrono::microseconds(700);
  return device;
}

ScipDeviceOptions product(const std::string& model) {
  ScipDeviceOptions o;
  o.product = model == "hokuyo_ust_05lx"   ? "UST-05LX"
              : model == "hokuyo_ust_20lx" ? "UST-20LX"
              : model == "hokuyo_ust_30lx" ? "UST-30LX"
                                           : "UST-10LX";
  o.sends_on_tick = true;
  if (model == "hokuyo_ust_20lx" || model == "hokuyo_ust_30lx") o.range_max_mm = 60000;
  if (model != "hokuyo_utm_30lx_ew" && model != "hokuyo_uxm_30lx_ew") return o;
  o.sends_on_tick = false;
  o.knows_echoes = true;
  o.product = "UTM-30LX-EW";
  o.range_min_mm = 23, o.range_max_mm = 60000;
  if (model == "hokuyo_utm_30lx_ew") return o;
  o.product = "UXM-30LX-EW";
  o.range_min_mm = 100, o.range_max_mm = 80000;
  o.last_step = 760, o.front_step = 380, o.rpm = 1200;
  return o;
}

void parse_scip(const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"firmware", "serial", "percent", "clock_ppm", "counter_ms", "boot", "request", "joined"});
  ScipDeviceOptions o = product(entry.model);
  if (yaml.flag("percent")) o.knows_percent = true, o.firmware = "4.1.0";
  if (yaml.has("firmware")) o.firmware = yaml.at("firmware").text();
  if (yaml.has("serial")) o.serial = yaml.at("serial").text();
  o.clock_ppm = yaml.number("clock_ppm", 0);
  o.counter = static_cast<std::uint64_t>(1000 * yaml.not_negative("counter_ms", 0));
  o.boot = span_from_seconds(yaml.not_negative("boot", 0));
  std::string order = std::string(o.knows_percent ? "%" : "") + "ME0000" + (o.last_step > 999 ? "" : "0") +
                      std::to_string(o.last_step) + "01000";
  if (yaml.has("request")) order = yaml.at("request").text();
  if (!parse_order(order)) yaml.at("request").fail("no request for distances like MD0000108001000");
  const Turn turn{span_from_seconds(60.0 / o.rpm), static_cast<std::size_t>(o.steps_per_turn),
                  -two_pi / o.steps_per_turn * o.front_step};
  SceneDevice device = turning(turn.period);
  device.beam_count = static_cast<std::size_t>(o.last_step) + 1;
  device.beams = [turn](Stamp begin, Span, std::size_t count) { return turn.beams(begin, count); };
  device.requests = {"QT\n", "VV\n", "PP\n", "II\n", order + "\n"};
  device.joined = yaml.flag("joined");
  device.make = [o, beams = device.beam_count](Transit transit, const SceneDevice::View& view,
                                               Stamp power_on) {
    ScipDeviceOptions options = o;
    options.transit = transit;
    const std::uint32_t nothing = o.knows_echoes ? 1 : 65533;
    const auto see = [view, beams, nothing](Stamp begin) {
      std::vector<ScipStep> steps;
      for (const Answer& answer : view(begin, beams)) {
        ScipStep& step = steps.emplace_back();
        for (std::size_t i = 0; i < std::max<std::size_t>(answer.count, 1); ++i)
          step.push_back({millimetres(answer.echoes[i], nothing), brightness(answer.echoes[i])});
      }
      return steps;
    };
    return std::make_unique<ScipDevice>(options, see, power_on);
  };
  set_device(device, entry);
}

void parse_uam(const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"serial", "clock_ppm", "counter_ms", "boot", "area", "ossd_off", "contaminated", "joined"});
  UamDeviceOptions o;
  if (yaml.has("serial")) o.serial = yaml.at("serial").text();
  o.clock_ppm = yaml.number("clock_ppm", 0);
  o.counter_ms = static_cast<std::uint32_t>(yaml.not_negative("counter_ms", 0));
  o.boot = span_from_seconds(yaml.not_negative("boot", 0));
  o.report.area = static_cast<unsigned>(yaml.not_negative("area", 0));
  if (yaml.flag("ossd_off")) o.report.ossd1 = o.report.ossd2 = 0;
  if (yaml.flag("contaminated")) o.report.contaminated = 1;
  const bool fine = entry.model == "hokuyo_uam_05lp_fine";
  const char* order = fine ? "AR07" : entry.model == "hokuyo_uam_05lp_intensity" ? "AR04" : "AR02";
  SceneDevice device = turning(std::chrono::milliseconds(30));
  device.beam_count = fine ? 2161 : 1081;
  device.beams = [](Stamp begin, Span, std::size_t count) {
    const std::size_t steps = count > 1081 ? 2880 : 1440;
    return Turn{std::chrono::milliseconds(30), steps, -0.375 * two_pi}.beams(begin, count);
  };
  device.requests = {uam_frame("VR00"), uam_frame(order)};
  device.joined = yaml.flag("joined");
  device.make = [o](Transit transit, const SceneDevice::View& view, Stamp power_on) {
    UamDeviceOptions options = o;
    options.transit = transit;
    const auto see = [view](Stamp begin, std::size_t beams) {
      std::vector<UamBeam> seen;
      for (const Answer& answer : view(begin, beams))
        seen.push_back({static_cast<std::uint16_t>(std::min(millimetres(answer.near(), 0xfffe), 0xfffeU)),
                        static_cast<std::uint16_t>(brightness(answer.near()))});
      return seen;
    };
    return std::make_unique<UamDevice>(options, see, power_on);
  };
  set_device(device, entry);
}

}  // namespace

std::vector<SceneModel> hokuyo_models() {
  return {{"hokuyo_ust_05lx", 0.06, 5, parse_scip},    {"hokuyo_ust_10lx", 0.06, 30, parse_scip},
          {"hokuyo_ust_20lx", 0.06, 60, parse_scip},   {"hokuyo_ust_30lx", 0.06, 60, parse_scip},
          {"hokuyo_utm_30lx_ew", 0.1, 60, parse_scip}, {"hokuyo_uxm_30lx_ew", 0.1, 80, parse_scip},
          {"hokuyo_uam_05lp", 0.1, 39, parse_uam},     {"hokuyo_uam_05lp_intensity", 0.1, 39, parse_uam},
          {"hokuyo_uam_05lp_fine", 0.1, 39, parse_uam}};
}

}  // namespace lidard::sim
