// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/read_ulog.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"
#include "hils/ulog/ulog_formats.hpp"

namespace cas::hils {

namespace {

using base::ConfigError;
using Type = UlogField::Type;

static_assert(std::endian::native == std::endian::little, "ULog is little-endian");

constexpr std::string_view kMagic("ULog\x01\x12\x35", 7);
constexpr std::size_t kHeaderSize = 16;        // magic, version, moment
constexpr std::size_t kMessageHeaderSize = 3;  // size, type
constexpr std::size_t kTimestampSize = 8;
// No log of a vehicle comes near it; it bounds the memory for a malicious one.
constexpr std::size_t kMostFields = 100'000;  // of all subscriptions

/// The number at a place; its bytes must be there.
template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// A topic of the log with the least size of its messages.
struct Subscription {
  UlogSeries series;
  UlogField timestamp;
  std::size_t size = 0;  ///< up to the last field; padding behind it may be left out
  std::size_t most = 0;  ///< with that padding
};

/// Reads the messages behind the header.
class Reader {
 public:
  Reader(std::string_view bytes, UlogListener& listener) : bytes_(bytes), listener_(listener) {}

  void read() {
    at_ = kHeaderSize;
    while (at_ < bytes_.size()) {
      const std::size_t end = end_of_part();
      if (at_ + kMessageHeaderSize > end) {
        if (end > at_) listener_.on_cut(end - at_);
        at_ = end;  // cut, or the data that was appended begins here
        continue;
      }
      const auto size = number_at<std::uint16_t>(bytes_, at_);
      const char type = bytes_[at_ + 2];
      const std::size_t next = at_ + kMessageHeaderSize + size;
      if (next > end) {
        // Cut, as many logs are; or a damaged size, behind which there may be more.
        const std::size_t place = next_place(at_ + 1, end);
        place < end || !plausible(type, size) ? listener_.on_damage(place - at_)
                                              : listener_.on_cut(end - at_);
        at_ = place;
        continue;
      }
      if (!is_message(at_, next, end)) {
        skip_to(next_place(at_ + 1, end));
        continue;
      }
      const std::size_t begin = std::exchange(at_, next);
      if (!on_message(type, bytes_.substr(begin + kMessageHeaderSize, size))) {
        listener_.on_damage(next - begin);
      }
    }
    if (fields_ == 0 && unreadable_) throw *unreadable_;
  }

 private:
  static constexpr std::string_view kSync{"\x08\x00S\x2F\x73\x13\x20\x25\x0C\xBB\x12", 11};

  /// End of the current part of the file: PX4 appends a further part after a crash.
  std::size_t end_of_part() const {
    for (const std::uint64_t offset : appended_) {
      if (offset > at_ && offset < bytes_.size()) return static_cast<std::size_t>(offset);
    }
    return bytes_.size();
  }

  /// Where the message at a place ends; nullopt: not before `end`.
  std::optional<std::size_t> end_of(std::size_t place, std::size_t end) const {
    if (place + kMessageHeaderSize > end) return {};
    const std::size_t next = place + kMessageHeaderSize + number_at<std::uint16_t>(bytes_, place);
    return next > end ? std::nullopt : std::optional(next);
  }

  /// Whether what is between two places is a message: its contents tell its size, or another one
  /// follows and none begins inside, over which a damaged size would reach.
  bool is_message(std::size_t place, std::size_t next, std::size_t end) const {
    const std::size_t size = next - place - kMessageHeaderSize;
    if (!plausible(bytes_[place + 2], size)) return false;
    if (is_sure(place, next)) return true;
    return is_followed(next, end) && next_place(place + 1, next) == next;
  }

  /// Whether a header of a known kind is at a place, behind some messages of unknown kinds perhaps.
  bool is_followed(std::size_t place, std::size_t end) const {
    constexpr int kMostUnknown = 8;
    for (int i = 0; i < kMostUnknown && place != end; ++i) {
      if (place + kMessageHeaderSize > end) return false;
      const auto size = number_at<std::uint16_t>(bytes_, place);
      if (is_kind(bytes_[place + 2])) return plausible(bytes_[place + 2], size);
      const auto next = end_of(place, end);
      if (!next || size == 0) return false;
      place = *next;
    }
    return place == end;
  }

  /// Whether the contents of a message of a known kind have its size, whatever follows.
  bool is_sure(std::size_t place, std::size_t next) const {
    const std::string_view body =
        bytes_.substr(place + kMessageHeaderSize, next - place - kMessageHeaderSize);
    if (body.size() < 2) return false;
    switch (bytes_[place + 2]) {
      case 'S':
        return bytes_.substr(place, kSync.size()) == kSync;
      case 'O':
      case 'R':
        return body.size() == 2;
      case 'D':
        return is_of_its_topic(body);
      case 'F':
        return body.find(':') != std::string_view::npos && body.back() == ';';
      case 'A':
        return body.size() > 3 && body.size() <= kMostUlogNameBytes && is_name(body.substr(3));
      case 'I':
      case 'P':
        return is_pair(body);
      case 'M':
      case 'Q':
        return is_pair(body.substr(1));
      case 'L':
        return is_text(body, 1);
      case 'C':
        return is_text(body, 3);
      default:
        return false;
    }
  }

