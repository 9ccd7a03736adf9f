// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/plane_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {

void PlaneView::set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                          const Eigen::Vector3f& up) {
  grid_ = &grid;
  ground_ = &ground;
  neighbours_ = &links;
  up_ = up;
  is_turned_ = false;
  const std::size_t cells = grid.kind.size();
  resize_amply(cells, rises_, reaches_, heights_);
  resize_amply(cells + grid.rings(), sides_);
}

LIDARD_CLONES void PlaneView::set_frame(const Pose& virtual_from_cloud) {
  const Eigen::Matrix3f rotation = virtual_from_cloud.linear().cast<float>();
  if (!is_turned_ || rotation != rotation_) turn(rotation);
  translation_ = virtual_from_cloud.translation().cast<float>();
  const float offset = translation_.z();
  const float* const rises = rises_.data();
  float* const to = heights_.data();
  const std::size_t cells = heights_.size();
  for (std::size_t i = 0; i < cells; ++i) to[i] = rises[i] + offset;
}

LIDARD_CLONES void PlaneView::turn(const Eigen::Matrix3f& r) {
  is_turned_ = true;
  rotation_ = r;
  rise_ = r.row(2).dot(up_);
  const std::array<float, 9> a = {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1),
                                  r(1, 2), r(2, 0), r(2, 1), r(2, 2)};
  const BeamEnd* const ends = grid_->ends.data();
  float* const rises = rises_.data();
  float* const reaches = reaches_.data();
  const std::size_t cells = rises_.size();
  for (std::size_t i = 0; i < cells; ++i) {
    const float x = a[0] * ends[i].x + a[1] * ends[i].y + a[2] * ends[i].z;
    const float y = a[3] * ends[i].x + a[4] * ends[i].y + a[5] * ends[i].z;
    reaches[i] = std::sqrt(x * x + y * y);
    rises[i] = a[6] * ends[i].x + a[7] * ends[i].y + a[8] * ends[i].z;
  }
}

LIDARD_CLONES void PlaneView::set_level(float level) {
  level_ = level;
  const std::size_t cells = heights_.size();
  const float* const heights = heights_.data();
  const Beam* const kinds = grid_->kind.data();
  const char* const grounds = ground_->is_ground.data();
  std::uint8_t* const sides = sides_.data();
  for (std::size_t i = 0; i < cells; ++i) {
    const int where = heights[i] < level ? below : above_it;
    const int all = where + on_ground * (grounds[i] != Ground::none ? 1 : 0);
    sides[i] = static_cast<std::uint8_t>(kinds[i] == Beam::point ? all : 0);
  }
  std::copy_n(sides, grid_->rings(), sides + cells);
}

LIDARD_CLONES void PlaneView::measure_reaches(std::size_t column, const Raster::Point& from,
                                              float* reaches) const {
  const std::size_t rings = grid_->rings();
  const BeamEnd* const ends = grid_->ends.data() + grid_->index(column, 0);
  for (std::size_t r = 0; r < rings; ++r) {
    const Raster::Point end = project(ends[r]);
    const float x = end.x - from.x, y = end.y - from.y;
    reaches[r] = std::sqrt(x * x + y * y);
  }
}

Raster::Point PlaneView::between(std::size_t a, std::size_t b) const {
  return project(mixed(grid_->ends[a], grid_->ends[b], above(a) / (above(a) - above(b))));
}

Raster::Point PlaneView::straight_from(std::size_t i) const {
  const float drop = above(i) / rise_;
  BeamEnd end = grid_->ends[i];
  end.x -= drop * up_.x();
  end.y -= drop * up_.y();
  end.z -= drop * up_.z();
  return project(end);
}

namespace {

// Share of the height between the highest return and the beam that passes over it. In random yards half of
// the tops in between are higher than this.
constexpr float likely_reach = 0.33F;
// m; a wider stretch of returns of one ring at one distance lies on the top of an object, or on a face that
// is square to the beams.
constexpr float flat_width = 0.6F;
// m; where the next ring meets something beneath the plane no farther behind, it may meet the object's top.
constexpr float deepest_top = 3;
// m above the plane; a thing that ends lower may be overlooked.
constexpr float flush = 0.1F;
constexpr float same_end = 0.2F;     // m; so far aside a thing ends at about the same height
constexpr float flat_slack = 0.02F;  // m, of height, and of distance beside the noise

}  // namespace

