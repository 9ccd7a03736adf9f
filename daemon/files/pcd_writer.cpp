// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <regex>
#include <stdexcept>

#include "core/frames/scan_points.h"
#include "daemon/config/module.h"
#include "daemon/files/frame_writer.h"
#include "daemon/files/pcl_module.h"
#include "daemon/files/text_file.h"

namespace lidard {
namespace {

/// PCL compresses a file as a whole and needs some 130 bytes for each of its points. A larger file is written
/// in order of arrival, not compressed.
constexpr std::size_t most_compressed = 500'000;

void save(const std::string& path, const std::vector<CloudPoint>& points) {
  static const auto write = reinterpret_cast<decltype(&lidard_write_pcd)>(
      module_function("lidard_pcl", "lidard_write_pcd", "PCD files need the package lidard-pcl"));
  if (!write(path.c_str(), points.data(), points.size()))
    throw std::runtime_error(path + ": cannot be written as PCD");
}

void append(const PlanarScan& scan, std::vector<CloudPoint>& points) { append_points(scan, points); }
void append(const Cloud& cloud, std::vector<CloudPoint>& points) {
  points.insert(points.end(), cloud.points(), cloud.points() + cloud.size());
}

/// The header of a file of points as they stand in memory, the same length for any number of them (PCD 0.7,
/// as the Point Cloud Library documents it; lines that begin with # are comments).
std::string binary_header(std::uint64_t points) {
  constexpr std::size_t length = 256;
  const std::string rest = fmt::format(
      "\nVERSION 0.7\nFIELDS x y z intensity ring time\nSIZE 4 4 4 4 2 4\nTYPE F F F F U F\nCOUNT 1 1 1 1 1 "
      "1\n"
      "WIDTH {0}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
      points);
  const std::string head = "# .PCD v0.7 - Point Cloud Data file format ";
  return head + std::string(length - head.size() - rest.size(), '.') + rest;
}

/// The points of all frames in one file.
class OnePcd final : public FrameWriter {
 public:
  explicit OnePcd(std::string path) : path_(std::move(path)) {
    // Fail now, not after a long capture was decoded. The header needs the number of points, so output to
    // standard output goes to a file first.
    file_.reset(path_ == "-" ? std::tmpfile() : std::fopen(path_.c_str(), "wb"));
    if (!file_) fail("cannot be opened for writing");
  }

  void cloud(std::uint64_t /*frame*/, const Cloud& cloud) override {
    append(cloud, points_);
    spill_if_many();
  }
  void scan(std::uint64_t /*frame*/, const PlanarScan& scan) override {
    append(scan, points_);
    spill_if_many();
  }

  void finish() override {
    if (spilled_ == 0 && points_.empty()) throw std::runtime_error(path_ + ": there is no point to write");
    if (spilled_ == 0) {
      // PCL needs a path; a file without a name has one there.
      std::fflush(file_.get());
      save(path_ == "-" ? "/proc/self/fd/" + std::to_string(fileno(file_.get())) : path_, points_);
    } else {
      spill();
      std::rewind(file_.get());
      put(binary_header(spilled_));
    }
    if (path_ == "-") copy_to_standard_output();
    if (std::fclose(file_.release()) != 0) fail("cannot be written");
  }

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void spill_if_many() {
    if (points_.size() > most_compressed || spilled_ > 0) spill();
  }
  void spill() {
    if (spilled_ == 0) put(binary_header(0));
    put({reinterpret_cast<const char*>(points_.data()), points_.size() * sizeof(CloudPoint)});
    spilled_ += points_.size();
    points_.clear();
  }
  void put(std::string_view bytes) {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail("cannot be written");
  }
  void copy_to_standard_output() {
    std::rewind(file_.get());
    TextFile out("-");
    std::array<char, 65536> buffer;
    for (std::size_t got = 1; got > 0;) {
      got = std::fread(buffer.data(), 1, buffer.size(), file_.get());
      out.write({buffer.data(), got});
    }
    out.close();
  }
  [[noreturn]] void fail(const char* what) const {
    throw std::runtime_error(path_ + ": " + what + ": " + std::strerror(errno));
  }

  const std::string path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::vector<CloudPoint> points_;
  std::uint64_t spilled_ = 0;  // points that are in the file
};

/// Each frame in a file of its own.
class NumberedPcd final : public FrameWriter {
 public:
  explicit NumberedPcd(std::string path) : path_(std::move(path)) {
    const auto folder = std::filesystem::path(path_).parent_path();
    if (!folder.empty() && !std::filesystem::is_directory(folder))
      throw std::runtime_error(folder.string() + ": there is no such folder; make it first");
  }
  void cloud(std::uint64_t frame, const Cloud& cloud) override { write(frame, cloud); }
  void scan(std::uint64_t frame, const PlanarScan& scan) override { write(frame, scan); }
  void finish() override {}

 private:
  template <class Frame>
  void write(std::uint64_t number, const Frame& frame) {
    points_.clear();
    append(frame, points_);
    // A frame without returns has no file: PCL writes none without points.
    if (!points_.empty()) save(numbered_path(path_, number).value(), points_);
  }

  const std::string path_;
  std::vector<CloudPoint> points_;
};

}  // namespace

std::optional<std::string> numbered_path(const std::string& path, std::uint64_t number) {
  static const std::regex placeholder("%(0?[1-9]?)d");
  std::smatch found;
  if (!std::regex_search(path, found, placeholder)) return std::nullopt;
  return found.prefix().str() + fmt::format(fmt::runtime("{:" + found[1].str() + "d}"), number) +
         found.suffix().str();
}

std::unique_ptr<FrameWriter> make_pcd_writer(const std::string& path) {
  if (numbered_path(path, 0)) return std::make_unique<NumberedPcd>(path);
  return std::make_unique<OnePcd>(path);
}

}  // namespace lidard
