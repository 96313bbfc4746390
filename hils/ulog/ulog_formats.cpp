// SPDX-License-Identifier: BSD-3-Clause
#include "hils/ulog/ulog_formats.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include "base/error.hpp"

namespace cas::hils {
namespace {

using base::ConfigError;
using Type = UlogField::Type;

// No log of a vehicle comes near it; it bounds the time for a malicious one.
constexpr std::size_t kMostSteps = 100'000;  // to spread topics out: padding counts, too

constexpr std::array<UlogBasicType, 12> kBasicTypes{{{"int8_t", Type::kInt8, 1},
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

}  // namespace

const UlogBasicType* ulog_basic_type(std::string_view name) {
  const auto* const found = std::ranges::find(kBasicTypes, name, &UlogBasicType::name);
  return found == kBasicTypes.end() ? nullptr : found;
}

std::size_t ulog_size_of(UlogField::Type type) {
  return std::ranges::find(kBasicTypes, type, &UlogBasicType::type)->size;
}

std::optional<UlogDeclaration> ulog_declaration(std::string_view text) {
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos || space == 0 || space + 1 == text.size()) return {};
  UlogDeclaration found{.type = std::string(text.substr(0, space)),
                        .count = {},
                        .name = std::string(text.substr(space + 1))};
  const std::size_t bracket = found.type.find('[');
  if (bracket == std::string::npos) return found;
  std::size_t count = 0;
  const char* const end = found.type.data() + found.type.size();
  const auto [rest, error] = std::from_chars(found.type.data() + bracket + 1, end, count);
  if (error != std::errc{} || rest + 1 != end || *rest != ']' || count > kMostUlogBytes) return {};
  found.count = count;
  found.type.resize(bracket);
  return found;
}

void UlogFormats::add(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return;  // a user of the type reports it missing
  std::vector<UlogDeclaration> fields;
  for (std::string_view rest = text.substr(colon + 1); !rest.empty();) {
    const std::size_t end = std::min(rest.find(';'), rest.size());
    auto field = ulog_declaration(rest.substr(0, end));
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

const std::vector<UlogField>& UlogFormats::spread(const std::string& topic) {
  if (const auto known = spread_.find(topic); known != spread_.end()) return known->second;
  std::vector<UlogField> fields;
  bytes_[topic] = spread(topic, "", 0, 0, fields);
  return spread_.emplace(topic, std::move(fields)).first->second;
}

/// @return bytes that the type takes
std::size_t UlogFormats::spread(const std::string& type, const std::string& prefix,
                                std::size_t offset, int depth, std::vector<UlogField>& out) {
  constexpr int kMostDepth = 16;
  const auto format = formats_.find(type);
  if (format == formats_.end()) throw ConfigError("type `" + type + "` is used, but not defined");
  if (depth == kMostDepth) throw ConfigError("type `" + type + "` is nested too deep");
  const std::size_t begin = offset;
  for (const UlogDeclaration& field : format->second) {
    const UlogBasicType* basic = ulog_basic_type(field.type);
    for (std::size_t i = 0; i < field.count.value_or(1); ++i) {
      std::string name = prefix + field.name;
      if (field.count) name += "[" + std::to_string(i) + "]";
      if (name.size() > kMostUlogNameBytes) {
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
      if (offset > kMostUlogBytes)
        throw ConfigError("type `" + type + "` is larger than a message");
    }
  }
  return offset - begin;
}

}  // namespace cas::hils
