// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "libsim/core/run/sim_runner.hpp"

namespace cas::sim {

/// The objects of a run, for drawing: the answer to `sim.scene`, made of the models that the
/// physics uses, and the meshes that it names by their SHA-256.
class Scene {
 public:
  /// Reads only data that never change after SimRunner::start(): from any thread.
  explicit Scene(const SimRunner& runner);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  const nlohmann::json& json() const { return *json_; }
  /// mesh_bytes() of a mesh, nullptr for an unknown hash.
  const std::string* mesh(const std::string& hash) const;

 private:
  std::map<std::string, std::string> meshes_;  // bytes by hash
  std::unique_ptr<const nlohmann::json> json_;
};

}  // namespace cas::sim
