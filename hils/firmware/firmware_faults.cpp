// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/firmware_faults.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <variant>

#include "hils/programs/pilot_calls.hpp"

namespace cas::hils {
namespace {

using base::rpc::Json;

/// A restored link, or a restarted casd, gets the next HEARTBEAT within a second; a USB port may
/// take a while to open.
constexpr base::Duration kHeardAgain = std::chrono::seconds(30);

}  // namespace

bool FirmwareFaults::excuses_silence(base::RunTime now) const {
  return outages_ > 0 || now < excused_until_;
}

void FirmwareFaults::play(const BenchFaultScript& script, const BenchFault& fault, bool begins) {
  if (std::holds_alternative<LineFault>(fault.kind)) {
    const LineFault* line = script.line_of(fault.vehicle);  // another one may go on
    deck_.bench.cable().set_line(line == nullptr ? fcu::LineConfig{} : line->line);
  } else if (std::holds_alternative<UnplugFault>(fault.kind)) {
    note_outage(begins);
    deck_.bench.cable().set_plugged(!begins);
  } else if (std::holds_alternative<RestartFault>(fault.kind)) {
    restart(begins);
  } else if (std::holds_alternative<ReloadFault>(fault.kind)) {
    if (begins) reload();
  } else if (std::holds_alternative<SilenceFault>(fault.kind)) {
    lose_sticks_(begins);
  } else if (const auto* stop = std::get_if<PauseFault>(&fault.kind)) {
    if (begins) pause(stop->wall);
  } else if (const auto* link = std::get_if<CutFault>(&fault.kind)) {
    cut(link->link, begins);
  }
}

void FirmwareFaults::pause(base::Duration wall) {
  deck_.simulator.client().call("sim.pause", Json::object());
  deck_.supervisor.wait(wall);
  deck_.simulator.client().call("sim.resume", Json::object());
}

void FirmwareFaults::restart(bool begins) {
  if (begins == casd_is_away_) return;  // of two restarts at once the later one finds it so
  note_outage(begins);
  casd_is_away_ = begins;
  if (begins) {
    before_casd_ends_();
    return deck_.bench.kill_casd();
  }
  deck_.bench.start_casd();
  deck_.casd = connect(deck_.casd_address);
  remove_cut_links();
}

/// casd reads its topology again to open the link.
void FirmwareFaults::cut(const std::string& link, bool begins) {
  note_outage(begins);
  if (!begins) {
    cut_links_.erase(std::ranges::find(cut_links_, link));
    return reload();
  }
  const bool is_cut = std::ranges::find(cut_links_, link) != cut_links_.end();
  cut_links_.push_back(link);
  if (!casd_is_away_ && !is_cut) remove(link);
}

/// A casd that is away reads it as it comes.
void FirmwareFaults::reload() {
  if (casd_is_away_) return;
  deck_.casd.call("casd.reload", Json::object());
  remove_cut_links();
}

/// A casd that has read its topology has opened them all.
void FirmwareFaults::remove_cut_links() {
  for (const std::string& link : std::set(cut_links_.begin(), cut_links_.end())) remove(link);
}

void FirmwareFaults::remove(const std::string& link) {
  deck_.casd.call("link.remove", {{"link", link}, {"force", true}});
}

void FirmwareFaults::note_outage(bool begins) {
  outages_ += begins ? 1 : -1;
  excused_until_ = base::steady_now() + kHeardAgain;
}

}  // namespace cas::hils
