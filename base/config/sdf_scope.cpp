// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_scope.hpp"

#include <charconv>

#include "base/angles.hpp"
#include "base/config/model_builder.hpp"

namespace cas::base {
namespace {

constexpr int kMostFrames = 100;  // frames on frames; more is a circle

bool is_true(std::string_view flag) { return flag == "true" || flag == "1"; }

/// Whether "1.4" or another version before 1.5 is meant; a file without a version is none.
bool is_before_1_5(std::string_view version) {
  int major = 0;
  int minor = 0;
  const char* const end = version.data() + version.size();
  const auto dot = std::from_chars(version.data(), end, major);
  if (dot.ptr != end) std::from_chars(dot.ptr + 1, end, minor);
  return major == 1 && minor <= 4;
}

/// Of a <pose> that is not empty, in the frame that it names.
Eigen::Isometry3d own_pose(const XmlElement& pose) {
  const std::string_view format = pose.attribute("rotation_format");
  const bool is_quaternion = format == "quat_xyzw";
  if (!format.empty() && format != "euler_rpy" && !is_quaternion) {
    pose.fail("the rotation_format of a <pose> is euler_rpy or quat_xyzw");
  }
  const std::vector<double> v = pose.numbers(is_quaternion ? 7 : 6);
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  if (is_quaternion) {
    const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    if (!(q.norm() > 1e-9)) pose.fail("the quaternion of a <pose> has no length");
    X.linear() = q.normalized().toRotationMatrix();
  } else {
    const double unit = is_true(pose.attribute("degrees")) ? kRadPerDeg : 1.0;
    X.linear() = rotation_rpy(unit * v[3], unit * v[4], unit * v[5]);
  }
  return X;
}

}  // namespace

std::string_view sdf_part_name(const XmlElement& model, const XmlElement* include) {
  const std::string_view given = include != nullptr ? include->child_text("name") : "";
  return given.empty() ? model.attribute("name") : given;
}

SdfScope::SdfScope(const XmlElement& model, std::string_view version, std::filesystem::path file)
    : model_(model), file_(std::move(file)), axes_in_model_(is_before_1_5(version)) {
  for (const XmlElement& child : model.children) {
    if (child.name != "link" && child.name != "joint" && child.name != "frame") continue;
    by_name_.emplace(child.attribute("name"), &child);
  }
}

SdfScope::SdfScope(const XmlElement& model, std::string_view version, std::filesystem::path file,
                   const SdfScope& parent, const XmlElement* include)
    : SdfScope(model, version, std::move(file)) {
  include_ = include;
  name_ = sdf_part_name(model, include);
  merged_ = include != nullptr && is_true(include->attribute("merge"));
  prefix_ = merged_ ? parent.prefix_ : parent.prefix_ + name_ + "::";
}

Eigen::Isometry3d SdfScope::pose(const XmlElement& element, std::string_view parent,
                                 int depth) const {
  const XmlElement* const own = element.child("pose");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  if (own != nullptr) {
    if (!own->attribute("frame").empty()) parent = own->attribute("frame");  // up to SDF 1.6
    if (!own->attribute("relative_to").empty()) parent = own->attribute("relative_to");
    if (!element.child_text("pose").empty()) X = own_pose(*own);
  }
  return frame(parent, element, depth + 1) * X;
}

Eigen::Isometry3d SdfScope::frame(std::string_view name, const XmlElement& asking,
                                  int depth) const {
  if (const auto X = find_frame(name, asking, depth)) return *X;
  asking.fail("the model has no link, joint or frame '" + std::string(name) + "'");
}

std::optional<Eigen::Isometry3d> SdfScope::find_frame(std::string_view name,
                                                      const XmlElement& asking, int depth) const {
  if (name == kModelFrame) return Eigen::Isometry3d::Identity();
  if (depth > kMostFrames) asking.fail("poses go round in a circle");
  if (const auto found = by_name_.find(name); found != by_name_.end()) {
    const XmlElement& child = *found->second;
    if (child.name == "link") return pose(child, kModelFrame, depth);
    if (child.name == "joint") return pose(child, child.child_text("child"), depth);
    const std::string_view attached = child.attribute("attached_to");
    return pose(child, attached.empty() ? kModelFrame : attached, depth);
  }
  for (const auto& part : parts_) {
    std::string_view inside = name;
    if (!part->merged_) {
      if (!inside.starts_with(part->name_)) continue;
      inside.remove_prefix(part->name_.size());
      if (inside.empty()) return placed(*part, depth + 1);
      if (!inside.starts_with("::")) continue;
      inside.remove_prefix(2);
    }
    if (const auto X = part->find_frame(inside, asking, depth + 1)) {
      return placed(*part, depth + 1) * *X;
    }
  }
  return std::nullopt;
}

Eigen::Isometry3d SdfScope::placed(const SdfScope& part, int depth) const {
  const bool posed = part.include_ != nullptr && part.include_->child("pose") != nullptr;
  const Eigen::Isometry3d X = pose(posed ? *part.include_ : part.model_, kModelFrame, depth);
  std::string_view placement =
      part.include_ != nullptr ? part.include_->child_text("placement_frame") : "";
  if (placement.empty()) placement = part.model_.attribute("placement_frame");
  if (placement.empty()) return X;
  return X * part.frame(placement, part.model_, depth + 1).inverse();
}

}  // namespace cas::base
