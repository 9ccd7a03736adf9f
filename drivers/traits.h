// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <initializer_list>

namespace lidard {

/// An ability of some models. A key of the configuration that only some sensors accept names one of these.
enum class Trait : std::uint8_t {
  echoes,       ///< several echoes of a beam of a planar scanner
  revolutions,  ///< clouds are revolutions of firing sequences, which can be cut, organised and split by ring
  calibration,  ///< accepts a calibration file
  silent_beams_are_free,  ///< a beam without return proves that nothing is there, up to free_range()
  packet_messages,        ///< packets can also come in velodyne_msgs/VelodyneScan
  gnss,                   ///< sends the sentences of a satellite receiver to telemetry_port
  web_control,            ///< its settings are read and changed through its web interface
  settings_writable,      ///< settings can be changed over TCP, if allowed
  receiver_settable,      ///< streams over UDP and the receiver's address can be set over TCP
  logins,                 ///< has user levels with passwords
  skip_setting,           ///< can skip scans, by a setting of the device (CoLa)
  skip_request,           ///< can skip scans and merge beams, by the request for scans (SCIP)
  clock_request,          ///< its clock can be compared with the host's on request (SCIP)
  states_on_request,      ///< sends its states only on request (CoLa)
  output_paths,           ///< sends the state of its output paths (safety scanners)
  // Other fields of a model say these; Model::has() knows them.
  known,        ///< every model, in contrast to a topic of another driver
  planar,       ///< gives scans of one plane
  multi_plane,  ///< gives clouds
  datagrams,    ///< streams over UDP
  scans,        ///< gives a LaserScan: a planar scanner, or a ring of revolutions
  skips,        ///< can skip scans, whichever way
};

/// The traits of a model.
class Traits {
 public:
  constexpr Traits() = default;
  constexpr Traits(std::initializer_list<Trait> traits) { add(traits); }
  constexpr void add(Trait trait) { bits_ |= bit(trait); }
  constexpr void add(std::initializer_list<Trait> traits) {
    for (const Trait trait : traits) add(trait);
  }
  constexpr bool has(Trait trait) const { return (bits_ & bit(trait)) != 0; }

 private:
  static constexpr std::uint32_t bit(Trait trait) { return 1U << static_cast<unsigned>(trait); }
  std::uint32_t bits_ = 0;
};

}  // namespace lidard
