// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_joints.hpp"

#include <set>

namespace cas::base {

void SdfJoints::add(const SdfScope& scope, ModelBuilder& builder) {
  for (const XmlElement& joint : scope.model().children) {
    if (joint.name != "joint") continue;
    const std::string who = "joint '" + std::string(joint.attribute("name")) + "'";
    for (const char* end : {"parent", "child"}) {
      if (joint.child_text(end).empty()) joint.fail(who + " has no <" + end + ">");
    }
    if (joint.child_text("parent") == "world" || joint.child_text("child") == "world") {
      builder.warn(joint, who + " holds the model to the world: left out, a vehicle flies");
      continue;
    }
    const auto child = scope.link_of(joint.child_text("child"), joint);
    const auto parent = scope.link_of(joint.child_text("parent"), joint);
    if (!child) continue;
    if (!carriers_.emplace(*child, Joint{&joint, &scope}).second) {
      builder.warn(joint,
                   who + " carries link '" + *child + "', which another joint carries: left out");
      continue;
    }
    if (parent && group_of(*child) != group_of(*parent)) {
      held_by_[group_of(*child)] = group_of(*parent);
    }
  }
}

const SdfJoints::Joint* SdfJoints::carrier_of(const std::string& link) const {
  const auto found = carriers_.find(link);
  return found == carriers_.end() ? nullptr : &found->second;
}

std::vector<std::string> SdfJoints::loose(const std::vector<std::string>& links) {
  std::vector<std::string> result;
  std::set<std::string> groups;
  for (const std::string& link : links) {
    if (groups.insert(group_of(link)).second && groups.size() > 1) result.push_back(link);
  }
  return result;
}

std::string SdfJoints::group_of(const std::string& link) {
  std::string group = link;
  for (auto by = held_by_.find(group); by != held_by_.end(); by = held_by_.find(group)) {
    group = by->second;
  }
  return group;
}

}  // namespace cas::base
