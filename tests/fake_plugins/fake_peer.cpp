// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// A lockstep peer that answers the first `answers` waits and no later one. After a step whose
/// number is divisible by `settles_every` nothing is on its way.
class FakePeer final : public sim::Plugin, private sim::LockstepPeer {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    answers_ = params.require<int>("answers");
    settles_every_ = params.get<std::uint64_t>("settles_every", 1);
    context.set_lockstep_peer(*this);
  }
  void post_step(const sim::StepInfo& step, const sim::World&) override { steps_ = step.index + 1; }
  void reset() override { asked_ = 0; }

 private:
  bool wait_for_controls(base::SimTime, base::Duration) override { return asked_++ < answers_; }
  bool settled() const override { return steps_ % settles_every_ == 0; }

  int answers_ = 0;
  int asked_ = 0;
  std::uint64_t settles_every_ = 1;
  std::uint64_t steps_ = 0;
};

}  // namespace

CAS_PLUGIN(FakePeer, "fake_peer")
