// SPDX-License-Identifier: BSD-3-Clause
// Wings, tails and their surfaces against closed forms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "base/earth/frames.hpp"
#include "libsim/core/body/rigid_body.hpp"
#include "plugins/aero/glide_polar.hpp"
#include "plugins/aero/propeller_wash.hpp"
#include "plugins/aero/stall_blend.hpp"
#include "tests/plugins/aerosonde.hpp"
#include "tests/plugins/plugin_harness.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = 1e-12;

Environment still_air(double density = 1.225) {
  Environment air;
  air.air_density_kg_m3 = density;
  air.gravity_W = {0, 0, -test::kGravity};
  return air;
}

Wrench wrench_of(const AeroModel& model, const BodyState& body, const Environment& air,
                 std::vector<double> deflections = {}) {
  deflections.resize(static_cast<std::size_t>(model.state_count()));
  std::vector<double> rates(deflections.size());
  Wrench wrench;
  model.evaluate(body, air, deflections, rates, wrench);
  return wrench;
}

/// Level body in air from this direction (velocity of the body through the air, FLU).
BodyState moving(const Vector3d& v_B) { return {.v_WB = v_B}; }

Vector3d velocity(double speed, double alpha, double beta) {
  return speed * Vector3d(std::cos(alpha) * std::cos(beta), -std::sin(beta),
                          -std::sin(alpha) * std::cos(beta));
}

// The blend.

TEST(AttachedShare, IsOneMinusTheBooksSigma) {
  constexpr double kStall = 0.47;
  constexpr double kSharpness = 50;
  for (const double a : {-1.0, -0.47, -0.1, 0.0, 0.3, 0.47, 0.5, 1.5}) {
    const double before = std::exp(-kSharpness * (a - kStall));
    const double behind = std::exp(kSharpness * (a + kStall));
    const double sigma = (1 + before + behind) / ((1 + before) * (1 + behind));
    EXPECT_NEAR(attached_share(a, kStall, kSharpness), 1 - sigma, kRounding);
  }
  EXPECT_EQ(attached_share(M_PI, kStall, 1000), 0);
  EXPECT_EQ(attached_share(0, kStall, 1000), 1);
}

// A body of derivatives.

TEST(DerivativeBody, GivesTheLinearFormBelowTheStall) {
  const base::Vehicle vehicle = test::load_plane("aerosonde");
  const AeroModel model(*vehicle.aero);
  const double alpha = 0.06;
  const double speed = 24;
  const double beta = 0.02;
  BodyState body = moving(velocity(speed, alpha, beta));
  const Vector3d w_D(0.3, -0.2, 0.1);
  body.w_WB_B = base::swap_BD(w_D);
  const double da = 0.05;
  const double de = -0.1;
  const double dr = 0.03;
  const Environment air = still_air(1.1);
  const Wrench wrench = wrench_of(model, body, air, {da, de, dr});

  const double qs = 0.5 * 1.1 * speed * speed * 0.55;
  const double b = 2.8956 / (2 * speed);
  const double c = 0.18994 / (2 * speed);
  const double in_plane = std::pow(std::cos(beta), 2);
  const double lift = 0.23 + 5.61 * alpha + 0.13 * de + 7.95 * c * w_D.y();
  const double ar = 2.8956 * 2.8956 / 0.55;
  const double drag = 0.043 + std::pow(0.23 + 5.61 * alpha, 2) / (M_PI * 0.9 * ar) + 0.0135 * de;
  const double roll =
      -0.13 * beta - 0.51 * b * w_D.x() + 0.25 * b * w_D.z() + 0.17 * da + 0.0024 * dr;
  const double pitch = 0.0135 - 2.74 * alpha - 38.21 * c * w_D.y() - 0.99 * de;
  const double yaw =
      0.073 * beta + 0.069 * b * w_D.x() - 0.095 * b * w_D.z() - 0.011 * da - 0.069 * dr;
  const double side = -0.98 * beta + 0.075 * da + 0.19 * dr;
  const Vector3d force_D = base::swap_BD(wrench.force_B);
  const Vector3d torque_D = base::swap_BD(wrench.torque_B);
  constexpr double kSideslip = 1e-4;  // of a coefficient: cosine and sine of 0.02 rad
  const double s = std::sin(alpha);
  const double k = std::cos(alpha);
  EXPECT_NEAR(force_D.x() / qs, in_plane * (lift * s - drag * k), kSideslip);
  EXPECT_NEAR(force_D.z() / qs, in_plane * (-lift * k - drag * s), kSideslip);
  EXPECT_NEAR(force_D.y() / qs, side, kSideslip);
  EXPECT_NEAR(torque_D.x() / (qs * 2.8956), roll, kSideslip);
  EXPECT_NEAR(torque_D.y() / (qs * 0.18994), pitch, kSideslip);
  EXPECT_NEAR(torque_D.z() / (qs * 2.8956), yaw, kSideslip);
}

