// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/black_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

#include "test/drivers/capture/pcap_testing.h"
#include "test/support/says.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using test::read_capture;
using ::testing::HasSubstr;

constexpr Stamp begin{1'700'000'000'000'000'000};
const Endpoint lidar{IpAddress::v4(192, 168, 1, 201), 2368}, ours{IpAddress::v4(192, 168, 1, 77), 2369};

class BlackBoxTest : public ::testing::Test {
 protected:
  BlackBoxTest() : folder_(fs::temp_directory_path() / ("lidard-box-" + std::to_string(getpid()))) {
    config_.seconds = 10;
    config_.path = folder_.string();
  }
  void TearDown() override { fs::remove_all(folder_); }
  BlackBox box() {
    return BlackBox(config_,
                    [this](bool good, const std::string& sentence) { said_.emplace_back(good, sentence); });
  }
  static void add(BlackBox& box, Stamp at, const std::string& bytes, Transport transport = Transport::udp,
                  bool stream_start = false) {
    Packet packet{ByteView(bytes), at, lidar, ours, transport};
    packet.stream_start = stream_start;
    box.add(packet);
  }
  /// What is answered to whoever asks for a capture.
  static std::string dump(BlackBox& box, Stamp now, Span step = Span(0), const std::string& events = "") {
    std::string answer;
    box.dump([&](const std::string& said) { answer = said; });
    for (int i = 0; i < 10000 && answer.empty(); ++i) {
      box.poll(now, HostStamp{now.ns} + step, [&] { return events; });
      std::this_thread::sleep_for(milliseconds(1));
    }
    EXPECT_NE(answer, "");
    return answer;
  }
  /// Waits for a capture that poll() begins at `now`; returns false where it begins none.
  bool writes(BlackBox& box, Stamp now) {
    const std::size_t before = said_.size();
    bool begun = false;
    box.poll(now, HostStamp{now.ns}, [&] { return begun = true, "why"; });
    for (int i = 0; i < 10000 && begun && said_.size() == before; ++i) {
      std::this_thread::sleep_for(milliseconds(1));
      box.poll(now, HostStamp{now.ns}, [] { return ""; });
    }
    EXPECT_EQ(said_.size(), before + (begun ? 1 : 0));
    return begun;
  }
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    if (fs::exists(folder_))
      for (const auto& entry : fs::directory_iterator(folder_)) found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }

  fs::path folder_;
  BlackBoxConfig config_;
  std::vector<std::pair<bool, std::string>> said_;
};

