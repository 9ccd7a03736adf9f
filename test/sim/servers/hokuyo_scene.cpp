// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/hokuyo_scene.h"

#include <algorithm>
#include <cmath>

#include "test/sim/world/rng.h"
#include "test/sim/world/scene.h"

namespace lidard::sim {
namespace {

/// Sensors of a scene were switched on so long before it began or the server started.
constexpr Span uptime = std::chrono::seconds(100);

/// A planar turn: beams in equal steps, the first at step 0.
struct Turn {
  Span period{0};
  std::size_t steps_per_turn = 1440, beams = 1081;
  double first_angle = 0;  ///< rad, ROS frame

  double angle(std::size_t beam) const {
    return first_angle + two_pi / static_cast<double>(steps_per_turn) * static_cast<double>(beam);
  }
  Span time(std::size_t beam) const {
    return Span(period.count() * static_cast<std::int64_t>(beam) / static_cast<std::int64_t>(steps_per_turn));
  }
  Beam beam(Stamp begin, std::size_t i) const {
    Beam beam;
    beam.time = begin + time(i);
    beam.azimuth = angle(i);
    beam.ray.direction = {std::cos(angle(i)), std::sin(angle(i)), 0};
    return beam;
  }
};

/// Like `millimetres`, for a range that the scene measured.
std::uint32_t millimetres(double distance, std::uint32_t nothing) {
  return std::isfinite(distance) ? static_cast<std::uint32_t>(std::lround(1000 * distance)) : nothing;
}
std::uint32_t brightness(double reflectivity) {
  return static_cast<std::uint32_t>(std::lround(4000 * std::min(reflectivity, 10.0)));
}

SlotTruth slot_of(const Beam& beam, const Answer& answer, double wire_m) {
  SlotTruth slot;
  slot.time = beam.time;
  slot.azimuth = beam.azimuth;
  slot.exact = answer.near().exact;
  slot.wire = wire_m;
  slot.reflectivity = answer.near().reflectivity;
  slot.xyz = answer.near().exact * beam.ray.direction;
  return slot;
}

/// A device whose turns a scene measures: the capture holds its whole connection.
class RecordedDevice : public SensorModel {
 public:
  /// `requests`: what its client writes, one after the other, answered before the first turn ends.
  RecordedDevice(const Turn& turn, Stamp start, std::vector<std::string> requests)
      : turn_(turn), start_(start), requests_(std::move(requests)) {}

  const std::vector<Beam>& next() override {
    ++number_;
    beams_.clear();
    const Stamp begin = start_ + turn_.period * number_;
    for (std::size_t i = 0; i < turn_.beams; ++i) beams_.push_back(turn_.beam(begin, i));
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings&, std::vector<Datagram>& datagrams,
              std::vector<SlotTruth>& slots) override {
    answers_ = &answers;
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const double distance = answers[i].near().distance;
      const double wire = std::isfinite(distance) ? std::round(1000 * distance) / 1000 : no_hit;
      slots.push_back(slot_of(beams_[i], answers[i], wire));
    }
    TcpDevice& device = this->device();
    if (number_ == 1) write_requests(device, datagrams);
    // The device's own turns are those of the scene; what it sends then leaves after the last beam.
    const Stamp until = beams_.front().time + turn_.period;
    while (auto sent = device.next(until)) put(sent->time, sent->bytes, false, datagrams);
  }

 protected:
  virtual TcpDevice& device() = 0;
  const std::vector<Answer>& answers() const { return *answers_; }

 private:
  void write_requests(TcpDevice& device, std::vector<Datagram>& datagrams) {
    Stamp now = start_ + turn_.period / 10;
    device.connected(now);
    for (const std::string& request : requests_) {
      if (!joined_) put(now, request, true, datagrams);
      device.receive(request, now);
      now = now + std::chrono::microseconds(700);
      while (auto sent = device.next(now)) {
        if (!joined_) put(sent->time, sent->bytes, false, datagrams);
      }
    }
  }
  static void put(Stamp time, const std::string& bytes, bool to_device, std::vector<Datagram>& datagrams) {
    Datagram datagram;
    datagram.ready = time;
    datagram.payload.assign(bytes.begin(), bytes.end());
    datagram.to_device = to_device;
    datagrams.push_back(std::move(datagram));
  }

  Turn turn_;
  Stamp start_;
  std::vector<std::string> requests_;
  std::int64_t number_ = 0;
  std::vector<Beam> beams_;
  const std::vector<Answer>* answers_ = nullptr;

