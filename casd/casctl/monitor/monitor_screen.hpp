// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/session/session.hpp"

namespace cas::casctl {

/// The full-screen monitor; returns when the user quits. The terminal is left as it was.
int run_monitor(const Options& options, double interval_s);

/// What the monitor shows, once, as plain tables.
int print_monitor(Session& session);

}  // namespace cas::casctl