TEST_F(BlackBoxTest, WritesWhatCameInTheLastSecondsWithTheEventsBeside) {
  BlackBox box = this->box();
  for (int i = 0; i < 300; ++i) add(box, begin + milliseconds(100 * i), "packet " + std::to_string(i));
  const std::string path = dump(box, begin + milliseconds(29'950), Span(0), "[events]");
  EXPECT_THAT(box.item()->message, test::Says(says::keeps_packets));
  EXPECT_EQ(fs::path(path).filename(), "lidard-20231114T221349.950Z.pcap");
  EXPECT_TRUE(said_.at(0).first);
  EXPECT_THAT(said_[0].second,
              testing::AllOf(HasSubstr("the last 9.9 s are in " + path), test::Says(says::box_written)));
  const test::Contents found = read_capture(path);
  ASSERT_EQ(found.payloads.size(), 100U);
  EXPECT_EQ(found.payloads.front(), "packet 200");
  EXPECT_EQ(found.payloads.back(), "packet 299");
  EXPECT_EQ(found.stamps.back(), begin + milliseconds(29'900));
  EXPECT_EQ(found.flows.front(), "192.168.1.201:2368 > 192.168.1.77:2369");
  EXPECT_EQ(test::content(fs::path(path).replace_extension(".events.json")), "[events]");
  EXPECT_EQ(files().size(), 2U) << "nothing half written is left";
}

TEST_F(BlackBoxTest, StampsAsTheHostsClockIsSetNow) {
  BlackBox box = this->box();
  add(box, begin, "a");
  const std::string path = dump(box, begin, -std::chrono::hours(1));
  EXPECT_EQ(read_capture(path).stamps.at(0), begin - std::chrono::hours(1));
}

TEST_F(BlackBoxTest, HoldsConnectionsWithTheStampsOfTheirChunks) {
  BlackBox box = this->box();
  const std::string telegram(9000, 't');
  add(box, begin, "half of a tele", Transport::tcp);
  add(box, begin + milliseconds(1), "gram", Transport::tcp);
  add(box, begin + milliseconds(9), telegram, Transport::tcp, true);
  const std::string path = dump(box, begin + milliseconds(9));
  std::string all;
  std::size_t starts = 0;
  for (const test::TcpChunk& chunk : read_capture(path).chunks) {
    all += chunk.bytes;
    starts += chunk.stream_start ? 1U : 0U;
    EXPECT_EQ(chunk.missing, 0U);
    if (all.size() > 18) {
      EXPECT_EQ(chunk.arrival, begin + milliseconds(9)) << "of each segment";
    }
  }
  EXPECT_EQ(all, "half of a telegram" + telegram);
  EXPECT_EQ(starts, 2U) << "the second connection begins anew";
}

TEST_F(BlackBoxTest, TakesNoMoreMemoryThanItMay) {
  config_.megabytes = 1;
  BlackBox box = this->box();
  const std::string bytes(1000, 'x');
  for (int i = 0; i < 5000; ++i) add(box, begin + milliseconds(i), bytes);
  const test::Contents found = read_capture(dump(box, begin + milliseconds(4999)));
  EXPECT_LT(found.payloads.size(), 1000U);
  EXPECT_GT(found.payloads.size(), 700U) << "the newest";
  EXPECT_EQ(found.stamps.back(), begin + milliseconds(4999));
}

TEST_F(BlackBoxTest, IsWrittenAWhileAfterAnIncidentWithTheSecondsBeforeIt) {
  BlackBox box = this->box();
  for (int i = 0; i <= 400; ++i) add(box, begin + milliseconds(100 * i), std::to_string(i));
  box.incident(begin + std::chrono::seconds(35), "front: silent");
  EXPECT_FALSE(writes(box, begin + milliseconds(39'900)));
  EXPECT_TRUE(writes(box, begin + std::chrono::seconds(40)));
  ASSERT_EQ(files().size(), 2U);
  const test::Contents found = read_capture((folder_ / files()[1]).string());
  EXPECT_EQ(found.stamps.front(), begin + std::chrono::seconds(25));
  EXPECT_EQ(found.stamps.back(), begin + std::chrono::seconds(40));
}

TEST_F(BlackBoxTest, ADumpNeitherEmptiesItNorHoldsUpAnIncident) {
  BlackBox box = this->box();
  for (int i = 0; i <= 200; ++i) add(box, begin + milliseconds(100 * i), std::to_string(i));
  const auto first = read_capture(dump(box, begin + std::chrono::seconds(20)));
  const auto second = read_capture(dump(box, begin + milliseconds(20'001)));
  EXPECT_EQ(first.stamps.front(), begin + std::chrono::seconds(10));
  EXPECT_EQ(second.stamps.front(), begin + milliseconds(10'100));
  box.incident(begin + std::chrono::seconds(21), "front: silent");
  EXPECT_TRUE(writes(box, begin + std::chrono::seconds(26)));
}

TEST_F(BlackBoxTest, AnIncidentWithinThePauseIsWrittenWhenThePauseEndsAndNothingIsMissingBetween) {
  config_.seconds = 60;
  BlackBox box = this->box();
  auto add_until = [&, from = 0](int to) mutable {
    for (; from <= to; ++from) add(box, begin + milliseconds(600 * from), std::to_string(from));
  };
  add_until(200);
  box.incident(begin + std::chrono::seconds(115), "front: silent");
  ASSERT_TRUE(writes(box, begin + std::chrono::seconds(120)));
  for (const int at : {121, 144, 179}) {
    box.incident(begin + std::chrono::seconds(at), "front: silent");
    EXPECT_FALSE(writes(box, begin + std::chrono::seconds(at)));
  }
  add_until(300);
  ASSERT_TRUE(writes(box, begin + std::chrono::seconds(180)));
  EXPECT_THAT(said_.back().second, testing::Not(HasSubstr("in no capture")));
  box.incident(begin + std::chrono::seconds(239), "front: silent");
  add_until(406);
  EXPECT_FALSE(writes(box, begin + std::chrono::seconds(243)));
  ASSERT_TRUE(writes(box, begin + std::chrono::seconds(244)));
  std::set<std::string> written;
  for (const fs::path& file : files())
    if (file.extension() == ".pcap")
      for (const std::string& payload : read_capture((folder_ / file).string()).payloads)
        written.insert(payload);
  // From a minute before the first incident on.
  for (int i = 92; i <= 406; ++i) EXPECT_EQ(written.count(std::to_string(i)), 1U) << i;
}

TEST_F(BlackBoxTest, ErrorsThatComeAgainAndAgainStartOneCaptureAMinuteAndSoManyADay) {
  config_.per_day = 70;
  BlackBox box = this->box();
  int captures = 0, first_hour = 0;
  // A cable that drops out every 3 s, and another sensor every 7 s, for 30 hours.
  for (int at = 0; at < 30 * 3600; ++at) {
    const Stamp now = begin + std::chrono::seconds(at);
    if (at % 3 == 0) add(box, now, "x");
    if (at % 3 == 0) box.incident(now, "front: silent");
    if (at % 7 == 0) box.incident(now, "rear: silent");
    captures += writes(box, now) ? 1 : 0;
    if (at == 3600) first_hour = captures;
    if (at == 20 * 3600) {
      EXPECT_EQ(captures, 70);
      const DiagnosticItem item = *box.item();
      EXPECT_EQ(item.health, Health::warn);
      EXPECT_THAT(item.message, HasSubstr("70 captures within a day"));
      EXPECT_THAT(item.message, test::Says(says::box_used_up));
      EXPECT_EQ(item.values.at(0), std::make_pair(std::string("Captures within a day"), std::string("70")));
      EXPECT_EQ(item.values.at(1).first, "Errors in no capture");
      EXPECT_GT(std::stoi(item.values[1].second), 10'000);
      EXPECT_NE(dump(box, now), "") << "by hand there is one";
    }
  }
  EXPECT_EQ(first_hour, 60);
  EXPECT_EQ(captures, 140) << "and so many on the next day";
  // Captures of 10 s leave out what came before them within the minute.
  EXPECT_THAT(said_.at(1).second, test::Says(says::box_written_with_gaps));
  EXPECT_EQ(std::count_if(said_.begin(), said_.end(), [](const auto& said) { return !said.first; }), 2)
      << "once a day it is said that no more are written";
}

TEST_F(BlackBoxTest, WhatFailsWithoutAPacketIsNoCaptureAndNoTrouble) {
  BlackBox box = this->box();
  box.incident(begin, "port 2368: in use");
  EXPECT_FALSE(writes(box, begin + std::chrono::seconds(6)));
  EXPECT_TRUE(said_.empty());
  EXPECT_EQ(box.item()->health, Health::ok);
}

TEST_F(BlackBoxTest, DoesNotFillTheDisk) {
  config_.files = 2;
  BlackBox box = this->box();
  for (int i = 0; i < 5; ++i) {
    const Stamp now = begin + std::chrono::seconds(100 * i);
    add(box, now, std::to_string(i));
    dump(box, now);
  }
  ASSERT_EQ(files().size(), 4U);
  EXPECT_EQ(read_capture((folder_ / files()[3]).string()).payloads.at(0), "4");
}

TEST_F(BlackBoxTest, TheFirstCaptureOfEachKindStays) {
  config_.files = 4;
  BlackBox box = this->box();
  const auto fail = [&](int at, const std::string& kind) {
    add(box, begin + std::chrono::seconds(at), kind + std::to_string(at));
    box.incident(begin + std::chrono::seconds(at), kind);
    EXPECT_TRUE(writes(box, begin + std::chrono::seconds(at + 5)));
  };
  const auto kept = [&] {
    std::vector<std::string> newest;
    for (const fs::path& file : files())
      if (file.extension() == ".pcap")
        newest.push_back(read_capture((folder_ / file).string()).payloads.back());
    return newest;
  };
  fail(0, "front");
  for (int i = 1; i < 9; ++i) fail(100 * i, i == 3 ? "rear" : "front");
  EXPECT_EQ(kept(), (std::vector<std::string>{"front0", "rear300", "front700", "front800"}));
  // There is always a place for the newest one.
  for (int i = 9; i < 14; ++i) fail(100 * i, "kind " + std::to_string(i) + " at ");
  EXPECT_EQ(kept(), (std::vector<std::string>{"front0", "rear300", "kind 9 at 900", "kind 13 at 1300"}));
}

TEST_F(BlackBoxTest, InAnotherFolderAndWithFewerFilesTheFirstCapturesAreNewOnes) {
  config_.path = "/proc/none";
  config_.files = 4;
  BlackBox box = this->box();
  const auto fail = [&](int at, const std::string& kind) {
    add(box, begin + std::chrono::seconds(at), kind);
    box.incident(begin + std::chrono::seconds(at), kind);
    EXPECT_TRUE(writes(box, begin + std::chrono::seconds(at + 5)));
  };
  fail(0, "front");
  ASSERT_EQ(box.item()->health, Health::warn);
  config_.path = folder_.string();
  box.configure(config_);
  EXPECT_EQ(box.item()->health, Health::ok) << "that folder could not be written";
  fail(100, "front");
  fail(200, "rear");
  config_.path = (folder_ / "more").string();
  box.configure(config_);
  fail(20'000, "front");
  fail(20'100, "rear");
  config_.files = 2;
  box.configure(config_);
  for (const int at : {20'200, 20'300}) fail(at, "again");
  std::vector<std::string> kept;
  for (const auto& entry : fs::directory_iterator(config_.path))
    if (entry.path().extension() == ".pcap") kept.push_back(read_capture(entry.path()).payloads.back());
  EXPECT_THAT(kept, testing::UnorderedElementsAre("front", "again"));
}

TEST_F(BlackBoxTest, SaysWhyNothingCanBeWritten) {
  config_.path = "/proc/none";
  BlackBox box = this->box();
  EXPECT_EQ(dump(box, begin), "error: no packet has come yet");
  add(box, begin, "a");
  EXPECT_THAT(dump(box, begin), HasSubstr("error: the black box cannot be written: /proc/none"));
  EXPECT_FALSE(said_.at(0).first);
  EXPECT_EQ(box.item()->health, Health::warn);
  config_.seconds = 0;
  BlackBox off = this->box();
  add(off, begin, "a");
  EXPECT_THAT(dump(off, begin), HasSubstr("blackbox: {seconds: 60}"));
}

/// No file grows beyond 100 kB, as on a disk that is full.
struct FullDisk {
  FullDisk() {
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit full{100'000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
  }
  rlimit before{};
  void (*handler)(int) = std::signal(SIGXFSZ, SIG_IGN);
};

TEST_F(BlackBoxTest, OnAFullDiskNothingOlderIsRemovedAndNothingHalfWrittenIsLeft) {
  config_.files = 1;
  BlackBox box = this->box();
  add(box, begin, "old");
  const std::string old = dump(box, begin);
  const fs::path left = folder_ / "lidard-20200101T000000.000Z.pcap.part";
  const fs::path new_one = folder_ / "lidard-20200101T000001.000Z.pcap.part";
  std::ofstream(left) << "of a daemon that was killed";
  std::ofstream(new_one) << "of a daemon that writes now";
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::hours(1));
  for (int i = 0; i < 1000; ++i) add(box, begin + milliseconds(i), std::string(1000, 'x'));
  {
    const FullDisk full;
    EXPECT_THAT(dump(box, begin + std::chrono::seconds(2)),
                HasSubstr("not everything could be written; make room on the disk"));
  }
  EXPECT_THAT(box.item()->message, HasSubstr("make room on the disk"));
  EXPECT_TRUE(fs::exists(old));
  EXPECT_EQ(files().size(), 3U) << "the old capture, its events, and what another daemon writes";
  EXPECT_FALSE(fs::exists(left));
  const std::string path = dump(box, begin + std::chrono::seconds(3));
  EXPECT_EQ(read_capture(path).payloads.size(), 1001U) << "what could not be written is still kept";
  EXPECT_FALSE(fs::exists(old));
  EXPECT_EQ(box.item()->health, Health::ok);
}

}  // namespace
}  // namespace lidard
