// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ubx/ubx_receiver.hpp"

#include <algorithm>
#include <utility>

namespace cas::sim {
namespace {

constexpr std::uint8_t kCfg = 0x06;
constexpr std::size_t kMostKeys = 1024;
constexpr std::uint32_t kKeyBaud = 0x40520001;
constexpr std::uint32_t kKeyMeasPeriod = 0x30210001;
constexpr unsigned kUart1 = 1;

/// The messages of an epoch, in the order in which they are sent, and their keys CFG-MSGOUT for
/// UART1.
struct Output {
  UbxId id;
  std::uint32_t key;
  UbxPayload (*payload)(const UbxEpoch&);
};
constexpr std::array<Output, 6> kOutputs{{{ubx::kNavPvt, 0x20910007, nav_pvt},
                                          {ubx::kNavTimeGps, 0x20910048, nav_time_gps},
                                          {ubx::kNavDop, 0x20910039, nav_dop},
                                          {ubx::kNavRelPosNed, 0x2091008E, nav_rel_pos_ned},
                                          {ubx::kNavSat, 0x20910016, nav_sat},
                                          {ubx::kMonRf, 0x2091035A, mon_rf}}};

std::uint64_t number_at(std::span<const std::uint8_t> bytes, std::size_t offset, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= std::uint64_t{bytes[offset + i]} << (8 * i);
  }
  return value;
}

void append(std::vector<std::uint8_t>& out, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Bytes of a value, by bits 28 to 30 of its key; 0: there is no such key.
std::size_t size_of(std::uint32_t key) {
  constexpr std::array<std::size_t, 8> kSizes{0, 1, 1, 2, 4, 8, 0, 0};
  return kSizes[key >> 28 & 7];
}

const Output* output_of(UbxId id) {
  const auto found = std::ranges::find(kOutputs, id, &Output::id);
  return found == kOutputs.end() ? nullptr : &*found;
}

}  // namespace

void UbxReceiver::receive(std::span<const std::uint8_t> bytes) {
  parser_.feed(bytes,
               [this](UbxId id, std::span<const std::uint8_t> payload) { on_frame(id, payload); });
}

void UbxReceiver::on_frame(UbxId id, std::span<const std::uint8_t> payload) {
  if (id == ubx::kMonVer && payload.empty()) return answer(id, mon_ver());
  if (id.group != kCfg) return;
  const std::array<std::uint8_t, 2> which{id.group, id.id};
  answer(configure(id, payload) ? ubx::kAckAck : ubx::kAckNak, which);
}

/// Settings that nothing of the simulation depends on are kept and told as they are.
/// @return false: refused
bool UbxReceiver::configure(UbxId id, std::span<const std::uint8_t> payload) {
  if (id == ubx::kCfgValSet) return set_values(payload);
  if (id == ubx::kCfgValGet) {
    if (payload.size() < 8) return false;
    tell_values(payload);
    return true;
  }
  if (id == ubx::kCfgPrt) return set_port(payload);
  if (id == ubx::kCfgMsg) return set_message(payload);
  if (payload.empty()) return tell_setting(id);
  if (id == ubx::kCfgRate && payload.size() == 6)
    values_[kKeyMeasPeriod] = number_at(payload, 0, 2);
  settings_[id.id].assign(payload.begin(), payload.end());
  return true;
}

/// As it was set, or zeros where it was not.
bool UbxReceiver::tell_setting(UbxId id) {
  constexpr std::pair<std::uint8_t, std::size_t> kSizes[]{
      {0x08, 6}, {0x16, 8}, {0x24, 36}, {0x31, 32}, {0x3E, 4}};  // RATE, SBAS, NAV5, TP5, GNSS
  const auto set = settings_.find(id.id);
  if (set != settings_.end()) {
    answer(id, set->second);
    return true;
  }
  for (const auto& [known, size] : kSizes) {
    if (known != id.id) continue;
    answer(id, std::vector<std::uint8_t>(size));
    return true;
  }
  return false;
}

/// Version, layers and two reserved bytes, then keys with their values.
bool UbxReceiver::set_values(std::span<const std::uint8_t> payload) {
  std::size_t at = 4;
  while (at + 4 < payload.size()) {
    const auto key = static_cast<std::uint32_t>(number_at(payload, at, 4));
    const std::size_t size = size_of(key);
    at += 4;
    if (size == 0 || at + size > payload.size()) return false;
    if (values_.size() == kMostKeys && !values_.contains(key)) return false;
    values_[key] = number_at(payload, at, size);
    if (key == kKeyBaud) set_baud(static_cast<std::uint32_t>(values_[key]));
    at += size;
  }
  return at == payload.size();
}

void UbxReceiver::tell_values(std::span<const std::uint8_t> payload) {
  std::vector<std::uint8_t> told{1, 0, 0, 0};
  for (std::size_t at = 4; at + 4 <= payload.size(); at += 4) {
    const auto key = static_cast<std::uint32_t>(number_at(payload, at, 4));
    append(told, key, 4);
    append(told, value_of(key), size_of(key));
  }
  answer(ubx::kCfgValGet, told);
}

/// One or several ports of 20 bytes; UART1 counts. Empty or one byte: a poll.
bool UbxReceiver::set_port(std::span<const std::uint8_t> payload) {
  constexpr std::size_t kPort = 20;
  if (payload.size() <= 1) {
    tell_port();
    return true;
  }
  for (std::size_t at = 0; at + kPort <= payload.size(); at += kPort) {
    if (payload[at] == kUart1) set_baud(static_cast<std::uint32_t>(number_at(payload, at + 8, 4)));
  }
  return payload.size() % kPort == 0;
}

void UbxReceiver::tell_port() {
  constexpr std::uint64_t k8n1 = 0x08D0;
  std::vector<std::uint8_t> port{kUart1, 0, 0, 0};
  append(port, k8n1, 4);
  append(port, baud_, 4);
  append(port, 0x0001'0001, 4);  // UBX in and out
  append(port, 0, 4);
  answer(ubx::kCfgPrt, port);
}

/// Class, id and the rate on this port, or those on all six; two bytes are a poll.
bool UbxReceiver::set_message(std::span<const std::uint8_t> payload) {
  if (payload.size() != 2 && payload.size() != 3 && payload.size() != 8) return false;
  const UbxId id{payload[0], payload[1]};
  const Output* output = output_of(id);
  if (payload.size() == 2) {
    std::array<std::uint8_t, 8> told{id.group, id.id};
    told[2 + kUart1] = static_cast<std::uint8_t>(rate_of(id));
    answer(ubx::kCfgMsg, told);
    return true;
  }
  const std::uint8_t rate = payload[payload.size() == 3 ? 2 : 2 + kUart1];
  if (output != nullptr) {
    values_[output->key] = rate;
  } else {
    other_rates_[{id.group, id.id}] = rate;
  }
  return true;
}

/// The acknowledgement goes out at the new rate. A rate that no UART has is not taken.
void UbxReceiver::set_baud(std::uint32_t baud) {
  constexpr std::uint32_t kLeast = 9'600;
  constexpr std::uint32_t kMost = 4'000'000;
  if (baud >= kLeast && baud <= kMost) baud_ = baud;
}

std::uint64_t UbxReceiver::value_of(std::uint32_t key) const {
  if (key == kKeyBaud) return baud_;
  const auto found = values_.find(key);
  return found == values_.end() ? 0 : found->second;
}

unsigned UbxReceiver::rate_of(UbxId id) const {
  if (const Output* output = output_of(id)) return static_cast<unsigned>(value_of(output->key));
  const auto other = other_rates_.find({id.group, id.id});
  return other == other_rates_.end() ? 0U : other->second;
}

unsigned UbxReceiver::wanted_period_ms() const {
  return static_cast<unsigned>(value_of(kKeyMeasPeriod));
}

void UbxReceiver::answer(UbxId id, std::span<const std::uint8_t> payload) {
  constexpr std::size_t kMostWaiting = 8192;  // of a driver that asks and does not read
  if (queue_.size() - sent_ > kMostWaiting) return;
  append_ubx(queue_, id, payload);
  ++counts_.answers;
}

void UbxReceiver::on_epoch(const UbxEpoch& epoch) {
  ++number_;
  if (sent_ < epoch_end_) {
    ++counts_.dropped;
    return;
  }
  const std::size_t before = queue_.size();
  for (const Output& output : kOutputs) {
    const std::uint64_t each = value_of(output.key);
    if (each == 0 || number_ % each != 0) continue;
    if (output.id == ubx::kNavRelPosNed && !epoch.baseline_N) continue;
    append_ubx(queue_, output.id, output.payload(epoch));
  }
  if (queue_.size() == before) return;
  epoch_end_ = queue_.size();
  ++counts_.epochs;
}

std::span<const std::uint8_t> UbxReceiver::next(base::SimTime now) {
  constexpr base::Duration::rep kBitsPerByte = 10;
  const base::Duration byte_time(kBitsPerByte * 1'000'000'000 / baud_);
  if (sent_ == queue_.size()) {
    queue_.clear();
    sent_ = epoch_end_ = 0;
    free_at_ = std::max(free_at_, now);  // it was idle until now
    return {};
  }
  const std::size_t begin = sent_;
  while (sent_ < queue_.size() && free_at_ < now) {
    free_at_ += byte_time;
    ++sent_;
  }
  counts_.bytes += sent_ - begin;
  return std::span(queue_).subspan(begin, sent_ - begin);
}

void UbxReceiver::reset() {
  queue_.clear();
  sent_ = epoch_end_ = 0;
  free_at_ = {};
  number_ = 0;
}

}  // namespace cas::sim
