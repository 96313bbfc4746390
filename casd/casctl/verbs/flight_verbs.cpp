// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/rpc/client.hpp"
#include "base/text.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

using base::lower;

/// "vehicle 1 armed".
std::string sentence(const json& result, const std::string& what) {
  return "vehicle " + result.at("vehicle").dump() + " " + what;
}

/// A vehicle's state, of which only packets after the command's acknowledgement count: an older one
/// shows the vehicle before the command.
class SaidSince {
 public:
  /// @param acknowledged_s  `at_s` of the acknowledgement
  SaidSince(const json& state, double acknowledged_s)
      : state_(state), youngest_s_(state.value("at_s", 0.0) - acknowledged_s) {}

  bool armed() const { return heartbeat() && state_.value("armed", false); }
  bool disarmed() const { return heartbeat() && !state_.value("armed", true); }
  bool in_mode(const std::string& mode) const {
    return heartbeat() && lower(state_.value("mode", "")) == lower(mode);
  }
  bool airborne_at(double altitude_m) const {
    constexpr double kNear = 0.9;  // of the height asked for: vehicles settle slowly on the rest
    return is_new(state_, "altitude_age_s") &&
           state_.value("altitude_m", 0.0) >= kNear * altitude_m;
  }
  bool landed() const {
    const std::string word = state_.value("landed", "");
    if (word == "undefined") return disarmed();
    return word == "on_ground" && is_new(state_, "landed_age_s");
  }
  bool near(double north_m, double east_m, double down_m) const {
    constexpr double kNear_m = 0.5;
    if (!state_.contains("position_N")) return false;
    const json& p = state_["position_N"];
    return is_new(p, "age_s") &&
           std::hypot(p.value("x_m", 1e9) - north_m,  //
                      p.value("y_m", 1e9) - east_m, p.value("z_m", 1e9) - down_m) < kNear_m;
  }

 private:
  /// A packet that arrived with the acknowledgement may have been sent before it.
  bool is_new(const json& holder, const char* age_key) const {
    constexpr double kRounding_s = 1e-6;
    return holder.value(age_key, 1e9) < youngest_s_ - kRounding_s;
  }
  bool heartbeat() const { return is_new(state_, "heartbeat_age_s"); }

  const json& state_;
  double youngest_s_;  ///< age of the acknowledgement
};

/// The state that a command with --wait waits for.
struct Goal {
  std::string word{};  ///< "airborne"; empty: the acknowledgement is all there is to wait for
  std::function<bool(const SaidSince&)> reached{};
  bool flies = false;  ///< the vehicle must stay armed until then: its disarming ends the wait
};

double acknowledged_s(const json& result) {
  if (result.contains("at_s")) return result["at_s"];
  throw std::runtime_error(
      "acknowledged, but --wait cannot tell old packets from new ones: casd is of an older "
      "version than casctl");
}

/// How long a vehicle that is to fly may stay disarmed: PX4 takes a takeoff before it is armed.
constexpr std::chrono::seconds kArmsWithin{5};

/// @throws WaitTimeout, and std::runtime_error where the vehicle disarms before a goal that it
/// flies to, or is not armed within kArmsWithin
json wait_for(Session& session, const Goal& goal, double acknowledged_s) {
  using Clock = std::chrono::steady_clock;
  const auto arms_by = Clock::now() + kArmsWithin;
  bool armed = false;
  return session.wait_for(goal.word, [&](const json& state) {
    const SaidSince now(state, acknowledged_s);
    armed = armed || now.armed();
    if (goal.flies && !armed && now.disarmed() && Clock::now() >= arms_by) {
      throw std::runtime_error("acknowledged, but vehicle " + state.at("system").dump() +
                               " is disarmed; arm it first: casctl arm --wait");
    }
    if (goal.flies && armed && now.disarmed()) {
      throw std::runtime_error("acknowledged, but vehicle " + state.at("system").dump() +
                               " disarmed before it was " + goal.word + ": it is " +
                               state.value("landed", "undefined") + ", in mode " +
                               state.value("mode", "?"));
    }
    return goal.reached(now);
  });
}

