// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/mount_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

constexpr std::size_t beams = 720;
constexpr Span period = std::chrono::milliseconds(200);
constexpr double memory_s = 5;

// A surface is a straight piece of 2 * reach + 1 returns.
constexpr std::size_t reach = 4;
constexpr float straight_m = 0.03F;
// Surfaces farther apart than this are different objects.
constexpr float same_surface_m = 0.4F;
constexpr float same_direction = 0.9848F;  // cosine of 10 degrees
constexpr float steep = 0.342F;            // sine of 20 degrees: a flatter beam makes errors long
// Neighbouring pieces share their returns: this number of beams counts as one sample.
constexpr double beams_per_sample = 2 * reach + 1;
constexpr double enough_beams = 50;
// If the surroundings move by less between two comparisons, the vehicle counts as standing: two sweeps are
// much closer in time.
constexpr double standing_m = 0.03;
// Share of the evidence that is required for a direction.
constexpr double determined_share = 0.02;
constexpr double mad_to_sigma = 1.4826;
constexpr double looks_to_confirm = 8;

/// The three parameters with yaw as a length, so that they can be compared.
struct Solution {
  Eigen::Vector3d value{0, 0, 0};
  std::array<bool, 3> determined{false, false, false};
};

/// Least squares along the directions that the surfaces determine, 0 along the others.
Solution solve(const Eigen::Matrix3d& levers, const Eigen::Vector3d& pulls, double evidence) {
  Solution solution;
  if (evidence <= 0) return solution;
  const double arm = std::sqrt(std::max(levers(0, 0) / evidence, 1e-6));
  const Eigen::Vector3d scale(1 / arm, 1, 1);
  const Eigen::Matrix3d scaled = scale.asDiagonal() * levers * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(scaled);
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  solution.determined = {true, true, true};
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d direction = parts.eigenvectors().col(i);
    if (parts.eigenvalues()[i] > determined_share * evidence) {
      value += direction * (direction.dot(scale.cwiseProduct(pulls)) / parts.eigenvalues()[i]);
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(direction[static_cast<int>(c)]) > 0.3) solution.determined[c] = false;
    }
  }
  solution.value = scale.cwiseProduct(value);
  return solution;
}

}  // namespace

