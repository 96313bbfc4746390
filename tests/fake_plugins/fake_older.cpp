// SPDX-License-Identifier: BSD-3-Clause
// Of the ABI of CAS 0.1.0, whose vehicles had four rotors.
#include "libsim/api/plugin.hpp"

#undef CAS_ABI_TAG
#define CAS_ABI_TAG CAS_ABI_BUILD ";cas=0.1"

namespace {

class Idle final : public cas::sim::Plugin {
 public:
  void configure(cas::sim::PluginContext&, const cas::base::ConfigNode&) override {}
  void reset() override {}
};

}  // namespace

CAS_PLUGIN(Idle, "fake_older")
