// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/collada_geometry.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>

namespace cas::sim {

using base::XmlElement;

namespace {

constexpr std::array<std::string_view, 5> kFaces{"triangles", "tristrips", "trifans", "polylist",
                                                 "polygons"};
/// Most numbers of all geometries together; one that is placed several times is read, and counts,
/// each time.
constexpr std::size_t kMostNumbers = 20 * kMostTriangles;

}  // namespace

void ColladaGeometry::take(const XmlElement& geometry, const Eigen::Affine3d& X) {
  for (const XmlElement& each : geometry.children) {
    numbers_ += each.children.size() + 1;
    require_few(each);
    if (each.name == "mesh") {
      for (const XmlElement& part : each.children) {
        if (std::ranges::find(kFaces, part.name) != kFaces.end()) {
          take_faces(each, part, X);
        } else {
          document_.require_known(part, {"source", "vertices", "lines", "linestrips", "extra"});
        }
      }
    } else if (each.name != "asset" && each.name != "extra") {
      options_.warn(document_.place(each) + ": <" + each.name +
                    "> is left out: of a <geometry> the <mesh> is read");
    }
  }
}

void ColladaGeometry::take_faces(const XmlElement& mesh, const XmlElement& part,
                                 const Eigen::Affine3d& X) {
  const Corners corners = corners_of(mesh, part);
  const std::size_t first = mesh_.vertices.size();
  const std::size_t count = add_positions(mesh, *corners.vertices, X);
  const std::size_t first_triangle = mesh_.triangles.size();
  faces_ = 0;
  numbers_ += part.children.size();
  for (const XmlElement& list : part.children) {
    if (list.name == "p") {
      cut(part, list, read_list(list, corners, first, count));
    } else if (list.name == "ph") {
      ++faces_;
      options_.warn(document_.place(list) + ": <ph> is left out: polygons with holes are not read");
    } else {
      document_.require_known(list, {"input", "vcount", "extra"});
    }
    require_few(list);
  }
  compare_count(part);
  if (X.linear().determinant() >= 0) return;
  // Mirrored: triangles keep their outer side.
  for (std::size_t i = first_triangle; i < mesh_.triangles.size(); ++i) {
    std::swap(mesh_.triangles[i][1], mesh_.triangles[i][2]);
  }
}

ColladaGeometry::Corners ColladaGeometry::corners_of(const XmlElement& mesh,
                                                     const XmlElement& part) const {
  constexpr std::uint32_t kMost = 1000;  // inputs of a part
  Corners corners;
  for (const XmlElement& input : part.children) {
    if (input.name != "input") continue;
    const auto place = document_.number<std::uint32_t>(input, "offset", 0);
    if (place >= kMost) document_.fail(input, "<input>: 'offset' is too large");
    corners.stride = std::max<std::size_t>(corners.stride, place + 1);
    if (input.attribute("semantic") != "VERTEX") continue;
    corners.offset = place;
    corners.vertices = &document_.target(input, "source", "vertices", &mesh);
  }
  if (corners.vertices == nullptr) {
    document_.fail(part, "<" + part.name + "> has no <input semantic='VERTEX'>");
  }
  return corners;
}

/// The positions behind <vertices>. @return how many
std::size_t ColladaGeometry::add_positions(const XmlElement& mesh, const XmlElement& vertices,
                                           const Eigen::Affine3d& X) {
  for (const XmlElement& input : vertices.children) {
    if (input.name != "input" || input.attribute("semantic") != "POSITION") continue;
    const XmlElement& source = document_.target(input, "source", "source", &mesh);
    const XmlElement* const common = source.child("technique_common");
    const XmlElement* const accessor = common ? common->child("accessor") : nullptr;
    const XmlElement* const array =
        accessor && !accessor->attribute("source").empty()
            ? &document_.target(*accessor, "source", "float_array", &source)
            : source.child("float_array");
    if (array == nullptr) document_.fail(source, "<source> has positions without numbers");
    const std::vector<double> v =
        document_.numbers<double>(*array, document_.number<std::size_t>(*array, "count", 0));
    numbers_ += v.size();
    const std::size_t stride =
        accessor ? document_.number<std::uint32_t>(*accessor, "stride", 3) : 3;
    if (stride < 3) {
      document_.fail(*accessor,
                     fmt::format("a position has three numbers, and 'stride' is {}", stride));
    }
    const std::size_t begin =
        accessor ? document_.number<std::uint32_t>(*accessor, "offset", 0) : 0;
    std::size_t count = 0;
    for (std::size_t i = begin; i + 2 < v.size(); i += stride, ++count) {
      mesh_.vertices.push_back(X * Eigen::Vector3d(v[i], v[i + 1], v[i + 2]));
    }
    require_few(*array);
    return count;
  }
  document_.fail(vertices, "<vertices> has no <input semantic='POSITION'>");
}

ColladaGeometry::Indices ColladaGeometry::read_list(const XmlElement& list, const Corners& corners,
                                                    std::size_t first, std::size_t count) {
  const Indices all = document_.numbers<std::uint32_t>(list);
  numbers_ += all.size();
  if (all.size() % corners.stride != 0) {
    document_.fail(list, fmt::format("<p> has {} numbers, which is no multiple of {}, the numbers "
                                     "of a corner",
                                     all.size(), corners.stride));
  }
  Indices named;
  named.reserve(all.size() / corners.stride);
  for (std::size_t i = corners.offset; i < all.size(); i += corners.stride) {
    if (all[i] >= count) {
      document_.fail(list, fmt::format("<p> names the vertex {}, and there are {}", all[i], count));
    }
    named.push_back(static_cast<std::uint32_t>(first + all[i]));
  }
  return named;
}

void ColladaGeometry::cut(const XmlElement& part, const XmlElement& list, const Indices& corners) {
  const std::size_t size = corners.size();
  if (part.name == "triangles") {
    if (size % 3 != 0) document_.fail(list, "<p> ends within a triangle");
    for (std::size_t i = 0; i < size; i += 3) add_fan(list, corners, i, 3);
    faces_ += size / 3;
  } else if (part.name == "tristrips") {
    ++faces_;
    for (std::size_t i = 2; i < size; ++i) {  // every other one is wound the other way round
      const bool odd = i % 2 != 0;
      mesh_.triangles.push_back(
          {corners[i - (odd ? 1 : 2)], corners[i - (odd ? 2 : 1)], corners[i]});
    }
  } else if (part.name == "polylist") {
    cut_polylist(part, list, corners);
  } else {  // trifans, polygons
    ++faces_;
    add_fan(list, corners, 0, size);
  }
}

void ColladaGeometry::cut_polylist(const XmlElement& part, const XmlElement& list,
                                   const Indices& corners) {
  const XmlElement* const lengths = part.child("vcount");
  if (lengths == nullptr) document_.fail(part, "<polylist> has no <vcount>");
  std::size_t at = 0;
  const Indices all = document_.numbers<std::uint32_t>(*lengths);
  numbers_ += all.size();
  faces_ += all.size();
  for (const std::uint32_t length : all) {
    if (length > corners.size() - at) {
      document_.fail(list, "<p> has fewer corners than <vcount> promises");
    }
    add_fan(list, corners, at, length);
    at += length;
  }
  if (at != corners.size()) document_.fail(list, "<p> has more corners than <vcount> promises");
}

void ColladaGeometry::add_fan(const XmlElement& list, const Indices& corners, std::size_t at,
                              std::size_t length) {
  if (length < 3 && !std::exchange(has_thin_faces_, true)) {
    options_.warn(document_.place(list) + ": faces of fewer than three corners are left out");
  }
  for (std::size_t i = 2; i < length; ++i) {
    mesh_.triangles.push_back({corners[at], corners[at + i - 1], corners[at + i]});
  }
}

/// Warns when the part has another number of faces than it promises: the export is damaged, or a
/// script has edited it.
void ColladaGeometry::compare_count(const XmlElement& part) const {
  const auto promised = document_.number<std::size_t>(part, "count", faces_);
  if (promised == faces_) return;
  options_.warn(fmt::format("{}: <{}> promises {} faces and has {}", document_.place(part),
                            part.name, promised, faces_));
}

void ColladaGeometry::require_few(const XmlElement& at) const {
  if (mesh_.triangles.size() <= kMostTriangles && mesh_.vertices.size() <= 3 * kMostTriangles &&
      numbers_ <= kMostNumbers) {
    return;
  }
  document_.fail(at, fmt::format("here the mesh grows beyond {} triangles, three times as many "
                                 "vertices or {} numbers",
                                 kMostTriangles, kMostNumbers));
}

}  // namespace cas::sim
