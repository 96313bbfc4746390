// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "base/random.hpp"
#include "hils/timing/echo_figures.hpp"
#include "hils/timing/probe_stage.hpp"

namespace cas::hils {

/// Round trips on a line without load: one question at a time, each 5 to 15 ms after the answer
/// before, at random, so that frames of the line show in the arrivals.
class EchoStage final : public ProbeStage {
 public:
  EchoStage(ProbeLine& line, QuestionKind kind, base::Duration length, std::uint64_t seed,
            base::RunTime begin)
      : line_(line), kind_(kind), random_(seed), end_(begin + length), next_(begin) {}

  void turn(base::RunTime now) override;
  void on_answer(std::uint32_t number, base::RunTime now) override;
  void on_read(std::size_t, base::RunTime) override {}
  base::RunTime wake() const override { return waiting_ ? asked_at_ + kPatience : next_; }
  bool done() const override { return done_; }

  EchoFigures figures() const { return echo_figures(asked_, round_trips_); }
  /// Times at which answers arrived.
  const std::vector<base::RunTime>& arrivals() const { return arrivals_; }

 private:
  /// A board that has not answered so many does not know the message.
  static constexpr std::size_t kEnoughSilence = 2;
  static constexpr base::Duration kLeastPause = std::chrono::milliseconds(5);
  static constexpr base::Duration kMorePause = std::chrono::milliseconds(10);

  void plan(base::RunTime now);

  ProbeLine& line_;
  QuestionKind kind_;
  base::NormalRandom random_;
  base::RunTime end_;
  base::RunTime next_;
  base::RunTime asked_at_{};
  bool waiting_ = false;
  bool done_ = false;
  std::size_t asked_ = 0;
  std::vector<base::Duration> round_trips_;
  std::vector<base::RunTime> arrivals_;
};

}  // namespace cas::hils
