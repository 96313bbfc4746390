// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/sdf_geometry.hpp"

#include <initializer_list>
#include <optional>

#include "base/error.hpp"
#include "libsim/core/load/sdf_omissions.hpp"

namespace cas::sim {

namespace {

double size(double value, const std::string& who, const char* what) {
  if (is_within(value, kSmallest_m, kLargest_m)) return value;
  throw base::ConfigError(who + ": " + what + " must lie above 0 and below 1e8 m");
}

/// A descendant that the file has.
sdf::ElementPtr descendant(sdf::ElementPtr element, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (element) element = element->HasElement(name) ? element->GetElement(name) : nullptr;
  }
  return element;
}

std::optional<double> number(const sdf::ElementPtr& element, const char* name) {
  if (!element || !element->HasElement(name)) return std::nullopt;
  return element->Get<double>(name);
}

void require_positive(const sdf::ElementPtr& element, const char* name, const std::string& shape) {
  const std::optional<double> value = number(element, name);
  if (!value || is_within(*value, 1e-300, 1e300)) return;
  throw base::ConfigError(place_of(*element->GetElement(name)) + ": collision '" + shape + "': <" +
                          name + "> must be above 0 and finite");
}

}  // namespace

Eigen::Vector3d to_eigen(const ignition::math::Vector3d& v) { return {v.X(), v.Y(), v.Z()}; }

Eigen::Isometry3d to_eigen(const ignition::math::Pose3d& pose) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  const auto& q = pose.Rot();
  X.translation() = to_eigen(pose.Pos());
  X.linear() = Eigen::Quaterniond(q.W(), q.X(), q.Y(), q.Z()).normalized().toRotationMatrix();
  return X;
}

bool take_sdf_primitive(const sdf::Geometry& geometry, const std::string& who, Shape& shape) {
  switch (geometry.Type()) {
    case sdf::GeometryType::BOX: {
      const Eigen::Vector3d edges = to_eigen(geometry.BoxShape()->Size());
      for (const double edge : edges) size(edge, who, "the <size> of a <box>");
      shape.geometry = Box{edges};
      return true;
    }
    case sdf::GeometryType::SPHERE:
      shape.geometry = Sphere{size(geometry.SphereShape()->Radius(), who, "the <radius>")};
      return true;
    case sdf::GeometryType::CYLINDER:
      shape.geometry = Cylinder{size(geometry.CylinderShape()->Radius(), who, "the <radius>"),
                                size(geometry.CylinderShape()->Length(), who, "the <length>")};
      return true;
    case sdf::GeometryType::PLANE: {
      const Eigen::Vector3d normal = to_eigen(geometry.PlaneShape()->Normal());
      if (!is_within(normal.norm(), kSmallest_m, kLargest_m)) {
        throw base::ConfigError(who + ": the <normal> of a <plane> must have a length");
      }
      shape.geometry = Plane{};
      shape.pose.rotate(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal));
      return true;
    }
    default:
      return false;  // sdf_omissions() names it
  }
}

Surface sdf_surface(const sdf::Collision& collision, const std::string& name,
                    std::vector<std::string>& warnings) {
  Surface surface;
  const sdf::ElementPtr friction = descendant(collision.Element(), {"surface", "friction", "ode"});
  surface.friction = number(friction, "mu").value_or(surface.friction);  // never below 0: SDF
  const sdf::ElementPtr contact = descendant(collision.Element(), {"surface", "contact", "ode"});
  require_positive(contact, "kp", name);
  surface.stiffness_n_m = number(contact, "kp");
  surface.damping_n_s_m = number(contact, "kd");
  if (surface.damping_n_s_m == 0.0) {
    warnings.push_back(place_of(*contact->GetElement("kd")) + ": collision '" + name +
                       "': a <kd> of 0 is left out: nothing rests without damping");
    surface.damping_n_s_m.reset();
  }
  if (surface.damping_n_s_m) require_positive(contact, "kd", name);
  return surface;
}

bool is_solid(const sdf::Collision& collision) {
  const sdf::ElementPtr contact = descendant(collision.Element(), {"surface", "contact"});
  if (!contact) return true;
  constexpr unsigned kEveryBit = 0xFFFF;
  if (contact->HasElement("collide_without_contact") &&
      contact->Get<bool>("collide_without_contact")) {
    return false;
  }
  return !contact->HasElement("collide_bitmask") ||
         (contact->Get<unsigned>("collide_bitmask") & kEveryBit) != 0;
}

}  // namespace cas::sim
