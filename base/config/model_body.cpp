// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/model_body.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "base/config/sdf_model.hpp"
#include "base/config/urdf_body.hpp"
#include "base/read_file.hpp"

namespace cas::base {
namespace {

constexpr double kTriangleSlack = 1e-6;  // of the largest moment: files round their figures

Eigen::Matrix3d parallel_axis(double mass, const Eigen::Vector3d& p) {
  return mass * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
}

}  // namespace

const ModelLink* ModelBody::find(std::string_view name) const {
  const auto found = std::ranges::find(links, name, &ModelLink::name);
  return found == links.end() ? nullptr : &*found;
}

void BodySum::add(const Inertial& inertial, const Eigen::Isometry3d& X_RL) {
  if (first_line_ == 0) first_line_ = inertial.line;
  const Eigen::Isometry3d X_RC = X_RL * inertial.X;
  mass_kg_ += inertial.mass_kg;
  moment_ += inertial.mass_kg * X_RC.translation();
  inertia_ += parallel_axis(inertial.mass_kg, X_RC.translation());
  if (inertial.mass_kg > 0 && !is_physical_inertia(inertial.inertia_kg_m2)) return;
  inertia_ += X_RC.linear() * inertial.inertia_kg_m2 * X_RC.linear().transpose();
}

void BodySum::finish(ModelBody& body) const {
  body.mass_kg = mass_kg_;
  body.inertial_line = first_line_;
  if (mass_kg_ <= 0) return;
  body.cog_R_m = moment_ / mass_kg_;
  const Eigen::Matrix3d inertia = inertia_ - parallel_axis(mass_kg_, body.cog_R_m);
  body.inertia_B_kg_m2 = 0.5 * (inertia + inertia.transpose());
}

std::optional<ModelBody> read_model_body(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return std::nullopt;
  const std::string xml = read_foreign_file(file, "vehicle model", kMaxModelBytes);
  std::optional<ModelBody> body =
      SdfModel::is_sdf(xml) ? SdfModel(xml, file).body() : read_urdf_body(xml);
  if (body) body->file = file;
  return body;
}

bool is_physical_inertia(const Eigen::Matrix3d& inertia) {
  if (!inertia.allFinite() || !inertia.isApprox(inertia.transpose())) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d& moments = solver.eigenvalues();  // rising
  return moments[0] > 0 && moments[2] <= moments[0] + moments[1] + kTriangleSlack * moments[2];
}

}  // namespace cas::base
