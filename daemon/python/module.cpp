// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstddef>
#include <sstream>

#include "daemon/files/json_text.h"
#include "daemon/log/log.h"
#include "daemon/offline/forecast.h"
#include "daemon/offline/remarks.h"
#include "daemon/offline/survey_json.h"
#include "daemon/python/capture_reader.h"
#include "daemon/python/replay_reader.h"
#include "daemon/yaml/yaml.h"

namespace py = pybind11;

namespace lidard::python {
namespace {

// lidard/__init__.py names these fields.
static_assert(sizeof(CloudColumn) == 24 && offsetof(CloudColumn, packet) == 4 &&
              offsetof(CloudColumn, block) == 8 && offsetof(CloudColumn, echo) == 9 &&
              offsetof(CloudColumn, azimuth) == 12 && offsetof(CloudColumn, stamp) == 16);
static_assert(sizeof(BeamStatus) == 1);

/// An object that frees what arrays stand on when the last of them is dropped.
template <class Owner>
py::capsule capsule_of(Owner owned) {
  auto* const owner = new Owner(std::move(owned));
  return {owner, [](void* held) { delete static_cast<Owner*>(held); }};
}

py::tuple to_python(const Frame& frame, std::unique_ptr<PlanarScan> data) {
  PlanarScan& scan = *data;
  const py::capsule owner = capsule_of(std::move(data));
  const std::vector<std::size_t> shape{scan.echoes, scan.beams};
  // With strides, since pybind11 before 2.12 would read them where numpy 2 has other things.
  const auto array = [&](auto& values) {
    using Value = std::decay_t<decltype(values[0])>;
    using Number = std::conditional_t<std::is_enum_v<Value>, std::uint8_t, Value>;
    const std::vector<std::size_t> strides{scan.beams * sizeof(Value), sizeof(Value)};
    return py::array(py::dtype::of<Number>(), shape, strides, values.data(), owner);
  };
  py::object intensities = py::none();
  if (!scan.intensities.empty()) intensities = array(scan.intensities);
  return py::make_tuple("scan", frame.sensor, frame.topic, scan.frame_id, scan.stamp.ns, array(scan.ranges),
                        intensities, array(scan.statuses), scan.angle_min, scan.angle_increment,
                        scan.time_increment, scan.scan_time, scan.range_min, scan.range_max,
                        py::make_tuple(scan.wave.amplitude, scan.wave.phase));
}

py::tuple to_python(const Frame& frame, CloudFrame cloud) {
  CloudMemory& memory = *cloud.memory;
  const py::capsule owner = capsule_of(std::move(cloud.memory));
  const auto bytes = [&](void* begin, std::size_t size) {
    return py::array(py::dtype::of<std::uint8_t>(), {size}, {std::size_t{1}}, begin, owner);
  };
  return py::make_tuple("cloud", frame.sensor, frame.topic, cloud.frame_id, cloud.stamp.ns, cloud.complete,
                        cloud.has_sensors, cloud.height, bytes(memory.points.data(), memory.points.size()),
                        bytes(memory.columns.data(), memory.columns.size() * sizeof(CloudColumn)));
}

py::object to_python(Frame frame) {
  return std::visit([&](auto& data) { return py::object(to_python(frame, std::move(data))); }, frame.data);
}

py::list to_python(std::deque<Frame> frames) {
  py::list list;
  for (Frame& frame : frames) list.append(to_python(std::move(frame)));
  return list;
}

/// Calls with the lock of Python free: another thread that waits for the source needs it.
template <class Call>
auto unlocked(const Call& call) {
  const py::gil_scoped_release unlock;
  return call();
}

/// Shows the source's sentences as Python warnings, at the line that called the package.
void warn(FrameSource& source) {
  for (const std::string& sentence : unlocked([&] { return source.new_warnings(); })) {
    if (PyErr_WarnEx(PyExc_UserWarning, sentence.c_str(), 2) != 0) throw py::error_already_set();
  }
}

py::object next(FrameSource& source) {
  for (;;) {
    std::optional<Frame> frame = unlocked([&] { return source.next(); });
    if (frame) return to_python(std::move(*frame));
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!unlocked([&] { return source.ended(); })) continue;
    warn(source);
    const std::string error = unlocked([&] { return source.new_error(); });
    if (!error.empty()) throw std::runtime_error(error);
    return py::none();
  }
}

template <class Source, class... Arguments>
std::unique_ptr<Source> open(const Arguments&... arguments) {
  auto source = unlocked([&] { return std::make_unique<Source>(arguments...); });
  warn(*source);
  return source;
}

CaptureChoice choice_of(const std::string& model, const std::string& calibration, const std::string& source) {
  CaptureChoice choice;
  choice.model = model;
  choice.calibration = calibration;
  if (!source.empty() && !choice.parse_source(source))
    throw UsageError("source: '" + source +
                     "' is not an address; expected IP or IP:PORT, e.g. 192.168.1.201");
  return choice;
}

ClockMode clock_of(const std::string& name) {
  if (name == "smooth") return ClockMode::smooth;
  if (name == "arrival") return ClockMode::arrival;
  throw UsageError("clock: '" + name + "'; expected smooth or arrival");
}

std::string check(const std::string& text, const std::string& name) {
  const Config config = parse_config(text, name);
  const EmptyField field(config);
  const std::vector<FieldSight> sights = sights_of(config, field);
  nlohmann::ordered_json out{{"warnings", remarks_on(config)},
                             {"outputs", nlohmann::ordered_json::array()},
                             {"config", to_yaml(config)}};
  for (const auto& more : {host_remarks_on(config), forecast(config, sights)}) {
    for (const std::string& sentence : more) out["warnings"].push_back(sentence);
  }
  for (const FieldSight& sight : sights) {
    nlohmann::ordered_json one{
        {"entry", sight.entry},          {"frame", sight.frame},
        {"topic", sight.topic},          {"free_percent", nullptr},
        {"free_ahead_percent", nullptr}, {"in_the_way", nlohmann::ordered_json::array()}};
    if (sight.came) one["free_percent"] = sight.free.all;
    if (sight.came && sight.free.ahead >= 0) one["free_ahead_percent"] = sight.free.ahead;
    for (const Hindrance& thing : sight.hindrances) one["in_the_way"].push_back(thing.sentence);
    out["outputs"].push_back(one);
  }
  return json_text(out);
}

/// Log lines go to Python's logger `lidard`, which shows warnings on standard error by default.
void log_to_python(LogLevel level, const std::string& text) {
  const py::gil_scoped_acquire lock;
  const char* const name = level == LogLevel::info ? "info" : level == LogLevel::warn ? "warning" : "error";
  try {
    py::module_::import("logging").attr("getLogger")("lidard").attr(name)("%s", text);
  } catch (py::error_already_set& error) {
    error.discard_as_unraisable("lidard's log");
  }
}

/// Errors are ValueErrors with the sentence that the command line has.
void translate(std::exception_ptr thrown) {
  try {
    std::rethrow_exception(std::move(thrown));
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::runtime_error& error) {
    PyErr_SetString(PyExc_ValueError, error.what());
  }
}

}  // namespace

