// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace cas::base::cli {

/// How many letters must be changed, added, left out or swapped with their neighbour to turn one
/// word into the other (optimal string alignment).
std::size_t edit_distance(const std::string& from, const std::string& to);

/// The known word that was most likely meant: at most a third of its letters differ, or it is the
/// only one that begins so. @return empty: none is near
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean 'status'?", or nothing.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& known);

}  // namespace cas::base::cli
