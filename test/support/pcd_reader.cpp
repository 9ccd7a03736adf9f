// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/pcd_reader.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace lidard::test {
namespace {

template <typename T>
T take(const char*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

NebulaPoint point_at(const char* at) {
  NebulaPoint p{};
  p.x = take<float>(at);
  p.y = take<float>(at);
  p.z = take<float>(at);
  p.intensity = take<unsigned char>(at);
  p.return_type = take<unsigned char>(at);
  p.channel = take<unsigned short>(at);
  p.azimuth_deg = take<float>(at) * 180 / M_PI;
  p.elevation_deg = take<float>(at) * 180 / M_PI;
  p.distance_m = take<float>(at);
  p.time_stamp_ns = take<unsigned>(at);
  return p;
}

}  // namespace

std::vector<NebulaPoint> read_nebula_pcd(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string all(std::istreambuf_iterator<char>(file), {});
  const std::string fields =
      "FIELDS x y z intensity return_type channel azimuth elevation distance time_stamp\n"
      "SIZE 4 4 4 1 1 2 4 4 4 4\n";
  const std::string data = "DATA binary\n";
  const std::size_t begin = all.find(data);
  if (all.find(fields) == std::string::npos || begin == std::string::npos)
    throw std::runtime_error(path + ": not a PCD file of nebula's fields");
  constexpr std::size_t point_bytes = 32;
  std::vector<NebulaPoint> points;
  for (std::size_t at = begin + data.size(); at + point_bytes <= all.size(); at += point_bytes)
    points.push_back(point_at(all.data() + at));
  return points;
}

}  // namespace lidard::test
