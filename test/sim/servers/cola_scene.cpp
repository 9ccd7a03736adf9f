// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/cola_scene.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "test/sim/devices/cola_device.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/scene.h"

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
    {"sick_lms1000", "LMS1xxx", 50, -47.5, 227.5, 0.25, 90, false, false, 0.05, 64},
    {"sick_lms4000", "LMS4xxx", 600, 55, 125, 1.0 / 12, 90, false, false, 0.5, 3.5},
    {"sick_tim240", "TiM240", 14.5, -120, 120, 1, 0, false, true, 0.05, 10},
    {"sick_tim4xx", "TiM433", 15, -30, 210, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim5xx", "TiM571", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim7xx", "TiM781", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_tim7xxs", "TiM781S", 15, -45, 225, 1.0 / 3, 90, false, true, 0.05, 25},
    {"sick_lrs36x0", "LRS3600", 8, 0, 359.75, 0.25, -90, true, false, 0.5, 65},
    {"sick_lrs36x1", "LRS3601", 15, 0, 359.5, 0.5, 180, false, false, 0.5, 65},
    {"sick_nav2xx", "NAV245", 25, -135, 135, 0.5, 0, false, false, 0.1, 50},
    {"sick_nav31x", "NAV310", 8, 0, 359.75, 0.25, 0, true, false, 0.5, 65},
    {"sick_oem15xx", "OEM1501", 8, 0, 359.75, 0.25, 0, true, false, 0.5, 65},
    {"sick_mrs1000", "MRS1xxxx", 50, -47.5, 227.5, 0.25, 90, false, false, 0.05, 64},
};

/// A scanner of a scene.
struct Setup {
  const Product* product = nullptr;
  ColaDeviceOptions device;
  bool joined = false;  ///< the capture begins in the middle of the stream

  double angle(std::size_t beam) const {
    const double device_deg = device.start / 1e4 + device.exact_step_deg * static_cast<double>(beam);
    return (product->clockwise ? -1 : 1) * (device_deg - product->ahead_deg) * rad_per_deg;
  }
  Stamp first_beam(Stamp power_on, std::int64_t number) const {
    return power_on + span_from_seconds(static_cast<double>(number) / device.hz);
  }
  Span beam_period() const {
    return span_from_seconds(device.scans_per_turn / device.hz * device.exact_step_deg / 360);
  }
  Beam beam(Stamp first, std::int64_t number, std::size_t i) const {
    const std::int16_t layer = device.layers[static_cast<std::size_t>(number) % device.layers.size()];
    // Positive is downwards: so the clouds that SICK's driver published of a recorded MRS1104 have it
    // (sick_scan_xd, test01 of the MRS1000).
    const double elevation = -layer / 100.0 * rad_per_deg;
    Beam beam;
    beam.time = first + beam_period() * static_cast<std::int64_t>(i);
    beam.azimuth = angle(i);
    beam.laser = static_cast<std::uint16_t>(1 - layer / 250);  // 0 is the lowest
    beam.ray.direction = {std::cos(elevation) * std::cos(beam.azimuth),
                          std::cos(elevation) * std::sin(beam.azimuth), std::sin(elevation)};
    return beam;
  }
};

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

SlotTruth slot_of(const Beam& beam, const Answer& answer) {
  SlotTruth slot;
  slot.time = beam.time;
  slot.azimuth = beam.azimuth;
  slot.exact = answer.near().exact;
  slot.wire = wire_distance(wire_of(answer).mm[0], 1);
  slot.reflectivity = answer.near().reflectivity;
  slot.laser = beam.laser;
  slot.xyz = answer.near().exact * beam.ray.direction;
  return slot;
}

/// The device of a capture, with what its client wrote.
class RecordedCola final : public SensorModel {
 public:
  RecordedCola(Setup setup, Stamp start)
      : setup_(std::move(setup)),
        power_on_(start - span_from_seconds(static_cast<double>(telegrams_before) / setup_.device.hz)),
        start_(start),
        device_(
            setup_.device, [this](Stamp, std::size_t) { return seen_; }, power_on_) {}

