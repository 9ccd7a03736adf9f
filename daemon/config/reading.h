// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/config/values.h"
#include "drivers/model.h"

namespace lidard {

struct VehicleConfig;
struct SensorConfig;
struct MergedCloudConfig;
struct VirtualScanConfig;

/// What must be unique among all parts of a configuration, gathered while they are read.
class ConfigClaims {
 public:
  ConfigClaims();
  /// Records that `owner` publishes on `topic`; throws at `value` if another owner does.
  void publishes(const std::string& topic, const std::string& owner, const Value& value);
  /// Notes that a sensor listens to `topic`.
  void listens(const std::string& topic, const std::string& owner, const Value& value);
  /// Notes the pose of `child` in `parent`; throws at `value` if it has another one already.
  void holds_frame(const std::string& child, const std::string& parent, const Pose& pose,
                   const std::string& owner, const Value& value);
  /// Notes what `owner` takes a sensor with `topic:` for; throws if another one took it for the other kind.
  void uses(const std::string& sensor, FrameKind kind, const std::string& owner, const Value& value);
  bool is_used(const std::string& sensor) const { return uses_.count(sensor) != 0; }

 private:
  struct Frame {
    std::string parent;
    Pose pose;
    std::string owner;
  };
  struct Use {
    FrameKind kind;
    std::string owner;
  };
  std::map<std::string, std::string> topics_;  // without leading slash, to the owner
  std::map<std::string, Frame> frames_;
  std::map<std::string, Use> uses_;
};

/// A source of a merged or virtual scan: a sensor, a merged cloud, or a virtual scan.
struct Source {
  enum class Kind : std::uint8_t { sensor, topic, merged_cloud, virtual_scan };
  Kind kind = Kind::sensor;             ///< topic: a sensor with `topic:`, which may give scans or clouds
  std::string name;                     ///< of the sensor, or the topic of the other as it is published
  double range_min = 0, range_max = 0;  ///< m, between which it measures
  double free_range = 0;                ///< m that a beam without return proves free; 0: not known
  bool proves_nothing = false;          ///< points alone: a virtual scan of profile flatten
  std::vector<std::string> merged{};    ///< sensors of a merged cloud

  bool is_sensor() const { return kind == Kind::sensor || kind == Kind::topic; }
  friend bool operator==(const Source& a, const Source& b) { return a.kind == b.kind && a.name == b.name; }
};

/// A name in laserscan_topics, sources or cloud_topic that stands for a source.
struct Candidate {
  std::string called;
  std::optional<FrameKind> gives;  ///< frames under that name; empty: scans or clouds, as is wanted
  Source source;
  std::string what;       ///< "the topic of sensors.front", for messages
  std::string but_gives;  ///< what is wrong with it where other frames are wanted
};

/// A configuration while it is read: the parts so far, in their order, and what concerns all of them.
struct Reading {
  const std::string& file;
  std::vector<std::string>& warnings;
  VehicleConfig& vehicle;
  std::vector<SensorConfig>& sensors;
  std::vector<MergedCloudConfig>& merged_clouds;
  std::vector<VirtualScanConfig>& virtual_scans;

  ConfigClaims claims{};
  std::vector<Candidate> candidates{};
  std::set<std::string> invalid_names{};  ///< without leading slash
  bool is_complete = true;                ///< false if the file has unknown sections
  bool is_vehicle_valid = true;
  bool has_sensors = false;  ///< valid ones

  /// Keeps a remark that is no error.
  void warn(const Location& location, const std::string& what);
  /// Keeps the names of an invalid entry: its own and every text in it, which may be a topic or a frame.
  void add_invalid_names(const std::string& name, const Value& entry);
  /// True if `name` may belong to something that is left out because of a mistake.
  bool may_be_invalid(const std::string& name) const;
};

/// Reads the entries of a section, if there is one. Of those in which something is wrong the names are kept.
template <class Entry>
void read_entries(const std::optional<Value>& section, std::vector<Entry>& entries, Reading& reading,
                  Entry (*read_one)(const std::string& name, const Value& entry, Reading& reading)) {
  if (!section) return;
  read_each(*section, {}, [&](const std::string& name, const Value& value) {
    try {
      check_entry_name(name, value);
      entries.push_back(read_one(name, value, reading));
    } catch (const ConfigError&) {
      reading.add_invalid_names(name, value);
      throw;
    }
  });
}

/// What `value` names of the sources so far: something that gives frames of this kind. A leading slash is of
/// no importance. Throws if that is nothing, several things, or something that gives frames of another kind;
/// `expected` says what may be named.
Source read_source(const Value& value, FrameKind kind, const Reading& reading, const std::string& expected);

/// The sources of a merged scan or cloud.
struct SourceList {
  std::string_view key;  ///< that they stand in
  std::vector<std::string> names;
  std::vector<std::string> written;  ///< as they are called there
  std::vector<Source> sources;
  std::vector<Value> values;

  /// Index of the source that `value` names: as it is named in the list, or by its own name.
  std::size_t index_of(const Value& value, const std::string& expected) const;
};
/// Reads the sources that `key` names, each once; `kind_of` says which frames are wanted of one.
SourceList read_sources(const Mapping& yaml, std::string_view key, const std::string& expected,
                        FrameKind (*kind_of)(const Value&, const Reading&), Reading& reading);

}  // namespace lidard
