// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/read_ulog.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "base/error.hpp"

namespace cas::hils {

namespace {

using base::ConfigError;
using Type = UlogField::Type;

static_assert(std::endian::native == std::endian::little, "ULog is little-endian");

constexpr std::string_view kMagic("ULog\x01\x12\x35", 7);
constexpr std::size_t kHeaderSize = 16;        // magic, version, moment
constexpr std::size_t kMessageHeaderSize = 3;  // size, type
constexpr std::size_t kTimestampSize = 8;
constexpr std::size_t kMostBytes = 65535;  // of a message
// No log of a vehicle comes near these; they bound the memory for a malicious one.
constexpr std::size_t kMostFields = 100'000;  // of all subscriptions
constexpr std::size_t kMostSteps = 100'000;   // to spread topics out: padding counts, too
constexpr std::size_t kMostNameBytes = 255;

struct BasicType {
  std::string_view name;
  Type type;
  std::size_t size;
};
constexpr std::array<BasicType, 12> kBasicTypes{{{"int8_t", Type::kInt8, 1},
                                                 {"uint8_t", Type::kUint8, 1},
                                                 {"int16_t", Type::kInt16, 2},
                                                 {"uint16_t", Type::kUint16, 2},
                                                 {"int32_t", Type::kInt32, 4},
                                                 {"uint32_t", Type::kUint32, 4},
                                                 {"int64_t", Type::kInt64, 8},
                                                 {"uint64_t", Type::kUint64, 8},
                                                 {"float", Type::kFloat, 4},
                                                 {"double", Type::kDouble, 8},
                                                 {"bool", Type::kBool, 1},
                                                 {"char", Type::kChar, 1}}};

const BasicType* basic_type(std::string_view name) {
  const auto* const found = std::ranges::find(kBasicTypes, name, &BasicType::name);
  return found == kBasicTypes.end() ? nullptr : found;
}

/// The number at a place; its bytes must be there.
template <class T>
T number_at(std::string_view bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// "float[3] xyz": type, how many (nothing: no array), name.
struct Declaration {
  std::string type;
  std::optional<std::size_t> count;
  std::string name;
};

std::optional<Declaration> declaration_of(std::string_view text) {
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space == 0 || space + 1 == text.size()) return {};
  Declaration found{.type = std::string(text.substr(0, space)),
                    .count = {},
                    .name = std::string(text.substr(space + 1))};
  const std::size_t bracket = found.type.find('[');
  if (bracket == std::string::npos) return found;
  std::size_t count = 0;
  const char* const end = found.type.data() + found.type.size();
  const auto [rest, error] = std::from_chars(found.type.data() + bracket + 1, end, count);
  if (error != std::errc{} || rest + 1 != end || *rest != ']' || count > kMostBytes) return {};
  found.count = count;
  found.type.resize(bracket);
  return found;
}

/// The types that a log defines, by name, as their fields.
class Formats {
 public:
  /// @param text  "name:type field;type field;"
  void add(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == std::string_view::npos) return;  // a user of the type reports it missing
    std::vector<Declaration> fields;
    for (std::string_view rest = text.substr(colon + 1); !rest.empty();) {
      const std::size_t end = std::min(rest.find(';'), rest.size());
      auto field = declaration_of(rest.substr(0, end));
      if (!field || field->count == 0U) {
        throw ConfigError("type `" + std::string(text.substr(0, colon)) + "` has `" +
                          std::string(rest.substr(0, end)) + "`, which is no field");
      }
      fields.push_back(*std::move(field));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    formats_.insert_or_assign(std::string(text.substr(0, colon)), std::move(fields));
    spread_.clear();
  }

  bool has(const std::string& topic) const { return formats_.contains(topic); }

  /// The numbers of a topic's messages. @throws ConfigError
  const std::vector<UlogField>& spread(const std::string& topic) {
    const auto [fields, is_new] = spread_.try_emplace(topic);
    if (is_new) spread(topic, "", 0, 0, fields->second);
    return fields->second;
  }

