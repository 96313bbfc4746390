// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "tests/casd/port/command_port_fixture.hpp"
#include "tests/support/paths.hpp"

namespace cas::casd {
namespace {

using mavlink::common::MavModeFlag;
using mavlink::common::MavParamType;
using mavlink::common::MavResult;
using nlohmann::json;
using test::CommandPortFixture;
using test::FakeVehicle;

struct Ended {
  int code = -1;
  std::string out;  ///< standard output and error
};

Ended shell(const std::string& command) {
  Ended run;
  std::FILE* pipe = ::popen(("{ " + command + "; } 2>&1").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    run.out.append(buffer.data(), n);
  }
  run.code = WEXITSTATUS(::pclose(pipe));
  return run;
}

/// Runs the real program.
Ended casctl(const std::string& arguments) {
  return shell("'" + cas::test::binary_dir() + "/bin/casctl' " + arguments);
}

class CasctlTest : public testing::Test {
 protected:
  CasctlTest() {
    directory_ =
        std::filesystem::temp_directory_path() / ("casctl_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  ~CasctlTest() override { std::filesystem::remove_all(directory_); }

  Ended run(const std::string& arguments) {
    if (!started_) fixture_.start();
    started_ = true;
    return casctl("--address " + fixture_.address() + " " + arguments);
  }

  CommandPortFixture fixture_;
  bool started_ = false;
  std::filesystem::path directory_;
};

TEST_F(CasctlTest, EndsWithZeroWhenTheVehicleAcknowledged) {
  const Ended armed = run("arm --no-wait");
  EXPECT_EQ(armed.code, 0);
  EXPECT_EQ(armed.out, "vehicle 1 armed\n");
}

TEST_F(CasctlTest, EndsWithOneWhenTheVehicleRefuses) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "Arming denied: throttle high";
  const Ended refused = run("arm --no-wait");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.out.find("denied: Arming denied: throttle high"), std::string::npos)
      << refused.out;
}

TEST_F(CasctlTest, PrintsTextsOfAVehicleWithoutWhatGivesATerminalOrders) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "Denied\x1b[2J\x07!";
  const Ended refused = run("arm --no-wait");
  EXPECT_NE(refused.out.find("Denied?[2J?!"), std::string::npos) << refused.out;
}

TEST_F(CasctlTest, OffersNoWordThatAShellWouldRun) {
  fixture_.vehicle().params = {
      {"MC_ROLL_P", {.value = 6.5}}, {"$(reboot)", {.value = 1}}, {"`id`", {.value = 1}}};
  EXPECT_EQ(run("words parameters").out, "MC_ROLL_P\n");
}

TEST_F(CasctlTest, SaysThatARestartWasAccepted) {
  EXPECT_EQ(run("reboot").out, "vehicle 1 accepted the restart\n");
}

TEST_F(CasctlTest, SaysNothingOfARestartThatWasRefused) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  const Ended refused = run("reboot");
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.out.find("accepted"), std::string::npos) << refused.out;
}

TEST_F(CasctlTest, EndsWithOneAtTheInterlock) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  const Ended refused = run("arm --not-hil");
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.out.find("waiting"), std::string::npos) << refused.out;
  EXPECT_NE(refused.out.find("allow_not_hil"), std::string::npos) << refused.out;
}

TEST_F(CasctlTest, EndsWithTwoOnWrongUsage) {
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run("fly").code, 2);
  EXPECT_EQ(run("takeoff high").code, 2);
  EXPECT_EQ(run("setgain roll").code, 2);
  EXPECT_EQ(run("setgain roll 1 2 3 --p 4").code, 2);
  EXPECT_EQ(run("setgain roll --p nan").code, 2);
  EXPECT_EQ(run("setgain roll 1 inf 0").code, 2);
  EXPECT_EQ(run("--vehicle 300 arm").code, 2);
}

TEST_F(CasctlTest, EndsWithThreeWithoutADaemon) {
  const Ended alone = casctl("--address 127.0.0.1:1 arm");
  EXPECT_EQ(alone.code, 3);
  EXPECT_NE(alone.out.find("Start it with"), std::string::npos) << alone.out;
}

