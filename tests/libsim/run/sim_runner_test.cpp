// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/sim_runner.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "libsim/api/messages.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr VehicleId kFirst{0};

std::string figure(const SimRunner& runner, const std::string& name) {
  for (const PluginFigures& figures : runner.plugin_figures()) {
    if (figures.name == name) return figures.json;
  }
  return "none";
}

TEST(SimRunner, CountsTimeOnTheGridOfSteps) {
  SimRunner runner(test::config(test::vehicle("iris0"), "step_us: 250\n"));
  runner.start();
  for (int i = 0; i < 4000; ++i) runner.step();
  EXPECT_EQ(runner.time().time_since_epoch(), 1s);
  EXPECT_EQ(runner.steps(), 4000u);
  EXPECT_EQ(runner.step_size(), 250us);
}

TEST(SimRunner, CallsEachPhaseOncePerStep) {
  SimRunner runner(test::config(test::vehicle("iris0", "{}", "[{plugin: fake_counter}]")),
                   test::fake_plugins());
  runner.start();
  for (int i = 0; i < 10; ++i) runner.step();
  EXPECT_EQ(figure(runner, "fake_counter@iris0"), R"({"pre":10,"post":10,"endpoint":"fake 1"})");
}

TEST(SimRunner, KeepsItsWarningsWithTheVehicleThatTheyAreAbout) {
  const cas::test::TemporaryFolder folder;
  std::string model =
      cas::test::TemporaryFolder::read(test::kSourceDir / "config/vehicles/quad_x.urdf");
  const std::size_t end = model.rfind("</robot>");
  ASSERT_NE(end, std::string::npos);
  model.insert(end,
               "<link name='camera'><inertial><mass value='1e-6'/><inertia ixx='-1' iyy='1' "
               "izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link><joint name='c' "
               "type='fixed'><parent link='base_link'/><child link='camera'/></joint>");
  folder.write("quad_x.urdf", model);
  const auto file = folder.write(
      "quad.yaml",
      cas::test::TemporaryFolder::read(test::kSourceDir / "config/vehicles/quad_x.yaml"));
  const SimRunner runner(test::config(test::vehicle("iris0") + "  - {name: mine, vehicle: " +
                                          file.string() + ", pose: {x_m: 5}, plugins: []}\n",
                                      "", "world: {gravity_m_s2: 32.174, ground: true}\n"));
  ASSERT_EQ(runner.warnings().size(), 2U);
  EXPECT_EQ(runner.warnings()[0].vehicle, "") << "the world's";
  EXPECT_THAT(runner.warnings()[0].sentence, HasSubstr("may be in ft/s^2"));
  EXPECT_EQ(runner.warnings()[1].vehicle, "mine");
  EXPECT_THAT(runner.warnings()[1].sentence, HasSubstr("taken as a point mass"));
}

TEST(SimRunner, WarnsOfWhatIsConnectedToNothing) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner(test::config(test::vehicle("a", "{}", "[{plugin: fake_listener}]") +
                                test::vehicle("b", "{x_m: 5}", "[{plugin: fake_sender}]")),
                   {.output_dir = folder.path(), .plugin_dirs = {test::kFakePluginDir}});
  EXPECT_TRUE(runner.warnings().empty());
  runner.start();
  ASSERT_EQ(runner.warnings().size(), 2U);
  EXPECT_EQ(runner.warnings()[0].vehicle, "b");
  EXPECT_THAT(runner.warnings()[0].sentence,
              HasSubstr("plugin fake_sender@b: its MAVLink messages are not sent"));
  EXPECT_EQ(runner.warnings()[1].vehicle, "a");
  EXPECT_EQ(runner.warnings()[1].sentence, "topic 'a/imu' has subscribers and no publisher");
  runner.step();
  runner.finish();
  EXPECT_EQ(runner.warnings().size(), 2U) << "nothing to say of the contacts";
}

TEST(SimRunner, HostSubscribesBeforeStart) {
  SimRunner runner(test::config(test::vehicle("iris0", "{}", "[{plugin: fake_counter}]")),
                   test::fake_plugins());
  std::vector<base::SimTime> times;
  const auto subscription = runner.bus().subscribe<ImuSample>(
      "iris0/imu", [&](const ImuSample& sample) { times.push_back(sample.time); });
  runner.start();
  runner.step();
  runner.step();
  ASSERT_EQ(times.size(), 2u);
  EXPECT_EQ(times[0].time_since_epoch(), 1ms) << "post_step has the time of the step's end";
  EXPECT_THAT(test::refusal([&] {
                const auto late =
                    runner.bus().subscribe<ImuSample>("iris0/imu", [](const ImuSample&) {});
              }),
              HasSubstr("wired after configure"));
}

TEST(SimRunner, VehiclesHaveTheirOwnTopicsAndSeeds) {
  const std::string plugins = "[{plugin: fake_counter}, {plugin: fake_listener}]";
  SimRunner runner(
      test::config(test::vehicle("a", "{}", plugins) + test::vehicle("b", "{x_m: 3}", plugins)),
      test::fake_plugins());
  double rate_a = -1;
  double rate_b = -1;
  const auto a = runner.bus().subscribe<ImuSample>(
      "a/imu", [&](const ImuSample& s) { rate_a = s.angular_rate_B.x(); });
  const auto b = runner.bus().subscribe<ImuSample>(
      "b/imu", [&](const ImuSample& s) { rate_b = s.angular_rate_B.x(); });
  runner.start();
  runner.step();
  EXPECT_NE(rate_a, rate_b);
  EXPECT_EQ(figure(runner, "fake_listener@b"), R"({"heard":1})");
  EXPECT_EQ(runner.vehicle_names(), (std::vector<std::string>{"a", "b"}));
}