MountCheck::MountCheck(std::size_t sources, double tolerance)
    : tolerance_(tolerance), facets_(sources, std::vector<Facet>(beams)), before_(facets_) {
  for (std::size_t i = 0; i < beams; ++i) {
    const double angle = two_pi * static_cast<double>(i) / static_cast<double>(beams);
    rays_.emplace_back(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
  }
  for (std::size_t a = 0; a < sources; ++a) {
    for (std::size_t b = a + 1; b < sources; ++b) {
      states_.emplace_back();
      states_.back().first = a;
      states_.back().second = b;
    }
  }
  memories_.resize(states_.size());
  common_.reserve(beams);
  sorted_.reserve(beams);
}

void MountCheck::reset() {
  last_look_.reset();
  std::fill(memories_.begin(), memories_.end(), Memory{});
  for (OverlapState& state : states_) {
    OverlapState fresh;
    fresh.first = state.first, fresh.second = state.second;
    state = fresh;
  }
}

bool MountCheck::is_due(Stamp stamp) const {
  return !last_look_ || stamp - *last_look_ >= period || *last_look_ - stamp > restart_limit;
}

/// Fits a straight line through the returns around `beam`; false if they are not on a straight surface.
bool MountCheck::fit(const PlacedScan& sweep, std::size_t beam, Eigen::Vector2f& middle,
                     Eigen::Vector2f& normal) const {
  if (beam < reach || beam + reach >= sweep.linked.size()) return false;
  middle.setZero();
  for (std::size_t i = beam - reach; i <= beam + reach; ++i) {
    if (i < beam + reach && sweep.linked[i] == 0) return false;
    middle += Eigen::Vector2f(sweep.x[i], sweep.y[i]);
  }
  middle /= static_cast<float>(beams_per_sample);
  Eigen::Matrix2f spread = Eigen::Matrix2f::Zero();
  for (std::size_t i = beam - reach; i <= beam + reach; ++i) {
    const Eigen::Vector2f d = Eigen::Vector2f(sweep.x[i], sweep.y[i]) - middle;
    spread += d * d.transpose();
  }
  // Closed form for the eigenvalues of a symmetric 2 x 2 matrix.
  const float half_trace = (spread(0, 0) + spread(1, 1)) / 2;
  const float half_difference = (spread(0, 0) - spread(1, 1)) / 2;
  const float root = std::hypot(half_difference, spread(0, 1));
  const float angle = 0.5F * std::atan2(spread(0, 1), half_difference);  // of the line
  normal = {-std::sin(angle), std::cos(angle)};
  const float thickness = std::sqrt(std::max(0.0F, half_trace - root) / static_cast<float>(beams_per_sample));
  const float length = std::sqrt((half_trace + root) / static_cast<float>(beams_per_sample));
  return thickness < straight_m && length > 3 * thickness;
}

/// Writes the piece of surface from p to q into the beams that hit it.
void MountCheck::draw(const Eigen::Vector2f& p, const Eigen::Vector2f& q, const Eigen::Vector2f& middle,
                      const Eigen::Vector2f& normal, std::vector<Facet>& facets) const {
  constexpr auto per_rad = static_cast<float>(static_cast<double>(beams) / (two_pi));
  float from = std::atan2(p.y(), p.x());
  float width = wrapped(std::atan2(q.y(), q.x()) - from);
  if (width < 0) from += width, width = -width;
  const auto first = static_cast<long>(std::ceil(from * per_rad));
  const auto last = static_cast<long>(std::floor((from + width) * per_rad));
  const float distance = normal.dot(middle);
  for (long at = first; at <= last; ++at) {
    const auto n = static_cast<long>(beams);
    const auto beam = static_cast<std::size_t>(((at % n) + n) % n);
    const float slope = normal.dot(rays_[beam]);
    if (std::abs(slope) < steep) continue;
    const float range = distance / slope;
    Facet& facet = facets[beam];
    if (range > 0.1F && (facet.range == 0 || range < facet.range)) facet = {range, normal};
  }
}

void MountCheck::see(const PlacedScan& sweep, const Eigen::Vector2d& place, std::vector<Facet>& facets) {
  std::fill(facets.begin(), facets.end(), Facet{});
  const Eigen::Vector2f from = place.cast<float>();
  Eigen::Vector2f middle, normal;
  for (std::size_t i = 0; i + 1 < sweep.linked.size(); ++i) {
    if (sweep.linked[i] == 0 || !fit(sweep, i, middle, normal)) continue;
    const Eigen::Vector2f beam = (middle - from).normalized();
    const float towards = normal.dot(beam);
    if (std::abs(towards) < steep) continue;
    if (towards > 0) normal = -normal;
    draw({sweep.x[i], sweep.y[i]}, {sweep.x[i + 1], sweep.y[i + 1]}, middle, normal, facets);
  }
}

/// True if a source sees the same surfaces as in the previous comparison.
bool MountCheck::stands(std::size_t source) {
  sorted_.clear();
  for (std::size_t i = 0; i < beams; ++i) {
    const Facet& now = facets_[source][i];
    const Facet& then = before_[source][i];
    if (now.range == 0 || then.range == 0 || now.normal.dot(then.normal) < same_direction) continue;
    sorted_.push_back(static_cast<double>(std::abs((now.range - then.range) * now.normal.dot(rays_[i]))));
  }
  if (static_cast<double>(sorted_.size()) < enough_beams) return false;
  // Walls along the way do not move; only the few surfaces across it show motion.
  const auto most = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() * 9 / 10);
  std::nth_element(sorted_.begin(), most, sorted_.end());
  return *most < standing_m;
}

void MountCheck::compare(const std::vector<Facet>& first, const std::vector<Facet>& second,
                         const Eigen::Vector2d& place) {
  common_.clear();
  for (std::size_t i = 0; i < beams; ++i) {
    const Facet& a = first[i];
    const Facet& b = second[i];
    if (a.range == 0 || b.range == 0 || std::abs(a.range - b.range) > same_surface_m) continue;
    if (a.normal.dot(b.normal) < same_direction) continue;
    const Eigen::Vector2d normal = (a.normal + b.normal).cast<double>().normalized();
    const Eigen::Vector2d ray = rays_[i].cast<double>();
    const double along = static_cast<double>(a.range - b.range);
    const Eigen::Vector2d arm = ray * static_cast<double>(b.range) - place;
    const Eigen::Vector3d lever(normal.dot(Eigen::Vector2d(-arm.y(), arm.x())), normal.x(), normal.y());
    common_.push_back({lever, along * normal.dot(ray), along});
  }
}

template <typename Value>
double MountCheck::median_of(Value value) {
  sorted_.clear();
  for (const Common& c : common_) sorted_.push_back(value(c));
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return *middle;
}

