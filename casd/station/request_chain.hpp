// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "casd/station/services.hpp"

namespace cas::casd {

/// A request that ends with one call of its `done`.
using Request = std::function<void(Done done)>;

/// Makes requests one after the other; the first that fails ends the chain.
/// @param done  called once with the outcome of the last one, and the parameters and texts of all
void run_chain(std::vector<Request> requests, Done done);

}  // namespace cas::casd
