// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/reading.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/nearest.h"

namespace lidard {

void Reading::warn(const Location& location, const std::string& what) {
  warnings.push_back(location.to_string() + ": " + what);
}

void Reading::add_invalid_names(const std::string& name, const Value& entry) {
  constexpr int deepest = 3;  // aliases may make a value much larger than its file
  std::vector<std::string> texts{name};
  entry.add_texts(deepest, texts);
  for (const std::string& text : texts) invalid_names.insert(without_slash(text));
}

bool Reading::may_be_invalid(const std::string& name) const {
  return !is_complete || !has_sensors || invalid_names.count(name) != 0 ||
         invalid_names.count(name.substr(0, name.find('/'))) != 0;
}

ConfigClaims::ConfigClaims() {
  for (const char* topic : {"clock", "diagnostics", "rosout", "tf", "tf_static"})
    topics_.emplace(topic, "ROS itself");
}

void ConfigClaims::publishes(const std::string& topic, const std::string& owner, const Value& value) {
  const auto [claim, is_new] = topics_.emplace(without_slash(topic), owner);
  if (!is_new)
    value.fail("would publish on " + topic + ", the topic of " + claim->second, "a topic of its own");
}

void ConfigClaims::listens(const std::string& topic, const std::string& owner, const Value& value) {
  const auto [claim, is_new] = topics_.emplace(without_slash(topic), owner);
  if (!is_new) value.fail("is the topic of " + claim->second + " already", "the topic of another driver");
}

void ConfigClaims::holds_frame(const std::string& child, const std::string& parent, const Pose& pose,
                               const std::string& owner, const Value& value) {
  if (child == parent) {
    if (!pose.isApprox(Pose::Identity(), 1e-9))
      value.fail("moves " + child + " against itself", "no pose, or another frame");
    return;
  }
  // tf knows a tree: a frame that hangs from itself would lose its parent.
  for (auto up = frames_.find(parent); up != frames_.end(); up = frames_.find(up->second.parent)) {
    if (up->second.parent == child)
      value.fail(fmt::format("places {0} in {1}, which the pose of {2} in {3} places in {0}", child, parent,
                             up->first, up->second.owner),
                 "poses that lead from each frame up to vehicle.base_frame");
  }
  const auto [frame, is_new] = frames_.emplace(child, Frame{parent, pose, owner});
  if (is_new) return;
  if (frame->second.parent != parent || !frame->second.pose.isApprox(pose, 1e-9))
    value.fail("differs from the pose of frame " + child + " in " + frame->second.owner,
               "one pose for one frame");
}

void ConfigClaims::uses(const std::string& sensor, FrameKind kind, const std::string& owner,
                        const Value& value) {
  const auto [use, is_new] = uses_.emplace(sensor, Use{kind, owner});
  if (is_new || use->second.kind == kind) return;
  const char* earlier = kind == FrameKind::scan ? "a cloud" : "a scan";
  value.fail("names " + sensor + ", which " + use->second.owner + " takes for " + earlier,
             "a topic to be one or the other");
}

Source read_source(const Value& value, FrameKind kind, const Reading& reading, const std::string& expected) {
  const std::string name = without_slash(value.text(expected));
  const Candidate* found = nullptr;
  const Candidate* other_kind = nullptr;
  const auto refuse_both = [&](const Candidate& other) {
    value.fail("names " + value.quoted() + ", which is " + found->what + " and " + other.what,
               "a name that only one of them has");
  };
  std::vector<std::string_view> names;
  for (const Candidate& one : reading.candidates) {
    const bool is_wanted = one.gives.value_or(kind) == kind;
    if (is_wanted) names.push_back(one.called);
    if (without_slash(one.called) != name) continue;
    if (is_wanted && found != nullptr && !(found->source == one.source)) refuse_both(one);
    (is_wanted ? found : other_kind) = &one;
  }
  if (found != nullptr && !found->source.is_sensor() && other_kind != nullptr &&
      other_kind->source.is_sensor())
    refuse_both(*other_kind);
  if (found != nullptr) return found->source;
  if (reading.may_be_invalid(name)) throw ConfigError(std::vector<ConfigError::Mistake>());
  if (other_kind != nullptr)
    value.fail("names " + other_kind->called + ", " + other_kind->but_gives, expected);
  const std::string_view near = nearest_word(name, names);
  value.fail("names " + value.quoted() + ", which is no sensor and no topic of one",
             near.empty() ? expected : std::string(near));
}

std::size_t SourceList::index_of(const Value& value, const std::string& expected) const {
  const std::string name = value.text(expected);
  for (const auto* const called : {&names, &written}) {
    const auto found = std::find(called->begin(), called->end(), name);
    if (found != called->end()) return static_cast<std::size_t>(found - called->begin());
  }
  value.fail("is " + value.quoted() + ", which is no source of it", expected);
}

SourceList read_sources(const Mapping& yaml, std::string_view key, const std::string& expected,
                        FrameKind (*kind_of)(const Value&, const Reading&), Reading& reading) {
  SourceList list{key, {}, {}, {}, {}};
  const Value all = yaml.require(key, expected);
  list.values = all.names(expected);
  if (list.values.empty()) all.fail("names nothing", expected);
  Mistakes mistakes;
  for (const Value& value : list.values) {
    mistakes.attempt([&] {
      const FrameKind kind = kind_of(value, reading);
      const Source source = read_source(value, kind, reading, expected);
      if (source.kind == Source::Kind::merged_cloud)
        value.fail("names " + value.quoted() + ", a merged cloud", expected);
      if (std::find(list.names.begin(), list.names.end(), source.name) != list.names.end())
        value.fail("names " + source.name + " again", "every source once");
      if (source.kind == Source::Kind::topic)
        reading.claims.uses(source.name, kind, yaml.self().path(), value);
      list.names.push_back(source.name);
      list.written.push_back(value.text());
      list.sources.push_back(source);
    });
  }
  mistakes.throw_if_any();
  return list;
}

}  // namespace lidard
