// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/config/xml_tree.hpp"

namespace cas::base {

/// A <model> as a space of names: those of its links, joints, frames and of the models in it.
/// Poses are in its frame M.
class SdfScope {
 public:
  static constexpr std::string_view kModelFrame = "__model__";

  /// The outermost model.
  SdfScope(const XmlElement& model, std::string_view version, std::filesystem::path file);
  /// A model in another one. @param include  that names its file; nullptr: it is nested
  SdfScope(const XmlElement& model, std::string_view version, std::filesystem::path file,
           const SdfScope& parent, const XmlElement* include);

  const XmlElement& model() const { return model_; }
  const std::filesystem::path& file() const { return file_; }
  const std::string& prefix() const { return prefix_; }  ///< of its names in the outermost model
  /// Up to SDF 1.4 the axes of joints are in the model's frame.
  bool axes_in_model() const { return axes_in_model_; }
  /// That names the model's file; nullptr: the outermost or a nested model.
  const XmlElement* include() const { return include_; }
  const std::vector<std::unique_ptr<SdfScope>>& parts() const { return parts_; }
  void add(std::unique_ptr<SdfScope> part) { parts_.push_back(std::move(part)); }
  /// Says that a model in this one is not among its parts. @param merged  its names would be here
  void leave_out(std::string_view name, bool merged);

  /// An element's own pose. @param parent  frame of the pose when it has no relative_to
  Eigen::Isometry3d pose(const XmlElement& element, std::string_view parent, int depth = 0) const;
  /// A link, joint, frame or model by name. @throws ConfigError when there is none
  Eigen::Isometry3d frame(std::string_view name, const XmlElement& asking, int depth = 0) const;
  /// The link that a link, joint, frame or model is part of, by its name in the outermost model;
  /// nullopt for one that is left out. @throws ConfigError when there is none
  std::optional<std::string> link_of(std::string_view name, const XmlElement& asking,
                                     int depth = 0) const;
  /// Where a model in this one has its frame.
  Eigen::Isometry3d placed(const SdfScope& part, int depth = 0) const;

 private:
  std::optional<Eigen::Isometry3d> find_frame(std::string_view name, const XmlElement& asking,
                                              int depth) const;
  std::optional<std::string> find_link(std::string_view name, const XmlElement& asking,
                                       int depth) const;
  std::string_view frame_of_model() const;
  std::optional<std::string_view> name_in(const SdfScope& part, std::string_view name) const;
  bool is_left_out(std::string_view name) const;

  const XmlElement& model_;
  const XmlElement* include_ = nullptr;
  std::filesystem::path file_;
  std::string name_;
  std::string prefix_;
  bool merged_ = false;
  bool axes_in_model_ = false;
  std::map<std::string_view, const XmlElement*> by_name_;
  std::vector<std::unique_ptr<SdfScope>> parts_;
  std::set<std::string, std::less<>> left_out_;
  bool misses_names_ = false;  // of a merged model
};

/// Whether "true" or "1" is said.
bool is_true(std::string_view flag);

/// Name of a part in its parent: the <include>'s <name>, else that of the model.
std::string_view sdf_part_name(const XmlElement& model, const XmlElement* include);

}  // namespace cas::base
