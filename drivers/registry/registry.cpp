// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/registry.h"

#include "drivers/hokuyo/scip_models.h"
#include "drivers/hokuyo/uam_driver.h"
#include "drivers/model.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/compact/compact_models.h"
#include "drivers/sick/safety/safety_models.h"
#include "drivers/velodyne/models.h"

namespace lidard {

const std::vector<Model>& models() {
  static const std::vector<Model> all = [] {
    std::vector<Model> list;
    velodyne::append_models(list);
    sick::append_safety_models(list);
    sick::append_cola_models(list);
    sick::append_compact_models(list);
    hokuyo::append_scip_models(list);
    hokuyo::append_uam_models(list);
    return list;
  }();
  return all;
}

const Model* find_model(std::string_view name) {
  for (const Model& model : models()) {
    if (model.name == name) return &model;
  }
  return nullptr;
}

}  // namespace lidard
