// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>

#include "libsim/core/load/sdf_headers.hpp"

namespace cas::sim {

/// libsdformat's description of all elements that SDF knows. libsdformat gives each element that it
/// reads a copy of the description of all that may be in it: this is nearly all that reading takes.
class SdfDescription {
 public:
  using IsUsed = std::function<bool(const std::string& element)>;

  /// The description of the whole of SDF.
  SdfDescription();
  /// Without the elements that are not used and have others in them, unless every file has them.
  /// Values stay, because their defaults count, and so does all that is in a sensor.
  SdfDescription(const SdfDescription& whole, const IsUsed& is_used);

  /// What libsdformat takes for an element of that name.
  std::size_t kilobytes_of(const std::string& element) const;
  /// To be read into, once.
  const sdf::SDFPtr& sdf() const { return sdf_; }

 private:
  sdf::SDFPtr sdf_;
  std::map<std::string, std::size_t> sizes_;  // elements that a description has, by its name
};

}  // namespace cas::sim