TEST(SimRunner, TwinsOfOnePluginDrawDifferentNumbers) {
  SimRunner runner(test::config(test::vehicle(
                       "a", "{}", "[{plugin: fake_counter}, {plugin: fake_counter, topic: imu2}]")),
                   test::fake_plugins());
  std::vector<double> seeds;
  const auto note = [&](const ImuSample& s) { seeds.push_back(s.angular_rate_B.x()); };
  const auto first = runner.bus().subscribe<ImuSample>("a/imu", note);
  const auto second = runner.bus().subscribe<ImuSample>("a/imu2", note);
  runner.start();
  runner.step();
  ASSERT_EQ(seeds.size(), 2u);
  EXPECT_NE(seeds[0], seeds[1]);
  EXPECT_NE(figure(runner, "fake_counter@a#2"), "none");
}

TEST(SimRunner, ResetFliesTheSameFlightAgain) {
  SimRunner runner(
      test::config(test::vehicle("iris0", "{z_m: 0.2}",
                                 "[{plugin: fake_counter}, {plugin: fake_hover, newton: 18, "
                                 "time_constant_s: 0.1}]")),
      test::fake_plugins());
  std::vector<double> trace;
  const auto subscription = runner.bus().subscribe<ImuSample>(
      "iris0/imu", [&](const ImuSample& s) { trace.push_back(s.specific_force_B.sum()); });
  runner.start();
  for (int i = 0; i < 1500; ++i) runner.step();
  const std::vector<double> first = std::exchange(trace, {});
  EXPECT_GT(runner.world().state(kFirst).p_WB.z(), 0.5);
  runner.reset();
  EXPECT_EQ(runner.time(), base::SimTime{});
  for (int i = 0; i < 1500; ++i) runner.step();
  EXPECT_EQ(trace, first);
}

TEST(SimRunner, FinishTellsPluginsOnce) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner(test::config(test::vehicle("iris0", "{}", "[{plugin: fake_counter}]")),
                   {.output_dir = folder.path(), .plugin_dirs = {test::kFakePluginDir}});
  runner.start();
  runner.finish();
  runner.finish();
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "finished_iris0"));
}

TEST(SimRunner, LockstepCountsStepsWithoutTheirControls) {
  auto config = test::config(test::vehicle("iris0", "{}", "[{plugin: fake_peer, answers: 5}]"),
                             "pacing: {lockstep_timeout_ms: 1}\n");
  config.pace.mode = PaceMode::kLockstep;
  SimRunner runner(std::move(config), test::fake_plugins());
  runner.start();
  for (int i = 0; i < 8; ++i) runner.step();
  EXPECT_EQ(runner.lockstep_timeouts(), 3u);
}

TEST(SimRunner, InterruptEndsALockstepWait) {
  auto config = test::config(test::vehicle("iris0", "{}", "[{plugin: fake_peer, answers: 0}]"),
                             "pacing: {lockstep_timeout_ms: 60000}\n");
  config.pace.mode = PaceMode::kLockstep;
  SimRunner runner(std::move(config), test::fake_plugins());
  std::atomic<bool> interrupt{true};
  runner.set_interrupt(&interrupt);
  runner.start();
  runner.step();
  EXPECT_EQ(runner.lockstep_timeouts(), 1u);
}

TEST(SimRunner, IrisFromItsFilesHovers) {
  SimRunner runner(test::config(test::vehicle(
                       "iris0", "{z_m: 5, yaw_deg: 90}",
                       "[{plugin: fake_hover, newton: 15.2003075, time_constant_s: 0.001}]")),
                   test::fake_plugins());
  runner.start();
  EXPECT_NEAR(runner.world().mass_kg(kFirst), 1.55, 1e-9);
  for (int i = 0; i < 5000; ++i) runner.step();
  EXPECT_NEAR(runner.world().state(kFirst).a_WB.norm(), 0, 1e-6);
}

TEST(SimRunner, HasOneAirForPressureAndDensityOfTheDay) {
  SimRunner runner(
      test::config(test::vehicle("iris0"),
                   "weather: {temperature_degc: 35, qnh_hpa: 1003.25, humidity: 0.8}\n"));
  runner.start();
  runner.step();
  const base::Atmosphere air = runner.world().atmosphere();
  const double alt_m = 488 + runner.world().state(kFirst).p_WB.z();
  EXPECT_NEAR(air.temperature_kelvin(488), 308.15, 1e-9);
  EXPECT_NEAR(air.pressure_pa(488), 100'325 * base::isa::pressure_pa(488) / 101'325, 1e-6);
  const double density = runner.world().environment(kFirst).air_density_kg_m3;
  EXPECT_EQ(density, air.density_kg_m3(alt_m));
  EXPECT_LT(density, 0.92 * base::isa::density_kg_m3(alt_m)) << "hot, humid and low: thin";
}

}  // namespace
}  // namespace cas::sim
