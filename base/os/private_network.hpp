// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "base/export.hpp"

namespace cas::base {

/// Gives this process, and those that it starts from now on, a network of their own: 127.0.0.1 with
/// all its ports, and nothing else. Unix sockets are files, and reach out of it. Must be called
/// before the first thread.
///
/// Linux needs the right to make network namespaces: root has it, others where user namespaces are
/// allowed (kernel.unprivileged_userns_clone, as on Debian).
/// @return why there is none; nullopt: the process is in it
CAS_BASE_EXPORT std::optional<std::string> enter_private_network();

}  // namespace cas::base
