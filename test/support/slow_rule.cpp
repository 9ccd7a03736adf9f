// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/slow_rule.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace lidard::sim {
namespace {

using Point = Eigen::Vector2d;

constexpr double widest_step = 0.2;  // rad; beams farther apart are no neighbours
constexpr double step = 0.003;       // m along a beam; shorter stretches are rounding
constexpr double nearest = 0.005;    // m; a surface at the output's origin is in no direction
constexpr double touch = 1e-9;       // m; wedges that share a beam leave nothing between them

double cross(const Point& a, const Point& b) { return a.x() * b.y() - a.y() * b.x(); }
double angle_between(const Point& a, const Point& b) { return std::atan2(cross(a, b), a.dot(b)); }
/// True if `p` lies left of the line from `at` in direction `along`, or on it.
bool is_left(const Point& at, const Point& along, const Point& p) { return cross(along, p - at) >= -touch; }
Point point(float x, float y) { return {static_cast<double>(x), static_cast<double>(y)}; }

}  // namespace

struct SlowRule::Scene {
  enum class Seen : std::uint8_t { no, maybe, yes };
  /// Of a place: whether some source sees it to be free, and whether a return hides it from one.
  struct Place {
    Seen free = Seen::no, hidden = Seen::no;
  };

  struct Beam {
    Point origin, ray;
    double from = 0, to = 0, step = 0;  // m; to == 0: no evidence; rad to the next beam
    bool returns = false;               // at its end
  };

  /// Between beams or borders a and b, b counter-clockwise of a.
  struct Wedge {
    Point a0, a, a1, b0, b, b1;       // where the free ways begin, their directions, where they end
    bool hides, doubtful, has_begin;  // the rule leaves open whether it is free; b0 to a0 is its border

    Seen holds(const Point& p) const {
      if (!is_left(a0, a, p) || !is_left(b0, -b, p) || (has_begin && !is_left(b0, a0 - b0, p)))
        return Seen::no;
      return is_left(a1, b1 - a1, p) ? Seen::yes : Seen::maybe;
    }
  };

  /// The wedges of one sweep.
  struct Source {
    std::vector<Wedge> wedges;
    std::size_t last = 0;  // the wedge that held the last place
    double turn = 1;       // -1: the beams are in clockwise order
    Point from, to;        // of the scanner during the sweep
    bool moved = false;

    /// Near a scanner that moves, neighbouring beams cross: not beyond its speed over that of the turning
    /// beam.
    bool is_folded(const Point& p) const {
      return moved && (p - from).norm() + (p - to).norm() < (to - from).norm() + 0.4;
    }

    std::vector<Beam> beams_of(const PlacedScan& sweep, const BeamRays& rays) {
      std::vector<Beam> beams(rays.size());
      const Point at = rays.pose.translation().head<2>();
      double turned = 0;
      for (std::size_t i = 0; i < beams.size(); ++i) {
        const Point ray = rays.direction[i].head<2>(),
                    next = rays.direction[(i + 1) % beams.size()].head<2>();
        beams[i] = {at,
                    ray.normalized(),
                    static_cast<double>(sweep.free_from[i]),
                    static_cast<double>(sweep.free_to[i]),
                    angle_between(ray, next),
                    sweep.kind[i] != Return::nothing};
        if (i + 1 < beams.size()) turned += beams[i].step;
        if (!sweep.moved) continue;
        beams[i].origin += point(sweep.origin_x[i], sweep.origin_y[i]);
        if (beams[i].to > 0)
          beams[i].ray = (at + point(sweep.free_x[i], sweep.free_y[i]) - beams[i].origin).normalized();
      }
      turn = turned < 0 ? -1 : 1;
      from = beams.front().origin;
      to = beams.back().origin;
      moved = sweep.moved;
      return beams;
    }

