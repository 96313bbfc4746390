// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/emulator/emulator_control.hpp"

#include <boost/asio/io_context.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/config/config.hpp"
#include "base/earth/frames.hpp"
#include "base/enum_words.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/call_params.hpp"
#include "base/rpc/server.hpp"

namespace cas::fcu {

using base::rpc::Json;
using base::rpc::Reply;

namespace {

double microseconds(base::Duration d) { return 1e6 * base::to_seconds(d); }

Json quantiles(const base::Histogram& h) {
  return {{"p50", microseconds(h.quantile(0.5))},
          {"p99", microseconds(h.quantile(0.99))},
          {"max", microseconds(h.max())}};
}

Json direction(const LineModel::Stats& s) {
  return {{"written", s.written}, {"duplicated", s.duplicated},
          {"refused", s.refused}, {"delivered", s.delivered},
          {"lost", s.lost},       {"overrun", s.overrun},
          {"misread", s.misread}, {"flipped_bits", s.flipped}};
}

Json stats_json(EmulatorView& view) {
  const FlightControllerStats s = view.controller().stats();
  EmulatorLine& line = view.serial_line();
  return {{"schema", 1},
          {"program", "fcu_emulator"},
          {"received", s.received},
          {"sent", s.sent},
          {"crc_errors", s.crc_errors},
          {"sequence_gaps", s.sequence_gaps},
          {"stale_sensors", s.stale_sensors},
          {"missed_controls", s.missed_controls},
          {"update_us", quantiles(view.update_time())},
          {"sensor_age_us", quantiles(s.sensor_age)},
          {"dropped_packets", line.dropped_packets()},
          {"line",
           {{"preset", line.config().preset},
            {"up", direction(line.up_stats())},
            {"down", direction(line.down_stats())}}}};
}

Json vector_json(const Eigen::Vector3d& v) {
  Json out = Json::array();
  for (int i = 0; i < 3; ++i) out.push_back(std::isfinite(v[i]) ? Json(v[i]) : Json());
  return out;
}

std::string_view landed_word(LandedState landed) {
  constexpr base::EnumWords<LandedState::kLanding> kWords{"on_ground", "taking_off", "in_air",
                                                          "landing"};
  return kWords[landed];
}

Json status_json(EmulatorView& view) {
  const FlightStatus& s = view.controller().status();
  return {{"endpoints", view.endpoints()},
          {"armed", s.armed},
          {"mode", name(s.mode)},
          {"landed", landed_word(s.landed)},
          {"on_wing", s.on_wing},
          {"vtol", s.vtol},
          {"estimator_ready", s.estimator_ready},
          {"sensor_time_s", 1e-6 * static_cast<double>(s.sensor_time_usec)},
          {"p_N_m", vector_json(s.p_N)},
          {"v_N_m_s", vector_json(s.v_N)},
          {"rpy_rad", vector_json(base::euler_rpy(s.q_ND))},
          {"position_stddev_m", vector_json(s.position_stddev_m)},
          {"reference_N_m", vector_json(s.reference_N)},
          {"yaw_reference_rad", s.yaw_reference_rad}};
}

/// line.set takes the keys of the configuration's `line:` block.
void set_line(EmulatorView& view, const Json& params, const Reply& reply) {
  try {
    const LineConfig line = LineConfig::parse(
        base::ConfigNode::parse(params.is_null() ? "{}" : params.dump(), "params"));
    view.serial_line().configure(line);
    reply.result({{"preset", line.preset}, {"baud", line.baud}});
  } catch (const base::ConfigError& error) {
    throw base::rpc::BadParams(error.what());
  }
}

void hang_up(EmulatorView& view, const Json& params, const Reply& reply) {
  constexpr std::int64_t kLongest_ms = 3'600'000;
  base::rpc::CallParams reader(params);
  const double ms = reader.number("ms", 0, kLongest_ms);
  reader.finish();
  view.hang_up(base::from_seconds(1e-3 * ms));
  reply.result({{"ms", ms}});
}

}  // namespace

struct EmulatorControl::Impl {
  explicit Impl(boost::asio::io_context& io) : server(io) {}
  base::rpc::Server server;
};

EmulatorControl::EmulatorControl(boost::asio::io_context& io, EmulatorView& view,
                                 const std::filesystem::path& socket)
    : impl_(std::make_unique<Impl>(io)) {
  auto& server = impl_->server;
  server.add_method("fcu.status",
                    [&view](const Json&, Reply reply) { reply.result(status_json(view)); });
  server.add_method("fcu.stats",
                    [&view](const Json&, Reply reply) { reply.result(stats_json(view)); });
  server.add_method("line.set",
                    [&view](const Json& params, Reply reply) { set_line(view, params, reply); });
  server.add_method("line.hangup",
                    [&view](const Json& params, Reply reply) { hang_up(view, params, reply); });
  server.listen_unix(socket);
}

void EmulatorControl::begin() { impl_->server.start(); }

EmulatorControl::~EmulatorControl() { impl_->server.close(); }

void write_stats(const std::filesystem::path& file, EmulatorView& view) {
  base::write_file(file, stats_json(view).dump(2) + '\n', base::Durability::kCache);
}

}  // namespace cas::fcu
