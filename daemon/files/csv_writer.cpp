// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/fmt/fmt.h>

#include <iterator>

#include "daemon/files/frame_writer.h"
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

}  // namespace

std::unique_ptr<FrameWriter> make_csv_writer(const std::string& path, StampColumn stamps) {
  return std::make_unique<CsvWriter>(path, stamps);
}

}  // namespace lidard
