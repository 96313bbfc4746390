// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "casd/casctl/monitor/monitor_state.hpp"

namespace cas::casctl {

/// Changes the state that `casctl monitor` draws. Pure: answers of casd, keys and times come in;
/// render() (monitor_view.hpp) makes lines of state().
class MonitorModel {
 public:
  using Page = MonitorState::Page;

  const MonitorState& state() const { return state_; }

  /// Takes in answers of casd.status and message.list. While paused, messages stay as they are.
  void update(const nlohmann::json& status, const nlohmann::json& messages, double time_s);
  /// Takes in vehicle.state and vehicle.telemetry.
  void update_vehicle(const nlohmann::json& vehicle, const nlohmann::json& telemetry,
                      double time_s);
  /// Takes in message.value of the open message.
  void update_value(const nlohmann::json& value, double time_s);
  /// Takes in gain.get of each loop, or why there is none.
  void update_gains(const nlohmann::json& gains, const std::optional<std::string>& fault,
                    double time_s);
  void set_gains_asked(double time_s) { state_.gains_asked_s = time_s; }
  /// Why casd does not answer; nullopt: it does.
  void set_casd_fault(const std::optional<std::string>& fault) { state_.casd_fault = fault; }

  // Where the user is.
  void move(int steps);
  void move_field(int steps);
  void cycle_sort();
  void cycle_link();
  void cycle_direction();
  void cycle_vehicle();
  void choose_vehicle(int system) { state_.chosen_vehicle = system; }
  void toggle_pause() { state_.paused = !state_.paused; }
  void set_filter(const std::string& filter);
  /// Opens the selected message, or closes it where it is open.
  void toggle_open();
  void close();
  /// Shows a page, or the messages again where it is shown already.
  void show(Page page);
  void set_note(const std::string& note, bool bad);
  void set_answer(const std::string& answer, bool bad, double time_s);
  /// The line under edit with a hint; nullopt: the keys are shown.
  void set_prompt(std::optional<std::string> prompt, const std::string& hint = "");
  void set_interval(double interval_s) { state_.interval_s = interval_s; }
  void use_unicode(bool unicode) { state_.unicode = unicode; }

  /// The loop that the gains' page has selected.
  std::optional<nlohmann::json> selected_gain() const;

 private:
  void watch_vehicles(const nlohmann::json& status, const nlohmann::json& messages, double time_s);
  void update_link_rates(const nlohmann::json& links, double seconds);
  void forget_vehicle();
  void choose_a_field();

  MonitorState state_;
};

}  // namespace cas::casctl