TEST(DerivativeBody, IsAFlatPlateAcrossTheAir) {
  const base::Vehicle vehicle = test::load_plane("aerosonde");
  const AeroModel model(*vehicle.aero);
  const Wrench wrench = wrench_of(model, moving({0, 0, -20}), still_air());
  const double qs = 0.5 * 1.225 * 400 * 0.55;
  const double plate = 2 / (1 + std::exp(-0.224 - 0.115 * 2.8956 * 2.8956 / 0.55));
  EXPECT_NEAR(wrench.force_B.z(), qs * (plate + 0.043), 1e-9);
  EXPECT_NEAR(wrench.force_B.x(), 0, 1e-9);
}

TEST(DerivativeBody, OfFormAvlHasTheInducedDragOfAllLift) {
  base::AeroParams aero = *test::load_plane("aerosonde").aero;
  aero.derivatives->form = base::DerivativeForm::kAvl;
  const AeroModel model(aero);
  const double alpha = 0.05;
  const Wrench wrench = wrench_of(model, moving(velocity(20, alpha, 0)), still_air(), {0, -0.2, 0});
  const double qs = 0.5 * 1.225 * 400 * 0.55;
  const double lift = 0.23 + 5.61 * alpha - 0.2 * 0.13;
  const double drag = 0.043 - 0.2 * 0.0135 + lift * lift / (M_PI * 0.9 * 2.8956 * 2.8956 / 0.55);
  constexpr double kAttached = 1e-8;  // what sigma takes at 0.05 rad
  EXPECT_NEAR(-wrench.force_B.x() * std::cos(alpha) + wrench.force_B.z() * std::sin(alpha),
              qs * drag, kAttached * qs);
}

// Panels.

base::PanelParams plate_panel() {
  return {.area_m2 = 0.5,
          .chord_m = 0.25,
          .lift_slope_per_rad = 5,
          .stall_rad = 0.3,
          .drag_zero = 0.02,
          .induced_drag_factor = 0.04,
          .blends = true,
          .stall_sharpness = 40,
          .plate_normal_force = 1.3};
}

TEST(LiftingPanel, LiftsUprightAndDragsAlongTheAir) {
  const LiftingPanel panel(plate_panel());
  const double alpha = 0.05;
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();
  panel.add(velocity(10, alpha, 0), 1.2, 0, force, torque);
  const double qs = 0.5 * 1.2 * 100 * 0.5;
  const double lift = 5 * alpha;
  const double drag = 0.02 + 0.04 * lift * lift;
  constexpr double kAttached = 1e-3;  // of sigma, 10 stall widths away
  EXPECT_NEAR(force.dot(Vector3d(std::sin(alpha), 0, std::cos(alpha))), qs * lift,
              kAttached * qs * lift);
  EXPECT_NEAR(force.dot(Vector3d(-std::cos(alpha), 0, std::sin(alpha))), qs * drag,
              kAttached * qs * drag);
  EXPECT_EQ(torque, Vector3d::Zero());
}

