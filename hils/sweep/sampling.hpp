// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "hils/sweep/study.hpp"

namespace cas::hils {

/// Points in the open unit cube, one row each; the same for the same arguments on every machine.
///
/// kRandom and kLatinHypercube give each parameter a stream of its own, named after it, so that one
/// more parameter changes no other. kSobol takes no seed: it is Sobol's sequence in Gray-code order
/// with the direction numbers of [Joe-Kuo] (Boost.Random), without the corner at 0 that it begins
/// with.
///
/// @param names  of the parameters, one for each dimension
std::vector<std::vector<double>> unit_points(Sampling sampling, std::size_t count,
                                             const std::vector<std::string>& names,
                                             std::uint64_t seed);

}  // namespace cas::hils
