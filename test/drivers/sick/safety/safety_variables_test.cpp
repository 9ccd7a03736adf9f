// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Bytes of each variable as SICK's own client reads them (SICKAG/sick_safetyscanners_base a46f34d,
// src/data_processing), written here by its offsets and not by our simulator.
#include <gtest/gtest.h>

#include <initializer_list>

#include "drivers/sick/safety/cola2_frame.h"

namespace lidard::sick {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// `size` zero bytes with these pieces laid over them.
Bytes bytes(std::size_t size, std::initializer_list<std::pair<std::size_t, Bytes>> pieces) {
  Bytes all(size);
  for (const auto& [at, piece] : pieces)
    std::copy(piece.begin(), piece.end(), all.begin() + static_cast<int>(at));
  return all;
}
ByteView view(const Bytes& bytes) { return {bytes.data(), bytes.size()}; }

// ParseDeviceName.cpp, ParseSerialNumber.cpp, ParseFirmwareVersion.cpp, ParseProjectName.cpp,
// ParseTypeCodeData.cpp: u16 length, then the letters.
TEST(SafetyVariables, APlainTextHasALengthOfTwoBytes) {
  EXPECT_EQ(read_text(view({4, 0, 'y', 'a', 'r', 'd'})), "yard");
  EXPECT_EQ(read_text(view({9, 0, 'y', 'a', 'r', 'd'})), "yard") << "longer than what came";
  EXPECT_EQ(read_text({}), "");
}

// ParseApplicationNameData.cpp: version letter at 0, its numbers at 1 to 3, u32 length at 4, letters at 8.
TEST(SafetyVariables, TheApplicationNameHasAVersionAndALengthOfFourBytes) {
  const Bytes name = {'R', 1, 0, 0, 8, 0, 0, 0, 'f', 'o', 'r', 'k', 'l', 'i', 'f', 't'};
  EXPECT_EQ(read_versioned_text(view(name)), "forklift");
  EXPECT_EQ(read_versioned_text(view(name).sub(0, 12)), "fork") << "cut off";
  EXPECT_EQ(read_versioned_text(view(name).sub(0, 7)), "");
  Bytes huge = name;
  huge[7] = 0xff;
  EXPECT_EQ(read_versioned_text(view(huge)), "forklift");
}

// ParseTypeCodeData.cpp: range in the letters at bytes 12 and 13, interface at 14 and 15, length included.
TEST(SafetyVariables, TheTypeCodeTellsRangeAndInterface) {
  EXPECT_EQ(range_of("MICS3-ACAZ40ZA1P01"), 40);
  EXPECT_EQ(range_of("MICS3-ACAZ90ZA1P01"), 64);
  EXPECT_EQ(interface_of("MICS3-ACAZ40ZA1P01"), 0) << "EFI-pro";
  EXPECT_EQ(interface_of("MICS3-ACAZ40IZ1P01"), 1) << "EtherNet/IP";
  EXPECT_EQ(interface_of("MICS3-ACAZ40PZ1P01"), 3) << "PROFINET";
  EXPECT_EQ(interface_of("MICS3-ACAZ40AN1P01"), 4) << "non-safe Ethernet";
}

// ParseMeasurementCurrentConfigData.cpp: enabled 4, interface 5, host 8 (last number first), port 12, every
// n-th scan 14, start 16, end 20, features 24.
TEST(SafetyVariables, TheDataOutputIsReadFromItsPlaces) {
  const auto output = read_output(view(bytes(48, {{0, {'R', 1}},
                                                  {4, {1, 3}},
                                                  {8, {5, 0, 168, 192}},
                                                  {12, {0xac, 0x17, 2, 0}},
                                                  {16, {0, 0, 0x20, 0xf4}},
                                                  {20, {0, 0, 0x80, 0x38}},
                                                  {24, {0x1f, 0}}})));
  ASSERT_TRUE(output);
  EXPECT_TRUE(output->enabled);
  EXPECT_EQ(output->interface, 3);
  EXPECT_EQ(output->host, IpAddress::v4(192, 168, 0, 5));
  EXPECT_EQ(output->port, 6060);
  EXPECT_EQ(output->every, 2);
  EXPECT_EQ(output->start, -199229440) << "-47.5 deg";
  EXPECT_EQ(output->end, 947912704) << "226 deg";
  EXPECT_EQ(output->features, 0x1f);
}

// ChangeCommSettingsCommand.cpp: 28 bytes, channel 0, then as above.
TEST(SafetyVariables, AChangeOfTheOutputIsWrittenToTheSamePlaces) {
  DataOutput output;
  output.enabled = true;
  output.interface = 1;
  output.host = IpAddress::v4(10, 1, 2, 3);
  output.port = 6061;
  output.every = 4;
  output.start = -199229440;
  output.features = 0xffff;
  EXPECT_EQ(encode_output(output, 2), bytes(28, {{0, {2}},
                                                 {4, {1, 1}},
                                                 {8, {3, 2, 1, 10}},
                                                 {12, {0xad, 0x17, 4, 0}},
                                                 {16, {0, 0, 0x20, 0xf4}},
                                                 {24, {0x1f, 0}}}))
      << "reserved bits stay 0 (SICK 8022708 p. 41)";
}

// ParseStatusOverview.cpp: states 4 to 6, power-on count 12, error code 24.
TEST(SafetyVariables, TheStatusIsReadFromItsPlaces) {
  const Bytes status = bytes(58, {{0, {'R', 1}}, {4, {2, 3, 4}}, {12, {42, 1, 0, 0}}, {24, {7, 0, 1, 0}}});
  EXPECT_EQ(
      describe_status(view(status)),
      "device state 2, configuration state 3, application state 4, powered on 298 times, error code 65543");
}

// ParseRequiredUserAction.cpp: one bit each.
TEST(SafetyVariables, EachBitOfTheUserActionHasItsWords) {
  EXPECT_EQ(describe_action(view({0x01, 0})), "confirm the configuration");
  EXPECT_EQ(describe_action(view({0x14, 0})), "check the environment, check the device");
  EXPECT_EQ(describe_action(view({0xe0, 0})), "run the setup procedure, check the firmware, wait");
  EXPECT_EQ(describe_action(view({0, 0})), "none");
}

}  // namespace
}  // namespace lidard::sick
