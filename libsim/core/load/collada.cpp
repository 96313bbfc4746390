// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/collada.hpp"

#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "base/angles.hpp"
#include "base/config/xml_tree.hpp"
#include "base/error.hpp"

namespace cas::sim {

using base::parse_xml;
using base::XmlElement;

namespace {

using Indices = std::vector<std::uint32_t>;

/// The numbers of a text, separated by white space.
template <class Number>
std::vector<Number> numbers(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  std::vector<Number> all;
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;
       at = text.find_first_not_of(kSpace, at)) {
    Number value{};
    const char* const begin = text.data() + at;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc{}) break;
    all.push_back(value);
    at += static_cast<std::size_t>(end - begin);
  }
  return all;
}

Eigen::Affine3d axis_rotation(const std::vector<double>& v) {
  return Eigen::Affine3d(
      Eigen::AngleAxisd(base::radians(v[3]), Eigen::Vector3d(v[0], v[1], v[2]).normalized()));
}

/// One of the transformations of a <node>, or nothing for its other children.
bool apply(const XmlElement& element, Eigen::Affine3d& X) {
  const auto takes = [&](std::string_view name, std::size_t count, std::vector<double>& v) {
    if (element.name != name) return false;
    v = numbers<double>(element.text);
    return v.size() >= count;
  };
  std::vector<double> v;
  if (takes("matrix", 16, v)) {
    X = X * Eigen::Affine3d(
                Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(v.data()).eval());
  } else if (takes("translate", 3, v)) {
    X.translate(Eigen::Vector3d(v[0], v[1], v[2]));
  } else if (takes("rotate", 4, v)) {
    X = X * axis_rotation(v);
  } else if (takes("scale", 3, v)) {
    X.scale(Eigen::Vector3d(v[0], v[1], v[2]));
  } else {
    return false;
  }
  return true;
}

class Collada {
 public:
  Collada(const XmlElement& root, std::string file) : root_(root), file_(std::move(file)) {
    if (root_.name != "COLLADA") fail("is no COLLADA file");
    index(root_);
  }

