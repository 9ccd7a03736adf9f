// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a scanner reports of itself: the status word of its scans and LCMstate (SICK 8013796 p. 81 and 86).
#include <gmock/gmock.h>

#include "drivers/capture/pcap_source.h"
#include "test/drivers/sick/cola/cola_bench.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

void send_status(ColaBench& bench, std::uint8_t first, std::uint8_t second) {
  bench.sample.status[0] = first;
  bench.sample.status[1] = second;
  bench.send_next();
}

TEST(ColaHealth, EveryStatusHasItsSentenceAndGoesWhenItsBitsGo) {
  struct Case {
    std::uint8_t second;
    const char* words;
    bool is_fault;
  };
  ColaBench bench;
  for (int incident = 0; incident < 2; ++incident) {
    for (const Case& each : {Case{1, "device error", true}, Case{2, "clean its window", false},
                             Case{4, "blind", true}, Case{5, "blind", true}}) {
      send_status(bench, 0, each.second);
      ASSERT_EQ(bench.driver->info().warnings.size(), 1U);
      EXPECT_TRUE(bench.has_warning(each.words)) << int{each.second};
      EXPECT_EQ(bench.driver->info().has_fault, each.is_fault) << int{each.second};
      send_status(bench, 0, 0);
      EXPECT_TRUE(bench.driver->info().warnings.empty());
      EXPECT_FALSE(bench.driver->info().has_fault);
    }
  }
}

TEST(ColaHealth, TheFirstScansBeforeTheLaserIsOnAreNoTrouble) {
  ColaBench bench;
  for (int i = 0; i < 40; ++i) send_status(bench, 1, 0);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  send_status(bench, 1, 2);
  EXPECT_TRUE(bench.has_warning("clean its window")) << "not hidden by the laser";
  for (int i = 0; i < 500; ++i) send_status(bench, 1, 0);
  EXPECT_TRUE(bench.has_warning("laser off"));
  send_status(bench, 0, 0);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  send_status(bench, 1, 0);
  EXPECT_TRUE(bench.driver->info().warnings.empty()) << "another start";
}

TEST(ColaHealth, AStatusThatNoManualDescribesIsShownAsItIs) {
  ColaBench bench;
  send_status(bench, 2, 0x10);
  EXPECT_TRUE(bench.has_warning("unknown status 2 16"));
}

TEST(ColaHealth, AnswersAboutContaminationCount) {
  for (const sim::Cola dialect : {sim::Cola::binary, sim::Cola::text}) {
    ColaBench bench("sick_lms5xx");
    bench.dialect = dialect;
    const auto answer = [&](std::uint32_t level) {
      bench.send(sim::ColaWords(dialect, "sRA LCMstate").number(level, 1).bytes());
      bench.send_next();
    };
    answer(1);
    EXPECT_TRUE(bench.has_warning("clean its window"));
    EXPECT_FALSE(bench.driver->info().has_fault);
    for (const std::uint32_t level : {2U, 3U}) {
      answer(level);
      EXPECT_TRUE(bench.has_warning("blind"));
      EXPECT_TRUE(bench.driver->info().has_fault);
    }
    answer(0);
    EXPECT_TRUE(bench.driver->info().warnings.empty());
  }
}

TEST(ColaHealth, RecordedStartsGiveNoWarning) {
  for (const auto& [file, model] : {std::pair("sick/lms111_colab_20210302.pcap", "sick_lms1xx"),
                                    std::pair("sick/lms511_colab_20210301.pcap", "sick_lms5xx")}) {
    LIDARD_NEED_CAPTURE(path, file);
    ColaBench bench(model);
    PcapSource source(path);
    std::size_t troubled = 0;
    for (Packet packet; source.next(packet);) {
      if (packet.from.port != 2112) continue;
      bench.driver->receive(packet, bench);
      troubled += bench.driver->info().warnings.size();
    }
    EXPECT_GT(bench.scans.size(), 100U);
    EXPECT_EQ(troubled, 0U) << file;
  }
}

}  // namespace
}  // namespace lidard::test