TEST_F(CasctlTest, SaysThatItWaitsForTheDaemon) {
  const Ended alone = casctl("--address 127.0.0.1:1 arm --wait --timeout 0.3");
  EXPECT_EQ(alone.code, 3);
  EXPECT_NE(alone.out.find("waiting: casd does not answer at 127.0.0.1:1 yet"), std::string::npos)
      << alone.out;
}

TEST_F(CasctlTest, WaitsForTheFirstHeartbeat) {
  const Ended unheard = run("--vehicle 7 land --wait --timeout 0.3");
  EXPECT_EQ(unheard.code, 4);
  EXPECT_NE(unheard.out.find("casctl: waiting: "), std::string::npos) << unheard.out;
}

TEST_F(CasctlTest, EndsWithFourWhereAVerbWaitedInVainForItsVehicle) {
  const std::string nowhere = (directory_ / "none.params").string();
  std::ofstream(nowhere) << "MC_ROLL_P 1\n";
  for (const std::string verb :
       {"status", "arm", "disarm", "takeoff 2", "land", "hold", "rtl", "goto 1 2 -3", "mode HOLD",
        "manual --for 0.1", "message-interval ATTITUDE 10", "setgain roll 6", "gains", "gains roll",
        "param list", "param get A", "param set A 1", "reboot", "watch --count 1"}) {
    const Ended ended = run("--vehicle 7 --wait --timeout 0.2 " + verb);
    EXPECT_EQ(ended.code, 4) << verb << ": " << ended.out;
    EXPECT_EQ(run("--vehicle 7 " + verb).code, 1) << verb;  // without --wait it is a refusal
  }
  const Ended load = run("--vehicle 7 --wait --timeout 0.2 param load " + nowhere);
  EXPECT_EQ(load.code, 4) << load.out;
  const Ended save = run("--vehicle 7 --wait --timeout 0.2 param save " + nowhere);
  EXPECT_EQ(save.code, 4) << save.out;
}

TEST_F(CasctlTest, EndsWithFourWhereAStateDoesNotCome) {
  mavlink::common::LocalPositionNed local;
  local.z = -2.4F;
  mavlink::common::ExtendedSysState in_air;
  in_air.landed_state = mavlink::common::MavLandedState::kInAir;
  fixture_.vehicle().base_mode |= MavModeFlag::kSafetyArmed;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  fixture_.vehicle().say(in_air, base::steady_now());
  fixture_.vehicle().say(local, base::steady_now());
  for (const std::string verb : {"disarm", "takeoff 50", "land", "rtl", "goto 50 0 -3"}) {
    const Ended ended = run(verb + " --wait --timeout 0.3");
    EXPECT_EQ(ended.code, 4) << verb << ": " << ended.out;
    EXPECT_NE(ended.out.find("acknowledged, but the vehicle was not heard to be"),
              std::string::npos)
        << ended.out;
  }
}

TEST_F(CasctlTest, EndsATakeoffWhoseVehicleDisarms) {
  const base::RunTime now = base::steady_now();
  fixture_.vehicle().say_heartbeat(now);
  fixture_.vehicle().say(mavlink::common::HomePosition{}, now);
  for (int i = 0; i < 100; ++i) {  // armed for 3 s from the command on, then not
    mavlink::common::Heartbeat heartbeat;
    heartbeat.autopilot = mavlink::common::MavAutopilot::kPx4;
    heartbeat.type = mavlink::common::MavType::kQuadrotor;
    heartbeat.base_mode = MavModeFlag::kCustomModeEnabled | MavModeFlag::kHilEnabled;
    if (i < 15) heartbeat.base_mode |= MavModeFlag::kSafetyArmed;
    fixture_.vehicle().say(heartbeat, now + i * std::chrono::milliseconds(200));
  }
  const Ended ended = run("takeoff 2.5 --wait --timeout 19");
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_NE(ended.out.find("vehicle 1 disarmed before it was airborne"), std::string::npos)
      << ended.out;
}

