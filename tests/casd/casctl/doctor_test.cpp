// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/doctor/doctor.hpp"

#include <gmock/gmock.h>

namespace cas::casctl {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

json link(const std::string& name, const std::string& type) {
  return {{"name", name},
          {"type", type},
          {"state", "up"},
          {"endpoint", type == "serial" ? "/dev/pixhawk 921600" : "127.0.0.1:14561"},
          {"rx", {{"lost", 0}, {"crc_errors", 0}, {"kernel_drops", 0}}},
          {"tx", {{"bytes", 0}, {"dropped", {{"age", 0}, {"queue_full", 0}}}}}};
}

json message(const std::string& on, const std::string& direction, const std::string& name,
             double hz, int system = 1, int component = 1) {
  return {{"link", on},   {"direction", direction}, {"name", name},          {"hz", hz},
          {"age_s", 0.1}, {"system", system},       {"component", component}};
}

/// A set-up that flies.
DoctorFacts good_setup() {
  DoctorFacts facts;
  json fcu = link("fcu", "serial");
  fcu["baud"] = 921600;
  facts.before = {{"self", {{"system", 254}, {"component", 190}}},
                  {"links", json::array({link("sim", "udp"), fcu})},
                  {"vehicles", json::array({{{"system", 1},
                                             {"autopilot", "PX4"},
                                             {"hil", true},
                                             {"armed", false},
                                             {"state", "standby"},
                                             {"arming_checks", "pass"},
                                             {"link", "fcu"},
                                             {"heartbeat_age_s", 0.4}}})}};
  facts.after = facts.before;
  facts.after["links"][1]["tx"]["bytes"] = 100'000;  // of 184 320 in two seconds
  facts.messages = json::array(
      {message("fcu", "tx", "HIL_SENSOR", 500, 1, 200), message("fcu", "rx", "HIL_CONTROLS", 400),
       message("fcu", "rx", "HEARTBEAT", 1), message("gcs", "rx", "HEARTBEAT", 1, 255, 190)});
  facts.seconds = 2;
  facts.devices = {{.path = "/dev/pixhawk",
                    .exists = true,
                    .usable = true,
                    .group = "dialout",
                    .latency_timer = {}}};
  facts.after["recording"] = {{"active", true}, {"recorded", 900}, {"left_out", 0}};
  facts.governors = {"performance"};
  facts.wake_p99_us = 80;
  facts.wake_max_us = 150;
  return facts;
}

/// Findings that are worse than good, one a line.
std::string complaints(const DoctorFacts& facts) {
  std::string text;
  for (const Finding& finding : diagnose(facts)) {
    if (finding.health == Health::kGood) continue;
    EXPECT_FALSE(finding.remedy.empty()) << finding.what;
    text += finding.what + "\n";
  }
  return text;
}

/// A stock ArduPilot on a board, by External AHRS on its SERIAL2, that flies.
DoctorFacts external_ahrs_setup() {
  DoctorFacts facts = good_setup();
  for (json* status : {&facts.before, &facts.after}) {
    (*status)["vehicles"][0]["autopilot"] = "ArduPilot";
    (*status)["vehicles"][0]["hil"] = false;
    (*status)["allow_not_hil"] = true;
  }
  facts.messages = json::array(
      {message("fcu", "rx", "HEARTBEAT", 1), message("fcu", "rx", "SERVO_OUTPUT_RAW", 300)});
  facts.routes = {{{"from", "fcu"}, {"to", "sim"}, {"allow", {"HEARTBEAT", "SERVO_OUTPUT_RAW"}}}};
  facts.params[1] = {{"EAHRS_TYPE", 1},       {"EAHRS_RATE", 400},      {"EAHRS_SENSORS", 15},
                     {"SERIAL0_PROTOCOL", 2}, {"SERIAL2_PROTOCOL", 36}, {"SERIAL2_BAUD", 921},
                     {"GPS1_TYPE", 21},       {"AHRS_EKF_TYPE", 3},     {"INS_ENABLE_MASK", 1}};
  return facts;
}

TEST(Doctor, FindsNothingWrongWithArdupilotByExternalAhrsButItsLiveOutputs) {
  EXPECT_EQ(complaints(external_ahrs_setup()), "vehicle 1 has no HIL mode: ITS OUTPUTS ARE LIVE\n");
  DoctorFacts older = external_ahrs_setup();
  older.params[1].erase("GPS1_TYPE");
  older.params[1]["GPS_TYPE"] = 21;  // 4.5
  older.params[1]["EAHRS_RATE"] = 200;
  EXPECT_EQ(complaints(older), complaints(external_ahrs_setup()));
}

TEST(DoctorOfExternalAhrs, NamesAWrongParameter) {
  struct WrongParam {
    std::string name;
    double value;
    std::string sentence;
  };
  const WrongParam rows[] = {{"EAHRS_TYPE", 0, ": EAHRS_TYPE is 0, not 1"},
                             {"EAHRS_RATE", 0, ": EAHRS_RATE is 0, not 400"},
                             {"EAHRS_SENSORS", 7, ": EAHRS_SENSORS is 7, not 15"},
                             {"SERIAL2_PROTOCOL", 2, ": no SERIALn_PROTOCOL is 36"},
                             {"SERIAL2_BAUD", 115, ": SERIAL2_BAUD is 115, not 921"},
                             {"GPS1_TYPE", 1, ": GPS1_TYPE is 1, not 21"},
                             {"AHRS_EKF_TYPE", 11, ": AHRS_EKF_TYPE is 11, not 3"},
                             {"INS_ENABLE_MASK", 127, ": INS_ENABLE_MASK is 127, not 1"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    DoctorFacts facts = external_ahrs_setup();
    facts.params[1][row.name] = row.value;
    EXPECT_THAT(complaints(facts), HasSubstr("vehicle 1" + row.sentence));
  }
}

TEST(Doctor, TakesNoRouteToAGroundStationForOneToASimulator) {
  DoctorFacts facts = external_ahrs_setup();
  facts.messages.push_back(message("sim", "rx", "HEARTBEAT", 1, 255, 190));
  EXPECT_THAT(complaints(facts), Not(HasSubstr("External AHRS")));
  EXPECT_THAT(complaints(facts), Not(HasSubstr("ITS OUTPUTS ARE LIVE")));
}

TEST(Doctor, FindsArdupilotWithoutExternalAhrsOrOutputsOrConsent) {
  DoctorFacts facts = external_ahrs_setup();
  facts.params[1].erase("EAHRS_TYPE");
  EXPECT_THAT(complaints(facts), HasSubstr("its firmware is without External AHRS"));
  facts = external_ahrs_setup();
  facts.messages = json::array({message("fcu", "rx", "HEARTBEAT", 1)});
  EXPECT_THAT(complaints(facts), HasSubstr("sends SERVO_OUTPUT_RAW 0 times a second"));
  facts = external_ahrs_setup();
  facts.after["allow_not_hil"] = false;
  EXPECT_THAT(complaints(facts), HasSubstr("casd does not arm it"));
}

TEST(Doctor, DoesNotAskAVehicleForHilThatCasdOnlyRoutesFor) {
  DoctorFacts facts = good_setup();
  for (json* status : {&facts.before, &facts.after}) {
    (*status)["vehicles"][0]["hil"] = false;
    (*status)["vehicles"][0]["arming_checks"] = "unknown";
  }
  facts.messages = json::array({message("fcu", "rx", "HEARTBEAT", 1)});
  facts.routes = {
      {{"from", "gcs"}, {"to", "fcu"}}};  // all may pass: a bench whose simulator stands
  EXPECT_THAT(complaints(facts), HasSubstr("HIL"));
  facts.routes[0]["block"] = {"HIL_SENSOR", "HIL_GPS"};
  EXPECT_EQ(complaints(facts), "");
  EXPECT_TRUE(std::ranges::any_of(diagnose(facts), &Finding::unchecked)) << "not ready to fly";
  facts.after["vehicles"][0]["arming_checks"] = "fail";
  EXPECT_NE(complaints(facts), "");
  facts.after["vehicles"][0]["arming_checks"] = "unknown";
  facts.routes[0] = {{"from", "gcs"}, {"to", "fcu"}, {"allow", {"HEARTBEAT"}}};
  EXPECT_EQ(complaints(facts), "");
  facts.routes.push_back({{"from", "sim"}, {"to", "fcu"}, {"allow", {"HIL_SENSOR"}}});
  EXPECT_THAT(complaints(facts), HasSubstr("does not say that it is in HIL"));
}

TEST(Doctor, WantsNoLogOfADisarmedAutopilot) {
  DoctorFacts facts = good_setup();
  json log{{"vehicle", 1}, {"wanted", true}};
  facts.after["autopilot_logs"] = {{"folder", "/logs"}, {"vehicles", json::array({log})}};
  EXPECT_EQ(complaints(facts), "");
  facts.after["vehicles"][0]["armed"] = true;
  facts.before = facts.after;
  EXPECT_NE(complaints(facts), "");
  log["file"] = "/logs/v1.bin";
  facts.after["autopilot_logs"]["vehicles"][0] = log;
  EXPECT_EQ(complaints(facts), "");
}

TEST(Doctor, SaysThatNobodyListensAtAUdpDestination) {
  DoctorFacts facts = good_setup();
  for (json* status : {&facts.before, &facts.after}) {
    (*status)["links"][0]["remote"] = "127.0.0.1:14550";
  }
  EXPECT_EQ(complaints(facts), "");
  facts.after["links"][0]["tx"]["dropped"]["closed"] = 90;
  facts.after["links"][0]["tx"]["refused"] = 7;
  EXPECT_THAT(complaints(facts),
              HasSubstr("nobody listens at 127.0.0.1:14550 or it cannot be reached, 97 packets"));
}

TEST(Doctor, FindsNothingWrongWithAGoodSetUp) { EXPECT_EQ(complaints(good_setup()), ""); }

/// All findings, one a line.
std::string findings(const DoctorFacts& facts) {
  std::string text;
  for (const Finding& finding : diagnose(facts)) text += finding.what + "\n";
  return text;
}

TEST(Doctor, TellsFilteredPacketsBesideALinkThatLosesNone) {
  DoctorFacts facts = good_setup();
  EXPECT_THAT(findings(facts),
              HasSubstr("link fcu is up, nothing lost or damaged in 2.0 s, nothing received\n"));
  facts.after["links"][1]["rx"]["packets"] = 1000;
  facts.before["links"][1]["rx"]["verdicts"] = {{"no_rule", 5}, {"forwarded", 9}};
  facts.after["links"][1]["rx"]["verdicts"] = {
      {"no_rule", 45}, {"forwarded", 99}, {"casd_only", 7}};
  facts.after["links"][1]["rx"]["not_accepted"] = 2;
  EXPECT_THAT(findings(facts),
              HasSubstr("nothing lost or damaged in 2.0 s; 42 of its packets go nowhere, "
                        "as the topology has it (casctl drops); 7 of its packets reach "
                        "casd alone, as the topology has it (casctl routes)\n"));
}

TEST(Doctor, NamesWhatEachLinkMayDoToVehiclesNotInHil) {
  DoctorFacts facts = good_setup();
  facts.after["links"][0]["to_not_hil"] = "all";
  facts.after["links"][1]["to_not_hil"] = "stops_only";
  facts.after["links"][1]["state"] = "down";
  for (const char* const rule : {"all from sim\n", "stops only from fcu\n"}) {
    EXPECT_THAT(findings(facts), HasSubstr(std::string("to vehicles not in HIL: ") + rule));
  }
}

TEST(Doctor, WarnsOfPacketsThatWereHeldBackFromVehiclesNotInHil) {
  DoctorFacts facts = good_setup();
  EXPECT_EQ(complaints(facts), "");
  facts.after["links"][1]["rx"]["verdicts"] = {{"not_hil", 3}};
  facts.after["links"][1]["state"] = "down";  // the log is over
  EXPECT_THAT(complaints(facts), HasSubstr("3 packets were held back"));
}

TEST(Doctor, TellsDropsOfBefore) {
  DoctorFacts facts = good_setup();
  for (json* status : {&facts.before, &facts.after}) {
    (*status)["links"][1]["tx"]["dropped"] = {{"age", 1090}, {"stalled", 9}, {"superseded", 3}};
  }
  EXPECT_THAT(findings(facts),
              HasSubstr("link fcu is up, nothing lost or damaged in 2.0 s, nothing "
                        "received; it dropped 1099 packets before (casctl drops)\n"));
}

TEST(Doctor, BlamesTheRateOfAFullLineAlone) {
  const auto remedy = [](double bytes) {
    DoctorFacts facts = good_setup();
    facts.after["links"][1]["tx"]["bytes"] = bytes;
    facts.after["links"][1]["tx"]["dropped"]["age"] = 7;
    for (const Finding& finding : diagnose(facts)) {
      if (finding.what.starts_with("line fcu")) return finding.remedy;
    }
    return std::string();
  };
  EXPECT_TRUE(remedy(180'000).starts_with("raise the baud rate"));
  EXPECT_TRUE(remedy(70'000).starts_with("not the rate"));
}

TEST(Doctor, SaysNothingOfTheLoadOfALineThatIsDown) {
  DoctorFacts facts = good_setup();
  facts.after["links"][1]["state"] = "down";
  EXPECT_THAT(findings(facts), Not(HasSubstr("line fcu carries")));
}

/// PX4 in software beside its simulator, in a good flight.
DoctorFacts software_setup() {
  DoctorFacts facts = good_setup();
  json udp = link("px4", "udp");
  for (json* status : {&facts.before, &facts.after}) {
    (*status)["links"] = json::array({udp});
    (*status)["allow_not_hil"] = true;
    (*status)["vehicles"][0]["hil"] = false;
    (*status)["vehicles"][0]["link"] = "px4";
  }
  facts.devices.clear();
  facts.messages = json::array({message("px4", "rx", "HEARTBEAT", 1)});
  facts.sys_hitl[1] = 0;
  return facts;
}

TEST(Doctor, FindsNothingWrongWithFirmwareInSoftware) {
  EXPECT_EQ(complaints(software_setup()), "");
  EXPECT_THAT(findings(software_setup()), HasSubstr("PX4 in software (SITL)"));
}

TEST(Doctor, TakesNoVehicleForSoftwareThatMayBeABoard) {
  const std::string bad = "does not say that it is in HIL mode";
  DoctorFacts no_consent = software_setup();
  no_consent.after["allow_not_hil"] = false;
  EXPECT_THAT(complaints(no_consent), HasSubstr(bad));
  DoctorFacts restart = software_setup();
  restart.sys_hitl[1] = 1;
  EXPECT_THAT(complaints(restart), HasSubstr(bad));
  DoctorFacts board = software_setup();
  board.after["links"][0]["type"] = "serial";
  EXPECT_THAT(complaints(board), HasSubstr(bad));
  DoctorFacts unanswered = software_setup();
  unanswered.sys_hitl.clear();
  unanswered.unasked[1] = "no answer";
  EXPECT_THAT(complaints(unanswered), HasSubstr(bad));
  DoctorFacts another = software_setup();
  another.sys_hitl = {{2, 0}};
  EXPECT_THAT(complaints(another), HasSubstr(bad)) << "the answer of another vehicle";
  DoctorFacts grouped = software_setup();
  grouped.after["links"].push_back(link("line", "serial"));
  grouped.messages.push_back(message("line", "rx", "HEARTBEAT", 1));
  EXPECT_THAT(complaints(grouped), HasSubstr(bad)) << "it has a serial way, too";
}

TEST(Doctor, SaysNothingGoodOfWhatItDidNotLookAt) {
  EXPECT_THAT(findings(software_setup()), HasSubstr("do not pass casd: not checked"));
  DoctorFacts silent = software_setup();
  silent.after["vehicles"][0]["heartbeat_age_s"] = 20;
  EXPECT_THAT(findings(silent), Not(HasSubstr("sensors")));
}

TEST(Doctor, TakesNoSysStatusOfAnotherVehicleForThisOnes) {
  DoctorFacts facts = software_setup();
  facts.after["vehicles"][0]["arming_checks"] = "unknown";
  facts.messages.push_back(message("px4", "rx", "SYS_STATUS", 1, 2));
  EXPECT_EQ(complaints(facts), "vehicle 1 has not told whether its arming checks pass\n");
}

TEST(Doctor, GivesArduPilotNoAdviceForPx4) {
  DoctorFacts facts = software_setup();
  facts.after["vehicles"][0]["autopilot"] = "ArduPilot";
  facts.after["vehicles"][0]["arming_checks"] = "unknown";
  facts.messages.push_back(message("px4", "rx", "SYS_STATUS", 1));
  for (const Finding& finding : diagnose(facts)) {
    EXPECT_THAT(finding.remedy, Not(HasSubstr("PX4")));
  }
}

// PX4 v1.12.0 has no MAV_SYS_STATUS_PREARM_CHECK.
TEST(Doctor, DoesNotFailAFirmwareThatNeverTellsOfItsArmingChecks) {
  DoctorFacts facts = software_setup();
  facts.after["vehicles"][0]["arming_checks"] = "unknown";
  facts.messages.push_back(message("px4", "rx", "SYS_STATUS", 1));
  EXPECT_EQ(complaints(facts), "vehicle 1 does not tell whether its arming checks pass\n");
  for (const Finding& finding : diagnose(facts)) EXPECT_NE(finding.health, Health::kBad);
}

TEST(Doctor, NamesACauseBeforeItsEffects) {
  DoctorFacts facts = good_setup();
  facts.devices[0].exists = false;
  facts.after["links"][1]["state"] = "down";
  facts.messages = json::array();
  facts.after["vehicles"][0]["arming_checks"] = "fail";
  const std::string text = complaints(facts);
  std::size_t last = 0;
  for (const char* finding : {"does not exist", "link fcu is down", "gets no HIL_SENSOR",
                              "sends no actuator controls", "arming checks fail"}) {
    const std::size_t place = text.find(finding);
    ASSERT_NE(place, std::string::npos) << finding << " in " << text;
    EXPECT_GE(place, last) << finding << " in " << text;
    last = place;
  }
}

struct BadCase {
  const char* name;
  std::function<void(DoctorFacts&)> spoil;
  const char* complaint;
};

TEST(DoctorFinds, TheFault) {
  const BadCase rows[] = {
      {"LinkDown",
       [](DoctorFacts& f) {
         f.after["links"][1]["state"] = "down";
         f.after["links"][1]["endpoint"] = "No such file or directory";
       },
       "link fcu is down: No such file"},
      {"NoDevice", [](DoctorFacts& f) { f.devices[0].exists = false; }, "does not exist"},
      {"NoRight", [](DoctorFacts& f) { f.devices[0].usable = false; }, "may not be opened"},
      {"LatencyTimer", [](DoctorFacts& f) { f.devices[0].latency_timer = 16; },
       "holds packets back for up to 16 ms"},
      {"BaudTooSmall", [](DoctorFacts& f) { f.after["links"][1]["tx"]["bytes"] = 180'000; },
       "line fcu carries 90.0 of 92.2 kB/s"},
      {"OwnDrops", [](DoctorFacts& f) { f.after["links"][0]["tx"]["dropped"]["queue_full"] = 5; },
       "link sim: casd dropped 5 packets (queue_full)"},
      {"LateDrops", [](DoctorFacts& f) { f.after["links"][1]["tx"]["dropped"]["age"] = 7; },
       "would come too late"},
      {"NotInHil", [](DoctorFacts& f) { f.after["vehicles"][0]["hil"] = false; },
       "does not say that it is in HIL mode"},
      {"TwoAutopilots",
       [](DoctorFacts& f) {
         f.after["vehicles"][0]["rival"] = {{"component", 1}, {"link", "sitl"}};
       },
       "links fcu and sitl bring two autopilots"},
      {"InTermination",
       [](DoctorFacts& f) { f.after["vehicles"][0]["state"] = "flight_termination"; },
       "vehicle 1 is in state flight_termination"},
      {"ArmingChecksFail", [](DoctorFacts& f) { f.after["vehicles"][0]["arming_checks"] = "fail"; },
       "vehicle 1 says that its arming checks fail"},
      {"ArmingChecksUnknown",
       [](DoctorFacts& f) { f.after["vehicles"][0]["arming_checks"] = "unknown"; },
       "vehicle 1 has not told whether its arming checks pass"},
      {"NoPositionYet",
       [](DoctorFacts& f) {
         f.after["vehicles"][0]["position_lacks"] = "the estimator has no velocity yet; no GPS";
       },
       "vehicle 1 cannot take off yet: the estimator has no velocity yet; no GPS"},
      {"Complaint",
       [](DoctorFacts& f) {
         f.after["vehicles"][0]["complaints"] = json::array({"PreArm: Check ACC cal"});
       },
       "vehicle 1: PreArm: Check ACC cal"},
      {"NoVehicle", [](DoctorFacts& f) { f.after["vehicles"] = json::array(); },
       "no flight controller"},
      {"SilentVehicle", [](DoctorFacts& f) { f.after["vehicles"][0]["heartbeat_age_s"] = 12; },
       "vehicle 1 has been silent for 12 s"},
      {"FewSensors", [](DoctorFacts& f) { f.messages[0]["hz"] = 120; },
       "vehicle 1 gets only 120 HIL_SENSOR a second"},
      {"OldSensors", [](DoctorFacts& f) { f.messages[0]["age_s"] = 4; },
       "vehicle 1 gets no HIL_SENSOR"},
      {"NoSensors", [](DoctorFacts& f) { f.messages.erase(0); }, "gets no HIL_SENSOR"},
      {"NoControls", [](DoctorFacts& f) { f.messages.erase(1); }, "sends no actuator controls"},
      {"TwoStations",
       [](DoctorFacts& f) { f.messages.push_back(message("lan", "rx", "HEARTBEAT", 1, 250, 190)); },
       "several ground stations are connected: 250/190, 255/190"},
      {"TwoCasds",
       [](DoctorFacts& f) { f.messages.push_back(message("gcs", "rx", "HEARTBEAT", 1, 254, 190)); },
       "casd's own address"},
      {"Damaged", [](DoctorFacts& f) { f.after["links"][1]["rx"]["crc_errors"] = 3; },
       "packets arrive damaged"},
      {"LostBeforeCasd", [](DoctorFacts& f) { f.after["links"][1]["rx"]["lost"] = 3; },
       "packets are lost before they reach casd"},
      {"SmallBuffer", [](DoctorFacts& f) { f.after["links"][0]["rx"]["kernel_drops"] = 3; },
       "socket buffer overflows"},
      {"SignedInTheFuture",
       [](DoctorFacts& f) {
         f.after["links"][0]["signing"] = {{"time_file", "/etc/cas/radio.key.time"},
                                           {"time_ahead_s", 0.0},
                                           {"future",
                                            {{"system", 1},
                                             {"component", 200},
                                             {"link_id", 3},
                                             {"ahead_s", 315'576'000.0},
                                             {"refused", true}}}};
         f.after["links"][0]["rx"]["signatures"] = {{"too_new", 2}};
       },
       "link sim: 1/200 (signing link 3) signs 10.0 years ahead of casd's clock"},
      {"SigningTimeAhead",
       [](DoctorFacts& f) {
         f.after["links"][0]["signing"] = {{"time_file", "/etc/cas/radio.key.time"},
                                           {"time_ahead_s", 86'400.0},
                                           {"too_far_ahead", true},
                                           {"future",
                                            {{"system", 1},
                                             {"component", 200},
                                             {"link_id", 3},
                                             {"ahead_s", 86'400.0},
                                             {"refused", false}}}};
       },
       "signatures is 24.0 h ahead of the clock, moved there by 1/200 (signing link 3)"},
      {"ReloadRefused",
       [](DoctorFacts& f) {
         f.after["reload"] = {{"accepted", false},
                              {"age_s", 12.0},
                              {"reason", "casd.yaml:3: threads: takes a restart"}};
       },
       "last reload, 12.0 s ago, was refused; the topology before it is in force: "
       "casd.yaml:3: threads"},
      {"RecordingPauses",
       [](DoctorFacts& f) {
         f.after["recording"]["left_out"] = 120;
         f.after["recording"]["paused"] = "No space left on device";
       },
       "the recording pauses: No space left on device; 120 packets are missing"},
      {"CannotRecord",
       [](DoctorFacts& f) {
         f.after["recording"] = {
             {"active", false}, {"folder", "/logs"}, {"paused", "Permission denied"}};
       },
       "casd cannot record in /logs: Permission denied"},
      {"GapsOfTheLastRecording",
       [](DoctorFacts& f) {
         f.after["recording"] = {{"active", false}, {"left_out", 9}};
       },
       "9 packets are missing in the last recording"},
      {"RecordingWithGaps", [](DoctorFacts& f) { f.after["recording"]["left_out"] = 7; },
       "the recording has gaps: 7 packets"},
      {"LogsOfAutopilotsPause",
       [](DoctorFacts& f) {
         f.after["autopilot_logs"] = {{"folder", "/var/log/cas"},
                                      {"paused", "No space left on device"},
                                      {"vehicles", nlohmann::json::array()}};
       },
       "the logs of autopilots pause: No space left on device"},
      {"AnAutopilotRefusesItsLog",
       [](DoctorFacts& f) {
         f.after["autopilot_logs"] = {
             {"folder", "/var/log/cas"},
             {"vehicles",
              {{{"vehicle", 1},
                {"wanted", true},
                {"trouble", "does not send its log: it does not support this command"}}}}};
       },
       "vehicle 1 does not send its log: it does not support this command"},
      {"AnArmedAutopilotIsSilentAboutItsLog",
       [](DoctorFacts& f) {
         f.after["vehicles"][0]["armed"] = true;
         f.after["autopilot_logs"] = {{"folder", "/var/log/cas"},
                                      {"vehicles", {{{"vehicle", 1}, {"wanted", true}}}}};
         f.before = f.after;
       },
       "vehicle 1 is armed, was asked for its log and sends none"},
      {"Powersave", [](DoctorFacts& f) { f.governors = {"powersave"}; }, "powersave"},
      {"ClockStep", [](DoctorFacts& f) { f.clock_step_s = -0.2; }, "wall clock moved by -200.0 ms"},
      {"BusyMachine", [](DoctorFacts& f) { f.wake_p99_us = 4000; }, "99 %: 4000 us"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    DoctorFacts facts = good_setup();
    row.spoil(facts);
    EXPECT_THAT(complaints(facts), HasSubstr(row.complaint));
  }
}

TEST(Doctor, GivesAnAutopilotArmedBetweenTheLooksTimeToSendItsLog) {
  DoctorFacts facts = good_setup();
  facts.before["vehicles"][0]["armed"] = false;
  facts.after["vehicles"][0]["armed"] = true;
  facts.after["autopilot_logs"] = {{"folder", "/var/log/cas"},
                                   {"vehicles", {{{"vehicle", 1}, {"wanted", true}}}}};
  facts.before["autopilot_logs"] = facts.after["autopilot_logs"];
  for (const Finding& finding : diagnose(facts)) {
    EXPECT_THAT(finding.what, Not(HasSubstr("sends none")));
  }
}

TEST(Doctor, TellsAStrangersTerminalFromABoardThatIsUnplugged) {
  const auto remedy = [](const char* reason) {
    DoctorFacts facts = good_setup();
    facts.after["links"][1]["state"] = "down";
    facts.after["links"][1]["endpoint"] = reason;
    for (const Finding& finding : diagnose(facts)) {
      if (finding.what.find(reason) != std::string::npos) return finding.remedy;
    }
    return std::string();
  };
  EXPECT_THAT(remedy("/x/fcu0: pseudo-terminal /dev/pts/5 is offered by no running program"),
              HasSubstr("start the emulator"));
  const std::string unplugged = remedy("/dev/pixhawk: No such file or directory");
  EXPECT_THAT(unplugged, HasSubstr("plug the board in"));
  EXPECT_THAT(unplugged, HasSubstr("start the emulator"));
  EXPECT_THAT(remedy("/dev/ttyXYZ0: Operation not permitted"), HasSubstr("DeviceAllow"));
  EXPECT_THAT(remedy("nothing may be sent: Operation not permitted"), HasSubstr("IPAddressAllow"));
}

// An old refusal stays in its texts for some time after its checks have passed.
TEST(Doctor, BelievesArmingChecksMoreThanAnEarlierRefusal) {
  const auto health = [](const char* checks) {
    DoctorFacts facts = good_setup();
    facts.after["vehicles"][0]["complaints"] = json::array({"Arming denied: no position"});
    facts.after["vehicles"][0]["arming_checks"] = checks;
    for (const Finding& finding : diagnose(facts)) {
      if (finding.what.find("Arming denied") != std::string::npos) return finding.health;
    }
    return Health::kGood;
  };
  EXPECT_EQ(health("pass"), Health::kWarning);
  EXPECT_EQ(health("fail"), Health::kBad);
  EXPECT_EQ(health("unknown"), Health::kBad);
}

}  // namespace
}  // namespace cas::casctl
