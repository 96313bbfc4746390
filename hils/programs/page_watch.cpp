// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/page_watch.hpp"

#include <fmt/format.h>

#include <string>

#include "hils/programs/pilot_calls.hpp"

namespace cas::hils {

void PageWatch::before_steps() {
  if (!simulator_.status().paused) {
    said_paused_ = false;
    return;
  }
  if (!said_paused_) {
    said_paused_ = true;
    std::string who = "somebody";
    for (const OutsideCall& call : read_simulator_calls(simulator_.client())) {
      if (call.method == "sim.pause") who = call.client;
    }
    fmt::print(stderr, "hils: paused by {}: the run waits for `sim.resume`\n", who);
  }
  if (live_ == nullptr || !live_->page_has_ended()) return;
  fmt::print(stderr, "hils: casweb has ended, so the page cannot resume the run: it goes on\n");
  live_->resume(simulator_.client());
}

void PageWatch::after_steps(Flight& flight, base::SimTime now, const LiveRun::BeginFault& begin) {
  if (live_ == nullptr || flight.plan.ended()) return;
  if (live_->wants_calls()) live_->show_calls(calls());
  live_->look(now, flight.plan, flight.vehicles, simulator_.start_m());
  live_->play_faults(now, flight.vehicles, flight.faults, simulator_.client(), begin);
}

void PageWatch::before_casd_ends() {
  base::rpc::Client* const casd = casd_();
  if (casd == nullptr) return;
  const std::vector<OutsideCall> calls = read_outside_calls(*casd);
  earlier_.insert(earlier_.end(), calls.begin(), calls.end());
}

std::vector<OutsideCall> PageWatch::finish() {
  std::vector<OutsideCall> all = calls();
  if (live_ != nullptr) live_->show_calls(all);
  return all;
}

std::vector<OutsideCall> PageWatch::calls() {
  std::vector<OutsideCall> all = earlier_;
  const auto add = [&all](const std::vector<OutsideCall>& more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  if (base::rpc::Client* const casd = casd_()) add(read_outside_calls(*casd));
  add(read_simulator_calls(simulator_.client()));
  if (live_ != nullptr) add(live_->calls());
  return all;
}

}  // namespace cas::hils