TEST_F(CasctlTest, EndsATakeoffThatNobodyArms) {
  fixture_.vehicle().params["MIS_TAKEOFF_ALT"] = {2.5};
  const base::RunTime now = base::steady_now();
  fixture_.vehicle().say(mavlink::common::HomePosition{}, now);
  for (int i = 0; i < 100; ++i) {
    fixture_.vehicle().say_heartbeat(now + i * std::chrono::milliseconds(200));
  }
  const Ended ended = run("takeoff 2.5 --wait --timeout 19");
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_NE(ended.out.find("vehicle 1 is disarmed; arm it first: casctl arm --wait"),
            std::string::npos)
      << ended.out;
}

/// On the ground for the next 20 s.
void say_landed(FakeVehicle& vehicle) {
  mavlink::common::ExtendedSysState landed;
  landed.landed_state = mavlink::common::MavLandedState::kOnGround;
  const base::RunTime now = base::steady_now();
  for (int i = 0; i < 100; ++i) {
    vehicle.say(landed, now + i * std::chrono::milliseconds(200));
    vehicle.say_heartbeat(now + i * std::chrono::milliseconds(200));
  }
}

TEST_F(CasctlTest, WaitsForTheDisarmAfterALanding) {
  say_landed(fixture_.vehicle());
  EXPECT_EQ(run("land --wait").out, "vehicle 1 landed and disarmed\n");
}

TEST_F(CasctlTest, SaysOfALandedVehicleThatItIsStillArmed) {
  fixture_.vehicle().base_mode |= MavModeFlag::kSafetyArmed;
  say_landed(fixture_.vehicle());
  EXPECT_EQ(run("rtl --wait --timeout 3").out, "vehicle 1 landed, and is still armed\n");
}

TEST_F(CasctlTest, EndsWithFourWhereTheVehicleAcceptsAndDoesNotArm) {
  const Ended ended = run("arm --no-wait --wait --timeout 0.5");
  EXPECT_EQ(ended.code, 4) << ended.out;
  EXPECT_NE(ended.out.find("acknowledged, but the vehicle was not heard to be armed"),
            std::string::npos)
      << ended.out;
}

TEST_F(CasctlTest, EndsWithOneWhereAModeIsAcceptedAndNotTaken) {
  fixture_.vehicle().custom_mode = 4U << 16U | 3U << 24U;  // PX4's HOLD
  fixture_.vehicle().script.keeps_mode = true;
  fixture_.vehicle().script.then = MavResult::kTemporarilyRejected;
  const Ended ended = run("mode POSCTL");
  EXPECT_EQ(ended.code, 1) << ended.out;
  EXPECT_NE(ended.out.find("was accepted, then temporarily rejected: it is in HOLD"),
            std::string::npos)
      << ended.out;
}

TEST_F(CasctlTest, SaysOfAWordThatItIsNotANumber) {
  const Ended ended = casctl("takeoff two");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.out.find("ALT: 'two' is not a number"), std::string::npos) << ended.out;
}

TEST_F(CasctlTest, SaysWhatAMisspeltVerbOrOptionMayHaveMeant) {
  const Ended verb = casctl("stauts");
  EXPECT_EQ(verb.code, 2);
  EXPECT_EQ(verb.out,
            "there is no command 'stauts'; did you mean 'status'?\n"
            "Run with --help for more information.\n");
  const Ended below = casctl("param gte MC_ROLL_P");
  EXPECT_EQ(below.code, 2);
  EXPECT_NE(below.out.find("did you mean 'get'?"), std::string::npos) << below.out;
  const Ended option = casctl("land --tiemout=3");
  EXPECT_EQ(option.code, 2);
  EXPECT_NE(option.out.find("--tiemout"), std::string::npos) << option.out;
  EXPECT_NE(option.out.find("did you mean '--timeout'?"), std::string::npos) << option.out;
  const Ended own = casctl("watch --cvs");
  EXPECT_NE(own.out.find("did you mean '--csv'?"), std::string::npos) << own.out;
  const Ended far = casctl("frobnicate");
  EXPECT_EQ(far.out.find("did you mean"), std::string::npos) << far.out;
}

