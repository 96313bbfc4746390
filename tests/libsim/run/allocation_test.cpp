// SPDX-License-Identifier: BSD-3-Clause
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "libsim/core/run/sim_runner.hpp"
#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

// Counts heap allocations of the whole process, libraries and plugins included.
namespace {

std::atomic<bool> counting{false};
std::atomic<std::uint64_t> allocations{0};

}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);

__attribute__((visibility("default"))) void* malloc(std::size_t size) {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
  return __libc_malloc(size);
}
__attribute__((visibility("default"))) void* calloc(std::size_t count, std::size_t size) {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
  return __libc_calloc(count, size);
}
__attribute__((visibility("default"))) void* realloc(void* memory, std::size_t size) {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
  return __libc_realloc(memory, size);
}
__attribute__((visibility("default"))) void* aligned_alloc(std::size_t alignment,
                                                           std::size_t size) {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
  return __libc_memalign(alignment, size);
}
}

namespace cas::sim {
namespace {

const std::filesystem::path kPlugins = std::filesystem::path(cas::test::binary_dir()) / "plugins";
const std::string kAllSensors =
    "[{plugin: motor}, {plugin: imu}, {plugin: gps}, {plugin: magnetometer}, {plugin: barometer}, "
    "{plugin: mavlink_interface, transport: bus, system_id: 1, component_id: 200}]";

/// Steps until nothing new comes up, then counts over `steps`.
std::uint64_t count_in_steps(SimRunner& runner, int warm_up, int steps) {
  for (int i = 0; i < warm_up; ++i) runner.step();
  allocations = 0;
  counting = true;
  for (int i = 0; i < steps; ++i) runner.step();
  counting = false;
  return allocations;
}

SimRunner make(const std::string& vehicles, const cas::test::TemporaryFolder& folder) {
  return SimRunner(test::config(vehicles),
                   {.output_dir = folder.path(), .plugin_dirs = {kPlugins, test::kFakePluginDir}});
}

TEST(Allocation, TheCounterCounts) {
  allocations = 0;
  counting = true;
  std::free(std::malloc(1));
  delete new std::string(100, 'x');
  counting = false;
  EXPECT_GE(allocations, 3u);
}

TEST(Allocation, AStepInFlightTakesNothingFromTheHeap) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner = make(test::vehicle("a", "{z_m: 500}", kAllSensors) +
                              test::vehicle("b", "{x_m: 5, z_m: 500}", kAllSensors),
                          folder);
  runner.start();
  EXPECT_EQ(count_in_steps(runner, 2000, 5000), 0u);
}

TEST(Allocation, AStepOnTheGroundTakesNothingFromTheHeap) {
  const cas::test::TemporaryFolder folder;
  SimRunner runner = make(test::vehicle("a", "{z_m: 0.1}", kAllSensors), folder);
  runner.start();
  EXPECT_EQ(count_in_steps(runner, 2000, 5000), 0u);
}

TEST(Allocation, AStepInContactTakesNothingFromTheHeap) {
  // Lifts off and lands, over and over: the contact solver is at work.
  const cas::test::TemporaryFolder folder;
  SimRunner runner =
      make(test::vehicle("a", "{}",
                         "[{plugin: fake_counter}, {plugin: fake_hover, newton: 15.19, "
                         "time_constant_s: 1.0}]"),
           folder);
  runner.start();
  EXPECT_EQ(count_in_steps(runner, 500, 5000), 0u);
  EXPECT_TRUE(runner.world().in_contact(VehicleId{0}));
}

}  // namespace
}  // namespace cas::sim
