// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/link_counter.hpp"

#include <string>

namespace cas::casctl {
namespace {

using nlohmann::json;

json member(const json& object, std::string_view key) {
  return object.is_object() ? object.value(std::string(key), json()) : json();
}

}  // namespace

std::optional<std::uint64_t> counter_of(const json& link, const casd::CounterWords& words) {
  const json block = words.group.empty() ? link : member(link, words.group);
  const json value = member(block, words.key);
  if (words.kind == casd::CounterWords::Kind::kByCause) {
    std::uint64_t sum = 0;
    for (const json& count : value) {
      if (count.is_number()) sum += count.get<std::uint64_t>();
    }
    return sum;
  }
  if (!value.is_number()) return std::nullopt;
  return value.get<std::uint64_t>();
}

}  // namespace cas::casctl