void PlaneTops::find(const PlaneView& view) {
  const RingGrid& grid = view.grid();
  const std::size_t cells = grid.kind.size();
  resize_amply(cells, verdicts_, steps_);
  verdicts_.assign(cells, none);
  runs_.resize(grid.rings());
  for (auto& runs : runs_) runs.clear();
  if (view.rise() < PlaneView::steepest) return;
  mark_steps(view);
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    const std::size_t lowest = grid.index(c, 0);
    each_set(steps_.data() + lowest + 1, grid.rings() - 1,
             [&](std::size_t r) { add_step(view, c, lowest + 1 + r); });
  }
  // What a ring meets behind a run is known before the run is judged.
  for (std::size_t r = runs_.size(); r-- > 0;) {
    for (const Run& run : runs_[r]) judge(view, r, run);
  }
}

LIDARD_CLONES void PlaneTops::mark_steps(const PlaneView& view) {
  const std::size_t cells = steps_.size();
  const std::uint8_t* const sides = view.sides().data();
  const Beam* const kinds = view.grid().kind.data();
  const float* const distances = view.ground().distance.data();
  const float slack = 2 * view.links().slack();
  std::uint8_t* const steps = steps_.data();
  for (std::size_t i = 1; i < cells; ++i) {
    const int farther = distances[i] > distances[i - 1] + slack ? 1 : 0;
    const int thing = (sides[i - 1] & PlaneView::both_sides) != 0 ? 1 : 0;
    const int ground = (sides[i - 1] & PlaneView::on_ground) != 0 ? 0 : 1;
    const int ends = kinds[i] == Beam::point || kinds[i] == Beam::none ? 1 : 0;
    steps[i] = static_cast<std::uint8_t>(farther & thing & ground & ends);
  }
}

namespace {

/// Columns of `width` m at `distance` m.
std::size_t columns_of(const PlaneView& view, float width, float distance) {
  constexpr double most = 1e6;  // a ring may look straight down
  return static_cast<std::size_t>(std::min(most, static_cast<double>(width / distance) / view.grid().step()));
}

}  // namespace

/// m above the plane at which a beam passes over the return of the beam beneath it.
float PlaneTops::passing_over(const PlaneView& view, std::size_t upper) {
  const float sensor = view.sensor_above();
  return sensor + (view.above(upper) - sensor) * view.distance(upper - 1) / view.distance(upper);
}

void PlaneTops::add_step(const PlaneView& view, std::size_t column, std::size_t upper) {
  const std::size_t lower = upper - 1;
  const std::size_t ring = upper - view.grid().index(column, 0);
  const float near = view.distance(lower);
  const float share = near / view.distance(upper);
  const float sensor = view.sensor_above();
  const float here = view.above(lower);
  const float passing = passing_over(view, upper);
  const bool stands =
      (view.sides()[upper] & (PlaneView::both_sides | PlaneView::on_ground)) == PlaneView::above_it;
  if (stands && here >= 0 && sensor * share + (here - sensor) < 0) verdicts_[upper] = hides;
  std::vector<Run>& runs = runs_[ring];
  // A beam that dips beneath the plane says nothing of the other columns.
  const float over = passing > 0 ? passing : std::numeric_limits<float>::infinity();
  if (runs.empty() || runs.back().end < column || !view.links().level(column - 1, ring - 1)) {
    runs.push_back({column, column + 1, here, over, near});
    return;
  }
  Run& run = runs.back();
  run.top = std::max(run.top, here);
  run.passing = std::min(run.passing, over);
  run.nearest = std::min(run.nearest, near);
  ++run.end;
}

