// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/simulate.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace lidard::sim {
namespace {

// Two surfaces that a beam touches at once are told apart from this depth on (m): about the length of a
// pulse.
constexpr double echo_separation = 1.0;

/// One sensor while it drives along: its device, and the datagrams that are ready but have not left yet.
class Station {
 public:
  Station(const Scene& scene, std::size_t index)
      : scene_(scene),
        entry_(scene.sensors[index]),
        index_(index),
        rng_(scene.seed + 0x10001U * (index + 1)),
        model_(entry_.make(entry_, scene.start + entry_.phase)) {}

  /// The datagram that leaves next; measures until there is one.
  const Datagram& front() {
    while (waiting_.empty()) measure();
    return waiting_.front();
  }

  SimPacket packet() {
    const Datagram& datagram = front();
    SimPacket packet;
    packet.sensor = index_;
    packet.time = datagram.ready;
    packet.from = entry_.from;
    packet.to = entry_.to;
    if (datagram.port != 0) packet.from.port = packet.to.port = datagram.port;
    packet.payload = ByteView(datagram.payload.data(), datagram.payload.size());
    if (datagram.to_device) std::swap(packet.from, packet.to);
    packet.tcp = entry_.is_tcp();
    packet.to_device = datagram.to_device;
    if (waiting_.size() == 1) packet.measurement = &measurement_;
    return packet;
  }

  void pop() { waiting_.pop_front(); }

 private:
  void measure() {
    const std::vector<Beam>& beams = model_->next();
    answers_.clear();
    for (const Beam& beam : beams) answers_.push_back(answer(beam));
    measurement_.sensor = index_;
    measurement_.number = count_++;
    measurement_.begin = beams.front().time;
    measurement_.end = beams.back().time;
    measurement_.vehicle = scene_.trajectory.at(scene_.elapsed(measurement_.begin));
    measurement_.slots.clear();
    datagrams_.clear();
    const Surroundings around{scene_.trajectory.speed(scene_.elapsed(measurement_.end))};
    model_->encode(answers_, around, datagrams_, measurement_.slots);
    for (Datagram& datagram : datagrams_) send(std::move(datagram));
  }

  void send(Datagram&& datagram) {
    Stamp leaves = datagram.ready + entry_.latency;
    if (entry_.jitter.count() > 0) {
      leaves = leaves +
               Span(static_cast<std::int64_t>(rng_.uniform() * static_cast<double>(entry_.jitter.count())));
    }
    // A device has one cable: nothing overtakes.
    datagram.ready = last_ = std::max(leaves, last_ + Span(1));
    waiting_.push_back(std::move(datagram));
  }

  Answer answer(const Beam& beam) {
    Answer answer;
    if (entry_.divergence > 0) {
      const Hit left = look(scene_, entry_, turned(beam.ray, entry_.divergence / 2), beam.time);
      const Hit right = look(scene_, entry_, turned(beam.ray, -entry_.divergence / 2), beam.time);
      const Hit& near = left.distance <= right.distance ? left : right;
      const Hit& far = left.distance <= right.distance ? right : left;
      if (far.distance - near.distance > echo_separation) {
        add_echo(entry_, beam.laser, near, rng_, answer);
        add_echo(entry_, beam.laser, far, rng_, answer);
        return answer;
      }
    }
    add_echo(entry_, beam.laser, look(scene_, entry_, beam.ray, beam.time), rng_, answer);
    return answer;
  }

  static Ray turned(const Ray& ray, double angle) {
    return {ray.origin, Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) * ray.direction};
  }

  const Scene& scene_;
  const SensorEntry& entry_;
  std::size_t index_;
  Rng rng_;
  std::unique_ptr<SensorModel> model_;
  std::uint64_t count_ = 0;
  Stamp last_;
  std::vector<Answer> answers_;
  std::vector<Datagram> datagrams_;
  std::deque<Datagram> waiting_;
  Measurement measurement_;
};

}  // namespace

void simulate(const Scene& scene, const std::function<bool(const SimPacket&)>& sink) {
  std::deque<Station> stations;
  for (std::size_t i = 0; i < scene.sensors.size(); ++i) stations.emplace_back(scene, i);
  while (!stations.empty()) {
    const auto next = std::min_element(stations.begin(), stations.end(), [](Station& a, Station& b) {
      return a.front().ready < b.front().ready;
    });
    const SimPacket packet = next->packet();
    if (packet.time >= scene.start + scene.duration || !sink(packet)) return;
    next->pop();
  }
}

Pose vehicle_motion(const Scene& scene, Stamp from, Stamp to) {
  return scene.vehicle_at(to).inverse() * scene.vehicle_at(from);
}

}  // namespace lidard::sim
