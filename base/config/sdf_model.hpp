// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/model_body.hpp"
#include "base/config/xml_tree.hpp"
#include "base/export.hpp"

namespace cas::base {

/// A link of an SDF model.
struct SdfLink {
  std::string name;
  Eigen::Isometry3d X_RL;  ///< in the model's frame
  const XmlElement* element = nullptr;
};

/// An SDF file of one model, read as a vehicle: poses of its links, its mass, its turning joints.
///
/// Poses are resolved as SDF 1.4 to 1.11 say: in Euler angles, `relative_to` a link, joint or
/// frame. A continuous joint turns, and so does a revolute one whose limits allow a full turn;
/// others count as fixed. Of two files that a merge joins, the one with the links is the vehicle's
/// model: <include> and nested models are refused.
class CAS_BASE_EXPORT SdfModel {
 public:
  /// Whether a text's outermost element is <sdf>.
  static bool is_sdf(std::string_view text);

  /// @throws ConfigError "FILE:LINE: ..." where the file holds no such model
  SdfModel(std::string_view text, const std::filesystem::path& file);
  SdfModel(const SdfModel&) = delete;
  SdfModel& operator=(const SdfModel&) = delete;

  std::string name() const { return std::string(model_->attribute("name")); }
  const std::vector<SdfLink>& links() const { return links_; }
  /// Pose of a link's part (a collision) in the model's frame.
  Eigen::Isometry3d pose_of(const XmlElement& part, const SdfLink& link) const;
  ModelBody body() const;
  /// The three numbers of an element, of a box's <size> say.
  Eigen::Vector3d vector(const XmlElement& element) const;
  double number(const XmlElement& element) const;
  [[noreturn]] void fail(const XmlElement& at, const std::string& sentence) const;

 private:
  std::vector<double> numbers(const XmlElement& element, std::size_t count) const;
  Eigen::Isometry3d frame(std::string_view name, const XmlElement& asking, int depth) const;
  Eigen::Isometry3d pose(const XmlElement& element, std::string_view parent, int depth) const;
  bool turns(const XmlElement& joint) const;
  Eigen::Vector3d axis_R(const XmlElement& joint) const;
  Inertial inertial(const SdfLink& link) const;

  std::string file_;
  XmlElement root_;
  const XmlElement* model_ = nullptr;
  int version_[2] = {0, 0};  ///< major and minor; 0: none is said
  std::vector<SdfLink> links_;
};

}  // namespace cas::base
