// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/session/command_line.hpp"

namespace cas::casctl {

/// status, links.
void add_status_verbs(CommandLine& line);
/// arm, takeoff, goto, mode, manual, ...
void add_flight_verbs(CommandLine& line);
/// setgain, gains, param.
void add_param_verbs(CommandLine& line);
/// watch: telemetry as lines.
void add_watch_verb(CommandLine& line);
/// message: the newest of a kind.
void add_message_verb(CommandLine& line);
/// words: called by the completion scripts.
void add_words_verb(CommandLine& line);
/// link add, link remove.
void add_link_verbs(CommandLine& line);
/// drops.
void add_drops_verb(CommandLine& line);
/// log start, log stop, log status.
void add_log_verb(CommandLine& line);
/// routes, drops, latency, budget, log, reload, reboot.
void add_service_verbs(CommandLine& line);

}  // namespace cas::casctl
