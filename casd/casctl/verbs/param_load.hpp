// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "casd/casctl/session/session.hpp"

namespace cas::casctl {

/// `casctl param load`: sets the parameters of a file in its order. A parameter that the vehicle
/// does not have, keeps or refuses costs no other one: all are named at the end.
/// @param strict  every name is read first, and nothing is written if one is missing; the first
/// parameter that is not taken ends it
/// @param not_hil  consents to those that arm or drive outputs of a vehicle that is not in HIL
/// @return kDone: all are in force; else kRefused, or kTimeout where the vehicle fell silent
/// @throws as Session::vehicle_call(), after it has told what is in force
int load_params(Session& session, const std::string& file, bool strict, bool not_hil);

}  // namespace cas::casctl