  const std::vector<Beam>& next() override {
    ++number_;
    beams_.clear();
    const Stamp first = setup_.first_beam(power_on_, number_);
    for (std::size_t i = 0; i < setup_.device.beams; ++i) beams_.push_back(setup_.beam(first, number_, i));
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings&, std::vector<Datagram>& datagrams,
              std::vector<SlotTruth>& slots) override {
    seen_.clear();
    for (std::size_t i = 0; i < answers.size(); ++i) {
      seen_.push_back(wire_of(answers[i]));
      slots.push_back(slot_of(beams_[i], answers[i]));
    }
    if (number_ == telegrams_before + 1) write_requests(datagrams);
    drain(beams_.back().time + setup_.device.processing, false, datagrams);
  }

 private:
  void write_requests(std::vector<Datagram>& datagrams) {
    Stamp now = start_;
    device_.connected(now);
    for (const char* command :
         {"sRN DeviceIdent", "sRN LMPoutputRange", "sRN LMDscandatacfg", "sEN LMDscandata"}) {
      ColaWords words(setup_.device.dialect, command);
      if (command[1] == 'E') words.number(1, 1);
      const std::vector<std::uint8_t> bytes = words.bytes();
      if (!setup_.joined) put(now, {bytes.begin(), bytes.end()}, true, datagrams);
      device_.receive({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, now);
      now = now + setup_.device.answer_time;
      drain(now, setup_.joined, datagrams);
    }
  }
  void drain(Stamp until, bool drop, std::vector<Datagram>& datagrams) {
    while (auto sent = device_.next(until)) {
      if (!drop) put(sent->time, sent->bytes, false, datagrams);
    }
  }
  static void put(Stamp time, const std::string& bytes, bool to_device, std::vector<Datagram>& datagrams) {
    Datagram datagram;
    datagram.ready = time;
    datagram.payload.assign(bytes.begin(), bytes.end());
    datagram.to_device = to_device;
    datagrams.push_back(std::move(datagram));
  }

  Setup setup_;
  Stamp power_on_, start_;
  std::int64_t number_ = telegrams_before;
  std::vector<Beam> beams_;
  std::vector<ColaBeam> seen_;
  ColaDevice device_;
};

/// The device of a server: sees what stands in the scene now.
std::unique_ptr<TcpDevice> live_cola(const Setup& setup, const Scene& scene, std::size_t sensor, Stamp now,
                                     Span shift) {
  const Stamp power_on = now - span_from_seconds(static_cast<double>(telegrams_before) / setup.device.hz);
  auto rng = std::make_shared<Rng>(scene.seed + sensor);
  const auto see = [&scene, setup, sensor, power_on, shift, rng](Stamp first, std::size_t beams) {
    const SensorEntry& entry = scene.sensors[sensor];
    const std::int64_t number = std::llround(seconds(first - power_on) * setup.device.hz);
    std::vector<ColaBeam> seen;
    for (std::size_t i = 0; i < beams; ++i) {
      const Beam beam = setup.beam(first, number, i);
      const Hit hit = look(scene, entry, beam.ray, beam.time + shift);
      Answer answer;
      if (hit.distance >= entry.range_min && hit.distance <= entry.range_max) {
        const double error = entry.noise > 0 ? entry.noise * rng->gaussian() : 0;
        answer.echoes[0] = {hit.distance + error, hit.distance, hit.reflectivity};
        answer.count = 1;
      }
      seen.push_back(wire_of(answer));
    }
    return seen;
  };
  return std::make_unique<ColaDevice>(setup.device, see, power_on);
}

Setup setup_of(const std::string& model) {
  Setup setup;
  setup.product =
      std::find_if(std::begin(products), std::end(products), [&](const auto& p) { return model == p.name; });
  ColaDeviceOptions& device = setup.device;
  device.type = setup.product->type;
  device.hz = setup.product->hz;
  device.stamps_last_beam = setup.product->stamps_last_beam;
  const bool modules = model == "sick_mrs1000" || model == "sick_lms1000";
  if (modules) device.scans_per_turn = 4;
  // In the order of two recorded MRS1104.
  if (model == "sick_mrs1000") device.layers = {250, -500, 0, -250};
  device.password = model == "sick_tim7xxs" ? 0x6FD62C05 : 0xF4724744;
  // What is left of the period behind the sweep of a fast device is shorter than the others' processing.
  device.processing = std::min<Span>(device.processing, span_from_seconds(1 / device.hz / 6));
  device.answer_time = std::min<Span>(device.answer_time, span_from_seconds(1 / device.hz / 6));
  return setup;
}

void set_angles(ColaDeviceOptions& device, double start_deg, double end_deg, double step_deg) {
  device.start = static_cast<std::int32_t>(std::lround(start_deg * 1e4));
  device.step = static_cast<std::uint16_t>(std::lround(step_deg * 1e4));
  device.exact_step_deg = step_deg;
  device.beams = static_cast<std::size_t>(std::lround((end_deg - start_deg) / step_deg)) + 1;
}

}  // namespace

