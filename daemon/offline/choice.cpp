// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/choice.h"

#include <charconv>
#include <ostream>
#include <stdexcept>

#include "daemon/yaml/yaml.h"
#include "drivers/calibration_file.h"
#include "drivers/config_error.h"
#include "drivers/registry/nearest_models.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// The model's table with the requested equations, if no file is given; nullptr: the driver's default.
CalibrationPtr table_for(const CaptureChoice& choice, const Model& model) {
  if (choice.calibration_model != "ros_drivers") return nullptr;
  if (!model.has(Trait::calibration) || needs_own_calibration(model))
    throw ConfigError("--calibration-model ros_drivers: " + std::string(model.product) +
                      " has no table of its own for it; expected --calibration FILE");
  return std::make_shared<Calibration>(table_calibration(model));
}

std::string list_of(const std::vector<FoundSensor>& sensors) {
  std::string list;
  for (const FoundSensor& sensor : sensors) list += "\n  " + text_of(sensor);
  return list;
}

}  // namespace

bool CaptureChoice::is_wanted(const Packet& packet) const {
  if (source && packet.from.address != *source) return false;
  if (source_port != 0 && packet.from.port != source_port) return false;
  return port == 0 || flow_of(packet).port == port;
}

bool CaptureChoice::parse_source(const std::string& text) {
  const auto colon = text.find(':');
  const bool has_port = colon != std::string::npos && text.find(':', colon + 1) == std::string::npos;
  source = IpAddress::parse(has_port ? text.substr(0, colon) : text);
  if (!source || !has_port) return source.has_value();
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + colon + 1, end, source_port);
  return read.ec == std::errc() && read.ptr == end;
}

std::string text_of(const FoundSensor& sensor) {
  return std::string(sensor.model->name) + " " + sensor.data.to_string();
}

const Model* model_of(const CaptureChoice& choice) {
  if (choice.model.empty()) return nullptr;
  const Model* const model = find_model(choice.model);
  if (model != nullptr) return model;
  const auto near = nearest_models(choice.model);
  throw UsageError("--model: unknown model '" + choice.model + "'; expected one of `lidard models`" +
                   (near.empty() ? "" : ", perhaps " + std::string(near.front())));
}

Survey survey_of_choice(const std::vector<std::string>& captures, const CaptureChoice& choice,
                        std::ostream& err, Span part) {
  const Model* const model = model_of(choice);
  const auto wanted = [&](const Packet& packet) { return choice.is_wanted(packet); };
  Survey found = survey(captures, {model, wanted, true, part});
  if (found.sensors.empty())
    throw std::runtime_error(captures.front() +
                             ": no lidar's packets with this --source and --port, but there are:" +
                             list_of(survey_of_sensors(captures, err, {model, {}, true, part}).sensors));
  for (const SurveyedCapture& capture : found.captures) {
    if (!capture.error.empty()) err << capture.error << '\n';
  }
  return found;
}

void check_single(const std::vector<std::string>& captures, const std::vector<FoundSensor>& sensors) {
  if (sensors.size() > 1)
    throw std::runtime_error(captures.front() + ": " + std::to_string(sensors.size()) +
                             " sensors found; choose one with --source and --port:" + list_of(sensors));
}

Calibration load_calibration(const std::string& path, std::vector<std::string>& warnings) {
  return parse_calibration(read_file(path, calibration_files), path, parse_yaml, warnings);
}

CalibrationPtr read_calibration(const CaptureChoice& choice, std::ostream& err) {
  if (choice.calibration.empty()) return nullptr;
  std::vector<std::string> warnings;
  auto calibration = std::make_shared<Calibration>(load_calibration(choice.calibration, warnings));
  for (const std::string& warning : warnings) err << "note: " << warning << '\n';
  return calibration;
}

CalibrationPtr calibration_for(const CaptureChoice& choice, const CalibrationPtr& file, const Model& model,
                               std::ostream& err) {
  if (file == nullptr) return table_for(choice, model);
  const std::string rejection = calibration_rejection(*file, model);
  if (!rejection.empty())
    throw ConfigError(choice.calibration + ": " + rejection + "; expected the calibration of this sensor");
  const std::string warning = calibration_warning(*file, model);
  if (!warning.empty()) err << "note: " << choice.calibration << ": " << warning << '\n';
  auto settled = std::make_shared<Calibration>(*file);
  settled->model = calibration_model_of(choice.calibration_model).value_or(usual_equations(*file, model));
  return settled;
}

}  // namespace lidard
