// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/aero_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "base/angles.hpp"
#include "base/config/missing_keys.hpp"
#include "base/config/model_match.hpp"
#include "base/suggestion.hpp"

namespace cas::base {
namespace {

// Numbers beyond these are typing errors; a blend narrower or wider than these ends is no stall.
constexpr double kMostCoefficient = 1e4;
constexpr double kMostLength_m = 1e3;
constexpr double kLeastSharpness = 10;
constexpr double kMostSharpness = 1000;
constexpr std::size_t kMostPanels = 64;

void need_all(const ConfigNode& node, std::initializer_list<const char*> keys) {
  MissingKeys missing;
  for (const char* key : keys) missing.need(node, key);
  missing.check(node, "");
}

double coefficient(const ConfigNode& node, std::string_view key) {
  return node.get_in(key, 0.0, -kMostCoefficient, kMostCoefficient);
}

double length_of(const ConfigNode& node, std::string_view key) {
  positive_value(node, key);
  return node.require_in(key, 0, kMostLength_m);
}

double angle(const ConfigNode& node, std::string_view key, double low_deg, double high_deg) {
  return radians(node.require_in(key, low_deg, high_deg));
}

// The control surfaces.

ControlSurface parse_surface(const ConfigNode& node, OutputUse& outputs) {
  need_all(node, {"name", "output", "min_deg", "max_deg", "rate_deg_s", "time_constant_s"});
  ControlSurface surface;
  surface.name = node.require<std::string>("name");
  surface.min_rad = angle(node, "min_deg", -90, 90);
  surface.max_rad = angle(node, "max_deg", -90, 90);
  if (surface.min_rad * surface.max_rad > 0 || surface.min_rad == surface.max_rad) {
    node.at("max_deg").fail("must have the other sign than min_deg: 0 lies between them");
  }
  surface.rate_rad_s = angle(node, "rate_deg_s", 1, 1e5);
  surface.time_constant_s = node.require_in("time_constant_s", 1e-3, 10);
  surface.output = output_of(node.at("output"));
  outputs.take(node.at("output"), surface.output);
  return surface;
}

std::vector<ControlSurface> parse_surfaces(const ConfigNode& node, OutputUse& outputs) {
  std::vector<ControlSurface> surfaces;
  for (const ConfigNode& item : node.items()) {
    surfaces.push_back(parse_surface(item, outputs));
    for (std::size_t i = 0; i + 1 < surfaces.size(); ++i) {
      if (surfaces[i].name == surfaces.back().name) {
        item.at("name").fail("is the name of another surface, too");
      }
    }
  }
  return surfaces;
}

/// The surfaces by name, and which of them something in the file moves the vehicle by.
class SurfaceNames {
 public:
  explicit SurfaceNames(const std::vector<ControlSurface>& surfaces)
      : surfaces_(surfaces), used_(surfaces.size()) {}

  /// Index of a surface. @throws ConfigError at `at` when there is none of that name
  int use(const ConfigNode& at, const std::string& name) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
      names.push_back(surfaces_[i].name);
      if (surfaces_[i].name != name) continue;
      used_[i] = true;
      return static_cast<int>(i);
    }
    at.fail("'" + name + "' is none of the surfaces of 'aero.surfaces'" +
            did_you_mean(name, names));
  }
  /// @throws ConfigError when one has no effect
  void check_used(const ConfigNode& node) const {
    for (std::size_t i = 0; i < used_.size(); ++i) {
      if (used_[i]) continue;
      node.items()[i].at("name").fail(
          "has no effect: no row of 'derivatives' and no panel names '" + surfaces_[i].name + "'");
    }
  }

 private:
  const std::vector<ControlSurface>& surfaces_;
  std::vector<bool> used_;
};

// The derivatives.

void add_surfaces(const ConfigNode& node, const char* key, double unit, SurfaceNames& names,
                  CoefficientRow& row) {
  const auto block = node.find(key);
  if (!block) return;
  for (const auto& [name, value] : block->entries()) {
    const auto index = static_cast<std::size_t>(names.use(value, name));
    const auto number = value.as<double>();
    if (!(std::abs(number) <= kMostCoefficient)) value.fail("must be a number within +-10000");
    if (row.surfaces[index] != 0) value.fail("is given per_rad and per_deg; leave one out");
    row.surfaces[index] = number / unit;
  }
}

CoefficientRow parse_row(const ConfigNode& node, std::size_t surfaces, SurfaceNames& names) {
  CoefficientRow row;
  row.zero = coefficient(node, "zero");
  row.alpha = coefficient(node, "alpha");
  row.beta = coefficient(node, "beta");
  row.p = coefficient(node, "p");
  row.q = coefficient(node, "q");
  row.r = coefficient(node, "r");
  row.surfaces.assign(surfaces, 0.0);
  add_surfaces(node, "per_rad", 1.0, names, row);
  add_surfaces(node, "per_deg", kRadPerDeg, names, row);
  return row;
}