    /// `a` comes before `b` in the sweep.
    void add_wedge(const Beam& a, const Beam& b, bool hides, bool doubtful) {
      const Beam &right = turn > 0 ? a : b, &left = turn > 0 ? b : a;
      const auto at = [](const Beam& beam, double range) { return Point(beam.origin + range * beam.ray); };
      const Point a0 = at(right, right.from), b0 = at(left, left.from);
      wedges.push_back({a0, right.ray, at(right, std::max(right.to, right.from)), b0, left.ray,
                        at(left, std::max(left.to, left.from)), hides, doubtful,
                        // Beams that cross each other begin where they do.
                        cross(right.ray, b0 - a0) > touch && cross(left.ray, b0 - a0) > touch});
    }

    void add_pair(Beam a, Beam b, bool linked, double passed, bool doubtful) {
      a.from = b.from = doubtful ? std::min(a.from, b.from) : std::max(a.from, b.from);
      if (linked) return add_wedge(a, b, true, doubtful);
      const double angle = angle_between(a.ray, b.ray);
      const Beam& nearer = a.to <= b.to ? a : b;
      double share = nearer.returns ? std::min(passed / std::max(std::fabs(angle), touch), 0.5) : 0.5;
      if (&nearer == &a) share = 1 - share;
      Beam border = a;
      border.origin += share * (b.origin - a.origin);
      border.ray = Eigen::Rotation2Dd(share * angle) * a.ray;
      add_wedge(a, border, a.returns, doubtful);
      border.to = b.to;
      add_wedge(border, b, b.returns, doubtful);
    }

    /// The half of a beam that no other beam bounds.
    void add_half(const Beam& beam, double width, bool before) {
      Beam border = beam;
      const double half = std::fabs(width) < widest_step ? turn * std::fabs(width) / 2 : 0;
      border.ray = Eigen::Rotation2Dd(before ? -half : half) * beam.ray;
      add_wedge(before ? border : beam, before ? beam : border, beam.returns, false);
    }

    /// A return that one beam alone meets hides nothing but what is near behind it.
    void pass_lone_returns(const std::vector<Beam>& beams, const PlacedScan& sweep, double passed) {
      for (std::size_t i = 1; i + 1 < beams.size(); ++i) {
        if (sweep.kind[i] != Return::surface || sweep.linked[i - 1] != 0 || sweep.linked[i] != 0) continue;
        Beam right = beams[i], left = beams[i];
        left.from = right.from = beams[i].to + 0.5;
        left.to = right.to = std::min(beams[i - 1].to, beams[i + 1].to);
        if (beams[i].to <= 0 || left.to < left.from) continue;
        for (Beam* border : {&right, &left}) {
          const double angle =
              angle_between(beams[i].ray, border == &right ? beams[i - 1].ray : beams[i + 1].ray);
          const double share = 1 - std::min(passed / std::max(std::fabs(angle), touch), 0.5);
          border->ray = Eigen::Rotation2Dd(share * angle) * border->ray;
        }
        add_wedge(right, left, false, false);
      }
    }

    /// `passed`: rad between an object and the beam beside it.
    void build(std::vector<Beam>& beams, const PlacedScan& sweep, double passed) {
      const std::size_t n = beams.size();
      const bool circle = n > 2 && std::fabs(beams[n - 1].step) < 1.5 * std::fabs(beams[0].step);
      const bool closed = circle && !sweep.moved;
      const double before_first = closed ? beams[n - 1].step : n > 1 ? beams[0].step : 0;
      if (!closed) beams[n - 1].step = n > 1 ? beams[n - 2].step : 0;
      pass_lone_returns(beams, sweep, passed);
      std::vector<char> follows(n, 0);
      for (std::size_t i = 0; i < n; ++i) {
        const Beam& a = beams[i];
        if (a.to <= 0) continue;
        const Beam& b = beams[(i + 1) % n];
        const double angle = angle_between(a.ray, b.ray);
        const bool near = b.to > 0 && std::fabs(angle) < widest_step && (i + 1 < n || circle);
        const bool linked = sweep.linked[i] == PlacedScan::linked_surely;
        if (near && (i + 1 < n || closed)) {
          follows[(i + 1) % n] = 1;
          add_pair(a, b, linked, passed, false);
          if (std::fabs(a.from - b.from) > 1e-3) add_pair(a, b, linked, passed, true);
          continue;
        }
        add_half(a, a.step, false);
        // The ends of a full circle are neighbours if the scanner moved little enough.
        if (near && angle * turn > 0) add_pair(a, b, linked, passed, true);
      }
      for (std::size_t i = 0; i < n; ++i)
        if (beams[i].to > 0 && follows[i] == 0)
          add_half(beams[i], i > 0 ? beams[i - 1].step : before_first, true);
    }
  };