  TriangleMesh run() {
    const Eigen::Affine3d X = to_metres_z_up();
    const XmlElement* const scene = root_.child("scene");
    const XmlElement* const instance = scene ? scene->child("instance_visual_scene") : nullptr;
    if (instance != nullptr) {
      take_nodes(target(*instance, "url"), X, 0);
    } else if (const XmlElement* library = root_.child("library_geometries")) {
      for (const XmlElement& geometry : library->children) take_geometry(geometry, X);
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& sentence) const {
    throw base::ConfigError(file_ + ": " + sentence);
  }

  void index(const XmlElement& element) {
    if (const auto id = element.attribute("id"); !id.empty()) by_id_.emplace(id, &element);
    for (const XmlElement& child : element.children) index(child);
  }

  /// The element that "#id" in an attribute names.
  const XmlElement& target(const XmlElement& element, std::string_view key) const {
    std::string_view url = element.attribute(key);
    if (!url.empty() && url.front() == '#') url.remove_prefix(1);
    const auto found = by_id_.find(url);
    if (found == by_id_.end()) fail("names '" + std::string(url) + "', which it does not have");
    return *found->second;
  }

  Eigen::Affine3d to_metres_z_up() const {
    Eigen::Affine3d X = Eigen::Affine3d::Identity();
    const XmlElement* const asset = root_.child("asset");
    if (asset == nullptr) return X;
    const XmlElement* const up = asset->child("up_axis");
    const bool z_up = up != nullptr && up->text.find("Z_UP") != std::string::npos;
    const bool x_up = up != nullptr && up->text.find("X_UP") != std::string::npos;
    if (x_up) X.rotate(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitY()));
    if (!x_up && !z_up) X.rotate(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
    if (const XmlElement* const unit = asset->child("unit")) {
      const auto metres = numbers<double>(unit->attribute("meter"));
      if (!metres.empty() && metres.front() > 0) X.scale(metres.front());
    }
    return X;
  }

  /// The geometries of a scene or a node, and of the nodes below.
  void take_nodes(const XmlElement& parent, const Eigen::Affine3d& X_parent, int depth) {
    constexpr int kDeepest = 64;  // a node library may name itself
    if (depth > kDeepest) fail("has nodes that name each other without end");
    Eigen::Affine3d X = X_parent;
    for (const XmlElement& element : parent.children) {
      if (apply(element, X)) continue;
      if (element.name == "node") take_nodes(element, X, depth + 1);
      if (element.name == "instance_node") take_nodes(target(element, "url"), X, depth + 1);
      if (element.name == "instance_geometry") take_geometry(target(element, "url"), X);
    }
  }

  void take_geometry(const XmlElement& geometry, const Eigen::Affine3d& X) {
    const XmlElement* const mesh = geometry.child("mesh");
    if (mesh == nullptr) return;
    for (const XmlElement& part : mesh->children) {
      if (part.name == "triangles" || part.name == "polylist" || part.name == "polygons") {
        take_faces(part, X);
      }
    }
  }

  void take_faces(const XmlElement& part, const Eigen::Affine3d& X) {
    std::size_t stride = 0;
    std::size_t offset = 0;
    const XmlElement* vertices = nullptr;
    for (const XmlElement& input : part.children) {
      if (input.name != "input") continue;
      const auto at = numbers<std::uint32_t>(input.attribute("offset"));
      const std::size_t place = at.empty() ? 0 : at.front();
      stride = std::max(stride, place + 1);
      if (input.attribute("semantic") != "VERTEX") continue;
      offset = place;
      vertices = &target(input, "source");
    }
    if (vertices == nullptr) return;
    const auto first = static_cast<std::uint32_t>(mesh_.vertices.size());
    const std::size_t count = add_positions(*vertices, X);
    const XmlElement* const lengths = part.child("vcount");
    const Indices face_lengths = lengths ? numbers<std::uint32_t>(lengths->text) : Indices{};
    for (const XmlElement& list : part.children) {
      if (list.name != "p") continue;
      const Indices all = numbers<std::uint32_t>(list.text);
      Indices corners;
      for (std::size_t i = offset; i < all.size(); i += stride) {
        if (all[i] >= count) fail("has a face that names no vertex: " + std::to_string(all[i]));
        corners.push_back(first + all[i]);
      }
      cut_into_faces(part.name, corners, face_lengths);
    }
  }

  /// The positions behind <vertices>. @return how many
  std::size_t add_positions(const XmlElement& vertices, const Eigen::Affine3d& X) {
    for (const XmlElement& input : vertices.children) {
      if (input.name != "input" || input.attribute("semantic") != "POSITION") continue;
      const XmlElement& source = target(input, "source");
      const XmlElement* const array = source.child("float_array");
      if (array == nullptr) fail("has positions without numbers");
      const std::vector<double> v = numbers<double>(array->text);
      const std::size_t step = stride_of(source);
      for (std::size_t i = 0; i + 2 < v.size(); i += step) {
        mesh_.vertices.push_back(X * Eigen::Vector3d(v[i], v[i + 1], v[i + 2]));
      }
      return v.size() / step;
    }
    fail("has vertices without positions");
  }

  static std::size_t stride_of(const XmlElement& source) {
    const XmlElement* const common = source.child("technique_common");
    const XmlElement* const accessor = common ? common->child("accessor") : nullptr;
    const auto stride =
        accessor ? numbers<std::uint32_t>(accessor->attribute("stride")) : Indices{};
    return stride.empty() || stride.front() < 3 ? 3 : stride.front();
  }

  void cut_into_faces(std::string_view kind, const Indices& corners, const Indices& lengths) {
    if (kind == "triangles") {
      for (std::size_t i = 0; i + 2 < corners.size(); i += 3) add_fan(corners, i, 3);
    } else if (kind == "polygons") {
      add_fan(corners, 0, corners.size());
    } else {
      std::size_t at = 0;
      for (const std::uint32_t length : lengths) {
        if (at + length > corners.size()) fail("has a polylist with too few corners");
        add_fan(corners, at, length);
        at += length;
      }
    }
  }

  void add_fan(const Indices& corners, std::size_t at, std::size_t length) {
    for (std::size_t i = 2; i < length; ++i) {
      mesh_.triangles.push_back({corners[at], corners[at + i - 1], corners[at + i]});
    }
  }

  const XmlElement& root_;
  std::string file_;
  std::map<std::string_view, const XmlElement*> by_id_;
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh parse_collada(std::string_view text, const std::string& file) {
  const XmlElement root = parse_xml(text, file);
  return Collada(root, file).run();
}

}  // namespace cas::sim