DerivativeForm parse_form(const ConfigNode& node) {
  const auto word = node.as<std::string>();
  if (word == "beard") return DerivativeForm::kBeard;
  if (word == "avl") return DerivativeForm::kAvl;
  node.fail("must be beard or avl");
}

DerivativeParams parse_derivatives(const ConfigNode& node, std::size_t surfaces,
                                   SurfaceNames& names) {
  need_all(node, {"form", "area_m2", "span_m", "chord_m", "efficiency", "stall_deg",
                  "stall_sharpness", "lift", "drag", "side", "roll", "pitch", "yaw"});
  need_all(node.at("lift"), {"alpha"});
  need_all(node.at("drag"), {"zero"});
  DerivativeParams body;
  body.form = parse_form(node.at("form"));
  body.area_m2 = length_of(node, "area_m2");
  body.span_m = length_of(node, "span_m");
  body.chord_m = length_of(node, "chord_m");
  body.efficiency = node.require_in("efficiency", 0.1, 2);
  body.stall_rad = angle(node, "stall_deg", 1, 60);
  body.stall_sharpness = node.require_in("stall_sharpness", kLeastSharpness, kMostSharpness);
  if (const auto centre = node.find("centre_B_m")) body.centre_B_m = centre->as<Eigen::Vector3d>();
  const std::pair<const char*, CoefficientRow*> rows[]{{"lift", &body.lift},   {"drag", &body.drag},
                                                       {"side", &body.side},   {"roll", &body.roll},
                                                       {"pitch", &body.pitch}, {"yaw", &body.yaw}};
  for (const auto& [key, row] : rows) *row = parse_row(node.at(key), surfaces, names);
  return body;
}

// The panels.

void parse_place(const ConfigNode& node, PanelParams& panel) {
  panel.position_B_m = node.require<Eigen::Vector3d>("position_B_m");
  if (const auto normal = node.find("normal_B")) panel.normal_B = unit_vector(*normal);
  Eigen::Vector3d forward = panel.forward_B;
  if (const auto key = node.find("forward_B")) forward = unit_vector(*key);
  // The chord is at right angles to the normal, whatever the file rounds.
  forward -= forward.dot(panel.normal_B) * panel.normal_B;
  constexpr double kParallel = 0.1;
  if (forward.norm() < kParallel) {
    node.at("normal_B").fail("points along forward_B: give the direction of the chord, too");
  }
  panel.forward_B = forward.normalized();
}

void parse_size(const ConfigNode& node, PanelParams& panel) {
  if (node.has("area_m2")) {
    if (const auto span = node.find("span_m")) {
      span->fail("is given beside area_m2; leave one out");
    }
    panel.area_m2 = length_of(node, "area_m2");
    if (node.has("chord_m")) panel.chord_m = length_of(node, "chord_m");
    return;
  }
  need_all(node, {"span_m", "chord_m"});
  panel.chord_m = length_of(node, "chord_m");
  panel.area_m2 = length_of(node, "span_m") * panel.chord_m;
}

void parse_stall(const ConfigNode& node, PanelParams& panel) {
  panel.stall_rad = angle(node, "stall_deg", 1, 60);
  panel.blends = node.has("stall_sharpness") || node.has("plate_normal_force");
  if (panel.blends) {
    need_all(node, {"stall_sharpness", "plate_normal_force"});
    panel.stall_sharpness = node.require_in("stall_sharpness", kLeastSharpness, kMostSharpness);
    panel.plate_normal_force = node.require_in("plate_normal_force", 0, 10);
    for (const char* key : {"after_stall_lift_slope_per_rad", "after_stall_drag_slope_per_rad"}) {
      if (const auto line = node.find(key)) line->fail("is given beside a blend with a plate");
    }
    return;
  }
  need_all(node, {"after_stall_lift_slope_per_rad", "after_stall_drag_slope_per_rad"});
  panel.after_stall_drag_slope_per_rad = coefficient(node, "after_stall_drag_slope_per_rad");
  panel.after_stall_lift_slope_per_rad = coefficient(node, "after_stall_lift_slope_per_rad");
  const double across = panel.lift_slope_per_rad * panel.stall_rad +
                        panel.after_stall_lift_slope_per_rad * (M_PI / 2 - panel.stall_rad);
  if (across > 0) {
    node.at("after_stall_lift_slope_per_rad")
        .fail("leaves lift at 90 deg, across the air: it must fall faster");
  }
}

/// A table of coefficients; zero_lift_deg and lift_slope_per_rad serve the controller's gains then.
void parse_polar(const ConfigNode& node, PanelParams& panel) {
  const ConfigNode file = node.at("polar");
  panel.polar = file.resolve(file.as<std::string>());
  panel.plate_normal_force = node.require_in("plate_normal_force", 0, 10);
  for (const char* key : {"stall_deg", "stall_sharpness", "drag_zero", "drag_slope_per_rad",
                          "after_stall_lift_slope_per_rad", "after_stall_drag_slope_per_rad",
                          "moment_zero", "moment_slope_per_rad"}) {
    if (const auto slope = node.find(key)) slope->fail("is given beside 'polar'; leave one out");
  }
}

