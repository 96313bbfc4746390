// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/logged_messages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "casd/tlog/tlog_packets.hpp"
#include "hils/replay/logged_series.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink/common/extended_sys_state.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/json/message_codec.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/tlog_clock.hpp"
#include "mavlink_gen/services/vehicle_state.hpp"

namespace cas::hils {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kMostElements = 8;  // of an array
// What a page shows without trouble. A longer log gets fewer samples a second.
constexpr std::size_t kMostNumbers = 8'000'000;
constexpr std::size_t kMostTexts = 10'000;
constexpr std::size_t kMostStates = 100'000;

casd::TlogLoss for_each_packet(
    const std::filesystem::path& tlog,
    const std::function<void(std::uint64_t, const mav::PacketView&)>& use) {
  casd::TlogLoss loss;
  if (!casd::for_each_tlog_packet(tlog, mavlink::common::table(), use, &loss)) {
    throw base::ConfigError("cannot read " + tlog.string());
  }
  return loss;
}

/// Time of a log since its begin (TlogClock), or of the simulation where its clock is known. It
/// never goes back.
class LogTime {
 public:
  explicit LogTime(const ClockMap& clock) : clock_(clock) {}

  double of(std::uint64_t stamp_us, std::span<const std::uint8_t> packet) {
    if (clock_.empty()) return 1e-6 * static_cast<double>(log_.at(stamp_us, packet));
    const std::int64_t us = clock_.to_sim_us(static_cast<std::int64_t>(stamp_us));
    if (us > now_us_ && us - now_us_ <= kDayUs) now_us_ = us;
    return 1e-6 * static_cast<double>(now_us_);
  }

  /// How often the recorder's clock was set.
  std::uint64_t steps() const { return log_.steps(); }

 private:
  static constexpr std::int64_t kDayUs = 86'400'000'000;

  const ClockMap& clock_;
  mav::services::TlogClock log_;
  std::int64_t now_us_ = 0;
};

using Payload = std::array<std::uint8_t, mav::kMaxPayloadBytes + sizeof(std::uint64_t)>;

template <class Wire>
double load(const std::uint8_t* bytes) {
  Wire value{};
  mav::get<Wire>(bytes, value);
  return static_cast<double>(value);
}

/// An element of a field as JSON has it (number_json()); NaN for a non-finite value.
double number_of(const mav::FieldInfo& field, const Payload& payload, std::size_t element) {
  const auto at = [&](std::size_t size) {
    return payload.data() + field.wire_offset + element * size;
  };
  switch (field.type) {
    case mav::FieldType::kChar:
    case mav::FieldType::kUint8:
      return load<std::uint8_t>(at(1));
    case mav::FieldType::kInt8:
      return load<std::int8_t>(at(1));
    case mav::FieldType::kUint16:
      return load<std::uint16_t>(at(2));
    case mav::FieldType::kInt16:
      return load<std::int16_t>(at(2));
    case mav::FieldType::kUint32:
      return load<std::uint32_t>(at(4));
    case mav::FieldType::kInt32:
      return load<std::int32_t>(at(4));
    case mav::FieldType::kUint64:
      return load<std::uint64_t>(at(8));
    case mav::FieldType::kInt64:
      return load<std::int64_t>(at(8));
    case mav::FieldType::kFloat: {
      const nlohmann::json number = mav::services::number_json(load<float>(at(4)));
      return number.is_null() ? std::nan("") : number.get<double>();
    }
    case mav::FieldType::kDouble: {
      const double value = load<double>(at(8));
      return std::isfinite(value) ? value : std::nan("");
    }
  }
  return std::nan("");
}

}  // namespace

class MessageCollector::Collected {
 public:
  void on_packet(double t_s, const mav::PacketView& packet) {
    last_s_ = std::max(last_s_, t_s);
    on_state(t_s, packet);
    on_text(t_s, packet);
    const mav::MessageInfo* info = mavlink::common::table().find(packet.message_id);
    if (info == nullptr) return;
    const auto place = messages_.try_emplace(std::string(info->name), period_s_).first;
    LoggedSeries& logged = place->second;
    if (!logged.take(t_s)) return;
    add_fields(packet, logged);
    numbers_ += 1 + mavlink::common::fields_of(packet.message_id).size() * kMostElements;
    if (numbers_ > kMostNumbers) bound_numbers();
  }

  OrderedJson json() const {
    OrderedJson messages = OrderedJson::array();
    for (const auto& [name, logged] : messages_) messages.push_back(logged.json(name));
    return {{"messages", std::move(messages)},
            {"texts", texts_},
            {"states", states_},
            {"duration_s", last_s_}};
  }

 private:
  /// `numbers_` is an upper bound; only where it is reached are the samples counted.
  void bound_numbers() {
    for (;;) {
      numbers_ = 0;
      for (const auto& [name, logged] : messages_) numbers_ += logged.numbers();
      if (numbers_ <= kMostNumbers / 2) return;
      for (auto& [name, logged] : messages_) logged.thin();
      period_s_ *= 2;
    }
  }

