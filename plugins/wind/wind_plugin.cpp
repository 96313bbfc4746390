// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "base/config/install_paths.hpp"
#include "base/earth/frames.hpp"
#include "base/os/log.hpp"
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/wind/wind_grid.hpp"
#include "plugins/wind/wind_model.hpp"

namespace cas::sim {
namespace {

/// Moves the air around its vehicle, besides the wind of the world; starts the gusts that topic
/// `gust` asks for.
class WindPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& params) override {
    vehicle_ = context.vehicle_id();
    initial_ = WindModel(parse_wind_params(params), context.seed());
    model_ = initial_;
    if (const auto grid = params.find("grid")) grid_ = WindGrid::load(base::find_config(*grid));
    gusts_ = context.bus().subscribe<GustCommand>(
        context.topic("gust"), [this](const GustCommand& gust) { start(gust); }, Need::kOptional);
  }

  void pre_step(const StepInfo& step, World& world) override {
    const BodyState& body = world.state(vehicle_);
    // Before the first step the vehicle's wind is still the world's.
    if (!world_wind_W_) world_wind_W_ = world.environment(vehicle_).wind_W;
    Eigen::Vector3d field_W = *world_wind_W_;
    if (grid_) field_W += grid_->at(body.p_WB);
    const double height = world.environment(vehicle_).height_above_ground_m;
    const Eigen::Vector3d wind_N =
        model_.advance_N(step.time, base::to_seconds(step.dt),
                         std::isfinite(height) ? height : body.p_WB.z(),  // over nothing
                         base::swap_WN(body.v_WB), base::swap_WN(field_W));
    world.set_wind_W(vehicle_, base::swap_WN(wind_N));
    if (model_.span_m() > 0) world.set_wind_gradient_W(vehicle_, gradient_W(body.p_WB));
  }

  void reset() override {
    model_ = initial_;
    left_out_ = 0;
  }

  std::string stats_json() const override {
    if (left_out_ == 0) return {};
    nlohmann::json figures;
    figures["warnings"].push_back(std::string(kLeftOut) + ": " + std::to_string(left_out_));
    return figures.dump();
  }

 private:
  /// Gradient of the wind at a place, 1/s; the grid's part is the mean over the vehicle's span.
  Eigen::Matrix3d gradient_W(const Eigen::Vector3d& p_W) const {
    Eigen::Matrix3d swap_WN;
    swap_WN << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    Eigen::Matrix3d gradient = swap_WN * model_.gradient_N() * swap_WN;
    if (!grid_) return gradient;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d half = 0.5 * model_.span_m() * Eigen::Vector3d::Unit(axis);
      gradient.col(axis) += (grid_->at(p_W + half) - grid_->at(p_W - half)) / model_.span_m();
    }
    return gradient;
  }

  static constexpr const char* kLeftOut =
      "plugin wind: gusts that are left out, because as many blow already as it has room for";

  void start(const GustCommand& gust) {
    if (!model_.start(gust) && left_out_++ == 0) base::log::warn(kLeftOut);
  }

  VehicleId vehicle_{};
  WindModel initial_;
  WindModel model_;
  int left_out_ = 0;  ///< gusts
  std::optional<WindGrid> grid_;
  std::optional<Eigen::Vector3d> world_wind_W_;
  Subscription gusts_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::WindPlugin, "wind")
