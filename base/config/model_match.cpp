// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_match.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cas::base {
namespace {

// Two descriptions agree within the rounding of files.
constexpr double kSameMass = 1e-3;     // of it
constexpr double kSameInertia = 5e-3;  // of the largest moment
constexpr double kSamePlace_m = 5e-4;
constexpr double kSameAxis_rad = 5e-3;
constexpr double kUpright_rad = 1e-6;  // CAD programs write angles with a rounding error
constexpr double kSameRotor = 0.01;    // of its mass

std::string text(double value) { return fmt::format("{:.6g}", value); }

std::string text(const Eigen::Vector3d& v) {
  return "[" + text(v.x()) + ", " + text(v.y()) + ", " + text(v.z()) + "]";
}

Eigen::Vector3d upward(const Eigen::Vector3d& axis) {
  if (axis.head<2>().norm() < kUpright_rad) return Eigen::Vector3d::UnitZ();
  return axis.z() < -kUpright_rad ? Eigen::Vector3d(-axis) : axis;
}

/// Whether a link weighs as much as one of the others.
bool weighs_as_one_of(const ModelLink& link, const std::vector<const ModelLink*>& others) {
  return std::ranges::any_of(others, [&link](const ModelLink* each) {
    return each != nullptr && std::abs(each->mass_kg - link.mass_kg) <= kSameRotor * each->mass_kg;
  });
}

}  // namespace

double positive_value(const ConfigNode& node, std::string_view key) {
  const double value = node.require<double>(key);
  if (value <= 0.0) node.at(key).fail("must be above zero");
  return value;
}

Eigen::Vector3d unit_vector(const ConfigNode& node) {
  const Eigen::Vector3d axis = node.as<Eigen::Vector3d>();
  if (axis.norm() < 1e-9) node.fail("is a direction and must not be zero");
  return axis.normalized();
}

double ModelMatch::mass_kg() const {
  if (!node_.has("mass_kg")) return body_->mass_kg;
  const double mass = positive_value(node_, "mass_kg");
  if (has_mass() && std::abs(mass - body_->mass_kg) > kSameMass * mass) {
    differ(node_.at("mass_kg"), text(mass), body_->inertial_place, text(body_->mass_kg),
           "all links together");
  }
  return mass;
}

Eigen::Vector3d ModelMatch::inertia_kg_m2() const {
  if (!node_.has("inertia_kg_m2")) {
    const Eigen::Vector3d model = body_->inertia_B_kg_m2.diagonal();
    if ((model.array() <= 0.0).any()) {
      node_.fail("key 'inertia_kg_m2' is missing, and " + body_->inertial_place +
                 " has no inertia of a rigid body" +
                 (body_->warnings.empty() ? "" : "; " + body_->warnings.front()));
    }
    return model;
  }
  const ConfigNode key = node_.at("inertia_kg_m2");
  const Eigen::Vector3d inertia = key.as<Eigen::Vector3d>();
  if ((inertia.array() <= 0.0).any()) key.fail("must be above zero in each axis");
  if (2.0 * inertia.maxCoeff() > inertia.sum()) {
    key.fail("belongs to no rigid body: one moment exceeds the sum of the other two");
  }
  if (!has_mass()) return inertia;
  const Eigen::Vector3d model = body_->inertia_B_kg_m2.diagonal();
  if ((inertia - model).cwiseAbs().maxCoeff() > kSameInertia * inertia.maxCoeff()) {
    differ(key, text(inertia), body_->inertial_place, text(model),
           "all links together, about their centre of gravity");
  }
  return inertia;
}

const ModelLink* ModelMatch::link_of(const ConfigNode& item, int number) const {
  if (const auto key = item.find("link")) {
    const auto name = key->as<std::string>();
    if (!body_) {
      const ConfigNode model = node_.has("urdf") ? node_.at("urdf") : node_.at("sdf");
      model.fail("there is no file " + node_.resolve(model.as<std::string>()).string() +
                 ", whose link '" + name + "' a rotor names");
    }
    const ModelLink* const link = body_->find(name);
    if (link == nullptr) key->fail("the model has no link '" + name + "'" + turning_names());
    return link;
  }
  if (!body_) return nullptr;
  const int before_first = body_->find("rotor_0") != nullptr ? 1 : 0;  // as PX4's models count
  const std::string name = fmt::format("rotor_{}", number - before_first);
  const ModelLink* const numbered = body_->find(name);
  if (numbered != nullptr && numbered->axis_R) return numbered;
  return item.has("position_B_m") ? nearest(item.require<Eigen::Vector3d>("position_B_m"))
                                  : nullptr;
}

