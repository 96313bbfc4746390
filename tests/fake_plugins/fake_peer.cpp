// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// A lockstep peer that answers the first `answers` waits and no later one.
class FakePeer final : public sim::Plugin, private sim::LockstepPeer {
 public:
  void configure(sim::PluginContext& context, const base::ConfigNode& params) override {
    answers_ = params.require<int>("answers");
    context.set_lockstep_peer(*this);
  }
  void reset() override { asked_ = 0; }

 private:
  bool wait_for_controls(base::SimTime, base::Duration) override { return asked_++ < answers_; }

  int answers_ = 0;
  int asked_ = 0;
};

}  // namespace

CAS_PLUGIN(FakePeer, "fake_peer")
