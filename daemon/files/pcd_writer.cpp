// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "daemon/files/frame_writer.h"
#include "daemon/files/pcl_module.h"
#include "daemon/files/text_file.h"

namespace lidard {
namespace {

/// The module stands beside the program where it was built, and below lib/lidard where it was installed.
decltype(&lidard_write_pcd) load_pcl() {
  const std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  std::string trouble;
  for (const auto& folder : {beside, beside / "../lib/lidard/modules"}) {
    void* const module = dlopen((folder / "lidard_pcl.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const found = module == nullptr ? nullptr : dlsym(module, "lidard_write_pcd");
    if (found != nullptr) return reinterpret_cast<decltype(&lidard_write_pcd)>(found);
    trouble = dlerror();
  }
  throw std::runtime_error("PCD files need lidard's module for PCL (package lidard-pcl): " + trouble);
}

class PcdWriter final : public FrameWriter {
 public:
  explicit PcdWriter(std::string path) : path_(std::move(path)), write_(load_pcl()) {
    // Found out now, not after a long capture was decoded.
    if (path_ != "-") TextFile(path_).close();
  }

  void cloud(std::uint64_t frame, const Cloud& cloud) override {
    static_cast<void>(frame);
    points_.insert(points_.end(), cloud.points(), cloud.points() + cloud.size());
  }

  void scan(std::uint64_t frame, const PlanarScan& scan) override {
    static_cast<void>(frame);
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
        const std::size_t i = scan.index(beam, echo);
        if (scan.statuses[i] != BeamStatus::hit) continue;
        CloudPoint point{};
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
  void save(const std::string& path) const {
    if (!write_(path.c_str(), points_.data(), points_.size()))
      throw std::runtime_error(path + ": cannot be written as PCD");
  }

  const std::string path_;
  const decltype(&lidard_write_pcd) write_;
  std::vector<CloudPoint> points_;
};

}  // namespace

std::unique_ptr<FrameWriter> make_pcd_writer(const std::string& path) {
  return std::make_unique<PcdWriter>(path);
}

}  // namespace lidard
