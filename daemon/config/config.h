// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/pose.h"
#include "core/evidence/placed_scan.h"
#include "core/frames/cloud_layout.h"
#include "core/frames/frame_filter.h"
#include "core/frames/ring_scan.h"
#include "core/frames/scan_grid.h"
#include "core/merge/scheduler.h"
#include "core/virtual/virtualizer.h"
#include "daemon/config/config_error.h"
#include "drivers/driver.h"
#include "drivers/flow.h"
#include "drivers/model.h"
#include "drivers/web_control.h"

namespace lidard {

/// A fixed transform for /tf_static.
struct StaticTransform {
  std::string parent;
  std::string child;
  Pose pose;  ///< of child in parent
};

/// `vehicle:` of the configuration.
struct VehicleConfig {
  std::string base_frame = "base_link";
  std::vector<Eigen::Vector2d> footprint;  ///< m, base_frame; empty: no self filter
  std::string odometry_frame;              ///< poses of base_frame in it come from tf; empty: none
  std::string odometry_topic;              ///< or from a nav_msgs/Odometry topic; empty: none
  std::string imu_topic;    ///< or from turn rates (sensor_msgs/Imu) and a speed ahead; empty: none
  std::string speed_topic;  ///< geometry_msgs/TwistStamped; empty: none

  bool has_motion() const { return !odometry_frame.empty() || !odometry_topic.empty() || !imu_topic.empty(); }
};

/// One entry of `sensors:`. Exactly one of model and topic is set.
struct SensorConfig {
  std::string name;
  const Model* model = nullptr;
  std::string topic;  ///< a LaserScan or PointCloud2 topic of another driver
  std::optional<IpAddress>
      ip_address;             ///< only packets from here; unset: any sender not claimed by another sensor
  std::uint16_t ip_port = 0;  ///< local UDP port; of a device that streams over TCP: its own port
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

/// What stands in a beam of the output where nothing was seen.
enum class EmptyBeam : std::uint8_t { inf, nan, range_max_plus_one, minus_inf, zero };

/// Keys that merged and virtual scans share.
struct OutputScanConfig {
  Profile profile = Profile::flatten;
  ScanGridSpec grid;
  EmptyBeam empty = EmptyBeam::inf;       ///< nothing there
  EmptyBeam unobserved = EmptyBeam::nan;  ///< not known
  std::optional<double> min_height,
      max_height;  ///< m, in the output frame; unset: the default of the kind of output
};

/// One more scan of the same merge: `also:` of an entry of `merged_scans:`.
struct AlsoScanConfig {
  std::string topic;
  Profile profile = Profile::safety;
};

/// What a merged scan or cloud does while poses of the vehicle are missing: as if it stood, wait for them as
/// long as for a source, or leave the output out.
enum class MissingMotion : std::uint8_t { stand, wait, drop };

/// One entry of `merged_scans:`.
struct MergedScanConfig {
  std::string name;
  std::vector<std::string> laserscan_topics;  ///< names of sensors
  std::string destination_frame;
  std::optional<Pose>
      destination_pose;                ///< of destination_frame in base_frame; identity for base_frame itself
  std::string scan_destination_topic;  ///< default: the entry's name
  std::string cloud_destination_topic;  ///< empty: no cloud
  ScheduleSettings schedule;
  MissingMotion on_missing_motion = MissingMotion::stand;
  std::string status_topic;  ///< what is known of each beam, as a LaserScan; empty: none
  OutputScanConfig output;
  std::vector<AlsoScanConfig> also;
  EchoChoice echoes = EchoChoice::last;
  bool veil_filter = true;
  double range_noise = 0.02;  ///< m, one standard deviation of the sources' ranges
  std::map<std::string, SourceSettings> source_settings;  ///< of sources that differ from the rest, by name
  double free_required = 0;                ///< m that a beam must be observed to be free; 0: range_max
  std::vector<std::string> free_requires;  ///< sources of which one must see a free beam's way; empty: any

