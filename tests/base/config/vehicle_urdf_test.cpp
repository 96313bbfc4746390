// SPDX-License-Identifier: BSD-3-Clause
// Values in both a vehicle's YAML and its URDF agree; the URDF gives those that the YAML omits.
#include <gtest/gtest.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "base/config/install_paths.hpp"
#include "base/config/vehicle.hpp"
#include "tests/support/paths.hpp"

namespace cas::base {
namespace {

constexpr double kDigitsInTheFile = 1e-9;

Eigen::Vector3d to_eigen(const urdf::Vector3& v) { return {v.x, v.y, v.z}; }

/// Where a link's centre of gravity is in the frame of the root; the shipped files do not rotate.
Eigen::Vector3d centre_of(const urdf::Link& link) {
  Eigen::Vector3d p = to_eigen(link.inertial->origin.position);
  for (const urdf::Link* at = &link; at->parent_joint; at = at->getParent().get()) {
    p += to_eigen(at->parent_joint->parent_to_joint_origin_transform.position);
  }
  return p;
}

Eigen::Matrix3d inertia_of(const urdf::Inertial& inertial) {
  Eigen::Matrix3d inertia;
  inertia << inertial.ixx, inertial.ixy, inertial.ixz,  //
      inertial.ixy, inertial.iyy, inertial.iyz,         //
      inertial.ixz, inertial.iyz, inertial.izz;
  return inertia;
}

struct Composite {
  double mass = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  // about the centre
};

/// About the origin.
Eigen::Matrix3d of_point(double m, const Eigen::Vector3d& p) {
  return m * (p.squaredNorm() * Eigen::Matrix3d::Identity() - p * p.transpose());
}

/// All links as one rigid body, by the parallel-axis theorem.
Composite compose(const urdf::ModelInterface& model) {
  Composite all;
  for (const auto& [name, link] : model.links_) {
    if (!link->inertial) continue;
    const Eigen::Vector3d p = centre_of(*link);
    const double m = link->inertial->mass;
    all.mass += m;
    all.centre += m * p;
    all.inertia += inertia_of(*link->inertial) + of_point(m, p);
  }
  all.centre /= all.mass;
  all.inertia -= of_point(all.mass, all.centre);
  return all;
}

class VehicleUrdf : public testing::TestWithParam<std::filesystem::path> {
 protected:
  VehicleUrdf() : vehicle_(Vehicle::load(GetParam())) {
    model_ = urdf::parseURDFFile(vehicle_.urdf.string());
  }
  void SetUp() override { ASSERT_TRUE(model_) << vehicle_.urdf; }

  Vehicle vehicle_;
  urdf::ModelInterfaceSharedPtr model_;
};

TEST_P(VehicleUrdf, MassAndInertiaAreThoseOfTheVehicleFile) {
  const Composite all = compose(*model_);
  EXPECT_NEAR(all.mass, vehicle_.mass_kg, kDigitsInTheFile);
  EXPECT_TRUE(all.inertia.diagonal().isApprox(vehicle_.inertia_kg_m2, 1e-8)) << all.inertia;
  if (vehicle_.aero)
    return;  // a plane may have products of inertia, which stand in its model alone
  EXPECT_TRUE(all.inertia.isDiagonal(1e-8)) << all.inertia;
}

TEST_P(VehicleUrdf, RotorsStandWhereTheVehicleFileHasThem) {
  if (model_->links_.size() == 1) return;  // the whole is one link
  const Eigen::Vector3d centre = compose(*model_).centre;
  for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) {
    const auto joint = model_->getJoint("rotor_" + std::to_string(i + 1) + "_joint");
    ASSERT_TRUE(joint);
    EXPECT_EQ(joint->type, urdf::Joint::CONTINUOUS);

    const Eigen::Vector3d hub = to_eigen(joint->parent_to_joint_origin_transform.position);
    EXPECT_LT((hub - centre - vehicle_.rotors[i].position_B_m).norm(), kDigitsInTheFile);
    EXPECT_TRUE(vehicle_.rotors[i].axis_B.isApprox(to_eigen(joint->axis), kDigitsInTheFile));
    const auto link = model_->getLink("rotor_" + std::to_string(i + 1));
    ASSERT_TRUE(link && link->inertial);
    EXPECT_EQ(inertia_of(*link->inertial).diagonal().maxCoeff(),
              vehicle_.rotors[i].params.inertia_kg_m2);
  }
}

TEST_P(VehicleUrdf, TheBodyHasAShapeToTouchTheGroundWith) {
  ASSERT_TRUE(model_->getRoot());
  ASSERT_TRUE(model_->getRoot()->collision);
  EXPECT_EQ(model_->getRoot()->collision->geometry->type, urdf::Geometry::BOX);
  EXPECT_EQ(model_->getName(), vehicle_.name);
}

/// Every vehicle file of the project, so that a new one is tested too.
std::vector<std::filesystem::path> shipped_vehicles() {
  std::vector<std::filesystem::path> files;
  const auto folder = std::filesystem::path(cas::test::source_dir()) / "config/vehicles";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

INSTANTIATE_TEST_SUITE_P(Shipped, VehicleUrdf, testing::ValuesIn(shipped_vehicles()),
                         [](const auto& test) { return test.param.stem().string(); });

}  // namespace
}  // namespace cas::base