TEST_F(CasctlTest, AsksAgainToArmWhileTheVehicleSaysNotNow) {
  fixture_.vehicle().script.result = MavResult::kTemporarilyRejected;
  const Ended later = run("arm --no-wait --wait --timeout 0.3");
  EXPECT_EQ(later.code, 4);
  EXPECT_EQ(run("arm --no-wait").code, 1);  // without --wait it is a refusal
  EXPECT_NE(later.out.find("casctl: waiting: MAV_CMD 400"), std::string::npos) << later.out;
}

TEST_F(CasctlTest, ArmsOnceTheVehicleHasThePositionThatTakeoffNeeds) {
  using E = mavlink::common::EstimatorStatusFlags;
  mavlink::common::EstimatorStatus status;
  status.flags = E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kConstPosMode;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(status, base::steady_now());
  const Ended early = run("arm --timeout 0.3");
  EXPECT_EQ(early.code, 4) << early.out;
  EXPECT_NE(
      early.out.find("casctl: waiting: it cannot take off yet: the estimator has no horizontal "
                     "position yet\n"),
      std::string::npos)
      << early.out;
  EXPECT_NE(early.out.find("--no-wait arms all the same"), std::string::npos) << early.out;
  EXPECT_EQ(run("arm --no-wait").code, 0);
}

TEST_F(CasctlTest, ArmsAVehicleThatHasItsPosition) {
  using E = mavlink::common::EstimatorStatusFlags;
  mavlink::common::EstimatorStatus status;
  status.flags =
      E::kAttitude | E::kVelocityHoriz | E::kVelocityVert | E::kPosHorizAbs | E::kPosVertAbs;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(status, base::steady_now() + std::chrono::milliseconds(100));
  fixture_.vehicle().say(mavlink::common::HomePosition{},
                         base::steady_now() + std::chrono::milliseconds(200));
  const Ended armed = run("arm");
  EXPECT_EQ(armed.code, 0) << armed.out;
}

TEST_F(CasctlTest, WaitsForNoPositionWhereTheInterlockHolds) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  const Ended refused = run("arm");
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.out.find("waiting"), std::string::npos) << refused.out;
}

TEST_F(CasctlTest, DecidesOnTheResultAndNotOnWhatTheVehicleSays) {
  fixture_.vehicle().script.result = MavResult::kDenied;
  fixture_.vehicle().script.text = "temporarily rejected, as people say";
  const Ended denied = run("arm --no-wait --wait --timeout 3");
  EXPECT_EQ(denied.code, 1);
  EXPECT_EQ(denied.out.find("waiting"), std::string::npos) << denied.out;
}

TEST_F(CasctlTest, KnowsNoStatusOfAVehicleThatWasNotHeard) {
  const Ended status = run("--vehicle 7 status");
  EXPECT_EQ(status.code, 1);
  EXPECT_NE(status.out.find("7"), std::string::npos) << status.out;
}

TEST_F(CasctlTest, SaysThatADisarmedVehicleMustBeArmedToTakeOff) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  const Ended disarmed = run("takeoff 2.5");
  EXPECT_EQ(disarmed.code, 0);
  EXPECT_EQ(disarmed.out, "vehicle 1 takes off to 2.5 m when armed; it was last heard disarmed\n");
}

TEST_F(CasctlTest, EndsWithFourWhenTheVehicleIsSilent) {
  fixture_.vehicle().script.answers = 0;
  EXPECT_EQ(run("arm --no-wait").code, 4);
}

TEST_F(CasctlTest, EndsWithFourWhenTheStateIsNotReached) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  const Ended late = run("takeoff 2.5 --wait --timeout 0.3");
  EXPECT_EQ(late.code, 4);
  EXPECT_NE(late.out.find("not heard to be airborne within 0.3 s"), std::string::npos) << late.out;
}

TEST_F(CasctlTest, WaitsUntilTheStateIsReached) {
  mavlink::common::LocalPositionNed local;
  local.z = -2.4F;
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  for (int i = 0; i < 200; ++i) {
    fixture_.vehicle().say(local, base::steady_now() + i * std::chrono::milliseconds(100));
  }
  const Ended airborne = run("takeoff 2.5 --wait");
  EXPECT_EQ(airborne.code, 0);
  EXPECT_EQ(airborne.out, "vehicle 1 airborne\n");
}

