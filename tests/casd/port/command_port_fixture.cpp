// SPDX-License-Identifier: BSD-3-Clause
#include "tests/casd/port/command_port_fixture.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <future>
#include <thread>

#include "base/rpc/server.hpp"
#include "casd/port/vehicle_methods.hpp"
#include "casd/station/gain_map.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/support/paths.hpp"

namespace cas::casd::test {

struct CommandPortFixture::Impl {
  Impl() : server(io) {}

  void build() {
    commander.emplace(options, [this](std::span<const std::uint8_t> bytes, std::span<const Path>) {
      parser.feed(bytes, [this](const mav::PacketView& packet) {
        for (const auto& vehicle : vehicles) vehicle->handle(packet, base::steady_now());
      });
    });
    vehicle_methods.emplace(
        server, *commander, GainMap::load(cas::test::source_dir() + "/config/gains.yaml"),
        VehicleHooks{.now = base::steady_now,
                     .link_name = [](LinkId) { return "fcu"; },
                     .audit = [this](const std::string& line) { audit.push_back(line); }});
    server.add_method("casd.status", [this](const auto&, const auto& reply) {
      reply.result({{"allow_not_hil", options.allow_not_hil}});
    });
  }

  /// Carries packets both ways every millisecond, heartbeats every second.
  void pump() {
    const base::RunTime now = base::steady_now();
    for (const auto& vehicle : vehicles) {
      if (now >= next_beat) vehicle->say_heartbeat(now);
      while (const auto packet = vehicle->take(now)) {
        from_vehicle.feed(packet->view(),
                          [&](const mav::PacketView& view) { commander->on_packet(3, view, now); });
      }
    }
    if (now >= next_beat) next_beat = now + std::chrono::seconds(1);
    commander->tick(now);
    if (commander->vehicles().size() == vehicles.size() && !heard_all) {
      heard_all = true;
      heard.set_value();
    }
    timer.expires_after(std::chrono::milliseconds(1));
    timer.async_wait([this](boost::system::error_code error) {
      if (!error) pump();
    });
  }

  boost::asio::io_context io;
  boost::asio::steady_timer timer{io};
  base::rpc::Server server;
  std::vector<std::unique_ptr<FakeVehicle>> vehicles;
  CommanderOptions options{.ask_on_sight = false};
  std::optional<VehicleCommander> commander;
  std::optional<VehicleMethods> vehicle_methods;
  mav::PacketParser parser{mavlink::common::table()};
  mav::PacketParser from_vehicle{mavlink::common::table()};
  base::RunTime next_beat{};
  bool heard_all = false;
  std::promise<void> heard;
  std::vector<std::string> audit;
  std::string address;
  std::thread thread;
};

CommandPortFixture::CommandPortFixture() : impl_(std::make_unique<Impl>()) {
  // Quick retries keep the tests short.
  impl_->options.command_timing = {.ack_timeout = std::chrono::milliseconds(100),
                                   .text_grace = std::chrono::milliseconds(50)};
  impl_->options.param_timing = {.answer_timeout = std::chrono::milliseconds(100)};
  add_vehicle();
}

CommandPortFixture::~CommandPortFixture() { stop(); }

FakeVehicle& CommandPortFixture::vehicle(std::size_t index) { return *impl_->vehicles.at(index); }

FakeVehicle& CommandPortFixture::add_vehicle() {
  const auto system = static_cast<std::uint8_t>(impl_->vehicles.size() + 1);
  impl_->vehicles.push_back(std::make_unique<FakeVehicle>(mav::Source{system, 1}));
  return *impl_->vehicles.back();
}

void CommandPortFixture::allow_not_hil() { impl_->options.allow_not_hil = true; }

void CommandPortFixture::require_token(const std::string& file) {
  impl_->server.require_token(file);
}

void CommandPortFixture::start() {
  impl_->build();
  impl_->address = "127.0.0.1:" + std::to_string(impl_->server.listen_tcp("127.0.0.1", 0));
  impl_->thread = std::thread([this] {
    impl_->pump();
    impl_->io.run();
  });
  impl_->heard.get_future().wait();
}

void CommandPortFixture::stop() {
  impl_->io.stop();
  if (impl_->thread.joinable()) impl_->thread.join();
  impl_->server.close();
}

const std::string& CommandPortFixture::address() const { return impl_->address; }

const std::vector<std::string>& CommandPortFixture::audit() const { return impl_->audit; }

}  // namespace cas::casd::test
