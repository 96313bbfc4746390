// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/collada.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "base/angles.hpp"
#include "base/text.hpp"
#include "libsim/core/load/collada_document.hpp"
#include "libsim/core/load/collada_geometry.hpp"

namespace cas::sim {

using base::XmlElement;

namespace {

constexpr int kDeepest = 64;  // a node library may name itself
/// Elements of nodes, each as often as it is named: nodes that name each other twice double with
/// each level.
constexpr std::size_t kMostVisits = 1'000'000;

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Follows the nodes of the scene.
class Scene {
 public:
  Scene(const ColladaDocument& document, const MeshOptions& options)
      : document_(document), options_(options), geometry_(document, options) {}

  TriangleMesh run() {
    const Eigen::Affine3d X = to_metres();
    if (const XmlElement* const scene = visual_scene()) {
      take_nodes(*scene, X, 0);
    } else {
      for (const XmlElement* each : of_libraries("library_geometries", "geometry")) {
        geometry_.take(*each, X);
      }
    }
    return geometry_.release();
  }

 private:
  /// What <scene> shows; in a file without one the only <visual_scene>, or nothing.
  const XmlElement* visual_scene() const {
    const XmlElement* const scene = document_.root().child("scene");
    const XmlElement* const instance = scene ? scene->child("instance_visual_scene") : nullptr;
    if (instance != nullptr) return &document_.target(*instance, "url", "visual_scene");
    const auto all = of_libraries("library_visual_scenes", "visual_scene");
    if (all.size() > 1) {
      document_.fail(*all[1], "is a second <visual_scene>, and no <scene> says which one counts");
    }
    return all.empty() ? nullptr : all.front();
  }

  /// The elements of one kind; a file may have several libraries of it.
  std::vector<const XmlElement*> of_libraries(std::string_view library,
                                              std::string_view name) const {
    std::vector<const XmlElement*> all;
    for (const XmlElement& each : document_.root().children) {
      if (each.name != library) continue;
      for (const XmlElement& element : each.children) {
        if (element.name == name) all.push_back(&element);
      }
    }
    return all;
  }

  /// Unit and, if it is applied, up axis.
  Eigen::Affine3d to_metres() const {
    Eigen::Affine3d X = Eigen::Affine3d::Identity();
    const XmlElement* const asset = document_.root().child("asset");
    const XmlElement* const up = asset ? asset->child("up_axis") : nullptr;
    std::string_view text = up ? up->text : std::string_view("Y_UP");  // COLLADA's default
    const std::string_view axis = base::next_word(text);
    if (!is_one_of(axis, {"X_UP", "Y_UP", "Z_UP"})) {
      document_.fail(*up, "<up_axis> is X_UP, Y_UP or Z_UP");
    }
    if (options_.up_axis == UpAxis::kApplied) {
      if (axis == "X_UP") X.rotate(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY()));
      if (axis == "Y_UP") X.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
    } else if (up != nullptr && axis != "Z_UP") {
      options_.warn(document_.place(*up) + ": <up_axis> " + std::string(axis) +
                    " does not turn the mesh, as in Gazebo; 'collada_up_axis: applied' does");
    }
    if (const XmlElement* const unit = asset ? asset->child("unit") : nullptr) {
      X.scale(metres_of(*unit));
    }
    return X;
  }

  double metres_of(const XmlElement& unit) const {
    if (!unit.attributes.contains("meter")) {  // COLLADA's default, also of <unit name="inch"/>
      const std::string name = base::lower(unit.attribute("name"));
      if (!is_one_of(name, {"", "m", "meter", "metre"})) {
        options_.warn(document_.place(unit) + ": <unit> '" + name +
                      "' has no 'meter': the numbers are taken as metres");
      }
      return 1;
    }
    const double metres = document_.number<double>(unit, "meter");
    if (metres <= 0) document_.fail(unit, "<unit>: 'meter' must be above 0");
    return metres;
  }

  /// The geometries of a scene or a node, and of the nodes below.
  void take_nodes(const XmlElement& parent, const Eigen::Affine3d& X_parent, int depth) {
    if (depth > kDeepest) document_.fail(parent, "has nodes that name each other without end");
    if ((visits_ += 1 + parent.children.size()) > kMostVisits) {
      document_.fail(parent,
                     "more than " + std::to_string(kMostVisits) +
                         " elements of nodes are named from here, or nodes name each other");
    }
    Eigen::Affine3d X = X_parent;
    for (const XmlElement& element : parent.children) apply(element, X);
    for (const XmlElement& element : parent.children) {
      if (element.name == "node") {
        take_nodes(element, X, depth + 1);
      } else if (element.name == "instance_node") {
        take_nodes(document_.target(element, "url", "node"), X, depth + 1);
      } else if (element.name == "instance_geometry") {
        geometry_.take(document_.target(element, "url", "geometry"), X);
      } else if (element.name == "instance_controller") {
        options_.warn(document_.place(element) +
                      ": <instance_controller> is left out: skins and morphs are not read");
      } else {
        document_.require_known(
            element, {"matrix", "translate", "scale", "rotate", "asset", "extra", "instance_camera",
                      "instance_light", "evaluate_scene"});
      }
    }
  }

  /// One of the transformations of a <node>, in their order, or nothing of its other children.
  void apply(const XmlElement& element, Eigen::Affine3d& X) const {
    if (element.name == "matrix") {
      X = X * matrix_of(element);
    } else if (element.name == "translate") {
      X.translate(vector_of(element));
    } else if (element.name == "scale") {
      X.scale(vector_of(element));
    } else if (element.name == "rotate") {
      const std::vector<double> v = document_.numbers<double>(element, 4);
      const Eigen::Vector3d axis(v[0], v[1], v[2]);
      if (axis.norm() > 0) {
        X.rotate(Eigen::AngleAxisd(base::radians(v[3]), axis.normalized()));
      } else if (v[3] != 0) {
        document_.fail(element, "<rotate> has an axis of length zero");
      }
    }
    if (!X.matrix().allFinite()) document_.fail(element, "<" + element.name + "> is too large");
  }

  Eigen::Vector3d vector_of(const XmlElement& element) const {
    return Eigen::Vector3d(document_.numbers<double>(element, 3).data());
  }

  Eigen::Affine3d matrix_of(const XmlElement& element) const {
    using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
    const std::vector<double> v = document_.numbers<double>(element, 16);
    const Matrix matrix = Eigen::Map<const Matrix>(v.data());
    if (!matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-6)) {
      document_.fail(element, "the last row of <matrix> must be 0 0 0 1");
    }
    return Eigen::Affine3d(matrix);
  }

  const ColladaDocument& document_;
  const MeshOptions& options_;
  ColladaGeometry geometry_;
  std::size_t visits_ = 0;
};

}  // namespace

TriangleMesh parse_collada(std::string_view text, const std::string& file,
                           const MeshOptions& options) {
  const ColladaDocument document(text, file);
  return Scene(document, options).run();
}

}  // namespace cas::sim
