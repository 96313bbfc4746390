// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/model_builder.hpp"
#include "base/config/sdf_scope.hpp"

namespace cas::base {

/// The joints of a model and of those in it.
class SdfJoints {
 public:
  struct Joint {
    const XmlElement* element = nullptr;
    const SdfScope* scope = nullptr;
  };

  /// Adds those of one model. A second joint of a link, and one that holds on to the world, is told
  /// and left out.
  /// @throws ConfigError for a joint between links that are not there
  void add(const SdfScope& scope, ModelBuilder& builder);

  /// The joint that carries a link; nullptr: none. @param link  by its name in the outermost model
  const Joint* carrier_of(const std::string& link) const;

  /// Links that joints do not connect to the first link; of those connected to each other only the
  /// first.
  std::vector<std::string> loose(const std::vector<std::string>& links);

 private:
  std::string group_of(const std::string& link);

  std::map<std::string, Joint> carriers_;
  std::map<std::string, std::string> held_by_;  // a link of the same group; none: the first of it
};

}  // namespace cas::base
