// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/black_box.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <thread>

#include "test/drivers/capture/pcap_testing.h"

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
  void wait_until_written(BlackBox& box, Stamp now) {
    for (int i = 0; i < 10000 && said_.empty(); ++i) {
      std::this_thread::sleep_for(milliseconds(1));
      box.poll(now, Span(0), [] { return ""; });
    }
    ASSERT_FALSE(said_.empty());
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
  const std::string path = box.write(begin + milliseconds(29'950), Span(0), "[events]");
  EXPECT_EQ(fs::path(path).filename(), "lidard-20231114T221349.950Z.pcap");
  wait_until_written(box, begin + std::chrono::seconds(31));
  EXPECT_TRUE(said_[0].first);
  EXPECT_THAT(said_[0].second, HasSubstr("the last 10.0 s are in " + path));
  const test::Contents found = read_capture(path);
  ASSERT_EQ(found.payloads.size(), 101U);
  EXPECT_EQ(found.payloads.front(), "packet 199");
  EXPECT_EQ(found.payloads.back(), "packet 299");
  EXPECT_EQ(found.stamps.back(), begin + milliseconds(29'900));
  EXPECT_EQ(found.flows.front(), "192.168.1.201:2368 > 192.168.1.77:2369");
  std::ifstream events(fs::path(path).replace_extension(".events.json"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(events), {}), "[events]");
  EXPECT_EQ(files().size(), 2U) << "nothing half written is left";
}

TEST_F(BlackBoxTest, StampsAsTheHostsClockIsSetNow) {
  BlackBox box = this->box();
  add(box, begin, "a");
  const std::string path = box.write(begin, -std::chrono::hours(1), "");
  wait_until_written(box, begin);
  EXPECT_EQ(read_capture(path).stamps.at(0), begin - std::chrono::hours(1));
}

TEST_F(BlackBoxTest, HoldsConnectionsToo) {
  BlackBox box = this->box();
  add(box, begin, "half of a tele", Transport::tcp);
  add(box, begin + milliseconds(1), "gram", Transport::tcp);
  add(box, begin + milliseconds(9), "anew", Transport::tcp, true);
  const std::string path = box.write(begin, Span(0), "");
  wait_until_written(box, begin);
  std::string all;
  std::size_t starts = 0;
  for (const test::TcpChunk& chunk : read_capture(path).chunks) {
    all += chunk.bytes;
    starts += chunk.stream_start ? 1U : 0U;
    EXPECT_EQ(chunk.missing, 0U);
  }
  EXPECT_EQ(all, "half of a telegramanew");
  EXPECT_EQ(starts, 2U) << "the second connection begins anew";
}

TEST_F(BlackBoxTest, TakesNoMoreMemoryThanItMay) {
  config_.megabytes = 0.1;
  BlackBox box = this->box();
  const std::string bytes(1000, 'x');
  for (int i = 0; i < 1000; ++i) add(box, begin + milliseconds(i), bytes);
  const std::string path = box.write(begin, Span(0), "");
  wait_until_written(box, begin);
  const auto kept = read_capture(path).payloads.size();
  EXPECT_LT(kept, 100U);
  EXPECT_GT(kept, 80U) << "the newest";
  EXPECT_EQ(read_capture(path).stamps.back(), begin + milliseconds(999));
}

TEST_F(BlackBoxTest, IsWrittenAWhileAfterAnErrorAndOnceForAllThatFollowsSoon) {
  BlackBox box = this->box();
  add(box, begin, "a");
  box.write_on_error(begin, std::chrono::seconds(5));
  box.poll(begin + std::chrono::seconds(4), Span(0), [] { return ""; });
  EXPECT_TRUE(files().empty());
  box.write_on_error(begin + std::chrono::seconds(4), std::chrono::seconds(5));
  box.poll(begin + std::chrono::seconds(5), Span(0), [] { return "why"; });
  wait_until_written(box, begin + std::chrono::seconds(6));
  EXPECT_EQ(files().size(), 2U);
  add(box, begin + std::chrono::seconds(7), "b");
  box.write_on_error(begin + std::chrono::seconds(8), Span(0));
  box.poll(begin + std::chrono::seconds(9), Span(0), [] { return ""; });
  EXPECT_EQ(files().size(), 2U) << "an error within the ten seconds that were written";
  box.write_on_error(begin + std::chrono::seconds(16), Span(0));
  said_.clear();
  box.poll(begin + std::chrono::seconds(16), Span(0), [] { return ""; });
  wait_until_written(box, begin + std::chrono::seconds(17));
  EXPECT_EQ(files().size(), 4U);
}

TEST_F(BlackBoxTest, DoesNotFillTheDisk) {
  config_.files = 2;
  BlackBox box = this->box();
  for (int i = 0; i < 5; ++i) {
    said_.clear();
    const Stamp now = begin + std::chrono::seconds(100 * i);
    add(box, now, std::to_string(i));
    box.write(now, Span(0), "");
    wait_until_written(box, now);
  }
  ASSERT_EQ(files().size(), 4U);
  EXPECT_EQ(read_capture((folder_ / files()[3]).string()).payloads.at(0), "4");
}

TEST_F(BlackBoxTest, SaysWhyNothingCanBeWritten) {
  config_.path = "/proc/none";
  BlackBox box = this->box();
  const auto reason = [](BlackBox& one) -> std::string {
    try {
      return one.write(begin, Span(0), "");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  };
  EXPECT_THAT(reason(box), HasSubstr("no packet"));
  add(box, begin, "a");
  reason(box);
  wait_until_written(box, begin);
  EXPECT_FALSE(said_[0].first);
  EXPECT_THAT(said_[0].second, HasSubstr("/proc/none"));
  config_.seconds = 0;
  BlackBox off = this->box();
  add(off, begin, "a");
  EXPECT_THAT(reason(off), HasSubstr("blackbox: {seconds: 60}"));
}

}  // namespace
}  // namespace lidard
