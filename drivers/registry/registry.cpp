// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/registry.h"

#include <algorithm>

#include "drivers/hokuyo/models.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/compact/compact_models.h"
#include "drivers/sick/safety/safety_models.h"
#include "drivers/velodyne/models.h"

namespace lidard {

/// In the order of the documentation. Where several recognize a stream, the first counts.
const std::vector<Family>& families() {
  static const std::vector<Family> all = {
      {velodyne::append_models, velodyne::make_recognizer},
      {sick::append_safety_models, sick::make_safety_recognizer},
      {sick::append_cola_models, sick::make_cola_recognizer},
      {sick::append_compact_models, sick::make_compact_recognizer},
      {hokuyo::append_models, hokuyo::make_recognizer},
  };
  return all;
}

const std::vector<Model>& models() {
  static const std::vector<Model> all = [] {
    std::vector<Model> list;
    for (const Family& family : families()) family.append_models(list);
    return list;
  }();
  return all;
}

const Model* find_model(std::string_view name) {
  const auto found =
      std::find_if(models().begin(), models().end(), [&](const Model& model) { return model.name == name; });
  return found == models().end() ? nullptr : &*found;
}

}  // namespace lidard
