// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/scene_device.h"

#include <utility>

#include "test/sim/world/rng.h"
#include "test/sim/world/scene.h"

namespace lidard::sim {
namespace {

/// The device of a capture.
class RecordedDevice final : public SensorModel {
 public:
  RecordedDevice(SceneDevice setup, Stamp start)
      : setup_(std::move(setup)),
        start_(start),
        power_on_(start - setup_.time_of(setup_.turns_before)),
        turn_(setup_.turns_before),
        // The scene adds its own transit.
        device_(setup_.make(
            {Span(0), Span(0)}, [this](Stamp, std::size_t) { return *answers_; }, power_on_)) {}

  const std::vector<Beam>& next() override {
    const Span since = setup_.time_of(++turn_);
    beams_ = setup_.beams(power_on_ + since, since, setup_.beam_count);
    return beams_;
  }

  void encode(const std::vector<Answer>& answers, const Surroundings&, std::vector<Datagram>& datagrams,
              std::vector<SlotTruth>& slots) override {
    answers_ = &answers;
    for (std::size_t i = 0; i < answers.size(); ++i) slots.push_back(slot(beams_[i], answers[i]));
    if (turn_ == setup_.turns_before + 1) write_requests(datagrams);
    drain(beams_.front().time + setup_.sent_within, false, datagrams);
  }

 private:
  SlotTruth slot(const Beam& beam, const Answer& answer) const {
    SlotTruth slot;
    slot.time = beam.time;
    slot.azimuth = beam.azimuth;
    slot.exact = answer.near().exact;
    slot.wire = setup_.wire(answer);
    slot.reflectivity = answer.near().reflectivity;
    slot.laser = beam.laser;
    slot.xyz = answer.near().exact * beam.ray.direction;
    return slot;
  }
  void write_requests(std::vector<Datagram>& datagrams) {
    Stamp now = start_ + setup_.first_request;
    device_->connected(now);
    for (const std::string& request : setup_.requests) {
      if (!setup_.joined) datagrams.push_back({now, 0, {request.begin(), request.end()}, true});
      device_->receive(request, now);
      now = now + setup_.next_request;
      drain(now, setup_.joined, datagrams);
    }
  }
  void drain(Stamp until, bool drop, std::vector<Datagram>& datagrams) {
    while (auto sent = device_->next(until)) {
      if (!drop) datagrams.push_back({sent->time, 0, {sent->bytes.begin(), sent->bytes.end()}, false});
    }
  }

  SceneDevice setup_;
  Stamp start_, power_on_;
  std::int64_t turn_;
  std::vector<Beam> beams_;
  const std::vector<Answer>* answers_ = nullptr;
  std::unique_ptr<TcpDevice> device_;
};

/// The device of a server: sees what stands in the scene now.
std::unique_ptr<TcpDevice> live_device(const SceneDevice& setup, const Scene& scene, std::size_t sensor,
                                       Stamp now, Span shift) {
  const SensorEntry& entry = scene.sensors[sensor];
  const Stamp power_on = now - setup.time_of(setup.turns_before);
  auto rng = std::make_shared<Rng>(scene.seed + sensor);
  const auto view = [&scene, &entry, beams_of = setup.beams, power_on, shift, rng](Stamp begin,
                                                                                   std::size_t beams) {
    std::vector<Answer> answers;
    for (const Beam& beam : beams_of(begin, begin - power_on, beams)) {
      Answer& answer = answers.emplace_back();
      add_echo(entry, beam.laser, look(scene, entry, beam.ray, beam.time + shift), *rng, answer);
    }
    return answers;
  };
  return setup.make({entry.latency, entry.jitter}, view, power_on);
}

}  // namespace

void set_device(const SceneDevice& device, SensorEntry& entry) {
  entry.make = [device](const SensorEntry&, Stamp start) {
    return std::make_unique<RecordedDevice>(device, start);
  };
  entry.make_device = [device](const Scene& scene, std::size_t sensor, Stamp now, Span shift) {
    return live_device(device, scene, sensor, now, shift);
  };
}

}  // namespace lidard::sim
