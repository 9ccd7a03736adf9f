// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "drivers/registry/registry.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> with(Trait trait) {
  std::vector<std::string> names;
  for (const Model& model : models()) {
    if (model.has(trait)) names.emplace_back(model.name);
  }
  return names;
}

TEST(Models, HaveWhatTheirTraitsNeed) {
  for (const Model& model : models()) {
    SCOPED_TRACE(model.name);
    if (model.has(Trait::revolutions)) {
      EXPECT_EQ(model.kind, FrameKind::cloud);
      EXPECT_NE(model.level_ring, nullptr);
    }
    if (model.has(Trait::gnss)) {
      EXPECT_NE(model.telemetry_port, 0);
    }
    if (model.has(Trait::receiver_settable)) {
      EXPECT_EQ(model.transport, Transport::udp);
      EXPECT_TRUE(model.has(Trait::settings_writable));
    }
    if (model.has(Trait::receiver_settable) || model.has(Trait::web_control)) {
      EXPECT_NE(model.dialogue_port, 0);
    }
    if (model.has(Trait::echoes)) {
      EXPECT_EQ(model.kind, FrameKind::scan);
    }
    EXPECT_FALSE(model.has(Trait::skip_setting) && model.has(Trait::skip_request));
    EXPECT_GE(model.fragments_per_packet, 1);
    EXPECT_NE(model.make, nullptr);
  }
}

TEST(Models, AreToldApartByWhatFewOfThemCan) {
  EXPECT_EQ(with(Trait::calibration), with(Trait::packet_messages));
  EXPECT_EQ(with(Trait::calibration).size(), with(Trait::web_control).size() + 4) << "the four HDL-64E";
  EXPECT_EQ(with(Trait::skip_request).size(), 7U) << "SCIP";
  for (const auto& name : with(Trait::skip_setting))
    EXPECT_THAT(with(Trait::states_on_request), ::testing::Contains(name)) << "CoLa";
  EXPECT_EQ(with(Trait::states_on_request).size(), with(Trait::skip_setting).size() + 4) << "safety scanners";
}

TEST(Models, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (const Model& model : models()) EXPECT_TRUE(names.insert(model.name).second) << model.name;
}

TEST(Families, RecognizeNothingInNothing) {
  for (const Family& family : families()) {
    const auto recognizer = family.make_recognizer();
    recognizer->add(Packet());
    EXPECT_EQ(recognizer->verdict(), "");
    EXPECT_EQ(recognizer->remark(), "");
  }
}

}  // namespace
}  // namespace lidard
