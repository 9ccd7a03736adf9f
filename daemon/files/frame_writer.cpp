// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/frame_writer.h"

#include <cmath>

#include "daemon/files/row_text.h"

namespace lidard {
namespace {

class CsvWriter final : public FrameWriter {
 public:
  CsvWriter(const std::string& path, StampColumn stamps) : rows_(path), stamps_(stamps) {}

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    header("frame,packet,block,laser,ring,return,stamp_ns,azimuth_deg,distance_m,x_m,y_m,z_m,intensity\n");
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const ReturnOrigin& o = cloud.origins[i];
      const CloudColumn& c = cloud.columns[o.column];
      rows_.integer(frame).put(',').integer(c.packet).put(',').integer(+o.block).put(',').integer(o.laser);
      rows_.put(',').integer(+p.ring).put(',').integer(+c.echo).put(',');
      rows_.integer(stamps_ == StampColumn::device ? o.offset_ns : o.stamp.ns).put(',');
      rows_.fixed<5>(o.azimuth_deg).put(',').fixed<4>(o.distance_m).put(',');
      rows_.fixed<5>(wide(p.x)).put(',').fixed<5>(wide(p.y)).put(',').fixed<5>(wide(p.z)).put(',');
      rows_.shortest(p.intensity).put('\n');
      rows_.flush_if_long();
    }
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
        rows_.integer(frame).put(',').integer(beam).put(',').integer(echo).put(',');
        rows_.fixed<7>(wide(scan.angle(beam))).put(',').fixed<4>(wide(scan.ranges[i])).put(',');
        rows_.shortest(scan.intensities.empty() ? 0.0F : scan.intensities[i]).put(',').integer(stamp);
        rows_.put(',').put(to_string(scan.statuses[i])).put('\n');
      }
    }
    rows_.flush_if_long();
  }

  void finish() override { rows_.close(); }

 private:
  static double wide(float value) { return static_cast<double>(value); }
  void header(const char* names) {
    if (started_) return;
    started_ = true;
    rows_.put(names);
  }

  RowText rows_;
  StampColumn stamps_;
  bool started_ = false;
};

/// One document per frame, each in a line of its own: {"frame", "stamp_ns", ..., "columns": [names], "rows":
/// [[...], ...]}.
class JsonWriter final : public FrameWriter {
 public:
  JsonWriter(const std::string& path, StampColumn stamps) : rows_(path), stamps_(stamps) {}

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    rows_.general(R"({{"frame":{},"stamp_ns":{},"complete":{},)", frame, cloud.stamp.ns, cloud.complete);
    rows_.put(R"("columns":["packet","block","laser","ring","return","stamp_ns","azimuth_deg","distance_m",)"
              R"("x_m","y_m","z_m","intensity"],"rows":[)");
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const ReturnOrigin& o = cloud.origins[i];
      const CloudColumn& c = cloud.columns[o.column];
      const std::int64_t stamp = stamps_ == StampColumn::device ? o.offset_ns : o.stamp.ns;
      const float x = p.x, y = p.y, z = p.z, intensity = p.intensity;
      const std::uint16_t ring = p.ring;
      rows_.general("{}[{},{},{},{},{},{},{},{},{},{},{},{}]", i == 0 ? "" : ",", c.packet, o.block, o.laser,
                    ring, c.echo, stamp, o.azimuth_deg, o.distance_m, x, y, z, intensity);
      rows_.flush_if_long();
    }
    rows_.put("]}\n");
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    rows_.general(
        R"({{"frame":{},"stamp_ns":{},"time_increment_s":{},"range_min_m":{},"range_max_m":{},"columns":)",
        frame, scan.stamp.ns, scan.time_increment, scan.range_min, scan.range_max);
    rows_.put(R"(["beam","echo","angle_rad","range_m","intensity","status")");
    rows_.put(flags_.empty() ? "" : R"(,"device_flags")").put(R"(],"rows":[)");
    bool first = true;
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        if (!is_written(scan, beam, echo)) continue;
        const std::size_t i = scan.index(beam, echo);
        rows_.general("{}[{},{},{},", first ? "" : ",", beam, echo, scan.angle(beam));
        number(scan.ranges[i]);
        rows_.general(R"(,{},"{}")", scan.intensities.empty() ? 0.0F : scan.intensities[i],
                      to_string(scan.statuses[i]));
        if (!flags_.empty()) rows_.put(',').integer(static_cast<int>(flags_[beam]));
        rows_.put(']');
        first = false;
      }
    }
    flags_.clear();
    rows_.put("]}\n").flush_if_long();
  }

  void beam_flags(const std::vector<float>& flags) override { flags_ = flags; }

  void finish() override { rows_.close(); }

 private:
  /// JSON has no inf and no NaN: a range without a hit is null, its status says why.
  void number(float value) {
    if (std::isfinite(value))
      rows_.general("{}", value);
    else
      rows_.put("null");
  }

  RowText rows_;
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
