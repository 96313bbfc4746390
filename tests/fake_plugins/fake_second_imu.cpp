// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

namespace {

/// Declares a message that is the loop's own.
class FakeSecondImu final : public cas::sim::Plugin {
 public:
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode&) override {}
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(FakeSecondImu, "fake_second_imu")
CAS_PLUGIN_SENDS("HIL_SENSOR")
