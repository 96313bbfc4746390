// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/protocols/param_protocol.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "fcu/core/fcu_core.hpp"
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

void ParamProtocol::send_value(std::size_t index, FcuCore& core, int version) const {
  const Param& param = core.params.at(index);
  ParamValue m;
  mav::set_text(m.param_id, param.name);
  m.param_value = ParamStore::to_wire(param);
  m.param_type = wire_type(param.type);
  m.param_count = static_cast<std::uint16_t>(core.params.size());
  m.param_index = static_cast<std::uint16_t>(index);
  core.outbox.reply(m, version);
}

void ParamProtocol::send_hash(FcuCore& core, int version) {
  ParamValue m;
  mav::set_text(m.param_id, kHashName);
  m.param_value = std::bit_cast<float>(core.params.hash());
  m.param_type = MavParamType::kUint32;
  m.param_count = static_cast<std::uint16_t>(core.params.size());
  m.param_index = kNoIndex;
  core.outbox.reply(m, version);
}

void ParamProtocol::on_list(int version) {
  next_ = 0;
  hash_first_ = true;
  version_ = version;
  due_ = {};
}

void ParamProtocol::on_read(const ParamRequestRead& request, FcuCore& core, int version) {
  if (request.param_index >= 0) {
    const auto index = static_cast<std::size_t>(request.param_index);
    if (index < core.params.size()) send_value(index, core, version);
    return;
  }
  const std::string_view name = mav::text(request.param_id);
  if (name == kHashName) return send_hash(core, version);
  if (const auto index = core.params.index_of(name)) send_value(*index, core, version);
}

void ParamProtocol::on_set(const ParamSet& request, FcuCore& core, int version) {
  const std::string name(mav::text(request.param_id));
  if (name == kHashName) {  // the station's cache is right: no need for the rest of the list
    next_.reset();
    return;
  }
  const auto index = core.params.index_of(name);
  if (!index) {
    core.texts.warn("No parameter " + name);
    return;
  }
  const Param& param = core.params.at(*index);
  if (request.param_type != wire_type(param.type)) {
    core.texts.warn("Wrong type for parameter " + name);
  } else {
    const double value = ParamStore::from_wire(param.type, request.param_value);
    const ParamSetResult result = core.params.set(name, value);
    if (result != ParamSetResult::kOk) core.texts.warn("Value out of range: " + name);
  }
  // The answer carries the value in force, also after a refusal: the sender compares.
  send_value(*index, core, version);
}

void ParamProtocol::update(FcuCore& core, base::RunTime now) {
  while (next_ && now >= due_) {
    due_ = std::max(due_, now - interval_) + interval_;
    if (hash_first_) {
      hash_first_ = false;
      send_hash(core, version_);
      continue;
    }
    send_value(*next_, core, version_);
    if (++*next_ >= core.params.size()) next_.reset();
  }
}

}  // namespace cas::fcu
