// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/sdf_model.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/angles.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cas::base {
namespace {

constexpr int kDeepest = 100;          // frames on frames; more is a circle
constexpr double kEndless_rad = 1000;  // between a joint's limits

constexpr std::string_view kModelFrame = "__model__";

std::string child_text(const XmlElement& element, std::string_view name) {
  const XmlElement* const child = element.child(name);
  if (child == nullptr) return {};
  const std::size_t begin = child->text.find_first_not_of(" \t\r\n");
  if (begin == std::string::npos) return {};
  return child->text.substr(begin, child->text.find_last_not_of(" \t\r\n") - begin + 1);
}

}  // namespace

bool SdfModel::is_sdf(std::string_view text) {
  // Before <sdf> there may be a declaration, a document type and comments.
  for (std::size_t at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("<!--")) {
      at = text.find("-->", at);
      if (at == text.npos) return false;
    } else if (!rest.starts_with("<?") && !rest.starts_with("<!")) {
      return rest.starts_with("<sdf ") || rest.starts_with("<sdf>") || rest.starts_with("<sdf\n");
    }
  }
  return false;
}

SdfModel::SdfModel(std::string_view text, const std::filesystem::path& file)
    : file_(file.string()), root_(parse_xml(text, file_)) {
  model_ = root_.child("model");
  if (model_ == nullptr) fail(root_, "has no <model>; a world is no vehicle");
  const std::string_view version = root_.attribute("version");
  const char* const version_end = version.data() + version.size();
  const auto major = std::from_chars(version.data(), version_end, version_[0]);
  if (major.ptr != version_end) std::from_chars(major.ptr + 1, version_end, version_[1]);
  for (const XmlElement& child : model_->children) {
    if (child.name == "include" || child.name == "model") {
      fail(child, "<" + child.name +
                      "> is not followed in a vehicle's model: name the file that has the links");
    }
    if (child.name != "link") continue;
    links_.push_back({std::string(child.attribute("name")), pose(child, kModelFrame, 0), &child});
  }
  if (links_.empty()) fail(*model_, "has no <link>");
}

void SdfModel::fail(const XmlElement& at, const std::string& sentence) const {
  throw ConfigError(file_ + ":" + std::to_string(at.line) + ": " + sentence);
}

std::vector<double> SdfModel::numbers(const XmlElement& element, std::size_t count) const {
  std::vector<double> values;
  if (const auto word = read_numbers(element.text, values)) {
    fail(element, "<" + element.name + "> is not made of numbers: " + no_number(*word));
  }
  if (values.size() != count) {
    fail(element, "<" + element.name + "> has " + std::to_string(values.size()) +
                      " numbers instead of " + std::to_string(count));
  }
  return values;
}

double SdfModel::number(const XmlElement& element) const { return numbers(element, 1)[0]; }

Eigen::Vector3d SdfModel::vector(const XmlElement& element) const {
  const std::vector<double> values = numbers(element, 3);
  return {values[0], values[1], values[2]};
}

// Poses.

