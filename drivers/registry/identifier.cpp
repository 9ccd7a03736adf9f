// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/identifier.h"

#include <algorithm>
#include <array>

#include "drivers/hokuyo/recognizer.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/sick/cola/cola_recognizer.h"
#include "drivers/sick/compact/compact_models.h"
#include "drivers/sick/safety/safety_models.h"
#include "drivers/velodyne/recognizer.h"

namespace lidard {
namespace {

/// Finds the models of one protocol in the packets of one sender.
class Recognizer {
 public:
  virtual ~Recognizer() = default;
  virtual void add(const Packet& packet) = 0;
  virtual const Model* verdict() const = 0;
  virtual std::vector<std::string_view> others() const = 0;
  virtual std::string remark() const = 0;
};

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

template <class Protocol>
auto others_of(const Protocol& protocol, int) -> decltype(protocol.others()) {
  return protocol.others();
}
template <class Protocol>
std::vector<std::string_view> others_of(const Protocol&, long) {
  return {};
}

/// A family's own class with add(packet), verdict() and perhaps others() and remark().
template <class Protocol>
class RecognizerOf final : public Recognizer {
 public:
  void add(const Packet& packet) override { protocol_.add(packet); }
  const Model* verdict() const override { return model_of(protocol_.verdict()); }
  std::vector<std::string_view> others() const override { return others_of(protocol_, 0); }
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
  /// Every product of the rows that fit: a Puck LITE has the row of a VLP-16.
  std::vector<std::string_view> others() const {
    std::vector<const velodyne::ModelRow*> rows = velodyne::Recognizer::others();
    rows.insert(rows.begin(), verdict());
    std::vector<std::string_view> names;
    for (const velodyne::ModelRow* row : rows) {
      for (const Model& model : models()) {
        if (model.row == row) names.push_back(model.name);
      }
    }
    return names;
  }
};

/// Models of one protocol and kind differ in nothing that their telegrams tell.
std::vector<std::string_view> alike(std::string_view verdict) {
  std::vector<std::string_view> names;
  const Model* chosen = model_of(verdict);
  for (const Model& model : models()) {
    if (chosen != nullptr && model.protocol == chosen->protocol && model.kind == chosen->kind)
      names.push_back(model.name);
  }
  return names;
}

class SafetyData {
 public:
  void add(const Packet& packet) {
    found_ = found_ || (packet.transport == Transport::udp && sick::looks_like_ms3(packet.payload));
  }
  std::string_view verdict() const { return found_ ? "sick_microscan3" : ""; }
  std::vector<std::string_view> others() const { return alike(verdict()); }

 private:
  bool found_ = false;
};

class CompactData : public sick::CompactRecognizer {
 public:
  std::vector<std::string_view> others() const { return alike(verdict()); }
};

/// Every protocol that can be recognised. Where several are, the first counts.
constexpr std::array protocols{
    make<VelodyneData>,  //
    make<SafetyData>,    //
    make<sick::ColaRecognizer>, make<hokuyo::Recognizer>, make<CompactData>,
};

/// Names the other models that are decoded differently; empty if there are none.
std::string doubt(const Identifier& identifier, const char* begin) {
  const Model* verdict = identifier.verdict();
  std::string names;
  for (const Model* other : identifier.others()) {
    if (other->row != verdict->row) names += (names.empty() ? "" : ", ") + std::string(other->name);
  }
  if (names.empty()) return {};
  return begin + ("taken for " + std::string(verdict->name)) + ", but nothing in the packets tells it from " +
         names + "; set the model if it is another one";
}

}  // namespace

struct Identifier::Impl {
  std::vector<std::unique_ptr<Recognizer>> recognizers;

  const Recognizer* sure() const;
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

const Recognizer* Identifier::Impl::sure() const {
  const auto found = std::find_if(recognizers.begin(), recognizers.end(),
                                  [](const auto& each) { return each->verdict() != nullptr; });
  return found == recognizers.end() ? nullptr : found->get();
}

const Model* Identifier::verdict() const {
  const Recognizer* recognizer = impl_->sure();
  return recognizer == nullptr ? nullptr : recognizer->verdict();
}

std::vector<const Model*> Identifier::others() const {
  std::vector<const Model*> list;
  const Recognizer* recognizer = impl_->sure();
  if (recognizer == nullptr) return list;
  for (const std::string_view name : recognizer->others()) {
    const Model* model = find_model(name);
    if (model != nullptr && model != recognizer->verdict()) list.push_back(model);
  }
  return list;
}

std::string Identifier::remark() const {
  for (const auto& recognizer : impl_->recognizers) {
    std::string text = recognizer->remark();
    if (!text.empty()) return text + doubt(*this, "; ");
  }
  return doubt(*this, "");
}

}  // namespace lidard
