// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/plugin_loader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "libsim/core/run/sim_runner.hpp"
#include "tests/libsim/support/sim_files.hpp"

namespace cas::sim {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(PluginLoader, MakesPluginsThatOutliveTheLoader) {
  PluginPtr plugin;
  {
    PluginLoader loader({test::kFakePluginDir});
    plugin = loader.create("fake_counter");
    EXPECT_NE(loader.create("fake_counter"), plugin);
  }
  EXPECT_EQ(plugin->stats_json(), R"({"pre":0,"post":0,"endpoint":"fake 1"})");
}

TEST(PluginLoader, RefusesAPluginOfTheVersionBeforeWhoseVehicleIsAnother) {
  PluginLoader loader({test::kFakePluginDir});
  EXPECT_THAT(test::refusal([&] { loader.create("fake_older"); }), HasSubstr("rebuild it"));
}

TEST(PluginLoader, ReadsWhatAPluginDeclaresToSend) {
  PluginLoader loader({test::kFakePluginDir});
  EXPECT_EQ(loader.sends("fake_sender"),
            (std::vector<std::string>{"147", "HIL_OPTICAL_FLOW", "OPTICAL_FLOW"}));
  EXPECT_TRUE(loader.sends("fake_counter").empty());
  EXPECT_THAT(test::refusal([&] { loader.sends("fake_absent"); }), HasSubstr("fake_absent"));
}

TEST(Refusal, SaysWhatIsWrongWithWhichFile) {
  struct RefusalCase {
    const char* plugin;
    const char* because;
  };
  const RefusalCase rows[] = {{"fake_wrong_abi", "was built for 'gcc4;cas=0.0', this program for"},
                              {"fake_wrong_size", "built against another version of CAS"},
                              {"fake_other_name", "calls itself 'somebody_else'"},
                              {"fake_no_create", "lacks create or destroy"},
                              {"fake_no_entry", "has no symbol cas_plugin_v1"},
                              {"fake_no_descriptor", "returns no descriptor"},
                              {"fake_not_elf", "cannot be opened"},
                              {"fake_throws_in_create", "no memory of its own"},
                              {"fake_creates_nothing", "create made nothing"},
                              {"fake_absent", "no libfake_absent.so in "},
                              {"fake_wrong_siez", "; did you mean 'fake_wrong_size'?"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.plugin);
    PluginLoader loader({test::kFakePluginDir});
    const std::string message = test::refusal([&] { loader.create(row.plugin); });
    EXPECT_THAT(message, AllOf(HasSubstr(row.plugin), HasSubstr(row.because)));
  }
}

TEST(PluginLoader, TakesNamesNotPaths) {
  PluginLoader loader({test::kFakePluginDir});
  for (const char* name : {"../fake_plugins/fake_counter", "", "/lib/x", "a b"}) {
    EXPECT_THAT(test::refusal([&] { loader.create(name); }), HasSubstr("is named by letters"));
  }
}

TEST(PluginLoader, ConfigureFailuresNamePluginAndVehicle) {
  const auto start = [](const std::string& plugins) {
    SimRunner runner(test::config(test::vehicle("iris0", "{}", plugins)), test::fake_plugins());
    runner.start();
  };
  EXPECT_THAT(test::refusal([&] { start("[{plugin: fake_throws_in_configure}]"); }),
              AllOf(HasSubstr("fake_throws_in_configure@iris0"), HasSubstr("sensor is not there")));
  EXPECT_THAT(test::refusal([&] { start("[{plugin: fake_throws_in_configure, odd: true}]"); }),
              HasSubstr("unknown exception"));
  EXPECT_THAT(test::refusal([&] { start("[{plugin: fake_refuses_params}]"); }),
              AllOf(HasSubstr("sim.yaml:"), HasSubstr("'rate_hz' is missing")));
  EXPECT_THAT(test::refusal([&] { start("[{plugin: fake_refuses_params, rate_hz: 5, rat: 1}]"); }),
              AllOf(HasSubstr("fake_refuses_params@iris0"), HasSubstr("rat: unknown key")));
}

TEST(PluginLoader, AnAbsentPluginIsRefusedWithTheLineThatNamesIt) {
  const auto start = [] {
    SimRunner runner(test::config(test::vehicle("iris0", "{}", "[{plugin: fake_absent}]")),
                     test::fake_plugins());
    runner.start();
  };
  EXPECT_THAT(test::refusal(start),
              AllOf(HasSubstr("sim.yaml:"), HasSubstr("vehicles[0].plugins[0].plugin: "),
                    HasSubstr("no libfake_absent.so in ")));
}

}  // namespace
}  // namespace cas::sim