/// An element's own pose in the model's frame. @param parent  frame of the pose when it has no
/// relative_to
Eigen::Isometry3d SdfModel::pose(const XmlElement& element, std::string_view parent,
                                 int depth) const {
  const XmlElement* const own = element.child("pose");
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  if (own != nullptr) {
    if (!own->attribute("relative_to").empty()) parent = own->attribute("relative_to");
    const std::string_view format = own->attribute("rotation_format");
    if (!format.empty() && format != "euler_rpy") fail(*own, "a <pose> must be in Euler angles");
    const double unit =
        own->attribute("degrees") == "true" || own->attribute("degrees") == "1" ? kRadPerDeg : 1.0;
    const bool empty = own->text.find_first_not_of(" \t\r\n") == std::string::npos;
    const std::vector<double> v = empty ? std::vector<double>(6, 0.0) : numbers(*own, 6);
    X.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    X.linear() = (Eigen::AngleAxisd(unit * v[5], Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(unit * v[4], Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(unit * v[3], Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
  }
  return frame(parent, element, depth + 1) * X;
}

/// A link, joint or frame by name, in the model's frame.
Eigen::Isometry3d SdfModel::frame(std::string_view name, const XmlElement& asking,
                                  int depth) const {
  if (name == kModelFrame) return Eigen::Isometry3d::Identity();
  if (depth > kDeepest) fail(asking, "poses go round in a circle");
  for (const XmlElement& child : model_->children) {
    if (child.attribute("name") != name) continue;
    if (child.name == "link") return pose(child, kModelFrame, depth);
    if (child.name == "joint") return pose(child, child_text(child, "child"), depth);
    if (child.name == "frame") {
      const std::string_view attached = child.attribute("attached_to");
      return pose(child, attached.empty() ? kModelFrame : attached, depth);
    }
  }
  fail(asking, "the model has no link, joint or frame '" + std::string(name) + "'");
}

Eigen::Isometry3d SdfModel::pose_of(const XmlElement& part, const SdfLink& link) const {
  return pose(part, link.name, 0);
}

// The whole.

bool SdfModel::turns(const XmlElement& joint) const {
  const std::string_view type = joint.attribute("type");
  if (type == "continuous") return true;
  if (type != "revolute") return false;
  const XmlElement* const axis = joint.child("axis");
  const XmlElement* const limit = axis != nullptr ? axis->child("limit") : nullptr;
  const XmlElement* const lower = limit != nullptr ? limit->child("lower") : nullptr;
  const XmlElement* const upper = limit != nullptr ? limit->child("upper") : nullptr;
  return lower == nullptr || upper == nullptr || number(*upper) - number(*lower) > kEndless_rad;
}

Eigen::Vector3d SdfModel::axis_R(const XmlElement& joint) const {
  const XmlElement* const axis = joint.child("axis");
  const XmlElement* const xyz = axis != nullptr ? axis->child("xyz") : nullptr;
  const Eigen::Vector3d v = xyz != nullptr ? vector(*xyz) : Eigen::Vector3d::UnitZ();
  if (v.norm() < 1e-9) fail(*xyz, "<xyz> of an axis is zero");
  std::string_view in = joint.attribute("name");
  if (xyz != nullptr && !xyz->attribute("expressed_in").empty())
    in = xyz->attribute("expressed_in");
  // Up to SDF 1.4 axes are in the model's frame, up to 1.6 where the file says so.
  const bool in_model = version_[0] == 1 && version_[1] <= 4;
  const std::string flag = axis != nullptr ? child_text(*axis, "use_parent_model_frame") : "";
  if (in_model || flag == "1" || flag == "true") in = kModelFrame;
  return (frame(in, joint, 0).linear() * v).normalized();
}

Inertial SdfModel::inertial(const SdfLink& link) const {
  const XmlElement* const element = link.element->child("inertial");
  const XmlElement* const mass = element != nullptr ? element->child("mass") : nullptr;
  const XmlElement* const inertia = element != nullptr ? element->child("inertia") : nullptr;
  if (mass == nullptr || inertia == nullptr) {
    fail(element != nullptr ? *element : *link.element,
         "link '" + link.name +
             "' has no <inertial> with <mass> and <inertia>; SDF would have it weigh 1 kg");
  }
  Inertial result;
  result.line = element->line;
  result.mass_kg = number(*mass);
  if (result.mass_kg < 0) fail(*mass, "<mass> must not be negative");
  result.X = link.X_RL.inverse() * pose(*element, link.name, 0);
  const auto moment = [&](std::string_view name, double fallback) {
    const XmlElement* const entry = inertia->child(name);
    return entry != nullptr ? number(*entry) : fallback;
  };
  const double ixy = moment("ixy", 0);
  const double ixz = moment("ixz", 0);
  const double iyz = moment("iyz", 0);
  result.inertia_kg_m2 << moment("ixx", 1), ixy, ixz, ixy, moment("iyy", 1), iyz, ixz, iyz,
      moment("izz", 1);
  if (result.mass_kg > 0 && !result.inertia_kg_m2.isZero(0) &&
      !is_physical_inertia(result.inertia_kg_m2)) {
    fail(*inertia, "<inertia> of link '" + link.name +
                       "' is one that no body has: its principal moments are above 0, and none is "
                       "larger than the sum of the others");
  }
  return result;
}

ModelBody SdfModel::body() const {
  ModelBody body;
  BodySum sum;
  for (const SdfLink& link : links_) {
    ModelLink& placed = body.links.emplace_back();
    placed.name = link.name;
    placed.line = link.element->line;
    placed.position_R_m = link.X_RL.translation();
    sum.add(inertial(link), link.X_RL);
    const auto joint = std::ranges::find_if(model_->children, [&](const XmlElement& child) {
      return child.name == "joint" && child_text(child, "child") == link.name;
    });
    if (joint == model_->children.end()) continue;
    placed.line = joint->line;
    placed.position_R_m = frame(joint->attribute("name"), *joint, 0).translation();
    if (turns(*joint)) placed.axis_R = axis_R(*joint);
  }
  sum.finish(body);
  return body;
}

}  // namespace cas::base