TEST_F(CasctlTest, PrintsJson) {
  json landing = json::parse(run("--json land").out);
  EXPECT_GT(landing.at("at_s"), 0.0);
  landing.erase("at_s");
  EXPECT_EQ(landing, (json{{"vehicle", 1}, {"result", "ACCEPTED"}}));
  const json error = json::parse(run("mode WARP --json").out).at("error");
  EXPECT_EQ(error.at("code"), -32602);
}

TEST_F(CasctlTest, TakesTheAddressFromTheEnvironment) {
  fixture_.start();
  ASSERT_EQ(::setenv("CASD_ADDRESS", fixture_.address().c_str(), 1), 0);
  EXPECT_EQ(casctl("disarm --force").code, 0);
  ::unsetenv("CASD_ADDRESS");
  fixture_.stop();
  EXPECT_EQ(fixture_.vehicle().commands.at(0).param2, 21196.0F);
}

// The kernel would take a port modulo 65536: another casd's.
TEST_F(CasctlTest, TakesNoAddressThatIsNone) {
  for (const char* address : {"127.0.0.1:108031", "127.0.0.1:0", "127.0.0.1:5790x", "127.0.0.1",
                              ":5790", "127.0.0.1:-1"}) {
    const Ended ended = casctl("--address " + std::string(address) + " status");
    EXPECT_EQ(ended.code, 2) << address;
    EXPECT_NE(ended.out.find("'" + std::string(address) + "' "), std::string::npos) << ended.out;
  }
}

TEST_F(CasctlTest, SetsGainsByPositionAndByName) {
  fixture_.vehicle().params = {{"MC_ROLLRATE_P", {.value = 0.15}},
                               {"MC_ROLLRATE_I", {.value = 0.2}},
                               {"MC_ROLLRATE_D", {.value = 0.003}},
                               {"MC_ROLL_P", {.value = 6.5}}};
  EXPECT_EQ(run("setgain rollrate 0.16 0.21 0.004").out,
            "rollrate: P 0.15 -> 0.16, I 0.2 -> 0.21, D 0.003 -> 0.004\n");
  EXPECT_EQ(run("setgain rollrate --i 0.3").out, "rollrate: P 0.16, I 0.21 -> 0.3, D 0.004\n");
  EXPECT_EQ(run("setgain roll --p 7").out, "roll: P 6.5 -> 7\n");
  const Ended refused = run("setgain roll 6 0.1 0");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.out.find("loop roll has no I and no D gain"), std::string::npos);
  EXPECT_NE(run("gains rollrate").out.find("rollrate  0.16  0.3  0.004"), std::string::npos);
}

TEST_F(CasctlTest, SavesAndLoadsParameters) {
  fixture_.vehicle().params = {
      {"MC_ROLL_P", {.value = 6.5}},
      {"SYS_HITL", {.value = 1, .type = mavlink::common::MavParamType::kInt32}}};
  const std::string file = (directory_ / "iris.params").string();
  EXPECT_EQ(run("param save " + file).code, 0);
  EXPECT_EQ(run("param set MC_ROLL_P 8").out, "MC_ROLL_P = 6.5 -> 8\n");
  EXPECT_EQ(run("param load " + file).code, 0);
  EXPECT_EQ(run("param get MC_ROLL_P").out, "MC_ROLL_P = 6.5\n");
  EXPECT_NE(run("param list SYS_").out.find("SYS_HITL      1  INT32"), std::string::npos);
  std::ofstream(directory_ / "bad.params") << "MC_ROLL_P 1\nMC_PITCH_P high\n";
  const Ended bad = run("param load " + (directory_ / "bad.params").string());
  EXPECT_EQ(bad.code, 1);
  EXPECT_NE(bad.out.find("bad.params:2: expected NAME VALUE"), std::string::npos) << bad.out;
  EXPECT_EQ(run("param get MC_ROLL_P").out, "MC_ROLL_P = 6.5\n");  // nothing was written
}

