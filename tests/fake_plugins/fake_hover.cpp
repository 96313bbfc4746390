// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/messages.hpp"
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// Thrust of `newton` along z of B, reached with a lag of `time_constant_s`.
class FakeHover final : public sim::Plugin, private sim::ForceModel {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    newton_ = params.require<double>("newton");
    time_constant_ = params.require_in("time_constant_s", 1e-3, 10);
    context.add_force_model(*this);
  }
  void reset() override {}

 private:
  int state_count() const override { return 1; }
  void initial_states(std::span<double> x) const override { x[0] = 0; }
  void evaluate(const sim::BodyState&, const sim::Environment&, std::span<const double> x,
                std::span<double> x_dot, sim::Wrench& wrench) const override {
    x_dot[0] = (newton_ - x[0]) / time_constant_;
    wrench.force_B.z() += x[0];
  }

  double newton_ = 0;
  double time_constant_ = 1;
};

}  // namespace

CAS_PLUGIN(FakeHover, "fake_hover")
