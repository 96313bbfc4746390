// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/bench_programs.hpp"

#include <chrono>

namespace cas::hils {

namespace {

constexpr base::Duration kStopPatience = std::chrono::seconds(10);

}  // namespace

void BenchPrograms::start(bool paused) {
  for (std::size_t i = 0; i < paths_.vehicles.size(); ++i) {
    if (request_.fcu_device(i) == nullptr) launch_emulator(paths_.vehicles[i]);
  }
  if (paused) programs_.launch_hilsim({"--paused"});  // it sends nothing yet: it loads meanwhile
  for (const ChildProcess* emulator : emulators_)
    supervisor_.wait_ready(*emulator, Supervisor::kReadyTimeout);
  programs_.start_first_casd();
  if (!paused) programs_.launch_hilsim();
  supervisor_.wait_ready(*programs_.hilsim(), Supervisor::kReadyTimeout);
}

void BenchPrograms::launch_emulator(const VehiclePaths& paths) {
  emulators_.push_back(&supervisor_.launch(programs_.options(
      paths.emulator(),
      {sibling_program("fcu_emulator"), paths.fcu_config(), "--stats",
       paths_.run / (paths.emulator() + "_stats.json"), "--link", paths.fcu_link(), "--ledger",
       paths.controller_ledger(), "--control", paths.fcu_control()})));
}

void BenchPrograms::stop(bool nothing_under_way) {
  using Turn = std::vector<ChildProcess*>;
  ChildProcess* const hilsim = programs_.hilsim();
  ChildProcess* const casd = programs_.casd();
  const std::vector<Turn> turns = nothing_under_way
                                      ? std::vector<Turn>{{hilsim, casd}, emulators_}
                                      : std::vector<Turn>{{hilsim}, {casd}, emulators_};
  for (Turn turn : turns) {
    std::erase(turn, nullptr);
    const ChildProcess* bad = supervisor_.stop(turn, kStopPatience);
    if (bad == nullptr) continue;
    throw RunStopped(bad->name() + " did not end in good order; its last lines:" + bad->log_tail(),
                     false);
  }
  programs_.join_logs();
}

}  // namespace cas::hils
