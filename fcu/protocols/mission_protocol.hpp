// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "base/time/clock.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/flight/commander.hpp"
#include "mavlink/common/mission_ack.hpp"
#include "mavlink/common/mission_clear_all.hpp"
#include "mavlink/common/mission_count.hpp"
#include "mavlink/common/mission_item_int.hpp"
#include "mavlink/common/mission_request_list.hpp"
#include "mavlink/common/mission_set_current.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::fcu {

/// The mission protocol: upload (we ask for the items one by one, again when they do not come),
/// download, clear, current. Fences and rally points: none, and none are taken.
///
/// One station uploads at a time; others are denied meanwhile. A download is of the mission as it
/// was when the station asked for its count, whatever is uploaded meanwhile.
class MissionProtocol {
 public:
  static constexpr std::size_t kMaxItems = 500;

  MissionProtocol(Commander& commander, Outbox& outbox, StatusTexts& texts)
      : commander_(commander), outbox_(outbox), texts_(texts) {}

  void on_count(const mavlink::common::MissionCount& m, mav::Source from, int version,
                base::RunTime now);
  void on_item(const mavlink::common::MissionItemInt& m, mav::Source from, base::RunTime now);
  void on_request_list(const mavlink::common::MissionRequestList& m, mav::Source from, int version,
                       base::RunTime now);
  void on_request(std::uint16_t seq, mavlink::common::MavMissionType type, mav::Source from,
                  int version, base::RunTime now);
  /// The end of a download, or an upload that its station has cancelled.
  void on_ack(const mavlink::common::MissionAck& m, mav::Source from);
  void on_clear(const mavlink::common::MissionClearAll& m, mav::Source from, int version);
  void on_set_current(const mavlink::common::MissionSetCurrent& m);
  /// Repeats a request that got no answer; reports items reached.
  void update(base::RunTime now);

 private:
  struct Upload {
    mav::Source from;
    int version = 2;
    std::size_t count = 0;
    std::vector<MissionItem> items;
    base::RunTime asked;
    int tries = 0;
  };
  struct Download {
    mav::Source from;
    std::vector<MissionItem> items;
    base::RunTime used;
  };
  const std::vector<MissionItem>& items_for(mav::Source from, base::RunTime now);
  void acknowledge(mav::Source to, int version, mavlink::common::MavMissionType type,
                   mavlink::common::MavMissionResult result);
  bool is_flown() const;
  void request_next(base::RunTime now);
  void finish(mavlink::common::MavMissionResult result);

  Commander& commander_;
  Outbox& outbox_;
  StatusTexts& texts_;
  std::optional<Upload> upload_;
  std::deque<Download> downloads_;  ///< under way, oldest first
};

}  // namespace cas::fcu