  /// What beams meet: a segment, or a point, which may be the end of a segment from `q`.
  struct Surface {
    Point p, q;
    bool is_segment;
  };

  /// A walk along a beam, with all rounding against it or in its favour.
  struct Walk {
    double known = 0, unseen = 0;  // m
    bool failed = false, ends_free = true;
  };

  ScanGrid grid;
  VisibilitySettings how;
  SlowRuleSettings settings;
  Footprint vehicle;
  std::optional<Pose> former_from_now;
  std::vector<Source> sources;
  std::vector<Surface> surfaces;

  void add_surfaces(const PlacedScan& sweep) {
    const auto at = [&](std::size_t i) { return point(sweep.x[i], sweep.y[i]); };
    for (std::size_t i = 0; i < sweep.kind.size(); ++i) {
      if (sweep.kind[i] != Return::surface) continue;
      const bool before = i > 0 && sweep.linked[i - 1] != 0, after = sweep.linked[i] != 0;
      if (!before || !after) surfaces.push_back({at(i), at(before ? i - 1 : after ? i + 1 : i), false});
      Point from = at(i);
      for (const auto& [beam, corner] : sweep.corners) {
        if (beam == i) surfaces.push_back({from, point(corner.x, corner.y), true}), from = surfaces.back().q;
      }
      if (after) surfaces.push_back({from, at(i + 1), true});
    }
  }

  double nearest_surface(double angle) const {
    const Point ray(std::cos(angle), std::sin(angle));
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [p, q, is_segment] : surfaces) {
      const double slope = cross(ray, q - p), crossing = cross(p, q - p) / slope,
                   share = cross(p, ray) / slope;
      if (is_segment && crossing > 0 && share >= 0 && share <= 1) nearest = std::min(nearest, crossing);
      if (is_segment || std::fabs(angle_between(ray, p)) > grid.increment / 2) continue;
      // The end of a surface is drawn out to the middle of the beam, unless it is slanted too much.
      const bool fits = std::fabs(crossing - p.norm()) <= p.norm() * grid.increment / 2;
      nearest = std::min(nearest, fits ? crossing : p.norm());
    }
    return nearest;
  }

  Place look(const Point& p) {
    if (vehicle.contains(p)) return {Seen::yes, Seen::no};
    if (former_from_now && vehicle.contains((*former_from_now * Eigen::Vector3d(p.x(), p.y(), 0)).head<2>()))
      return {Seen::yes, Seen::no};
    // Mostly the wedge that held the last place holds this one, or one beside it does.
    for (Source& s : sources) {
      for (std::size_t w = s.last - (s.last > 0);
           w < std::min(s.last + 2, s.wedges.size()) && !s.is_folded(p); ++w) {
        if (s.wedges[w].doubtful || s.wedges[w].holds(p) != Seen::yes) continue;
        s.last = w;
        return {Seen::yes, Seen::no};
      }
    }
    Place place;
    for (Source& s : sources) {
      const bool folded = s.is_folded(p);
      for (const Wedge& wedge : s.wedges) {
        const Seen held = wedge.holds(p);
        if (held == Seen::no) continue;
        const Seen seen = folded || wedge.doubtful ? Seen::maybe : Seen::yes;
        if (held == Seen::yes) place.free = std::max(place.free, seen);
        if (held == Seen::maybe && wedge.hides) place.hidden = std::max(place.hidden, seen);
        if (place.free != Seen::yes) continue;
        s.last = static_cast<std::size_t>(&wedge - s.wedges.data());
        return place;
      }
    }
    return place;
  }

  /// Before a hit, a part of the way may be unobserved; what a return hides may not.
  void walk_on(Walk& walk, double at, bool has_hit, bool free, bool hidden) const {
    walk.ends_free = free;
    if (free) walk.known = at;
    if (free) return;
    walk.unseen += step;
    const double most = std::max(how.gap, how.gap_share * at);
    walk.failed = walk.failed || !has_hit || hidden || at - walk.known > most || walk.unseen > 2 * most;
  }

  /// Three places side by side, each a third of a step before the next one.
  std::array<Place, 3> look_at(double at, const Point& ray) {
    const double reach = std::min(settings.edge, 0.01 * at);
    const Point aside(-reach * ray.y(), reach * ray.x()), along = step / 3 * ray;
    return {look(at * ray), look(at * ray + along + aside), look(at * ray - along - aside)};
  }
};

