// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "libsim/core/run/sim_loop.hpp"
#include "libsim/core/run/sim_runner.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {

/// State of the simulation at one moment.
struct SimTruth {
  sim::LoopFigures figures;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  std::string stats;  ///< of the interface plugin
};

/// A shipped world on a thread of its own, with its interface on a free port.
class RunningSimulation {
 public:
  /// @param interface  the plugin whose address is replaced
  /// @param overrides  YAML laid over that plugin's parameters
  RunningSimulation(const std::string& world_file, const std::string& interface,
                    const std::string& overrides, std::optional<double> speed = std::nullopt)
      : interface_(interface) {
    sim::SimConfig config = sim::SimConfig::load(std::filesystem::path(cas::test::source_dir()) /
                                                 "config/worlds" / world_file);
    for (sim::PluginConfig& plugin : config.vehicles.at(0).plugins) {
      if (plugin.plugin != interface) continue;
      plugin.params = base::ConfigNode::parse(overrides, "test").merged_over(plugin.params);
    }
    config.pace.speed_given = speed.has_value();
    config.pace.speed = speed.value_or(1.0);
    runner_ = std::make_unique<sim::SimRunner>(
        std::move(config),
        sim::SimOptions{
            .output_dir = ".",
            .plugin_dirs = {std::filesystem::path(cas::test::binary_dir()) / "plugins"}});
    runner_->start();
    loop_ = std::make_unique<sim::SimLoop>(*runner_, runner_->config().pace);
    endpoint_ = endpoint();
    thread_ = std::thread([this] { loop_->run(); });
  }
  ~RunningSimulation() {
    loop_->stop();
    thread_.join();
  }
  RunningSimulation(const RunningSimulation&) = delete;
  RunningSimulation& operator=(const RunningSimulation&) = delete;

  std::uint16_t port() const {
    return static_cast<std::uint16_t>(std::stoi(endpoint_.substr(endpoint_.rfind(':') + 1)));
  }
  /// Between two steps, while the loop runs.
  SimTruth look() {
    std::promise<SimTruth> answer;
    loop_->post([&] {
      answer.set_value({loop_->figures(), runner_->world().state(sim::VehicleId{0}).p_WB, stats()});
    });
    return answer.get_future().get();
  }
  sim::SimLoop& loop() { return *loop_; }

 private:
  std::string stats() const {
    for (const sim::PluginFigures& figures : runner_->plugin_figures()) {
      if (figures.name.starts_with(interface_)) return figures.json;
    }
    return {};
  }
  std::string endpoint() const {
    const std::string text = stats();
    const std::string key = "\"endpoint\":\"";
    const std::size_t start = text.find(key) + key.size();
    return text.substr(start, text.find('"', start) - start);
  }

  std::string interface_;
  std::unique_ptr<sim::SimRunner> runner_;
  std::unique_ptr<sim::SimLoop> loop_;
  std::string endpoint_;
  std::thread thread_;
};

}  // namespace cas::test