TEST_F(CasctlTest, SetsNoParameterThatLetsAVehicleArmWithoutConsent) {
  fixture_.vehicle().base_mode = MavModeFlag::kCustomModeEnabled;
  fixture_.vehicle().params = {{"COM_ARM_WO_GPS", {.value = 0}}, {"MC_ROLL_P", {.value = 6.5}}};
  const Ended refused = run("param set COM_ARM_WO_GPS 1");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.out.find("--not-hil"), std::string::npos) << refused.out;
  const Ended half = run("param set COM_ARM_WO_GPS 1 --not-hil");
  EXPECT_EQ(half.code, 1);
  EXPECT_NE(half.out.find("allow_not_hil"), std::string::npos) << half.out;
  std::ofstream(directory_ / "arms.params") << "COM_ARM_WO_GPS 1\nMC_ROLL_P 7\n";
  const Ended loaded = run("param load " + (directory_ / "arms.params").string());
  EXPECT_EQ(loaded.code, 1);
  EXPECT_NE(loaded.out.find("refused: COM_ARM_WO_GPS"), std::string::npos) << loaded.out;
  EXPECT_EQ(run("param get COM_ARM_WO_GPS").out, "COM_ARM_WO_GPS = 0\n");
  EXPECT_EQ(run("param get MC_ROLL_P").out, "MC_ROLL_P = 7\n");
}

TEST_F(CasctlTest, SavesWhatCanBeLoadedAndNamesTheRest) {
  fixture_.vehicle().params = {{"A_NUMBER", {.value = 6.5}},
                               {"NOT_A_NUMBER", {.value = std::nan("")}},
                               {"NO_END", {.value = std::numeric_limits<double>::infinity()}}};
  const std::string file = (directory_ / "odd.params").string();
  const Ended saved = run("param save " + file);
  EXPECT_EQ(saved.code, 0);
  EXPECT_EQ(saved.out, "1 parameters saved to " + file +
                           "; NaN or infinite, so left out: NOT_A_NUMBER, NO_END\n");
  const Ended loaded = run("param load " + file);
  EXPECT_EQ(loaded.code, 0);
  EXPECT_EQ(loaded.out, "1 parameters of " + file + " are in force\n");
}

TEST_F(CasctlTest, SavesTheParametersThatCameBeforeTheVehicleFellSilent) {
  fixture_.vehicle().params = {
      {"A_FIRST", {.value = 1}}, {"B_SECOND", {.value = 2}}, {"C_LOST", {.value = 3}}};
  fixture_.vehicle().unsaid = "C_LOST";
  const std::string file = (directory_ / "some.params").string();
  const Ended saved = run("param save " + file);
  EXPECT_EQ(saved.code, 4) << saved.out;
  EXPECT_NE(saved.out.find("2 parameters saved to " + file), std::string::npos) << saved.out;
  EXPECT_NE(saved.out.find("2 of 3 parameters, then no more"), std::string::npos) << saved.out;
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(text.find("# Not all of them"), std::string::npos) << text;
  EXPECT_NE(text.find("\nB_SECOND 2\n"), std::string::npos) << text;
  const json told = json::parse(run("--json param list").out);
  EXPECT_EQ(told["parameters"].size(), 2U);
  EXPECT_TRUE(told.contains("missing"));
}

TEST_F(CasctlTest, LoadsWhatAnotherFirmwareTakesAndNamesTheRest) {
  fixture_.vehicle().params = {{"A_FIRST", {.value = 1}},
                               {"B_CLAMPED", {.value = 5, .high = 5}},
                               {"C_WHOLE", {.value = 1, .type = MavParamType::kInt32}},
                               {"E_LAST", {.value = 1}}};
  const std::string file = (directory_ / "other.params").string();
  std::ofstream(file) << "A_FIRST 2\nB_CLAMPED 9\nC_WHOLE 1.5\nD_MISSING 3\nE_LAST 4\n";
  const Ended strict = run("param load --strict " + file);
  EXPECT_EQ(strict.code, 1);
  EXPECT_NE(strict.out.find("0 of 5 parameters of " + file), std::string::npos) << strict.out;
  EXPECT_EQ(run("param get A_FIRST").out, "A_FIRST = 1\n") << "strict, so nothing was written";
  const Ended loaded = run("param load " + file);
  EXPECT_EQ(loaded.code, 1);
  EXPECT_EQ(loaded.out, "2 of 5 parameters of " + file +
                            " are in force: A_FIRST, E_LAST\n"
                            "the vehicle keeps B_CLAMPED = 5 (asked: 9)\n"
                            "refused: C_WHOLE: C_WHOLE is INT32 and cannot hold 1.5\n"
                            "not found: D_MISSING\n");
  const json told = json::parse(run("--json param load " + file).out);
  EXPECT_EQ(told["set"], 2);
  EXPECT_EQ(told["not_found"], json({"D_MISSING"}));
  EXPECT_EQ(told["kept"][0]["name"], "B_CLAMPED");
}