SlowRule::SlowRule(const ScanGrid& grid, const VisibilitySettings& how, const SlowRuleSettings& settings,
                   const Footprint& outline, const std::optional<Pose>& former_from_now)
    : scene_(new Scene{grid, how, settings, outline.padded(Footprint::margin_m), former_from_now, {}, {}}) {}

void SlowRule::add(const PlacedScan& sweep, const BeamRays& rays) {
  Scene::Source& source = scene_->sources.emplace_back();
  std::vector<Scene::Beam> beams = source.beams_of(sweep, rays);
  source.build(beams, sweep, scene_->grid.increment / 4);
  scene_->add_surfaces(sweep);
}

SlowAnswer SlowRule::answer(std::size_t beam) {
  using Seen = Scene::Seen;
  Scene& scene = *scene_;
  const double angle = scene.grid.angle(beam), range = scene.nearest_surface(angle),
               most = scene.grid.range_max;
  const bool has_hit = range <= most;
  SlowAnswer answer{{}, range > nearest, 0.01};
  for (const double turn : {-1e-4, 1e-4}) {
    const double beside = scene.nearest_surface(angle + turn),
                 change = has_hit ? std::fabs(beside - range) : 0;
    answer.slack += change;
    answer.sure = answer.sure && (beside <= most) == has_hit && change < 0.05;
  }
  const double open = scene.how.free_required > 0 ? std::min(scene.how.free_required, most) : most;
  const double way = has_hit ? range - std::max(scene.how.approach, 5 * scene.how.noise) : open;
  const Point ray(std::cos(angle), std::sin(angle));
  Scene::Walk against, in_favour;
  std::array<std::array<Scene::Place, 3>, 3> around;
  around[0] = around[1] = scene.look_at(step, ray);
  for (double at = step; at <= way && !in_favour.failed; at += step) {
    around[2] = scene.look_at(at + step, ray);
    Seen least_free = Seen::yes, most_free = Seen::no, least_hidden = Seen::yes, most_hidden = Seen::no;
    for (const auto& places : around) {
      for (const auto& [free, hidden] : places) {
        least_free = std::min(least_free, free), most_free = std::max(most_free, free);
        least_hidden = std::min(least_hidden, hidden), most_hidden = std::max(most_hidden, hidden);
      }
    }
    scene.walk_on(against, at, has_hit, least_free == Seen::yes, most_hidden != Seen::no);
    scene.walk_on(in_favour, at, has_hit, most_free != Seen::no, least_hidden == Seen::yes);
    answer.walked_to = at;
    around[0] = around[1];
    around[1] = around[2];
  }
  const bool passes = !in_favour.failed && in_favour.ends_free;
  answer.sure = answer.sure && passes == (!against.failed && against.ends_free);
  answer.claim = {!passes ? Claim::nothing : has_hit ? Claim::hit : Claim::free, range};
  return answer;
}

}  // namespace lidard::sim
