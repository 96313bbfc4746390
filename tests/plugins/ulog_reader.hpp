// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace cas::test {

/// Reads a ULog file by the rules of its specification; throws for each that is broken.
class UlogReader {
 public:
  struct Field {
    std::string type;
    std::string name;
    std::size_t count = 1;
    std::size_t offset = 0;
  };
  struct Format {
    std::vector<Field> fields;
    std::size_t size = 0;
  };
  struct Message {
    std::uint64_t timestamp = 0;
    std::vector<std::uint8_t> bytes;
  };

  explicit UlogReader(const std::string& file) {
    std::ifstream stream(file, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(stream), {});
    read_header();
    while (place_ < bytes_.size()) read_message();
  }

  const std::map<std::string, Format>& formats() const { return formats_; }
  const std::vector<Message>& messages(const std::string& topic) const { return data_.at(topic); }
  bool has(const std::string& topic) const { return data_.count(topic) != 0; }
  /// The bytes of a fact's value.
  const std::string& info(const std::string& key) const { return info_.at(key); }
  /// Parameters as they were when the log began.
  const std::map<std::string, double>& params() const { return params_; }
  struct Change {
    std::uint64_t timestamp = 0;  ///< of the message before it
    std::string name;
    double value = 0;
  };
  const std::vector<Change>& changes() const { return changes_; }
  struct Text {
    std::uint64_t timestamp = 0;
    int severity = 0;
    std::string text;
  };
  const std::vector<Text>& texts() const { return texts_; }
  /// Whether no message of any topic is older than the one before it.
  bool is_in_order() const { return in_order_; }

  /// A number of a message, whatever its type.
  double value(const std::string& topic, const Message& message, const std::string& field,
               std::size_t index = 0) const {
    for (const Field& candidate : formats_.at(topic).fields) {
      if (candidate.name != field) continue;
      return number(candidate.type,
                    message.bytes.data() + candidate.offset + index * size_of(candidate.type));
    }
    throw std::runtime_error("no field " + field);
  }

 private:
  static void require(bool condition, const std::string& rule) {
    if (!condition) throw std::runtime_error("ULog rule broken: " + rule);
  }

  static std::size_t size_of(const std::string& type) {
    static const std::map<std::string, std::size_t> sizes{
        {"int8_t", 1},  {"uint8_t", 1},  {"bool", 1},     {"char", 1},
        {"int16_t", 2}, {"uint16_t", 2}, {"int32_t", 4},  {"uint32_t", 4},
        {"float", 4},   {"int64_t", 8},  {"uint64_t", 8}, {"double", 8}};
    require(sizes.count(type) != 0, "type " + type + " is unknown");
    return sizes.at(type);
  }

  static double number(const std::string& type, const std::uint8_t* bytes) {
    if (type == "float") return load<float>(bytes);
    if (type == "double") return load<double>(bytes);
    if (type == "uint64_t") return static_cast<double>(load<std::uint64_t>(bytes));
    if (type == "int32_t") return load<std::int32_t>(bytes);
    if (type == "uint32_t") return load<std::uint32_t>(bytes);
    if (type == "int8_t") return load<std::int8_t>(bytes);
    require(size_of(type) == 1, "reader knows no " + type);
    return *bytes;
  }

  template <class T>
  static T load(const std::uint8_t* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
  }

  void read_header() {
    require(bytes_.size() >= 16, "the header has 16 bytes");
    const std::string magic = {'U', 'L', 'o', 'g', 0x01, 0x12, 0x35};
    require(std::string(bytes_.begin(), bytes_.begin() + 7) == magic, "magic");
    require(bytes_[7] <= 1, "version");
    place_ = 16;
  }

  void read_message() {
    require(place_ + 3 <= bytes_.size(), "message header");
    const auto size = load<std::uint16_t>(bytes_.data() + place_);
    const char type = static_cast<char>(bytes_[place_ + 2]);
    require(place_ + 3 + size <= bytes_.size(), "message is whole");
    const std::vector<std::uint8_t> body(bytes_.begin() + static_cast<long>(place_) + 3,
                                         bytes_.begin() + static_cast<long>(place_) + 3 + size);
    require(place_ != 16 || type == 'B', "flag bits come first");
    place_ += 3U + size;
    switch (type) {
      case 'B':
        return read_flags(body);
      case 'F':
        return read_format(std::string(body.begin(), body.end()));
      case 'I':
        return read_info(body);
      case 'P':
        return read_param(body);
      case 'L':
        return read_text(body);
      case 'A':
        return read_subscription(body);
      case 'D':
        return read_data(body);
      default:
        require(false, std::string("type ") + type);
    }
  }

