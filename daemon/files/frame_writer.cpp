// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/frame_writer.h"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "daemon/files/text_file.h"

namespace lidard {
namespace {

class CsvWriter final : public FrameWriter {
 public:
  CsvWriter(const std::string& path, StampColumn stamps) : file_(path), stamps_(stamps) {}

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    header("frame,packet,block,laser,ring,return,stamp_ns,azimuth_deg,distance_m,x_m,y_m,z_m,intensity\n");
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const ReturnOrigin& o = cloud.origins[i];
      const CloudColumn& c = cloud.columns[o.column];
      fmt::format_to(std::back_inserter(text_),
                     "{},{},{},{},{},{},{},{:.5f},{:.4f},{:.5f},{:.5f},{:.5f},{:g}\n", frame, c.packet,
                     o.block, o.laser, copy_of(p.ring), c.echo,
                     stamps_ == StampColumn::device ? o.offset_ns : o.stamp.ns, o.azimuth_deg, o.distance_m,
                     copy_of(p.x), copy_of(p.y), copy_of(p.z), copy_of(p.intensity));
    }
    flush();
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    header("frame,beam,echo,angle_rad,range_m,intensity,stamp_ns,status\n");
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      const Span since_first =
          span_from_seconds(static_cast<double>(scan.time_increment) * static_cast<double>(beam));
      const std::int64_t stamp =
          (stamps_ == StampColumn::device ? Stamp{} + since_first : scan.stamp + since_first).ns;
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        if (!is_written(scan, beam, echo)) continue;
        const std::size_t i = scan.index(beam, echo);
        fmt::format_to(std::back_inserter(text_), "{},{},{},{:.7f},{:.4f},{:g},{},{}\n", frame, beam, echo,
                       scan.angle(beam), scan.ranges[i],
                       scan.intensities.empty() ? 0.0F : scan.intensities[i], stamp,
                       to_string(scan.statuses[i]));
      }
    }
    flush();
  }

  void finish() override { file_.close(); }

 private:
  // A copy, because a member of a packed struct cannot be bound to a reference.
  template <typename T>
  static T copy_of(T value) {
    return value;
  }
  void header(const char* names) {
    if (started_) return;
    started_ = true;
    file_.write(names);
  }
  void flush() {
    file_.write({text_.data(), text_.size()});
    text_.clear();
  }

  TextFile file_;
  StampColumn stamps_;
  bool started_ = false;
  fmt::memory_buffer text_;
};

using nlohmann::json;

/// JSON has no inf and no NaN: a range without a hit is null, its status says why.
json number(float value) { return std::isfinite(value) ? json(value) : json(nullptr); }

/// A line for each frame: {"frame", "stamp_ns", "complete", "columns": [names], "rows": [[...], ...]}
class JsonWriter final : public FrameWriter {
 public:
  JsonWriter(const std::string& path, StampColumn stamps) : file_(path), stamps_(stamps) {}

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    json rows = json::array();
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const ReturnOrigin& o = cloud.origins[i];
      const CloudColumn& c = cloud.columns[o.column];
      const std::int64_t stamp = stamps_ == StampColumn::device ? o.offset_ns : o.stamp.ns;
      const float x = p.x, y = p.y, z = p.z, intensity = p.intensity;
      const std::uint16_t ring = p.ring;
      rows.push_back(json::array({c.packet, o.block, o.laser, ring, c.echo, stamp, o.azimuth_deg,
                                  o.distance_m, x, y, z, intensity}));
    }
    write(json{{"frame", frame},
               {"stamp_ns", cloud.stamp.ns},
               {"complete", cloud.complete},
               {"columns",
                {"packet", "block", "laser", "ring", "return", "stamp_ns", "azimuth_deg", "distance_m", "x_m",
                 "y_m", "z_m", "intensity"}},
               {"rows", std::move(rows)}});
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    json rows = json::array();
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        if (!is_written(scan, beam, echo)) continue;
        const std::size_t i = scan.index(beam, echo);
        rows.push_back(json::array({beam, echo, scan.angle(beam), number(scan.ranges[i]),
                                    scan.intensities.empty() ? 0.0F : scan.intensities[i],
                                    to_string(scan.statuses[i])}));
        if (!flags_.empty()) rows.back().push_back(static_cast<int>(flags_[beam]));
      }
    }
    json columns = {"beam", "echo", "angle_rad", "range_m", "intensity", "status"};
    if (!flags_.empty()) columns.push_back("device_flags");
    flags_.clear();
    write(json{{"frame", frame},
               {"stamp_ns", scan.stamp.ns},
               {"time_increment_s", scan.time_increment},
               {"range_min_m", scan.range_min},
               {"range_max_m", scan.range_max},
               {"columns", std::move(columns)},
               {"rows", std::move(rows)}});
  }

  void beam_flags(const std::vector<float>& flags) override { flags_ = flags; }

  void finish() override { file_.close(); }

 private:
  void write(const json& object) { file_.write(object.dump() + "\n"); }

  TextFile file_;
  StampColumn stamps_;
  std::vector<float> flags_;  // of the next scan's beams; empty: the device sends none
};

}  // namespace

std::unique_ptr<FrameWriter> make_csv_writer(const std::string& path, StampColumn stamps) {
  return std::make_unique<CsvWriter>(path, stamps);
}

std::unique_ptr<FrameWriter> make_json_writer(const std::string& path, StampColumn stamps) {
  return std::make_unique<JsonWriter>(path, stamps);
}

}  // namespace lidard
