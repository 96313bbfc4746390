// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <filesystem>
#include <optional>
#include <string>

#include "base/config/sensor_sheets.hpp"
#include "base/os/result_file.hpp"
#include "libsim/api/plugin.hpp"
#include "plugins/common/result_path.hpp"
#include "plugins/lidar/cloud_file.hpp"
#include "plugins/lidar/lidar_model.hpp"

namespace cas::sim {
namespace {

/// Publishes each scan on topic `lidar`, sends OBSTACLE_DISTANCE after it, and writes scans as
/// files. Writing one takes a millisecond of a step; the files go to the kernel's cache.
class LidarPlugin final : public Plugin {
 public:
  void configure(PluginContext& context, const base::ConfigNode& node) override {
    const base::LidarSheet sheet = base::read_lidar_sheet(node);
    vehicle_ = context.vehicle_id();
    seed_ = context.seed();
    form_ = sheet.cloud;
    every_ = static_cast<std::uint64_t>(sheet.cloud_every);
    if (form_) folder_ = cloud_folder(node, sheet);
    output_ = context.output_dir();
    file_ = context.vehicle_name() + "_";
    restart(parse_lidar_params(node, base::to_seconds(context.step())));
    if (sheet.obstacle_height_m) obstacles_ = context.mavlink();
    cloud_ = context.bus().advertise<PointCloud>(free_topic(context));
    context.expect_rays();
  }

  void pre_step(const StepInfo&, World& world) override { before_ = world.state(vehicle_); }

  void post_step(const StepInfo& step, const World& world) override {
    model_.aim(step.time - step.dt, step.time, before_, world.state(vehicle_));
    if (model_.hits().empty()) return;
    world.cast(vehicle_, model_.origins_W(), model_.directions_W(), reach_m_, model_.hits());
    model_.take_hits();
  }

  void reset() override { restart(model_.params()); }

  std::string stats_json() const override {
    return fmt::format(R"({{"rays":{},"returns":{}}})", model_.rays(), model_.returns());
  }

 private:
  static std::string free_topic(PluginContext& context) {
    int number = 1;
    while (context.bus().is_advertised(context.topic(lidar_topic(number)))) ++number;
    return context.topic(lidar_topic(number));
  }

  static std::filesystem::path cloud_folder(const base::ConfigNode& node,
                                            const base::LidarSheet& sheet) {
    if (const auto key = node.find("cloud_folder")) return result_path(*key);
    return sheet.cloud_folder;
  }

  static const char* ending_of(base::CloudForm form) {
    if (form == base::CloudForm::kPgm) return "pgm";
    return form == base::CloudForm::kPcd ? "pcd" : "ply";
  }

  void restart(LidarParams params) {
    constexpr double kDeviations = 6;  // of noise that may bring a surface into range
    reach_m_ = params.max_m + kDeviations * params.stddev_m;
    model_ = LidarModel(std::move(params), seed_, [this](const LidarScan& scan) { on_scan(scan); });
  }

  void on_scan(const LidarScan& scan) {
    const LidarParams& params = model_.params();
    cloud_.publish({scan.number, scan.begin, scan.p_WS, scan.q_WS, scan.points});
    if (obstacles_) {
      obstacles_->publish(
          mavlink_message(scan.sectors.message(scan.begin, params.min_m, params.max_m)));
    }
    if (!form_ || scan.number % every_ != 0) return;
    const std::string name = fmt::format("{}{:06}.{}", file_, scan.number, ending_of(*form_));
    base::write_result({output_, folder_ / name}, *form_ == base::CloudForm::kPgm
                                                      ? depth_text(scan, *params.picture)
                                                      : cloud_text(scan, *form_));
  }

  VehicleId vehicle_{};
  std::uint64_t seed_ = 0;
  LidarModel model_;
  double reach_m_ = 0;
  BodyState before_;
  Publisher<PointCloud> cloud_;
  std::optional<Publisher<MavlinkMessage>> obstacles_;
  std::optional<base::CloudForm> form_;
  std::uint64_t every_ = 1;
  std::filesystem::path output_;
  std::filesystem::path folder_;
  std::string file_;
};

}  // namespace
}  // namespace cas::sim

CAS_PLUGIN(cas::sim::LidarPlugin, "lidar")
CAS_PLUGIN_SENDS("OBSTACLE_DISTANCE")
