// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/registry.h"

#include <algorithm>
#include <string>

#include "drivers/hokuyo/models.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/compact/compact_models.h"
#include "drivers/sick/safety/safety_models.h"
#include "drivers/velodyne/models.h"

namespace lidard {
namespace {

/// A configuration could not distinguish two models of one name.
void require_usable(const std::vector<Model>& added, const std::deque<Model>& known) {
  std::vector<std::string_view> names;
  names.reserve(known.size() + added.size());
  for (const Model& model : known) names.push_back(model.name);
  for (const Model& model : added) {
    if (std::find(names.begin(), names.end(), model.name) != names.end())
      throw std::invalid_argument("there is a model " + std::string(model.name) + " already");
    if (model.make == nullptr)
      throw std::invalid_argument("the model " + std::string(model.name) + " has no driver");
    names.push_back(model.name);
  }
}

struct Registry {
  std::vector<Family> families;
  std::deque<Model> models;

  void add(const Family& family) {
    std::vector<Model> added;
    family.append_models(added);
    require_usable(added, models);
    families.push_back(family);
    models.insert(models.end(), added.begin(), added.end());
  }
};

/// In the order of the documentation. Where several families recognize a stream, the first counts.
Registry& registry() {
  static Registry all = [] {
    Registry known;
    known.add({velodyne::append_models, velodyne::make_recognizer});
    known.add({sick::append_safety_models, sick::make_safety_recognizer});
    known.add({sick::append_cola_models, sick::make_cola_recognizer, &sick::discovery()});
    known.add({sick::append_compact_models, sick::make_compact_recognizer});
    known.add({hokuyo::append_models, hokuyo::make_recognizer, &hokuyo::discovery()});
    return known;
  }();
  return all;
}

}  // namespace

const std::vector<Family>& families() { return registry().families; }

const std::deque<Model>& models() { return registry().models; }

const Model* find_model(std::string_view name) {
  const auto found =
      std::find_if(models().begin(), models().end(), [&](const Model& model) { return model.name == name; });
  return found == models().end() ? nullptr : &*found;
}

void register_family(const Family& family) { registry().add(family); }

}  // namespace lidard
