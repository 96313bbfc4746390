// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_scope.hpp"

#include <charconv>

#include "base/angles.hpp"
#include "base/config/model_builder.hpp"
#include "base/text.hpp"

namespace cas::base {
namespace {

constexpr int kMostFrames = 100;  // frames on frames; more is a circle

[[noreturn]] void fail_missing(std::string_view name, const XmlElement& asking) {
  asking.fail("the model has no link, joint or frame '" + std::string(name) + "'");
}

/// Whether "1.4" or another version before 1.5 is meant; a file without a version is none.
bool is_before_1_5(std::string_view version) {
  int major = 0;
  int minor = 0;
  const char* const end = version.data() + version.size();
  const auto dot = std::from_chars(version.data(), end, major);
  if (dot.ptr != end) std::from_chars(dot.ptr + 1, end, minor);
  return major == 1 && minor <= 4;
}

/// Pose that a non-empty <pose> states, in the frame that it names.
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

bool is_true(std::string_view flag) { return lower(flag) == "true" || flag == "1"; }

std::string_view sdf_part_name(const XmlElement& model, const XmlElement* include) {
  const std::string_view given = include != nullptr ? include->child_text("name") : "";
  return given.empty() ? model.attribute("name") : given;
}

SdfScope::SdfScope(const XmlElement& model, std::string_view version, std::filesystem::path file)
    : model_(model), file_(std::move(file)), axes_in_model_(is_before_1_5(version)) {
  for (const char* kind : {"link", "frame", "joint"}) {  // up to SDF 1.6 they may share a name
    for (const XmlElement& child : model.children) {
      if (child.name == kind) by_name_.emplace(child.attribute("name"), &child);
    }
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
  fail_missing(name, asking);
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
    const auto inside = name_in(*part, name);
    if (!inside) continue;
    if (const auto X = part->find_frame(*inside, asking, depth + 1)) {
      return placed(*part, depth + 1) * *X;
    }
  }
  return std::nullopt;
}

/// A name of this model as a part has it; that of its own frame for the part itself.
std::optional<std::string_view> SdfScope::name_in(const SdfScope& part,
                                                  std::string_view name) const {
  if (part.merged_) return name;
  if (!name.starts_with(part.name_)) return std::nullopt;
  name.remove_prefix(part.name_.size());
  if (name.empty()) return kModelFrame;
  if (!name.starts_with("::")) return std::nullopt;
  return name.substr(2);
}

void SdfScope::leave_out(std::string_view name, bool merged) {
  left_out_.emplace(name);
  misses_names_ |= merged;
}

bool SdfScope::is_left_out(std::string_view name) const {
  return misses_names_ || left_out_.contains(name.substr(0, name.find("::")));
}

std::optional<std::string> SdfScope::link_of(std::string_view name, const XmlElement& asking,
                                             int depth) const {
  if (auto link = find_link(name, asking, depth)) return link;
  if (is_left_out(name)) return std::nullopt;
  fail_missing(name, asking);
}

std::optional<std::string> SdfScope::find_link(std::string_view name, const XmlElement& asking,
                                               int depth) const {
  if (depth > kMostFrames) asking.fail("frames are attached to each other in a circle");
  if (name == kModelFrame) name = frame_of_model();
  if (const auto found = by_name_.find(name); found != by_name_.end()) {
    const XmlElement& child = *found->second;
    if (child.name == "link") return prefix_ + std::string(name);
    if (child.name == "joint") return link_of(child.child_text("child"), child, depth + 1);
    const std::string_view attached = child.attribute("attached_to");
    return link_of(attached.empty() ? kModelFrame : attached, child, depth + 1);
  }
  for (const auto& part : parts_) {
    const auto inside = name_in(*part, name);
    if (!inside) continue;
    if (auto link = part->find_link(*inside, asking, depth + 1)) return link;
  }
  return std::nullopt;
}

/// The link that a model's own frame is attached to, or the part that has it.
std::string_view SdfScope::frame_of_model() const {
  if (!model_.attribute("canonical_link").empty()) return model_.attribute("canonical_link");
  if (const XmlElement* const first = model_.child("link")) return first->attribute("name");
  if (parts_.empty()) return "";
  return parts_.front()->merged_ ? parts_.front()->frame_of_model() : parts_.front()->name_;
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
