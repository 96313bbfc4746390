// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/link_report.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>

namespace cas::web {
namespace {

using nlohmann::json;

json link(const char* name, int baud, int rx_bytes, int tx_bytes) {
  json entry{{"name", name},
             {"type", baud > 0 ? "serial" : "udp"},
             {"state", "up"},
             {"endpoint", "x"},
             {"rx", {{"lost", 3}, {"bytes", rx_bytes}}},
             {"tx",
              {{"bytes", tx_bytes},
               {"queued", 1},
               {"queue_high_water", 12},
               {"dropped", {{"age", 2}, {"closed", 0}}}}}};
  if (baud > 0) entry["baud"] = baud;
  return entry;
}

json message(const char* link, const char* direction, const char* name, double hz, int system = 1) {
  return {{"link", link}, {"direction", direction}, {"name", name}, {"hz", hz}, {"system", system}};
}

const json kMessages{
    message("sim", "rx", "HIL_SENSOR", 500.04), message("sim", "tx", "HIL_CONTROLS", 400),
    message("fcu", "tx", "HIL_SENSOR", 500), message("fcu", "rx", "HIL_CONTROLS", 400),
    message("gcs", "tx", "HEARTBEAT", 1)};
const json kLatency{{{"link", "fcu"},
                     {"routes",
                      {{{"from", "sim"}, {"count", 5}, {"p50", 28}},
                       {{"from", "gcs"}, {"count", 0}, {"p50", 0}}}}}};

TEST(LinkReport, HasAHopForEachWayOfTheLoop) {
  const json report =
      LinkReport().make(json{link("sim", 0, 0, 0), link("fcu", 921600, 0, 0), link("gcs", 0, 0, 0)},
                        kMessages, kLatency, {});
  const json& hops = report.at("hops");
  ASSERT_EQ(hops.size(), 4U);
  const char* const ways[][2] = {
      {"sim", "casd"}, {"casd", "sim"}, {"casd", "fcu"}, {"fcu", "casd"}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(hops[i]["from"], ways[i][0]);
    EXPECT_EQ(hops[i]["to"], ways[i][1]);
    EXPECT_EQ(hops[i]["measured"], "none");
  }
  EXPECT_EQ(hops[0]["msgs"], (json{{"HIL_SENSOR", 500.0}}));
  EXPECT_EQ(hops[0]["lost"], 3);
  EXPECT_EQ(report.at("forward_us"), json::array({{{"from", "sim"},
                                                   {"to", "fcu"},
                                                   {"from_link", "sim"},
                                                   {"to_link", "fcu"},
                                                   {"system", 1},
                                                   {"count", 5},
                                                   {"p50", 28}}}));
}

TEST(LinkReport, TellsWhatLiesAtALinkAndWhoseItIsWhateverItIsCalled) {
  const json messages{
      message("sim2", "rx", "HIL_SENSOR", 500, 2), message("sim2", "tx", "HIL_CONTROLS", 400, 2),
      message("px4", "tx", "HIL_SENSOR", 500, 2), message("px4", "rx", "HIL_CONTROLS", 400, 2)};
  const json latency{
      {{"link", "px4"},
       {"routes", {{{"from", "sim2"}, {"count", 5}}, {{"from", "gcs"}, {"count", 1}}}}}};
  const json report =
      LinkReport().make(json{link("sim2", 0, 0, 0), link("px4", 0, 0, 0)}, messages, latency, {});
  const json& hops = report.at("hops");
  ASSERT_EQ(hops.size(), 4U);
  const char* const ways[][3] = {{"sim", "casd", "sim2"},
                                 {"casd", "sim", "sim2"},
                                 {"casd", "fcu", "px4"},
                                 {"fcu", "casd", "px4"}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(hops[i]["from"], ways[i][0]);
    EXPECT_EQ(hops[i]["to"], ways[i][1]);
    EXPECT_EQ(hops[i]["link"], ways[i][2]);
    EXPECT_EQ(hops[i]["system"], 2);
  }
  const json& forward = report.at("forward_us");
  ASSERT_EQ(forward.size(), 2U);
  EXPECT_EQ(forward[0]["from"], "sim");
  EXPECT_EQ(forward[0]["from_link"], "sim2");
  EXPECT_EQ(forward[0]["to_link"], "px4");
  EXPECT_EQ(forward[0]["system"], 2);
  EXPECT_EQ(forward[1]["from"], "gcs");
}

TEST(LinkReport, TellsTheHilPacketsThatCasdDroppedByCause) {
  const auto dropped = [](const char* direction, const char* name, int count) {
    json row = message("fcu", direction, name, 0);
    row["count"] = count;
    return row;
  };
  json messages = kMessages;
  for (const json& row :
       {dropped("drop.age", "HIL_SENSOR", 500), dropped("drop.age", "HIL_GPS", 29),
        dropped("drop.age", "STATUSTEXT", 7),             // no HIL packet
        dropped("drop.duplicate", "HIL_CONTROLS", 9)}) {  // of what came from it
    messages.push_back(row);
  }
  const json hops = LinkReport()
                        .make(json::array({link("sim", 0, 0, 0), link("fcu", 0, 0, 0)}), messages,
                              json::array(), {})
                        .at("hops");
  EXPECT_EQ(hops[1]["dropped"], json::object());
  EXPECT_EQ(hops[2]["dropped"], (json{{"age", 529}}));
}

TEST(LinkReport, CountsASerialLineAsFullByItsBytes) {
  LinkReport report;
  const auto fcu = [](int bytes) { return json::array({link("fcu", 921600, 2 * bytes, bytes)}); };
  EXPECT_FALSE(report.make(fcu(0), kMessages, json::array(), {}).at("hops")[0].contains("full"));
  const base::RunTime later = base::RunTime{} + std::chrono::milliseconds(500);
  const json hops = report.make(fcu(11520), kMessages, json::array(), later).at("hops");
  EXPECT_EQ(hops[0]["full"], 0.25);  // 11520 bytes of 10 bits in half a second of 921600 bit/s
  EXPECT_EQ(hops[1]["full"], 0.5);
  // A restarted casd counts from zero again.
  EXPECT_FALSE(report.make(fcu(10), kMessages, json::array(), later + std::chrono::seconds(1))
                   .at("hops")[0]
                   .contains("full"));
}

}  // namespace
}  // namespace cas::web