TEST(LiftingPanel, FollowsGazebosLinesBeyondTheStall) {
  const base::PanelParams wing = test::load_plane("panel_plane").aero->panels[0];
  const auto at = [&](double angle) {
    return panel_coefficients(wing, angle, std::sin(angle), std::cos(angle), 0);
  };
  constexpr double kDigits = 1e-6;  // of the file
  EXPECT_NEAR(at(0.2).lift, 4.7527987 * 0.2, kDigits);
  EXPECT_NEAR(at(0.2).drag, 0.64171123 * 0.2, kDigits);
  EXPECT_NEAR(at(-0.2).lift, -4.7527987 * 0.2, kDigits);
  EXPECT_NEAR(at(-0.2).drag, 0.64171123 * 0.2, kDigits);
  EXPECT_NEAR(at(0.4).lift, 4.7527987 * 0.33914281 - 3.85 * (0.4 - 0.33914281), kDigits);
  EXPECT_NEAR(at(0.4).drag, 0.64171123 * 0.33914281 - 0.9233984 * (0.4 - 0.33914281), kDigits);
  EXPECT_EQ(at(1.2).lift, 0);
  EXPECT_NEAR(at(M_PI / 2).drag, 0.9233984 * (M_PI / 2 - 0.33914281) - 0.64171123 * 0.33914281,
              kDigits);
  EXPECT_NEAR(at(M_PI).drag, 0, kDigits);
}

TEST(LiftingPanel, MomentAndSurfaceRaiseTheNose) {
  base::PanelParams params = plate_panel();
  params.moment_zero = 0.1;
  params.surface = 0;
  params.surface_lift_per_rad = 2;
  const LiftingPanel panel(params);
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();
  panel.add({10, 0, 0}, 1.2, 0.1, force, torque);
  const double qs = 0.5 * 1.2 * 100 * 0.5;
  EXPECT_NEAR(force.z(), qs * 0.2, kRounding * qs);
  EXPECT_NEAR(torque.y(), -qs * 0.25 * 0.1, kRounding * qs);  // nose up is about -y
}

/// A panel of 2 m^2 that lifts and neither drags nor turns.
base::PanelParams plain_panel(const Vector3d& place) {
  return {.position_B_m = place,
          .area_m2 = 2,
          .lift_slope_per_rad = 5,
          .stall_rad = 0.3,
          .after_stall_lift_slope_per_rad = -5};
}

/// Elliptic lifting line: far behind the wing the air comes down by 2 C_L / (pi AR).
TEST(Downwash, OfTheWingTakesAngleOfAttackFromTheTail) {
  base::AeroParams aero;
  aero.wing_span_m = 4;
  aero.panels = {plain_panel({-3, 0, 0}), plain_panel({0, 0, 0})};
  const double alpha = 0.1;
  const BodyState body = moving(velocity(20, alpha, 0));
  const double clean_n = wrench_of(AeroModel(aero), body, still_air()).torque_B.y() / 3;
  const double wing_n = 0.5 * 1.225 * 400 * 2 * 5 * alpha * std::cos(alpha);
  EXPECT_NEAR(clean_n, wing_n, 1e-9);
  for (const double share : {0.5, 1.0}) {
    aero.panels[0].downwash_share = share;
    const double tail_n = wrench_of(AeroModel(aero), body, still_air()).torque_B.y() / 3;
    const double angle = alpha - std::atan(share * 2 * 5 * alpha / (M_PI * 4 * 4 / 2));
    const double speed2 = 400 * (1 + std::pow(std::tan(alpha - angle), 2));
    EXPECT_NEAR(tail_n, 0.5 * 1.225 * speed2 * 2 * 5 * angle * std::cos(angle), 1e-9) << share;
  }
  aero.panels[0].downwash_share = 1;
  EXPECT_EQ(wrench_of(AeroModel(aero), moving({0, 0, 0}), still_air()).force_B, Vector3d::Zero());
}

/// Actuator disc: at rest the disc gives the air sqrt(T / (2 rho A)), twice that far behind it.
TEST(PropellerWash, IsThatOfMomentumTheory) {
  constexpr double kRadius = 0.2;
  const double area = M_PI * kRadius * kRadius;
  const double hover = std::sqrt(10 / (2 * 1.2 * area));
  EXPECT_NEAR(wash_m_s(10, 0, 1.2, kRadius, 0), hover, kRounding);
  EXPECT_NEAR(wash_m_s(10, 0, 1.2, kRadius, 1e6), 2 * hover, 1e-9);
  EXPECT_NEAR(wash_m_s(10, 0, 1.2, kRadius, -1e6), 0, 1e-9);
  const double in_flight = wash_m_s(10, 15, 1.2, kRadius, 0);
  EXPECT_NEAR(2 * 1.2 * area * (15 + in_flight) * in_flight, 10, 1e-9);
  EXPECT_EQ(wash_m_s(0, 15, 1.2, kRadius, 1), 0);
  EXPECT_EQ(wash_m_s(10, 0, 0, kRadius, 1), 0);
}

