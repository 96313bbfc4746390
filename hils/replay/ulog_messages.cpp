// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/ulog_messages.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "base/earth/frames.hpp"
#include "base/error.hpp"
#include "hils/measure/check_json.hpp"
#include "hils/replay/logged_series.hpp"
#include "hils/replay/ulog_truth.hpp"
#include "hils/ulog/read_ulog.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

/// Topics from which the page draws the vehicle; their numbers always come at 20 Hz.
const std::set<std::string, std::less<>> kDrawn{"vehicle_local_position", "vehicle_attitude",
                                                "vehicle_status"};

/// vehicle_status.nav_state in words.
std::string mode_word(int nav_state) {
  if (nav_state >= 0 && nav_state <= 0xFF) {
    const auto word = mav::services::px4_mode_word(static_cast<std::uint8_t>(nav_state));
    if (!word.empty()) return std::string(word);
  }
  return fmt::format("nav state {}", nav_state);
}

/// Time since the begin of a log, s. A stamp from before it, of something that was published
/// earlier, is 0.
class UlogTime {
 public:
  void start(std::uint64_t time_us) { start_us_ = time_us; }

  /// Time of a stamp since the start, s. @return nullopt for a wrong stamp: a topic may have one of
  ///     an earlier flight, or a clock of its own. Time leaps only where most topics leap.
  std::optional<double> of(std::uint64_t time_us, std::string_view series) {
    const std::uint64_t us = time_us > start_us_ ? time_us - start_us_ : 0;
    if (us > newest_us_ && us - newest_us_ > kGapUs) {
      if (!confirms_leap(us, series)) return std::nullopt;
      leapt_.clear();
    } else if (!leapt_.empty()) {
      stayed_.emplace(series);
      if (const auto back = leapt_.find(series); back != leapt_.end()) leapt_.erase(back);
    }
    newest_us_ = std::max(newest_us_, us);
    const auto heard = heard_us_.find(series);
    (heard == heard_us_.end() ? heard_us_[std::string(series)] : heard->second) = us;
    return 1e-6 * static_cast<double>(us);
  }
  double newest_s() const { return 1e-6 * static_cast<double>(newest_us_); }

 private:
  static constexpr std::uint64_t kGapUs = 10'000'000;

  /// Whether time has leapt: the stamps of two topics leapt together, or one topic's go on behind
  /// the leap; more topics leapt than stayed; and these are over half of the topics of the last
  /// kGapUs, or all topics for kWhileUs.
  bool confirms_leap(std::uint64_t us, std::string_view series) {
    std::erase_if(leapt_, [&](const auto& other) {
      return other.first != series &&
             std::max(us, other.second) - std::min(us, other.second) > kGapUs;
    });
    if (leapt_.empty()) {
      stayed_.clear();
      leap_us_ = us;
    }
    const auto before = leapt_.find(series);
    const bool goes_on = before != leapt_.end() && us > before->second;
    leapt_.insert_or_assign(std::string(series), us);
    if ((leapt_.size() < 2 && !goes_on) || leapt_.size() <= stayed_.size()) return false;
    const auto of_late = std::ranges::count_if(
        heard_us_, [&](const auto& topic) { return topic.second + kGapUs >= newest_us_; });
    return 2 * leapt_.size() > static_cast<std::size_t>(of_late) ||
           (stayed_.empty() && us >= leap_us_ + kWhileUs);
  }

  static constexpr std::uint64_t kWhileUs = 2'000'000;

  std::uint64_t start_us_ = 0;
  std::uint64_t newest_us_ = 0;
  std::map<std::string, std::uint64_t, std::less<>> heard_us_;  // newest stamps, by topic
  std::map<std::string, std::uint64_t, std::less<>> leapt_;  // topics that leapt, with their stamps
  std::set<std::string, std::less<>> stayed_;                // topics without it since
  std::uint64_t leap_us_ = 0;                                // where it began
};