PlaneTops::Shape PlaneTops::shape_of(const PlaneView& view, std::size_t ring, const Run& run) const {
  const RingGrid& grid = view.grid();
  const Ground& ground = view.ground();
  const float slack = flat_slack + view.links().slack();
  const double middle = static_cast<double>(run.first + run.end) / 2;
  float count = 0, faces = 0, tops = 0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto beyond_nearest = [&](std::size_t c) {
    return view.distance(grid.index(c, ring) - 1) - run.nearest;
  };
  // The columns around the nearest return alone: the feet of two walls that meet have no common bend.
  std::size_t nearest = run.first;
  while (nearest + 1 < run.end && beyond_nearest(nearest) > 0) ++nearest;
  const std::size_t gap = columns_of(view, flat_width, run.nearest);
  std::size_t first = nearest, end = nearest + 1;
  for (std::size_t c = nearest; c-- > run.first && first - c <= gap + 1;) {
    if (beyond_nearest(c) <= slack) first = c;
  }
  for (std::size_t c = nearest + 1; c < run.end && c - end <= gap; ++c) {
    if (beyond_nearest(c) <= slack) end = c + 1;
  }
  for (std::size_t c = first; c < end; ++c) {
    const std::size_t i = grid.index(c, ring) - 1;
    const float beyond = beyond_nearest(c);
    if (beyond > slack) continue;
    ++count;
    const double azimuth = (static_cast<double>(c) - middle) * grid.step();
    const Eigen::Vector3d terms(1, azimuth, azimuth * azimuth);
    normal += terms * terms.transpose();
    sum += terms * static_cast<double>(beyond);
    const std::uint8_t side = run.top >= 0 ? PlaneView::above_it : PlaneView::below;
    const bool same_side = (view.sides()[i + 1] & (PlaneView::both_sides | PlaneView::on_ground)) == side;
    // The return behind may belong to another thing, unless both lie on one level, or the beam passes so low
    // that the nearer thing hardly reaches the plane.
    const float rise = ground.height[i + 1] - ground.height[i];
    const bool may_be_top = rise > -flat_slack &&
                            (rise < flat_slack || (run.top < 0 && passing_over(view, i + 1) < flush)) &&
                            (ring + 1 >= grid.rings() || steps_[i + 2] == step);
    tops += same_side && may_be_top && view.distance(i + 1) - view.distance(i) < deepest_top ? 1.0F : 0.0F;
    if (ring < 2 || grid.kind[i - 1] != Beam::point) continue;
    faces += std::fabs(view.distance(i - 1) - view.distance(i)) < slack ? 1.0F : 0.0F;
  }
  if (count * static_cast<float>(grid.step()) * run.nearest <= flat_width) return Shape::uneven;
  if (2 * tops > count) return Shape::top;
  if (2 * faces > count) return Shape::face;
  // Least squares: distance = constant + slope * azimuth + bend * azimuth^2. The bend of a top is 0, that of
  // a face half the distance.
  const Eigen::Matrix3d inverse = normal.inverse();
  const double bend = inverse.row(2).dot(sum), face = static_cast<double>(run.nearest) / 2;
  const double error = std::sqrt(inverse(2, 2)) * static_cast<double>(view.links().noise());
  if (bend > face / 2) return Shape::face;
  return bend + 3 * error < face ? Shape::top : Shape::top_or_face;
}

void PlaneTops::judge(const PlaneView& view, std::size_t ring, const Run& run) {
  const float room = run.passing - run.top;
  const bool above = run.top >= 0;
  // A higher thing matters where no beam can meet its front.
  const Shape shape = above && ring > 1 ? Shape::uneven : shape_of(view, ring, run);
  Verdict verdict = none;
  if (above)
    verdict = ring == 1 && (shape == Shape::top || shape == Shape::top_or_face) ? top_alone : reaches;
  else if (shape == Shape::top)
    verdict = stays_below;
  else if (shape == Shape::face)
    verdict = none;
  else if (shape == Shape::top_or_face || -run.top > (1 - likely_reach) * room)
    verdict = likely_below;
  else if (-run.top < likely_reach * room)
    verdict = reaches;
  for (std::size_t c = run.first; c < run.end; ++c) {
    const std::size_t i = view.grid().index(c, ring);
    if (shape == Shape::face && !above) steps_[i] = over_face;
    if (verdicts_[i] != hides || verdict == top_alone) verdicts_[i] = verdict;
  }
  // Where the beam above dips beneath the plane the thing ends below it, and so does what is near.
  const std::size_t aside = columns_of(view, same_end, run.nearest);
  std::size_t done = run.first;
  for (std::size_t c = run.first; c < run.end; ++c) {
    if (!(passing_over(view, view.grid().index(c, ring)) <= 0)) continue;
    const std::size_t end = std::min(run.end, c + aside + 1);
    for (done = std::max(done, c > aside ? c - aside : 0); done < end; ++done) {
      std::uint8_t& at = verdicts_[view.grid().index(done, ring)];
      if (at != hides) at = stays_below;
    }
  }
}

}  // namespace lidard