TEST(PropellerWash, LiftsThePanelBehindTheRotorAlone) {
  base::AeroParams aero;
  aero.panels = {plain_panel({-1, 0, 0}), plain_panel({0, 0, 0})};
  base::Rotor rotor;
  rotor.position_B_m = {0.5, 0, 0};
  rotor.axis_B = Vector3d::UnitX();
  rotor.params.thrust_coefficient = 1e-5;
  rotor.params.radius_m = 0.3;
  aero.panels[0].in_wash_of = 0;
  AeroModel model(aero, {&rotor, 1});
  const double w = 2;  // up through still air: the panels meet it across
  const BodyState body = moving({0, 0, -w});
  const Wrench still = wrench_of(model, body, still_air());
  model.set_rotor_speeds(base::RotorVector::Constant(1, 1000));
  const Wrench wrench = wrench_of(model, body, still_air());
  const double thrust = 10;
  const double u = wash_m_s(thrust, 0, 1.225, 0.3, 1.5);
  const double alpha = std::atan2(w, u);
  ASSERT_LT(alpha, 0.3);
  const double lift = 0.5 * 1.225 * (u * u + w * w) * 2 * 5 * alpha;
  EXPECT_NEAR(wrench.torque_B.y() - still.torque_B.y(), lift * std::cos(alpha), 1e-9);
  model.release();
}

std::string refusal_of_polar(const std::string& text) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("wing.csv", text);
  return test::refusal([&] { PanelPolar(file, 1.8); });
}

TEST(PanelPolar, IsTheTableBetweenItsLines) {
  const test::TemporaryFolder folder;
  const PanelPolar polar(folder.write("wing.csv",
                                      "reynolds,alpha_deg,CL,CD,Cm\n"
                                      "1e5,-10,-0.8,0.06,0.01\n1e5,0,0.2,0.02,-0.05\n"
                                      "1e5,10,1.1,0.05,-0.07\n"
                                      "3e5,-10,-1,0.04,0\n3e5,10,1.3,0.04,0\n"),
                         1.8);
  const double degree = M_PI / 180;
  EXPECT_NEAR(polar.at(5 * degree, 5e4).lift, 0.65, kRounding);
  EXPECT_NEAR(polar.at(5 * degree, 5e4).drag, 0.035, kRounding);
  EXPECT_NEAR(polar.at(5 * degree, 5e4).moment, -0.06, kRounding);
  EXPECT_NEAR(polar.at(5 * degree, 1e6).lift, 0.725, kRounding);
  EXPECT_NEAR(polar.at(5 * degree, 2e5).lift, (0.65 + 0.725) / 2, kRounding);
  // Beyond its angles a flat plate; without a jump at its ends and from behind.
  EXPECT_NEAR(polar.at(90 * degree, 1e5).lift, 0, kRounding);
  EXPECT_NEAR(polar.at(90 * degree, 1e5).drag, 1.82, kRounding);
  for (const double edge : {-180.0, -20.0, -10.0, 10.0, 20.0}) {
    const auto below = polar.at((edge < -179 ? 180 - 1e-9 : edge - 1e-9) * degree, 1e5);
    const auto above = polar.at((edge + 1e-9) * degree, 1e5);
    EXPECT_NEAR(below.lift, above.lift, 1e-8) << edge;
    EXPECT_NEAR(below.drag, above.drag, 1e-8) << edge;
    EXPECT_NEAR(below.moment, above.moment, 1e-8) << edge;
  }
}

TEST(PanelPolar, OfAPanelCountsFromItsChord) {
  const test::TemporaryFolder folder;
  base::AeroParams aero;
  aero.panels = {plain_panel({0, 0, 0})};
  aero.panels[0].chord_m = 0.25;
  aero.panels[0].zero_lift_rad = -0.1;
  aero.panels[0].plate_normal_force = 1.8;
  aero.panels[0].induced_drag_factor = 0.05;
  aero.panels[0].polar = folder.write("wing.csv",
                                      "reynolds,alpha_deg,CL,CD,Cm\n1e5,-10,-1,0.02,-0.04\n"
                                      "1e5,10,1,0.02,-0.04\n");
  const Wrench wrench = wrench_of(AeroModel(aero), moving({20, 0, 0}), still_air());
  const double q = 0.5 * 1.225 * 400;
  EXPECT_NEAR(wrench.force_B.z(), 0, 1e-9);
  EXPECT_NEAR(wrench.force_B.x(), -q * 2 * 0.02, 1e-9);
  EXPECT_NEAR(wrench.torque_B.y(), q * 2 * 0.25 * 0.04, 1e-9);  // nose down
}

