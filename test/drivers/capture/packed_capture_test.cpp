// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Captures as people keep them: packed with gzip or zstd, or coming through a pipe. What comes out of a
// packed capture is what the plain one holds, and damage is told with its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <thread>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;

Bytes gzip(const Bytes& plain) {
  Bytes out(plain.size() + 1000);
  z_stream stream{};
  deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  stream.next_in = const_cast<Bytef*>(plain.data());
  stream.avail_in = static_cast<uInt>(plain.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

Bytes zstd(const Bytes& plain) {
  Bytes out(ZSTD_compressBound(plain.size()));
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);  // as the program zstd does
  const std::size_t size = ZSTD_compress2(context, out.data(), out.size(), plain.data(), plain.size());
  EXPECT_EQ(ZSTD_isError(size), 0U);
  ZSTD_freeCCtx(context);
  out.resize(size);
  return out;
}

struct Packing {
  const char* name;
  Bytes (*pack)(const Bytes&);
};
const Packing packings[] = {{"gzip", gzip}, {"zstd", zstd}};

Bytes content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A quarter of a megabyte of a VLP-16.
const Bytes& plain() {
  static const Bytes bytes = content(project_file("pcaps/vlp16_dual.pcap"));
  return bytes;
}
const Contents& whole() {
  static const Contents all = read_capture(plain());
  return all;
}

Bytes part(const Bytes& bytes, std::size_t begin, std::size_t end) {
  return {bytes.begin() + static_cast<std::ptrdiff_t>(begin),
          bytes.begin() + static_cast<std::ptrdiff_t>(end)};
}

void expect_same(const Contents& got, const Contents& expected, const std::string& what) {
  EXPECT_TRUE(got.payloads == expected.payloads) << what << ": " << got.payloads.size() << " payloads";
  EXPECT_TRUE(got.stamps == expected.stamps) << what;
  EXPECT_EQ(got.counters.frames, expected.counters.frames) << what;
  EXPECT_EQ(got.error, expected.error) << what;
  EXPECT_EQ(got.damaged, expected.damaged) << what;
}

/// True if what came out is the begin of what should have.
bool is_begin_of(const Contents& got, const Contents& expected) {
  return got.payloads.size() <= expected.payloads.size() &&
         std::equal(got.payloads.begin(), got.payloads.end(), expected.payloads.begin());
}

TEST(PackedCapture, HoldsWhatThePlainOneHolds) {
  ASSERT_GT(whole().payloads.size(), 200U);
  for (const auto& [name, pack] : packings) {
    const Bytes packed = pack(plain());
    EXPECT_LT(packed.size(), plain().size()) << name;
    expect_same(read_capture(packed), whole(), name);
  }
}

TEST(PackedCapture, InSeveralPiecesIsReadAsOne) {
  const std::size_t middle = plain().size() / 2 + 1;
  for (const auto& [name, pack] : packings) {
    const Bytes both = pack(part(plain(), 0, middle)) + pack(part(plain(), middle, plain().size()));
    expect_same(read_capture(both), whole(), name);
  }
}

TEST(PackedCapture, OfThePcapngKindIsReadToo) {
  LIDARD_NEED_CAPTURE(capture, "odd/sick_lls_udp5009_office_noise.pcapng");
  const Bytes bytes = content(capture);
  const Contents expected = read_capture(bytes);
  ASSERT_GT(expected.counters.frames, 100U);
  for (const auto& [name, pack] : packings) expect_same(read_capture(pack(bytes)), expected, name);
}

TEST(PackedCapture, IsReadAgainFromItsBegin) {
  for (const auto& [name, pack] : packings) {
    const MemoryFile file(pack(plain()));
    PcapSource source(file.path());
    Contents first, second;
    read_all(source, first);
    EXPECT_EQ(source.position(), source.size()) << name << ": progress";
    source.rewind();
    read_all(source, second);
    EXPECT_TRUE(second.payloads == whole().payloads) << name;
    EXPECT_TRUE(first.payloads == second.payloads) << name;
  }
}

TEST(PackedCapture, ThatWasCutOffGivesWhatThereIsAndSaysWhere) {
  for (const auto& [name, pack] : packings) {
    const Bytes packed = pack(plain());
    for (const std::size_t length :
         {std::size_t{20}, packed.size() / 3, packed.size() / 2, packed.size() - 1}) {
      const Contents got = read_capture(part(packed, 0, length));
      const std::string words =
          std::string("the ") + name + " file was cut off, at byte " + std::to_string(length);
      EXPECT_THAT(got.error, HasSubstr(words)) << length;
      EXPECT_TRUE(!got.opened || got.damaged) << name << length;
      EXPECT_TRUE(is_begin_of(got, whole())) << name << length;
    }
  }
}

TEST(PackedCapture, OfACaptureThatEndsInARecordIsUsedUpToThere) {
  for (const auto& [name, pack] : packings) {
    const Contents got = read_capture(pack(part(plain(), 0, plain().size() - 100)));
    EXPECT_EQ(got.payloads.size(), whole().payloads.size() - 1) << name;
    EXPECT_FALSE(got.damaged) << name << got.error;
    EXPECT_THAT(got.error, HasSubstr("what came before it was used"));
  }
}

TEST(PackedCapture, WithAWrongByteAnywhereNeverPassesForWhole) {
  for (const auto& [name, pack] : packings) {
    const Bytes packed = pack(plain());
    std::size_t told = 0;
    const std::size_t step = packed.size() / 150;
    for (std::size_t at = 0; at < packed.size(); at += step) {
      Bytes wrong = packed;
      wrong[at] ^= 0x55U;
      const Contents got = read_capture(wrong);
      // A few bytes of a gzip header mean nothing to us: its time, its system.
      EXPECT_TRUE(!got.error.empty() || got.payloads == whole().payloads) << name << " at byte " << at;
      told += got.error.find(" at byte ") != std::string::npos ? 1U : 0U;
    }
    EXPECT_GT(told, 140U) << name;
  }
}

TEST(PackedCapture, OfSomethingElseOrOfNothingIsRefusedWithOneSentence) {
  for (const auto& [name, pack] : packings) {
    EXPECT_THAT(read_capture(pack(Bytes(100, 'x'))).error, HasSubstr("unknown file format; give a pcap"))
        << name;
    EXPECT_THAT(read_capture(pack(Bytes{})).error, HasSubstr("too short to be a capture")) << name;
  }
}

TEST(PackedCapture, OfAnotherProgramIsRefusedWithTheWayToUnpackIt) {
  const std::pair<Bytes, const char*> others[] = {
      {{0xfd, '7', 'z', 'X', 'Z', 0}, "packed with xz.*use `xz -d` first"},
      {{'B', 'Z', 'h', '9'}, "packed with bzip2.*use `bunzip2` first"},
      {{0x04, 0x22, 0x4d, 0x18}, "packed with lz4.*use `lz4 -d` first"},
      {{'P', 'K', 3, 4}, "packed with zip.*use `unzip` first"}};
  for (const auto& [first_bytes, expected] : others)
    EXPECT_THAT(read_capture(first_bytes + Bytes(100)).error, ::testing::ContainsRegex(expected));
}

TEST(CaptureFromAPipe, IsReadOnceAndCanBeOpenedAgain) {
  const std::string path = ::testing::TempDir() + "lidard-pipe-" + std::to_string(getpid());
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::thread writer([&] {
    const Bytes packed = gzip(plain());
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(packed.data()), static_cast<std::streamsize>(packed.size()));
  });
  expect_same(read_capture(path), whole(), "the first time");
  writer.join();
  expect_same(read_capture(path), whole(), "the second time, the writer being gone");
  std::remove(path.c_str());
}

TEST(CaptureFromAPipe, ThatBringsSomethingElseWithoutEndIsGivenUp) {
  const std::string path = ::testing::TempDir() + "lidard-noise-" + std::to_string(getpid());
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  std::signal(SIGPIPE, SIG_IGN);
  std::thread writer([&] {
    std::ofstream out(path, std::ios::binary);
    const std::string noise(64 * 1024, 'y');
    while (out.write(noise.data(), static_cast<std::streamsize>(noise.size()))) {
    }
  });
  EXPECT_THAT(read_capture(path).error, HasSubstr("unknown file format"));
  writer.join();
  std::remove(path.c_str());
}

}  // namespace
}  // namespace lidard::test
