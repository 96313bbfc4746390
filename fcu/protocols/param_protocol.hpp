// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "base/time/clock.hpp"
#include "fcu/core/outbox.hpp"
#include "fcu/flight/status_texts.hpp"
#include "fcu/params/params.hpp"
#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/param_request_read.hpp"
#include "mavlink/common/param_set.hpp"

namespace cas::fcu {

/// The parameter protocol: list (paced, `_HASH_CHECK` first), read by name or index, set. Integers
/// travel bytewise.
class ParamProtocol {
 public:
  /// @param interval  between two values of a list
  ParamProtocol(ParamStore& store, Outbox& outbox, StatusTexts& texts, base::Duration interval)
      : store_(store), outbox_(outbox), texts_(texts), interval_(interval) {}

  void on_list(int version);
  void on_read(const mavlink::common::ParamRequestRead& request, int version);
  void on_set(const mavlink::common::ParamSet& request, int version);
  /// Goes on with a list.
  void update(base::RunTime now);

 private:
  void send_value(std::size_t index, int version) const;
  void send_hash(int version);

  ParamStore& store_;
  Outbox& outbox_;
  StatusTexts& texts_;
  base::Duration interval_;
  std::optional<std::size_t> next_;  ///< index of the list's next value
  bool hash_first_ = false;
  int version_ = 2;
  base::RunTime due_{};
};

}  // namespace cas::fcu
