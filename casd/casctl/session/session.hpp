// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/rpc/client.hpp"

namespace cas::casctl {

/// Exit codes of casctl.
enum ExitCode : int {
  kDone = 0,      ///< done, and acknowledged by the vehicle
  kRefused = 1,   ///< refused, by casd or by the vehicle
  kUsage = 2,     ///< the command line makes no sense
  kNoDaemon = 3,  ///< no casd answers at the address
  kTimeout = 4,   ///< no acknowledgement or state in time
};

/// The options that every verb takes.
struct Options {
  std::string address;     ///< empty: the one casd that runs on this machine
  std::string token_file;  ///< empty: the one in the runtime folder, for TCP to this machine
  std::optional<int> vehicle;
  bool json = false;
  bool wait = false;
  double timeout_s = 60;
};

/// Several casds run on this machine and --address names none: what() lists them.
class SeveralDaemons : public std::runtime_error {
 public:
  /// @param daemons  of each `address`, and if it answers `name`, `topology`, `vehicles` and
  /// `uptime_s`
  SeveralDaemons(const std::string& what, nlohmann::json daemons)
      : std::runtime_error(what), daemons_(std::move(daemons)) {}
  const nlohmann::json& daemons() const { return daemons_; }

 private:
  nlohmann::json daemons_;
};

/// Thrown by casctl's verbs when a state that --wait waits for has not come in time.
class WaitTimeout : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One connection to casd, authorised over TCP where a token is given or found. With --wait it
/// waits up to --timeout for casd to answer and for the vehicle's first HEARTBEAT.
class Session {
 public:
  /// @throws base::rpc::ConnectionError, CallError, SeveralDaemons; std::runtime_error for an
  /// unreadable token
  explicit Session(const Options& options);

  /// As given, with the address that was found where none was given.
  const Options& options() const { return options_; }
  /// Calls a method with the parameters as they are.
  nlohmann::json call(const std::string& method,
                      const nlohmann::json& params = nlohmann::json::object());
  /// Calls a vehicle method: adds `vehicle` where --vehicle is given.
  nlohmann::json vehicle_call(const std::string& method,
                              nlohmann::json params = nlohmann::json::object());
  /// All parameters of a vehicle, as param.list answers them. Shows on standard error how far the
  /// list is; --timeout is the time in which casd says nothing.
  nlohmann::json list_params(int vehicle);
  using OfState = std::function<bool(const nlohmann::json&)>;
  /// Polls vehicle.state until `reached` holds.
  /// @param what  the state in a word, for the error
  /// @throws WaitTimeout
  nlohmann::json wait_for(const std::string& what, const OfState& reached);
  /// The same for at most `patience`. @return the newest state; whether `reached` holds of it
  std::pair<nlohmann::json, bool> wait_at_most(std::chrono::duration<double> patience,
                                               const OfState& reached);
  /// Whether --wait is given and its time is not over.
  bool may_wait() const;
  /// Says once why casctl waits, then does so for `period`.
  void wait_because(const std::string& reason, std::chrono::milliseconds period);

 private:
  base::rpc::Client connect();
  /// Without --address: the one casd that has a socket on this machine, else its TCP port.
  base::rpc::Client connect_here();
  void authorise();
  bool is_asked_for_token();
  void authorise_with_own_token();

  Options options_;
  std::chrono::steady_clock::time_point give_up_;
  std::string told_;     // the reason for waiting that was said last
  std::string address_;  // that was tried last
  base::rpc::Client client_;
};

/// Every row of message.list, page by page.
nlohmann::json all_messages(Session& session);

/// Whether a vehicle's newest HEARTBEAT is too old to tell its state.
bool is_silent(const nlohmann::json& vehicle);

/// Prints a result as JSON, with --json. @return whether it did
bool printed_as_json(const Options& options, const nlohmann::json& result);
/// Prints a result: as JSON with --json, else the sentence.
void report(const Options& options, const nlohmann::json& result, const std::string& sentence);

}  // namespace cas::casctl
