// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <tuple>

#include "base/config/config_keys.hpp"
#include "fcu/line/line_model.hpp"

namespace cas::fcu {

/// Probability that something happens.
inline constexpr base::Range kProbability{0, 1};
/// A time in microseconds, an hour at most.
inline constexpr base::Range kLineTime_us{0, 3.6e9, 1e-6};
inline constexpr base::Range kLineBaud{0, 100e6};
inline constexpr base::Whole kLineBuffer{0, 1'000'000'000};

/// Keys of a serial line. Its preset is read before the others, which override it.
inline constexpr std::tuple kLineKeys{
    base::key<&LineConfig::preset>(
        "preset", base::ReadApart{"ideal, usb, baud_921600, baud_460800, baud_115200"},
        "the others override it", "ideal"),
    base::key<&LineConfig::baud>("baud", kLineBaud,
                                 "byte clock of each direction, ten bits a byte; 0: none"),
    base::key<&LineConfig::clock_drift_ppm>("clock_drift_ppm", base::Range{-50000, 50000},
                                            "sender's clock against nominal, positive is slow"),
    base::key<&LineConfig::extra_delay>("extra_delay_us", kLineTime_us, "added to every byte"),
    base::key<&LineConfig::jitter>(
        "jitter_us", kLineTime_us,
        "uniform from 0, added per write; bytes never overtake each other"),
    base::key<&LineConfig::batch>(
        "batch_us", kLineTime_us,
        "bytes arrive in batches, one each time this has passed (USB: 1000)"),
    base::key<&LineConfig::stall_every>("stall_every_us", kLineTime_us, "mean time between stalls"),
    base::key<&LineConfig::stall_length>("stall_length_us", kLineTime_us, "length of a stall"),
    base::key<&LineConfig::bit_error_rate>("bit_error_rate", base::Range{0, 0.5},
                                           "probability per bit"),
    base::key<&LineConfig::burst_begin>("burst_begin", kProbability,
                                        "Gilbert-Elliott: probability per byte, good to bad"),
    base::key<&LineConfig::burst_end>("burst_end", base::Range{1e-9, 1},
                                      "Gilbert-Elliott: probability per byte, bad to good"),
    base::key<&LineConfig::burst_loss>("burst_loss", kProbability,
                                       "probability that a byte is lost while bad"),
    base::key<&LineConfig::packet_loss>("packet_loss", kProbability,
                                        "probability that a write is lost"),
    base::key<&LineConfig::packet_duplicate>("packet_duplicate", kProbability,
                                             "probability that a write arrives twice"),
    base::key<&LineConfig::packet_reorder>(
        "packet_reorder", kProbability,
        "probability that a write is overtaken by the next one, within 50 ms"),
    base::key<&LineConfig::receiver_baud>(
        "receiver_baud", kLineBaud,
        "the receiver's rate: a difference corrupts bytes or loses them by framing errors; at "
        "least 1, or 0: the sender's rate"),
    base::key<&LineConfig::send_buffer_bytes>("send_buffer_bytes", kLineBuffer,
                                              "room before the writer is held back; 0: unlimited"),
    base::key<&LineConfig::receive_fifo_bytes>(
        "receive_fifo_bytes", kLineBuffer,
        "bytes that may wait to be read; more are lost; 0: unlimited"),
    base::key<&LineConfig::receive_trigger_bytes>(
        "receive_trigger_bytes", base::Whole{1, 1'000'000'000},
        "a receiver is woken after this many bytes of a longer packet"),
};

}  // namespace cas::fcu