 protected:
  bool joined_ = false;  ///< the capture begins in the middle of the stream
};

struct ScipSetup {
  ScipDeviceOptions device;
  std::string order;  ///< what the client asks for in the end
  std::uint32_t no_echo_mm = 65533;
  bool joined = false;
};

Turn turn_of(const ScipDeviceOptions& o) {
  Turn turn;
  turn.period = span_from_seconds(60.0 / o.rpm * (1 + o.motor_ppm * 1e-6));
  turn.steps_per_turn = static_cast<std::size_t>(o.steps_per_turn);
  turn.beams = static_cast<std::size_t>(o.last_step) + 1;
  turn.first_angle = -two_pi / o.steps_per_turn * o.front_step;
  return turn;
}

class RecordedScip final : public RecordedDevice {
 public:
  RecordedScip(const ScipSetup& setup, Stamp start)
      : RecordedDevice(turn_of(setup.device), start, {"QT\n", "VV\n", "PP\n", "II\n", setup.order + "\n"}),
        no_echo_mm_(setup.no_echo_mm),
        device_(
            setup.device, [this](Stamp) { return steps(); },
            start - turn_of(setup.device).period * (uptime / turn_of(setup.device).period)) {
    joined_ = setup.joined;
  }

 private:
  TcpDevice& device() override { return device_; }
  std::vector<ScipStep> steps() const {
    std::vector<ScipStep> all;
    for (const Answer& answer : answers()) {
      ScipStep step;
      for (std::size_t i = 0; i < std::max<std::size_t>(answer.count, 1); ++i)
        step.push_back(
            {millimetres(answer.echoes[i].distance, no_echo_mm_), brightness(answer.echoes[i].reflectivity)});
      all.push_back(std::move(step));
    }
    return all;
  }

  std::uint32_t no_echo_mm_;
  ScipDevice device_;
};

struct UamSetup {
  UamDeviceOptions device;
  std::string order = "AR02";
  bool joined = false;
};

Turn uam_turn(bool fine) {
  Turn turn;
  turn.period = std::chrono::milliseconds(30);
  turn.steps_per_turn = fine ? 2880 : 1440;
  turn.beams = fine ? 2161 : 1081;
  turn.first_angle = -0.375 * two_pi;
  return turn;
}

class RecordedUam final : public RecordedDevice {
 public:
  RecordedUam(const UamSetup& setup, Stamp start)
      : RecordedDevice(uam_turn(setup.order == "AR07"), start, {uam_frame("VR00"), uam_frame(setup.order)}),
        device_(
            setup.device, [this](Stamp, std::size_t) { return beams(); },
            start - uam_turn(false).period * (uptime / uam_turn(false).period)) {
    joined_ = setup.joined;
  }

 private:
  TcpDevice& device() override { return device_; }
  std::vector<UamBeam> beams() const {
    std::vector<UamBeam> all;
    for (const Answer& answer : answers())
      all.push_back(
          {static_cast<std::uint16_t>(std::min(millimetres(answer.near().distance, 0xfffe), 0xfffeU)),
           static_cast<std::uint16_t>(brightness(answer.near().reflectivity))});
    return all;
  }

