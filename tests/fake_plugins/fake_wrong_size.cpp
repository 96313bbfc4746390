// SPDX-License-Identifier: BSD-3-Clause
#include "tests/fake_plugins/idle.hpp"

extern "C" __attribute__((visibility("default"))) const cas::sim::PluginDescriptor* cas_plugin_v1();

extern "C" const cas::sim::PluginDescriptor* cas_plugin_v1() {
  static const cas::sim::PluginDescriptor descriptor{
      sizeof(cas::sim::PluginDescriptor) + 8, "fake_wrong_size", CAS_ABI_TAG,
      []() -> cas::sim::Plugin* { return new cas::test::Idle; },
      [](cas::sim::Plugin* p) { delete p; }};
  return &descriptor;
}
