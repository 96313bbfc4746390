// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "hils/measure/run_record.hpp"

namespace cas::hils {

/// Each hop according to the ledgers of a run, for the page's link diagram:
///
///   hops:  one from point to point ("sim>casd"), with a bin for each second of simulated time:
///          packets that left, that arrived, and the median and 99 % of their delays, us
///   relay: casd's own time, in the same bins
///   loop:  from a sensor message to the control that answers it, in the same bins
///   tapes: 20 ms of packets each 4 s, and around each second with a loss: [message id, moment of
///          leaving, us on the way]; a packet that did not arrive has its id negated
///
/// Where casd kept no ledger there is one hop each way, and where only echoes are known no hop has
/// delays. Null without any packet.
nlohmann::ordered_json hop_record(const RunRecord& record);

}  // namespace cas::hils
