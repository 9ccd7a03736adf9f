// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/pcap_writer.h"

#include <gtest/gtest.h>
#include <pcap/pcap.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace lidard;
using namespace lidard::sim;

const Endpoint from{IpAddress::v4(192, 168, 1, 201), 2368};

std::uint32_t folded_sum(const std::uint8_t* bytes, std::size_t size, std::uint32_t sum = 0) {
  for (std::size_t i = 0; i < size; ++i) sum += i % 2 == 0 ? bytes[i] * 256U : bytes[i];
  while (sum > 0xffff) sum = (sum & 0xffffU) + (sum >> 16U);
  return sum;
}

TEST(EthernetFrame, ChecksumsAddUpForEvenAndOddPayloads) {
  const std::vector<std::uint8_t> payload = {1, 2, 250, 4, 5};
  for (const std::size_t size : {std::size_t{4}, std::size_t{5}}) {
    const Endpoint to{IpAddress::v4(10, 0, 0, 9), 6060};
    const auto frame = ethernet_frame(from, to, {payload.data(), size}, 77);
    ASSERT_EQ(frame.size(), 42 + size);
    EXPECT_EQ(folded_sum(&frame[14], 20), 0xffffU);
    const auto length = static_cast<std::uint32_t>(8 + size);
    EXPECT_EQ(folded_sum(&frame[34], 8 + size, folded_sum(&frame[26], 8) + 17 + length), 0xffffU);
  }
}

TEST(EthernetFrame, DestinationDecidesTheHardwareAddress) {
  const std::uint8_t byte = 0;
  const auto first = [&](const IpAddress& to) {
    const auto frame = ethernet_frame(from, {to, 1}, {&byte, 1}, 0);
    return std::vector<std::uint8_t>(frame.begin(), frame.begin() + 6);
  };
  EXPECT_EQ(first(IpAddress::v4(255, 255, 255, 255)), std::vector<std::uint8_t>(6, 0xff));
  EXPECT_EQ(first(IpAddress::v4(239, 129, 2, 3)),
            (std::vector<std::uint8_t>{0x01, 0x00, 0x5e, 0x01, 0x02, 0x03}));
  EXPECT_EQ(first(IpAddress::v4(192, 168, 0, 9)), (std::vector<std::uint8_t>{0x02, 0x00, 192, 168, 0, 9}));
}

TEST(PcapWriter, LibpcapReadsBackTimesAndBytes) {
  const std::string path =
      std::filesystem::temp_directory_path() / ("lidard_writer_" + std::to_string(getpid()));
  const std::vector<std::uint8_t> payload = {7, 8, 9};
  PcapWriter writer(path);
  writer.write({1767225600'123456789}, from, {IpAddress::v4(10, 0, 0, 1), 99}, {payload.data(), 3});
  writer.write({1767225601'000000001}, from, {IpAddress::v4(10, 0, 0, 1), 99}, {payload.data(), 2});
  EXPECT_EQ(writer.records(), 2U);
  writer.close();
  char error[PCAP_ERRBUF_SIZE];
  pcap_t* pcap = pcap_open_offline_with_tstamp_precision(path.c_str(), PCAP_TSTAMP_PRECISION_NANO, error);
  ASSERT_NE(pcap, nullptr) << error;
  EXPECT_EQ(pcap_datalink(pcap), DLT_EN10MB);
  pcap_pkthdr* header = nullptr;
  const u_char* data = nullptr;
  ASSERT_EQ(pcap_next_ex(pcap, &header, &data), 1);
  EXPECT_EQ(header->ts.tv_sec, 1767225600);
  EXPECT_EQ(header->ts.tv_usec, 123456789);
  EXPECT_EQ(header->caplen, 45U);
  EXPECT_EQ(data[42], 7);
  EXPECT_EQ(data[19], 0) << "identification";
  ASSERT_EQ(pcap_next_ex(pcap, &header, &data), 1);
  EXPECT_EQ(header->ts.tv_usec, 1);
  EXPECT_EQ(data[19], 1);
  EXPECT_EQ(pcap_next_ex(pcap, &header, &data), PCAP_ERROR_BREAK);
  pcap_close(pcap);
  std::filesystem::remove(path);
}

TEST(PcapWriter, FolderThatIsNotThereAndFullDiskAreToldNotIgnored) {
  EXPECT_THROW(PcapWriter("/nowhere/x.pcap"), std::runtime_error);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(
      {
        PcapWriter full("/dev/full");
        const std::uint8_t byte = 0;
        full.write({0}, from, from, {&byte, 1});
        full.close();
      },
      std::runtime_error);
}

}  // namespace
