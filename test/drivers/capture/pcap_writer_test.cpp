// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/capture/pcap_writer.h"

#include <gtest/gtest.h>
#include <pcap/pcap.h>
#include <unistd.h>

#include <filesystem>

#include "drivers/capture/pcap_source.h"

namespace {

using namespace lidard;

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

TEST(EthernetFrame, TcpChecksumsAddUpAndNumbersStandInTheirPlace) {
  const std::vector<std::uint8_t> payload = {1, 2, 250, 4, 5};
  for (const std::size_t size : {std::size_t{0}, std::size_t{4}, std::size_t{5}}) {
    const Endpoint to{IpAddress::v4(10, 0, 0, 9), 10940};
    const auto frame =
        ethernet_tcp_frame(from, to, {payload.data(), size}, 77, {0x01020304, 0x05060708, 0x18});
    ASSERT_EQ(frame.size(), 54 + size);
    EXPECT_EQ(folded_sum(&frame[14], 20), 0xffffU);
    EXPECT_EQ(frame[23], 6) << "TCP";
    const auto length = static_cast<std::uint32_t>(20 + size);
    EXPECT_EQ(folded_sum(&frame[34], 20 + size, folded_sum(&frame[26], 8) + 6 + length), 0xffffU);
    const ByteView tcp(&frame[34], 20 + size);
    EXPECT_EQ(tcp.be32(4), 0x01020304U);
    EXPECT_EQ(tcp.be32(8), 0x05060708U);
    EXPECT_EQ(tcp.u8(13), 0x18);
  }
}

TEST(PcapWriter, AConnectionComesBackInOrderFromItsHandshakeOn) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("tcp_writer_" + std::to_string(::getpid()) + ".pcap"))
          .string();
  const Endpoint client{IpAddress::v4(10, 0, 0, 2), 40000}, server{IpAddress::v4(10, 0, 0, 9), 10940};
  const std::string question = "VV\n", answer(5000, 'x');
  const Stamp begin{1'767'225'600'000'000'000};
  {
    PcapWriter writer(path);
    writer.open_tcp(begin, client, server);
    writer.write_tcp(begin + std::chrono::milliseconds(1), client, server, ByteView(question));
    writer.write_tcp(begin + std::chrono::milliseconds(2), server, client, ByteView(answer));
    EXPECT_EQ(writer.records(), 3U + 1 + 4);
    writer.close();
  }
  PcapSource source(path);
  std::string up, down;
  std::size_t starts = 0;
  for (Packet packet; source.next(packet);) {
    EXPECT_EQ(packet.transport, Transport::tcp);
    EXPECT_EQ(packet.missing, 0U);
    starts += packet.stream_start ? 1U : 0U;
    (packet.from == client ? up : down) += packet.payload.text();
  }
  std::filesystem::remove(path);
  EXPECT_EQ(up, question);
  EXPECT_EQ(down, answer);
  EXPECT_EQ(starts, 2U);
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
