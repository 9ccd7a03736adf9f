// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/journal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "test/support/says.h"

namespace lidard {
namespace {

constexpr HostStamp journal_start{1'700'000'000'000'000'000};
HostStamp at(double s) { return journal_start + span_from_seconds(s); }

struct Bench {
  void see(double s, Health health, const std::string& message, const std::string& name = "front") {
    DiagnosticItem item;
    item.name = name;
    item.health = health;
    item.message = message;
    items[name] = item;  // the others are as they were
    std::vector<DiagnosticItem> all;
    for (const auto& [key, one] : items) all.push_back(one);
    journal.update(all, at(s));
  }
  std::map<std::string, DiagnosticItem> items;
  std::vector<Event> told;
  Journal journal{[this](const Event& event) { told.push_back(event); }};
};

TEST(Journal, NotesEachChangeOnceAtItsTime) {
  Bench bench;
  bench.see(0, Health::ok, "fine");
  EXPECT_TRUE(bench.journal.events().empty()) << "that all is well from the beginning is no news";
  bench.see(1, Health::warn, "silent for 1.1 s");
  bench.see(2, Health::warn, "silent for 2.1 s");
  bench.see(3, Health::error, "silent for 3.1 s");
  bench.see(4, Health::error, "window covered");
  bench.see(5, Health::ok, "fine");
  bench.see(6, Health::ok, "very fine");
  const auto& events = bench.journal.events();
  ASSERT_EQ(events.size(), 4U);
  EXPECT_EQ(events[0].text, "silent for 1.1 s");
  EXPECT_EQ(events[0].source, "front");
  EXPECT_EQ(events[0].health, Health::warn);
  EXPECT_EQ(events[1].at, at(3));
  EXPECT_EQ(events[1].health, Health::error);
  EXPECT_EQ(events[2].text, "window covered");
  EXPECT_EQ(events[3].health, Health::ok);
  EXPECT_EQ(bench.told.size(), 4U);
}

TEST(Journal, ReturnsWhatWentToErrorUnlessItHasNotComeSinceTheStart) {
  Journal journal([](const Event&) {});
  const auto errors = [&](double s, Health health, const std::string& message, bool awaited = false) {
    DiagnosticItem item{"sensor front"};
    item.set(health, message);
    item.awaited = awaited;
    return journal.update({item}, at(s));
  };
  using Errors = std::vector<std::string>;
  EXPECT_EQ(errors(1, Health::error, "nothing received for 3 s", true), Errors{});
  EXPECT_EQ(errors(2, Health::error, "refused", true), Errors{});
  EXPECT_EQ(journal.events().size(), 2U) << "events they are all the same";
  EXPECT_EQ(errors(3, Health::error, "it is a VLP-16"), Errors{"sensor front: it is a VLP-"});
  EXPECT_EQ(errors(4, Health::error, "it is a VLP-16"), Errors{});
  EXPECT_EQ(errors(5, Health::warn, "silent for 1 s"), Errors{});
  EXPECT_EQ(errors(6, Health::error, "silent for 3 s"), Errors{"sensor front: silent for  s"});
}

TEST(Journal, WhatComesBackAfterItWasGoneIsNews) {
  Journal journal([](const Event&) {});
  DiagnosticItem rivals{"address 10.0.0.9"};
  rivals.set(Health::error, "two devices have the address");
  EXPECT_EQ(journal.update({rivals}, at(0)).size(), 1U);
  EXPECT_TRUE(journal.update({rivals}, at(1)).empty());
  EXPECT_TRUE(journal.update({}, at(700)).empty());
  EXPECT_EQ(journal.update({rivals}, at(1400)).size(), 1U);
  EXPECT_EQ(journal.events().size(), 2U);
}

TEST(Journal, KeepsSourcesApart) {
  Bench bench;
  bench.see(1, Health::warn, "silent", "front");
  bench.see(1, Health::warn, "silent", "rear");
  bench.see(2, Health::ok, "", "rear");
  ASSERT_EQ(bench.journal.events().size(), 3U);
  EXPECT_EQ(bench.journal.events()[2].source, "rear");
}

TEST(Journal, ForgetsTheOldestAndSaysHowMany) {
  Bench bench;
  for (std::size_t i = 0; i < Journal::most_events + 7; ++i)
    bench.journal.add({at(1000.0 * static_cast<double>(i)), "front", Health::ok, std::to_string(i)});
  EXPECT_EQ(bench.journal.events().size(), Journal::most_events);
  EXPECT_EQ(bench.journal.forgotten(), 7U);
  EXPECT_EQ(bench.journal.events().front().text, "7");
}

TEST(Journal, CountsWhatHappensAgainInOneEvent) {
  Bench bench;
  for (int i = 0; i < 7; ++i) {
    bench.see(60 * i, Health::error, "no scan for " + std::to_string(i) + " s");
    bench.see(60 * i + 1, Health::ok, "");
  }
  bench.see(400, Health::error, "window covered");
  bench.see(401, Health::error, "no scan for 1 s", "rear");
  const auto& events = bench.journal.events();
  ASSERT_EQ(events.size(), 4U) << "in the order in which they happened last";
  EXPECT_EQ(events[0].text, "no scan for 6 s");
  EXPECT_EQ(events[0].count, 7U);
  EXPECT_EQ(events[0].first, at(0));
  EXPECT_EQ(events[0].at, at(360));
  EXPECT_EQ(events[1].count, 7U);
  EXPECT_EQ(events[2].count, 1U);
  EXPECT_EQ(events[3].source, "rear");
  bench.see(1001, Health::error, "no scan for 1 s");
  ASSERT_EQ(events.size(), 5U) << "ten minutes later it is another incident";
  EXPECT_EQ(events[4].count, 1U);
  EXPECT_EQ(events[4].first, at(1001));
}

TEST(Journal, OfABadHourHasAFewRowsWithEveryIncidentAmongThem) {
  Bench bench;
  const char* const causes[] = {"nothing received: lidar0 has no link", "nothing received: check the cable"};
  for (int s = 0; s < 3600; ++s) {
    // A device that is away, whose sentence alternates; a cable that flaps; a merged scan of both on a busy
    // machine.
    bench.see(s, Health::error, causes[s / 2 % 2], "sensor away");
    bench.see(s, Health::error, causes[s / 2 % 2], "link away");
    const bool up = s % 5 < 2;
    bench.see(s, up ? Health::ok : s % 5 == 2 ? Health::warn : Health::error, "silent", "sensor flapping");
    bench.see(s, s % 3 == 0 ? Health::warn : Health::ok, "publishing without flapping", "merged around");
    // What somebody has to know of.
    if (s == 700) bench.see(s, Health::error, "is in use by another program", "port 2368");
    if (s == 1900) bench.see(s, Health::error, "window covered", "sensor rear");
    if (s == 2000) bench.see(s, Health::ok, "", "sensor rear");
    if (s == 3000) bench.see(s, Health::error, "window covered", "sensor rear");
  }
  const auto& events = bench.journal.events();
  EXPECT_LE(events.size(), 60U);
  EXPECT_EQ(bench.journal.forgotten(), 0U);
  const auto found = [&](const std::string& source, Health health, HostStamp when) {
    return std::any_of(events.begin(), events.end(), [&](const Event& event) {
      return event.source == source && event.health == health && event.first == when && event.at == when;
    });
  };
  EXPECT_TRUE(found("port 2368", Health::error, at(700)));
  EXPECT_TRUE(found("sensor rear", Health::error, at(1900)));
  EXPECT_TRUE(found("sensor rear", Health::ok, at(2000)));
  EXPECT_TRUE(found("sensor rear", Health::error, at(3000)));
  EXPECT_LE(bench.told.size(), 300U) << "nor does the log grow by more than 5 lines a minute";
}

TEST(Journal, TellsOfASourceThatFlapsThatItDoesAndCountsTheRest) {
  Bench bench;
  for (int i = 0; i < 20; ++i) bench.see(i, i % 2 == 0 ? Health::warn : Health::ok, "contact");
  ASSERT_EQ(bench.journal.events().size(), 2U);
  EXPECT_EQ(bench.journal.events()[0].count, 10U);
  bench.see(20, Health::warn, "contact");
  ASSERT_EQ(bench.told.size(), 2 * Journal::most_logged) << "all of each sentence";
  EXPECT_THAT(bench.told.back().text, test::Says(says::recurs));
  bench.see(20.5, Health::warn, "other", "rear");
  EXPECT_EQ(bench.told.back().source, "rear") << "others are heard";
}

}  // namespace
}  // namespace lidard
