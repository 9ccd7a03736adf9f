// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/journal.h"

#include <gtest/gtest.h>

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};
Stamp at(double s) { return begin + span_from_seconds(s); }

struct Bench {
  void see(double s, Health health, const std::string& message, const std::string& name = "front") {
    DiagnosticItem item;
    item.name = name;
    item.health = health;
    item.message = message;
    journal.update({item}, at(s));
  }
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
    bench.journal.add({at(100.0 * static_cast<double>(i)), "front", Health::ok, std::to_string(i)});
  EXPECT_EQ(bench.journal.events().size(), Journal::most_events);
  EXPECT_EQ(bench.journal.forgotten(), 7U);
  EXPECT_EQ(bench.journal.events().front().text, "7");
}

TEST(Journal, TellsOfASourceThatFlapsThatItDoesAndNotesTheRest) {
  Bench bench;
  for (int i = 0; i < 20; ++i) bench.see(i, i % 2 == 0 ? Health::warn : Health::ok, "contact");
  EXPECT_EQ(bench.journal.events().size(), 20U);
  ASSERT_EQ(bench.told.size(), Journal::most_told + 1);
  EXPECT_NE(bench.told.back().text.find("to and fro"), std::string::npos);
  bench.see(20.5, Health::warn, "other", "rear");
  EXPECT_EQ(bench.told.back().source, "rear") << "others are heard";
  bench.see(100, Health::error, "gone");
  EXPECT_EQ(bench.told.back().text, "gone") << "after a minute";
}

}  // namespace
}  // namespace lidard
