// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/frames/cloud_layout.h"
#include "core/frames/frame_filter.h"
#include "core/frames/ring_scan.h"
#include "daemon/config/outputs.h"
#include "daemon/config/topic.h"
#include "drivers/flow.h"
#include "drivers/web_control.h"

namespace lidard {

class Mapping;
struct Reading;
struct Source;

/// One entry of `sensors:`. Exactly one of model and topic is set.
struct SensorConfig {
  std::string name;
  const Model* model = nullptr;
  std::string topic;                    ///< a LaserScan or PointCloud2 topic of another driver
  std::optional<IpAddress> ip_address;  ///< only packets from here; unset: any that no other sensor claims
  std::uint16_t ip_port = 0;            ///< local UDP port; of a device that streams over TCP: its own port
  std::uint16_t telemetry_port = 0;  ///< local UDP port of what it sends beside its data; 0: not listened to
  std::string packet_topic;          ///< its packets come from here (velodyne_msgs/VelodyneScan), not by UDP
  std::string raw_topic;  ///< its packets are published here (velodyne_msgs/VelodyneScan); empty: not
  std::optional<IpAddress> multicast_group;
  std::string interface;     ///< network interface to join the group on; empty: the kernel's choice
  std::string frame_id;      ///< default: the sensor's name
  std::optional<Pose> pose;  ///< of the sensor in base_frame; unset: from tf
  std::string calibration;   ///< file as written, relative to the configuration's folder; empty: none
  std::size_t calibration_digest = 0;  ///< hash of the file's bytes, to detect changes
  DriverConfig driver;                 ///< model, frame_id and options, ready for Model::make
  VelodyneControl control;             ///< the sensor's web interface; nothing is done with it by default
  std::string scan_topic;    ///< of a planar scanner, or of the ring `ring_scan` of a multi-plane lidar
  std::string points_topic;  ///< of a multi-plane lidar
  std::string
      extended_scan_topic;         ///< scans with flags, sick_safetyscanners/ExtendedLaserScanMsg; empty: not
  std::string output_paths_topic;  ///< sick_safetyscanners/OutputPathsMsg; empty: not
  CloudLayout layout;              ///< of its cloud message
  std::string points_frame;        ///< frame of its cloud message; empty: frame_id
  bool deskew = false;             ///< the cloud message shows one instant, that of its stamp
  bool counter_clockwise = false;  ///< its LaserScan has its beams in this order, whichever way it turns
  std::optional<RingScanSpec> ring_scan;  ///< one ring of a multi-plane lidar as a planar scan
  FrameFilterSettings filter;             ///< of what is published of it; other outputs see all of it

  /// TCP port that the device listens on, for its data or its settings; 0: none.
  std::uint16_t device_port() const {
    if (model == nullptr) return 0;
    if (model->transport == Transport::tcp) return ip_port;
    return model->has(Trait::web_control) ? control.port : model->dialogue_port;
  }
};

/// Of `name`; nullptr: there is none.
const SensorConfig* find_sensor(const std::vector<SensorConfig>& sensors, const std::string& name);
/// The topic of a sensor's own frames: its cloud, or its scan.
OutputTopic frame_topic(const SensorConfig& sensor);
/// Everything that a sensor of ours may publish on; a source with `topic:` publishes nothing.
std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor);
/// What comes from a sensor over the network, its data first; without an address in a flow where anybody may
/// send it.
std::vector<Flow> flows_of(const SensorConfig& sensor);

/// The keys of an entry; each names the trait of the sensors that accept it. Those apply that the sensor
/// accepts and that have an effect with the others.
Keys sensor_keys(SensorConfig& sensor);
/// The sensors with a trait, for people ("Velodynes"); empty: all.
std::string_view products_with(Trait trait);
/// True if the key means something to the sensor, or to a sensor of its model at all.
bool accepts(const SensorConfig& sensor, const Key& key);
/// Why a key is rejected for this sensor, and the remedy.
Rejection refusal(const SensorConfig& sensor, const Key& key);

void read_sensors(const Mapping& root, Reading& reading);
/// Brings the limits of the ring that is a scan in line with those of the cloud.
void set_ring_limits(SensorConfig& sensor);
/// The sensor as a source.
Source source_of(const SensorConfig& sensor);
/// The sensors that give frames of this kind, for messages.
std::string names_of(const std::vector<SensorConfig>& sensors, FrameKind kind);

}  // namespace lidard
