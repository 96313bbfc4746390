// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "base/time/clock.hpp"
#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/param_request_read.hpp"
#include "mavlink/common/param_set.hpp"

namespace cas::fcu {

struct FcuCore;

/// The parameter protocol: list (paced, `_HASH_CHECK` first), read by name or index, set. Integers
/// travel bytewise.
class ParamProtocol {
 public:
  /// @param interval  between two values of a list
  explicit ParamProtocol(base::Duration interval) : interval_(interval) {}

  void on_list(int version);
  void on_read(const mavlink::common::ParamRequestRead& request, FcuCore& core, int version);
  void on_set(const mavlink::common::ParamSet& request, FcuCore& core, int version);
  /// Goes on with a list.
  void update(FcuCore& core, base::RunTime now);

 private:
  void send_value(std::size_t index, FcuCore& core, int version) const;
  static void send_hash(FcuCore& core, int version);

  base::Duration interval_;
  std::optional<std::size_t> next_;  ///< index of the list's next value
  bool hash_first_ = false;
  int version_ = 2;
  base::RunTime due_{};
};

}  // namespace cas::fcu
