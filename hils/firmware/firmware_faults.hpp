// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/rpc/client.hpp"
#include "base/time/clock.hpp"
#include "hils/firmware/firmware_bench.hpp"
#include "hils/flight/bench_fault.hpp"

namespace cas::hils {

/// Plays the faults of the bench in a flight of stock firmware, and knows when the vehicles may be
/// silent because of one.
class FirmwareFaults {
 public:
  /// Targets of the faults; all outlive them.
  struct Reach {
    FirmwareBench& bench;
    base::rpc::Client& simulator;
    base::rpc::Client& casd;   ///< replaced when casd is started again
    std::string casd_address;  ///< to connect to it again
    /// Called before casd forgets the vehicles.
    /// @param ends  casd ends, and forgets its calls, too
    std::function<void(bool ends)> before_forgetting;
  };

  FirmwareFaults(std::vector<BenchFault> faults, Reach reach)
      : script_(std::move(faults)), reach_(std::move(reach)) {}

  /// Applies faults that begin or end now. A pause is over when it returns.
  /// @throws RunStopped, base::rpc::CallError
  void play(base::SimTime now, std::span<const VehicleReport> vehicles, std::string_view phase);

  bool casd_is_away() const { return casd_is_away_; }
  /// Whether a vehicle that casd does not hear is silent because of a fault: while one lasts that
  /// keeps casd from hearing it, and for 30 s of real time after it.
  bool excuses_silence(base::RunTime now) const;

  std::vector<BenchFaultScript::Span> history_of(std::size_t vehicle) const {
    return script_.history_of(vehicle);
  }

 private:
  void play(const BenchFault& fault, bool begins);
  void pause(base::Duration wall);
  void restart(bool begins);
  void cut(const std::string& link, bool begins);
  void reload();
  void remove_cut_links();
  void remove(const std::string& link);
  void note_outage(bool begins);
  void ask_casd(const std::string& method, const base::rpc::Json& params);

  BenchFaultScript script_;
  Reach reach_;
  bool casd_is_away_ = false;
  std::vector<std::string> cut_links_;  ///< one for each cut under way
  int outages_ = 0;                     ///< under way
  base::RunTime excused_until_{};       ///< once none is
};

}  // namespace cas::hils