  bool is_of_its_topic(std::string_view body) const {
    const auto topic = topics_.find(number_at<std::uint16_t>(body, 0));
    if (topic == topics_.end()) return false;
    return body.size() - 2 >= topic->second.size && body.size() - 2 <= topic->second.most;
  }

  static bool is_name(std::string_view text) {
    return std::ranges::all_of(text, [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
  }

  /// Whether the body is a key with its length and a value of the key's size.
  static bool is_pair(std::string_view body) {
    if (body.empty()) return false;
    const auto length = static_cast<std::uint8_t>(body[0]);
    if (body.size() < 1U + length) return false;
    const auto key = ulog_declaration(body.substr(1, length));
    const UlogBasicType* basic = key ? ulog_basic_type(key->type) : nullptr;
    return basic != nullptr && body.size() == 1U + length + key->count.value_or(1) * basic->size;
  }

  /// Whether the body is a severity, perhaps a tag, a moment and a text without control characters.
  static bool is_text(std::string_view body, std::size_t before_time) {
    if (body.size() < before_time + kTimestampSize || body[0] < '0' || body[0] > '7') return false;
    constexpr std::string_view kAllowed("\t\n\r\x1b\0", 5);
    return std::ranges::all_of(body.substr(before_time + kTimestampSize), [&](char c) {
      return static_cast<unsigned char>(c) >= 0x20 || kAllowed.find(c) != std::string_view::npos;
    });
  }

  /// Whether messages begin at a place: kSureOnes sure ones follow, or fewer up to `end` or up to a
  /// synchronisation message. Other plausible messages may be between them.
  bool is_chain(std::size_t place, std::size_t end) const {
    constexpr int kSureOnes = 3;
    constexpr int kMost = 32;
    int sure = 0;
    for (int i = 0; i < kMost && place != end; ++i) {
      const auto next = end_of(place, end);
      if (!next || !plausible(bytes_[place + 2], *next - place - kMessageHeaderSize)) return false;
      if (is_sure(place, *next)) {
        if (++sure == kSureOnes || bytes_[place + 2] == 'S') return true;
      } else if (i == 0) {
        return false;
      }
      place = *next;
    }
    return place == end;
  }

  /// The next place at which messages begin, or `limit`.
  std::size_t next_place(std::size_t place, std::size_t limit) const {
    const std::size_t end = end_of_part();
    for (; place < limit; ++place) {
      if (place + kMessageHeaderSize <= end && is_kind(bytes_[place + 2]) && is_chain(place, end)) {
        return place;
      }
    }
    return limit;
  }

  void skip_to(std::size_t place) {
    listener_.on_damage(place - at_);
    at_ = place;
  }

  static bool is_kind(char type) {
    return std::string_view("SORDALCIMPQFB").find(type) != std::string_view::npos;
  }

  /// A type that this reader does not know may come from a newer logger.
  static bool plausible(char type, std::size_t size) {
    switch (type) {
      case 'S':
        return size == 8;
      case 'O':
        return size == 2;
      case 'R':
        return size >= 2;
      case 'D':
      case 'A':
      case 'L':
      case 'C':
      case 'I':
      case 'M':
      case 'P':
      case 'Q':
      case 'F':
      case 'B':
        return size >= 3;
      default:
        return size > 0;
    }
  }

  /// Whether a format is; a damaged one costs its own topic. The first reason is kept.
  template <class Read>
  bool is_readable(Read&& read) {
    try {
      read();
      return true;
    } catch (const ConfigError& error) {
      if (!unreadable_) unreadable_ = error;
      return false;
    }
  }

  /// Takes a message. @return false where it is damaged
  bool on_message(char type, std::string_view body) {
    switch (type) {
      case 'B':
        return on_flags(body);
      case 'F':
        return body.back() == ';' && is_readable([&] { formats_.add(body); });
      case 'I':
      case 'P':
        return on_pair(type, body);
      case 'A':
        return on_subscription(body);
      case 'R':
        topics_.erase(number_at<std::uint16_t>(body, 0));
        return true;
      case 'D':
        return on_data(body);
      case 'L':
        return on_sentence(body, 1);
      case 'C':
        return on_sentence(body, 3);  // with a tag
      case 'O':
        listener_.on_dropout(number_at<std::uint16_t>(body, 0));
        return true;
      default:
        return true;
    }
  }

  bool on_flags(std::string_view body) {
    // Right behind the header, as the format has it.
    if (at_ != kHeaderSize + kMessageHeaderSize + body.size()) return false;
    constexpr std::size_t kFlags = 8;  // bytes of flags that may be unknown, then as many that not
    if (body.size() < 2 * kFlags + sizeof appended_) return false;
    constexpr char kAppended = 1;
    for (std::size_t i = kFlags; i < 2 * kFlags; ++i) {
      if ((body[i] & ~(i == kFlags ? kAppended : 0)) != 0) {
        throw ConfigError("it needs a reader that knows more than ULog version 1");
      }
    }
    std::memcpy(appended_.data(), body.data() + 2 * kFlags, sizeof appended_);
    std::ranges::sort(appended_);
    return true;
  }

  /// A fact or a parameter: length of the key, key ("char[5] sys_name"), value.
  bool on_pair(char type, std::string_view body) {
    const auto length = static_cast<std::uint8_t>(body[0]);
    if (body.size() < 1U + length) return false;
    const auto key = ulog_declaration(body.substr(1, length));
    const std::string_view value = body.substr(1U + length);
    if (!key) return false;
    if (type == 'I') {
      if (key->type == "char") listener_.on_text_fact(key->name, value);
      return true;
    }
    const UlogBasicType* basic = ulog_basic_type(key->type);
    if (basic == nullptr || value.size() < basic->size) return false;
    listener_.on_parameter({key->name, ulog_number({key->name, basic->type, 0}, value)});
    return true;
  }

  /// Instance, id, name of the topic.
  bool on_subscription(std::string_view body) {
    const std::string topic(body.substr(3));
    if (!formats_.has(topic)) return false;
    Subscription added;
    const int instance = static_cast<std::uint8_t>(body[0]);
    added.series.name = instance == 0 ? topic : topic + "[" + std::to_string(instance) + "]";
    auto& fields = added.series.fields;
    if (!is_readable([&] { fields = formats_.spread(topic); })) return false;
    const auto timestamp = std::ranges::find(fields, "timestamp", &UlogField::name);
    if (timestamp == fields.end() || timestamp->type != Type::kUint64) {
      return is_readable([&] { throw ConfigError("topic `" + topic + "` has no timestamp"); });
    }
    fields_ += fields.size();
    if (fields_ > kMostFields) throw ConfigError("it has too many fields");
    added.timestamp = *timestamp;
    added.size = fields.back().offset + ulog_size_of(fields.back().type);
    added.most = formats_.bytes_of(topic);
    fields.erase(timestamp);
    topics_.insert_or_assign(number_at<std::uint16_t>(body, 1), std::move(added));
    return true;
  }

  bool on_data(std::string_view body) {
    if (!is_of_its_topic(body)) return false;  // a damaged size, or a damaged format
    const Subscription& found = topics_.at(number_at<std::uint16_t>(body, 0));
    body.remove_prefix(2);
    listener_.on_message(found.series, number_at<std::uint64_t>(body, found.timestamp.offset),
                         body);
    return true;
  }

  /// Severity as a digit, perhaps a tag, moment, text.
  bool on_sentence(std::string_view body, std::size_t before_time) {
    if (body.size() < before_time + kTimestampSize) return false;
    const int severity = static_cast<std::uint8_t>(body[0]) - '0';
    if (severity < 0 || severity > 7) return false;
    listener_.on_sentence(number_at<std::uint64_t>(body, before_time), severity,
                          body.substr(before_time + kTimestampSize));
    return true;
  }

  std::string_view bytes_;
  UlogListener& listener_;
  std::size_t at_ = 0;
  std::array<std::uint64_t, 3> appended_{};
  UlogFormats formats_;
  std::unordered_map<std::uint16_t, Subscription> topics_;
  std::size_t fields_ = 0;                 // of all subscriptions so far
  std::optional<ConfigError> unreadable_;  // why a format is
};

}  // namespace

double ulog_number(const UlogField& field, std::string_view bytes) {
  const auto read = [&]<class T>(T) {
    return static_cast<double>(number_at<T>(bytes, field.offset));
  };
  switch (field.type) {
    case Type::kInt8:
      return read(std::int8_t{});
    case Type::kInt16:
      return read(std::int16_t{});
    case Type::kUint16:
      return read(std::uint16_t{});
    case Type::kInt32:
      return read(std::int32_t{});
    case Type::kUint32:
      return read(std::uint32_t{});
    case Type::kInt64:
      return read(std::int64_t{});
    case Type::kUint64:
      return read(std::uint64_t{});
    case Type::kFloat:
      return read(float{});
    case Type::kDouble:
      return read(double{});
    case Type::kUint8:
    case Type::kBool:
    case Type::kChar:
      break;
  }
  return read(std::uint8_t{});
}

void read_ulog(std::string_view bytes, UlogListener& listener) {
  if (bytes.size() < kHeaderSize || !bytes.starts_with(kMagic)) {
    throw ConfigError("this is no ULog: it does not begin as one");
  }
  const auto version = static_cast<std::uint8_t>(bytes[kMagic.size()]);
  if (version > 1) {
    throw ConfigError("ULog version " + std::to_string(version) + "; versions 0 and 1 are read");
  }
  listener.on_start(number_at<std::uint64_t>(bytes, kMagic.size() + 1));
  Reader(bytes, listener).read();
}

}  // namespace cas::hils