/// Computes the correction from one comparison and counts its evidence, with Huber's weights against
/// outliers.
void MountCheck::learn(Memory& memory) {
  constexpr int rounds = 4;
  Eigen::Vector3d guess = Eigen::Vector3d::Zero();
  for (int round = 1; round <= rounds; ++round) {
    const double rest = median_of([&](const Common& c) { return std::abs(c.across - c.lever.dot(guess)); });
    const double limit = 1.345 * mad_to_sigma * rest + 0.002;
    Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();
    Eigen::Vector3d pulls = Eigen::Vector3d::Zero();
    double evidence = 0;
    for (const Common& c : common_) {
      const double off = std::abs(c.across - c.lever.dot(guess));
      const double weight = off > limit ? limit / off : 1;
      levers += weight * c.lever * c.lever.transpose();
      pulls += weight * c.across * c.lever;
      evidence += weight;
    }
    guess = solve(levers, pulls, evidence).value;
    if (round < rounds) continue;
    memory.levers += levers, memory.pulls += pulls, memory.evidence += evidence;
    memory.rest += static_cast<double>(common_.size()) * rest;
  }
}

/// Adds one comparison to the decayed sums of the earlier ones.
void MountCheck::remember(double kept, Memory& memory) {
  const auto n = static_cast<double>(common_.size());
  memory.weight = memory.weight * kept + 1;
  memory.beams = memory.beams * kept + n;
  memory.median *= kept, memory.mad *= kept, memory.rest *= kept, memory.evidence *= kept;
  memory.levers *= kept, memory.pulls *= kept;
  if (common_.empty()) return;
  const double median = median_of([](const Common& c) { return c.along; });
  memory.median += n * median;
  memory.mad += n * median_of([median](const Common& c) { return std::abs(c.along - median); });
  learn(memory);
}

void MountCheck::judge(const Memory& memory, OverlapState& state) const {
  state.beams = memory.beams / memory.weight;
  state.misaligned = false;
  if (memory.beams <= 0) return;
  state.median = memory.median / memory.beams;
  state.mad = memory.mad / memory.beams;
  const Solution solution = solve(memory.levers, memory.pulls, memory.evidence);
  state.correction = solution.value;
  state.determined = solution.determined;
  state.shift = std::sqrt(state.correction.dot(memory.levers * state.correction) / memory.evidence);
  const double samples = std::max(1.0, memory.beams / beams_per_sample);
  const double limit = tolerance_ + 3 * mad_to_sigma * memory.rest / memory.beams / std::sqrt(samples);
  state.misaligned = state.beams >= enough_beams && std::max(std::abs(state.median), state.shift) > limit;
}

/// What was seen for a while before a knock would lessen the correction: it is forgotten once the knock
/// shows. A few looks later it is known whether it was one.
void MountCheck::date_knock(Stamp stamp, Memory& memory, OverlapState& state) {
  if (memory.since_knock && memory.weight < looks_to_confirm) state.misaligned = true;
  if (state.misaligned == state.since.has_value()) return;
  state.since = state.misaligned ? std::optional(stamp) : std::nullopt;
  const bool is_knock = state.misaligned && memory.weight >= looks_to_confirm;
  if (is_knock) memory = Memory{};
  memory.since_knock = is_knock;
}

void MountCheck::look(Stamp stamp, const std::vector<const PlacedScan*>& sweeps,
                      const std::vector<Eigen::Vector2d>& places, bool deskewed) {
  if (last_look_ && *last_look_ - stamp > restart_limit) reset();
  const double since = last_look_ ? std::max(0.0, seconds(stamp - *last_look_)) : 0;
  last_look_ = stamp;
  for (std::size_t s = 0; s < facets_.size(); ++s) {
    facets_[s].swap(before_[s]);
    if (sweeps[s] != nullptr)
      see(*sweeps[s], places[s], facets_[s]);
    else
      std::fill(facets_[s].begin(), facets_[s].end(), Facet{});
  }
  for (std::size_t i = 0; i < states_.size(); ++i) {
    OverlapState& state = states_[i];
    if (sweeps[state.first] == nullptr || sweeps[state.second] == nullptr) continue;
    if (!deskewed && !(stands(state.first) && stands(state.second))) continue;
    compare(facets_[state.first], facets_[state.second], places[state.second]);
    remember(std::exp(-since / memory_s), memories_[i]);
    judge(memories_[i], state);
    date_knock(stamp, memories_[i], state);
  }
}

}  // namespace lidard
