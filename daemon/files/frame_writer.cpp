// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/frame_writer.h"

#include <cmath>
#include <string_view>
#include <utility>

#include "daemon/files/row_text.h"

namespace lidard {
namespace {

/// Rows of numbers, as CSV or as JSON. JSON has one document per frame, each in a line of its own: properties
/// of the frame such as "stamp_ns", "columns": [names], "rows": [[...], ...].
class TableWriter final : public FrameWriter {
 public:
  TableWriter(const std::string& path, StampColumn stamps, bool json)
      : rows_(path), stamps_(stamps), json_(json) {}

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    if (json_)
      rows_.general(R"({{"frame":{},"stamp_ns":{},"complete":{},)", frame, cloud.stamp.ns, cloud.complete);
    begin({"packet", "block", "laser", "ring", "return", "stamp_ns", "azimuth_deg", "distance_m", "x_m",
           "y_m", "z_m", "intensity"});
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      const ReturnOrigin& o = cloud.origins[i];
      const CloudColumn& c = cloud.columns[o.column];
      begin_row(frame);
      rows_.integer(c.packet).put(',').integer(+o.block).put(',').integer(o.laser);
      rows_.put(',').integer(+p.ring).put(',').integer(+c.echo).put(',');
      rows_.integer(stamps_ == StampColumn::device ? o.offset_ns : o.stamp.ns).put(',');
      rows_.fixed<5>(o.azimuth_deg).put(',').fixed<4>(o.distance_m).put(',');
      rows_.fixed<5>(wide(p.x)).put(',').fixed<5>(wide(p.y)).put(',').fixed<5>(wide(p.z)).put(',');
      rows_.shortest(p.intensity).put(json_ ? ']' : '\n');
      rows_.flush_if_long();
    }
    end();
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    if (json_)
      rows_.general(R"({{"frame":{},"stamp_ns":{},"time_increment_s":{},"range_min_m":{},"range_max_m":{},)",
                    frame, scan.stamp.ns, scan.time_increment, scan.range_min, scan.range_max);
    std::vector<std::string_view> names{"beam",      "echo",     "angle_rad", "range_m",
                                        "intensity", "stamp_ns", "status"};
    if (!flags_.empty()) names.emplace_back("device_flags");
    begin(names);
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      const Span since_first =
          span_from_seconds(static_cast<double>(scan.time_increment) * static_cast<double>(beam));
      const std::int64_t stamp =
          (stamps_ == StampColumn::device ? Stamp{} + since_first : scan.stamp + since_first).ns;
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        if (!is_written(scan, beam, echo)) continue;
        const std::size_t i = scan.index(beam, echo);
        begin_row(frame);
        rows_.integer(beam).put(',').integer(echo).put(',').fixed<7>(wide(scan.angle(beam))).put(',');
        // JSON has no inf and no NaN: a range without a hit is null, its status says why.
        if (json_ && !std::isfinite(scan.ranges[i]))
          rows_.put("null,");
        else
          rows_.fixed<4>(wide(scan.ranges[i])).put(',');
        rows_.shortest(scan.intensities.empty() ? 0.0F : scan.intensities[i]).put(',').integer(stamp);
        rows_.put(json_ ? ",\"" : ",").put(to_string(scan.statuses[i])).put(json_ ? "\"" : "");
        if (!flags_.empty()) rows_.put(',').integer(static_cast<int>(flags_[beam]));
        rows_.put(json_ ? ']' : '\n');
      }
    }
    flags_.clear();
    end();
  }

  void beam_flags(const std::vector<float>& flags) override {
    if (json_) flags_ = flags;
  }

  void finish() override { rows_.close(); }

 private:
  static double wide(float value) { return static_cast<double>(value); }
  /// The names of the columns: of each frame, or once before all.
  void begin(const std::vector<std::string_view>& names) {
    if (!json_ && std::exchange(has_head_, true)) return;
    rows_.put(json_ ? R"("columns":[)" : "frame");
    for (const std::string_view name : names) {
      if (json_)
        rows_.put(name == names.front() ? "\"" : ",\"").put(name).put('"');
      else
        rows_.put(',').put(name);
    }
    rows_.put(json_ ? R"(],"rows":[)" : "\n");
    is_first_ = true;
  }
  void begin_row(std::uint64_t frame) {
    if (json_)
      rows_.put(std::exchange(is_first_, false) ? "[" : ",[");
    else
      rows_.integer(frame).put(',');
  }
  void end() {
    if (json_) rows_.put("]}\n");
    rows_.flush_if_long();
  }

  RowText rows_;
  const StampColumn stamps_;
  const bool json_;
  bool has_head_ = false, is_first_ = true;
  std::vector<float> flags_;  // of the next scan's beams; empty: the device sends none
};

}  // namespace

std::unique_ptr<FrameWriter> make_csv_writer(const std::string& path, StampColumn stamps) {
  return std::make_unique<TableWriter>(path, stamps, false);
}

std::unique_ptr<FrameWriter> make_json_writer(const std::string& path, StampColumn stamps) {
  return std::make_unique<TableWriter>(path, stamps, true);
}

}  // namespace lidard
