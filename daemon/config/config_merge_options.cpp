// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config_parts.h"
#include "daemon/config/config_words.h"

namespace lidard {
namespace {

constexpr double strongest = 1e9;

constexpr std::array<Word<bool>, 2> conflicts{{{"keep", false}, {"newest", true}}};
constexpr std::array<Word<bool>, 2> heights{{{"any", false}, {"all", true}}};
constexpr std::array<Word<Intensities>, 3> intensities{
    {{"auto", Intensities::automatic}, {"on", Intensities::on}, {"off", Intensities::off}}};

/// What compares the evidence of sources needs some evidence, and sources.
void need_evidence(const Value& key, const MergedScanConfig& merged) {
  if (!merged.has_visibility() && merged.status_topic.empty())
    key.fail_at_key("has no effect with profile: flatten, which knows no free space",
                    "profile: strict or safety");
  if (merged.laserscan_topics.size() < 2)
    key.fail_at_key("has no effect with one source", "two sources or more");
}

}  // namespace

const char* word_of(Intensities choice) { return word_in(choice, intensities); }

void read_merge_options(Mapping& yaml, MergedScanConfig& merged) {
  MergeOptions& options = merged.options;
  if (const auto v = yaml.find("conflicts")) {
    options.newest_wins = read_word(*v, conflicts);
    if (options.newest_wins) need_evidence(*v, merged);
  }
  if (const auto v = yaml.find("free_requires")) {
    options.all_heights = read_word(*v, heights);
    if (options.all_heights) need_evidence(*v, merged);
  }
  if (const auto v = yaml.find("veil_cross_check")) {
    options.veil_cross_check = v->boolean();
    if (options.veil_cross_check) need_evidence(*v, merged);
  }
  if (const auto v = yaml.find("intensity")) options.intensities = read_word(*v, intensities);
  if (const auto v = yaml.find("missing_intensity")) {
    options.missing_intensity = static_cast<float>(v->number(-strongest, strongest, ""));
    if (options.intensities != Intensities::on)
      v->fail_at_key("has no effect with intensity: " + std::string(word_of(options.intensities)),
                     "intensity: on");
  }
}

}  // namespace lidard