  void add_fields(const mav::PacketView& packet, LoggedSeries& logged) {
    Payload payload{};  // bytes that a truncated one lacks are zero
    std::ranges::copy(packet.payload, payload.begin());
    for (const mav::FieldInfo& field : mavlink::common::fields_of(packet.message_id)) {
      const std::string_view name = field.name;
      if (name.starts_with("time_") || field.type == mav::FieldType::kChar) continue;
      if (field.array_length == 0) logged.add(name, field.units, number_of(field, payload, 0));
      for (std::size_t i = 0; i < std::min<std::size_t>(field.array_length, kMostElements); ++i) {
        logged.add(fmt::format("{}[{}]", name, i), field.units, number_of(field, payload, i));
      }
    }
  }

  void on_state(double t_s, const mav::PacketView& packet) {
    std::array<std::uint32_t, 3> state = state_;
    // The autopilot's mode: a gimbal or a station of the same system has one of its own.
    if (const auto heartbeat = mav::decode<mavlink::common::Heartbeat>(packet);
        heartbeat && heartbeat->autopilot != mavlink::common::MavAutopilot::kInvalid) {
      state[0] = static_cast<std::uint32_t>(heartbeat->base_mode);
      state[1] = heartbeat->custom_mode;
      mode_ = mav::services::mode_name(
          mav::services::mode_set(mav::services::autopilot_family(heartbeat->autopilot),
                                  heartbeat->type),
          heartbeat->base_mode, heartbeat->custom_mode);
      heard_ = true;
    }
    if (const auto landed = mav::decode<mavlink::common::ExtendedSysState>(packet)) {
      state[2] = static_cast<std::uint32_t>(landed->landed_state);
    }
    if (!heard_ || (state == state_ && !states_.empty())) return;
    if (states_.size() == kMostStates) return;
    state_ = state;
    states_.push_back({t_s, state[0], mode_, state[2]});
  }

  void on_text(double t_s, const mav::PacketView& packet) {
    const auto text = mav::decode<mavlink::common::Statustext>(packet);
    if (!text) return;
    const auto whole = joiner_.add(*text, {});
    if (!whole || texts_.size() > kMostTexts) return;
    const bool is_last = texts_.size() == kMostTexts;
    texts_.push_back({t_s, static_cast<int>(whole->severity),
                      is_last ? "(the replay shows no further texts)" : whole->text});
  }

  std::map<std::string, LoggedSeries> messages_;
  double period_s_ = kSeriesPeriod_s;
  std::size_t numbers_ = 0;
  OrderedJson texts_ = OrderedJson::array();
  OrderedJson states_ = OrderedJson::array();
  std::array<std::uint32_t, 3> state_{};
  std::string mode_;
  bool heard_ = false;
  mav::services::StatusTextJoiner joiner_;
  double last_s_ = 0;
};

MessageCollector::MessageCollector() : collected_(std::make_unique<Collected>()) {}
MessageCollector::MessageCollector(MessageCollector&&) noexcept = default;
MessageCollector::~MessageCollector() = default;

void MessageCollector::on_packet(double t_s, const mav::PacketView& packet) {
  collected_->on_packet(t_s, packet);
}

OrderedJson MessageCollector::json() const { return collected_->json(); }

OrderedJson logged_messages(const std::filesystem::path& tlog, std::uint8_t system,
                            const ClockMap& clock, LoggedLoss* lost) {
  MessageCollector collector;
  LogTime time(clock);
  const casd::TlogLoss loss =
      for_each_packet(tlog, [&](std::uint64_t stamp_us, const mav::PacketView& packet) {
        const double t_s = time.of(stamp_us, packet.bytes);
        if (packet.source.system == system) collector.on_packet(t_s, packet);
      });
  if (lost != nullptr) *lost = {loss.skipped_bytes, loss.wrong_checksums, time.steps()};
  return collector.json();
}

std::string LoggedLoss::sentence() const {
  std::string text;
  const auto add = [&text](std::uint64_t count, const char* what) {
    if (count == 0) return;
    text += fmt::format("{}{}{}", text.empty() ? "" : ", ", count, what);
  };
  add(wrong_checksums, " packet(s) with a wrong checksum left out");
  add(skipped_bytes, " bytes that are no record skipped");
  add(clock_steps, " step(s) of the recorder's clock taken out of the time");
  return text;
}

std::uint8_t first_autopilot(const std::filesystem::path& tlog) {
  std::uint8_t system = 0;
  for_each_packet(tlog, [&](std::uint64_t, const mav::PacketView& packet) {
    if (system != 0) return;
    const auto heartbeat = mav::decode<mavlink::common::Heartbeat>(packet);
    if (!heartbeat || heartbeat->autopilot == mavlink::common::MavAutopilot::kInvalid) return;
    system = packet.source.system;
  });
  return system;
}

}  // namespace cas::hils
