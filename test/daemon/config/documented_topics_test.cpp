// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Both manuals name every topic that a sensor can have, and no other.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "daemon/config/config.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using Names = std::set<std::string>;

std::string text_of(const std::string& file) {
  const std::string text = test::content(test::project_file(file));
  EXPECT_GT(text.size(), 1000U) << file;
  return text;
}

/// The last parts of the topics that a sensor of this model has with everything switched on.
Names topics_of(const Model& model) {
  SensorConfig sensor;
  sensor.name = "s";
  sensor.model = &model;
  sensor.driver.publish_multiecho = true;
  sensor.driver.requests.device_states = true;
  if (model.level_ring != nullptr) sensor.ring_scan.emplace(), sensor.scan_topic = "s/scan";
  Names names;
  for (const OutputTopic& topic : sensor_topics(sensor)) names.insert(topic.name.substr(2));
  return names;
}

Names all_topics() {
  Names names;
  for (const Model& model : models()) names.merge(topics_of(model));
  return names;
}

Names found_in(const std::string& text, const std::regex& pattern) {
  Names names;
  for (std::sregex_iterator found(text.begin(), text.end(), pattern), end; found != end; ++found)
    names.insert((*found)[1]);
  return names;
}

TEST(DocumentedTopics, OfSensorsAreThoseThatTheModelsHave) {
  const Names known = all_topics();
  EXPECT_THAT(known, ::testing::IsSupersetOf({"scan", "points", "intrusion", "lferec", "imu", "status"}));
  const std::string page_of_topics = text_of("config/doc/topics.md");
  const std::string table = page_of_topics.substr(page_of_topics.find("\n| topic |"));
  EXPECT_EQ(found_in(table.substr(0, table.find("\n\n", 20)), std::regex("`<sensor>/([a-z_]+)`")), known);
  const std::string page = text_of("daemon/lidard.8");
  const std::size_t begin = page.find("\n.SH TOPICS\n");
  ASSERT_NE(begin, std::string::npos);
  const std::string section = page.substr(begin, page.find("\n.SH ", begin + 1) - begin);
  EXPECT_EQ(found_in(section, std::regex("NAME \"?/([a-z_]+)")), known);
}

TEST(DocumentedTopics, StatesOfADeviceAreNotThereUnlessAskedFor) {
  std::string model = "sick_lms1xx";
  const auto names = [&](const std::string& keys) {
    const Config config =
        parse_config("sensors: {s: {model: " + model + ", ip_address: 192.168.0.1" + keys + "}}", "f");
    Names topics;
    for (const OutputTopic& topic : output_topics(config)) topics.insert(topic.name);
    return topics;
  };
  EXPECT_EQ(names(""), Names{"s/scan"});
  EXPECT_EQ(names(", publish_states: false"), Names{"s/scan"});
  EXPECT_EQ(names(", publish_states: true"),
            (Names{"s/encoder", "s/lferec", "s/lidinputstate", "s/lidoutputstate", "s/scan"}));
  for (const char* safety : {"sick_microscan3", "sick_nanoscan3", "sick_outdoorscan3"}) {
    model = safety;
    EXPECT_EQ(names(""), Names{"s/scan"});
    EXPECT_EQ(names(", output_paths_topic: paths"), (Names{"paths", "s/scan"}));
    EXPECT_EQ(names(", publish_states: true"),
              (Names{"s/beam_status", "s/intrusion", "s/output_paths", "s/scan", "s/system_state"}));
    EXPECT_EQ(names(", publish_states: true, output_paths_topic: paths"),
              (Names{"paths", "s/beam_status", "s/intrusion", "s/scan", "s/system_state"}));
  }
  model = "sick_picoscan150";
  EXPECT_EQ(names("").count("s/reflectors"), 1U) << "comes only where there is a reflector";
}

}  // namespace
}  // namespace lidard