/// Waits if asked to, and reports the state reached in words.
int tell(Session& session, json result, const std::string& did, const Goal& goal) {
  std::string words = did;
  if (session.options().wait && goal.reached) {
    result["state"] = wait_for(session, goal, acknowledged_s(result));
    words = goal.word;
  }
  report(session.options(), result, sentence(result, words));
  return kDone;
}

int fly(Session& session, const std::string& method, const json& params, const std::string& did,
        const Goal& goal = {}) {
  return tell(session, session.vehicle_call(method, params), did, goal);
}

/// Lands; with --wait until the vehicle has disarmed after it, or has not for long enough: PX4
/// disarms 2 s after its landing, ArduCopter after 10 s at most (DISARM_DELAY).
int come_down(Session& session, const std::string& method, const std::string& did) {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::duration<double> kDisarms{15};
  const auto give_up = Clock::now() + std::chrono::duration<double>(session.options().timeout_s);
  json result = session.vehicle_call(method);
  std::string words = did;
  if (session.options().wait) {
    const double since_s = acknowledged_s(result);
    wait_for(session, {"landed", [](const SaidSince& now) { return now.landed(); }}, since_s);
    const std::chrono::duration<double> left = give_up - Clock::now();
    auto [state, disarmed] = session.wait_at_most(
        std::min(kDisarms, left),
        [since_s](const json& now) { return SaidSince(now, since_s).disarmed(); });
    words = disarmed ? "landed and disarmed" : "landed, and is still armed";
    result["state"] = std::move(state);
  }
  report(session.options(), result, sentence(result, words));
  return kDone;
}

/// Whether the vehicle said "not now": MAV_RESULT_TEMPORARILY_REJECTED in the error's data.
bool is_temporary(const base::rpc::CallError& error) {
  constexpr int kTemporarilyRejected = 1;
  const json data = json::parse(error.data_json(), nullptr, false);
  return data.is_object() && data.value("result_code", json()) == kTemporarilyRejected;
}

/// With --wait asks again each second while the vehicle says "not yet": estimators take a while.
json arm(Session& session, const json& params) {
  for (;;) {
    try {
      return session.vehicle_call("vehicle.arm", params);
    } catch (const base::rpc::CallError& error) {
      if (!is_temporary(error) || !session.options().wait) throw;
      if (!session.may_wait()) {
        throw WaitTimeout(std::string("the vehicle did not let one arm in time: ") + error.what());
      }
      session.wait_because(error.what(), std::chrono::seconds(1));
    }
  }
}

/// Vehicles let one arm before they can take off, and disarm themselves again. Where the interlock
/// will hold there is nothing to wait for.
void wait_for_position(Session& session, bool not_hil) {
  using Clock = std::chrono::steady_clock;
  const auto give_up = Clock::now() + std::chrono::duration<double>(session.options().timeout_s);
  const bool consented = not_hil && session.call("casd.status").value("allow_not_hil", false);
  for (;;) {
    const json state = session.vehicle_call("vehicle.state");
    const bool armable = state.value("hil", false) || consented;
    if (!armable || state.contains("rival") || state.value("armed", false) ||
        !state.contains("position_lacks"))
      return;
    const std::string lack = state["position_lacks"];
    if (Clock::now() >= give_up) {
      throw WaitTimeout("not armed, because it could not take off: " + lack +
                        "; --no-wait arms all the same");
    }
    session.wait_because("it cannot take off yet: " + lack, std::chrono::milliseconds(200));
  }
}

void add_arm(CommandLine& line) {
  struct Flags {
    bool force = false;
    bool not_hil = false;
    bool no_wait = false;
  };
  const auto flags = std::make_shared<Flags>();
  CLI::App* const verb =
      line.add_verb("arm", "Arm the motors (only of a vehicle in HIL mode)", "casctl arm --wait",
                    [flags](Session& session) {
                      const json params{{"force", flags->force}, {"not_hil", flags->not_hil}};
                      if (!flags->no_wait && !flags->force) {
                        wait_for_position(session, flags->not_hil);
                      }
                      return tell(session, arm(session, params), "armed",
                                  {"armed", [](const SaidSince& now) { return now.armed(); }});
                    });
  verb->add_flag("--force", flags->force, "Skip the vehicle's own checks, and wait for nothing");
  verb->add_flag("--no-wait", flags->no_wait,
                 "Arm at once, also before the vehicle has the position that takeoff needs");
  verb->add_flag("--not-hil", flags->not_hil,
                 "Arm a vehicle that does not say it is in HIL: PROPELLERS MAY SPIN; casd's "
                 "configuration must consent");
}

