// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "libsim/api/plugin.hpp"

namespace cas::test {

/// A plugin that does nothing.
class Idle final : public sim::Plugin {
 public:
  void configure(sim::PluginContext&, const base::ConfigNode&) override {}
  void reset() override {}
};

}  // namespace cas::test
