// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/nearest.h"
#include "daemon/config/config_parts.h"
#include "daemon/config/config_words.h"

namespace lidard {
namespace {

constexpr std::array<Word<Profile>, 3> profiles{
    {{"strict", Profile::strict}, {"safety", Profile::safety}, {"flatten", Profile::flatten}}};
constexpr std::array<Word<EmptyBeam>, 5> beams{{{"inf", EmptyBeam::inf},
                                                {"nan", EmptyBeam::nan},
                                                {"range_max_plus_one", EmptyBeam::range_max_plus_one},
                                                {"minus_inf", EmptyBeam::minus_inf},
                                                {"zero", EmptyBeam::zero}}};
constexpr std::array<Word<EchoChoice>, 4> echo_choices{{{"first", EchoChoice::first},
                                                        {"last", EchoChoice::last},
                                                        {"strongest", EchoChoice::strongest},
                                                        {"all", EchoChoice::all}}};

}  // namespace

bool MergedScanConfig::has_visibility() const {
  bool visibility = output.profile != Profile::flatten;
  for (const AlsoScanConfig& one : also) visibility |= one.profile != Profile::flatten;
  return visibility;
}

Profile read_profile(const Value& value) { return read_word(value, profiles); }

AlsoScanConfig read_also(const std::string& topic, const Value& value) {
  AlsoScanConfig also;
  also.topic = topic;
  if (value.node().IsScalar()) {
    also.profile = read_profile(value);
    return also;
  }
  Mapping yaml(value, {"profile", "empty", "unobserved"});
  also.profile = read_profile(yaml.require("profile", list_of(profiles)));
  if (const auto empty = yaml.find("empty")) also.empty = read_empty(*empty);
  if (const auto unobserved = yaml.find("unobserved")) also.unobserved = read_empty(*unobserved);
  return also;
}

EchoChoice read_echoes(const Value& value) { return read_word(value, echo_choices); }
EmptyBeam read_empty(const Value& value) { return read_word(value, beams); }
const char* word_of(Profile profile) { return word_in(profile, profiles); }
const char* word_of(EmptyBeam beam) { return word_in(beam, beams); }
const char* word_of(EchoChoice choice) { return word_in(choice, echo_choices); }

void read_visibility(Mapping& yaml, const std::string& owner, Config& config, ConfigClaims& claims,
                     MergedScanConfig& merged) {
  if (const auto fuse = yaml.find("fuse")) {
    const std::string word = fuse->text("nearest or mean");
    if (word != "nearest" && word != "mean") fuse->fail("is " + fuse->quoted(), "nearest or mean");
    merged.mean = word == "mean";
  }
  if (const auto echoes = yaml.find("echoes")) merged.echoes = read_echoes(*echoes);
  if (const auto filter = yaml.find("veil_filter")) merged.veil_filter = filter->boolean();
  if (const auto noise = yaml.find("range_noise")) merged.range_noise = noise->number(0.0005, 1, "m");
  if (const auto free = yaml.find("free_required"))
    merged.free_required = free->number(0.1, merged.output.grid.range_max, "m");
  if (const auto also = yaml.find("also")) {
    for (const auto& [topic, value] : named_entries(*also)) {
      check_entry_name(topic, value);
      merged.also.push_back(read_also(topic, value));
      claims.publishes(topic, owner, value);
    }
  }
  if (!merged.has_visibility() || !config.vehicle.footprint.empty()) return;
  warn(config, yaml.where("profile").place(),
       owner +
           " is to say what is observed, but vehicle.footprint is not set: where the vehicle hides the way " +
           "from " + merged.destination_frame + " outward, every beam stays unobserved");
}

}  // namespace lidard
