// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/ardupilot_json/json_state.hpp"

#include <cmath>
#include <cstdio>
#include <span>

#include "base/earth/frames.hpp"

namespace cas::sim {
namespace {

/// What is not a number would be read as garbage; nothing of a sane simulation is.
double finite(double value) { return std::isfinite(value) ? value : 0.0; }

void append(std::string& text, double value) {
  char number[48];
  std::snprintf(number, sizeof number, "%.9f", finite(value));
  text += number;
}

void append(std::string& text, const char* key, std::span<const double> values) {
  text += key;
  char before = '[';
  for (const double value : values) {
    text += before;
    append(text, value);
    before = ',';
  }
  text += ']';
}

void append(std::string& text, const char* key, const Eigen::Vector3d& values) {
  append(text, key, std::span(values.data(), 3));
}

}  // namespace

JsonState to_json_state(base::SimTime time, const BodyState& body, const Environment& air) {
  const Eigen::Matrix3d R_BW = body.q_WB.conjugate().toRotationMatrix();
  JsonState state;
  state.timestamp_s = base::to_seconds(time);
  state.gyro_D = base::swap_BD(body.w_WB_B);
  state.accel_D = base::swap_BD(R_BW * (body.a_WB - air.gravity_W));
  state.p_N = base::swap_WN(body.p_WB);
  state.v_N = base::swap_WN(body.v_WB);
  state.q_ND = base::q_ND_from_q_WB(body.q_WB);
  return state;
}

std::string to_text(const JsonState& state) {
  const Eigen::Quaterniond& q = state.q_ND;
  const double quaternion[] = {q.w(), q.x(), q.y(), q.z()};
  std::string text = "\n{\"timestamp\":";
  append(text, state.timestamp_s);
  append(text, ",\"imu\":{\"gyro\":", state.gyro_D);
  append(text, ",\"accel_body\":", state.accel_D);
  append(text, "},\"position\":", state.p_N);
  append(text, ",\"velocity\":", state.v_N);
  append(text, ",\"quaternion\":", quaternion);
  if (state.range_m) {
    text += ",\"rng_1\":";
    append(text, *state.range_m);
  }
  return text + "}\n";
}

}  // namespace cas::sim
