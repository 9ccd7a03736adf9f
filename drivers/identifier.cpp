// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "drivers/hokuyo/recognizer.h"
#include "drivers/model.h"
#include "drivers/sick/cola_recognizer.h"
#include "drivers/sick/compact_models.h"
#include "drivers/sick/safety_models.h"
#include "drivers/velodyne/recognizer.h"

namespace lidard {
namespace {

/// Finds the models of one protocol in the packets of one sender.
class Recognizer {
 public:
  virtual ~Recognizer() = default;
  virtual void add(const Packet& packet) = 0;
  virtual const Model* verdict() const = 0;
  virtual std::string remark() const = 0;
};

const Model* model_of(const Model* model) { return model; }
/// By name; empty: none.
const Model* model_of(std::string_view name) { return name.empty() ? nullptr : find_model(name); }
const Model* model_of(const velodyne::ModelRow* row) {
  for (const Model& model : models()) {
    if (row != nullptr && model.row == row) return &model;
  }
  return nullptr;
}

template <class Protocol>
auto remark_of(const Protocol& protocol, int) -> decltype(protocol.remark()) {
  return protocol.remark();
}
template <class Protocol>
std::string remark_of(const Protocol&, long) {
  return {};
}

/// A family's own class with add(packet), verdict() and perhaps remark().
template <class Protocol>
class RecognizerOf final : public Recognizer {
 public:
  void add(const Packet& packet) override { protocol_.add(packet); }
  const Model* verdict() const override { return model_of(protocol_.verdict()); }
  std::string remark() const override { return remark_of(protocol_, 0); }

 private:
  Protocol protocol_;
};

template <class Protocol>
std::unique_ptr<Recognizer> make() {
  return std::make_unique<RecognizerOf<Protocol>>();
}

class VelodyneData : public velodyne::Recognizer {
 public:
  void add(const Packet& packet) {
    if (packet.transport == Transport::udp) velodyne::Recognizer::add(packet.payload);
  }
};

class SafetyData {
 public:
  void add(const Packet& packet) {
    found_ = found_ || (packet.transport == Transport::udp && sick::looks_like_ms3(packet.payload));
  }
  std::string_view verdict() const { return found_ ? "sick_microscan3" : ""; }

 private:
  bool found_ = false;
};

/// Every protocol that can be recognised. Where several are, the first counts.
constexpr std::array protocols{
    make<VelodyneData>,  //
    make<SafetyData>,    //
    make<sick::ColaRecognizer>,
    make<hokuyo::Recognizer>,
    make<sick::CompactRecognizer>,
};

}  // namespace

struct Identifier::Impl {
  std::vector<std::unique_ptr<Recognizer>> recognizers;
};

Identifier::Identifier() : impl_(std::make_unique<Impl>()) {
  for (const auto& make_one : protocols) impl_->recognizers.push_back(make_one());
}
Identifier::~Identifier() = default;
Identifier::Identifier(Identifier&&) noexcept = default;
Identifier& Identifier::operator=(Identifier&&) noexcept = default;

void Identifier::add(const Packet& packet) {
  for (const auto& recognizer : impl_->recognizers) recognizer->add(packet);
}

const Model* Identifier::verdict() const {
  for (const auto& recognizer : impl_->recognizers) {
    if (const Model* model = recognizer->verdict()) return model;
  }
  return nullptr;
}

std::string Identifier::remark() const {
  for (const auto& recognizer : impl_->recognizers) {
    std::string text = recognizer->remark();
    if (!text.empty()) return text;
  }
  return {};
}

}  // namespace lidard
