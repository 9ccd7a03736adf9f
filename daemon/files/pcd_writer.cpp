// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pcl/io/pcd_io.h>
#include <pcl/point_types.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "daemon/files/frame_writer.h"
#include "daemon/files/text_file.h"

namespace lidard {

/// The PCL point with the fields of our clouds (m, device units, ring from below, s after the cloud's stamp).
/// PCL pads it to 32 bytes, so messages and files must be read by field names, as PCL does.
struct EIGEN_ALIGN16 PointXYZIRT {
  PCL_ADD_POINT4D
  float intensity;
  std::uint16_t ring;
  float time;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace lidard

POINT_CLOUD_REGISTER_POINT_STRUCT(lidard::PointXYZIRT,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity,
                                                                          intensity)(std::uint16_t, ring,
                                                                                     ring)(float, time, time))

namespace lidard {
namespace {

class PcdWriter final : public FrameWriter {
 public:
  explicit PcdWriter(std::string path) : path_(std::move(path)) {
    // Found out now, not after a long capture was decoded.
    if (path_ != "-") TextFile(path_).close();
  }

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    static_cast<void>(frame);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint p = cloud.points()[i];
      PointXYZIRT point{};
      point.x = p.x, point.y = p.y, point.z = p.z;
      point.intensity = p.intensity, point.ring = p.ring, point.time = p.time;
      points_.push_back(point);
    }
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    static_cast<void>(frame);
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        const std::size_t i = scan.index(beam, echo);
        if (scan.statuses[i] != BeamStatus::hit) continue;
        PointXYZIRT point{};
        point.x = scan.ranges[i] * std::cos(scan.angle(beam));
        point.y = scan.ranges[i] * std::sin(scan.angle(beam));
        point.intensity = scan.intensities.empty() ? 0 : scan.intensities[i];
        point.time = scan.time_increment * static_cast<float>(beam);
        points_.push_back(point);
      }
    }
  }

  void finish() override {
    if (points_.empty()) throw std::runtime_error(path_ + ": there is no point to write");
    if (path_ != "-") {
      save(path_);
      return;
    }
    std::array<char, 32> name{"/tmp/lidard-XXXXXX"};
    const int descriptor = mkstemp(name.data());
    if (descriptor < 0) throw std::runtime_error("no temporary file for the PCD output can be made in /tmp");
    close(descriptor);
    save(name.data());
    std::ifstream file(name.data(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), {}};
    std::remove(name.data());
    TextFile out("-");
    out.write(bytes);
    out.close();
  }

 private:
  void save(const std::string& path) {
    pcl::PCDWriter writer;
    if (writer.writeBinaryCompressed(path, points_) != 0)
      throw std::runtime_error(path + ": cannot be written as PCD");
  }

  std::string path_;
  pcl::PointCloud<PointXYZIRT> points_;
};

}  // namespace

std::unique_ptr<FrameWriter> make_pcd_writer(const std::string& path) {
  return std::make_unique<PcdWriter>(path);
}

}  // namespace lidard
