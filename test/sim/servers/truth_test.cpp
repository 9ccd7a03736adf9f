// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/truth.h"

#include <gtest/gtest.h>

#include "test/sim/servers/test_scene.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

std::vector<std::uint8_t> written(const Scene& scene, const std::vector<KeptPacket>& kept) {
  TruthWriter writer(scene);
  for (std::uint32_t i = 0; i < kept.size(); ++i) {
    if (kept[i].measured) writer.add(kept[i].measurement, i);
  }
  return writer.bytes();
}

TEST(TruthFile, GivesBackWhatWasWritten) {
  for (const char* model : {"velodyne_vlp16", "sick_microscan3"}) {
    const Scene scene =
        room(model, "range_max: 5.5, options: {}", "vehicle: {path: [{duration: 9, speed: 3}]}\n");
    const auto kept = all_packets(scene);
    const auto bytes = written(scene, kept);
    const auto sensors = parse_truth({bytes.data(), bytes.size()}, "t");
    ASSERT_EQ(sensors.size(), 1U);
    EXPECT_EQ(sensors[0].name, "it");
    EXPECT_EQ(sensors[0].model, model);
    ASSERT_FALSE(sensors[0].records.empty());
    for (const TruthRecord& record : sensors[0].records) {
      const Measurement& measurement = kept[record.record].measurement;
      EXPECT_EQ(record.number, measurement.number);
      EXPECT_EQ(record.begin, measurement.begin);
      EXPECT_EQ(record.end, measurement.end);
      EXPECT_EQ(record.vehicle.x, measurement.vehicle.x);
      EXPECT_EQ(record.vehicle.yaw, measurement.vehicle.yaw);
      ASSERT_EQ(record.ranges.size(), measurement.slots.size());
      for (std::size_t i = 0; i < record.ranges.size(); ++i) {
        ASSERT_EQ(record.ranges[i], static_cast<float>(measurement.slots[i].exact));
      }
    }
  }
}

TEST(TruthFile, ForeignAndCutFilesAreRefused) {
  const Scene scene = room("sick_microscan3", "options: {}");
  const auto bytes = written(scene, all_packets(scene));
  for (const std::size_t size : {std::size_t{0}, std::size_t{15}, std::size_t{16}, std::size_t{95},
                                 std::size_t{96}, bytes.size() / 2, bytes.size() - 1}) {
    EXPECT_THROW(parse_truth({bytes.data(), size}, "t"), TruthError) << size;
  }
  auto lying = bytes;
  lying[16 + 64 + 3] = 0xff;  // number of records
  EXPECT_THROW(parse_truth({lying.data(), lying.size()}, "t"), TruthError);
  lying = bytes;
  lying[0] = 'X';
  EXPECT_THROW(parse_truth({lying.data(), lying.size()}, "t"), TruthError);
  EXPECT_THROW(read_truth("/nowhere/t"), TruthError);
}

}  // namespace
