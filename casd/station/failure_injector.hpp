// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "base/time/clock.hpp"
#include "casd/packet/link_mask.hpp"
#include "casd/station/notice_limit.hpp"
#include "casd/station/vehicle_commander.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/failure_order.hpp"

namespace cas::casd {

/// Begins each STATUSTEXT that casd sends with a vehicle's ids.
inline constexpr std::string_view kInjectorPrefix = "casd: ";

/// A simulator whose sensor data goes to a vehicle.
struct Simulator {
  mav::Source source;
  Path path;
};

/// Callbacks of a FailureInjector into the rest of casd.
struct FailureHooks {
  SendPacket send{};
  /// Whether the topology lets stations on this link inject failures.
  std::function<bool(LinkId)> permits{};
  std::function<std::string(LinkId)> link_name{};
  /// Why a vehicle is not known to be in HIL; nullopt: it is.
  std::function<std::optional<std::string>(std::uint8_t system)> hil_doubt{};
  /// The simulator that feeds a vehicle; nullopt: none does through casd.
  std::function<std::optional<Simulator>(std::uint8_t system)> simulator{};
  /// Takes one line of the audit log.
  std::function<void(const std::string&)> audit{};
};

/// Intercepts MAV_CMD_INJECT_FAILURE from stations to vehicles, and passes it to the vehicle's
/// simulator. Vehicles never get the command.
///
///   station --> on_packet --> permitted? in HIL? --> simulator --> COMMAND_ACK --> station
///
/// The answer has the vehicle's ids, because ground stations expect it from there; a refusal also
/// sends a STATUSTEXT with the reason. Failures of a vehicle are sent one at a time. Pure: the time
/// comes in as an argument, that of this machine's clock, also in lockstep.
class FailureInjector {
 public:
  static constexpr base::Duration kPatience = std::chrono::seconds(1);
  static constexpr std::size_t kMostWaiting = 16;  ///< of one vehicle

  /// @param commander  knows the vehicles; outlives this object
  FailureInjector(mav::Source self, const VehicleCommander& commander, FailureHooks hooks);

  /// Result for a packet.
  enum class Verdict : std::uint8_t {
    kNotOurs,  ///< it is about something else
    kRefused,  ///< without effect: the commander must not count it as an intervention
    kTaken     ///< sent on to the simulator
  };
  Verdict on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  /// The same command from the command port.
  void inject(std::uint8_t system, const VehicleCommand& command, base::RunTime now, Done done);
  /// Gives up on simulators that do not answer.
  void tick(base::RunTime now);
  /// When tick() has something to do; RunTime::max(): nothing under way.
  base::RunTime due() const;
  /// Drops, unanswered, the requests that wait on links that are gone. Until end_reload() every
  /// packet with the number of such a link is refused, because it may come from the old link.
  void begin_reload(const LinkMask& gone, base::RunTime now);
  void end_reload() { gone_ = {}; }

 private:
  struct Request {
    mav::services::FailureOrder order;
    Done answer;
    std::string line{};      ///< of the audit, without the outcome; empty: the port leaves its own
    mav::Source by{};        ///< requester; system 0: the command port
    LinkId link = kNoLink;   ///< where it is
    std::uint32_t peer = 0;  ///< of the link: two stations may have the same ids
    Simulator simulator{};   ///< of the one that is under way
    std::int32_t token = 0;  ///< the same; 0: not sent yet
    base::RunTime deadline{};
  };

  /// Target of a command.
  struct Addressee {
    mav::Source source;
    std::optional<Outcome> unknown{};  ///< why there is no such vehicle
  };

  Addressee addressee(mav::Source target) const;
  Request request_of(const Origin& from, const mav::PacketView& packet,
                     const std::optional<mav::services::FailureOrder>& order, mav::Source vehicle);
  bool is_repetition(const Origin& from, const mav::PacketView& packet, std::uint8_t system,
                     const mav::services::FailureOrder& order) const;
  std::optional<Outcome> refusal(std::uint8_t system,
                                 const std::optional<Simulator>& simulator) const;
  std::optional<Outcome> refusal(mav::Source by, LinkId link) const;
  bool is_autopilot(mav::Source source) const;
  void add(std::uint8_t system, Request request, base::RunTime now);
  void send_first(std::uint8_t system, base::RunTime now);
  void finish(std::uint8_t system, const Outcome& outcome, base::RunTime now);
  void end(const Request& request, const Outcome& outcome, base::RunTime now);
  void on_ack(const Origin& from, const mav::PacketView& packet, base::RunTime now);
  void answer(const Path& to, mav::Source asker, mav::Source vehicle, const Outcome& outcome);
  void leave_line(const std::string& line, bool accepted, base::RunTime now);
  template <class M>
  void send_as(mav::Source source, const M& message, const Path& to);

  mav::Encoder encoder_;
  const VehicleCommander& commander_;
  FailureHooks hooks_;
  std::map<std::uint8_t, std::deque<Request>> waiting_;  ///< by system; the first is under way
  LinkMask gone_;                                        ///< while a reload is under way
  std::int32_t token_ = 0;
  std::uint8_t sequence_ = 0;  ///< of packets in a vehicle's name
  NoticeLimit refusals_{20};   ///< that leave a line
};

}  // namespace cas::casd
