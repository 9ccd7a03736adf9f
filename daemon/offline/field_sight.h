// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <set>
#include <string>
#include <vector>

#include "daemon/offline/empty_field.h"

namespace lidard {

/// The share of beams, %, of all and of those ahead: within 30 degrees of the x axis of the output's frame.
/// Without beams ahead `ahead` is negative.
struct BeamShares {
  double all = 0, ahead = 0;
};

/// What is in the way of some beams of an output; several things may be in the way of one beam.
struct Hindrance {
  Limit limit;  ///< that keeps them from being free, were it the only one; none: the vehicle's outline
  BeamShares beams;
  std::string sentence;  ///< what it is, and the remedy
};

/// What a merged or virtual scan can know of an empty field.
struct FieldSight {
  std::string entry;   ///< "merged_scans.scan"
  std::string frame;   ///< its origin
  std::string topic;   ///< in EmptyField
  bool proves = true;  ///< false: profile flatten, which proves nothing; the rest is that of strict
  std::set<std::string> sensors{};      ///< behind it
  bool came = false;                    ///< false: a pose is not known, so nothing else is
  BeamShares free{};                    ///< +inf
  std::vector<Hindrance> hindrances{};  ///< the greatest first
};

/// What each merged and virtual scan of `field` can know; `config` is the configuration behind it.
std::vector<FieldSight> sights_of(const Config& config, const EmptyField& field);
/// The same as YAML comments.
std::string comments_of(const std::vector<FieldSight>& sights, const EmptyField& field);
/// "92 % of the beams (ahead 100 %)".
std::string to_text(const BeamShares& shares);

}  // namespace lidard