/// A sentence without the colours of a terminal, and without blanks and zeros at its end.
std::string plain(std::string_view text) {
  std::string kept;
  while (!text.empty()) {
    const std::size_t escape = std::min(text.find("\x1b["), text.size());
    kept += text.substr(0, escape);
    const std::size_t end = text.find('m', escape);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  kept.resize(kept.find_last_not_of(std::string_view("\t\n\0 ", 4)) + 1);
  return kept;
}

/// A number that the page lists: no text, no further time, and the first ones of an array.
bool is_shown(const UlogField& field) {
  constexpr std::size_t kMostElements = 16;
  if (field.type == UlogField::Type::kChar) return false;
  const std::size_t dot = field.name.rfind('.');
  const std::string_view last =
      std::string_view(field.name).substr(dot == std::string::npos ? 0 : dot + 1);
  if (last.starts_with("timestamp")) return false;
  for (std::size_t at = field.name.find('['); at != std::string::npos;
       at = field.name.find('[', at + 1)) {
    std::size_t i = 0;
    std::from_chars(field.name.data() + at + 1, field.name.data() + field.name.size(), i);
    if (i >= kMostElements) return false;
  }
  return true;
}

/// First reading: how long the log is, and how many numbers there are at 20 Hz.
class Sizes final : public UlogListener {
 public:
  void on_start(std::uint64_t time_us) override { time_.start(time_us); }
  void on_message(const UlogSeries& series, std::uint64_t time_us, std::string_view) override {
    if (!time_.of(time_us, series.name)) return;
    auto& [messages, fields] = series_[series.name];
    ++messages;
    if (messages == 1) {
      fields = static_cast<double>(std::ranges::count_if(series.fields, is_shown));
    }
  }

  bool empty() const { return series_.empty(); }

  /// Interval of the series that nothing is drawn from, s: long enough that the page can hold them.
  double period_s(std::size_t most_numbers) const {
    const auto most = static_cast<double>(most_numbers);
    double drawn = 0;
    double others = 0;
    for (const auto& [name, size] : series_) {
      const double at_20_hz = time_.newest_s() / kSeriesPeriod_s + 1;
      const double numbers = size.fields * std::min(size.messages, at_20_hz);
      (kDrawn.contains(name) ? drawn : others) += numbers;
    }
    const double room = std::max(most - drawn, most / 4);
    return kSeriesPeriod_s * std::max(1.0, others / room);
  }

 private:
  struct Size {
    double messages = 0;
    double fields = 0;
  };

  UlogTime time_;
  std::map<std::string, Size, std::less<>> series_;
};

/// Second reading: collects the contents of the page.
class Contents final : public UlogListener {
 public:
  explicit Contents(double period_s) : period_s_(period_s) {}

  void on_start(std::uint64_t time_us) override { time_.start(time_us); }

  void on_text_fact(std::string_view name, std::string_view value) override {
    if (name == "ver_hw") controller_ = value;
  }

  void on_parameter(const UlogValue& parameter) override {
    const auto [known, is_new] = parameters_.try_emplace(parameter.name, parameter.value);
    if (is_new || known->second == parameter.value) return;
    events_.push_back({{"t_s", time_.newest_s()},
                       {"kind", "parameter"},
                       {"text", parameter.name},
                       {"before", number_or_null(known->second)},
                       {"after", number_or_null(parameter.value)}});
    known->second = parameter.value;
  }

  void on_message(const UlogSeries& series, std::uint64_t time_us,
                  std::string_view bytes) override {
    const auto t_s = time_.of(time_us, series.name);
    if (!t_s) ++wrong_stamps_;
    if (!t_s) return;
    on_state(*t_s, series, bytes);
    truth_.on_message(*t_s, series, bytes);
    auto logged = messages_.find(series.name);
    if (logged == messages_.end()) {
      const double period_s = kDrawn.contains(series.name) ? kSeriesPeriod_s : period_s_;
      logged = messages_.emplace(series.name, LoggedSeries(period_s)).first;
    }
    if (logged->second.take(*t_s)) add_fields(series, bytes, logged->second);
  }

  void on_sentence(std::uint64_t time_us, int severity, std::string_view text) override {
    const auto t_s = time_.of(time_us, "sentence");
    if (t_s) texts_.push_back({*t_s, severity, plain(text)});
  }

  void on_dropout(int duration_ms) override { missing_[second()].dropped_ms += duration_ms; }
  void on_damage(std::size_t bytes) override { missing_[second()].damaged_bytes += bytes; }
  void on_cut(std::size_t bytes) override { missing_[second()].cut_bytes += bytes; }

  UlogLoss loss() const {
    UlogLoss all{.wrong_stamps = wrong_stamps_};
    for (const auto& [second, missing] : missing_) {
      all.dropped_ms += missing.dropped_ms;
      all.damaged_bytes += missing.damaged_bytes;
      all.cut_bytes += missing.cut_bytes;
    }
    return all;
  }
  bool empty() const { return messages_.empty(); }

  OrderedJson take() {
    for (const auto& [second, missing] : missing_) tell(second, missing);
    OrderedJson messages = OrderedJson::array();
    for (const auto& [name, logged] : messages_) messages.push_back(logged.json(name));
    OrderedJson log{{"messages", std::move(messages)},
                    {"texts", std::move(texts_)},
                    {"states", std::move(states_)},
                    {"autopilot", "PX4"},
                    {"duration_s", time_.newest_s()}};
    OrderedJson vehicle{{"system", system()},
                        {"controller", controller_},
                        {"log", std::move(log)},
                        {"events", std::move(events_)}};
    truth_.add_to(vehicle);
    return vehicle;
  }

 private:
  /// Armed, in HIL, mode, landed.
  using State = std::tuple<bool, bool, int, std::optional<bool>>;

  static std::optional<double> number(const UlogSeries& series, std::string_view bytes,
                                      std::string_view field) {
    const auto found = std::ranges::find(series.fields, field, &UlogField::name);
    if (found == series.fields.end()) return std::nullopt;
    return ulog_number(*found, bytes);
  }

  static void add_fields(const UlogSeries& series, std::string_view bytes, LoggedSeries& logged) {
    for (const UlogField& field : series.fields) {
      if (!is_shown(field)) continue;
      logged.add(field.name, "", ulog_number(field, bytes), field.type == UlogField::Type::kDouble);
    }
    const auto q = std::ranges::find(series.fields, "q[0]", &UlogField::name);
    if (series.fields.end() - q < 4 || (q + 3)->name != "q[3]") return;
    const Eigen::Quaterniond q_ND(ulog_number(q[0], bytes), ulog_number(q[1], bytes),
                                  ulog_number(q[2], bytes), ulog_number(q[3], bytes));
    const Eigen::Vector3d rpy = base::euler_rpy(q_ND);
    logged.add("roll", "rad", rpy.x());
    logged.add("pitch", "rad", rpy.y());
    logged.add("yaw", "rad", rpy.z());
  }

  void on_state(double t_s, const UlogSeries& series, std::string_view bytes) {
    constexpr int kHilEnabled = 32;  // of MAV_MODE_FLAG, which the page reads
    constexpr int kSafetyArmed = 128;
    if (series.name == "vehicle_status") {
      constexpr double kArmed = 2;  // ARMING_STATE_ARMED
      auto& [armed, in_hil, mode, landed] = now_;
      armed = number(series, bytes, "arming_state") == kArmed;
      in_hil = number(series, bytes, "hil_state").value_or(0) != 0;
      const double nav_state = number(series, bytes, "nav_state").value_or(-1);
      mode = nav_state >= 0 && nav_state <= 255 ? static_cast<int>(nav_state) : -1;
      system_ = number(series, bytes, "system_id").value_or(0);
      heard_ = true;
    } else if (series.name == "vehicle_land_detected") {
      std::get<3>(now_) = number(series, bytes, "landed").value_or(0) != 0;
    }
    if (!heard_ || told_ == now_) return;
    told_ = now_;
    const auto& [armed, in_hil, mode, landed] = now_;
    const int flags = (armed ? kSafetyArmed : 0) + (in_hil ? kHilEnabled : 0);
    const int landed_state = !landed ? 0 : *landed ? 1 : 2;  // MAV_LANDED_STATE
    states_.push_back({t_s, flags, mode_word(mode), landed_state});
  }

  /// By its status, or by its parameter.
  int system() const {
    const auto parameter = parameters_.find("MAV_SYS_ID");
    const double by_parameter = parameter == parameters_.end() ? 0 : parameter->second;
    const double system = system_ != 0 ? system_ : by_parameter;
    return system >= 1 && system <= 255 ? static_cast<int>(system) : 1;
  }

  std::int64_t second() const { return static_cast<std::int64_t>(std::floor(time_.newest_s())); }

  void tell(std::int64_t second, const UlogLoss& missing) {
    const auto add = [&](const std::string& text) {
      events_.push_back({{"t_s", second}, {"kind", "loss"}, {"text", text}});
    };
    if (missing.dropped_ms > 0) {
      add(fmt::format("the log lacks {} ms", missing.dropped_ms));
    }
    if (missing.damaged_bytes > 0) {
      add(fmt::format("{} bytes of the log are damaged", missing.damaged_bytes));
    }
    if (missing.cut_bytes > 0) {
      add(fmt::format("the log ends within a message, of which it has {} bytes",
                      missing.cut_bytes));
    }
  }

  double period_s_;
  UlogTime time_;
  std::string controller_;
  UlogTruth truth_;
  std::map<std::string, LoggedSeries, std::less<>> messages_;
  std::map<std::string, double, std::less<>> parameters_;
  std::map<std::int64_t, UlogLoss> missing_;  // by second
  std::size_t wrong_stamps_ = 0;
  OrderedJson events_ = OrderedJson::array();
  OrderedJson texts_ = OrderedJson::array();
  OrderedJson states_ = OrderedJson::array();
  State now_{};
  std::optional<State> told_;
  bool heard_ = false;
  double system_ = 0;
};

}  // namespace

std::string UlogLoss::sentence() const {
  std::string text;
  const auto add = [&text](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  if (dropped_ms > 0) add(fmt::format("{} ms are missing", dropped_ms));
  if (damaged_bytes > 0) add(fmt::format("{} bytes are damaged", damaged_bytes));
  if (wrong_stamps > 0) add(fmt::format("{} message(s) with a wrong time left out", wrong_stamps));
  if (cut_bytes > 0) add("it ends within a message");
  return text;
}

OrderedJson ulog_messages(std::string_view bytes, std::size_t most_numbers, UlogLoss* loss) {
  Sizes sizes;
  read_ulog(bytes, sizes);
  if (sizes.empty()) throw base::ConfigError("no message is in this log");
  Contents contents(sizes.period_s(most_numbers));
  read_ulog(bytes, contents);
  // The stamps of sentences may have made all messages stale.
  if (contents.empty()) throw base::ConfigError("no message is in this log");
  if (loss != nullptr) *loss = contents.loss();
  return contents.take();
}

}  // namespace cas::hils