  /// True if some scan of this merge is more than points.
  bool has_visibility() const;
};

/// One entry of `merged_clouds:`.
struct MergedCloudConfig {
  std::string name;
  std::vector<std::string>
      sources;  ///< names of sensors; a return's `sensor` is the place of its source here
  std::string destination_frame;
  std::optional<Pose> destination_pose;  ///< as in MergedScanConfig
  std::string destination_topic;         ///< default: the entry's name
  bool organized = false;                ///< a row per ring, else a list
  ScheduleSettings schedule;
  MissingMotion on_missing_motion = MissingMotion::stand;
};

/// One entry of `virtual_scans:`.
struct VirtualScanConfig {
  std::string name;
  std::string cloud_topic;  ///< name of a sensor that gives clouds, or topic of a merged cloud
  std::string base_frame;   ///< parent of the poses
  std::vector<std::string> virtual_laser_scan;  ///< output frames
  std::map<std::string, Pose> poses;  ///< of output frames in base_frame; a frame without one comes from tf
  std::string output_laser_topic;     ///< empty: one topic per frame, named like the frame
  OutputScanConfig output;
  std::vector<AlsoScanConfig> also;  ///< topics beneath that of the frame
  CutMode mode = CutMode::slice;
  GroundSettings ground;
  bool early_returns = false;       ///< echoes: all
  double no_return_free_range = 0;  ///< m that a beam without return proves free
  bool has_visibility() const;
  /// Topic of a frame's scan, or of one of its further scans.
  std::string topic(const std::string& frame, const AlsoScanConfig* further = nullptr) const;
};

/// `blackbox:` of the configuration.
struct BlackBoxConfig {
  double seconds = 0;      ///< of packets that are kept; 0: none
  double megabytes = 256;  ///< of memory at most: a shorter time is kept where that does not suffice
  std::string path;        ///< folder of the captures; empty: $STATE_DIRECTORY, else /var/lib/lidard
  int files = 10;          ///< captures that are kept there; the oldest is removed for a new one
  int per_day = 100;       ///< captures that errors may start within 24 hours
};

/// The whole configuration, complete and validated.
struct Config {
  std::string file;
  VehicleConfig vehicle;
  std::vector<SensorConfig> sensors;
  std::vector<MergedScanConfig> merged_scans;
  std::vector<MergedCloudConfig> merged_clouds;
  std::vector<VirtualScanConfig> virtual_scans;
  BlackBoxConfig black_box;
  std::vector<std::string> warnings;      ///< `file:line:column: what`, to be shown once
  std::vector<std::string> host_remarks;  ///< the same of this host's network, for what talks to sensors
  /// What a part of a configuration must know of the other parts; a file has none.
  struct Elsewhere {
    std::vector<StaticTransform> poses;  ///< of all parts
    std::set<std::string> merged;        ///< sources here whose scans another part merges
    bool has_sensors = false;
  };
  Elsewhere elsewhere;

  const SensorConfig* find_sensor(const std::string& name) const;
  /// The lidars behind the cloud_topic of a virtual scan: one, or those of a merged cloud.
  std::vector<std::string> lidars_of(const VirtualScanConfig& group) const;
};

/// Reads and validates a configuration file; throws ConfigError.
Config load_config(const std::string& path);
/// The same from text; `name` stands in messages where a file name would.
Config parse_config(const std::string& text, const std::string& name);
/// The configuration as YAML with every default filled in; parse_config() reads it back to the same.
std::string to_yaml(const Config& config);
/// True if two entries have the same name and the same value of every key, so that they do the same.
bool operator==(const VehicleConfig& a, const VehicleConfig& b);
bool operator==(const SensorConfig& a, const SensorConfig& b);
bool operator==(const MergedScanConfig& a, const MergedScanConfig& b);
bool operator==(const MergedCloudConfig& a, const MergedCloudConfig& b);
bool operator==(const VirtualScanConfig& a, const VirtualScanConfig& b);

/// The poses that a configuration fixes, each frame once.
std::vector<StaticTransform> fixed_poses(const Config& config);

/// What travels on a topic. A scan with several echoes goes to a topic of its own (MultiEchoLaserScan).
/// `extended_scan` and `output_paths`: a scan and a DeviceState as messages of sick_safetyscanners.
enum class TopicKind : std::uint8_t {
  scan,
  echoes,
  cloud,
  merged_cloud,
  message,
  extended_scan,
  output_paths
};

/// A topic that something in a configuration may publish on.
struct OutputTopic {
  std::string name;  ///< as ROS has it (relative names are resolved by the sink)
  TopicKind kind;
  bool promised = true;     ///< comes with every frame; else only when the device has something to report
  std::size_t message = 0;  ///< of TopicKind::message: message_kind() of what travels
  std::size_t id = 0;       ///< place in output_topics()
  std::string_view from{};  ///< the driver's name of what travels; empty: what every sensor of the kind gives
};

/// The topic of a sensor's own frames: its cloud, or its scan.
OutputTopic frame_topic(const SensorConfig& sensor);
/// Everything that a sensor of ours may publish on; a source with `topic:` publishes nothing.
std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor);
/// Everything that the configuration may publish on. At run time a topic travels as its entry of this list.
std::vector<OutputTopic> output_topics(const Config& config);

/// What comes from a sensor over the network, its data first; without an address in a flow where anybody may
/// send it.
std::vector<Flow> flows_of(const SensorConfig& sensor);

/// An entry of merged_scans:, merged_clouds: or virtual_scans: of the configuration.
struct OutputId {
  enum class Kind : std::uint8_t { merged, merged_cloud, virtual_group };
  Kind kind = Kind::merged;
  std::string entry;

  friend bool operator==(const OutputId& a, const OutputId& b) {
    return a.kind == b.kind && a.entry == b.entry;
  }
};

}  // namespace lidard
