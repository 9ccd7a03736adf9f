// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/python/capture_reader.h"

#include <algorithm>
#include <sstream>
#include <utility>

#include "daemon/files/json_text.h"
#include "daemon/offline/survey_json.h"
#include "drivers/capture/pcap_source.h"

namespace lidard::python {
namespace {

void add_lines(const std::ostringstream& text, std::vector<std::string>& list) {
  std::istringstream lines(text.str());
  for (std::string line; std::getline(lines, line);) list.push_back(line);
}

}  // namespace

class Decoder final : public FrameReceiver {
 public:
  using AddScan = std::function<void(const std::string&, const PlanarScan&)>;
  using AddCloud = std::function<void(const std::string&, Cloud&)>;

  Decoder(const Model& model, const std::string& name, ClockMode clock, CalibrationPtr calibration,
          AddScan add_scan, AddCloud add_cloud)
      : add_scan_(std::move(add_scan)), add_cloud_(std::move(add_cloud)) {
    config_.model = &model;
    config_.frame_id = name;
    config_.clock = clock;
    config_.keep_partial = true;
    config_.publish_multiecho = model.has(Trait::echoes);
    config_.calibration = std::move(calibration);
    driver_ = model.make(config_);
  }
  void receive(Packet& packet) {
    if (packet.transport == Transport::udp || connection_.pick(packet)) driver_->receive(packet, *this);
  }
  void finish() { driver_->finish(*this); }
  const Model& model() const { return *config_.model; }

  nlohmann::ordered_json json() const {
    return json_of(model().name, driver_->counters(), info_of(*driver_));
  }

 private:
  void scan(PlanarScan& scan) override { add_scan_(config_.frame_id, scan); }
  void cloud(Cloud& cloud) override { add_cloud_(config_.frame_id, cloud); }

  const AddScan add_scan_;
  const AddCloud add_cloud_;
  DriverConfig config_;
  std::unique_ptr<Driver> driver_;
  ConnectionPicker connection_;
};

CaptureReader::CaptureReader(std::vector<std::string> captures, CaptureChoice choice, ClockMode clock)
    : captures_(std::move(captures)), choice_(std::move(choice)), clock_(clock) {
  constexpr Span begin = std::chrono::seconds(5);
  std::ostringstream notes, errors;
  calibration_ = read_calibration(choice_, notes);
  add_lines(notes, warnings_);
  const auto wanted = [this](const Packet& packet) { return choice_.is_wanted(packet); };
  Survey found = survey(captures_, {model_of(choice_), wanted, true, begin});
  is_complete_ = found.sensors.empty() || !found.unknown.empty();
  if (is_complete_) found = survey_of_choice(captures_, choice_, errors);
  add_sensors(found);
  capture_ = std::make_unique<MergedCapture>(captures_);
}

CaptureReader::~CaptureReader() = default;

void CaptureReader::add_sensors(const Survey& survey) {
  for (const FoundSensor& found : survey.sensors) {
    const auto is_same = [&](const FoundSensor& one) { return one.data == found.data; };
    if (std::any_of(sensors_.begin(), sensors_.end(), is_same)) continue;
    FoundSensor sensor = found;
    sensor.name = name_for(*found.model, sensors_);
    std::ostringstream notes;
    decoders_.push_back(std::make_unique<Decoder>(
        *found.model, sensor.name, clock_, calibration_for(choice_, calibration_, *found.model, notes),
        [this](const std::string& name, const PlanarScan& scan) { add(name, scan); },
        [this](const std::string& name, Cloud& cloud) { add(name, cloud, cloud.columns); }));
    sensors_.push_back(std::move(sensor));
    add_lines(notes, warnings_);
  }
  if (calibration_ != nullptr) check_single(captures_, sensors_);
  owners_ = owners_of(sensors_);
}

bool CaptureReader::is_new(const Packet& packet) {
  return !is_complete_ && !packet.payload.empty() && choice_.is_wanted(packet) &&
         owners_.find_receiver(packet) == nullptr;
}

bool CaptureReader::advance() {
  Packet packet;
  if (!capture_->next(packet)) {
    for (const auto& decoder : decoders_) decoder->finish();
    const auto errors = capture_->errors();
    warnings_.insert(warnings_.end(), errors.begin(), errors.end());
    free();
    return false;
  }
  const std::size_t* owner = owners_.find(packet);
  if (owner == nullptr && is_new(packet)) {
    is_complete_ = true;
    std::ostringstream errors;
    add_sensors(survey_of_choice(captures_, choice_, errors));
    owner = owners_.find(packet);
  }
  if (owner != nullptr) decoders_[*owner]->receive(packet);
  return true;
}

std::string CaptureReader::sensors_json() const {
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    all[sensors_[i].name] = decoders_[i]->json();
    all[sensors_[i].name]["sender"] = sensors_[i].data.to_string();
  }
  return json_text(all);
}

LiveReader::LiveReader(const CaptureChoice& choice, ClockMode clock) {
  const Model* const model = model_of(choice);
  if (model == nullptr) throw UsageError("a model is required; expected one of `lidard models`");
  std::ostringstream notes;
  const CalibrationPtr file = read_calibration(choice, notes);
  decoder_ = std::make_unique<Decoder>(
      *model, std::string(model->name), clock, calibration_for(choice, file, *model, notes),
      [this](const std::string& name, const PlanarScan& scan) { add(name, scan); },
      [this](const std::string& name, Cloud& cloud) { add(name, cloud, cloud.columns); });
  add_lines(notes, warnings_);
}

LiveReader::~LiveReader() = default;

std::deque<Frame> LiveReader::feed(ByteView bytes, Stamp arrival, std::uint16_t port) {
  const std::lock_guard lock(mutex_);
  const Model& model = decoder_->model();
  Packet packet;
  packet.payload = bytes;
  packet.arrival = arrival;
  packet.transport = model.transport;
  packet.to.port = port == 0 ? model.port : port;
  packet.stream_start = std::exchange(is_first_, false);
  decoder_->receive(packet);
  return std::exchange(frames(), {});
}

std::deque<Frame> LiveReader::finish() {
  const std::lock_guard lock(mutex_);
  decoder_->finish();
  return std::exchange(frames(), {});
}

std::string LiveReader::sensors_json() const { return json_text(decoder_->json()); }

}  // namespace lidard::python