TEST(PanelPolar, RefusesATableWithFileAndLine) {
  const std::string head = "reynolds,alpha_deg,CL,CD,Cm\n";
  for (const auto& [text, sentence] : std::vector<std::pair<std::string, const char*>>{
           {"alpha,CL,CD\n", "wing.csv:1: the first line must be reynolds,alpha_deg,CL,CD,Cm"},
           {head + "1e5,0,0.1,0.02,0\n1e5,0,0.2,0.02,0\n",
            "wing.csv:3: alpha_deg must rise from line to line of one Reynolds number"},
           {head + "1e5,0,0.1,0.02,0\n1e5,1,0.2,0.02,0\n5e4,0,0.1,0.02,0\n",
            "wing.csv:4: reynolds must not fall from line to line"},
           {head + "1e5,0,0.1,-0.02,0\n", "wing.csv:2: CD must not be below 0"},
           {head + "1e5,200,0.1,0.02,0\n", "wing.csv:2: alpha_deg must lie in [-180, 180]"},
           {head + "1e5,0,0.1,0.02,0\n", "wing.csv:2: a Reynolds number needs two angles"},
           {head + "1e5,0,0.1,0.02\n", "wing.csv:2: needs 5 numbers with commas between them"},
           {head, "wing.csv:1: needs two angles at least"}}) {
    EXPECT_NE(refusal_of_polar(text).find(sentence), std::string::npos) << refusal_of_polar(text);
  }
}

TEST(Panels, MeetTheAirOfTheirOwnPlace) {
  base::AeroParams aero;
  base::PanelParams panel = plate_panel();
  panel.position_B_m = {0, 1.5, 0};
  aero.panels = {panel};
  const AeroModel model(aero);
  // Rolling to the right lifts the left tip, so it meets the air from above.
  BodyState body = moving({20, 0, 0});
  body.w_WB_B = {0.5, 0, 0};
  const double angle = std::atan2(-0.5 * 1.5, 20);
  Vector3d force = Vector3d::Zero();
  Vector3d torque = Vector3d::Zero();
  LiftingPanel(panel).add(velocity(std::hypot(20, 0.75), angle, 0), 1.225, 0, force, torque);
  EXPECT_TRUE(wrench_of(model, body, still_air()).force_B.isApprox(force, kRounding));
  // The same by air that falls at that tip.
  Environment falling = still_air();
  falling.wind_gradient_W = Eigen::Matrix3d::Zero();
  (*falling.wind_gradient_W)(2, 1) = -0.5;
  EXPECT_TRUE(wrench_of(model, moving({20, 0, 0}), falling).force_B.isApprox(force, kRounding));
  // And by a gust.
  Environment gust = still_air();
  gust.wind_W = {0, 0, -0.75};
  EXPECT_TRUE(wrench_of(model, moving({20, 0, 0}), gust).force_B.isApprox(force, kRounding));
}

TEST(DerivativeBody, FeelsAGradientOfTheWindAsItsOwnTurn) {
  const AeroModel model(*test::load_plane("aerosonde").aero);
  const Vector3d w_B(0.3, 0.2, -0.1);
  BodyState turning = moving({20, 0, -1});
  turning.w_WB_B = w_B;
  Environment air = still_air();
  air.wind_gradient_W = Eigen::Matrix3d::Zero();
  (*air.wind_gradient_W)(2, 1) = -w_B.x();  // across the span
  (*air.wind_gradient_W)(2, 0) = w_B.y();   // along the body
  (*air.wind_gradient_W)(1, 0) = -w_B.z();
  const Wrench by_turn = wrench_of(model, turning, still_air());
  const Wrench by_air = wrench_of(model, moving({20, 0, -1}), air);
  EXPECT_TRUE(by_air.force_B.isApprox(by_turn.force_B, kRounding));
  EXPECT_TRUE(by_air.torque_B.isApprox(by_turn.torque_B, kRounding));
}

