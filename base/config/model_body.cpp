// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "base/config/sdf_model.hpp"
#include "base/config/urdf_model.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::base {
namespace {

constexpr double kTriangleSlack = 1e-6;  // of the largest moment: files round their figures

}  // namespace

const ModelLink* ModelBody::find(std::string_view link_name) const {
  const auto found = std::ranges::find(links, link_name, &ModelLink::name);
  if (found != links.end()) return &*found;
  const std::string inside = "::" + std::string(link_name);
  const auto is_it = [&inside](const ModelLink& link) { return link.name.ends_with(inside); };
  const auto only = std::ranges::find_if(links, is_it);
  return std::ranges::count_if(links, is_it) == 1 ? &*only : nullptr;
}

const ModelMotor* ModelBody::motor_of(const ModelLink& link) const {
  const auto found = std::ranges::find_if(motors, [&link](const ModelMotor& motor) {
    return motor.link == link.name || (!motor.joint.empty() && motor.joint == link.joint);
  });
  return found == motors.end() ? nullptr : &*found;
}

ModelBody parse_model_body(std::string_view text, const std::filesystem::path& file,
                           const ModelParts& parts) {
  // A template may parse, without the expansion of its macros.
  if (const auto sentence = template_language(text)) {
    throw ConfigError(file.string() + ": is no vehicle model: " + *sentence);
  }
  const XmlElement root = parse_xml(text, file.string());
  if (root.name == "sdf") return read_sdf_model(root, file, parts);
  if (root.name == "robot") return read_urdf_model(root, file, parts);
  root.fail("is no vehicle model: its outermost element is <" + root.name +
            ">, not <robot> (URDF) or <sdf>");
}

std::optional<ModelBody> read_model_body(const std::filesystem::path& file,
                                         const ModelParts& parts) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  return parse_model_body(read_foreign_file(file, "vehicle model", kMaxModelBytes), file, parts);
}

bool is_physical_inertia(const Eigen::Matrix3d& inertia) {
  if (!inertia.allFinite() || !inertia.isApprox(inertia.transpose())) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& moments = solver.eigenvalues();  // rising
  return moments[0] > 0 && moments[2] <= moments[0] + moments[1] + kTriangleSlack * moments[2];
}

}  // namespace cas::base
