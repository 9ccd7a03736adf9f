// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "drivers/address.h"
#include "test/sim/world/geometry.h"

namespace lidard::sim {

/// One laser fires once. Origin and direction in the sensor's ROS frame (REP 103).
struct Beam {
  Stamp time;
  Ray ray;
  double azimuth = 0;       ///< rad, as the sensor counts it
  std::uint16_t laser = 0;  ///< the device's own number
};

/// What comes back to one beam: no echo, one, or a near and a far one (the beam touches an edge).
/// Distances hold the sensor's noise; `exact` ones do not.
struct Answer {
  struct Echo {
    double distance = no_hit;  ///< m, what the sensor measures
    double exact = no_hit;     ///< m, the truth
    double reflectivity = 0;
  };
  std::array<Echo, 2> echoes{};
  std::size_t count = 0;

  const Echo& near() const { return echoes[0]; }
  /// The far echo, or the only one.
  const Echo& far() const { return echoes[count > 1 ? 1 : 0]; }
};

/// The truth of one slot on the wire: a place in a packet or scan that holds one distance.
struct SlotTruth {
  Stamp time;             ///< when its beam fired
  double azimuth = 0;     ///< rad, exact, as the sensor counts it
  double exact = no_hit;  ///< m from where the beam crosses the sensor's axis; no noise, not quantised
  double wire = no_hit;   ///< m, as the wire's distance count says; +inf: the wire says nothing came back;
                          ///< NaN: it vouches for nothing
  double reflectivity = 0;
  std::uint16_t laser = 0;
  std::uint8_t echo = 0;  ///< which of several returns of the same beam
  /// m, sensor frame: the exact distance along the axis of the beam. Not finite where `exact` is not.
  Eigen::Vector3d xyz = Eigen::Vector3d::Zero();
};

/// A UDP payload, or a piece of a TCP stream, and when it is ready to leave.
struct Datagram {
  Stamp ready;
  std::uint16_t port = 0;  ///< both sides' port where it is not that of the data
  std::vector<std::uint8_t> payload;
  bool to_device = false;  ///< TCP: what its client wrote
};

/// What the device knows of its vehicle's motion when it encodes.
struct Surroundings {
  double speed = 0;  ///< m/s
};

/// Speaks like one device: a group of beams (a packet, a scan) goes out, answers come back, bytes leave.
class SensorModel {
 public:
  virtual ~SensorModel() = default;
  /// The beams of the next packet or scan in firing order; valid until the next call.
  virtual const std::vector<Beam>& next() = 0;
  /// Puts the answers to those beams on the wire; `slots` gets the truth in the order of the wire.
  virtual void encode(const std::vector<Answer>& answers, const Surroundings& around,
                      std::vector<Datagram>& datagrams, std::vector<SlotTruth>& slots) = 0;
};

struct SensorEntry;
struct Scene;
class TcpDevice;
class SafetySettings;
/// Makes the device that a client finds at a TCP sensor's address, switched on long ago; `shift` is added to
/// a time of the client's clock to get the scene's.
using DeviceMaker =
    std::function<std::unique_ptr<TcpDevice>(const Scene& scene, std::size_t sensor, Stamp now, Span shift)>;
/// Makes a device that starts to measure at `start`.
using ModelMaker = std::function<std::unique_ptr<SensorModel>(const SensorEntry& entry, Stamp start)>;

/// A mounted sensor, whatever its model.
struct SensorEntry {
  std::string name;
  std::string model;
  Pose mount = Pose::Identity();  ///< in the vehicle's frame
  /// The mount after somebody knocked it, and s after the start of the scene when that was.
  Pose knocked = Pose::Identity();
  double knocked_at = no_hit;
  Endpoint from, to;
  Span phase{0};                      ///< measures this long after the start of the scene
  Span clock_offset{0};               ///< the device's clock minus the true time
  Span latency{20'000};               ///< from the last firing to the wire
  Span jitter{0};                     ///< up to that much more, evenly distributed
  double noise = 0;                   ///< m, standard deviation of a distance
  double divergence = 0;              ///< rad, horizontal width of a beam; 0: one exact ray
  double range_min = 0;               ///< m
  double range_max = 0;               ///< m
  std::vector<double> range_offsets;  ///< m, added to each distance; one for all lasers, or one per laser
  double range_offset(std::size_t laser) const {
    if (range_offsets.size() == 1) return range_offsets[0];
    return laser < range_offsets.size() ? range_offsets[laser] : 0;
  }
  ModelMaker make;
  DeviceMaker make_device;                         ///< empty: the sensor sends UDP datagrams
  std::shared_ptr<const SafetySettings> settings;  ///< of a sensor with a CoLa 2 port beside its datagrams
  bool is_tcp() const { return static_cast<bool>(make_device); }
};

/// The distance that `count` steps of `step` mm mean; +inf for none.
inline double wire_distance(std::uint32_t count, double step_mm) {
  return count == 0 ? no_hit : count * step_mm / 1000;
}

}  // namespace lidard::sim