void add_disarm(CommandLine& line) {
  const auto force = std::make_shared<bool>(false);
  line.add_verb("disarm", "Stop the motors", "casctl disarm --force",
                [force](Session& session) {
                  return fly(session, "vehicle.disarm", {{"force", *force}}, "disarmed",
                             {"disarmed", [](const SaidSince& now) { return now.disarmed(); }});
                })
      ->add_flag("--force", *force, "Also in flight: the vehicle falls");
}

/// `--not-hil` of a verb that may move a vehicle.
void add_consent(CLI::App* verb, bool& not_hil) {
  verb->add_flag("--not-hil", not_hil,
                 "Also a vehicle that does not say it is in HIL: A REAL VEHICLE MAY MOVE; casd's "
                 "configuration must consent");
}

/// The parameters of a call, with the consent where it is given.
json consenting(json params, bool not_hil) {
  if (not_hil) params["not_hil"] = true;
  return params;
}

void add_takeoff(CommandLine& line) {
  const auto altitude_m = std::make_shared<double>(2.5);
  const auto not_hil = std::make_shared<bool>(false);
  CLI::App* const verb = line.add_verb(
      "takeoff", "Take off to a height above home", "casctl takeoff 2.5 --wait",
      [altitude_m, not_hil](Session& session) {
        const json state = session.vehicle_call("vehicle.state");
        // A heartbeat may lag behind the arming: so it is said, not refused.
        const bool armed = state.value("armed", false);
        return fly(
            session, "vehicle.takeoff", consenting({{"altitude_m", *altitude_m}}, *not_hil),
            "takes off to " + fixed(*altitude_m, 1) + " m" +
                (armed ? "" : " when armed; it was last heard disarmed"),
            {"airborne",
             [altitude_m](const SaidSince& now) { return now.airborne_at(*altitude_m); }, true});
      });
  verb->add_option("ALT", *altitude_m, "Metres above home")
      ->check(in_range(0.1, 10000.0))
      ->capture_default_str();
  add_consent(verb, *not_hil);
}

void add_goto(CommandLine& line) {
  struct Target {
    double north_m = 0, east_m = 0, down_m = 0;
    std::optional<double> yaw_deg;
    bool not_hil = false;
  };
  const auto target = std::make_shared<Target>();
  CLI::App* const verb = line.add_verb(
      "goto", "Fly to a position in the local north-east-down frame",
      "casctl goto 5 0 -3 90 --wait", [target](Session& session) {
        json params{
            {"north_m", target->north_m}, {"east_m", target->east_m}, {"down_m", target->down_m}};
        if (target->yaw_deg) params["yaw_deg"] = *target->yaw_deg;
        return fly(session, "vehicle.goto", consenting(params, target->not_hil), "goes there",
                   {"there",
                    [target](const SaidSince& now) {
                      return now.near(target->north_m, target->east_m, target->down_m);
                    },
                    true});
      });
  verb->add_option("NORTH", target->north_m, "Metres to the north")->required();
  verb->add_option("EAST", target->east_m, "Metres to the east")->required();
  verb->add_option("DOWN", target->down_m, "Metres down; -3 is 3 m above the frame's origin")
      ->required();
  verb->add_option("YAW", target->yaw_deg, "Degrees from north; left out: kept");
  add_consent(verb, target->not_hil);
}

void add_mode(CommandLine& line) {
  const auto mode = std::make_shared<std::string>();
  const auto not_hil = std::make_shared<bool>(false);
  CLI::App* const verb = line.add_verb(
      "mode", "Set a flight mode by its word", "casctl mode POSCTL --wait",
      [mode, not_hil](Session& session) {
        return fly(
            session, "vehicle.mode", consenting({{"mode", *mode}}, *not_hil), "took mode " + *mode,
            {"in mode " + *mode, [mode](const SaidSince& now) { return now.in_mode(*mode); }});
      });
  verb->add_option("MODE", *mode, "HOLD, LAND, RTL, POSCTL, ...; a wrong word lists them")
      ->required();
  add_consent(verb, *not_hil);
}

