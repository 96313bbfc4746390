// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/api/plugin.hpp"

extern "C" __attribute__((visibility("default"))) const cas::sim::PluginDescriptor* cas_plugin_v1();

extern "C" const cas::sim::PluginDescriptor* cas_plugin_v1() {
  static const cas::sim::PluginDescriptor descriptor{
      sizeof(cas::sim::PluginDescriptor), "fake_creates_nothing", CAS_ABI_TAG,
      []() -> cas::sim::Plugin* { return nullptr; }, [](cas::sim::Plugin*) {}};
  return &descriptor;
}
