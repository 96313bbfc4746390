// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/param_protocol.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "mavlink/common/param_value.hpp"
#include "mavlink_gen/runtime/message.hpp"

namespace cas::fcu {

using mavlink::common::MavParamType;
using mavlink::common::ParamRequestRead;
using mavlink::common::ParamSet;
using mavlink::common::ParamValue;

namespace {

constexpr std::string_view kHashName = "_HASH_CHECK";
constexpr std::uint16_t kNoIndex = 0xFFFF;

MavParamType wire_type(ParamType type) {
  return type == ParamType::kInt32 ? MavParamType::kInt32 : MavParamType::kReal32;
}

}  // namespace

void ParamProtocol::send_value(std::size_t index, int version) const {
  const Param& param = store_.at(index);
  ParamValue m;
  mav::set_text(m.param_id, param.name);
  m.param_value = ParamStore::to_wire(param);
  m.param_type = wire_type(param.type);
  m.param_count = static_cast<std::uint16_t>(store_.size());
  m.param_index = static_cast<std::uint16_t>(index);
  outbox_.reply(m, version);
}

void ParamProtocol::send_hash(int version) {
  ParamValue m;
  mav::set_text(m.param_id, kHashName);
  m.param_value = std::bit_cast<float>(store_.hash());
  m.param_type = MavParamType::kUint32;
  m.param_count = static_cast<std::uint16_t>(store_.size());
  m.param_index = kNoIndex;
  outbox_.reply(m, version);
}

void ParamProtocol::on_list(int version) {
  next_ = 0;
  hash_first_ = true;
  version_ = version;
  due_ = {};
}

void ParamProtocol::on_read(const ParamRequestRead& request, int version) {
  if (request.param_index >= 0) {
    const auto index = static_cast<std::size_t>(request.param_index);
    if (index < store_.size()) send_value(index, version);
    return;
  }
  const std::string_view name = mav::text(request.param_id);
  if (name == kHashName) return send_hash(version);
  if (const auto index = store_.index_of(name)) send_value(*index, version);
}

void ParamProtocol::on_set(const ParamSet& request, int version) {
  const std::string name(mav::text(request.param_id));
  if (name == kHashName) {  // the station's cache is right: no need for the rest of the list
    next_.reset();
    return;
  }
  const auto index = store_.index_of(name);
  if (!index) {
    texts_.warn("No parameter " + name);
    return;
  }
  const Param& param = store_.at(*index);
  if (request.param_type != wire_type(param.type)) {
    texts_.warn("Wrong type for parameter " + name);
  } else {
    const double value = ParamStore::from_wire(param.type, request.param_value);
    const ParamSetResult result = store_.set(name, value);
    if (result != ParamSetResult::kOk) texts_.warn("Value out of range: " + name);
  }
  // The answer carries the value in force, also after a refusal: the sender compares.
  send_value(*index, version);
}

void ParamProtocol::update(base::RunTime now) {
  while (next_ && now >= due_) {
    due_ = std::max(due_, now - interval_) + interval_;
    if (hash_first_) {
      hash_first_ = false;
      send_hash(version_);
      continue;
    }
    send_value(*next_, version_);
    if (++*next_ >= store_.size()) next_.reset();
  }
}

}  // namespace cas::fcu
