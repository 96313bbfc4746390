// SPDX-License-Identifier: BSD-3-Clause
#include "hils/timing/echo_stage.hpp"

namespace cas::hils {

void EchoStage::turn(base::RunTime now) {
  if (done_) return;
  if (waiting_ && now - asked_at_ >= kPatience) {
    waiting_ = false;
    line_.forget_open();
    plan(now);
  }
  if (waiting_) return;
  const bool silent = round_trips_.empty() && asked_ >= kEnoughSilence;
  if (now >= end_ || silent) {
    done_ = true;
  } else if (now >= next_) {
    line_.ask(kind_, now);
    ++asked_;
    asked_at_ = now;
    waiting_ = true;
  }
}

void EchoStage::on_answer(std::uint32_t number, base::RunTime now) {
  const auto time = line_.answered(number, now);
  if (!time || !waiting_) return;
  waiting_ = false;
  round_trips_.push_back(*time);
  arrivals_.push_back(now);
  plan(now);
}

void EchoStage::plan(base::RunTime now) {
  next_ = now + kLeastPause + base::from_seconds(random_.uniform() * base::to_seconds(kMorePause));
}

}  // namespace cas::hils
