// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "fcu/flight/flight_tasks.hpp"
#include "mavlink/common/enums.hpp"

namespace cas::fcu {

/// One item of a mission, as MISSION_ITEM_INT carries it.
struct MissionItem {
  mavlink::common::MavFrame frame{};
  mavlink::common::MavCmd command{};
  bool autocontinue = true;
  std::array<double, 4> param{};
  std::int32_t x = 0;  ///< latitude, 1e-7 degree
  std::int32_t y = 0;  ///< longitude, 1e-7 degree
  double z = 0;        ///< altitude, m, as the frame says

  friend bool operator==(const MissionItem&, const MissionItem&) = default;
};

/// Flies the items one after the other: take-off, way-point, loiter, return, land, delay, speed.
class MissionTask final : public MovingTask {
 public:
  /// Whether an item can be flown. @return MAV_MISSION_ACCEPTED or the error
  static mavlink::common::MavMissionResult check(const MissionItem& item);

  void set_items(std::vector<MissionItem> items);
  const std::vector<MissionItem>& items() const { return items_; }
  /// Continues at an item. @return false when there is no such item
  bool set_current(std::size_t index);
  std::size_t current() const { return current_; }
  bool finished() const { return finished_; }
  /// Number of the item reached since the last call.
  std::optional<std::uint16_t> take_reached();
  /// The mode that the present item hands over to (return, land at the end).
  std::optional<FlightMode> wanted_mode() const { return wanted_mode_; }

  void activate(const TaskContext& context) override;
  ControlSetpoint update(const TaskContext& context) override;
  bool done(const TaskContext&) const override { return finished_; }
  bool wants_takeoff(const TaskContext&) const override { return !items_.empty() && !finished_; }
  bool descending(const TaskContext&) const override { return landing_; }

 private:
  void shift_more(const Eigen::Vector3d& by_N) override { land_.shift(by_N); }
  void start_item(const TaskContext& context);
  void continue_item(const TaskContext& context);
  void next(const TaskContext& context);
  bool waited(const MissionItem& item) const;
  void touch_down(const TaskContext& context);
  Eigen::Vector3d place(const MissionItem& item, const TaskContext& context) const;
  bool reached(const TaskContext& context) const;

  std::vector<MissionItem> items_;
  std::size_t current_ = 0;
  bool started_ = false;
  bool finished_ = false;
  bool landing_ = false;
  double waited_s_ = 0;
  double speed_m_s_ = -1;
  std::optional<std::uint16_t> reached_;
  std::optional<FlightMode> wanted_mode_;
  LandTask land_;
};

}  // namespace cas::fcu