PYBIND11_MODULE(_lidard, module) {
  py::register_local_exception_translator(translate);
  set_log_receiver(log_to_python);
  module.attr("__version__") = LIDARD_VERSION;
  py::class_<FrameSource>(module, "FrameSource")
      .def("next", next)
      .def("sensors", &FrameSource::sensors, py::call_guard<py::gil_scoped_release>())
      .def("close", &FrameSource::close, py::call_guard<py::gil_scoped_release>());
  py::class_<CaptureReader, FrameSource>(module, "CaptureReader")
      .def(py::init([](const std::vector<std::string>& captures, const std::string& model,
                       const std::string& calibration, const std::string& source, const std::string& clock) {
        return open<CaptureReader>(captures, choice_of(model, calibration, source), clock_of(clock));
      }));
  py::class_<ReplayReader, FrameSource>(module, "ReplayReader")
      .def(py::init([](const std::string& text, const std::string& name,
                       const std::vector<std::string>& captures, const std::string& motion,
                       const std::set<std::string>& topics) {
        return open<ReplayReader>(parse_config(text, name), captures, motion, topics);
      }));
  py::class_<LiveReader, FrameSource>(module, "LiveReader")
      .def(py::init([](const std::string& model, const std::string& calibration, const std::string& clock) {
        return open<LiveReader>(choice_of(model, calibration, {}), clock_of(clock));
      }))
      .def("feed",
           [](LiveReader& self, const py::buffer& data, std::int64_t stamp_ns, std::uint16_t port) {
             const py::buffer_info info = data.request();
             const ByteView bytes(static_cast<const std::uint8_t*>(info.ptr),
                                  static_cast<std::size_t>(info.size * info.itemsize));
             return to_python(unlocked([&] { return self.feed(bytes, Stamp{stamp_ns}, port); }));
           })
      .def("finish", [](LiveReader& self) { return to_python(unlocked([&] { return self.finish(); })); });
  module.def("inspect", [](const std::vector<std::string>& captures) {
    return unlocked([&] { return json_text(json_of(survey(captures))); });
  });
  module.def("models", [] { return json_text(json_of_models()); });
  module.def("check", [](const std::string& text, const std::string& name) {
    return unlocked([&] { return check(text, name); });
  });
}

}  // namespace lidard::python
