// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/rpc/call_params.hpp"
#include "base/rpc/server.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/link_id.hpp"
#include "casd/port/call_journal.hpp"
#include "casd/station/gain_map.hpp"
#include "casd/station/vehicle_commander.hpp"

namespace cas::casd {

/// Callbacks of the command port into the rest of casd.
struct VehicleHooks {
  std::function<base::RunTime()> now;
  /// Name of a link in the topology.
  std::function<std::string(LinkId)> link_name;
  /// Takes one line of the audit log: client, call and outcome.
  std::function<void(const std::string&)> audit;
  /// The moment by the clock of a recording, in microseconds since 1970.
  std::function<std::int64_t()> unix_us{};
};

/// The methods of the command port about vehicles: vehicle.*, gain.* and param.*, answered after
/// the vehicle has acknowledged, casd.journal, and the topics `statustext` and `parameters`.
/// Everything on the server's thread.
class VehicleMethods {
 public:
  /// Adds its methods to `server`. All arguments outlive this object; it outlives the server's run.
  VehicleMethods(base::rpc::Server& server, VehicleCommander& commander, GainMap gains,
                 VehicleHooks hooks);

  /// Replaces the gain map; requests under way keep their loop.
  void set_gains(GainMap gains) { gains_ = std::move(gains); }

  /// The `vehicles` of casd.status.
  nlohmann::json vehicles() const;

  /// Publishes how far the lists of parameters under way are; called once a second.
  void publish();

  /// Writes a line to audit and journal for a call that changed something other than a vehicle.
  /// @param refusal  nullopt: it was done
  void audit_other(const std::string& client, const std::string& name, const nlohmann::json& params,
                   const std::optional<std::string>& refusal);

 private:
  /// Starts a request to a vehicle.
  using Action = std::function<void(std::uint8_t system, base::RunTime now, Done done)>;
  /// Reads a method's parameters. A wrong one throws before anything is sent.
  using Parse = std::function<Action(base::rpc::CallParams&)>;
  /// Makes the result of an accepted request.
  using Answer = std::function<nlohmann::json(std::uint8_t system, const Outcome&)>;

  template <class... Args>
  Action calls(auto verb, Args... args);
  template <class... Args>
  Action moves(base::rpc::CallParams& params, auto verb, Args... args);
  void add_arming_methods();
  void add_flight_methods();
  void add_raw_methods();
  void add_state_methods();
  void add_gain_methods();
  void add_loop_method(const std::string& name, bool audited,
                       std::function<GainValues(base::rpc::CallParams&)> values_of);
  void add_param_methods();
  void add_journal_method();
  /// Sticks come many times a second: only the first of a stretch leaves a line.
  bool is_more_of_sticks(const std::string& name, base::RunTime now);
  /// Audited methods change the vehicle.
  void add(const std::string& name, bool audited, Parse parse, Answer answer);
  /// A method that commands the vehicle, answered once the vehicle has accepted it.
  void add_command(const std::string& name, Parse parse);
  /// A method that is answered at once, from the vehicle's stored state.
  void add_look(const std::string& name, std::function<nlohmann::json(const VehicleState&)> look);
  void run(const std::string& name, bool audited, const Parse& parse, const Answer& answer,
           const nlohmann::json& params, const base::rpc::Reply& reply);
  void audit(const std::string& client, const std::string& name, const nlohmann::json& params,
             std::uint8_t system, const Outcome& outcome);
  void publish_text(const VehicleState& vehicle, const StatusText& text);
  const GainLoop* find_loop(std::uint8_t system, const std::string& loop, const Done& done) const;

  base::rpc::Server& server_;
  VehicleCommander& commander_;
  GainMap gains_;
  VehicleHooks hooks_;
  CallJournal journal_;
  std::optional<base::RunTime> last_sticks_;
  std::string last_refusal_;    ///< line of the audit
  base::RunTime refused_at_{};  ///< when that line was left
  std::uint64_t refused_again_ = 0;
};

}  // namespace cas::casd