 private:
  /// @return bytes that the type takes
  std::size_t spread(const std::string& type, const std::string& prefix, std::size_t offset,
                     int depth, std::vector<UlogField>& out) {
    constexpr int kMostDepth = 16;
    const auto format = formats_.find(type);
    if (format == formats_.end()) throw ConfigError("type `" + type + "` is used, but not defined");
    if (depth == kMostDepth) throw ConfigError("type `" + type + "` is nested too deep");
    const std::size_t begin = offset;
    for (const Declaration& field : format->second) {
      const BasicType* basic = basic_type(field.type);
      for (std::size_t i = 0; i < field.count.value_or(1); ++i) {
        std::string name = prefix + field.name;
        if (field.count) name += "[" + std::to_string(i) + "]";
        if (name.size() > kMostNameBytes) {
          throw ConfigError("type `" + type + "` has a field with too long a name");
        }
        if (++steps_ > kMostSteps) throw ConfigError("it has too many fields");
        std::size_t size = 0;
        if (basic != nullptr) {
          size = basic->size;
          if (!field.name.starts_with("_padding")) out.push_back({name, basic->type, offset});
        } else {
          size = spread(field.type, name + ".", offset, depth + 1, out);
        }
        if (size == 0) throw ConfigError("type `" + field.type + "` is empty");
        offset += size;
        if (offset > kMostBytes) throw ConfigError("type `" + type + "` is larger than a message");
      }
    }
    return offset - begin;
  }

  std::map<std::string, std::vector<Declaration>> formats_;
  std::map<std::string, std::vector<UlogField>> spread_;  // topics so far
  std::size_t steps_ = 0;                                 // taken for all of them
};

/// A topic of the log with the least size of its messages.
struct Subscription {
  UlogSeries series;
  UlogField timestamp;
  std::size_t size = 0;  ///< up to the last field; padding behind it may be left out
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
      if (!plausible(type, size)) {
        skip_to(next_sync(end));
        continue;
      }
      if (next > end) {
        // Cut, as many logs are; or a damaged size, behind which there may be more.
        const std::size_t sync = next_sync(end);
        sync < end ? listener_.on_damage(sync - at_) : listener_.on_cut(end - at_);
        at_ = sync;
        continue;
      }
      const std::size_t begin = std::exchange(at_, next);
      if (!on_message(type, bytes_.substr(begin + kMessageHeaderSize, size))) {
        listener_.on_damage(next - begin);
      }
    }
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

  /// Where the next synchronisation message of this part begins, or the part's end.
  std::size_t next_sync(std::size_t end) const {
    return std::min(bytes_.substr(0, end).find(kSync, at_ + 1), end);
  }

  void skip_to(std::size_t place) {
    listener_.on_damage(place - at_);
    at_ = place;
  }

  /// A type that this reader does not know may come from a newer logger; it has a letter, too.
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
        return (type >= 'A' && type <= 'Z') || (type >= 'a' && type <= 'z');
    }
  }

  /// Takes a message. @return false where it is damaged
  bool on_message(char type, std::string_view body) {
    switch (type) {
      case 'B':
        return on_flags(body);
      case 'F':
        formats_.add(body);
        return true;
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
    const auto key = declaration_of(body.substr(1, length));
    const std::string_view value = body.substr(1U + length);
    if (!key) return false;
    if (type == 'I') {
      if (key->type == "char") listener_.on_text_fact(key->name, value);
      return true;
    }
    const BasicType* basic = basic_type(key->type);
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
    added.series.fields = formats_.spread(topic);
    auto& fields = added.series.fields;
    const auto timestamp = std::ranges::find(fields, "timestamp", &UlogField::name);
    if (timestamp == fields.end() || timestamp->type != Type::kUint64) {
      throw ConfigError("topic `" + topic + "` has no timestamp");
    }
    fields_ += fields.size();
    if (fields_ > kMostFields) throw ConfigError("it has too many fields");
    added.timestamp = *timestamp;
    added.size = fields.back().offset + size_of(fields.back().type);
    fields.erase(timestamp);
    topics_.insert_or_assign(number_at<std::uint16_t>(body, 1), std::move(added));
    return true;
  }

  bool on_data(std::string_view body) {
    const auto topic = topics_.find(number_at<std::uint16_t>(body, 0));
    body.remove_prefix(2);
    if (topic == topics_.end() || body.size() < topic->second.size) return false;
    const Subscription& found = topic->second;
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

  static std::size_t size_of(Type type) {
    return std::ranges::find(kBasicTypes, type, &BasicType::type)->size;
  }

  std::string_view bytes_;
  UlogListener& listener_;
  std::size_t at_ = 0;
  std::array<std::uint64_t, 3> appended_{};
  Formats formats_;
  std::unordered_map<std::uint16_t, Subscription> topics_;
  std::size_t fields_ = 0;  // of all subscriptions so far
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
