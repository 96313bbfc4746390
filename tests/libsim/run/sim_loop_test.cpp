// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/run/sim_loop.hpp"

#include <gtest/gtest.h>

#include <future>
#include <thread>

#include "tests/libsim/support/sim_files.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::sim {
namespace {

using namespace std::chrono_literals;

/// A loop on a thread of its own, and orders that wait for their end.
class LoopTest : public testing::Test {
 protected:
  void start(PaceMode mode, double speed = 1.0, const std::string& plugins = "[]") {
    SimConfig config = test::config(test::vehicle("iris0", "{z_m: 100}", plugins));
    config.pace.mode = mode;
    config.pace.speed = speed;
    const PaceConfig pace = config.pace;
    runner_ = std::make_unique<SimRunner>(std::move(config), test::fake_plugins());
    runner_->start();
    loop_ = std::make_unique<SimLoop>(*runner_, pace);
    loop_->post([this] { loop_->pause(); });
    thread_ = std::thread([this] { loop_->run(); });
  }
  void TearDown() override {
    loop_->stop();
    thread_.join();
  }

  /// Carries out `order`, which calls its argument when it is done; then takes the figures.
  LoopFigures carry(const std::function<void(std::function<void()>)>& order) {
    std::promise<LoopFigures> figures;
    loop_->post([&] { order([&] { figures.set_value(loop_->figures()); }); });
    return figures.get_future().get();
  }
  LoopFigures look() {
    return carry([](const auto& done) { done(); });
  }

  std::unique_ptr<SimRunner> runner_;
  std::unique_ptr<SimLoop> loop_;
  std::thread thread_;
};

TEST_F(LoopTest, StepsByCountWhilePaused) {
  start(PaceMode::kRealtime);
  EXPECT_EQ(look().steps, 0u);
  const LoopFigures f = carry([this](auto done) { loop_->step(250, done); });
  EXPECT_EQ(f.steps, 250u);
  EXPECT_EQ(f.time.time_since_epoch(), 250ms);
  EXPECT_TRUE(f.paused);
  EXPECT_EQ(look().steps, 250u) << "and no further";
}

TEST_F(LoopTest, RunsUntilATimeAndPauses) {
  start(PaceMode::kFreeRun);
  const LoopFigures f =
      carry([this](auto done) { loop_->run_until(base::SimTime(1234500us), done); });
  EXPECT_EQ(f.time.time_since_epoch(), 1235ms) << "first step that ends at or after it";
  EXPECT_TRUE(f.paused);
  const LoopFigures past = carry([this](auto done) { loop_->run_until(base::SimTime(1s), done); });
  EXPECT_EQ(past.time, f.time) << "a time that has passed is reached at once";
}

TEST_F(LoopTest, PausesInLockstepWhenNothingIsOnItsWay) {
  start(PaceMode::kLockstep, 1.0, "[{plugin: fake_peer, answers: 100000, settles_every: 7}]");
  const LoopFigures f =
      carry([this](auto done) { loop_->run_until(base::SimTime(30ms), std::move(done)); });
  EXPECT_EQ(f.steps, 35u);
  EXPECT_TRUE(f.paused);
}

TEST_F(LoopTest, PausesInLockstepWithAPeerThatNeverAnswers) {
  start(PaceMode::kLockstep, 1.0,
        "[{plugin: fake_peer, answers: 100000, settles_every: 1000000007}]");
  const LoopFigures f =
      carry([this](auto done) { loop_->run_until(base::SimTime(30ms), std::move(done)); });
  EXPECT_EQ(f.time.time_since_epoch(), 230ms);
  EXPECT_TRUE(f.paused);
}

TEST_F(LoopTest, ResetGoesBackToZero) {
  start(PaceMode::kFreeRun);
  carry([this](auto done) { loop_->step(100, done); });
  loop_->post([this] { loop_->reset(); });
  const LoopFigures f = look();
  EXPECT_EQ(f.steps, 0u);
  EXPECT_EQ(f.time, base::SimTime{});
  EXPECT_EQ(f.wall_s, 0.0);
}

TEST_F(LoopTest, PauseDoesNotCountAsLateness) {
  start(PaceMode::kRealtime, 10.0);
  loop_->post([this] { loop_->resume(); });
  ASSERT_TRUE(cas::test::wait_until([this] { return look().steps >= 20; }));
  loop_->post([this] { loop_->pause(); });
  const LoopFigures paused = look();
  EXPECT_TRUE(paused.paused);
  EXPECT_EQ(look().wall_s, paused.wall_s) << "the wall clock of a pause is left out";
}

TEST_F(LoopTest, RealTimeKeepsTheOrderedPace) {
  start(PaceMode::kRealtime, 5.0);
  const LoopFigures f = carry([this](auto done) { loop_->run_until(base::SimTime(1s), done); });
  // Never fast; how slow depends on the machine.
  EXPECT_LT(f.real_time_factor, 5.0 * 1.02);
  EXPECT_GE(f.wall_s, 0.19);
}

TEST_F(LoopTest, AStepCutShortIsStillAnswered) {
  start(PaceMode::kRealtime, 1e-3);  // a step takes a second: run_until cannot get there
  std::promise<void> answered;
  loop_->post([&] { loop_->run_until(base::SimTime(1h), [&] { answered.set_value(); }); });
  loop_->post([this] { loop_->reset(); });
  EXPECT_EQ(answered.get_future().wait_for(20s), std::future_status::ready);
}

}  // namespace
}  // namespace cas::sim
