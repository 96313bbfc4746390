// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/hilsim/scene.hpp"

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "base/config/sensor_sheets.hpp"
#include "base/os/log.hpp"
#include "libsim/core/body/world_model.hpp"
#include "libsim/core/load/model_loader.hpp"
#include "libsim/core/load/visuals.hpp"
#include "libsim/hilsim/round_json.hpp"
#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::sim {

namespace {

using Json = nlohmann::json;

constexpr double kLength = 1e-4;  // m, tolerance of a picture
constexpr double kTurn = 1e-6;
constexpr std::size_t kMostDrawnTriangles = 500'000;  // of a vehicle, that a browser still turns

std::string sha256_hex(std::string_view bytes) {
  constexpr const char* kDigits = "0123456789abcdef";
  const mav::Sha256Digest digest =
      mav::Sha256()
          .update({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()})
          .finish();
  std::string text;
  for (const std::uint8_t byte : digest) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 0xFU];
  }
  return text;
}

/// Writes shapes, and keeps the meshes that they name.
class ShapeWriter {
 public:
  explicit ShapeWriter(std::map<std::string, std::string>& meshes) : meshes_(meshes) {}

  Json list(const std::vector<Shape>& shapes) {
    Json parts = Json::array();
    for (const Shape& shape : shapes) parts.push_back(one(shape));
    return parts;
  }

 private:
  Json one(const Shape& shape) {
    Json part{{"name", shape.name},
              {"p", rounded(shape.pose.translation(), kLength)},
              {"q", rounded(Eigen::Quaterniond(shape.pose.linear()), kTurn)}};
    std::visit([&](const auto& geometry) { add(part, geometry); }, shape.geometry);
    return part;
  }

  void add(Json& part, const Box& box) {
    part["shape"] = "box";
    part["size_m"] = rounded(box.size_m, kLength);
  }
  void add(Json& part, const Sphere& sphere) {
    part["shape"] = "sphere";
    part["radius_m"] = rounded(sphere.radius_m, kLength);
  }
  void add(Json& part, const Cylinder& cylinder) {
    part["shape"] = "cylinder";
    part["radius_m"] = rounded(cylinder.radius_m, kLength);
    part["length_m"] = rounded(cylinder.length_m, kLength);
  }
  void add(Json& part, const Plane&) { part["shape"] = "plane"; }
  void add(Json& part, const Mesh& mesh) {
    std::string& hash = hashes_[mesh.triangles];  // shapes share meshes
    if (hash.empty()) {
      std::string bytes = mesh_bytes(*mesh.triangles);
      hash = sha256_hex(bytes);
      meshes_.emplace(hash, std::move(bytes));
    }
    part["shape"] = "mesh";
    part["mesh"] = "sha256:" + hash;
  }

  std::map<std::string, std::string>& meshes_;
  std::map<std::shared_ptr<const TriangleMesh>, std::string> hashes_;
};

Json rotors_json(const base::Vehicle& vehicle) {
  Json rotors = Json::array();
  for (const base::Rotor& rotor : vehicle.rotors) {
    rotors.push_back({{"p_B", rounded(rotor.position_B_m, kLength)},
                      {"axis_B", rounded(rotor.axis_B, kTurn)},
                      {"radius_m", rounded(rotor.params.radius_m, kLength)},
                      {"spin", rotor.spin},
                      {"k_f", rotor.params.thrust_coefficient},
                      {"k_m", rotor.params.torque_coefficient},
                      {"omega_max_rad_s", rotor.params.omega_max_rad_s}});
  }
  return rotors;
}

/// The beams of the vehicle's rangefinder plugins, which have read the same sheets.
Json rays_json(const VehicleConfig& vehicle) {
  Json rays = Json::array();
  for (const PluginConfig& plugin : vehicle.plugins) {
    if (plugin.plugin != kRangefinder) continue;
    const base::RangefinderSheet sheet = base::read_rangefinder_sheet(plugin.params);
    rays.push_back({{"name", plugin.plugin},
                    {"p_B", rounded(sheet.position_B_m, kLength)},
                    {"dir_B", rounded(sheet.direction_B, kTurn)},
                    {"max_m", sheet.max_m}});
  }
  return rays;
}

/// Adds to the visuals which of them turn with a control surface.
void add_surfaces(Json& visuals, const std::vector<Shape>& shapes, const base::AeroParams& aero) {
  for (const DrawnSurface& drawn : drawn_surfaces(shapes, aero)) {
    visuals[drawn.visual]["surface"] = {{"index", drawn.surface}, {"sign", drawn.sign}};
  }
}

}  // namespace

Scene::Scene(const SimRunner& runner) {
  ShapeWriter shapes(meshes_);
  const base::Geodetic& home = runner.world().projection().home();
  Json scene{
      {"frame", "W"},
      {"home", {{"lat_deg", home.lat_deg}, {"lon_deg", home.lon_deg}, {"alt_m", home.alt_m}}},
      {"vehicles", Json::array()},
      {"world", shapes.list(drawn_world(runner.world_model()))},
      {"obstacles", Json::array()}};
  for (std::size_t i = 0; i < runner.config().vehicles.size(); ++i) {
    const VehicleConfig& vehicle = runner.config().vehicles[i];
    const VehicleModel& model = runner.vehicle_models()[i];
    std::vector<std::string> warnings;
    const auto& aero = vehicle.vehicle.aero;
    const std::vector<Shape> visuals =
        load_visuals(model, aero.has_value(), kMostDrawnTriangles, warnings);
    for (const std::string& warning : warnings) base::log::warn(warning);
    Json drawn = shapes.list(visuals);
    if (aero) add_surfaces(drawn, visuals, *aero);
    scene["vehicles"].push_back({{"name", vehicle.name},
                                 {"type", vehicle.vehicle.name},
                                 {"system", vehicle.vehicle.system_id},
                                 {"mass_kg", model.mass.mass_kg()},
                                 {"parts", shapes.list(model.shapes)},
                                 {"visuals", std::move(drawn)},
                                 {"rotors", rotors_json(vehicle.vehicle)},
                                 {"rays", rays_json(vehicle)}});
  }
  for (const MovingObstacle& obstacle : runner.world_model().moving) {
    scene["obstacles"].push_back(
        {{"name", obstacle.name}, {"parts", shapes.list(obstacle.shapes)}});
  }
  scene["hash"] = sha256_hex(scene.dump(-1, ' ', false, Json::error_handler_t::replace));
  json_ = std::make_unique<const Json>(std::move(scene));
}

Scene::~Scene() = default;

const std::string* Scene::mesh(const std::string& hash) const {
  const auto found = meshes_.find(hash);
  return found == meshes_.end() ? nullptr : &found->second;
}

}  // namespace cas::sim