std::vector<ColaFamily> cola_families() {
  std::vector<ColaFamily> families;
  for (const Product& product : products)
    families.push_back({product.name, product.range_min, product.range_max});
  return families;
}

void parse_cola(const std::string& model, const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"dialect", "serial", "hz", "start_deg", "end_deg", "step_deg", "clock_ppm", "clock_us", "boot",
              "processing_us", "echoes", "rssi", "interval", "joined"});
  Setup setup = setup_of(model);
  ColaDeviceOptions& device = setup.device;
  if (yaml.has("dialect")) {
    const std::string dialect = yaml.at("dialect").text();
    if (dialect != "a" && dialect != "b") yaml.at("dialect").fail("a or b");
    device.dialect = dialect == "a" ? Cola::text : Cola::binary;
  }
  if (yaml.has("serial")) device.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  device.hz = yaml.positive("hz", device.hz);
  const double start_deg = yaml.number("start_deg", setup.product->start_deg);
  const double end_deg = yaml.number("end_deg", setup.product->end_deg);
  const double step_deg = yaml.positive("step_deg", setup.product->step_deg);
  if (!(end_deg > start_deg && end_deg - start_deg < 360))
    yaml.fail("start_deg must be below end_deg, by less than 360");
  set_angles(device, start_deg, end_deg, step_deg);
  device.clock_ppm = yaml.number("clock_ppm", 0);
  device.clock_us = static_cast<std::uint32_t>(static_cast<std::int64_t>(yaml.not_negative("clock_us", 0)));
  device.boot = span_from_seconds(yaml.not_negative("boot", 0));
  device.processing =
      span_from_seconds(yaml.not_negative("processing_us", seconds(device.processing) * 1e6) * 1e-6);
  device.channels = static_cast<std::uint8_t>((1U << static_cast<unsigned>(yaml.positive("echoes", 1))) - 1);
  device.rssi = yaml.has("rssi") && yaml.at("rssi").flag() ? 1 : 0;
  device.interval = static_cast<std::uint16_t>(yaml.positive("interval", 1));
  if (yaml.has("joined")) setup.joined = yaml.at("joined").flag();
  entry.make = [setup](const SensorEntry&, Stamp start) {
    Setup recorded = setup;
    recorded.device.transit.delay = Span(0);  // the scene adds its own
    return std::make_unique<RecordedCola>(recorded, start);
  };
  entry.make_device = [setup](const Scene& scene, std::size_t sensor, Stamp now, Span shift) {
    Setup live = setup;
    live.device.transit = {scene.sensors[sensor].latency, scene.sensors[sensor].jitter};
    return live_cola(live, scene, sensor, now, shift);
  };
}

}  // namespace lidard::sim