void ModelMatch::place(const ConfigNode& item, const ModelLink* link, Rotor& rotor) const {
  if (const auto key = item.find("position_B_m")) {
    rotor.position_B_m = key->as<Eigen::Vector3d>();
    if (link != nullptr) check_place(*key, *link, rotor.position_B_m);
  } else {
    rotor.position_B_m = body_->position_B_m(*link);
  }
  if (const auto key = item.find("axis_B")) {
    rotor.axis_B = unit_vector(*key);
    if (link != nullptr && link->axis_R) check_axis(*key, *link, rotor.axis_B);
  } else if (link != nullptr && link->axis_R) {
    rotor.axis_B = upward(*link->axis_R);
  }
}

void ModelMatch::settle_others(const ConfigNode& rotors, const std::vector<const ModelLink*>& taken,
                               Vehicle& vehicle) const {
  for (std::size_t i = 0; i < taken.size(); ++i) {
    const auto end = taken.begin() + static_cast<std::ptrdiff_t>(i);
    if (taken[i] != nullptr && std::find(taken.begin(), end, taken[i]) != end) {
      rotors.items()[i].fail("its link '" + taken[i]->name + "' is another rotor's, too");
    }
  }
  if (!body_) return;
  for (const ModelLink& link : body_->links) {
    if (!link.axis_R || std::ranges::find(taken, &link) != taken.end()) continue;
    const std::string turns = "link '" + link.name + "' turns without end";
    const std::string fix = "`parts: {" + link.name + ": fixed}`";
    if (weighs_as_one_of(link, taken)) {
      rotors.fail(fmt::format(
          "lists {} rotors, but {} has one more: {}; list it, or say {} where it is no rotor",
          taken.size(), link.place, turns, fix));
    }
    vehicle.parts[link.name] = PartUse::kFixed;
    vehicle.warnings.push_back(link.place + ": " + turns +
                               " and is no rotor of the vehicle file: taken as fixed; " + fix +
                               " says that it is meant so");
  }
}

void ModelMatch::differ(const ConfigNode& key, const std::string& here, const std::string& place,
                        const std::string& there, const std::string& what) const {
  key.fail("is " + here + ", but " + place + " has " + there + " (" + what +
           "); mend one, or leave this key out");
}

void ModelMatch::check_place(const ConfigNode& key, const ModelLink& link,
                             const Eigen::Vector3d& p_B) const {
  const Eigen::Vector3d model = body_->position_B_m(link);
  if ((p_B - model).norm() <= kSamePlace_m) return;
  differ(key, text(p_B), link.place, text(model),
         "link '" + link.name + "' from the centre of gravity, which is at " +
             text(body_->cog_R_m) + " of the model's frame");
}

void ModelMatch::check_axis(const ConfigNode& key, const ModelLink& link,
                            const Eigen::Vector3d& axis) const {
  // A joint's axis may point either way: the sense of turning is `spin`.
  if (axis.cross(*link.axis_R).norm() <= kSameAxis_rad) return;
  differ(key, text(axis), link.place, text(upward(*link.axis_R)), "link '" + link.name + "'");
}

const ModelLink* ModelMatch::nearest(const Eigen::Vector3d& p_B) const {
  const ModelLink* found = nullptr;
  for (const ModelLink& link : body_->links) {
    if (!link.axis_R) continue;
    const double distance = (body_->position_B_m(link) - p_B).norm();
    if (found == nullptr || distance < (body_->position_B_m(*found) - p_B).norm()) found = &link;
  }
  return found;
}

std::string ModelMatch::turning_names() const {
  std::string names;
  if (body_) {
    for (const ModelLink& link : body_->links) {
      if (link.axis_R) names += (names.empty() ? "; those that turn are '" : "', '") + link.name;
    }
  }
  return names.empty() ? "" : names + "'";
}

}  // namespace cas::base
