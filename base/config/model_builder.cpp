// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_builder.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cas::base {
namespace {

Eigen::Matrix3d parallel_axis(double mass, const Eigen::Vector3d& p) {
  return mass * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
}

}  // namespace

Eigen::Matrix3d rotation_rpy(double roll, double pitch, double yaw) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

ModelBuilder::ModelBuilder(const std::filesystem::path& file, const ModelParts& parts)
    : parts_(parts) {
  body_.file = file;
}

bool ModelBuilder::is_used(std::string_view name, PartUse use) {
  const auto found = parts_.find(name);
  if (found == parts_.end()) return false;
  met_.insert(found->first);
  return found->second == use;
}

bool ModelBuilder::leaves_out(std::string_view name) { return is_used(name, PartUse::kLeftOut); }

bool ModelBuilder::fixes(std::string_view name) { return is_used(name, PartUse::kFixed); }

void ModelBuilder::warn(const XmlElement& at, const std::string& sentence) {
  body_.warnings.push_back(at.place() + ": " + sentence);
}

void ModelBuilder::warn_of_degrees(const XmlElement& at, std::string_view numbers,
                                   std::size_t first) {
  constexpr double kFullTurn_rad = 6.3;  // rounded up, as some write it
  std::vector<double> values;
  read_numbers(numbers, values);
  for (std::size_t i = first; i < values.size(); ++i) {
    if (std::abs(values[i]) <= kFullTurn_rad) continue;
    return warn(at, fmt::format("an angle of {:g} rad is more than a full turn: it may be in "
                                "degrees",
                                values[i]));
  }
}

std::optional<bool> ModelBuilder::add(const XmlElement& element, const std::string& name,
                                      const Eigen::Isometry3d& X_RL, const LinkJoint& joint,
                                      const Eigen::Vector3d& position_R_m,
                                      const std::optional<Inertial>& inertial) {
  if (name.empty()) element.fail("a <link> has no name");
  if (!names_.insert(name).second) element.fail("a second <link> is called '" + name + "'");
  if (names_.size() > kMaxModelLinks) {
    element.fail("the model has more than the " + std::to_string(kMaxModelLinks) +
                 " links that are read");
  }
  if (!X_RL.matrix().allFinite() || !position_R_m.allFinite()) {
    element.fail("link '" + name + "' is too far away");
  }
  const bool link_is_out = is_used(name, PartUse::kLeftOut);
  const bool joint_is_out = is_used(joint.name, PartUse::kLeftOut);
  if (link_is_out || joint_is_out) return std::nullopt;
  const bool fixed_by_link = is_used(name, PartUse::kFixed);
  const bool fixed_by_joint = is_used(joint.name, PartUse::kFixed);
  const bool fixed = fixed_by_link || fixed_by_joint;
  if (joint.moves && !joint.axis_R && !fixed) {
    warn(*joint.element, "joint '" + joint.name +
                             "' moves; only joints that turn without end (rotors) do here: taken "
                             "as fixed");
  }
  body_.links.push_back({.name = name,
                         .joint = joint.name,
                         .place = (joint.element != nullptr ? joint.element : &element)->place(),
                         .mass_kg = inertial ? inertial->mass_kg : 0,
                         .position_R_m = position_R_m,
                         .axis_R = fixed ? std::nullopt : joint.axis_R});
  if (inertial) add_mass(name, *inertial, X_RL);
  return body_.links.back().axis_R.has_value();
}

void ModelBuilder::add_shape(const XmlElement& part, FormValues values,
                             const std::filesystem::path& file, bool turns,
                             const std::function<Eigen::Isometry3d()>& X_RS) {
  ModelShape shape{.link = body_.links.back().name,
                   .name = std::string(part.attribute("name")),
                   .visual = part.name == "visual",
                   .turns = turns,
                   .file = file};
  if (!shape.visual) return take_shape(part, values, std::move(shape), X_RS);
  const std::string link = shape.link;
  try {
    take_shape(part, values, std::move(shape), X_RS);
  } catch (const ConfigError& error) {
    body_.warnings.push_back(std::string(error.what()) + "; link '" + link +
                             "' is drawn without this <visual>");
  }
}

void ModelBuilder::take_shape(const XmlElement& part, FormValues values, ModelShape shape,
                              const std::function<Eigen::Isometry3d()>& X_RS) {
  const XmlElement& geometry = part.need("geometry");
  if (geometry.children.empty()) geometry.fail("<geometry> is empty");
  const XmlElement& form = geometry.children.front();
  take_model_form(form, values, shape);
  if (const XmlElement* const submesh = form.child("submesh"); submesh && !shape.visual) {
    warn(*submesh, "link '" + shape.link + "' names a <submesh>; the whole mesh collides here");
  }
  if (geometry.children.size() > 1) {
    warn(geometry.children[1], "link '" + shape.link +
                                   "': of a <geometry> the first form counts, <" + shape.word +
                                   ">; <" + geometry.children[1].name + "> is left out");
  }
  shape.X_RS = X_RS();
  body_.shapes.push_back(std::move(shape));
}

void ModelBuilder::add_mass(const std::string& link, const Inertial& inertial,
                            const Eigen::Isometry3d& X_RL) {
  if (inertial.mass_kg < 0) inertial.element->fail("<mass> must not be negative");
  if (body_.inertial_place.empty()) body_.inertial_place = inertial.element->place();
  const Eigen::Isometry3d X_RC = X_RL * inertial.X;
  body_.mass_kg += inertial.mass_kg;
  moment_ += inertial.mass_kg * X_RC.translation();
  inertia_ += parallel_axis(inertial.mass_kg, X_RC.translation());
  const Eigen::Matrix3d& own = inertial.inertia_kg_m2;
  if (own.isZero(0)) return;
  if (inertial.mass_kg <= 0) {
    warn(*inertial.element, "link '" + link + "': no body without mass has an <inertia>; left out");
    return;
  }
  if (!is_physical_inertia(own)) {
    warn(*inertial.element,
         "link '" + link +
             "': no body has this <inertia>: each principal moment must be above zero, and none "
             "above the sum of the other two; taken as a point mass");
    return;
  }
  inertia_ += X_RC.linear() * own * X_RC.linear().transpose();
}

ModelBody ModelBuilder::finish(std::string name) {
  for (const auto& [part, use] : parts_) {
    if (met_.contains(part)) continue;
    throw ConfigError(body_.file.string() + ": has no link, joint or included model '" + part +
                      "', which `parts` of the vehicle file names");
  }
  for (const ModelMotor& motor : body_.motors) {
    if (motor.link.empty() || names_.contains(motor.link)) continue;
    body_.warnings.push_back(motor.place + ": a motor plugin drives link '" + motor.link +
                             "', which the model does not have: left out");
  }
  body_.name = std::move(name);
  for (const ModelShape& shape : body_.shapes) {
    if (!shape.X_RS.matrix().allFinite()) {
      throw ConfigError(shape.place + ": link '" + shape.link + "' has a shape too far away");
    }
  }
  if (body_.mass_kg > 0) {
    body_.cog_R_m = moment_ / body_.mass_kg;
    const Eigen::Matrix3d inertia = inertia_ - parallel_axis(body_.mass_kg, body_.cog_R_m);
    body_.inertia_B_kg_m2 = 0.5 * (inertia + inertia.transpose());
  }
  if (!std::isfinite(body_.mass_kg) || !body_.inertia_B_kg_m2.allFinite()) {
    throw ConfigError(body_.inertial_place + ": the links' masses and places give no finite sum");
  }
  return std::move(body_);
}

}  // namespace cas::base
