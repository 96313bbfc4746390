// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <variant>

#include "libsim/core/body/shape.hpp"
#include "libsim/hilsim/vehicle_description.hpp"

namespace cas::sim {
namespace {

constexpr double kView_px = 400;  // width and height of a view
constexpr double kMargin_px = 40;
constexpr int kCircleParts = 48;

using Points = std::vector<Eigen::Vector3d>;
using Flat = Eigen::Vector2d;

/// How B is seen: right and up of the picture.
struct View {
  const char* title;
  Eigen::Vector3d right_B;
  Eigen::Vector3d up_B;
  double origin_px;  // of the left edge
};

Points circle(const Eigen::Vector3d& centre, const Eigen::Vector3d& axis, double radius) {
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  Points points;
  for (int i = 0; i < kCircleParts; ++i) {
    const double a = 2 * std::numbers::pi * i / kCircleParts;
    points.push_back(centre + radius * (std::cos(a) * u + std::sin(a) * v));
  }
  return points;
}

/// Points whose hull is the shape, in B; none for an infinite shape.
Points points_of(const Shape& shape) {
  Points points;
  if (const auto* box = std::get_if<Box>(&shape.geometry)) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5,
                                 corner & 4 ? 0.5 : -0.5);
      points.push_back(sign.cwiseProduct(box->size_m));
    }
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape.geometry)) {
    for (const double end : {-0.5, 0.5}) {
      const Points ring =
          circle({0, 0, end * cylinder->length_m}, Eigen::Vector3d::UnitZ(), cylinder->radius_m);
      points.insert(points.end(), ring.begin(), ring.end());
    }
  } else if (const auto* sphere = std::get_if<Sphere>(&shape.geometry)) {
    for (const Eigen::Vector3d& axis :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
      const Points ring = circle(Eigen::Vector3d::Zero(), axis, sphere->radius_m);
      points.insert(points.end(), ring.begin(), ring.end());
    }
  }
  for (Eigen::Vector3d& point : points) point = shape.pose * point;
  return points;
}

/// Convex hull by Andrew's monotone chain.
std::vector<Flat> hull(std::vector<Flat> points) {
  std::sort(points.begin(), points.end(), [](const Flat& a, const Flat& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Flat> chain;
  const auto turns_right = [&chain](const Flat& next) {
    const Flat& a = chain[chain.size() - 2];
    const Flat& b = chain.back();
    return (b.x() - a.x()) * (next.y() - a.y()) - (b.y() - a.y()) * (next.x() - a.x()) <= 0;
  };
  for (int side = 0; side < 2; ++side) {
    const std::size_t first = chain.size();
    for (const Flat& point : points) {
      while (chain.size() >= first + 2 && turns_right(point)) chain.pop_back();
      chain.push_back(point);
    }
    chain.pop_back();  // where the other side begins
    std::reverse(points.begin(), points.end());
  }
  return chain;
}

/// Writes both views to one scale.
class Drawing {
 public:
  Drawing(const base::Vehicle& vehicle, const VehicleModel& model)
      : vehicle_(vehicle), model_(model) {
    double reach = 0.1;
    for (const base::Rotor& rotor : vehicle.rotors) {
      reach = std::max(reach, rotor.position_B_m.norm() + rotor.params.radius_m);
    }
    for (const Shape& shape : model.shapes) {
      for (const Eigen::Vector3d& point : points_of(shape)) reach = std::max(reach, point.norm());
    }
    scale_ = (kView_px / 2 - kMargin_px) / reach;
  }

  std::string run() {
    add("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 800 440\" "
        "font-family=\"sans-serif\" "
        "font-size=\"13\">\n<rect width=\"800\" height=\"440\" fill=\"white\"/>\n");
    draw({"from above, nose up", -Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX(), 0});
    draw({"from the left, nose to the left", -Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ(),
          kView_px});
    add(
        fmt::format("<path d=\"M 20 425 h {:.1f}\" stroke=\"black\" stroke-width=\"2\"/>"
                    "<text x=\"20\" y=\"418\">0.1 m</text>\n</svg>\n",
                    0.1 * scale_));
    return std::move(svg_);
  }

 private:
  void add(std::string_view text) { svg_ += text; }

  Flat project(const View& view, const Eigen::Vector3d& p_B) const {
    return {view.origin_px + kView_px / 2 + scale_ * view.right_B.dot(p_B),
            20 + kView_px / 2 - scale_ * view.up_B.dot(p_B)};
  }

  void draw(const View& view) {
    add(fmt::format("<text x=\"{:.0f}\" y=\"20\">{}</text>\n", view.origin_px + 20, view.title));
    for (const Shape& shape : model_.shapes) {
      polygon(view, points_of(shape), "fill=\"#dddde4\" stroke=\"#888\"");
    }
    for (std::size_t i = 0; i < vehicle_.rotors.size(); ++i) draw_rotor(view, i);
    const Flat centre = project(view, Eigen::Vector3d::Zero());
    add(fmt::format(
        "<path d=\"M {:.1f} {:.1f} h 12 m -6 -6 v 12\" stroke=\"#c00\" stroke-width=\"2\"/>\n",
        centre.x() - 6, centre.y()));
  }

  void draw_rotor(const View& view, std::size_t index) {
    const base::Rotor& rotor = vehicle_.rotors[index];
    polygon(view, circle(rotor.position_B_m, rotor.axis_B, rotor.params.radius_m),
            rotor.spin > 0 ? "fill=\"#2a6fdb\" fill-opacity=\"0.25\" stroke=\"#2a6fdb\""
                           : "fill=\"#d9822b\" fill-opacity=\"0.25\" stroke=\"#d9822b\"");
    const Flat hub = project(view, rotor.position_B_m);
    const Flat tip = project(view, rotor.position_B_m + 0.08 * rotor.axis_B);
    // The arrow turns as the rotor is seen to in this view.
    const bool from_behind = rotor.axis_B.dot(view.right_B.cross(view.up_B)) < -1e-9;
    // Rotors of one arm stand over each other: their numbers stand side by side.
    const double aside = rotor.wake ? 26 : -4;
    add(
        fmt::format("<path d=\"M {:.1f} {:.1f} L {:.1f} {:.1f}\" stroke=\"black\"/>"
                    "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{} {}</text>\n",
                    hub.x(), hub.y(), tip.x(), tip.y(), hub.x() + aside, hub.y() - 6, index + 1,
                    (rotor.spin > 0) != from_behind ? "&#8634;" : "&#8635;"));
  }

  void polygon(const View& view, const Points& points, const char* style) {
    if (points.empty()) return;
    std::vector<Flat> flat;
    for (const Eigen::Vector3d& point : points) flat.push_back(project(view, point));
    svg_ += "<polygon points=\"";
    for (const Flat& point : hull(std::move(flat))) {
      svg_ += fmt::format("{:.1f},{:.1f} ", point.x(), point.y());
    }
    svg_ += std::string("\" ") + style + "/>\n";
  }

  const base::Vehicle& vehicle_;
  const VehicleModel& model_;
  double scale_ = 1;  // px/m
  std::string svg_;
};

}  // namespace

std::string draw_vehicle(const base::Vehicle& vehicle, const VehicleModel& model) {
  return Drawing(vehicle, model).run();
}

}  // namespace cas::sim
