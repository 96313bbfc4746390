// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <utility>
#include <vector>

#include "libsim/core/body/shape.hpp"
#include "libsim/core/load/collada_document.hpp"
#include "libsim/core/load/mesh_options.hpp"

namespace cas::sim {

/// Collects the triangles of <geometry> elements.
class ColladaGeometry {
 public:
  /// @param document, options  outlive it
  ColladaGeometry(const ColladaDocument& document, const MeshOptions& options)
      : document_(document), options_(options) {}

  /// Adds a geometry in its place. @throws base::ConfigError
  void take(const base::XmlElement& geometry, const Eigen::Affine3d& X);

  /// The triangles so far.
  TriangleMesh release() { return std::move(mesh_); }

 private:
  using Indices = std::vector<std::uint32_t>;

  /// Which numbers of a <p> name vertices, and which vertices they are.
  struct Corners {
    std::size_t stride = 0;
    std::size_t offset = 0;
    const base::XmlElement* vertices = nullptr;
  };

  void take_faces(const base::XmlElement& mesh, const base::XmlElement& part,
                  const Eigen::Affine3d& X);
  Corners corners_of(const base::XmlElement& mesh, const base::XmlElement& part) const;
  std::size_t add_positions(const base::XmlElement& mesh, const base::XmlElement& vertices,
                            const Eigen::Affine3d& X);
  Indices read_list(const base::XmlElement& list, const Corners& corners, std::size_t first,
                    std::size_t count);
  void cut(const base::XmlElement& part, const base::XmlElement& list, const Indices& corners);
  void cut_polylist(const base::XmlElement& part, const base::XmlElement& list,
                    const Indices& corners);
  void add_fan(const base::XmlElement& list, const Indices& corners, std::size_t at,
               std::size_t length);
  void compare_count(const base::XmlElement& part) const;
  void require_few(const base::XmlElement& at) const;

  const ColladaDocument& document_;
  const MeshOptions& options_;
  TriangleMesh mesh_;
  std::size_t numbers_ = 0;  ///< read so far, and elements of geometries
  std::size_t faces_ = 0;    ///< of the part that is being read
  bool has_thin_faces_ = false;
};

}  // namespace cas::sim