  UamDevice device_;
};

/// What a scene's sensor sees now, for a device on a real clock.
std::vector<Answer> look_around(const Scene& scene, std::size_t sensor, const Turn& turn, Stamp begin,
                                Rng& rng) {
  const SensorEntry& entry = scene.sensors[sensor];
  std::vector<Answer> answers(turn.beams);
  for (std::size_t i = 0; i < turn.beams; ++i) {
    const Beam beam = turn.beam(begin, i);
    const Hit hit = look(scene, entry, beam.ray, beam.time);
    if (!(hit.distance >= entry.range_min && hit.distance <= entry.range_max)) continue;
    const double error = entry.noise > 0 ? entry.noise * rng.gaussian() : 0;
    answers[i].echoes[0] = {std::max(0.0, hit.distance + error), hit.distance, hit.reflectivity};
    answers[i].count = 1;
  }
  return answers;
}

/// The live SCIP device of a scene.
std::unique_ptr<TcpDevice> live_scip(const ScipSetup& setup, const Scene& scene, std::size_t sensor,
                                     Stamp now, Span shift) {
  const Turn turn = turn_of(setup.device);
  auto rng = std::make_shared<Rng>(scene.seed + sensor);
  const auto see = [&scene, sensor, turn, shift, rng, nothing = setup.no_echo_mm](Stamp begin) {
    std::vector<ScipStep> steps;
    for (const Answer& answer : look_around(scene, sensor, turn, begin + shift, *rng))
      steps.push_back(
          {{millimetres(answer.near().distance, nothing), brightness(answer.near().reflectivity)}});
    return steps;
  };
  return std::make_unique<ScipDevice>(setup.device, see, now - uptime);
}

std::unique_ptr<TcpDevice> live_uam(const UamSetup& setup, const Scene& scene, std::size_t sensor, Stamp now,
                                    Span shift) {
  auto rng = std::make_shared<Rng>(scene.seed + sensor);
  const auto see = [&scene, sensor, shift, rng](Stamp begin, std::size_t beams) {
    std::vector<UamBeam> seen;
    for (const Answer& answer : look_around(scene, sensor, uam_turn(beams > 1081), begin + shift, *rng))
      seen.push_back(
          {static_cast<std::uint16_t>(std::min(millimetres(answer.near().distance, 0xfffe), 0xfffeU)),
           static_cast<std::uint16_t>(brightness(answer.near().reflectivity))});
    return seen;
  };
  return std::make_unique<UamDevice>(setup.device, see, now - uptime);
}

/// A scene's own latency and jitter are those of the way.
Transit transit_of(const SensorEntry& entry) { return {entry.latency, entry.jitter}; }

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

void parse_scip(const std::string& model, const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"firmware", "serial", "percent", "intensities", "clock_ppm", "motor_ppm", "counter_ms", "boot",
              "processing_us", "request", "no_echo", "joined"});
  ScipSetup setup;
  setup.device = product(model);
  ScipDeviceOptions& o = setup.device;
  if (yaml.has("percent") && yaml.at("percent").flag()) o.knows_percent = true, o.firmware = "4.1.0";
  if (yaml.has("firmware")) o.firmware = yaml.at("firmware").text();
  if (yaml.has("serial")) o.serial = yaml.at("serial").text();
  if (yaml.has("intensities")) o.knows_intensities = yaml.at("intensities").flag();
  o.clock_ppm = yaml.number("clock_ppm", 0);
  o.motor_ppm = yaml.number("motor_ppm", 0);
  o.counter = static_cast<std::uint64_t>(1000 * yaml.not_negative("counter_ms", 0));
  o.boot = span_from_seconds(yaml.not_negative("boot", 0));
  o.processing = span_from_seconds(yaml.not_negative("processing_us", 200) * 1e-6);
  setup.no_echo_mm = static_cast<std::uint32_t>(yaml.not_negative("no_echo", o.knows_echoes ? 1 : 65533));
  setup.order = std::string(o.knows_percent ? "%" : "") + (o.knows_intensities ? "ME" : "MD") + "0000" +
                (o.last_step > 999 ? "" : "0") + std::to_string(o.last_step) + "01000";
  if (yaml.has("request")) setup.order = yaml.at("request").text();
  if (!parse_order(setup.order)) yaml.at("request").fail("no request for distances like MD0000108001000");
  if (yaml.has("joined")) setup.joined = yaml.at("joined").flag();
  entry.make = [setup](const SensorEntry&, Stamp start) {
    ScipSetup recorded = setup;
    recorded.device.transit.delay = Span(0);  // the scene adds its own
    return std::make_unique<RecordedScip>(recorded, start);
  };
  entry.make_device = [setup](const Scene& scene, std::size_t sensor, Stamp now, Span shift) {
    ScipSetup live = setup;
    live.device.transit = transit_of(scene.sensors[sensor]);
    return live_scip(live, scene, sensor, now, shift);
  };
}

void parse_uam(const std::string& model, const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"serial", "clock_ppm", "counter_ms", "boot", "area", "ossd_off", "contaminated", "joined"});
  UamSetup setup;
  if (model == "hokuyo_uam_05lp_intensity") setup.order = "AR04";
  if (model == "hokuyo_uam_05lp_fine") setup.order = "AR07";
  UamDeviceOptions& o = setup.device;
  if (yaml.has("serial")) o.serial = yaml.at("serial").text();
  o.clock_ppm = yaml.number("clock_ppm", 0);
  o.counter_ms = static_cast<std::uint32_t>(yaml.not_negative("counter_ms", 0));
  o.boot = span_from_seconds(yaml.not_negative("boot", 0));
  o.report.area = static_cast<unsigned>(yaml.not_negative("area", 0));
  if (yaml.has("ossd_off") && yaml.at("ossd_off").flag()) o.report.ossd1 = o.report.ossd2 = 0;
  if (yaml.has("contaminated") && yaml.at("contaminated").flag()) o.report.contaminated = 1;
  if (yaml.has("joined")) setup.joined = yaml.at("joined").flag();
  entry.make = [setup](const SensorEntry&, Stamp start) {
    UamSetup recorded = setup;
    recorded.device.transit.delay = Span(0);
    return std::make_unique<RecordedUam>(recorded, start);
  };
  entry.make_device = [setup](const Scene& scene, std::size_t sensor, Stamp now, Span shift) {
    UamSetup live = setup;
    live.device.transit = transit_of(scene.sensors[sensor]);
    return live_uam(live, scene, sensor, now, shift);
  };
}

}  // namespace

std::vector<HokuyoFamily> hokuyo_families() {
  return {{"hokuyo_ust_05lx", 0.06, 5},     {"hokuyo_ust_10lx", 0.06, 30},
          {"hokuyo_ust_20lx", 0.06, 60},    {"hokuyo_ust_30lx", 0.06, 60},
          {"hokuyo_utm_30lx_ew", 0.1, 60},  {"hokuyo_uxm_30lx_ew", 0.1, 80},
          {"hokuyo_uam_05lp", 0.1, 39},     {"hokuyo_uam_05lp_intensity", 0.1, 39},
          {"hokuyo_uam_05lp_fine", 0.1, 39}};
}

void parse_hokuyo(const std::string& model, const YamlReader& options, SensorEntry& entry) {
  if (model.find("uam") != std::string::npos) return parse_uam(model, options, entry);
  parse_scip(model, options, entry);
}

}  // namespace lidard::sim
