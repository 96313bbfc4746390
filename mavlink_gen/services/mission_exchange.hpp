// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "mavlink/common/enums.hpp"
#include "mavlink/common/mission_ack.hpp"
#include "mavlink/common/mission_clear_all.hpp"
#include "mavlink/common/mission_count.hpp"
#include "mavlink/common/mission_item_int.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/mission_request_list.hpp"
#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/outcome.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// Timeouts and retries of a mission transfer.
struct MissionTiming {
  Duration answer_timeout = std::chrono::milliseconds(700);
  int tries = 5;
  /// A transfer that is not whole by then is given up, however much still comes.
  Duration whole_timeout = std::chrono::seconds(120);
};

/// "denied", "no space", ...
std::string describe(mavlink::common::MavMissionResult result);

/// The mission protocol (https://mavlink.io/en/services/mission.html) with one vehicle, from the
/// ground station's side: upload, download, clear; of missions, fences and rally points. One
/// transfer at a time. Every wait has a deadline and a bound on tries.
class MissionExchange {
 public:
  using Items = std::vector<mavlink::common::MissionItemInt>;
  using Message =
      std::variant<mavlink::common::MissionCount, mavlink::common::MissionItemInt,
                   mavlink::common::MissionRequestList, mavlink::common::MissionRequestInt,
                   mavlink::common::MissionAck, mavlink::common::MissionClearAll>;
  using Send = std::function<void(const Message&)>;
  /// Called once, when the transfer has ended, with the items that came or went.
  using Done = std::function<void(const Outcome&, const Items&)>;
  using Type = mavlink::common::MavMissionType;

  explicit MissionExchange(Send send, MissionTiming timing = {})
      : send_(std::move(send)), timing_(timing) {}

  /// Replaces the vehicle's items by these, numbered in this order.
  void upload(Items items, Time now, Done done, Type type = Type::kMission);
  void download(Time now, Done done, Type type = Type::kMission);
  void clear(Time now, Done done, Type type = Type::kMission);

  /// Takes in a packet of the vehicle. @param self  packets for others are left out
  void on_packet(const PacketView& packet, Source self, Time now);
  void tick(Time now);
  /// Ends the transfer with this outcome.
  void give_up(const Outcome& outcome);
  bool busy() const { return transfer_.has_value(); }

 private:
  enum class Kind { kUpload, kDownload, kClear };
  struct Transfer {
    Kind kind{};
    Type type{};
    Items items{};
    std::optional<std::size_t> count{};  ///< of the items, once it is known
    std::size_t asked_for = 0;           ///< of an upload: items that the vehicle has asked for
    Done done{};
    Message last{};  ///< message to repeat
    int sent = 0;
    Time deadline{};
    Time give_up{};  ///< of the transfer as a whole
  };

  void start(Transfer transfer, Time now);
  void say(Message message, Time now);
  void on_request(std::uint16_t seq, Type type, Time now);
  void on_count(const mavlink::common::MissionCount& message, Time now);
  void on_item(const mavlink::common::MissionItemInt& message, Time now);
  void on_ack(const mavlink::common::MissionAck& message);
  void ask_for_next(Time now);
  void finish(const Outcome& outcome);
  std::string progress() const;

  Send send_;
  MissionTiming timing_;
  std::optional<Transfer> transfer_;
};

}  // namespace cas::mav::services
