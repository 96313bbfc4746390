// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "mavlink/common/enums.hpp"
#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/param_request_read.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink_gen/services/outcome.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// How a vehicle puts an integer parameter into the float field of PARAM_SET and PARAM_VALUE.
enum class ParamEncoding {
  kBytewise,  ///< the integer's bytes (PX4)
  kCast,      ///< the number, converted (ArduPilot)
};

/// The number that a PARAM_VALUE carries.
double from_wire(ParamEncoding encoding, mavlink::common::MavParamType type, float wire);

/// The field of PARAM_SET for a number; nullopt when the type cannot hold it (a fraction in an
/// integer, out of range, not finite).
std::optional<float> to_wire(ParamEncoding encoding, mavlink::common::MavParamType type,
                             double value);

/// Whether the vehicle's value is the one asked for, as far as the type can tell them apart.
bool same_value(mavlink::common::MavParamType type, double asked, double in_force);

/// "INT32", "REAL32", ...
std::string_view name(mavlink::common::MavParamType type);

/// Shortest decimal text that a float of this value reads back from: 0.15, not 0.150000006.
std::string number_text(double value);

/// One parameter by the newest PARAM_VALUE.
struct Parameter {
  double value = 0;
  mavlink::common::MavParamType type{};
};

/// When parameter requests are sent again and given up.
struct ParamTiming {
  Duration answer_timeout = std::chrono::milliseconds(700);
  /// A list that has begun to come is waited for longer from try to try: 10 s of silence end it.
  int tries = 5;
  /// A list with gaps asks for at most this many missing ones at a time.
  std::size_t missing_at_once = 10;
};

/// How far a list of parameters has come.
struct ListProgress {
  std::size_t received = 0;
  std::size_t count = 0;  ///< 0: not known yet
};

/// The parameter protocol (https://mavlink.io/en/services/parameter.html) with one vehicle.
///
/// Every wait has a deadline and a bound on tries, and the number of parameters has a limit that no
/// autopilot reaches: a faulty or endless stream costs bounded time and memory. A list takes as
/// long as new parameters come. An answered value is compared with the requested one: a vehicle
/// that clamps or refuses answers with the value in force.
class ParamExchange {
 public:
  using Message = std::variant<mavlink::common::ParamSet, mavlink::common::ParamRequestRead,
                               mavlink::common::ParamRequestList>;
  using Send = std::function<void(const Message&)>;
  /// Asked before each transmission of a value. @return why it may not be sent, if so
  using Objection = std::function<std::optional<Outcome>(Time)>;

  explicit ParamExchange(Send send, ParamTiming timing = {})
      : send_(std::move(send)), timing_(timing) {}

  /// Reads one parameter. Outcome.parameters has it.
  void read(const std::string& name, Time now, Done done);
  /// Sets one parameter, after asking for its type where that is not known yet.
  /// @param objection  ends the request; empty: none
  void set(const std::string& name, double value, Time now, Done done, Objection objection = {});
  /// Fetches all parameters; Outcome.parameters has them, or those that came.
  void list(Time now, Done done);
  /// Progress of the list under way; nullopt: none is.
  std::optional<ListProgress> list_progress() const;

  void on_value(const mavlink::common::ParamValue& message, ParamEncoding encoding, Time now);
  void on_status_text(std::string_view text);
  void tick(Time now);
  /// When tick() has something to do; nothing while no request is under way.
  std::optional<Time> due() const;
  /// Ends all requests with this outcome.
  void give_up(const Outcome& outcome);

  const std::map<std::string, Parameter>& known() const { return known_; }

 private:
  struct Request {
    std::string name;
    std::optional<double> value;     ///< to set
    std::optional<double> before{};  ///< in force until it is set
    Done done;
    Objection objection{};
    bool type_known = false;
    int sent = 0;
    int mismatches = 0;
    Time deadline{};
    std::vector<std::string> texts;
  };
  struct Listing {
    std::vector<Done> done;
    std::vector<bool> have;  ///< by index; empty until a count is known
    std::size_t received = 0;
    std::size_t news = 0;  ///< parameters taken as new, again after each change of the count
    int idle_rounds = 0;
    Time deadline{};
    std::map<std::string, double> values;
  };

  void start(Request request, Time now);
  void transmit(std::list<Request>::iterator request, Time now);
  void send_set(Request& request);
  bool fits(const Request& request) const;
  Outcome unfit(const Request& request) const;
  void on_answer(std::list<Request>::iterator request, const Parameter& in_force, Time now);
  void on_set_answer(std::list<Request>::iterator request, const Parameter& in_force, Time now);
  void finish(std::list<Request>::iterator request, Outcome outcome);
  void on_listed(const mavlink::common::ParamValue& message, const std::string& name, double value,
                 Time now);
  void tick_listing(Time now);
  void give_up_listing(OutcomeKind kind, const std::string& why);
  void finish_listing(Outcome outcome);
  std::vector<std::string_view> known_names() const;

  Send send_;
  ParamTiming timing_;
  ParamEncoding encoding_{};  ///< of the last answer
  std::map<std::string, Parameter> known_;
  std::list<Request> active_;
  std::optional<Listing> listing_;
};

}  // namespace cas::mav::services
