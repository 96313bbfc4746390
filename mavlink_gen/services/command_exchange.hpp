// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "mavlink/common/command_ack.hpp"
#include "mavlink/common/command_int.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink_gen/services/command.hpp"
#include "mavlink_gen/services/outcome.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// When a command is sent again and given up.
struct CommandTiming {
  Duration ack_timeout = std::chrono::milliseconds(700);
  int tries = 5;
  Duration in_progress_timeout = std::chrono::seconds(10);
  /// A refusal waits this long for the status text that says why; 0: it does not wait for a tick
  /// either.
  Duration text_grace = std::chrono::milliseconds(250);
  /// An accepted command must show in the HEARTBEAT within this long, where it has a `Doubt`.
  Duration effect_timeout = std::chrono::seconds(3);
  /// The same by the wall clock, while the vehicle's time does not advance.
  Duration effect_patience = std::chrono::seconds(10);
};

/// The command protocol (https://mavlink.io/en/services/command.html) with one vehicle: sends,
/// repeats with a rising confirmation count, waits for COMMAND_ACK, through IN_PROGRESS.
///
/// One command per id is under way; more of the same id wait in line, except where the newest
/// counts (arm and disarm, mode, reposition): there it replaces the one under way. MAVLink cannot
/// tell acknowledgements of the same command apart, so one that arrives after its request was
/// given up counts for the next of its id.
///
/// An acknowledgement may promise too much: PX4 1.16 accepts a mode and rejects it in a second
/// acknowledgement. A command with a `Doubt` is done when the HEARTBEAT shows its effect.
class CommandExchange {
 public:
  using Message = std::variant<mavlink::common::CommandLong, mavlink::common::CommandInt>;
  using Send = std::function<void(const Message&)>;
  /// Asked before each transmission. @return why the command may not be sent, if so
  using Objection = std::function<std::optional<Outcome>(Time)>;
  /// Asked at each HEARTBEAT after the acknowledgement. @return the vehicle's other state ("it is
  /// in HOLD"); nullopt once the command has taken effect
  using Doubt = std::function<std::optional<std::string>()>;

  /// Asked before each transmission, before the objection. @return the command, of the same id, as
  /// the vehicle's newest HEARTBEAT has it
  using Renewal = std::function<VehicleCommand()>;

  explicit CommandExchange(Send send, CommandTiming timing = {})
      : send_(std::move(send)), timing_(timing) {}

  /// @param objection  ends the command at the next tick; empty: none
  /// @param doubt  empty: the acknowledgement is believed
  /// @param renewal  empty: each repetition is the same
  void start(const VehicleCommand& command, Time now, Done done, Objection objection = {},
             Doubt doubt = {}, Renewal renewal = {});
  /// @return whether an accepted command waits for a HEARTBEAT from now on
  bool on_ack(const mavlink::common::CommandAck& ack, Time now);
  void on_status_text(std::string_view text);
  /// The vehicle has reported its state.
  void on_heartbeat(Time now);
  void tick(Time now);
  /// Now and then by the wall clock, where that of `tick` may stand still.
  void wall_tick(Time wall);
  /// The vehicle was disarmed, or its flight ended: ends all active and waiting commands that may
  /// start motors. @param by  for the sentence: who, and how
  void on_disarm(const std::string& by, Time now);
  /// When tick() has something to do; nothing while no command is under way.
  std::optional<Time> due() const;
  /// Ends all commands with this outcome.
  void give_up(const Outcome& outcome);

 private:
  struct Request {
    VehicleCommand command;
    Done done;
    Objection objection;
    Doubt doubt;
    Renewal renewal;
    std::optional<Outcome> objected;
    int sent = 0;
    bool in_progress = false;
    bool accepted = false;  ///< and in doubt
    bool heard = false;     ///< a HEARTBEAT came after the acknowledgement
    Time deadline{};
    std::optional<Time> wall_deadline{};  ///< of an accepted one
    std::optional<mavlink::common::MavResult> refused;
    std::vector<std::string> texts;
  };

  void transmit(Request& request, Time now);
  void replace(mavlink::common::MavCmd id, Time now);
  void end_doubt(std::list<Request>::iterator request, Time now, const std::string& within);
  void on_deadline(std::list<Request>::iterator request, Time now);
  void finish(std::list<Request>::iterator request, Outcome outcome, Time now);
  void start_waiting(mavlink::common::MavCmd id, Time now);
  std::list<Request>::iterator find(mavlink::common::MavCmd id);

  Send send_;
  CommandTiming timing_;
  std::list<Request> active_;
  std::list<Request> waiting_;
  Time ticked_at_{};
};

}  // namespace cas::mav::services
