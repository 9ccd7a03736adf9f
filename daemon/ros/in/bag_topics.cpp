// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/in/bag_topics.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "core/base/number_text.h"
#include "daemon/ros/messages/convert.h"
#include "daemon/ros/velodyne/velodyne_scan.h"

namespace lidard {
namespace {

std::string text_of(const BagTopic& topic) {
  return topic.name + " (" + topic.type + ", " + std::to_string(topic.messages) + " messages)";
}

/// A topic as the name of a sensor.
std::string sensor_name(const std::string& topic) {
  std::string name = ros_frame(topic);
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) name = "topic_" + name;
  return name;
}

}  // namespace

bool same_topic(const std::string& a, const std::string& b) { return ros_frame(a) == ros_frame(b); }

std::unique_ptr<BagReader> open_bags(const std::vector<std::string>& bags) {
  return std::unique_ptr<BagReader>(bags_function<decltype(lidard_open_bags)>("lidard_open_bags")(bags));
}

bool is_bag(const std::string& path) {
  return path.size() > 4 && path.compare(path.size() - 4, 4, ".bag") == 0;
}

std::vector<std::string> split_bags(std::vector<std::string>& captures) {
  const auto first = std::stable_partition(captures.begin(), captures.end(),
                                           [](const std::string& path) { return !is_bag(path); });
  std::vector<std::string> bags(first, captures.end());
  captures.erase(first, captures.end());
  return bags;
}

std::string config_of_bags(const std::vector<std::string>& bags) {
  std::string sensors, others;
  const auto reader = open_bags(bags);
  for (const BagTopic& topic : reader->topics()) {
    const std::string what = "   # " + topic.type + ", " + std::to_string(topic.messages) + " messages in " +
                             fixed(topic.seconds, 1) + " s\n";
    if (topic.type == type_of<sensor_msgs::LaserScan>().name ||
        topic.type == type_of<sensor_msgs::PointCloud2>().name)
      sensors += "  " + sensor_name(topic.name) + ": {topic: " + topic.name + "}" + what;
    else if (topic.type == VelodyneScanMessage::message_type().name)
      others += "#  " + sensor_name(topic.name) + ": {model: velodyne_vlp16, packet_topic: " + topic.name +
                "}" + what;
    else
      others += "# " + topic.name + what;
  }
  return (sensors.empty() ? "sensors: {}\n" : "sensors:\n" + sensors) + others;
}

BagTopics::BagTopics(const std::vector<std::string>& bags, const Config& config) : reader_(open_bags(bags)) {
  for (const TopicSource& source : topic_sources(config))
    static_cast<TopicSource&>(sources_.emplace_back()) = source;
  check(bags);
  reader_->choose([this](const std::string& topic) {
    return std::any_of(sources_.begin(), sources_.end(),
                       [&](const SourceReport& source) { return same_topic(source.topic, topic); });
  });
  advance();
}

void BagTopics::check(const std::vector<std::string>& bags) const {
  std::string there;
  for (const BagTopic& topic : reader_->topics()) {
    if (!there.empty()) there += ", ";
    there += text_of(topic);
  }
  const std::string& first = bags.front();
  if (sources_.empty())
    throw std::runtime_error(first + ": no sensor of the configuration has a topic; give one `topic:`, of " +
                             there);
  const auto& all = reader_->topics();
  const auto missing = std::find_if(sources_.begin(), sources_.end(), [&](const SourceReport& source) {
    return std::none_of(all.begin(), all.end(), [&](const BagTopic& topic) {
      return topic.messages > 0 && same_topic(source.topic, topic.name);
    });
  });
  if (missing == sources_.end()) return;
  throw std::runtime_error(first + ": no message on " + missing->topic + ", the topic of sensor " +
                           missing->sensor + "; there are " + there);
}

void BagTopics::advance() {
  at_.reset();
  try {
    if (reader_->next(message_)) at_ = clock_.steady(from_ros(message_.time));
  } catch (const std::exception& problem) {
    damage_ = problem.what();
  }
}

/// Passes the message at hand on; returns why it is of no use.
const char* BagTopics::pass(SourceReport& source, MessageReceiver& to, Stamp received) {
  if (source.packets) {
    const ByteView bytes(message_.bytes.data(), message_.bytes.size());
    return read_velodyne_scan(bytes, [&](ByteView packet, HostStamp arrival) {
      const Stamp stamp = arrival == HostStamp{} ? received : clock_.steady(arrival);
      to.packet_message(source.sensor, {packet, stamp, {}, {}}, received);
    });
  }
  if (message_.scan) {
    const char* const error = read_message(*message_.scan, clock_, scan_, source);
    if (error == nullptr) to.scan_message(source.sensor, scan_, received);
    return error;
  }
  if (!message_.cloud) return "neither a LaserScan nor a PointCloud2";
  const char* const error = read_message(*message_.cloud, clock_, cloud_, source);
  if (error == nullptr) to.cloud_message(source.sensor, cloud_, received);
  return error;
}

void BagTopics::feed(MessageReceiver* to, Stamp until) {
  for (; at_ && *at_ <= until; advance()) {
    for (SourceReport& source : sources_) {
      if (to == nullptr || !same_topic(source.topic, message_.topic)) continue;
      ++source.messages;
      const char* const reason = pass(source, *to, *at_);
      if (reason == nullptr) continue;
      ++source.rejected;
      source.last_reason = reason;
    }
  }
}

}  // namespace lidard
