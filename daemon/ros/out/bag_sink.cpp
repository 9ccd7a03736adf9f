// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/bag_sink.h"

#include <ros/exception.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/ros/messages/bags_module.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {

/// Gives up a bag that cannot be written: its destructor writes the rest, and an exception there would end
/// the process.
void BagSink::give_up(const std::exception& problem, int error_number) {
  static auto* const broken = new std::vector<std::unique_ptr<BagFile>>;
  const std::string why = error_number != 0 ? std::strerror(error_number) : problem.what();
  if (error_.empty())
    error_ = "cannot write bag '" + path_ + "': " + why + "; choose a writable path with enough space";
  broken->push_back(std::move(bag_));
}

template <class Step>
bool BagSink::attempt(const Step& step) {
  errno = 0;
  try {
    step();
    return true;
  } catch (const ros::Exception& problem) {
    give_up(problem, errno);
    return false;
  }
}

void BagSink::write(const std::string& topic, Stamp released, const RawMessage& message, bool latched) {
  const std::string name = (topic.compare(0, 1, "/") == 0 ? "" : "/") + topic;
  // A bag refuses the time 0 (ros::TIME_MIN).
  const ros::Time time = std::max(to_ros(clock_.host(released)), ros::TIME_MIN);
  if (bag_ && attempt([&] { bag_->write(name, time, message, latched); })) ++messages_;
}

BagSink::BagSink(const std::string& path) : path_(path) {
  const auto open = bags_function<decltype(lidard_write_bag)>("lidard_write_bag");
  if (!attempt([&] { bag_.reset(open(path)); })) throw BagError(error_);
}

BagSink::~BagSink() {
  try {
    close();
  } catch (const BagError&) {
    // A destructor cannot report errors; close() does.
  }
}

void BagSink::publish(const OutputTopic& topic, const Frame& frame, Stamp released) {
  auto& maker = makers_[topic.name];
  if (maker == nullptr) maker = row_of(topic).maker();
  write(topic.name, released, maker->make(frame, released, clock_));
}

void BagSink::transforms(const std::vector<StaticTransform>& transforms, Stamp released) {
  if (!transforms.empty())
    write("/tf_static", released, transforms_maker()->make(transforms, released, clock_), true);
}

void BagSink::diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) {
  if (items.empty()) return;
  diagnostic_msgs::DiagnosticArray message;
  to_ros(items, "lidard", clock_.host(released), message);
  write("/diagnostics", released, raw(message));
}

void BagSink::outline(const VehicleConfig& vehicle, Stamp released) {
  if (!vehicle.footprint.empty()) write(outline_topic, released, outline_of(vehicle), true);
}

void BagSink::close() {
  if (bag_ && attempt([&] { bag_->close(); })) bag_.reset();
  if (!error_.empty()) throw BagError(error_);
}

}  // namespace lidard