TEST_F(CasctlTest, LoadsOnlyTheAutopilotsRowsOfAGroundStationsFile) {
  fixture_.vehicle().params = {{"A_FIRST", {.value = 1}}};
  const std::string file = (directory_ / "station.params").string();
  std::ofstream(file) << "1\t1\tA_FIRST\t2\t9\r\n1\t154\tA_FIRST\t3\t9\r\n1\t1\tB_NAN\tnan\t9\r\n";
  const Ended loaded = run("param load " + file);
  EXPECT_EQ(loaded.code, 1);
  EXPECT_NE(loaded.out.find("refused: A_FIRST: it is of component 154"), std::string::npos)
      << loaded.out;
  EXPECT_NE(loaded.out.find("refused: B_NAN: NaN or infinite"), std::string::npos) << loaded.out;
  EXPECT_EQ(run("param get A_FIRST").out, "A_FIRST = 2\n");
}

TEST_F(CasctlTest, LeavesTheFileOfBeforeWhenSavingFails) {
  const std::string file = (directory_ / "iris.params").string();
  std::ofstream(file) << "MC_ROLL_P 6.5\n";
  fixture_.vehicle().params = {{"MC_ROLL_P", {.value = 8}}};
  // Writes beyond 0 bytes fail, as on a full disk.
  if (!started_) fixture_.start();
  started_ = true;
  const Ended full = shell("trap '' XFSZ; ulimit -f 0; '" + cas::test::binary_dir() +
                           "/bin/casctl' --address " + fixture_.address() + " param save " + file);
  EXPECT_EQ(full.code, 1) << full.out;
  EXPECT_NE(full.out.find("cannot be written"), std::string::npos) << full.out;
  std::ifstream in(file);
  std::string line;
  EXPECT_TRUE(std::getline(in, line));
  EXPECT_EQ(line, "MC_ROLL_P 6.5");
}

TEST_F(CasctlTest, GoesToPlacesWithNegativeNumbers) {
  fixture_.vehicle().say_heartbeat(base::steady_now());
  fixture_.vehicle().say(mavlink::common::HomePosition{}, base::steady_now());
  EXPECT_EQ(run("goto 5 -2 -3 90").code, 0);
  fixture_.stop();
  EXPECT_EQ(fixture_.vehicle().int_commands.size(), 1U);
}

TEST_F(CasctlTest, GivesTheTokenOfAFile) {
  const std::string file = (directory_ / "token").string();
  std::ofstream(file) << "open-sesame-open-sesame\n";
  std::filesystem::permissions(
      file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  fixture_.require_token(file);
  EXPECT_EQ(run("land").code, 1);
  EXPECT_EQ(run("--token-file " + file + " land").code, 0);
}

TEST_F(CasctlTest, EveryVerbHasAnExample) {
  const std::string help = casctl("--help").out;
  for (const char* verb : {"status",  "links",  "arm",     "disarm", "takeoff", "land",
                           "hold",    "rtl",    "goto",    "mode",   "manual",  "message-interval",
                           "setgain", "gains",  "routes",  "drops",  "latency", "budget",
                           "reload",  "reboot", "monitor", "doctor", "watch",   "message"}) {
    EXPECT_NE(help.find(verb), std::string::npos) << verb;
    EXPECT_NE(casctl(std::string(verb) + " --help").out.find("Example: casctl"), std::string::npos)
        << verb;
  }
}

}  // namespace
}  // namespace cas::casd