  void read_flags(const std::vector<std::uint8_t>& body) {
    require(body.size() == 40, "flag bits have 40 bytes");
    for (std::size_t i = 8; i < 16; ++i) require(body[i] == 0, "no unknown incompatible flag");
  }

  void read_format(const std::string& text) {
    require(subscriptions_.empty(), "formats come before data");
    const std::size_t colon = text.find(':');
    require(colon != std::string::npos, "format has a name");
    Format format;
    for (std::size_t start = colon + 1; start < text.size();) {
      const std::size_t end = text.find(';', start);
      require(end != std::string::npos, "each field ends with ';'");
      format.fields.push_back(read_field(text.substr(start, end - start)));
      format.fields.back().offset = format.size;
      format.size += size_of(format.fields.back().type) * format.fields.back().count;
      start = end + 1;
    }
    require(format.fields.at(0).name == "timestamp" && format.fields[0].type == "uint64_t",
            "the timestamp comes first");
    require(formats_.emplace(text.substr(0, colon), format).second, "format names are unique");
  }

  static Field read_field(const std::string& text) {
    const std::size_t space = text.find(' ');
    require(space != std::string::npos, "field has type and name");
    Field field{text.substr(0, space), text.substr(space + 1)};
    const std::size_t bracket = field.type.find('[');
    if (bracket != std::string::npos) {
      field.count = std::stoul(field.type.substr(bracket + 1));
      field.type.resize(bracket);
    }
    size_of(field.type);
    return field;
  }

  static std::pair<Field, std::string> read_pair(const std::vector<std::uint8_t>& body) {
    const std::size_t length = body.at(0);
    require(1 + length <= body.size(), "info has a key");
    const Field key =
        read_field(std::string(body.begin() + 1, body.begin() + 1 + static_cast<long>(length)));
    const std::string value(body.begin() + 1 + static_cast<long>(length), body.end());
    require(value.size() == size_of(key.type) * key.count, "info value has its type's size");
    return {key, value};
  }

  void read_info(const std::vector<std::uint8_t>& body) {
    const auto [key, value] = read_pair(body);
    require(subscriptions_.empty(), "info comes before data");
    require(info_.emplace(key.name, value).second, "info keys are unique");
  }

  void read_param(const std::vector<std::uint8_t>& body) {
    const auto [key, value] = read_pair(body);
    require(key.count == 1 && (key.type == "int32_t" || key.type == "float"), "type of parameters");
    const double v = number(key.type, reinterpret_cast<const std::uint8_t*>(value.data()));
    if (!subscriptions_.empty()) return changes_.push_back({newest_, key.name, v});
    require(params_.emplace(key.name, v).second, "parameters are unique before data");
  }

  void read_text(const std::vector<std::uint8_t>& body) {
    require(body.size() >= 9, "text has severity and time");
    require(body[0] >= '0' && body[0] <= '7', "severity of syslog");
    texts_.push_back({load<std::uint64_t>(body.data() + 1), body[0] - '0',
                      std::string(body.begin() + 9, body.end())});
  }

  void read_subscription(const std::vector<std::uint8_t>& body) {
    require(body.size() > 3, "subscription has a name");
    const auto id = load<std::uint16_t>(body.data() + 1);
    const std::string name(body.begin() + 3, body.end());
    require(formats_.count(name) != 0, "subscription has a format");
    require(subscriptions_.emplace(id, name).second, "message ids are unique");
  }

  void read_data(const std::vector<std::uint8_t>& body) {
    const auto subscription = subscriptions_.find(load<std::uint16_t>(body.data()));
    require(subscription != subscriptions_.end(), "data has a subscription");
    require(body.size() == 2 + formats_.at(subscription->second).size,
            "data has its format's size");
    Message message{load<std::uint64_t>(body.data() + 2), {body.begin() + 2, body.end()}};
    auto& messages = data_[subscription->second];
    require(messages.empty() || messages.back().timestamp <= message.timestamp, "time goes on");
    in_order_ = in_order_ && message.timestamp >= newest_;
    newest_ = std::max(newest_, message.timestamp);
    messages.push_back(std::move(message));
  }

  std::vector<std::uint8_t> bytes_;
  std::size_t place_ = 0;
  std::map<std::string, Format> formats_;
  std::map<std::string, std::string> info_;
  std::map<std::string, double> params_;
  std::vector<Change> changes_;
  std::vector<Text> texts_;
  std::uint64_t newest_ = 0;  ///< stamp
  bool in_order_ = true;
  std::map<std::uint16_t, std::string> subscriptions_;
  std::map<std::string, std::vector<Message>> data_;
};

}  // namespace cas::test