// From anywhere.

/// Neighbouring directions and speeds give neighbouring forces: what changes by more than the
/// steepest of the model is a jump.
TEST(AnyAir, GivesFiniteForcesWithoutJumps) {
  for (const char* text : {"aerosonde", "panel_plane"}) {
    SCOPED_TRACE(text);
    base::AeroParams aero = *test::load_plane(text).aero;
    if (aero.panels.size() > 1) aero.panels.push_back(plate_panel());
    const AeroModel model(aero);
    std::vector<double> deflections(aero.surfaces.size(), 0.3);
    BodyState body{.w_WB_B = {0.5, -1, 0.3}};
    const auto at = [&](double speed, double alpha, double beta) {
      body.v_WB = velocity(speed, alpha, beta);
      const Wrench wrench = wrench_of(model, body, still_air(), deflections);
      Eigen::Matrix<double, 6, 1> all;
      all << wrench.force_B, wrench.torque_B;
      EXPECT_TRUE(all.allFinite()) << speed << ' ' << alpha << ' ' << beta;
      return all;
    };
    constexpr double kNear = 1e-7;     // rad and m/s
    constexpr double kSteepest = 3e5;  // N over rad at 60 m/s
    for (const double speed : {0.0, 1e-9, 0.1, 5.0, 20.0, 60.0}) {
      for (int a = -180; a <= 180; a += 3) {
        for (int b = -180; b <= 180; b += 6) {
          const double alpha = a * M_PI / 180;
          const double beta = b * M_PI / 180;
          const auto here = at(speed, alpha, beta);
          for (const auto& there : {at(speed, alpha + kNear, beta), at(speed, alpha, beta + kNear),
                                    at(speed + kNear, alpha, beta)}) {
            ASSERT_LT((there - here).cwiseAbs().maxCoeff(), kNear * kSteepest)
                << speed << ' ' << a << ' ' << b;
          }
        }
      }
    }
  }
}

// Gliding.

/// Best of lift over drag along the book's formulas, the elevator balancing the moment.
TEST(Glide, IsAsFlatAsLiftOverDrag) {
  const base::Vehicle vehicle = test::load_plane("aerosonde");
  const auto model = std::make_shared<AeroModel>(*vehicle.aero);
  Airframe airframe = test::aerosonde();
  airframe.wrench = [model, air = airframe.air](const BodyState& body,
                                                std::span<const double> deflections, double) {
    Wrench wrench;
    std::vector<double> rates(deflections.size());
    model->evaluate(body, air, deflections, rates, wrench);
    return wrench;
  };
  double best = 0;
  double lift_then = 0;
  for (double alpha = 0; alpha < 0.3; alpha += 1e-4) {
    const double elevator = (0.0135 - 2.74 * alpha) / 0.99;
    const double linear = 0.23 + 5.61 * alpha;
    const double lift = linear + 0.13 * elevator;
    const double drag =
        0.043 + linear * linear / (M_PI * 0.9 * 2.8956 * 2.8956 / 0.55) + 0.0135 * elevator;
    if (lift / drag < best) continue;
    best = lift / drag;
    lift_then = std::hypot(lift, drag);
  }
  const auto wide = glide_polar(airframe, 25, std::vector<std::pair<double, double>>(3, {-2, 2}));
  ASSERT_TRUE(wide);
  constexpr double kGrid = 1e-4;  // of the look-up, and what sigma takes there
  EXPECT_NEAR(wide->best_glide_ratio / best, 1, kGrid);
  EXPECT_NEAR(wide->best_glide_m_s, std::sqrt(11 * 9.81 / (0.5 * 1.2682 * 0.55 * lift_then)), 0.05);
  EXPECT_GT(wide->stall_alpha_rad, 0.35);
  EXPECT_LT(wide->stall_alpha_rad, 0.47);
  // An elevator of 10 deg holds no more than this angle of attack: there the plane is as slow as it
  // can be.
  const auto narrow =
      glide_polar(airframe, 25, std::vector<std::pair<double, double>>(3, {-0.175, 0.175}));
  ASSERT_TRUE(narrow);
  EXPECT_NEAR(narrow->stall_alpha_rad, (0.175 * 0.99 + 0.0135) / 2.74, 5e-4);
}