/// Repeats the sticks, then releases them.
int hold_sticks(Session& session, const json& sticks, double duration_s) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kPeriod = std::chrono::milliseconds(50);  // 20 Hz, as ground stations do
  const auto start = Clock::now();
  const auto end = start + std::chrono::duration<double>(duration_s);
  json result = session.vehicle_call("vehicle.manual_control", sticks);
  for (auto next = start + kPeriod; next < end; next += kPeriod) {
    std::this_thread::sleep_until(next);
    result = session.vehicle_call("vehicle.manual_control", sticks);
  }
  report(session.options(), result,
         sentence(result, "had the sticks for " + fixed(duration_s, 1) + " s"));
  return kDone;
}

void add_manual(CommandLine& line) {
  struct Sticks {
    double pitch = 0, roll = 0, throttle = 0.5, yaw = 0;
    double duration_s = 1;
    bool not_hil = false;
  };
  const auto sticks = std::make_shared<Sticks>();
  CLI::App* const verb = line.add_verb(
      "manual", "Hold the sticks for some time (a mode that listens to them is needed)",
      "casctl manual --pitch 0.2 --for 2", [sticks](Session& session) {
        return hold_sticks(session,
                           consenting({{"pitch", sticks->pitch},
                                       {"roll", sticks->roll},
                                       {"throttle", sticks->throttle},
                                       {"yaw", sticks->yaw}},
                                      sticks->not_hil),
                           sticks->duration_s);
      });
  verb->add_option("--pitch", sticks->pitch, "-1 back to 1 forward")->check(in_range(-1.0, 1.0));
  verb->add_option("--roll", sticks->roll, "-1 left to 1 right")->check(in_range(-1.0, 1.0));
  verb->add_option("--throttle", sticks->throttle, "0 to 1; 0.5 keeps the height")
      ->check(in_range(0.0, 1.0))
      ->capture_default_str();
  verb->add_option("--yaw", sticks->yaw, "-1 left to 1 right")->check(in_range(-1.0, 1.0));
  verb->add_option("--for", sticks->duration_s, "Seconds to hold them")
      ->check(in_range(0.0, 3600.0))
      ->capture_default_str();
  add_consent(verb, sticks->not_hil);
}

void add_message_interval(CommandLine& line) {
  struct Wish {
    std::string message;
    std::optional<double> hz;
  };
  const auto wish = std::make_shared<Wish>();
  CLI::App* const verb = line.add_verb(
      "message-interval", "Set how often the vehicle sends a message",
      "casctl message-interval ATTITUDE 20", [wish](Session& session) {
        json params{{"message", wish->message}};
        if (!wish->message.empty() &&
            wish->message.find_first_not_of("0123456789") == std::string::npos) {
          params["message"] = std::strtoull(wish->message.c_str(), nullptr, 10);
        }
        if (wish->hz) params["hz"] = *wish->hz;
        return fly(session, "vehicle.message_interval", params,
                   "sends " + wish->message +
                       (wish->hz ? " at " + fixed(*wish->hz, 1) + " Hz" : " at its default rate"));
      });
  verb->add_option("MESSAGE", wish->message, "Name or id")->required();
  verb->add_option("HZ", wish->hz, "0 is off; left out: the vehicle's default");
}

}  // namespace

void add_flight_verbs(CommandLine& line) {
  add_arm(line);
  add_disarm(line);
  add_takeoff(line);
  line.add_verb("land", "Land here", "casctl land --wait --timeout 60",
                [](Session& session) { return come_down(session, "vehicle.land", "lands"); });
  line.add_verb("hold", "Stop and hold position", "casctl hold", [](Session& session) {
    return fly(session, "vehicle.hold", json::object(), "holds position");
  });
  line.add_verb("rtl", "Return to launch and land", "casctl rtl --wait", [](Session& session) {
    return come_down(session, "vehicle.rtl", "returns to launch");
  });
  add_goto(line);
  add_mode(line);
  add_manual(line);
  add_message_interval(line);
}

}  // namespace cas::casctl
