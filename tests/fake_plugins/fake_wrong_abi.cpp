// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fake_plugins/idle.hpp"

extern "C" __attribute__((visibility("default"))) const cas::sim::PluginDescriptor* cas_plugin_v1();

extern "C" const cas::sim::PluginDescriptor* cas_plugin_v1() {
  static const cas::sim::PluginDescriptor descriptor{
      sizeof(cas::sim::PluginDescriptor), "fake_wrong_abi", "gcc4;cas=0.0",
      []() -> cas::sim::Plugin* { return new cas::test::Idle; },
      [](cas::sim::Plugin* p) { delete p; }};
  return &descriptor;
}