/// The energy that a glide loses is the work of the air, to the integrator's accuracy.
TEST(Glide, LosesTheEnergyThatTheAirTakes) {
  const base::Vehicle vehicle = test::load_plane("aerosonde");
  AeroModel model(*vehicle.aero);
  ForceSet forces;
  forces.add(model);
  forces.reset_states();
  Eigen::Matrix3d inertia;
  inertia << 0.8244, 0, 0.1204, 0, 1.135, 0, 0.1204, 0, 1.759;
  const MassProperties mass(11, inertia);
  const Environment air = still_air();
  BodyState body = moving({25, 0, 0});
  const auto energy = [&] {
    return 11 * (0.5 * body.v_WB.squaredNorm() + test::kGravity * body.p_WB.z()) +
           0.5 * body.w_WB_B.dot(inertia * body.w_WB_B);
  };
  const auto power = [&] {
    Wrench wrench;
    std::array<double, ForceModel::kMaxStates> rates{};
    model.evaluate(body, air, forces.states_of(model), std::span(rates).first(3), wrench);
    return wrench.force_B.dot(body.q_WB.conjugate() * body.v_WB) + wrench.torque_B.dot(body.w_WB_B);
  };
  const double before = energy();
  constexpr double kStep_s = 1e-3;
  double work = 0;
  for (int i = 0; i < 5000; ++i) {  // Simpson's rule over pairs of steps
    work += power();
    integrate_free(body, forces, mass, air, {}, kStep_s);
    work += 4 * power();
    integrate_free(body, forces, mass, air, {}, kStep_s);
    work += power();
  }
  work *= kStep_s / 3;
  EXPECT_LT(work, -100);
  EXPECT_NEAR(energy() - before, work, 1e-6 * std::abs(before));
  EXPECT_NEAR((energy() - before) / work, 1, 1e-6);
}

// Servos and the plugin.

TEST(SurfaceServos, FollowWithLagAndRate) {
  std::vector<base::ControlSurface> surfaces(1);
  surfaces[0] = {.name = "elevator",
                 .output = 2,
                 .min_rad = 0.5,
                 .max_rad = -0.4,  // turned round
                 .rate_rad_s = 3,
                 .time_constant_s = 0.1};
  SurfaceServos servos(surfaces);
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.values = ActuatorValues::Zero(16);
  command.values[2] = 0.5;
  servos.take(command);
  double angle = 0;
  double rate = 0;
  servos.rates({&angle, 1}, {&rate, 1});
  EXPECT_NEAR(rate, -0.2 / 0.1, kRounding);  // though disarmed
  command.values[2] = -2;
  servos.take(command);
  servos.rates({&angle, 1}, {&rate, 1});
  EXPECT_NEAR(rate, 3, kRounding);
  angle = 0.7;
  servos.limit({&angle, 1});
  EXPECT_EQ(angle, 0.5);
  command.values[2] = std::nan("");
  servos.take(command);
  servos.rates({&angle, 1}, {&rate, 1});
  EXPECT_EQ(rate, -3);  // back to the middle
  servos.take({});      // control inputs: none of a plane's surfaces
  angle = 0.1;
  servos.rates({&angle, 1}, {&rate, 1});
  EXPECT_NEAR(rate, -1, kRounding);
}

/// The rate of a servo with this defect that is 0.1 rad off the middle and is asked to +0.2 rad.
double rate_of_broken_servo(const ServoHealth& defect) {
  SurfaceServos servos(std::vector<base::ControlSurface>{{.name = "elevator",
                                                          .output = 0,
                                                          .min_rad = -0.4,
                                                          .max_rad = 0.4,
                                                          .rate_rad_s = 2,
                                                          .time_constant_s = 0.1}});
  MotorCommand command;
  command.kind = MotorCommand::Kind::kMotorOutputs;
  command.values = ActuatorValues::Constant(1, 0.5);
  servos.take(command);
  SurfaceHealth health;
  health.servos[0] = defect;
  servos.set_health(health);
  const double angle = 0.1;
  double rate = 0;
  servos.rates({&angle, 1}, {&rate, 1});
  return rate;
}

