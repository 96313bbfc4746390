// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <set>
#include <string>
#include <string_view>

namespace cas::casctl {

/// The users whose programs listen at a TCP port. Pure. @param table  text of /proc/net/tcp
std::set<uid_t> listeners(std::string_view table, unsigned port);

/// Whether all listeners at a TCP port of this machine are this user's or the service's, as the
/// kernel has it: any other program may be an impostor.
bool is_own_port(const std::string& port);

}  // namespace cas::casctl
