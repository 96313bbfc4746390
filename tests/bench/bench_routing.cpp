// SPDX-License-Identifier: BSD-3-Clause
// What casd's decision costs for one packet, by the number of links.
//
//   build/bench/bench/bench_routing
//   valgrind --tool=callgrind --toggle-collect='*on_packet*'
//       build/bench/bench/bench_routing --benchmark_filter=Broadcast/4 --benchmark_min_time=0.01
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "casd/routing/router.hpp"
#include "mavlink/common/attitude.hpp"
#include "mavlink/common/command_long.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink_gen/runtime/encode.hpp"
#include "mavlink_gen/runtime/public_table.hpp"

namespace {

using namespace cas;
using namespace mavlink::common;

/// Links that all talk to each other and to casd's own station, one vehicle on each.
class Net {
 public:
  explicit Net(int links) : router_(plan_of(links), mav::public_table()) {
    for (int i = 0; i < links; ++i) {
      mav::Encoder vehicle{{static_cast<std::uint8_t>(1 + i), 1}};
      router_.on_packet(slot(i), mav::view_packet(vehicle(Heartbeat{})), base::RunTime{});
    }
  }
  casd::Router& router() { return router_; }
  static casd::LinkId slot(int link) {
    return static_cast<casd::LinkId>(link < casd::kLocalLink ? link : link + 1);
  }

 private:
  static std::shared_ptr<const casd::RoutingPlan> plan_of(int links) {
    auto plan = std::make_shared<casd::RoutingPlan>();
    std::vector<casd::ForwardRule> rules;
    for (int from = 0; from < links; ++from) {
      plan->never_back[slot(from)] = casd::bit(slot(from));
      rules.emplace_back().from = slot(from);
      rules.back().to = casd::kLocalLink;
      for (int to = 0; to < links; ++to) {
        rules.emplace_back().from = slot(from);
        rules.back().to = slot(to);
      }
    }
    plan->rules = casd::ForwardRules(rules);
    return plan;
  }
  casd::Router router_;
};

/// Telemetry of a vehicle goes to every other link.
void Broadcast(benchmark::State& state) {
  Net net(static_cast<int>(state.range(0)));
  mav::Encoder vehicle{{1, 1}};
  const auto bytes = vehicle(Attitude{});
  const mav::PacketView packet = mav::view_packet(bytes);
  const casd::LinkId from = Net::slot(0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(net.router().on_packet(from, packet, base::RunTime{}));
  }
}
BENCHMARK(Broadcast)->Arg(4)->Arg(62)->Arg(250);

/// A command goes to the link of its vehicle.
void Addressed(benchmark::State& state) {
  Net net(static_cast<int>(state.range(0)));
  mav::Encoder station{{1, 190}};
  CommandLong command;
  command.target_system = 2;
  command.target_component = 1;
  const auto bytes = station(command);
  const mav::PacketView packet = mav::view_packet(bytes);
  const casd::LinkId from = Net::slot(0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(net.router().on_packet(from, packet, base::RunTime{}));
  }
}
BENCHMARK(Addressed)->Arg(4)->Arg(62)->Arg(250);

}  // namespace

BENCHMARK_MAIN();