/// What the panel feels of wing and propeller.
void parse_neighbours(const ConfigNode& node, const std::vector<bool>& tilts, PanelParams& panel) {
  panel.downwash_share = node.get_in("downwash_share", 0, 0, 1);
  const auto rotor = node.find("in_wash_of");
  if (!rotor) return;
  panel.in_wash_of = rotor->as<int>() - 1;
  if (panel.in_wash_of < 0 || panel.in_wash_of >= std::ssize(tilts)) {
    rotor->fail("must be the number of a rotor, 1 to " + std::to_string(tilts.size()));
  }
  if (tilts[static_cast<std::size_t>(panel.in_wash_of)]) {  // the wash goes along a fixed axis
    rotor->fail("names a rotor with a tilt servo, whose wash is not modelled");
  }
}

/// Lift, drag and moment by slopes.
void parse_slopes(const ConfigNode& node, PanelParams& panel) {
  panel.drag_zero = node.require_in("drag_zero", 0, kMostCoefficient);
  panel.drag_slope_per_rad = node.get_in("drag_slope_per_rad", 0, 0, kMostCoefficient);
  parse_stall(node, panel);
  panel.moment_zero = coefficient(node, "moment_zero");
  panel.moment_slope_per_rad = coefficient(node, "moment_slope_per_rad");
}

PanelParams parse_panel(const ConfigNode& node, SurfaceNames& names,
                        const std::vector<bool>& tilts) {
  const bool has_polar = node.has("polar");
  if (has_polar) {
    need_all(node, {"position_B_m", "zero_lift_deg", "lift_slope_per_rad", "chord_m",
                    "plate_normal_force"});
  } else {
    need_all(node,
             {"position_B_m", "zero_lift_deg", "lift_slope_per_rad", "stall_deg", "drag_zero"});
  }
  PanelParams panel;
  parse_place(node, panel);
  parse_size(node, panel);
  panel.zero_lift_rad = angle(node, "zero_lift_deg", -90, 90);
  panel.lift_slope_per_rad = node.require_in("lift_slope_per_rad", 0, kMostCoefficient);
  panel.induced_drag_factor = node.get_in("induced_drag_factor", 0, 0, kMostCoefficient);
  has_polar ? parse_polar(node, panel) : parse_slopes(node, panel);
  parse_neighbours(node, tilts, panel);
  if (const auto surface = node.find("surface")) {
    need_all(node, {"surface_lift_per_rad"});
    panel.surface = names.use(*surface, surface->as<std::string>());
    panel.surface_lift_per_rad = coefficient(node, "surface_lift_per_rad");
    panel.surface_moment_per_rad = coefficient(node, "surface_moment_per_rad");
  }
  const bool turns = panel.moment_zero != 0 || panel.moment_slope_per_rad != 0 ||
                     panel.surface_moment_per_rad != 0;
  if (turns && panel.chord_m == 0) need_all(node, {"chord_m"});
  return panel;
}

std::vector<PanelParams> parse_panels(const ConfigNode& node, SurfaceNames& names,
                                      const std::vector<bool>& tilts) {
  const ConfigNode common = node.find("panel").value_or(ConfigNode::empty());
  std::vector<PanelParams> panels;
  const auto list = node.find("panels");
  if (!list) return panels;
  const std::vector<ConfigNode> items = list->items();
  if (items.empty() || items.size() > kMostPanels) {
    list->fail("must list 1 to " + std::to_string(kMostPanels) + " panels");
  }
  for (const ConfigNode& item : items) {
    panels.push_back(parse_panel(item.merged_over(common), names, tilts));
  }
  return panels;
}

}  // namespace

AeroParams read_aero(const ConfigNode& node, OutputUse& outputs, const std::vector<bool>& tilts) {
  need_all(node, {"cruise_m_s"});
  AeroParams aero;
  aero.cruise_m_s = node.require_in("cruise_m_s", 1, 300);
  const auto surfaces = node.find("surfaces");
  if (surfaces) aero.surfaces = parse_surfaces(*surfaces, outputs);
  SurfaceNames names(aero.surfaces);
  if (const auto body = node.find("derivatives")) {
    aero.derivatives = parse_derivatives(*body, aero.surfaces.size(), names);
  }
  aero.panels = parse_panels(node, names, tilts);
  const bool has_downwash = std::ranges::any_of(
      aero.panels, [](const PanelParams& panel) { return panel.downwash_share > 0; });
  if (has_downwash) {
    need_all(node, {"wing_span_m"});
    aero.wing_span_m = length_of(node, "wing_span_m");
  }
  if (!aero.derivatives && aero.panels.empty()) {
    node.fail("needs 'derivatives' or 'panels': without them no air acts on the vehicle");
  }
  if (surfaces) names.check_used(*surfaces);
  return aero;
}

}  // namespace cas::base