TEST(SurfaceServos, FailAsTheyAreTold) {
  EXPECT_NEAR(rate_of_broken_servo({}), 1, kRounding);
  EXPECT_EQ(rate_of_broken_servo({.rate_share = 0}), 0);
  EXPECT_NEAR(rate_of_broken_servo({.rate_share = 0.25}), 0.5, kRounding);
  EXPECT_NEAR(rate_of_broken_servo({.reversed = true}), -2, kRounding);
  EXPECT_NEAR(rate_of_broken_servo({.held_rad = 0.0}), -1, kRounding);
  EXPECT_NEAR(rate_of_broken_servo({.held_rad = 0.15}), 0.5, kRounding);
}

TEST(AeroPlugin, HasTheDefectsOfPluginFault) {
  const base::Vehicle plane = test::load_plane("aerosonde");
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4",
                              [&](base::Vehicle& vehicle) { vehicle = plane; });
  auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("aero", "{}");
  Plugin& fault =
      harness.add("fault",
                  "{faults: [{name: jam, at_s: 0.002, for_s: 0.002, surface: {number: 2, stuck: "
                  "true}}, {at_s: 0.002, surface: {name: rudder, reversed: true}}]}");
  harness.bus.freeze();
  MotorCommand wanted;
  wanted.kind = MotorCommand::Kind::kMotorOutputs;
  wanted.values = ActuatorValues::Constant(16, 1);
  command.publish(wanted);
  const ForceModel& model = *harness.context.force_models[0];
  const auto rates = [&] {
    Eigen::Vector3d rate;
    Wrench wrench;
    model.evaluate(harness.world.body, harness.world.air, std::array<double, 3>{}, {rate.data(), 3},
                   wrench);
    return Vector3d(rate / (600 * M_PI / 180));  // of the fastest
  };
  harness.run(std::chrono::milliseconds(2));
  EXPECT_EQ(rates(), Vector3d(1, 1, 1));
  harness.run(std::chrono::milliseconds(2));
  EXPECT_EQ(rates(), Vector3d(1, 0, -1));
  harness.run(std::chrono::milliseconds(2));
  EXPECT_EQ(rates(), Vector3d(1, 1, -1));
  EXPECT_NE(fault.stats_json().find("jam"), std::string::npos);
  harness.reset();
  command.publish(wanted);
  EXPECT_EQ(rates(), Vector3d(1, 1, 1));
}

TEST(AeroPlugin, PublishesDeflectionsAndTakesCommands) {
  const base::Vehicle plane = test::load_plane("aerosonde");
  test::PluginHarness harness(std::chrono::milliseconds(1), ".", "iris_px4",
                              [&](base::Vehicle& vehicle) { vehicle = plane; });
  auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  harness.add("aero", "{}");
  std::vector<SurfaceDeflections> got;
  const Subscription tap = harness.bus.subscribe<SurfaceDeflections>(
      "iris0/surface_deflections", [&](const SurfaceDeflections& each) { got.push_back(each); });
  harness.bus.freeze();
  ASSERT_EQ(harness.context.force_models.size(), 1U);
  const ForceModel& model = *harness.context.force_models[0];
  ASSERT_EQ(model.state_count(), 3);
  MotorCommand wanted;
  wanted.kind = MotorCommand::Kind::kMotorOutputs;
  wanted.values = ActuatorValues::Zero(16);
  wanted.values[1] = 1;  // elevator: 30 deg
  command.publish(wanted);
  std::vector<double> x{0.1, 0.2, 0.3};
  std::vector<double> rates(3);
  Wrench wrench;
  model.evaluate(harness.world.body, harness.world.air, x, rates, wrench);
  EXPECT_NEAR(rates[1], 600 * M_PI / 180, kRounding);  // its fastest
  harness.world.model_states[&model] = x;
  harness.step();
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].angle_rad, Eigen::Vector3d(0.1, 0.2, 0.3));
  harness.reset();
  model.evaluate(harness.world.body, harness.world.air, x, rates, wrench);
  EXPECT_NEAR(rates[1], -0.2 / 0.02, kRounding);
}

TEST(AeroPlugin, NeedsAVehicleWithWings) {
  test::PluginHarness harness;
  const auto command = harness.bus.advertise<MotorCommand>("iris0/motor_command");
  EXPECT_THROW(harness.add("aero", "{}"), base::ConfigError);
}

}  // namespace
}  // namespace cas::sim
